"""The page in which a design lives: one HTML file with the FMU's C code as WebAssembly.

    write_view      writes the page of a design

Modules of the page: app.js starts the page, player.js is the clock, engine.js calls the FMU's functions.

May import common, fmi, design_file, export.
"""

from dualcam.common.module_calls import explain_call_of
from dualcam.view.page import view_page, write_view

__all__ = ["view_page", "write_view"]

explain_call_of(__name__)
