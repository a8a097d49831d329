"""Friction at the contacts (fmu_src/contact/contact.c) where the FMU itself refuses the geometry."""

import math
from ctypes import POINTER, Structure, byref, c_bool, c_double, c_int

import pytest

Pair = c_double * 2


class Geometry(Structure):
    _fields_ = [
        *((n, Pair) for n in ("radius", "friction", "friction_by_log_load", "slope", "dpsi_dtheta")),
        ("dz_dtheta", c_double),
    ]


class Transfer(Structure):
    _fields_ = [
        ("regular", c_bool),
        ("delta", c_double),
        ("rho", c_double),
        ("rho_rate", c_double),
        ("rho_kappa1", c_double),
        ("axial", Pair),
        ("moment", Pair),
    ]


class BandFactors(Structure):
    _fields_ = [(name, c_double) for name in ("load", "release", "load_rate", "release_rate")]


@pytest.fixture(scope="module")
def contact(core):
    c = core(["contact/contact"], [Geometry, Transfer, BandFactors])
    c.contact_transfer.restype = Transfer
    c.contact_transfer.argtypes = [POINTER(Geometry), c_int, c_int * 2]
    c.contact_band.restype = BandFactors
    c.contact_band.argtypes = [POINTER(Geometry)]
    return c


def helices(r1, r2, lambda1, lambda2, mu1, mu2):
    slopes = r1 * math.tan(lambda1), r2 * math.tan(lambda2)
    turns = slopes[1] / sum(slopes), slopes[0] / sum(slopes)
    return Geometry(Pair(r1, r2), Pair(mu1, mu2), Pair(), Pair(*slopes), Pair(*turns), slopes[0] * turns[0])


def test_jam(contact):
    """Steep grooves, case 9 of the 60-digit statics: no torque loads it; releasing is ordinary."""
    geometry = helices(0.02, 0.03, 1.5, 1.5, 0.14, 0.14)
    band = contact.contact_band(byref(geometry))
    assert band.load == math.inf
    assert 100.0 * band.release == pytest.approx(5.6330141678046557, rel=1e-12)
    transfer = contact.contact_transfer(byref(geometry), -1, (c_int * 2)(1, 1))
    reactions = [
        100.0 * transfer.axial[i] * math.hypot(geometry.radius[i], geometry.slope[i]) for i in range(2)
    ]
    assert reactions == pytest.approx([285.18940169279986, 190.12626779519992], rel=1e-12)


def test_jam_is_refused(fmu):
    fmu.set({"cam1.radius": 0.02, "cam2.radius": 0.03, "cam1.lead_angle": 1.5, "cam2.lead_angle": 1.5})
    fmu.setup()
    fmu.ok("fmi2EnterInitializationMode")
    fmu.refused("fmi2ExitInitializationMode", mentions=("cam1.lead_angle", "1.5", "must be > 0"))


def test_both_lead_angles_at_the_friction_angle(contact):
    """n_1 = n_2 = 0: no torque is needed to hold any load, and none to let it go."""
    geometry = helices(0.02, 0.03, 0.5, 0.6, 0.3, 0.3)
    for i in range(2):
        geometry.friction[i] = geometry.slope[i] / geometry.radius[i]
        geometry.slope[i] = geometry.friction[i] * geometry.radius[i]
    assert contact.contact_band(byref(geometry)).release == 0.0


def test_dwell_on_one_cam(contact):
    """lambda_1 = 0: the pin turns in cam 1 and does not rise; only friction asks for torque."""
    geometry = helices(0.02, 0.03, 0.0, 0.7, 0.1, 0.0)
    band = contact.contact_band(byref(geometry))
    assert geometry.dz_dtheta == 0.0
    # contact 2 without friction: kappa_2 = 1/(r2 s2), kappa_1 = 1/(r1 mu1)
    assert band.load == pytest.approx(1 / (1 / (0.03 * math.tan(0.7)) + 1 / (0.02 * 0.1)), rel=1e-14)
