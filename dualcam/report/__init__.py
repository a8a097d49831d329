"""One HTML file about a design: inputs, findings, curves, simulation, energy balance, what lasts.

    write_report      writes the page of a design

May import common, fmi, scenario, design, design_file, simulation, plots, checking.
"""

from dualcam.common.module_calls import explain_call_of
from dualcam.report.page import write_report

__all__ = ["write_report"]

explain_call_of(__name__)
