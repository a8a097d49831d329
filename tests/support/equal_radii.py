"""The smallest template with cams of one radius, the defaults of the FMU."""

import re
from pathlib import Path

from dualcam.design_file import write_template


def write_equal_radii(path: Path) -> Path:
    """Writes the template `minimal` with both radii 20 mm: the grooves are equal."""
    write_template("minimal", path)
    path.write_text(re.sub(r'radius = "(15|30) mm"', 'radius = "20 mm"', path.read_text(encoding="utf-8")))
    return path
