"""The parts of the example systems that are not the cam, as FMUs: FMI 2.0 co-simulation, in C (ssp/).

Here is the one list of each part's variables. It becomes part_variables.h, which the C code reads, and
modelDescription.xml; the FMUs are compiled like the cam's, by the functions of build_fmu.py, into
build/ssp/parts.
"""

from __future__ import annotations

import hashlib
import sys
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "system_examples/ssp"
sys.path.insert(0, str(ROOT / "fmu_src/tools"))
import build_fmu  # noqa: E402

FOLDER = build_fmu.BUILD / "ssp/parts"
HARMONICS = 7  # as in reference.h

# Exponents of the base units: kg, m, s, A, rad
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
}

PARAMETER, INPUT, OUTPUT, LOCAL = "parameter", "input", "output", "local"


@dataclass(frozen=True)
class Variable:
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
    return Variable(name, PARAMETER, unit, start, text)


def reads(name: str, unit: str, text: str) -> Variable:
    return Variable(name, INPUT, unit, 0.0, text)


def gives(name: str, unit: str, text: str) -> Variable:
    return Variable(name, OUTPUT, unit, 0.0, text)


def keeps(name: str, unit: str, text: str) -> Variable:
    return Variable(name, LOCAL, unit, 0.0, text)


THETA = reads("theta", "rad", "angle of the cam")
OMEGA = reads("omega", "rad/s", "speed of the cam")
RATIO = parameter("ratio", "1", 1.0, "angle of the cam over that of the output")
OFFSET = parameter("offset", "rad", 0.0, "angle of the output at theta = 0")
COMMAND = gives("command", "N.m", "torque asked of the motor, about the output")
REFERENCE = gives("reference", "rad", "planned angle of the output")
NEWEST = keeps("newest", "1", "number of the newest tick whose command has been computed")
START = (
    parameter("initial.theta", "rad", 0.0, "theta at the start"),
    parameter("initial.omega", "rad/s", 0.0, "omega at the start"),
)
TICKING = (THETA, OMEGA, COMMAND, REFERENCE, parameter("tick", "s", 1e-3, "time between two commands"))
LIMIT = parameter("limit", "N.m", 12.0, "largest torque to ask for")
INERTIA = parameter("inertia", "kg.m2", 0.2, "believed inertia of the output, rotor included")
GRAVITY = parameter("gravity", "m/s2", 9.81, "gravity")
TORQUE = gives("torque", "N.m", "torque about the output")

MOTION = (
    parameter("motion.start", "rad", 0.0, "where the cycle begins and ends"),
    parameter("motion.end", "rad", 1.0, "where it turns"),
    parameter("motion.move", "s", 1.0, "duration of one move"),
    parameter("motion.dwell", "s", 1.0, "duration of one rest"),
)
BAND = (
    parameter("band.release", "N.m", 0.0, "believed torque of the cam that just releases, at theta = 0"),
    parameter("band.release_rise", "N.m/rad", 0.0, "its rise over theta"),
    parameter("band.load", "N.m", 0.0, "believed torque of the cam that just loads, at theta = 0"),
    parameter("band.load_rise", "N.m/rad", 0.0, "its rise over theta"),
)
BELIEVED_LOAD = (
    parameter("load.moment", "kg.m", 0.0, "believed mass times distance of its centre from the axis"),
    parameter("load.lean", "rad", 0.0, "lean of that centre from upright at output angle 0"),
    parameter("load.gravity", "m/s2", 9.81, "gravity"),
)
HOLD = (
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


def path_of(identifier: str) -> Path:
    return FOLDER / f"{identifier}.fmu"


@dataclass(frozen=True)
class Part:
    """An FMU made from C files in ssp/ and a list of variables."""

    identifier: str
    text: str
    sources: tuple[str, ...]
    variables: tuple[Variable, ...]

    @property
    def path(self) -> Path:
        return path_of(self.identifier)


MOTOR = Part(
    "Motor",
    "Geared brushless motor under a PI current loop; adds the load's torque to its own",
    ("motor.c",),
    (
        reads("command", "N.m", "torque asked for, about the output"),
        OMEGA,
        reads("load", "N.m", "torque of the load about the output"),
        gives("tau", "N.m", "torque of motor and load at the cam, mean over the last step"),
        gives("torque", "N.m", "torque of the motor about the output, mean over the last step"),
        gives("current", "A", "current in the winding"),
        gives("heat", "J", "heat in the winding since the start"),
        gives("energy", "J", "energy drawn from the supply since the start"),
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
        keeps("current.integral", "V", "integral part of the current loop"),
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
        *TICKING,
        INERTIA,
        LIMIT,
        parameter("gain.angle", "1/s2", 0.0, "feedback of the angle's error"),
        parameter("gain.speed", "1/s", 0.0, "feedback of the speed's error"),
        parameter("gain.integral", "1/s3", 0.0, "feedback of the integral of the angle's error"),
        *BELIEVED_LOAD,
        *BAND,
        *MOTION,
        parameter("hold.tolerance", "rad", 0.5e-3, "error of the angle below which it may rest"),
        *HOLD,
        keeps("integral", "rad.s", "integral of the angle's error"),
        keeps("resting", "1", "1 if it rests in the stick band, else 0"),
        *START,
        NEWEST,
    ),
)
DOOR_CONTROLLER = Part(
    "DoorController",
    "Controller of the car door's motor",
    ("door_controller.c", "reference.c"),
    (
        *TICKING,
        INERTIA,
        LIMIT,
        parameter("gain.speed", "1/s", 0.0, "feedback of the speed's error"),
        parameter("gain.distance", "1/s2", 0.0, "feedback of the distance to the profile"),
        *BELIEVED_LOAD,
        *BAND,
        parameter("drag", "N.m.s2/rad2", 0.0, "damper's torque about the hinge over the square of the speed"),
        RATIO,
        OFFSET,
        *MOTION,
        *HOLD,
        keeps("distance", "rad", "distance to the profile"),
        *START,
        NEWEST,
    ),
)
KNEE_CONTROLLER = Part(
    "KneeController",
    "Impedance controller of the prosthetic knee",
    ("knee_controller.c", "reference.c"),
    (
        *TICKING,
        parameter("stiffness", "N.m/rad", 100.0, "torque over the angle's error"),
        parameter("damping", "N.m.s/rad", 5.0, "torque over the speed's error"),
        *SWING,
        *fourier("knee", "rad", "flexion of the knee"),
        *START,
        NEWEST,
    ),
)
PARTS = (MOTOR, PENDULUM_LOAD, SHANK_LOAD, JOINT_CONTROLLER, DOOR_CONTROLLER, KNEE_CONTROLLER)


def header(part: Part) -> str:
    """part_variables.h. Only fmi2.c, which has defined Variable, sees the list of names."""
    names = "".join(f"    {v.constant},\n" for v in part.variables)
    rows = "".join(f'    {{"{v.name}", {v.causality.upper()}, {v.start!r}}},\n' for v in part.variables)
    return (
        "/* Written by ssp_parts.py. */\n"
        f"enum {{\n{names}    VARIABLE_COUNT\n}};\n"
        "#ifdef LIST_VARIABLES\n"
        f"static const Variable VARIABLES[VARIABLE_COUNT] = {{\n{rows}}};\n"
        "#endif\n"
    )


def description(part: Part, guid: str) -> str:
    """modelDescription.xml."""
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=part.identifier,
        guid=guid,
        description=part.text,
        license="BSD-2-Clause",
        generationTool="ssp_parts.py",
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=part.identifier,
        canHandleVariableCommunicationStepSize="true",
        canNotUseMemoryManagementFunctions="true",
    )
    units = ET.SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in part.variables}):
        base = {name: str(exponent) for name, exponent in UNITS[unit].items()}
        ET.SubElement(ET.SubElement(units, "Unit", name=unit), "BaseUnit", base)
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError")
    ET.SubElement(root, "DefaultExperiment", startTime="0", stepSize="5e-05")
    variables = ET.SubElement(root, "ModelVariables")
    for reference, v in enumerate(part.variables):
        facts = {"name": v.name, "valueReference": str(reference), "description": v.text}
        facts |= {"causality": v.causality}
        facts |= {"variability": "fixed" if v.causality == PARAMETER else "continuous"}
        real = {"unit": v.unit}
        if v.causality == OUTPUT:
            facts["initial"] = "calculated"
        elif v.causality == LOCAL:
            facts |= {"initial": "calculated", "variability": "discrete"}
        else:
            real["start"] = repr(v.start)
        if v.causality == PARAMETER:
            facts["initial"] = "exact"
        ET.SubElement(ET.SubElement(variables, "ScalarVariable", facts), "Real", real)
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [str(i) for i, v in enumerate(part.variables, start=1) if v.causality == OUTPUT]
    for name in ("Outputs", "InitialUnknowns"):
        unknowns = ET.SubElement(structure, name)
        for index in outputs:
            ET.SubElement(unknowns, "Unknown", index=index)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


@dataclass(frozen=True)
class PartFmu(build_fmu.Fmu):
    """A part as build_fmu.py builds it, elsewhere than the FMUs of the cam."""

    @property
    def path(self) -> Path:
        return path_of(self.identifier)


def fmu(part: Part) -> PartFmu:
    """The part, its header written. All that a binary is made of and that is no C file is in the GUID."""
    sources = [SOURCES / name for name in ("fmi2.c", *part.sources)]
    variables = header(part)
    headers = [*sorted(SOURCES.glob("*.h")), build_fmu.BARE / "incapable.h"]
    included = [path.read_text() for path in headers]
    guid = hashlib.sha256("\0".join([description(part, ""), variables, *included]).encode()).hexdigest()[:32]
    folder = FOLDER / "include" / part.identifier
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "part_variables.h").write_text(variables)
    return PartFmu(
        part.identifier,
        sources,
        description(part, guid),
        guid,
        {"documentation/licenses/license.txt": ROOT / "LICENSE"},
        defines=[f"-I{build_fmu.relative(folder)}"],
    )


def build() -> None:
    """Builds what is not there or not fresh."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with build_fmu.locked():
        for part in PARTS:
            build_fmu.build(fmu(part))
