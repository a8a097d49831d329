"""Units of the parts, and variables that several parts have in common."""

from __future__ import annotations

from dataclasses import dataclass

HARMONICS = 7  # as in reference.h

# Exponents of the base units: kg, m, s, A, K, rad
UNITS = {
    "1": {},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "N.m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1},
    "N.m.s/rad": {"kg": 1, "m": 2, "s": -1, "rad": -1},
    "N.m.s2/rad2": {"kg": 1, "m": 2, "rad": -2},
    "N.m/A": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "kg.m": {"kg": 1, "m": 1},
    "kg.m2": {"kg": 1, "m": 2},
    "m": {"m": 1},
    "m/s2": {"m": 1, "s": -2},
    "s": {"s": 1},
    "1/s": {"s": -1},
    "1/s2": {"s": -2},
    "1/s3": {"s": -3},
    "rad.s": {"rad": 1, "s": 1},
    "Hz": {"s": -1},
    "ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "A": {"A": 1},
    "J": {"kg": 1, "m": 2, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N/m": {"kg": 1, "s": -2},
    "m/s": {"m": 1, "s": -1},
    "s/m": {"m": -1, "s": 1},
    "K": {"K": 1},
    "J/K": {"kg": 1, "m": 2, "s": -2, "K": -1},
    "W/K": {"kg": 1, "m": 2, "s": -3, "K": -1},
}

PARAMETER, INPUT, OUTPUT, LOCAL = "parameter", "input", "output", "local"


@dataclass(frozen=True)
class Variable:
    """A variable of a part."""

    name: str
    causality: str
    unit: str
    start: float
    text: str

    @property
    def constant(self) -> str:
        """Its name in C."""
        return self.name.upper().replace(".", "_")


def parameter(name: str, unit: str, start: float, text: str) -> Variable:
    """A parameter with its start value."""
    return Variable(name, PARAMETER, unit, start, text)


def input_variable(name: str, unit: str, text: str) -> Variable:
    """An input, 0 at the start."""
    return Variable(name, INPUT, unit, 0.0, text)


def output_variable(name: str, unit: str, text: str) -> Variable:
    """An output."""
    return Variable(name, OUTPUT, unit, 0.0, text)


def local_variable(name: str, unit: str, text: str) -> Variable:
    """A local variable, which keeps its value between steps."""
    return Variable(name, LOCAL, unit, 0.0, text)


THETA = input_variable("theta", "rad", "angle of the cam")
OMEGA = input_variable("omega", "rad/s", "speed of the cam")
RATIO = parameter("ratio", "1", 1.0, "angle of the cam over that of the output")
OFFSET = parameter("offset", "rad", 0.0, "angle of the output at theta = 0")
COMMAND = output_variable("command", "N.m", "torque asked of the motor, about the output")
REFERENCE = output_variable("reference", "rad", "planned angle of the output")
NEWEST_COMMAND = local_variable("newest", "1", "number of the newest tick whose command has been computed")
START = (
    parameter("initial.theta", "rad", 0.0, "theta at the start"),
    parameter("initial.omega", "rad/s", 0.0, "omega at the start"),
)
CONTROLLER = (THETA, OMEGA, COMMAND, REFERENCE, parameter("tick", "s", 1e-3, "time between two commands"))
LIMIT = parameter("limit", "N.m", 12.0, "largest torque to ask for")
INERTIA = parameter("inertia", "kg.m2", 0.2, "believed inertia of the output, rotor included")
GRAVITY = parameter("gravity", "m/s2", 9.81, "gravity")
TORQUE = output_variable("torque", "N.m", "torque about the output")

MOTION = (
    parameter("motion.start", "rad", 0.0, "where the cycle begins and ends"),
    parameter("motion.end", "rad", 1.0, "where it turns"),
    parameter("motion.move", "s", 1.0, "duration of one move"),
    parameter("motion.dwell", "s", 1.0, "duration of one rest"),
)
BAND_MODEL = (
    parameter("band.release", "N.m", 0.0, "believed torque of the cam that just releases, at theta = 0"),
    parameter("band.release_rise", "N.m/rad", 0.0, "its rise over theta"),
    parameter("band.load", "N.m", 0.0, "believed torque of the cam that just loads, at theta = 0"),
    parameter("band.load_rise", "N.m/rad", 0.0, "its rise over theta"),
)
LOAD_MODEL = (
    parameter("load.moment", "kg.m", 0.0, "believed mass times distance of its centre from the axis"),
    parameter("load.lean", "rad", 0.0, "lean of that centre from upright at output angle 0"),
    parameter("load.gravity", "m/s2", 9.81, "gravity"),
)
REST = (
    parameter("hold.speed", "rad/s", 5e-3, "speed below which it may rest"),
    parameter(
        "hold.margin", "1", 0.1, "share of the stick band kept between a held load and the band's edge"
    ),
)


def fourier(name: str, unit: str, text: str) -> tuple[Variable, ...]:
    """Coefficients of a series, in the order in which the C code reads them."""
    rows = [parameter(f"{name}.mean", unit, 0.0, f"{text}: mean")]
    for n in range(1, HARMONICS + 1):
        rows.append(parameter(f"{name}.cos{n}", unit, 0.0, f"{text}: cosine of harmonic {n}"))
        rows.append(parameter(f"{name}.sin{n}", unit, 0.0, f"{text}: sine of harmonic {n}"))
    return tuple(rows)


SWING = (
    parameter("stride", "s", 1.0, "duration of a stride"),
    parameter("toe_off", "s", 0.65, "time from heel strike to toe-off, where the swing begins"),
    parameter("extension", "rad", 0.0, "knee flexion at theta = 0"),
)
