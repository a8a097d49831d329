"""Design of the mechanism: the best lead angles, and grooves that give a wanted torque.

    optimum, efficiency, efficiency_map     lead angles and friction
    synthesize                              groove for a wanted torque over angle, as the FMU's table
    propose_spring                          spring with which a wanted torque is possible
    design_groove, TorqueCurve              the same from a file with a torque to a file with the groove
    Mechanism, Spring                       torque of slow motion, reactions, curvature of a pair of grooves
    torque_band                             torque band and efficiency over the whole range
    Helix, Ellipse, Table                   groove laws
    assess, Pin, Limits                     can it be made, does it carry its load
    export_groove, GrooveCut, CamBody       files for a workshop: points, drawing, solid
    dualcam.design.tolerances               what tolerances do to the torque band

Everything here is slow motion without damper, external force and inertia, in SI units. An
impossible design is a DesignError (a ValueError) that names the angle, the value and what is allowed.
"""

from dualcam.design.cut.cam_body import CamBody
from dualcam.design.cut.export import export_groove
from dualcam.design.cut.groove_cut import Curve, Flanks, GrooveCut
from dualcam.design.design import Design
from dualcam.design.grooves import Ellipse, Groove, Helix, Table, curvature
from dualcam.design.mechanism import Mechanism, Spring
from dualcam.design.proposal import SpringProposal
from dualcam.design.statics import (
    DesignError,
    EfficiencyMap,
    Optimum,
    band_factors,
    efficiency,
    efficiency_map,
    optimum,
)
from dualcam.design.strength import Assessment, Finding, Limits, Pin, assess, hertz_pressure
from dualcam.design.synthesis import propose_spring, synthesize
from dualcam.design.torque_band import TorqueBand, torque_band
from dualcam.design.workflow import TorqueCurve, design_groove
from dualcam.module_calls import explain_call_of

__all__ = [
    "Assessment",
    "CamBody",
    "Curve",
    "Design",
    "DesignError",
    "EfficiencyMap",
    "Ellipse",
    "Finding",
    "Flanks",
    "Groove",
    "GrooveCut",
    "Helix",
    "Limits",
    "Mechanism",
    "Optimum",
    "Pin",
    "Spring",
    "SpringProposal",
    "Table",
    "TorqueBand",
    "TorqueCurve",
    "assess",
    "band_factors",
    "curvature",
    "design_groove",
    "efficiency",
    "efficiency_map",
    "export_groove",
    "hertz_pressure",
    "optimum",
    "propose_spring",
    "synthesize",
    "torque_band",
]

explain_call_of(__name__)
