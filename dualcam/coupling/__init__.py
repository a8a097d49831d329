"""An own plant in Python on the shaft of the forward FMU: explicit and implicit coupling, and which of them
is stable.

    PlantCoupling           the FMU with a plant, stepped together
    ShaftMotion             what the plant gets; PlantTorque is such a function
    impedance_of            stiffness, damping and inertia of a plant
    largest_stable_step     of explicit coupling, from these numbers
    reflected_inertia       the inertia of a motor behind its gear

May import common, fmi.
"""

from dualcam.coupling.plant import (
    Impedance,
    LoopStability,
    PlantTorque,
    ShaftMotion,
    cam_of_step,
    impedance_of,
    largest_stable_step,
    reflected_inertia,
    spectral_radius,
)
from dualcam.coupling.plant_coupling import CoupledStep, PlantCoupling, step_difference

__all__ = [
    "CoupledStep",
    "Impedance",
    "LoopStability",
    "PlantCoupling",
    "PlantTorque",
    "ShaftMotion",
    "cam_of_step",
    "impedance_of",
    "largest_stable_step",
    "reflected_inertia",
    "spectral_radius",
    "step_difference",
]
