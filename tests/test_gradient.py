"""dualcam.gradient: the gradient of a loss through 1000 steps of stick and slip against differences, in NumPy,
JAX and PyTorch."""

import math

import numpy as np
import pytest

from dualcam import Fleet, FmuError, UnknownVariableError
from dualcam.errors import DualcamError
from dualcam.gradient import DifferentiableFleet, jax_rollout, torch_rollout

COUNT, STEPS, H = 6, 1000, 2e-3
PARAMETERS = ("cam1.friction", "cam2.friction", "spring.stiffness", "damper.c_load")
NOMINAL = np.array([0.14, 0.12, 5e4, 20.0])
SCALE = np.array([1e-2, 1e-2, 1e3, 5.0])  # of changes
START = np.array([0.4, 0.0])
STRIBECK = {"cam1.friction_peak": 1.4, "cam1.stribeck_velocity": 0.05, "cam2.friction_viscous": 0.2}
ELLIPSES = {"cam1.profile": 2, "cam2.profile": 2, "cam2.radius": 0.025, "cam2.lead_angle": 0.7}
SCENES = {
    "helices": {},
    "helices that bounce": {"stop.restitution": 0.6, "stop.upper": 0.75, "stop.lower": 0.1},
    "Stribeck": STRIBECK,
    "ellipses": ELLIPSES | {"inertia.follower_mass": 0.3, "stop.restitution": 0.5, "stop.upper": 0.7},
    "without inertia, damped": {"inertia.shaft": 0.0, "damper.c_release": 30.0},
    "play": {"inertia.shaft": 0.0, "damper.c_load": 0.0},
}


def arguments(seed: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Slow torques of several waves each: every instance sticks and slips in both directions."""
    random = np.random.default_rng(seed)
    time = H * np.arange(STEPS)
    waves = random.uniform(0.5, 1.5, (COUNT, 3, 1)) * np.sin(
        2.0 * math.pi * random.uniform(0.5, 4.0, (COUNT, 3, 1)) * time + random.uniform(0, 6, (COUNT, 3, 1))
    )
    u = (3.0 + waves.sum(axis=1))[:, :, None]
    return np.tile(START, (COUNT, 1)), u, np.tile(NOMINAL, (COUNT, 1))


def loss_and_slope(states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A loss of each instance: of the angles all along, and of the speed; and its derivative by the states."""
    weight = np.cos(0.01 * np.arange(states.shape[1]))[:, None] * [1.0, 0.02]
    return (weight * states**2).sum(axis=(1, 2)), 2.0 * weight * states


def directions(scene: dict) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Random changes of start, inputs and parameters."""
    random = np.random.default_rng(7)
    speed = 0.0 if scene.get("inertia.shaft") == 0.0 else 1.0
    none = np.zeros((COUNT, 2)), np.zeros((COUNT, STEPS, 1)), np.zeros((COUNT, 4))
    start = random.normal(size=(COUNT, 2)) * [1e-2, 0.0 * speed]
    inputs = 0.1 * random.normal(size=(COUNT, STEPS, 1))
    parameters = random.normal(size=(COUNT, 4)) * SCALE
    if scene.get("damper.c_load") == 0.0:
        parameters[:, 3] = 0.0
    return {
        "start": (start, *none[1:]),
        "inputs": (none[0], inputs, none[2]),
        "parameters": (*none[:2], parameters),
    }
