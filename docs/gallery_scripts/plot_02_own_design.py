"""
An own design: check, simulate, export
======================================

A design file describes the mechanism. This script takes the template of a robot's elbow, changes one value,
and makes an FMU.
"""

# %%
# ``write_template`` writes a commented design file, as ``dualcam new`` does. The spring becomes stiffer.

from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

import dualcam
from dualcam.design_file import write_template

folder = TemporaryDirectory()
file = write_template("robot", Path(folder.name) / "my.toml")
text = file.read_text(encoding="utf-8")
file.write_text(text.replace("stiffness = 41343.0", 'stiffness = "45 N/mm"'), encoding="utf-8")

verdict = dualcam.check_design(file)
print("works" if verdict.good else verdict.errors, "-", len(verdict.warnings), "warnings")

# %%
# The scenario of the file: the torque rises to 14 N.m, stays, and falls.

run = dualcam.simulate(file)
figure, (torque, angle) = plt.subplots(2, 1, figsize=(8.0, 6.0), sharex=True, layout="constrained")
torque.fill_between(run["time"], run["torque_release"], run["torque_load"], alpha=0.2, label="stick band")
torque.plot(run["time"], run["tau"], "k", label="torque on the shaft")
torque.set(ylabel="torque [N.m]")
torque.legend()
angle.plot(run["time"], np.degrees(run["theta"]))
angle.set(xlabel="time [s]", ylabel="angle of cam 2 [deg]")

# %%
# The FMU for other tools. Its name is that of the file, its start values are those of the design.

fmu = dualcam.export_fmu(file, Path(folder.name) / "MyCam.fmu")
description = dualcam.fmi.read_model_description(fmu)
starts = {variable.name: variable.start for variable in description.variables}
print(description.model_name, starts["spring.stiffness"], "N/m")
folder.cleanup()
plt.show()
