"""Blocks of dualcam.systems against closed forms, finite differences, balances and the FMUs."""

import math
import pkgutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from dualcam import Fmu, systems
from dualcam.systems.blocks.elliptical_cam import EllipticalCam
from dualcam.systems.blocks.impedance import ImpedanceController
from dualcam.systems.blocks.motions import FourierSeries
from dualcam.systems.blocks.pendulum import HingedPendulum, HingeMotion

ROOT = Path(__file__).resolve().parent.parent
STEP = 2e-3  # s, of the differences below
STENCIL = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])  # 8th order
OFFSETS = np.arange(-4, 5)

THIGH = FourierSeries((0.15, 0.3, -0.05, 0.08, 0.02), 1.1)
KNEE = FourierSeries((0.5, -0.1, -0.3, 0.2, 0.1), 1.1)
FORWARD = FourierSeries((0.0, 0.1, -0.02, 0.03, 0.01), 1.1)
UPWARD = FourierSeries((0.4, 0.02, 0.01, -0.01, 0.008), 1.1)
CURVES = (THIGH, KNEE, FORWARD, UPWARD)


def at(curve, time, order=0):
    return float(curve.sample(np.array([time]), order)[0])


def derivative(function, time):
    return sum(w * function(time + k * STEP) for w, k in zip(STENCIL, OFFSETS, strict=True)) / STEP


def hinge(time):
    return HingeMotion(
        tuple(at(THIGH, time, n) for n in range(5)),
        tuple(at(FORWARD, time, n) for n in (2, 3, 4)),
        tuple(at(UPWARD, time, n) for n in (2, 3, 4)),
    )


# ---- periodic curves ----


def test_periodic_curve_is_its_series():
    curve = FourierSeries((1.0, 2.0, 3.0, 0.0, 4.0), 0.5)
    time = np.array([0.0, 0.125, 0.5])
    assert curve.sample(time) == pytest.approx([3.0, 4.0, 3.0], abs=1e-14)  # 1 + 2, 1 + 3 + 4 sin(pi), 1 + 2


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_periodic_derivatives(order):
    for time in (0.0, 0.3, 0.77):
        slope = derivative(lambda t: at(KNEE, t, order - 1), time)
        assert at(KNEE, time, order) == pytest.approx(slope, rel=1e-10, abs=1e-9)


# ---- pendulum ----

MASS, DISTANCE, LEAD, CENTRAL = 4.0, 0.26, 0.04, 0.12  # kg, m, rad, kg.m2 about the centre of mass
PENDULUM = HingedPendulum(CENTRAL + MASS * DISTANCE**2, MASS * DISTANCE, LEAD)


def inclination(time, order=0):
    return at(THIGH, time, order) - at(KNEE, time, order) + (LEAD if order == 0 else 0.0)


def moment(time):
    """Extension moment that the equation of motion asks for along the curves."""
    return PENDULUM.drive(hinge(time), at(KNEE, time))[0] - PENDULUM.inertia * at(KNEE, time, 2)


def test_work_at_the_hinge_is_the_segments_energy():
    """Force at the hinge from Newton's law for the centre of mass; its work and the moment's make energy."""

    def centre(time, order):
        chi, rate, change = (inclination(time, n) for n in range(3))
        along, across = np.array([math.sin(chi), -math.cos(chi)]), np.array([math.cos(chi), math.sin(chi)])
        arm = (along, rate * across, change * across - rate**2 * along)[order]
        return np.array([at(FORWARD, time, order), at(UPWARD, time, order)]) + DISTANCE * arm

    def power(time):
        force = MASS * (centre(time, 2) + np.array([0.0, 9.81]))
        carried = force @ np.array([at(FORWARD, time, 1), at(UPWARD, time, 1)])
        return carried + moment(time) * inclination(time, 1)

    def energy(time):
        speed = centre(time, 1)
        kinetic = 0.5 * MASS * speed @ speed + 0.5 * CENTRAL * inclination(time, 1) ** 2
        return kinetic + MASS * 9.81 * centre(time, 0)[1]

    for begin, end in ((0.0, 0.4), (0.4, 0.9)):
        work, _ = quad(power, begin, end, epsabs=1e-12, epsrel=1e-12, limit=200)
        assert work == pytest.approx(energy(end) - energy(begin), abs=1e-10)


def test_pendulum_at_a_resting_hinge_is_the_textbooks():
    still = HingeMotion((0.0,) * 5, (0.0,) * 3, (0.0,) * 3)
    torque, first, second = PENDULUM.drive(still, 0.3, 0.0, 0.0)
    assert torque == pytest.approx(MASS * DISTANCE * 9.81 * math.sin(LEAD - 0.3), rel=1e-14)
    assert (first, second) == (0.0, 0.0)


@pytest.mark.parametrize("order", [1, 2])
def test_drive_derivatives(order):
    def drive(time):
        return PENDULUM.drive(hinge(time), *(at(KNEE, time, n) for n in range(3)))

    for time in (0.1, 0.5, 0.8):
        slope = derivative(lambda t: drive(t)[order - 1], time)
        assert drive(time)[order] == pytest.approx(slope, rel=1e-9, abs=1e-8)


def test_impedance_is_a_spring_and_a_damper():
    controller = ImpedanceController(100.0, 5.0)
    assert controller.torque(0.1, 0.0) == pytest.approx(-10.0)
    assert controller.torque(0.0, -2.0) == pytest.approx(10.0)


# ---- cam with elliptical grooves ----

CAM = EllipticalCam(0.02, 1.19, 0.0756, 0.0188, 0.14, 44.8e3, 20e3)


@pytest.mark.parametrize("theta", [0.01, 0.4, 1.0, 1.2])
@pytest.mark.parametrize("omega", [3.0, -0.02, -1.0, -6.0])
def test_elliptical_cam_agrees_with_the_inverse_fmu(theta, omega):
    """Loading, releasing, and releasing so fast that the damper pulls the pin to the other flank."""
    span, step = 1e-4, 1e-6
    with Fmu(ROOT / "build" / "DualCamInverse.fmu") as slave:
        motion, torque = slave.reals("theta", "omega"), slave.reals("tau")
        slave.start({**CAM.parameters(), "inertia.shaft": 0.0, "theta": theta - omega * span, "omega": omega})
        for k in range(1, round(span / step) + 1):
            motion.values[:] = theta + omega * (k * step - span), omega
            motion.write()
            slave.step(step)
        (found,) = torque.read()
    assert float(CAM.torque(np.array([theta]), np.array([omega]))[0]) == pytest.approx(found, rel=1e-9)


def test_height_of_the_elliptical_cam_is_the_integral_of_its_slope():
    def rate(theta):
        return float(0.5 * CAM.radius * CAM.slope_and_height(np.array([theta]))[0][0])

    height = float(CAM.slope_and_height(np.array([1.2]))[1][0])
    assert quad(rate, 0.0, 1.2, epsabs=1e-14)[0] == pytest.approx(height, rel=1e-12)
    assert rate(0.0) == pytest.approx(0.01 * math.tan(CAM.lead_angle), rel=1e-12)


def test_systems_are_imported_without_matplotlib():
    """Nor python-control, whose import takes seconds."""
    modules = [f"dualcam.systems.{module.name}" for module in pkgutil.iter_modules(systems.__path__)]
    code = f"import sys, {', '.join(modules)}; print({{'matplotlib', 'control'}} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert run.stdout.strip() == "set()"
