"""Draws docs/cut_grooves.png for docs/cut-grooves.md: both solids of the prosthetic knee, the unwrapped
grooves, and the error of the plain parallel curve.

Run by `./build.sh run cad`, since the solids need the CAD kernel. The solids are read from STEP files."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from dualcam import read_design
from dualcam.design import GrooveCut, Helix, Mechanism, Pin, Spring, export_groove
from dualcam.design.cut.pin_section import section
from dualcam.design.statics import Array
from dualcam.design_file import write_template

MM = 1e3  # per metre
CAM_COLORS = ("#b08a4f", "#5b8dc9")
PIN_COLOR, INK = "#b5202b", "#222222"
ELEVATION, AZIMUTH = 24.0, 15.0  # deg, of the eye; the azimuth is that of cam 1, and minus that of cam 2


def knee() -> tuple[Mechanism, Pin]:
    """The design that `dualcam new --from knee` writes."""
    with TemporaryDirectory() as folder:
        design = read_design(write_template("knee", Path(folder) / "knee.toml"))
    assert design.pin is not None
    return design.mechanism(), design.pin


def triangles(path: Path) -> Array:
    """Triangles of the solid in a STEP file [mm], shape (n, 3, 3)."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    shape = reader.OneShape()
    BRepMesh_IncrementalMesh(shape, 0.02, False, 0.08)
    faces, found = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_FACE), []
    while faces.More():
        face = TopoDS.Face(faces.Current())
        mesh = BRep_Tool.Triangulation_s(face, TopLoc_Location())
        for k in range(1, mesh.NbTriangles() + 1):
            corners = [mesh.Node(n) for n in mesh.Triangle(k).Get()]
            if face.Orientation().name == "TopAbs_REVERSED":
                corners.reverse()
            found.append([(corner.X(), corner.Y(), corner.Z()) for corner in corners])
        faces.Next()
    return np.array(found)


def toward(azimuth: float, elevation: float) -> Array:
    """Unit vector; angles in deg."""
    a, e = math.radians(azimuth), math.radians(elevation)
    return np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])


def draw_solid(axes: Axes, corners: Array, color: str, azimuth: float, title: str) -> None:
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    faces_the_eye = normal @ toward(azimuth, ELEVATION) > 0.0
    corners, normal = corners[faces_the_eye], normal[faces_the_eye]
    shade = 0.35 + 0.65 * np.clip(normal @ toward(azimuth - 40.0, 35.0), 0.0, 1.0)
    colors = np.clip(shade[:, None] * np.array(mpl.colors.to_rgb(color)) * 1.25, 0.0, 1.0)
    axes.add_collection3d(Poly3DCollection(corners, facecolors=colors, edgecolors=colors, linewidths=0.3))
    low, high = corners.reshape(-1, 3).min(axis=0), corners.reshape(-1, 3).max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.3)
    axes.view_init(elev=ELEVATION, azim=azimuth)
    axes.set_axis_off()
    axes.set_title(title, fontsize=12, y=0.98)


def draw_unwrapped(axes: Axes, cut: GrooveCut, color: str) -> None:
    psi = np.linspace(cut.begin, cut.end, 400)
    flanks, scale = cut.flanks(psi), MM * cut.radius * cut.hand
    share = np.linspace(0.0, 1.0, 60)
    ends = [cut.round_end(at_end, share) for at_end in (True, False)]
    outline = [
        flanks.upper,
        ends[0],
        type(ends[0])(flanks.lower.psi[::-1], flanks.lower.z[::-1]),
        type(ends[1])(ends[1].psi[::-1], ends[1].z[::-1]),
    ]
    x = scale * np.concatenate([curve.psi for curve in outline])
    axes.fill(x, MM * np.concatenate([curve.z for curve in outline]), color=color, alpha=0.25, lw=0)
    axes.plot(scale * flanks.upper.psi, MM * flanks.upper.z, color=color, lw=2.2)
    axes.plot(scale * flanks.lower.psi, MM * flanks.lower.z, color=color, lw=2.2, ls=(0, (4, 1.5)))
    for end in ends:
        axes.plot(scale * end.psi, MM * end.z, color=color, lw=1.2)
    axes.plot(scale * psi, MM * cut.centre(psi).z, color=INK, lw=1.0, ls=(0, (10, 3, 2, 3)))
    stops = cut.stops()
    axes.plot(scale * stops.psi, MM * stops.z, "+", color=INK, ms=11)
    edge = section(np.linspace(0.0, 2.0 * math.pi, 100), cut.pin_radius, cut.radius)
    for place in np.linspace(*cut.travel, 3):
        height = float(cut.centre(place).z)
        axes.plot(scale * (place + edge.angle), MM * (height + edge.height), color=PIN_COLOR, lw=1.2)


def draw_both_unwrapped(axes: Axes, cuts: list[GrooveCut]) -> None:
    for cut, color in zip(cuts, CAM_COLORS, strict=True):
        draw_unwrapped(axes, cut, color)
    axes.set_aspect("equal")
    axes.set_xlabel("along the circumference, seen from outside [mm]")
    axes.set_ylabel("z [mm]")
    axes.set_title("Unwrapped grooves: cam 1 right-handed, cam 2 left-handed", fontsize=12)
    handles = [
        mpl.lines.Line2D([], [], color=INK, lw=1.0, ls=(0, (10, 3, 2, 3)), label="path of the pin's axis"),
        mpl.lines.Line2D([], [], color=CAM_COLORS[0], lw=2.2, label="upper flank"),
        mpl.lines.Line2D(
            [], [], color=CAM_COLORS[0], lw=2.2, ls=(0, (4, 1.5)), label="lower flank, carries the spring"
        ),
        mpl.lines.Line2D([], [], color=PIN_COLOR, lw=1.2, label="pin"),
        mpl.lines.Line2D([], [], color=INK, marker="+", ms=11, lw=0, label="axis of the pin at the stops"),
    ]
    axes.legend(handles=handles, fontsize=9, loc="lower center", ncols=2)
    axes.set(xlim=(-24.0, 24.0), ylim=(-19.0, 17.0))


def parallel_error(lead: float, pin_over_radius: float) -> float:
    """Distance between the flank and the parallel curve of a helix, as a share of the pin's radius."""
    groove = Helix(1.0, lead)
    cut = GrooveCut(Mechanism((groove, groove), (0.1, 0.1), Spring(1.0, 1e3), 0.2), 1, pin_over_radius)
    flank = cut.flanks(0.0).upper
    across = -math.sin(lead) * float(flank.psi) + math.cos(lead) * float(flank.z)
    return across / pin_over_radius - 1.0


def draw_parallel_error(axes: Axes) -> None:
    """Of pins in a cam of radius 20 mm."""
    leads = np.radians(np.linspace(2.0, 85.0, 84))
    for pin, shade in ((2.0, "#9db8d9"), (3.0, "#5b8dc9"), (4.0, "#24507f")):
        error = [1e3 * pin * parallel_error(float(lead), pin / 20.0) for lead in leads]
        axes.semilogy(
            np.degrees(leads), error, color=shade, lw=2.2, label=f"pin of diameter {2.0 * pin:g} mm"
        )
    axes.axhline(1.0, color=PIN_COLOR, lw=1.0, ls="--")
    axes.text(4.0, 1.15, "1 µm", color=PIN_COLOR, fontsize=10)
    axes.set(xlim=(0, 90), ylim=(1e-3, 50), xlabel="lead angle [deg]", ylabel="error [µm]")
    axes.set_title("Error of the plain parallel curve, cam radius 20 mm", fontsize=12)
    axes.legend(fontsize=9)
    axes.grid(alpha=0.3)


def draw() -> Figure:
    mechanism, pin = knee()
    run_out = pin.radius
    cuts = [GrooveCut(mechanism, cam, pin.radius, run_out) for cam in (1, 2)]
    figure = Figure(figsize=(12.0, 10.5), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(1.15, 1.0))
    with TemporaryDirectory() as folder:
        for k, color in enumerate(CAM_COLORS):
            name = Path(folder) / f"knee_cam{k + 1}.step"
            size = {"run_out": run_out, "depth": pin.width}
            (file,) = export_groove(mechanism, name, pin.radius, cams=[k + 1], **size)
            axes = figure.add_subplot(grid[0, k], projection="3d")
            title = f"Cam {k + 1} of the prosthetic knee: {file.name}"
            draw_solid(axes, triangles(file), color, (AZIMUTH, -AZIMUTH)[k], title)
    draw_both_unwrapped(figure.add_subplot(grid[1, 0]), cuts)
    draw_parallel_error(figure.add_subplot(grid[1, 1]))
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=Path(__file__).resolve().parents[1])
    folder = parser.parse_args().output
    draw().savefig(folder / "cut_grooves.png", dpi=100, metadata={"Software": None})


if __name__ == "__main__":
    main()
