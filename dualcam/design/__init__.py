"""Design of the mechanism: the best lead angles, and grooves that give a wanted torque.

    optimum, efficiency, efficiency_map     lead angles and friction
    synthesize                              groove for a wanted torque over angle, as the FMU's table
    propose_spring                          spring with which a wanted torque is possible
    design_groove, TorqueCurve              the same from a file with a torque to a file with the groove
    Mechanism, Spring                       torque of slow motion, reactions, curvature of a pair of grooves
    torque_band                             torque band and efficiency over the whole range
    Helix, Ellipse, Table, Cycloid          groove laws
    assess, Pin, Limits                     can it be made, does it carry its load
    line_contact, Roller, wear              pressure and shear stress, roller, wear and what wear changes
    HelicalSpring, find_springs             stress and fatigue of the spring, search in standard wires
    export_groove, GrooveCut, CamBody       files for a workshop: points, drawing, solid
    dualcam.design.tolerances               what tolerances do to the torque band

Everything here is slow motion without damper, external force and inertia, in SI units. An impossible design
is a dualcam.errors.DesignError (a ValueError) that names the angle, the value and what is allowed.

May import common, fmi.
"""

from typing import TYPE_CHECKING

from dualcam.common.module_calls import explain_call_of
from dualcam.common.moved import old_names
from dualcam.design.band import TorqueBand, torque_band
from dualcam.design.cut.cam_body import CamBody
from dualcam.design.cut.export import export_groove
from dualcam.design.cut.groove_cut import Curve, Flanks, GrooveCut
from dualcam.design.design import Design
from dualcam.design.groove_wear import Wear, WearLife, WornMechanism, wear
from dualcam.design.grooves import Cycloid, Ellipse, Groove, Helix, Table, curvature
from dualcam.design.helical_spring import Fatigue, HelicalSpring
from dualcam.design.hertz import LineContact, Pin, hertz_pressure, line_contact, relative_radius, shear_below
from dualcam.design.mechanism import Mechanism, Spring
from dualcam.design.proposal import SpringProposal
from dualcam.design.roller import Roller
from dualcam.design.spring_search import find_springs
from dualcam.design.spring_steel import tensile_strength
from dualcam.design.statics import (
    BestLeadAngles,
    EfficiencyMap,
    band_factors,
    efficiency,
    efficiency_map,
    optimum,
)
from dualcam.design.strength import Assessment, Limits, LimitViolation, assess
from dualcam.design.synthesis import propose_spring, synthesize
from dualcam.design.workflow import TorqueCurve, design_groove

__all__ = [
    "Assessment",
    "BestLeadAngles",
    "CamBody",
    "Curve",
    "Cycloid",
    "Design",
    "EfficiencyMap",
    "Ellipse",
    "Fatigue",
    "Flanks",
    "Groove",
    "GrooveCut",
    "HelicalSpring",
    "Helix",
    "LimitViolation",
    "Limits",
    "LineContact",
    "Mechanism",
    "Pin",
    "Roller",
    "Spring",
    "SpringProposal",
    "Table",
    "TorqueBand",
    "TorqueCurve",
    "Wear",
    "WearLife",
    "WornMechanism",
    "assess",
    "band_factors",
    "curvature",
    "design_groove",
    "efficiency",
    "efficiency_map",
    "export_groove",
    "find_springs",
    "hertz_pressure",
    "line_contact",
    "optimum",
    "propose_spring",
    "relative_radius",
    "shear_below",
    "synthesize",
    "tensile_strength",
    "torque_band",
    "wear",
]

explain_call_of(__name__)

if not TYPE_CHECKING:  # type checkers report the old names
    __getattr__ = old_names(
        __name__,
        {"DesignError": "errors.DesignError", "Finding": "LimitViolation", "Optimum": "BestLeadAngles"},
    )
