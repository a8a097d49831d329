"""
Push, hold and let go
=====================

A torque pushes the cam, falls, and rises again. While the torque is inside the stick band, the cam stands
still.
"""

# %%
# The torque of the motor is a line through points: it rises to 8 N.m, falls to 1 N.m, and so on. A step of
# 1 ms brings the FMU from one torque to the next. The FMU finds each start of stick and slip between two
# steps by itself.

import matplotlib.pyplot as plt
import numpy as np

from dualcam import Fmu

time = np.arange(0.0, 4.0, 1e-3)  # s
torque = np.interp(time, [0.0, 1.0, 2.0, 2.6, 3.3, 4.0], [0.0, 5.0, 2.5, 4.5, 2.0, 0.0])  # N.m

names = ("theta", "torque_release", "torque_load", "mode")
rows = []
with Fmu("forward") as fmu:
    fmu.start({"inertia.shaft": 0.002, "shaft.damping": 0.05})
    for value in torque:
        fmu.set("tau", float(value))
        fmu.step(1e-3)
        rows.append([fmu.get(name) for name in names])
theta, release, load, mode = np.array(rows).T

# %%
# Grey: the cam stands still (mode 1), also at its lower stop (mode 4). The angle moves only while the
# torque is on an edge of the band.

figure, (upper, lower) = plt.subplots(2, 1, figsize=(8.0, 6.0), sharex=True, layout="constrained")
upper.fill_between(time, release, load, color="tab:blue", alpha=0.2, label="stick band")
upper.plot(time, torque, "k", label="torque on the shaft")
upper.set(ylabel="torque [N.m]")
upper.legend()
lower.plot(time, np.degrees(theta))
lower.fill_between(time, 0.0, 80.0, where=np.isin(mode, (1, 4)), color="0.9", label="stands still")
lower.set(xlabel="time [s]", ylabel="angle of cam 2 [deg]", ylim=(0.0, 80.0))
lower.legend()

# %%
# The same run with the torque over the angle: a loop inside the band. Its area is friction heat.

figure, axes = plt.subplots(figsize=(8.0, 5.0), layout="constrained")
order = np.argsort(theta)
axes.fill_between(np.degrees(theta[order]), release[order], load[order], color="tab:blue", alpha=0.2)
axes.plot(np.degrees(theta), torque, "k")
axes.set(
    xlabel="angle of cam 2 [deg]", ylabel="torque [N.m]", title="Torque over the angle, and the stick band"
)
plt.show()
