"""Components of the example systems with their start values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dualcam.ssp import Component, Value
from dualcam.systems.blocks.current_loop import CURRENT_BANDWIDTH, CURRENT_RATE
from dualcam.systems.blocks.gravity import GravityLoad
from dualcam.systems.blocks.helical_cam import HelicalCam
from dualcam.systems.blocks.motions import PickAndPlace
from dualcam.systems.blocks.motor import Motor
from dualcam.systems.blocks.position_controller import PositionController
from dualcam.systems.blocks.speed_controller import SpeedController
from system_examples.ssp import parts
from system_examples.ssp.variables import HARMONICS

CAM = parts.BUILD / "DualCamForward.fmu"


def cam_component(plant: Mapping[str, Value], theta: float, omega: float = 0.0) -> Component:
    """The cam with the start values `plant`, at `theta` [rad] and `omega` [rad/s]."""
    start: dict[str, Value] = {**plant, "initial.theta": theta}
    return Component("cam", CAM, start | ({"initial.omega": omega} if omega else {}))


def motor_component(motor: Motor, load: float, ratio: float = 1.0) -> Component:
    """The motor with its current loop; `load`: the load's torque at the start [N.m]."""
    return Component(
        "motor",
        parts.MOTOR.path,
        {
            "resistance": motor.resistance,
            "inductance": motor.inductance,
            "torque_constant": motor.torque_constant,
            "gear": motor.gear,
            "voltage": motor.voltage,
            "peak_torque": motor.peak_torque,
            "current.bandwidth": CURRENT_BANDWIDTH,
            "current.rate": CURRENT_RATE,
            "ratio": ratio,
            "initial.load": load,
        },
    )


def weight_component(load: GravityLoad, theta: float, ratio: float = 1.0, offset: float = 0.0) -> Component:
    """A load by gravity, the cam being at `theta` [rad]."""
    values = {"moment": load.moment, "lean": load.lean, "gravity": load.gravity}
    start = {**values, "ratio": ratio, "offset": offset, "initial.theta": theta}
    return Component("load", parts.PENDULUM_LOAD.path, start)


def band_values(cam: HelicalCam) -> dict[str, float]:
    """The controller's model of the stick band: straight lines over theta."""
    (release, load), rise = cam.band(0.0), cam.stiffness * cam.dz_dtheta
    return {
        "band.release": release,
        "band.release_rise": cam.release_arm * rise,
        "band.load": load,
        "band.load_rise": cam.load_arm * rise,
    }


def motion_values(cycle: PickAndPlace) -> dict[str, float]:
    """The motion that a controller follows."""
    return {f"motion.{name}": getattr(cycle, name) for name in ("start", "end", "move", "dwell")}


def model_values(controller: PositionController | SpeedController) -> dict[str, float]:
    """The controller's model of plant and load, and its limit."""
    load = controller.load
    return {
        "tick": controller.period,
        "inertia": controller.inertia,
        "limit": controller.torque_limit,
        "load.moment": load.moment,
        "load.lean": load.lean,
        "load.gravity": load.gravity,
    }


def series_values(name: str, coefficients: Sequence[float]) -> dict[str, float]:
    """A Fourier series."""
    names = ["mean", *(f"{wave}{n}" for n in range(1, HARMONICS + 1) for wave in ("cos", "sin"))]
    return {f"{name}.{key}": value for key, value in zip(names, coefficients, strict=True)}
