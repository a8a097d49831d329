"""Where this package's own FMUs are, and the files for a page in a browser."""

from pathlib import Path

from dualcam.errors import FmuError
from dualcam.fmi.binary import library_suffix, platform_tuple

MODELS = {"forward": "DualCamForward", "inverse": "DualCamInverse"}
PACKAGE = Path(__file__).resolve().parents[1]


def fmu_path(kind: str, fmi: int = 2) -> Path:
    """Path of one of this package's FMUs: inside the installed package, or in the build folder of a checkout.

    `kind`: "forward": torque in, motion out; "inverse": motion in, torque out. `fmi`: version, 2 or 3.
    FmuError for anything else, and where a checkout has not been built yet.

    Examples
    --------
    >>> import dualcam
    >>> dualcam.fmu_path("inverse").name
    'DualCamInverse.fmu'
    """
    if not isinstance(kind, str) or kind not in MODELS:
        raise FmuError(f"fmu_path(kind={kind!r}): allowed are {', '.join(map(repr, MODELS))}")
    if type(fmi) is not int or fmi not in (2, 3):
        raise FmuError(f"fmu_path(fmi={fmi!r}): allowed are 2 (FMI 2.0) and 3 (FMI 3.0)")
    folders = f"fmus/fmi{fmi}", "build" if fmi == 2 else "build/fmi3"
    return _found(
        f"{MODELS[kind]}.fmu",
        folders,
        f" of FMI {fmi}.0",
        "which makes the FMUs in build/; an installed package has the FMUs inside: install the package again",
    )


def fleet_library_path() -> Path:
    """Path of the library of `dualcam.Fleet` for the running Python. FmuError where there is none."""
    platform = platform_tuple()
    return _found(
        f"{platform}/dualcam_fleet{library_suffix()}",
        ("fleet/lib", "build/fleet"),
        f", the library of dualcam.Fleet for {platform},",
        "which makes the library; an installed package has"
        " those for Linux (x86-64, aarch64), Windows (64 and 32 bits) and macOS",
    )


def web_path(name: str) -> Path:
    """The file "DualCamForward.wasm" or "DualCamInverse.wasm", the folder "three", or a file in it."""
    if not isinstance(name, str) or not name:
        raise FmuError(f"web_path(name={name!r}): allowed is the name of a file or folder, such as 'three'")
    return _found(
        name,
        ("web", "build/web"),
        "",
        "which makes build/web and warns where three.js cannot be downloaded;"
        " an installed package has the files inside: install the package again",
    )


def _found(name: str, folders: tuple[str, str], what: str, remedy: str) -> Path:
    """`name` in a folder of the installed package, or of a checkout. FmuError where it is in none."""
    places = [root / folder / name for root, folder in zip((PACKAGE, PACKAGE.parent), folders, strict=True)]
    for path in places:
        if path.exists():
            return path
    looked = " and ".join(map(str, places))
    raise FmuError(f"{name}{what} is missing: looked for {looked}. In a checkout run ./build.sh, {remedy}")


def source_path(source: str | Path, fmi: int | None = None) -> Path:
    """The file behind a path, or behind "forward" or "inverse", then of FMI `fmi` (None: 2). FmuError for
    anything else."""
    if not isinstance(source, str | Path):
        raise FmuError(
            f"FMU {source!r}: allowed are {', '.join(map(repr, MODELS))}, or the path of an FMU (str or Path)"
        )
    if isinstance(source, str) and source in MODELS:
        return fmu_path(source, 2 if fmi is None else fmi)
    return Path(source)
