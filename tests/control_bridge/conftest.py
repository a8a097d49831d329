"""Fixtures of the tests of the bridge to python-control."""

import pytest
from control_cases import FORWARD, PERIOD

import dualcam
from dualcam import Fmu


@pytest.fixture(scope="module")
def slave():
    with Fmu(FORWARD) as fmu:
        yield fmu


@pytest.fixture(scope="module")
def continuous():
    return dualcam.to_nonlinear_io_system(FORWARD)


@pytest.fixture(scope="module")
def sampled():
    return dualcam.to_nonlinear_io_system(FORWARD, period=PERIOD)
