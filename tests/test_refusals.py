"""Every refusal is a DualcamError that says what works."""

import copy
import pickle

import numpy as np
import pytest

import dualcam
from dualcam.design import Table
from dualcam.design_file import write_template
from dualcam.errors import DualcamError, FileError, FmuError
from dualcam.gradient import DifferentiableFleet


@pytest.fixture(scope="module")
def design(tmp_path_factory):
    return write_template("minimal", tmp_path_factory.mktemp("design") / "my.toml")


WRITERS = {
    "report.html": dualcam.write_report,
    "view.html": dualcam.write_view,
    "run.csv": lambda design, path: dualcam.simulate(design).write(path),
    "groove.csv": lambda design, path: Table(0.02, np.linspace(0, 1, 9), np.linspace(0, 0.01, 9)).write(path),
    "new.toml": lambda design, path: write_template("minimal", path),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_folder_that_is_missing(design, tmp_path, name):
    path = tmp_path / "missing" / name
    with pytest.raises(FileError, match=r"cannot be written: .*Make its folder first") as caught:
        WRITERS[name](design, path)
    assert isinstance(caught.value, DualcamError) and isinstance(caught.value, OSError)
    assert str(path) in str(caught.value) and caught.value.filename == str(path)


@pytest.mark.parametrize("name", ["theta", "omega", "tau", "F_ext", "period"])
def test_a_text_is_no_operating_point(name):
    with pytest.raises(FmuError, match=f"{name} = '0.4': allowed is a finite number"):
        dualcam.linearize("forward", **{"theta": 0.5, "omega": 1.0} | {name: "0.4"})


def test_handles_say_what_to_do_instead_of_pickling():
    with (
        dualcam.Fmu("forward") as fmu,
        dualcam.ContinuousFmu("forward") as continuous,
        dualcam.Fleet("forward", 2) as fleet,
        DifferentiableFleet("forward", 1, 1e-3) as differentiable,
    ):
        fmu.start()
        for handle, instead in (
            (fmu, "open a new one there from its `path`, and call start with its `parameters`"),
            (continuous, "open a new one there from its `path`"),
            (fmu.reals("tau"), "make a group of its `names` with the FMU there"),
            (fmu.save_state(), "restore it into its own FMU"),
            (dualcam.fmi.RepeatedStart(fmu, {}, ["tau"]), "open a new one there"),
            (fleet, "make a new one there, from the same arguments"),
            (fleet.save(), "restore it into its own fleet"),
            (differentiable, "make a new one there"),
        ):
            for attempt in (pickle.dumps, copy.deepcopy):
                with pytest.raises(FmuError, match=f"cannot be pickled or copied: .*{instead}"):
                    attempt(handle)
        fmu.start()  # as before
