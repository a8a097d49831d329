"""Variables, mechanisms and input sequences that several FMI 2.0 tests share."""

from ctypes import byref, c_double

import pytest
from driver import FORWARD, LAST_SUCCESSFUL_TIME, models

INVERSE = models["DualCamInverse"]
TYPES = ["Real", "Integer", "Boolean", "String"]


def for_each(condition=lambda variable: True, **wanted):
    """Parametrizes `name` over the variables of each FMU with these attributes."""
    pairs = [(m, n) for m in models.values() for n in m.names(**wanted) if condition(m.variables[n])]
    return pytest.mark.parametrize(("model", "name"), pairs, indirect=["model"], ids=lambda value: str(value))


for_forward = pytest.mark.parametrize("model", [FORWARD], indirect=True)
for_inverse = pytest.mark.parametrize("model", [INVERSE], indirect=True)
SETTABLE = ["parameter", "input"]
DRIVE = {FORWARD: "tau", INVERSE: "theta"}  # the main input


def drive(fmu, value):
    """The main input of the FMU, as argument of step() and set()."""
    return {DRIVE[fmu.model]: value}


# A torsion spring without friction, far from its stops: motion in closed form.
LIFT = 0.01  # m/rad: two cams of 0.02 m at 45 degrees share the turning
INERTIA = 0.5
FREE = {
    "cam1.friction": 0.0,
    "cam2.friction": 0.0,
    "inertia.shaft": INERTIA,
    "stop.lower": -1e3,
    "stop.upper": 1e3,
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
}
SWING = FREE | {"spring.stiffness": 50000.0, "spring.preload": 20.0, "initial.theta": 0.3}

# Through loading, upper stop, release and lower stop with the default parameters.
TORQUES = [0.0, 3.0, 12.0, 12.0, 40.0, 40.0, 2.0, 0.0, -5.0, 6.0, 6.0, 1.0]
ANGLES = [0.0, 0.2, 0.7, 0.7, 1.3963, 1.2, 0.4, 0.0, 0.3, 0.31, 0.2, 0.2]
INPUT_SEQUENCE = {
    FORWARD: [{"tau": tau} for tau in TORQUES],
    INVERSE: [{"theta": a, "omega": 3 * (k % 3 - 1.0), "alpha": 7.0 * k} for k, a in enumerate(ANGLES)],
}


def run(driver, count=None, h=0.013):
    """Every variable, exactly, after every step of the input sequence."""
    record = []
    for inputs in INPUT_SEQUENCE[driver.model][:count]:
        driver.step(h, **inputs)
        record.append(driver.everything())
    return record


def last_time(fmu):
    time = c_double()
    fmu.ok("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, byref(time))
    return time.value
