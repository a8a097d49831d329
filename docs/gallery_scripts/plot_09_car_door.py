"""
A car door that stays where it is let go
========================================

The cam's stick band contains the door's weight on each slope, so the door stays with its motor off. Page
:doc:`/examples` explains the result; the whole script is ``system_examples/car_door.py``.
"""

# %%
# The band and the weight, over the angle of the door:

import matplotlib.pyplot as plt

import dualcam
from system_examples import car_door

figure, band = plt.subplots(figsize=(8.0, 4.8), layout="constrained")
car_door.draw_band(band)
print("\n".join(car_door.design_table()))

# %%
# The motor opens the door, holds it and closes it, nose up. With the cam the hold is free, and moving costs
# more.

results = car_door.run(dualcam.fmu_path("forward"))
figure, (torque, energy) = plt.subplots(1, 2, figsize=(10.0, 4.4), layout="constrained")
car_door.draw_torque(torque, results)
car_door.draw_energy(energy, results)
plt.show()
