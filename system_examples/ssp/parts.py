"""The parts of the example systems besides the cam, as FMUs: FMI 2.0 co-simulation, in C.

Here is the one list of each part's variables. compilation.py makes from it part_variables.h, which the C code
reads, and modelDescription.xml.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from system_examples.ssp.variables import (
    BAND_MODEL,
    CONTROLLER,
    GRAVITY,
    INERTIA,
    LIMIT,
    LOAD_MODEL,
    MOTION,
    NEWEST_COMMAND,
    OFFSET,
    OMEGA,
    RATIO,
    REST,
    START,
    SWING,
    THETA,
    TORQUE,
    Variable,
    fourier,
    input_variable,
    local_variable,
    output_variable,
    parameter,
)

BUILD = Path(__file__).resolve().parents[2] / "build"
FOLDER = BUILD / "ssp/parts"


@dataclass(frozen=True)
class Part:
    """An FMU from C files beside this one and a list of variables."""

    identifier: str
    text: str
    sources: tuple[str, ...]
    variables: tuple[Variable, ...]

    @property
    def path(self) -> Path:
        """The FMU that compilation.build makes."""
        return FOLDER / f"{self.identifier}.fmu"


MOTOR = Part(
    "Motor",
    "Geared brushless motor under a PI current loop; adds the load's torque to its own",
    ("motor.c",),
    (
        input_variable("command", "N.m", "torque asked for, about the output"),
        OMEGA,
        input_variable("load", "N.m", "torque of the load about the output"),
        output_variable("tau", "N.m", "torque of motor and load at the cam, mean over the last step"),
        output_variable("torque", "N.m", "torque of the motor about the output, mean over the last step"),
        output_variable("current", "A", "current in the winding"),
        output_variable("heat", "J", "heat in the winding since the start"),
        output_variable("energy", "J", "energy drawn from the supply since the start"),
        parameter("resistance", "ohm", 0.17, "resistance"),
        parameter("inductance", "H", 57e-6, "inductance"),
        parameter("torque_constant", "N.m/A", 0.091, "torque per ampere at the rotor"),
        parameter("gear", "1", 6.0, "turns of the rotor per turn of the output"),
        parameter("voltage", "V", 24.0, "largest voltage of the supply"),
        parameter("peak_torque", "N.m", 12.0, "largest torque about the output"),
        parameter("current.bandwidth", "Hz", 1e3, "bandwidth of the current loop"),
        parameter("current.rate", "Hz", 20e3, "samples of the current loop"),
        RATIO,
        parameter("initial.load", "N.m", 0.0, "torque of the load at the start"),
        local_variable("current.integral", "V", "integral part of the current loop"),
    ),
)
PENDULUM_LOAD = Part(
    "PendulumLoad",
    "Weight of a body that turns about an axis",
    ("pendulum_load.c",),
    (
        THETA,
        OMEGA,
        TORQUE,
        parameter("moment", "kg.m", 1.0, "mass times distance of its centre from the axis"),
        parameter("lean", "rad", 0.0, "lean of that centre from upright at output angle 0"),
        GRAVITY,
        RATIO,
        OFFSET,
        START[0],
    ),
)
SHANK_LOAD = Part(
    "ShankLoad",
    "Torque with which thigh and gravity swing the shank, the thigh's motion being given",
    ("shank_load.c", "reference.c"),
    (
        THETA,
        OMEGA,
        TORQUE,
        parameter("inertia", "kg.m2", 0.3, "inertia of shank and foot about the knee"),
        parameter("moment", "kg.m", 1.0, "their mass times the distance of its centre from the knee"),
        parameter("lead", "rad", 0.0, "how far that centre is ahead of the shank's axis"),
        GRAVITY,
        *SWING,
        *fourier("thigh", "rad", "inclination of the thigh"),
        *fourier("forward", "m", "knee's way forward"),
        *fourier("upward", "m", "knee's way upward"),
        START[0],
    ),
)
JOINT_CONTROLLER = Part(
    "JointController",
    "Position controller of the robot's elbow",
    ("joint_controller.c", "reference.c"),
    (
        *CONTROLLER,
        INERTIA,
        LIMIT,
        parameter("gain.angle", "1/s2", 0.0, "feedback of the angle's error"),
        parameter("gain.speed", "1/s", 0.0, "feedback of the speed's error"),
        parameter("gain.integral", "1/s3", 0.0, "feedback of the integral of the angle's error"),
        *LOAD_MODEL,
        *BAND_MODEL,
        *MOTION,
        parameter("hold.tolerance", "rad", 0.5e-3, "error of the angle below which it may rest"),
        *REST,
        local_variable("integral", "rad.s", "integral of the angle's error"),
        local_variable("resting", "1", "1 if it rests in the stick band, else 0"),
        *START,
        NEWEST_COMMAND,
    ),
)
DOOR_CONTROLLER = Part(
    "DoorController",
    "Controller of the car door's motor",
    ("door_controller.c", "reference.c"),
    (
        *CONTROLLER,
        INERTIA,
        LIMIT,
        parameter("gain.speed", "1/s", 0.0, "feedback of the speed's error"),
        parameter("gain.distance", "1/s2", 0.0, "feedback of the distance to the profile"),
        *LOAD_MODEL,
        *BAND_MODEL,
        parameter("drag", "N.m.s2/rad2", 0.0, "damper's torque about the hinge over the square of the speed"),
        RATIO,
        OFFSET,
        *MOTION,
        *REST,
        local_variable("distance", "rad", "distance to the profile"),
        *START,
        NEWEST_COMMAND,
    ),
)
KNEE_CONTROLLER = Part(
    "KneeController",
    "Impedance controller of the prosthetic knee",
    ("knee_controller.c", "reference.c"),
    (
        *CONTROLLER,
        parameter("stiffness", "N.m/rad", 100.0, "torque over the angle's error"),
        parameter("damping", "N.m.s/rad", 5.0, "torque over the speed's error"),
        *SWING,
        *fourier("knee", "rad", "flexion of the knee"),
        *START,
        NEWEST_COMMAND,
    ),
)
CLAMP_SERVO = Part(
    "ClampServo",
    "Servo of a spring clamp: position control with feed-forward",
    ("clamp_servo.c", "reference.c"),
    (
        *CONTROLLER,
        parameter("settling", "s", 0.1, "time for which the servo goes on after a move"),
        parameter("bandwidth", "1/s", 60.0, "both poles of the error without friction"),
        INERTIA,
        *BAND_MODEL,
        *MOTION,
        *START,
        NEWEST_COMMAND,
    ),
)
THERMAL_NETWORK = Part(
    "ThermalNetwork",
    "Friction heat of the cam, temperatures of contact zone and housing, and what they do to the grease",
    ("thermal_network.c",),
    (
        input_variable("tau", "N.m", "torque on the cam, constant over a step"),
        THETA,
        OMEGA,
        input_variable("z", "m", "way of the follower"),
        output_variable("stribeck_velocity", "m/s", "Stribeck velocity of the contacts"),
        output_variable("friction_viscous", "s/m", "slope of the lubricated branch"),
        output_variable("temperature.contact", "K", "temperature of the contact zone"),
        output_variable("temperature.housing", "K", "temperature of the housing"),
        output_variable("heat_in", "J", "friction heat so far"),
        output_variable("heat_out", "J", "heat that has gone to the air so far"),
        parameter("period", "s", 1.0, "time between two updates of the temperatures"),
        parameter("capacity.contact", "J/K", 50.0, "heat capacity of the contact zone"),
        parameter("capacity.housing", "J/K", 500.0, "heat capacity of cams and housing"),
        parameter("conductance.contact", "W/K", 0.5, "conductance from the contact zone to the housing"),
        parameter("conductance.air", "W/K", 0.25, "conductance from the housing to the air"),
        parameter("air", "K", 293.15, "temperature of the air, and of both masses at the start"),
        parameter("oil.b", "K", 1000.0, "Vogel's B"),
        parameter("oil.reference", "K", 313.15, "temperature of the two reference values"),
        parameter("oil.span", "K", 135.0, "that temperature less Vogel's C"),
        parameter("reference.stribeck_velocity", "m/s", 0.02, "Stribeck velocity there"),
        parameter("reference.friction_viscous", "s/m", 0.25, "slope of the lubricated branch there"),
        parameter("spring.preload", "N", 50.0, "force of the cam's spring at z = 0"),
        parameter("spring.stiffness", "N/m", 50000.0, "stiffness of the cam's spring"),
        parameter("inertia", "kg.m2", 0.05, "inertia of the cam's shaft"),
        parameter("initial.z", "m", 0.0, "z at the start"),
        *START,
        local_variable("periods", "1", "number of updates so far"),
        local_variable("work", "J", "work of the torque since the last update"),
        local_variable("last_stored", "J", "energy of spring and inertia at the last update"),
        local_variable("last_theta", "rad", "angle at the beginning of the last step"),
        local_variable("last_tau", "N.m", "torque over the last step"),
    ),
)
PARTS = (
    *(MOTOR, PENDULUM_LOAD, SHANK_LOAD, JOINT_CONTROLLER, DOOR_CONTROLLER, KNEE_CONTROLLER),
    *(CLAMP_SERVO, THERMAL_NETWORK),
)
