"""Grooves of a mechanism to files for a workshop."""

import warnings
from collections.abc import Sequence
from pathlib import Path

from dualcam.design.cut.cam_body import CamBody
from dualcam.design.cut.csv_file import write_csv
from dualcam.design.cut.dxf_file import require_ezdxf, write_dxf
from dualcam.design.cut.groove_cut import GrooveCut
from dualcam.design.cut.solid import require_kernel
from dualcam.design.cut.step_file import write_step
from dualcam.design.mechanism import Mechanism
from dualcam.errors import DesignError, DualcamWarning

ROUNDING = 1e-9  # relative; walls that touch do not overlap
ENDINGS = (".csv", ".dxf", ".step", ".stp")


def export_groove(
    mechanism: Mechanism,
    path: str | Path,
    pin_radius: float,
    *,
    cams: Sequence[int] = (1, 2),
    run_out: float = 0.0,
    loading: str = "counterclockwise",
    depth: float | None = None,
    outer_radius: float | None = None,
    bore_radius: float | None = None,
    length: float | None = None,
) -> tuple[Path, ...]:
    """Write the grooves of a mechanism to files for a workshop.

    Parameters
    ----------
    mechanism : Both grooves and the stops.
    path
        Name of the file; its ending is the format. `.csv`: points of centre line and flanks in space [m],
        which are also a groove table. `.dxf`: drawing of the unwrapped cylinder [mm]. `.step`: solid of the
        cam [mm]. With two cams there are two files: `groove_cam1.dxf` and `groove_cam2.dxf` for `groove.dxf`.
    pin_radius : Radius of the pin [m].
    cams : Which cams: 1, 2 or both.
    run_out, loading : As in `GrooveCut`.
    depth, outer_radius, bore_radius, length : As in `CamBody.around`, for `.step`.

    Returns
    -------
    The files.

    Raises
    ------
    DesignError
        A groove or a body that cannot be made, another ending, or a library that is not installed: `.dxf`
        needs ezdxf, `.step` needs OpenCASCADE (`pip install "dualcam[cad]"` brings both).

    Warns
    -----
    DualcamWarning : Two solids that cannot stand inside one another.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.design import Helix, Mechanism, Spring, export_groove
    >>> helix = Helix(radius=0.02, lead_angle=0.7854)
    >>> mechanism = Mechanism((helix, helix), (0.14, 0.14), Spring(50.0, 5e4), upper=1.3963)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     files = export_groove(mechanism, f"{folder}/groove.csv", pin_radius=0.003)
    >>> [file.name for file in files]
    ['groove_cam1.csv', 'groove_cam2.csv']
    """
    files = groove_files(path, cams)
    ending = Path(path).suffix.lower()
    require_libraries(path)
    cuts = {cam: GrooveCut(mechanism, cam, pin_radius, run_out, loading) for cam in files}
    if write := {".csv": write_csv, ".dxf": write_dxf}.get(ending):
        for cam, file in files.items():
            write(cuts[cam], file)
    else:
        if depth is None:
            raise DesignError(
                f"{path}: a solid needs depth: allowed is the length of the pin on the flank [m]"
            )
        size = {"outer_radius": outer_radius, "bore_radius": bore_radius, "length": length}
        bodies = {cam: CamBody.around(cut, depth, **size) for cam, cut in cuts.items()}
        _warn_of_overlap(list(bodies.values()))
        for cam, file in files.items():
            write_step(cuts[cam], bodies[cam], file)
    return tuple(files.values())


def _warn_of_overlap(bodies: Sequence[CamBody]) -> None:
    if len(bodies) < 2:
        return
    inner, outer = sorted(bodies, key=lambda body: body.outer_radius)
    if inner.outer_radius > outer.bore_radius * (1.0 + ROUNDING):
        walls = [f"{1e3 * body.bore_radius:.6g} to {1e3 * body.outer_radius:.6g} mm" for body in bodies]
        warnings.warn(
            DualcamWarning(
                f"the walls of cam 1 (radius {walls[0]}) and cam 2 (radius {walls[1]}) overlap: the cams"
                " cannot stand inside one another. Give the cams different radii, or a smaller depth"
            ),
            stacklevel=3,
        )


def groove_files(path: str | Path, cams: Sequence[int] = (1, 2)) -> dict[int, Path]:
    """The file of each cam: `groove_cam1.dxf` and `groove_cam2.dxf` for `groove.dxf`, the path itself for one
    cam alone. DesignError for an unknown ending or cam."""
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        raise DesignError(f"{path}: allowed endings are {', '.join(ENDINGS)}")
    if not cams or any(cam not in (1, 2) for cam in cams) or len(set(cams)) != len(cams):
        raise DesignError(f"cams = {cams!r}: allowed are (1,), (2,) and (1, 2)")
    if len(cams) == 1:
        return {cams[0]: path}
    return {cam: path.with_name(f"{path.stem}_cam{cam}{path.suffix}") for cam in cams}


def require_libraries(path: str | Path) -> None:
    """DesignError if the library for a file of this ending is not installed."""
    ending = Path(path).suffix.lower()
    if ending == ".dxf":
        require_ezdxf()
    elif ending in (".step", ".stp"):
        require_kernel()
