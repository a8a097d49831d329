"""
A groove for a wanted torque
============================

The wanted torque is that of an arm which its spring lifts. ``synthesize`` finds the groove.
"""

# %%
# The arm weighs 1.5 kg at 0.5 m and leans 10 deg at the start. Groove 2 is a helix, groove 1 is sought. The
# torque of releasing, friction included, must be the weight.

import matplotlib.pyplot as plt
import numpy as np

from dualcam.design import Helix, Limits, Pin, Spring, assess, synthesize


def weight(theta):
    """Torque [N.m] that holds the arm at the angle theta [rad]."""
    return 1.5 * 9.81 * 0.5 * np.sin(np.radians(10.0) + theta)


spring = Spring(preload=170.0, stiffness=45e3)  # N, N/m
helix = Helix(radius=0.02, lead_angle=np.radians(45.0))
design = synthesize(weight, np.radians(80.0), spring, direction="releasing", groove2=helix)
print(design.summary())

# %%
# Torque and groove. The cam takes more torque to load than it gives back.

theta = np.linspace(0.0, np.radians(80.0), 200)
release, load = design.mechanism.band(theta)
figure, (torque, groove) = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
torque.fill_between(np.degrees(theta), release, load, alpha=0.2, label="stick band")
torque.plot(np.degrees(theta), weight(theta), "k--", label="wanted: slow releasing")
torque.set(xlabel="angle of cam 2 [deg]", ylabel="torque [N.m]", ylim=(0.0, None))
torque.legend()
groove.plot(20.0 * design.table.psi, 1e3 * design.table.z)
groove.set(xlabel="along the circumference [mm]", ylabel="height z [mm]", title="groove 1", aspect="equal")

# %%
# Can the groove be made, and does it carry its load? A pin of 3 mm radius and 8 mm width:

found = assess(design.mechanism, Pin(radius=0.003, width=0.008), Limits())
print(f"largest pressure {found.pressure.max() / 1e6:.0f} MPa; what fails: {found.findings or 'nothing'}")
plt.show()
