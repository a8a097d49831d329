"""The torque of slow motion as the inverse FMU gives it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from dualcam.design.statics import Array
from dualcam.fmu import Fmu, Scalar


def slow_torque(fmu: Fmu, parameters: Mapping[str, Scalar], theta: Array, speed: float) -> Array:
    """tau [N.m], shape (n,), of the inverse FMU without inertia at theta [rad], shape (n,), in the order in
    which a motion with `speed` [rad/s] passes them. FmuError if the FMU refuses a parameter or an angle."""
    fmu.start({**parameters, "inertia.shaft": 0.0, "theta": float(theta[0]), "omega": speed})
    motion, torque = fmu.reals("theta", "omega"), fmu.reals("tau")
    found = [torque.read()[0]]
    for angle, step in zip(theta[1:], np.diff(theta) / speed, strict=True):
        motion.values[:] = angle, speed
        motion.write()
        fmu.step(float(step))
        found.append(torque.read()[0])
    return np.array(found)
