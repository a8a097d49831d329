"""
A prosthetic knee
=================

What does the cam save a knee in swing? The motion is measured; the motor follows through an impedance. Page
:doc:`/examples` explains the result; the whole script is ``system_examples/prosthetic_knee.py``.
"""

# %%
# The cam is fitted to the first subject's self-selected swing.

import matplotlib.pyplot as plt

import dualcam
from system_examples import prosthetic_knee

results = prosthetic_knee.run(dualcam.fmu_path("forward"))
print("\n".join(prosthetic_knee.design_table()))

# %%
# Angle and torque of one swing. With the motor off, the cam alone brings the shank through.

swings = {joint: results[prosthetic_knee.DESIGN_WALKER.name, 1.0, joint] for joint in prosthetic_knee.JOINTS}
figure, (angle, torque) = plt.subplots(1, 2, figsize=(10.0, 4.4), layout="constrained")
prosthetic_knee.draw_angle(angle, swings)
prosthetic_knee.draw_torque(torque, swings)

# %%
# Motor heat per swing, both subjects, three cadences:

figure, heat = plt.subplots(figsize=(8.0, 4.4), layout="constrained")
prosthetic_knee.draw_heat(heat, results)
plt.show()
