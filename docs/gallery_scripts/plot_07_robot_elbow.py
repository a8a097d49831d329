"""
A robot's elbow
===============

What does the cam save a robot's joint that carries a payload? The closed loop has motor, current control,
position control and load. Page :doc:`/examples` explains the result; the whole script is
``system_examples/robot_joint.py``.
"""

# %%
# The cam is designed for 1.5 kg: gravity then lies inside its stick band at each angle.

import matplotlib.pyplot as plt

import dualcam
from system_examples import robot_joint

results = robot_joint.run(dualcam.fmu_path("forward"))
print("\n".join(robot_joint.design_table()))

# %%
# Grey: the joint holds. With the cam the motor then needs no torque.

figure, (statics, torque) = plt.subplots(1, 2, figsize=(10.0, 4.4), layout="constrained")
robot_joint.draw_statics(statics)
robot_joint.draw_torque(torque, results)

# %%
# Heat per cycle in the motor and in the cam, for three payloads:

figure, heat = plt.subplots(figsize=(8.0, 4.4), layout="constrained")
robot_joint.draw_heat(heat, results)
plt.show()
