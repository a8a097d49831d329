"""Systems of FMUs as SSP packages (SSP 1.0), and the package of one design.

    export_ssp        writes the package of a design
    System            components and connections; `save` writes the package
    Component         an FMU with start values
    design_system     the system with the FMU of a design alone

May import common, fmi, design, design_file, checking, export.
"""

from dualcam.common.module_calls import explain_call_of
from dualcam.ssp.package import START, System, design_system, export_ssp
from dualcam.ssp.system_structure import Component, Value

__all__ = ["START", "Component", "System", "Value", "design_system", "export_ssp"]

explain_call_of(__name__)
