"""The price of one evaluation of the acceleration: elliptical grooves with every force, in acceleration.c."""

from __future__ import annotations

import ctypes
import math

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from scipy.optimize import brentq

from benchmarks.harness import core
from benchmarks.harness.fmu import Parameters
from benchmarks.harness.timing import Array, Block

CALLS = 5000
DEGREE = 12
FITTED = (0.0, 1.0)  # rad, the angles over which the grooves are fitted
TORQUE = 10.0  # N.m
RADII, LEADS, AXES, CURVATURES = (0.03, 0.025), (0.70, 0.85), (0.15, 0.12), (1, -1)
OTHERS: dict[str, float] = {  # name of the FMU's parameter, and its value
    **{"cam1.friction": 0.14, "cam2.friction": 0.14, "inertia.shaft": 0.002, "inertia.follower_mass": 0.3},
    **{"inertia.follower": 3e-5, "spring.preload": 100.0, "spring.stiffness": 5e4, "spring.stiffness2": 1e6},
    **{"spring.stiffness3": 1e8, "damper.c_load": 50.0, "damper.q_load": 20.0, "shaft.damping": 0.005},
}
NUMBERS = (
    *("middle", "scale", "r1", "r2", "mu1", "mu2", "inertia", "mass", "spin", "preload", "k", "k2", "k3"),
    *("c", "q", "b", "tau"),
)


class MechanismStruct(ctypes.Structure):
    """`Mechanism` of acceleration.c."""

    _fields_ = [
        *((name, ctypes.c_double * (DEGREE + 1)) for name in ("a1", "a2", "z")),
        *((name, ctypes.c_double) for name in NUMBERS),
    ]


class Ellipse:
    """An elliptical groove: S = start + rate psi, z = kappa b (sqrt(1 - start^2) - sqrt(1 - S^2))."""

    def __init__(self, cam: int) -> None:
        radius, axis, curvature = RADII[cam], AXES[cam], CURVATURES[cam]
        self.start = math.sin(math.atan(math.tan(LEADS[cam])))
        self.rate, self.height = curvature * radius / axis, curvature * axis

    def root(self, psi: float) -> float:
        return math.sqrt(1.0 - (self.start + self.rate * psi) ** 2)

    def z(self, psi: float) -> float:
        return self.height * (self.root(0.0) - self.root(psi))

    def slope(self, psi: float) -> float:
        return self.height * self.rate * (self.start + self.rate * psi) / self.root(psi)


def transmission(theta: float) -> tuple[float, float, float]:
    """Both slopes [m/rad] and z [m] at an angle [rad]."""
    one, two = Ellipse(0), Ellipse(1)
    gamma = brentq(lambda g: one.z(g) - two.z(theta - g), -1e-9, theta + 1e-9, xtol=1e-16, rtol=1e-15)
    return one.slope(gamma), two.slope(theta - gamma), one.z(gamma)


def fitted() -> list[Array]:
    """Coefficients of a1, a2 and z of x, which goes from -1 to 1 over FITTED."""
    middle, half = sum(FITTED) / 2.0, (FITTED[1] - FITTED[0]) / 2.0
    points = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
    columns = np.array([transmission(middle + half * x) for x in points]).T
    curves = [Chebyshev.fit(points, column, DEGREE, domain=[-1, 1]) for column in columns]
    return [np.asarray(curve.convert(kind=Polynomial).coef, dtype=float) for curve in curves]


def mechanism() -> MechanismStruct:
    middle, scale = sum(FITTED) / 2.0, 2.0 / (FITTED[1] - FITTED[0])
    rows = [(ctypes.c_double * (DEGREE + 1))(*row) for row in fitted()]
    return MechanismStruct(*rows, middle, scale, *RADII, *OTHERS.values(), TORQUE)


def parameters() -> Parameters:
    """The same mechanism in the words of the FMU."""
    cams = zip((1, 2), RADII, LEADS, AXES, CURVATURES, strict=True)
    grooves = {
        f"cam{cam}.{name}": value
        for cam, *values in cams
        for name, value in zip(
            ("radius", "lead_angle", "ellipse_a", "ellipse_b", "ellipse_curvature", "profile"),
            (*values[:2], values[2], values[2], values[3], 2),
            strict=True,
        )
    }
    return {**grooves, **OTHERS}


def load() -> ctypes.CDLL:
    return core.load_loops("step_cost/acceleration.c", "seconds_evaluations", "acceleration")


def evaluation() -> Block:
    """Seconds of one evaluation at 10 rad/s."""
    loops, struct, total = load(), mechanism(), ctypes.c_double()

    def block() -> float:
        arguments = ctypes.c_double(10.0), ctypes.c_size_t(CALLS), ctypes.byref(total)
        return float(loops.seconds_evaluations(ctypes.byref(struct), *arguments)) / CALLS

    return block
