"""The spring clamp as a system of FMUs: the cam, its servo, and a thermal network that warms the grease.

    servo --command--> cam --theta, omega--> servo
    servo (command), cam (theta, omega, z) --> thermal
    thermal --stribeck_velocity, friction_viscous--> tunable parameters of the cam

The thermal network is an FMU of its own. It gets the friction heat from the energy balance of the cam, and so
needs no more than outputs of the cam. The way back ends at connectors of the kind "parameter".
"""

from __future__ import annotations

from dualcam.ssp import Component
from dualcam.systems.blocks.grease import REFERENCE
from dualcam.systems.machines import clamp
from dualcam.systems.machines.clamp import GREASE, HALL, MOTION, NETWORK
from system_examples.ssp import parts
from system_examples.ssp.components import band_values, cam_component, motion_values
from system_examples.ssp.package import ExampleSystem

MOTION_CONNECTIONS = (
    ("servo.command", "cam.tau"),
    ("cam.theta", "servo.theta"),
    ("cam.omega", "servo.omega"),
    ("servo.command", "thermal.tau"),
    ("cam.theta", "thermal.theta"),
    ("cam.omega", "thermal.omega"),
    ("cam.z", "thermal.z"),
)
FRICTION_CONNECTIONS = tuple(
    (f"thermal.{name}", f"cam.cam{i}.{name}") for i in (1, 2) for name in clamp.TUNED
)
WATCHED = (
    "cam.theta",
    "servo.command",
    "thermal.temperature.contact",
    "thermal.temperature.housing",
    "thermal.heat_in",
    "thermal.heat_out",
    "cam.energy.heat_cam1",
    "cam.energy.heat_cam2",
)


def servo_component() -> Component:
    """The servo with its start values."""
    servo = clamp.Servo()
    values = {
        "tick": clamp.SAMPLE,
        "settling": clamp.SETTLING,
        "bandwidth": servo.bandwidth,
        "inertia": clamp.INERTIA,
        **band_values(servo.cam),
        **motion_values(MOTION),
        "initial.theta": MOTION.start,
    }
    return Component("servo", parts.CLAMP_SERVO.path, values)


def thermal_component() -> Component:
    """The thermal network with its start values."""
    _, b, c = GREASE.oil.vogel
    values = {
        "period": MOTION.period,
        "capacity.contact": NETWORK.contact_capacity,
        "capacity.housing": NETWORK.housing_capacity,
        "conductance.contact": NETWORK.contact_conductance,
        "conductance.air": NETWORK.air_conductance,
        "air": NETWORK.air,
        "oil.b": b,
        "oil.reference": REFERENCE,
        "oil.span": REFERENCE - c,
        "reference.stribeck_velocity": GREASE.stribeck_velocity,
        "reference.friction_viscous": GREASE.viscous,
        "spring.preload": clamp.PRELOAD,
        "spring.stiffness": clamp.STIFFNESS,
        "inertia": clamp.INERTIA,
        "initial.theta": MOTION.start,
    }
    return Component("thermal", parts.THERMAL_NETWORK.path, values)


def clamp_system(cycles: int, *, parameter_connections: bool = True) -> ExampleSystem:
    """The package of a number of cycles, with or without the connections to the cam's parameters."""
    components = (
        cam_component(clamp.plant_parameters(HALL), MOTION.start),
        servo_component(),
        thermal_component(),
    )
    connections = MOTION_CONNECTIONS + (FRICTION_CONNECTIONS if parameter_connections else ())
    name = "spring_clamp" if parameter_connections else "spring_clamp_script"
    text = "spring clamp in a cold hall, whose grease warms up"
    return ExampleSystem(name, text, components, connections, clamp.SAMPLE, cycles * MOTION.period)
