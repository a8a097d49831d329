"""
A study: which friction spoils the efficiency?
==============================================

512 runs of the FMU with random lead angles and friction coefficients.
"""

# %%
# The plan says what varies. The scenario pushes with 8 N.m for 0.2 s and then lets go. The results of all
# runs are one table.

from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

from dualcam.study import History, Plan, Scenario, Study, Vary

study = Study(
    "forward",
    Plan("sobol", {"cam1.lead_angle": Vary(0.5, 1.1), "cam1.friction": Vary(0.05, 0.25)}, runs=512),
    Scenario(0.4, {"tau": History([0.0, 0.2, 0.2, 0.4], [8.0, 8.0, 0.0, 0.0])}),
    ["efficiency", "energy.heat_cam1"],
)
with TemporaryDirectory() as folder:
    table = study.run(folder, workers=0)

# %%
# Each point is one run. The friction decides; the lead angle matters little near 45 deg.

figure, axes = plt.subplots(figsize=(8.0, 5.0), layout="constrained")
points = axes.scatter(
    np.degrees(table["cam1.lead_angle"]), table["efficiency"], c=table["cam1.friction"], s=14, cmap="viridis"
)
axes.set(xlabel="lead angle of groove 1 [deg]", ylabel="efficiency", ylim=(0.0, 1.0))
figure.colorbar(points, label="friction coefficient of groove 1")
plt.show()
