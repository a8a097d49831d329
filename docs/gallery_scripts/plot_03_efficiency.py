"""
The best lead angles
====================

The efficiency is the torque given back over the torque to load. Which lead angles of the two grooves have
the highest efficiency, and what does friction change?
"""

# %%
# With equal friction at both grooves, 45 deg is the best lead angle for each radius and each load. Grey:
# the spring cannot drive the cam back.

import matplotlib.pyplot as plt
import numpy as np

from dualcam.design import efficiency_map, optimum

figure, panels = plt.subplots(1, 2, figsize=(10.0, 4.6), layout="constrained")
for axes, friction in zip(panels, [(0.14, 0.14), (0.19, 0.06)], strict=True):
    filled = efficiency_map(friction).draw(axes)
    figure.colorbar(filled, label="efficiency")
    plt.setp(axes.texts, color="k")
    axes.set(title=f"friction {friction[0]} and {friction[1]}")

# %%
# The optimum in closed form, over the friction coefficient:

friction = np.linspace(0.01, 0.4, 100)
best = [optimum((mu, mu)).efficiency for mu in friction]
figure, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
axes.plot(friction, best)
axes.plot(0.14, optimum((0.14, 0.14)).efficiency, "o", label="default friction of the FMU")
axes.set(xlabel="friction coefficient of both grooves", ylabel="highest efficiency", ylim=(0.0, 1.0))
axes.legend()
plt.show()
