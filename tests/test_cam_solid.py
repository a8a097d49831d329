"""Solids of cams in STEP files, read again by the CAD kernel.

The centre line of a groove is where a radial pin has the same distance from both flanks. These distances are
measured in space, from points of the file's own surfaces.
"""

import math

import numpy as np
import pytest
from test_groove_cut import LAWS, PIN, SPRING, mechanism

from dualcam.design import CamBody, GrooveCut, Helix, Mechanism, export_groove
from dualcam.design.cut.cam_body import groove_area
from dualcam.errors import DesignError

pytest.importorskip("OCP.STEPControl", reason='the CAD kernel is not installed: pip install "dualcam[cad]"')

pytestmark = pytest.mark.filterwarnings("ignore:the walls of cam 1:dualcam.errors.DualcamWarning")
DEPTH = 0.008  # m
MICROMETRE = 1e-6


def read_step(path):
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    assert reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    reader.TransferRoots()
    return reader.OneShape()


def parts(shape, kind):
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    explorer, found = TopExp_Explorer(shape, getattr(TopAbs_ShapeEnum, f"TopAbs_{kind}")), []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def volume(shape):
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, 1e-7)
    return 1e-9 * properties.Mass()


def edges_on_cylinder(solid, radius):
    """Points (n, 3) [m] where the surface of the solid meets a cylinder about the axis."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Section
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    from OCP.TopoDS import TopoDS

    axes = gp_Ax2(gp_Pnt(0.0, 0.0, -500.0), gp_Dir(0.0, 0.0, 1.0))
    cylinder = BRepPrimAPI_MakeCylinder(axes, 1e3 * radius, 1000.0).Shape()
    found = []
    for edge in parts(BRepAlgoAPI_Section(solid, cylinder).Shape(), "EDGE"):
        curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
        for t in np.linspace(curve.FirstParameter(), curve.LastParameter(), 1501):
            point = curve.Value(float(t))
            found.append((point.X(), point.Y(), point.Z()))
    return 1e-3 * np.array(found)


def distances(cut, psi, points, end=0):
    """Distance of points from the pin's axis at each psi, and whether the pin's axis is below them."""
    angle, z = cut.angle(psi, end), cut.centre(psi).z
    across = points[:, None, 0] * np.sin(angle) - points[:, None, 1] * np.cos(angle)
    ahead = points[:, None, 0] * np.cos(angle) + points[:, None, 1] * np.sin(angle) > 0.0
    # along the normal of the unwrapped path: + is the side of the upper flank
    slope = cut.centre(psi).slope / cut.radius
    side = (points[:, None, 2] - z) + slope * across * cut.hand
    away = np.where(ahead, np.hypot(across, points[:, None, 2] - z), np.inf)
    return away, side > 0.0


@pytest.mark.parametrize(
    "law, bore",
    [*((law, None) for law in LAWS), ("helix", 0.0), ("ellipse that flattens", 0.0), ("table", 0.0)],
)
def test_centre_line_of_the_file_is_the_groove_law(tmp_path, law, bore):
    """Both cams, both ends of the pin, on the cylinder of the cam's radius: the pin at psi on the law touches
    both flanks of the file within 0.2 um, so the centre line is there."""
    cam = mechanism(law)
    for number, file in enumerate(
        export_groove(cam, tmp_path / "cam.step", PIN, depth=DEPTH, bore_radius=bore, run_out=0.001), 1
    ):
        solid = read_step(file)
        cut = GrooveCut(cam, number, PIN, run_out=0.001)
        points = edges_on_cylinder(solid, cut.radius)
        psi = np.linspace(*cut.travel, 31)
        for end in range(2):
            away, above = distances(cut, psi, points, end)
            upper = np.where(above, away, np.inf).min(axis=0)
            lower = np.where(above, np.inf, away).min(axis=0)
            assert upper == pytest.approx(PIN, abs=0.2 * MICROMETRE)
            assert lower == pytest.approx(PIN, abs=0.2 * MICROMETRE)
            assert np.abs(upper - lower).max() / 2.0 < 0.2 * MICROMETRE


@pytest.mark.parametrize("law", ["helix", "ellipse that steepens", "table"])
def test_the_pin_fits_over_its_whole_depth(tmp_path, law):
    """Also near floor and outer surface: no point of the solid is nearer to the pin's axis than the pin's
    radius less 1 um, and the flanks touch."""
    cam = mechanism(law)
    (file,) = export_groove(cam, tmp_path / "cam.step", PIN, cams=[2], depth=DEPTH)
    solid, cut = read_step(file), GrooveCut(cam, 2, PIN)
    psi = np.linspace(*cut.travel, 401)
    for radius in (cut.radius - 0.45 * DEPTH, cut.radius + 0.45 * DEPTH):
        points = edges_on_cylinder(solid, radius)
        away = distances(cut, psi, points)[0]
        assert away.min() == pytest.approx(PIN, abs=0.2 * MICROMETRE)
        touched = away.min(axis=0)
        assert touched == pytest.approx(PIN, abs=0.2 * MICROMETRE)


def swept_area(lead, radius, pin, length):
    """Area of the pin's section moved along a straight line, by Cavalieri: the section's own area, and its
    width across the line times the length."""
    t = np.linspace(0.0, 2.0 * math.pi, 20_001)
    x, z = radius * np.arcsin(pin / radius * np.cos(t)), pin * np.sin(t)
    own = abs(np.trapezoid(z, x))
    across = -math.sin(lead) * x + math.cos(lead) * z
    return own + length * np.ptp(across)


@pytest.mark.parametrize("bore", [None, 0.01])
def test_volume_and_size_of_helical_cams(tmp_path, bore):
    """The volume is that of the tube without two swept pins. One valid solid has the size that was asked
    for."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepCheck import BRepCheck_Analyzer

    cam, run_out = mechanism("helix"), 0.002
    files = export_groove(
        cam, tmp_path / "cam.stp", PIN, run_out=run_out, depth=DEPTH, bore_radius=bore, length=0.04
    )
    for number, file in enumerate(files, 1):
        text = file.read_text()
        assert f"PRODUCT('dualcam cam {number}'" in text and "SI_UNIT(.MILLI.,.METRE.)" in text
        assert "pin of diameter 6 mm" in "".join(text.splitlines())
        shape = read_step(file)
        (solid,) = parts(shape, "SOLID")
        assert BRepCheck_Analyzer(solid).IsValid()
        cut = GrooveCut(cam, number, PIN, run_out=run_out)
        floor, outer = 0.016, 0.024
        radii = np.linspace(floor, outer, 101)
        rise = np.ptp(cut.centre(np.array([cut.begin, cut.end])).z)
        turned = cut.end - cut.begin
        areas = [swept_area(math.atan(0.02 / rho), rho, PIN, math.hypot(rho * turned, rise)) for rho in radii]
        assert groove_area(cut, 0.02) == pytest.approx(areas[50], rel=1e-6)
        tube = math.pi * (outer**2 - (floor if bore is None else bore) ** 2) * 0.04
        assert volume(solid) == pytest.approx(tube - 2.0 * np.trapezoid(areas, radii), rel=1e-5)
        box = Bnd_Box()
        BRepBndLib.AddOptimal_s(solid, box)
        low, high = box.CornerMin(), box.CornerMax()
        size = [high.X() - low.X(), high.Y() - low.Y(), high.Z() - low.Z()]
        assert size == pytest.approx([48.0, 48.0, 40.0], abs=1e-2)
        assert 0.5 * (low.Z() + high.Z()) == pytest.approx(0.5e3 * cut.centre(cut.travel).z.sum(), abs=1e-2)


@pytest.mark.parametrize(
    "sizes, mention",
    [
        ({"depth": 0.05}, "depth = 50 mm: allowed is a length > 0 and below 34 mm"),
        ({"depth": math.nan}, "depth = nan mm"),
        ({"outer_radius": 0.019}, "outer diameter = 38 mm: allowed is 40 mm"),
        ({"bore_radius": 0.021}, "bore diameter = 42 mm"),
        ({"length": 0.005}, "length = 5 mm: allowed is more than the groove's height, 18 mm"),
    ],
)
def test_bodies_that_the_groove_does_not_fit(sizes, mention):
    cut = GrooveCut(mechanism("helix"), 1, PIN)
    with pytest.raises(DesignError, match=mention):
        CamBody.around(cut, **{"depth": DEPTH, **sizes})


def test_a_groove_of_more_than_a_turn_is_refused(tmp_path):
    long = Helix(0.02, math.radians(30))
    cam = Mechanism((long, long), (0.14, 0.14), SPRING, 13.0)
    with pytest.raises(DesignError, match=r"goes over \d+\.?\d* deg: allowed in a STEP file are 350 deg"):
        export_groove(cam, tmp_path / "cam.step", PIN, depth=DEPTH)
    assert len(export_groove(cam, tmp_path / "cam.dxf", PIN)) == 2
