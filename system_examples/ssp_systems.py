"""The three examples as systems of FMUs: the cam, a controller, a motor with its current loop, a load.

The cam's torque is the motor's and the load's. Communication points are the samples of the current loop,
20 kHz; the controllers give a command per tick of 1 ms, as in Python. In an explicit coupling a command
reaches the motor one step late and the motor's torque the cam another one. So controllers and load compute
ahead: for the time two steps on, and the angle and speed expected then. What differs from the Python
versions is that expectation, and that the motor's torque acts as it is every 50 us, not averaged over a
tick.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import blocks
import car_door
import numpy as np
import prosthetic_knee
import robot_joint
from ssp_packages import Columns, Component, System
from ssp_parts import (
    DOOR_CONTROLLER,
    HARMONICS,
    JOINT_CONTROLLER,
    KNEE_CONTROLLER,
    MOTOR,
    PENDULUM_LOAD,
    SHANK_LOAD,
    Part,
    build_fmu,
)

from dualcam import Fmu

CAM = build_fmu.BUILD / "DualCamForward.fmu"
STEP = 1.0 / robot_joint.CURRENT_RATE  # s
PER_TICK = round(robot_joint.TICK / STEP)  # communication steps per tick
CONNECTIONS = (
    ("motor.tau", "cam.tau"),
    ("load.torque", "motor.load"),
    ("controller.command", "motor.command"),
    ("cam.omega", "motor.omega"),
    ("cam.theta", "controller.theta"),
    ("cam.omega", "controller.omega"),
    ("cam.theta", "load.theta"),
    ("cam.omega", "load.omega"),
)
ACCOUNTS = ("cam.energy.heat_cam1", "cam.energy.heat_cam2", "cam.energy.heat_damper")
WATCHED = (
    "cam.theta",
    "cam.omega",
    "motor.tau",
    "motor.heat",
    "motor.energy",
    "controller.reference",
    *ACCOUNTS,
)


@dataclass(frozen=True)
class Course:
    """What is compared with the Python version, at the end of each tick; accounts since the start."""

    angle: np.ndarray  # rad, of the output
    reference: np.ndarray  # rad
    motor_heat: np.ndarray  # J
    supply: np.ndarray  # J
    cam_heat: np.ndarray  # J, contacts and damper
    begin: int = 0  # the tick that the numbers count from

    def numbers(self) -> dict[str, float]:
        def since(account: np.ndarray) -> float:
            return float(account[-1] - (account[self.begin - 1] if self.begin else 0.0))

        error = (self.angle - self.reference)[self.begin :]
        return {
            "largest error [mrad]": 1e3 * float(np.max(np.abs(error))),
            "motor heat [J]": since(self.motor_heat),
            "from the supply [J]": since(self.supply),
            "heat in the cam [J]": since(self.cam_heat),
        }


@dataclass(frozen=True)
class Example:
    system: System
    original: Callable[[], Course]  # the Python version
    ratio: float = 1.0  # angle of the cam over that of the output
    offset: float = 0.0  # rad, angle of the output at theta = 0
    begin: int = 0

    def course(self, columns: Columns) -> Course:
        """Of a run of the package, watched at each tick."""
        return Course(
            self.offset + columns["cam.theta"] / self.ratio,
            columns["controller.reference"],
            columns["motor.heat"],
            columns["motor.energy"],
            sum((columns[name] for name in ACCOUNTS), np.zeros(len(columns["cam.theta"]))),
            self.begin,
        )


def motor(values: blocks.Motor, load: float, ratio: float = 1.0) -> Component:
    """`load`: the load's torque at the start [N.m]."""
    return Component(
        "motor",
        MOTOR.path,
        {
            "resistance": values.resistance,
            "inductance": values.inductance,
            "torque_constant": values.torque_constant,
            "gear": values.gear,
            "voltage": values.voltage,
            "peak_torque": values.peak_torque,
            "current.bandwidth": robot_joint.CURRENT_BANDWIDTH,
            "current.rate": robot_joint.CURRENT_RATE,
            "ratio": ratio,
            "initial.load": load,
        },
    )


def band(cam: blocks.HelixCam) -> dict[str, float]:
    """The stick band that a controller believes in: straight lines over theta."""
    (release, load), rise = cam.band(0.0), cam.stiffness * cam.lift
    return {
        "band.release": release,
        "band.release_rise": cam.release_arm * rise,
        "band.load": load,
        "band.load_rise": cam.load_arm * rise,
    }


def motion(cycle: blocks.PickAndPlace) -> dict[str, float]:
    return {f"motion.{name}": getattr(cycle, name) for name in ("start", "end", "move", "dwell")}


def believed(load: blocks.GravityLoad) -> dict[str, float]:
    return {"load.moment": load.moment, "load.lean": load.lean, "load.gravity": load.gravity}


def weight(load: blocks.GravityLoad, theta: float, ratio: float = 1.0, offset: float = 0.0) -> Component:
    values = {"moment": load.moment, "lean": load.lean, "gravity": load.gravity}
    return Component(
        "load", PENDULUM_LOAD.path, {**values, "ratio": ratio, "offset": offset, "initial.theta": theta}
    )


def controller(part: Part, values: dict[str, float]) -> Component:
    return Component("controller", part.path, values)


def elbow() -> Example:
    """The robot's elbow with the cam and the payload that it was designed for."""
    e = robot_joint
    payload, cam = e.DESIGN_PAYLOAD, e.design_cam()
    load, told = e.gravity(payload), payload + e.PAYLOAD_ERROR
    gains = blocks.lqi_gains(e.BANDWIDTH, e.TICK)
    components = (
        Component(
            "cam",
            CAM,
            {
                **cam.parameters(),
                "inertia.shaft": e.AK80_6.inertia + e.arm_inertia(payload),
                "stop.lower": 0.0,
                "stop.upper": e.RANGE,
                "initial.theta": e.MOTION.start,
                "contacts": 2,
            },
        ),
        controller(
            JOINT_CONTROLLER,
            {
                "tick": e.TICK,
                "inertia": e.AK80_6.inertia + e.arm_inertia(told),
                "limit": e.AK80_6.peak_torque,
                **dict(zip(("gain.angle", "gain.speed", "gain.integral"), gains, strict=True)),
                **believed(e.gravity(told)),
                **band(e.with_friction(cam, e.FRICTION_BELIEVED)),
                **motion(e.MOTION),
                "hold.tolerance": e.HOLD_TOLERANCE,
                "hold.speed": e.HOLD_SPEED,
                "hold.margin": e.HOLD_MARGIN,
                "initial.theta": e.MOTION.start,
            },
        ),
        motor(e.AK80_6, load.torque(e.MOTION.start)),
        weight(load, e.MOTION.start),
    )

    def original() -> Course:
        with Fmu(CAM) as slave:
            result = e.simulate(slave, payload, e.CAM)
        heat = result.ledger["heat_cam1"] + result.ledger["heat_cam2"]
        accounts = np.cumsum(result.motor_heat), np.cumsum(result.supply_energy), heat
        return Course(result.theta, result.reference, *accounts, begin)

    begin = round((e.CYCLES - 1) * e.MOTION.period / e.TICK)
    text = "elbow of a robot that moves 1.5 kg to and fro, with the cam"
    system = System("robot_joint", text, components, CONNECTIONS, STEP, e.CYCLES * e.MOTION.period)
    return Example(system, original, begin=begin)


def door() -> Example:
    """The car door's motor cycle, nose up, with the cam."""
    e = car_door
    hold, load = e.design(), e.weight(e.NOSE_UP)
    hidden = replace(hold, cam=e.with_friction(hold.cam, e.FRICTION_BELIEVED))
    told, ratio = e.weight(e.NOSE_UP, e.MASS_BELIEVED * e.MASS), -e.RATIO
    begin = e.RATIO * (e.OPEN - e.MOTION.start)  # rad, the cam's angle
    frequency = 2.0 * math.pi * e.BANDWIDTH
    components = (
        Component(
            "cam",
            CAM,
            {
                **hold.parameters(),
                "inertia.shaft": e.INERTIA / e.RATIO**2,
                "stop.lower": 0.0,
                "stop.upper": e.RATIO * e.OPEN,
                "initial.theta": begin,
            },
        ),
        controller(
            DOOR_CONTROLLER,
            {
                "tick": e.TICK,
                "inertia": e.INERTIA,
                "limit": e.MOTOR.peak_torque,
                "gain.speed": 2.0 * frequency,
                "gain.distance": frequency**2,
                **believed(told),
                **band(hidden.cam),
                "drag": hidden.drag,
                "ratio": ratio,
                "offset": e.OPEN,
                **motion(e.MOTION),
                "hold.speed": e.HOLD_SPEED,
                "hold.margin": e.REST_MARGIN,
                "initial.theta": begin,
            },
        ),
        motor(e.MOTOR, load.torque(e.MOTION.start), ratio),
        weight(load, begin, ratio, e.OPEN),
    )

    def original() -> Course:
        with Fmu(CAM) as slave:
            cycle = e.drive(e.Door(slave), e.NOSE_UP, e.CAM, hold)
        heat = cycle.ledger["heat_cam1"] + cycle.ledger["heat_cam2"] + cycle.ledger["heat_damper"]
        accounts = np.cumsum(cycle.motor_heat), np.cumsum(cycle.supply_energy), heat
        return Course(cycle.angle, cycle.reference, *accounts)

    text = "side door of a car that is parked nose up, opened, held and closed by its motor, with the cam"
    system = System("car_door", text, components, CONNECTIONS, STEP, e.DURATION)
    return Example(system, original, ratio, e.OPEN)


def series(name: str, coefficients: Sequence[float]) -> dict[str, float]:
    names = ["mean", *(f"{wave}{n}" for n in range(1, HARMONICS + 1) for wave in ("cos", "sin"))]
    return {f"{name}.{key}": value for key, value in zip(names, coefficients, strict=True)}


def knee() -> Example:
    """The prosthetic knee with the cam: one swing of the first subject, self-selected cadence."""
    e = prosthetic_knee
    walker, cam = e.DESIGN_WALKER, e.design_cam()
    swing, pendulum, drive_motor = e.swing(walker, 1.0), walker.pendulum, e.AK80_6_BELT
    inertia = pendulum.inertia + drive_motor.inertia
    impedance = e.impedance(inertia)
    start = float(swing.angle[0])
    stride = {
        "stride": walker.stride,
        "toe_off": e.SWING[0] * walker.stride,
        "extension": swing.extension,
    }
    load = {
        "inertia": pendulum.inertia,
        "moment": pendulum.moment,
        "lead": pendulum.lead,
        "gravity": pendulum.gravity,
        **stride,
        **series("thigh", walker.thigh),
        **series("forward", walker.forward),
        **series("upward", walker.upward),
        "initial.theta": start,
    }
    components = (
        Component(
            "cam",
            CAM,
            {
                **e.valve(cam, 1.0).parameters(),
                "inertia.shaft": inertia,
                "stop.lower": 0.0,
                "stop.upper": e.RANGE,
                "initial.theta": start,
                "initial.omega": float(swing.speed[0]),
            },
        ),
        controller(
            KNEE_CONTROLLER,
            {
                "tick": e.TICK,
                "stiffness": impedance.stiffness,
                "damping": impedance.damping,
                **stride,
                **series("knee", walker.knee),
                "initial.theta": start,
                "initial.omega": float(swing.speed[0]),
            },
        ),
        motor(drive_motor, pendulum.drive(swing.hinge[0], start + swing.extension)[0]),
        Component("load", SHANK_LOAD.path, load),
    )

    def original() -> Course:
        with Fmu(CAM) as slave:
            result = e.simulate(slave, swing, e.CAM, cam)
        heat = sum((result.ledger[name.removeprefix("cam.energy.")] for name in ACCOUNTS), np.zeros(ticks))
        accounts = np.cumsum(result.motor_heat), np.cumsum(result.supply_energy), heat
        return Course(result.theta, swing.angle[1:], *accounts)

    ticks = len(swing.time) - 1
    text = "prosthetic knee in swing, from toe-off to heel strike, with the cam"
    system = System("prosthetic_knee", text, components, CONNECTIONS, STEP, ticks * e.TICK)
    return Example(system, original)


EXAMPLES = {"robot_joint": elbow, "prosthetic_knee": knee, "car_door": door}
