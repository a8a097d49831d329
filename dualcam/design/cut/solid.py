"""The solid of a cam by the CAD kernel OpenCASCADE, in millimetres.

The flanks are surfaces over the angle psi and the radius rho. They are cubic splines through exact points;
the number of points grows until the splines are within SPLINE_ERROR. A tool in the shape of the groove is
closed by two round ends and two pieces of cylinders, and cut from a tube.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from dualcam.design.cut.cam_body import CamBody
from dualcam.design.cut.groove_cut import Curve, GrooveCut
from dualcam.design.cut.sampling import SHARES, in_space
from dualcam.design.statics import Array
from dualcam.errors import DesignError

if TYPE_CHECKING:
    from OCP.Geom import Geom_BSplineSurface
    from OCP.TopoDS import TopoDS_Face, TopoDS_Shape, TopoDS_Solid
    from scipy.interpolate import BSpline

MM = 1e3  # per metre
SPLINE_ERROR = 1e-4  # mm
SEWING = 1e-3  # mm between edges that are one
VOLUME_ERROR = 1e-5  # relative, of the kernel's integration
FEWEST_RADII, MOST_RADII = 9, 200  # nodes of the splines along the pin
FEWEST_NODES, MOST_NODES = 9, 4_000  # along the groove
LARGEST_TURN = math.radians(350.0)  # of one groove about the axis

Outline = Callable[[Array, float], Curve]  # parameters (n,) and a radius [m] -> points of the groove's edge


def require_kernel() -> None:
    """DesignError if the CAD kernel is not installed."""
    try:
        import OCP.BRepAlgoAPI  # noqa: F401
    except ImportError:
        raise DesignError(
            'a .step file needs the CAD kernel OpenCASCADE (380 MB): pip install "dualcam[cad]"; .dxf and'
            " .csv files need no CAD kernel"
        ) from None


def cam_solid(cut: GrooveCut, body: CamBody) -> TopoDS_Shape:
    """The cam with all its grooves [mm]. DesignError if the kernel makes no valid solid."""
    require_kernel()
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    _require_less_than_a_turn(cut, body)
    shape: TopoDS_Shape = _tube(body)
    for end in range(cut.mechanism.contacts):
        shape = BRepAlgoAPI_Cut(shape, _tool(cut, body, end)).Shape()
    solids = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_SOLID)
    solid = solids.Current()
    solids.Next()
    wanted = MM**3 * body.volume(cut)
    if (
        solids.More()
        or not BRepCheck_Analyzer(solid).IsValid()
        or not math.isclose(_volume(solid), wanted, rel_tol=1e-4)
    ):
        raise DesignError(
            f"cam {cut.cam}: the CAD kernel makes no valid solid of this groove: write .dxf or .csv"
        )
    return solid


def _require_less_than_a_turn(cut: GrooveCut, body: CamBody) -> None:
    low, _ = _radii(cut, body)
    turn = cut.end - cut.begin + 2.0 * math.asin(cut.pin_radius / low)
    if turn > LARGEST_TURN:
        raise DesignError(
            f"cam {cut.cam}: the groove goes over {math.degrees(turn):.4g} deg: allowed in a STEP file are"
            f" {math.degrees(LARGEST_TURN):.4g} deg; write .dxf or .csv"
        )


def _volume(shape: TopoDS_Shape) -> float:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, VOLUME_ERROR)
    return float(properties.Mass())


def _tube(body: CamBody) -> TopoDS_Shape:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    axes = gp_Ax2(gp_Pnt(0.0, 0.0, MM * body.low), gp_Dir(0.0, 0.0, 1.0))
    height = MM * (body.high - body.low)
    outer = BRepPrimAPI_MakeCylinder(axes, MM * body.outer_radius, height).Shape()
    if body.bore_radius == 0.0:
        return outer
    return BRepAlgoAPI_Cut(
        outer, BRepPrimAPI_MakeCylinder(axes, MM * body.bore_radius, height).Shape()
    ).Shape()


# ---- the tool: a body in the shape of one groove ----


def _tool(cut: GrooveCut, body: CamBody, end: int) -> TopoDS_Solid:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
    from OCP.BRepLib import BRepLib
    from OCP.TopoDS import TopoDS

    low, high = _radii(cut, body)
    radii = _radius_nodes(cut, low, high)
    sides = _sides(cut, radii)
    sewing = BRepBuilderAPI_Sewing(SEWING)
    for outline, nodes in sides:
        sewing.Add(_side_face(cut, outline, nodes, radii, end))
    for radius in (low, high):
        sewing.Add(_cylinder_face(cut, sides, radius, end))
    sewing.Perform()
    solid = BRepBuilderAPI_MakeSolid(TopoDS.Shell(sewing.SewedShape())).Solid()
    BRepLib.OrientClosedSolid_s(solid)
    return solid


def _radii(cut: GrooveCut, body: CamBody) -> tuple[float, float]:
    """Radii between which the tool is [m]: beyond the wall where the groove is open."""
    high = 1.02 * body.outer_radius
    if not body.is_slot:
        return body.floor_radius, high
    return 0.5 * (body.bore_radius + max(0.98 * body.bore_radius, cut.pin_radius)), high


def _radius_nodes(cut: GrooveCut, low: float, high: float) -> Array:
    """Radii between which a cubic spline is within SPLINE_ERROR of the flanks and of the round ends [m]."""
    psi = np.linspace(cut.begin, cut.end, 17)

    def points(radii: Array) -> Array:
        curves = [
            (rho, curve)
            for rho in radii.tolist()
            for curve in (
                *cut.flanks(psi, rho),
                cut.round_end(True, 0.5, rho),
                cut.round_end(False, 0.5, rho),
            )
        ]
        space = [_in_space(cut, Curve(*map(np.atleast_1d, curve)), rho, 0) for rho, curve in curves]
        return np.concatenate(space).reshape(len(radii), -1)

    count = FEWEST_RADII
    while count < MOST_RADII:
        radii = np.linspace(low, high, count)
        between = 0.5 * (radii[1:] + radii[:-1])
        spline = _spline(radii, points(radii))
        if np.abs(spline(_share(between, radii)) - points(between)).max() < SPLINE_ERROR:
            return radii
        count = 2 * count - 1
    raise DesignError(
        f"cam {cut.cam}: the pin is almost as wide as the floor of the groove, of radius {MM * low:.4g} mm:"
        " allowed in a STEP file is a thinner pin or a smaller depth"
    )


def _sides(cut: GrooveCut, radii: Array) -> list[tuple[Outline, Array]]:
    """The edge of the groove in pieces, once around, each with the nodes of its spline."""
    pieces: list[tuple[Outline, Array]] = []
    borders = np.unique([cut.begin, *cut.travel, cut.end])

    def upper(psi: Array, radius: float) -> Curve:
        return cut.flanks(psi, radius).upper

    def lower(psi: Array, radius: float) -> Curve:
        return cut.flanks(psi, radius).lower

    def last(share: Array, radius: float) -> Curve:
        return cut.round_end(True, share, radius)

    def first(share: Array, radius: float) -> Curve:
        return cut.round_end(False, 1.0 - share, radius)

    for begin, end in pairwise(borders):
        pieces.append((upper, _nodes(cut, upper, begin, end, radii)))
    pieces.append((last, _nodes(cut, last, 0.0, 1.0, radii)))
    for begin, end in pairwise(borders[::-1]):
        pieces.append((lower, _nodes(cut, lower, begin, end, radii)))
    pieces.append((first, _nodes(cut, first, 0.0, 1.0, radii)))
    return pieces


def _nodes(cut: GrooveCut, outline: Outline, begin: float, end: float, radii: Array) -> Array:
    """Nodes between which a cubic spline is within SPLINE_ERROR of the outline."""
    nodes = np.linspace(begin, end, FEWEST_NODES)
    while len(nodes) < MOST_NODES:
        between = nodes[:-1, None] + SHARES * np.diff(nodes)[:, None]
        coarse = np.zeros(len(nodes) - 1, dtype=bool)
        for radius in (float(radii[0]), float(radii[-1])):
            spline = _spline(nodes, _in_space(cut, outline(nodes, radius), radius, 0))
            wanted = _in_space(cut, outline(between.ravel(), radius), radius, 0)
            error = np.abs(spline(_share(between.ravel(), nodes)) - wanted).max(axis=1)
            coarse |= error.reshape(between.shape).max(axis=1) > SPLINE_ERROR
        if not coarse.any():
            return nodes
        nodes = np.sort(np.append(nodes, 0.5 * (nodes[:-1] + nodes[1:])[coarse]))
    raise DesignError(f"cam {cut.cam}: the groove bends too sharply for a STEP file: write .dxf or .csv")


def _share(values: Array, nodes: Array) -> Array:
    """Parameters of a spline: 0 at the first node, 1 at the last."""
    return (values - nodes[0]) / (nodes[-1] - nodes[0])


def _spline(nodes: Array, points: Array) -> BSpline:
    """The cubic spline through points at these nodes."""
    from scipy.interpolate import make_interp_spline

    return make_interp_spline(_share(nodes, nodes), points, k=3)


def _in_space(cut: GrooveCut, curve: Curve, radius: float, end: int) -> Array:
    """Points [mm], shape (n, 3)."""
    return MM * in_space(cut.angle(curve.psi, end), curve.z, radius)


def _side_face(cut: GrooveCut, outline: Outline, nodes: Array, radii: Array, end: int) -> TopoDS_Face:
    """A flank or a round end: a spline surface over nodes and radii."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace

    points = np.stack([_in_space(cut, outline(nodes, float(rho)), float(rho), end) for rho in radii], axis=1)
    along = _spline(nodes, points)
    across = _spline(radii, np.moveaxis(along.c, 1, 0))
    surface = _surface(np.moveaxis(across.c, 0, 1), along.t, across.t)
    return BRepBuilderAPI_MakeFace(surface, 1e-7).Face()


def _surface(poles: Array, u_knots: Array, v_knots: Array) -> Geom_BSplineSurface:
    """A bicubic surface; poles of shape (m, n, 3)."""
    from OCP.collections import Array2_gp_Pnt
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt

    rows, columns = poles.shape[:2]
    array = Array2_gp_Pnt(1, rows, 1, columns)
    for i in range(rows):
        for j in range(columns):
            array.SetValue(i + 1, j + 1, gp_Pnt(*poles[i, j].tolist()))
    (u, u_mults), (v, v_mults) = _knots(u_knots), _knots(v_knots)
    return Geom_BSplineSurface(array, u, v, u_mults, v_mults, 3, 3)


def _knots(knots: Array) -> tuple[object, object]:
    """Distinct knots and their multiplicities, as arrays of the kernel."""
    from OCP.collections import Array1_double, Array1_int

    values, counts = np.unique(knots, return_counts=True)
    numbers, multiplicities = Array1_double(1, len(values)), Array1_int(1, len(values))
    for k, (value, count) in enumerate(zip(values.tolist(), counts.tolist(), strict=True), 1):
        numbers.SetValue(k, value)
        multiplicities.SetValue(k, count)
    return numbers, multiplicities


def _cylinder_face(
    cut: GrooveCut, sides: list[tuple[Outline, Array]], radius: float, end: int
) -> TopoDS_Face:
    """The piece of a cylinder inside the groove's edge: the floor, or the lid outside of the cam."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.BRepLib import BRepLib
    from OCP.Geom import Geom_CylindricalSurface
    from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt

    # the seam of the cylinder is half a turn from the middle of the groove
    seam = float(cut.angle(0.5 * (cut.begin + cut.end), end)) - math.pi
    axes = gp_Ax3(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 0.0, 1.0), gp_Dir(math.cos(seam), math.sin(seam), 0.0))
    cylinder = Geom_CylindricalSurface(axes, MM * radius)
    wire = BRepBuilderAPI_MakeWire()
    for outline, nodes in sides:
        curve = outline(nodes, radius)
        points = np.stack([cut.angle(curve.psi, end) - seam, MM * curve.z], axis=-1)
        wire.Add(BRepBuilderAPI_MakeEdge(_curve_2d(_spline(nodes, points)), cylinder).Edge())
    BRepLib.BuildCurves3d_s(wire.Wire())
    return BRepBuilderAPI_MakeFace(cylinder, wire.Wire(), True).Face()


def _curve_2d(spline: BSpline) -> object:
    from OCP.collections import Array1_gp_Pnt2d
    from OCP.Geom2d import Geom2d_BSplineCurve
    from OCP.gp import gp_Pnt2d

    poles = Array1_gp_Pnt2d(1, len(spline.c))
    for k, pole in enumerate(spline.c.tolist(), 1):
        poles.SetValue(k, gp_Pnt2d(*pole))
    knots, multiplicities = _knots(spline.t)
    return Geom2d_BSplineCurve(poles, knots, multiplicities, 3)
