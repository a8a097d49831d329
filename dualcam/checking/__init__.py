"""One verdict on a design: can it be made, does it carry its load, and does its FMU start?

check_design      all findings about a design file, each with the nearest value that works
Verdict           the findings, and whether the design is good

May import common, fmi, design, scenario, design_file.
"""

from dualcam.checking.verdict import Verdict, check_design

__all__ = ["Verdict", "check_design"]
