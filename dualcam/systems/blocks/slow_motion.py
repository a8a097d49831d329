"""The torque of slow motion as the inverse FMU gives it."""

from collections.abc import Mapping

import numpy as np

from dualcam.design.statics import Array
from dualcam.fmi.fmu import Fmu, Scalar


def slow_torque(fmu: Fmu, parameters: Mapping[str, Scalar], theta: Array, speed: float) -> Array:
    """The torque of the inverse FMU without inertia along a slow motion [N.m], shape (n,).

    `fmu`: the inverse FMU. `parameters`: start values of the FMU. `theta`: angles [rad] in the order in which
    the motion passes them, shape (n,). `speed` of the motion [rad/s]; its sign is that of the steps of theta.
    FmuError: the FMU refuses a parameter or an angle.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam import Fmu
    >>> from dualcam.systems.blocks.slow_motion import slow_torque
    >>> with Fmu("inverse") as fmu:
    ...     torque = slow_torque(fmu, {}, np.array([0.0, 0.7, 1.3]), speed=1e-3)
    >>> torque.round(3).tolist()  # N.m
    [0.663, 5.302, 9.279]
    """
    fmu.start({**parameters, "inertia.shaft": 0.0, "theta": float(theta[0]), "omega": speed})
    motion, torque = fmu.reals("theta", "omega"), fmu.reals("tau")
    found = [torque.read()[0]]
    for angle, step in zip(theta[1:], np.diff(theta) / speed, strict=True):
        motion.values[:] = angle, speed
        motion.write()
        fmu.step(float(step))
        found.append(torque.read()[0])
    return np.array(found)
