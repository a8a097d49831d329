"""Where the FMUs of this project are: in the installed package, else in the build folder of a checkout."""

from __future__ import annotations

from pathlib import Path

from dualcam.errors import FmuError

MODELS = {"forward": "DualCamForward", "inverse": "DualCamInverse"}
PACKAGE = Path(__file__).resolve().parent


def fmu_path(model: str, fmi: int = 2) -> Path:
    """The path of one of the project's FMUs.

    Parameters
    ----------
    model
        "forward" (torque in, motion out) or "inverse" (motion in, torque out).
    fmi
        Version of FMI, 2 or 3.

    Returns
    -------
    Path
        An existing file.

    Raises
    ------
    FmuError
        Another word or number, or an FMU that has not been built.

    Examples
    --------
    >>> from dualcam.library import fmu_path
    >>> fmu_path("forward").name
    'DualCamForward.fmu'
    """
    if model not in MODELS:
        raise FmuError(f"model {model!r}: allowed are {', '.join(MODELS)}")
    if fmi not in (2, 3):
        raise FmuError(f"fmi = {fmi!r}: allowed are 2 and 3")
    name = f"{MODELS[model]}.fmu"
    build = PACKAGE.parent / "build"
    candidates = (PACKAGE / "fmus" / f"fmi{fmi}" / name, (build if fmi == 2 else build / "fmi3") / name)
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise FmuError(f"{name} of FMI {fmi}.0 is missing in {build}: build the FMUs by ./build.sh")
