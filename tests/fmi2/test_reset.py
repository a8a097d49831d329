"""FMI 2.0: tolerance, and fmi2Reset."""

import math

import pytest
from driver import PHASES
from fmi2_inputs import drive, run

# ---- tolerance ----


def bytes_with(make, tolerance):
    fmu = make()
    fmu.setup(tolerance=tolerance)
    return fmu.state_bytes()


def test_tolerance(make):
    """1e-9 unless given; below 1e-12 and above 1e-2 the nearest of them counts."""
    assert bytes_with(make, None) == bytes_with(make, 1e-9) == make().state_bytes()
    assert bytes_with(make, 1e-12) == bytes_with(make, 1e-20) != bytes_with(make, 1.1e-12)
    assert bytes_with(make, 1e-2) == bytes_with(make, 0.5) == bytes_with(make, 1e300)
    assert bytes_with(make, 1e-2) != bytes_with(make, 9e-3)


def test_reset_restores_the_tolerance(fmu, make):
    fmu.setup(tolerance=1e-4)
    fmu.ok("fmi2Reset")
    assert fmu.state_bytes() == make().state_bytes()


# ---- reset ----


@pytest.mark.parametrize("phase", PHASES)
def test_reset(make, phase):
    fmu, new = make(), make()
    fmu.set({"spring.preload": 10.0, "F_ext": 7.0, "contacts": 1, "ledger": False, "cam1.table": "x"})
    fmu.set_rates(F_ext=1.0)
    fmu.setup(3.0, tolerance=1e-4)
    fmu.enter(phase)
    fmu.ok("fmi2Reset")
    assert fmu.everything() == new.everything()
    assert fmu.state_bytes() == new.state_bytes()
    fmu.time = 0.0
    assert run(fmu.start()) == run(new.start())


def test_reset_revives_after_errors(fmu):
    fmu.start().step(0.1, **drive(fmu, 1.2))
    fmu.refused("fmi2DoStep", math.nan, math.nan, 1)
    fmu.ok("fmi2Terminate")
    fmu.refused("fmi2DoStep", 0.1, 0.1, 1)
    fmu.ok("fmi2Reset")
    fmu.time = 0.0
    fmu.start().step(0.1, **drive(fmu, 1.2))
