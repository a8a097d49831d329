"""FMUs of own designs: own name, GUID, start values, tables, documentation and reference result.

    export_fmu          makes the FMU of a design from the project's FMU, for all its platforms
    model_identifier    the C identifier of an FMU with that name

No compiler is needed. Start values edited in a modelDescription.xml do nothing by themselves: an FMU starts
from the values in its binary. The export writes both.

May import common, fmi, scenario, design_file, plots.
"""

from typing import TYPE_CHECKING

from dualcam.common.module_calls import explain_call_of
from dualcam.common.moved import old_names
from dualcam.export.description import model_identifier
from dualcam.export.exporter import ExportableDesign, export_fmu

__all__ = ["ExportableDesign", "export_fmu", "model_identifier"]

explain_call_of(__name__)

if not TYPE_CHECKING:  # type checkers report the old names
    __getattr__ = old_names(__name__, {"Design": "ExportableDesign", "ExportError": "errors.ExportError"})
