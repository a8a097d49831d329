"""The section [study] of a design file, a study or an optimisation, checked while the file is read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dualcam.study.file import study_file
from dualcam.study.optimisation.file import check_search_section, is_search

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile


def check_section(design: DesignFile) -> None:
    """StudyError with all mistakes of the section."""
    check = check_search_section if is_search({"study": design.study}) else study_file.check_section
    check(design)
