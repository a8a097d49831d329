"""The section [study] of a design file, a study or an optimisation, checked while the file is read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dualcam.common.mistakes import StudyError, refuse
from dualcam.common.unit_guards import units_checked_before
from dualcam.study.file.study_file import NO_SCENARIO, study_of_design
from dualcam.study.optimisation.file import is_search, task_of_design

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile


def check_section(design: DesignFile) -> None:
    """StudyError with all mistakes of the section, whose design may lack a scenario."""
    try:
        with units_checked_before():  # the study warns when it is made
            (task_of_design if is_search({"study": design.study}) else study_of_design)(design)
    except StudyError as error:
        refuse(text for text in error.problems if not text.endswith(NO_SCENARIO))
