"""The section [study] of a design file, a study or an optimisation, checked while the file is read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dualcam.study.optimisation.reading import check_search_section, is_search
from dualcam.study.reading import study_file

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile


def check_section(design: DesignFile, is_scenario_refused: bool) -> None:
    """StudyError with all mistakes of the section."""
    check = check_search_section if is_search({"study": design.study}) else study_file.check_section
    check(design, is_scenario_refused)
