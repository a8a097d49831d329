"""The three examples as systems of FMUs: the cam, a controller, a motor with its current loop, a load.

The cam's torque is the sum of the motor's and the load's. Communication points are the samples of the current
loop, 20 kHz. The controllers give a command per control period of 1 ms, as in Python. In an explicit coupling
a command reaches the motor one step late, and the motor's torque reaches the cam another step late. So
controllers and load compute ahead: for the time two steps later, and the angle and speed expected then. Two
things differ from the Python versions: that expectation, and the motor's torque, which acts as it is every
50 us and not averaged over a control period.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dualcam import Fmu
from dualcam.ssp import Component
from dualcam.systems.blocks.axis import CamAxis, simulate_closed_loop
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD, CURRENT_RATE, CurrentLoop
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.blocks.record import Record
from dualcam.systems.machines import car_door, elbow, knee
from dualcam.systems.machines.gait import DESIGN_WALKER
from dualcam.systems.machines.swing import SWING
from system_examples.ssp import parts
from system_examples.ssp.components import (
    CAM,
    band_values,
    cam_component,
    model_values,
    motion_values,
    motor_component,
    series_values,
    weight_component,
)
from system_examples.ssp.coupling import Columns
from system_examples.ssp.package import ExampleSystem

STEP = 1.0 / CURRENT_RATE  # s
STEPS_PER_PERIOD = round(CONTROL_PERIOD / STEP)  # communication steps per control period
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
HEATS = ("heat_cam1", "heat_cam2", "heat_damper")  # of the cam
WATCHED = (
    "cam.theta",
    "cam.omega",
    "motor.tau",
    "motor.heat",
    "motor.energy",
    "controller.reference",
    *(f"cam.energy.{name}" for name in HEATS),
)


@dataclass(frozen=True)
class Run:
    """The values to compare with the Python version, at the end of each control period, shape (n,); accounts
    since the start."""

    angle: np.ndarray  # rad, of the output
    reference: np.ndarray  # rad
    motor_heat: np.ndarray  # J
    supply: np.ndarray  # J
    cam_heat: np.ndarray  # J, contacts and damper
    begin: int = 0  # the control period from which the figures count

    def figures(self) -> dict[str, float]:
        """The figures to compare, by name."""

        def since_begin(account: np.ndarray) -> float:
            return float(account[-1] - (account[self.begin - 1] if self.begin else 0.0))

        error = (self.angle - self.reference)[self.begin :]
        return {
            "largest error [mrad]": 1e3 * float(np.max(np.abs(error))),
            "motor heat [J]": since_begin(self.motor_heat),
            "from the supply [J]": since_begin(self.supply),
            "heat in the cam [J]": since_begin(self.cam_heat),
        }


@dataclass(frozen=True)
class Example:
    """A system of FMUs, and its Python version."""

    system: ExampleSystem
    python: Callable[[Fmu], Record]  # runs the Python version with the forward FMU
    ratio: float = 1.0  # angle of the cam over that of the output
    offset: float = 0.0  # rad, angle of the output at theta = 0
    begin: int = 0  # the control period from which the figures count

    def package_run(self, columns: Columns) -> Run:
        """The run of the package whose watched variables are these, one entry per control period."""
        return Run(
            self.offset + columns["cam.theta"] / self.ratio,
            columns["controller.reference"],
            columns["motor.heat"],
            columns["motor.energy"],
            total([columns[f"cam.energy.{name}"] for name in HEATS]),
            self.begin,
        )

    def python_run(self) -> Run:
        """The run of the Python version."""
        with Fmu(CAM) as fmu:
            record = self.python(fmu)
        motor_heat, supply = np.cumsum(record.motor_heat), np.cumsum(record.supply_energy)
        heat = total([record.ledger[name] for name in HEATS])
        return Run(record.angle, record.reference, motor_heat, supply, heat, self.begin)


def total(accounts: Sequence[np.ndarray]) -> np.ndarray:
    """The sum of these accounts [J]."""
    return sum(accounts, np.zeros(len(accounts[0])))


# ---- systems ----


def elbow_example() -> Example:
    """The robot's elbow with the cam and the payload that it was designed for."""
    payload, cam, begin = elbow.DESIGN_PAYLOAD, elbow.design_cam(), elbow.MOTION.start
    load, controller = elbow.weight(payload), elbow.controller(cam, payload)
    start = {
        **model_values(controller),
        **{f"gain.{name}": gain for name, gain in controller.gains._asdict().items()},
        **band_values(controller.cam),
        **motion_values(elbow.MOTION),
        "hold.tolerance": controller.rest.tolerance,
        "hold.speed": controller.rest.speed,
        "hold.margin": controller.rest.margin,
        "initial.theta": begin,
    }
    components = (
        cam_component(elbow.plant_parameters(cam, payload), begin),
        Component("controller", parts.JOINT_CONTROLLER.path, start),
        motor_component(AK80_6, load.torque(begin)),
        weight_component(load, begin),
    )

    def python(fmu: Fmu) -> Record:
        axis = CamAxis(fmu)
        axis.start(elbow.plant_parameters(cam, payload), begin)
        return simulate_closed_loop(
            axis, load, elbow.controller(cam, payload), CurrentLoop(AK80_6), elbow.reference_motion()
        )

    duration = elbow.CYCLES * elbow.MOTION.period
    text = "elbow of a robot that moves 1.5 kg to and fro, with the cam"
    system = ExampleSystem("robot_joint", text, components, CONNECTIONS, STEP, duration)
    return Example(system, python, begin=round((duration - elbow.MOTION.period) / CONTROL_PERIOD))


def door_example() -> Example:
    """The car door's motor cycle, nose up, with the cam."""
    cam, load, ratio = car_door.design(), car_door.weight(car_door.NOSE_UP), -car_door.RATIO
    controller = car_door.controller(cam, car_door.NOSE_UP)
    believed = car_door.cam_in_controller(cam)
    theta = ratio * (car_door.MOTION.start - car_door.OPEN)
    start = {
        **model_values(controller),
        "gain.speed": controller.proportional,
        "gain.distance": controller.integral,
        **band_values(believed.cam),
        "drag": believed.damping,
        "ratio": ratio,
        "offset": car_door.OPEN,
        **motion_values(car_door.MOTION),
        "hold.speed": controller.rest_speed,
        "hold.margin": controller.rest_margin,
        "initial.theta": theta,
    }
    components = (
        cam_component(car_door.plant_parameters(cam), theta),
        Component("controller", parts.DOOR_CONTROLLER.path, start),
        motor_component(car_door.MOTOR, load.torque(car_door.MOTION.start), ratio),
        weight_component(load, theta, ratio, car_door.OPEN),
    )

    def python(fmu: Fmu) -> Record:
        axis, loop = car_door.door_axis(fmu), CurrentLoop(car_door.MOTOR)
        axis.start(car_door.plant_parameters(cam), car_door.MOTION.start)
        controller = car_door.controller(cam, car_door.NOSE_UP)
        return simulate_closed_loop(
            axis, load, controller, loop, car_door.reference_motion(), mean_speed=True
        )

    text = "side door of a car that is parked nose up, opened, held and closed by its motor, with the cam"
    system = ExampleSystem("car_door", text, components, CONNECTIONS, STEP, car_door.DURATION)
    return Example(system, python, ratio, car_door.OPEN)


def knee_example() -> Example:
    """The prosthetic knee with the cam: one swing of the first subject, self-selected cadence."""
    walker, pendulum = DESIGN_WALKER, DESIGN_WALKER.pendulum
    motion, cam = knee.swing(walker, 1.0), knee.design_cam().parameters()
    impedance = knee.impedance(knee.inertia(walker))
    state = {"initial.theta": float(motion.angle[0]), "initial.omega": float(motion.speed[0])}
    stride = {
        "stride": walker.stride,
        "toe_off": SWING[0] * walker.stride,
        "extension": motion.extension,
    }
    controller = {
        "tick": CONTROL_PERIOD,
        "stiffness": impedance.stiffness,
        "damping": impedance.damping,
        **stride,
        **series_values("knee", walker.knee),
        **state,
    }
    load = {
        "inertia": pendulum.inertia,
        "moment": pendulum.moment,
        "lead": pendulum.lead,
        "gravity": pendulum.gravity,
        **stride,
        **series_values("thigh", walker.thigh),
        **series_values("forward", walker.forward),
        **series_values("upward", walker.upward),
        "initial.theta": state["initial.theta"],
    }
    drive, _, _ = pendulum.drive(motion.hinge[0], state["initial.theta"] + motion.extension)
    components = (
        cam_component(knee.plant_parameters(cam, walker), *state.values()),
        Component("controller", parts.KNEE_CONTROLLER.path, controller),
        motor_component(knee.MOTOR, drive),
        Component("load", parts.SHANK_LOAD.path, load),
    )

    def python(fmu: Fmu) -> Record:
        return knee.simulate(fmu, motion, cam, impedance).record

    duration = (len(motion.time) - 1) * CONTROL_PERIOD
    text = "prosthetic knee in swing, from toe-off to heel strike, with the cam"
    return Example(ExampleSystem("prosthetic_knee", text, components, CONNECTIONS, STEP, duration), python)


EXAMPLES = {"robot_joint": elbow_example, "prosthetic_knee": knee_example, "car_door": door_example}
