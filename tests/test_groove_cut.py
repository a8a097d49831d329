"""Grooves for a workshop: flanks against the pin itself, undercut, and the files in CSV and DXF.

The pin is a cylinder in space. A point of a flank is right if the pin touches the point and never cuts
beyond the point: the least distance of the point from the pin's axis, over all places of the pin, is the
pin's radius. The distance is computed in space, without the formulas of the flanks.
"""

import math

import ezdxf
import numpy as np
import pytest

from dualcam import Fmu, read_design
from dualcam.design import Ellipse, GrooveCut, Helix, Mechanism, Spring, Table, curvature, export_groove
from dualcam.errors import DesignError

PIN = 0.003  # m
ANGLES = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
LAWS = {
    "helix": Helix(0.02, math.pi / 4),
    "flat helix": Helix(0.04, math.radians(1.4)),
    "steep helix": Helix(0.012, math.radians(75)),
    "ellipse that flattens": Ellipse(0.02, 1.1867, 0.0756, 0.0188, -1),
    "ellipse that steepens": Ellipse(0.028, 0.4, 0.05, 0.05, 1),
    "table": Table(0.02, ANGLES, 0.012 * ANGLES + 0.009 * ANGLES**2),
    "table with a dwell": Table(0.02, ANGLES, np.maximum(0.0, ANGLES - 0.3) ** 3 * 0.05),
}
SPRING = Spring(50.0, 5e4)


def mechanism(law, upper=1.2, contacts=2):
    """Both grooves of this law; a dwell meets a helix."""
    first = LAWS[law]
    second = LAWS["helix"] if "dwell" in law else first
    return Mechanism((first, second), (0.14, 0.14), SPRING, upper, contacts)


def distance_from_pin(cut, points, radius, psi):
    """Least distance of points in space from the pin's axis, a radial line, over the places psi [m]."""
    z = cut.centre(psi).z
    angle = cut.hand * psi
    axis = np.stack([np.cos(angle), np.sin(angle)])
    across = points[:, None, 0] * axis[1] - points[:, None, 1] * axis[0]
    return np.hypot(across, points[:, None, 2] - z).min(axis=1)


def in_space(cut, curve, radius):
    angle = cut.hand * curve.psi
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), curve.z], axis=-1)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("cam", [1, 2])
def test_the_pin_touches_each_point_of_both_flanks_and_cuts_none(law, cam):
    """Brute force over 20,001 places of the pin: the distance is quadratic about its least value, so that the
    grid adds less than 1 nm."""
    cut = GrooveCut(mechanism(law), cam, PIN, run_out=0.001)
    psi = np.linspace(cut.begin, cut.end, 41)
    dense = np.linspace(cut.begin, cut.end, 20_001)
    for radius in (cut.radius, 0.8 * cut.radius, 1.2 * cut.radius):
        for flank in cut.flanks(psi, radius):
            found = distance_from_pin(cut, in_space(cut, flank, radius), radius, dense)
            assert found == pytest.approx(PIN, abs=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_the_upper_flank_is_above_and_round_ends_join_both_flanks(law):
    cut = GrooveCut(mechanism(law), 1, PIN)
    psi = np.linspace(cut.begin, cut.end, 101)
    upper, lower = cut.flanks(psi)
    z = cut.centre(psi).z
    assert (upper.z > z).all() and (lower.z < z).all()
    assert 0.5 * (upper.psi + lower.psi) == pytest.approx(psi, abs=1e-15)
    for at_end, place in ((True, -1), (False, 0)):
        edge = cut.round_end(at_end, np.linspace(0.0, 1.0, 33))
        assert (edge.psi[0], edge.z[0]) == pytest.approx((upper.psi[place], upper.z[place]), abs=1e-15)
        assert (edge.psi[-1], edge.z[-1]) == pytest.approx((lower.psi[place], lower.z[place]), abs=1e-15)
        points = in_space(cut, edge, cut.radius)
        pin_at = np.array([psi[place]])
        assert distance_from_pin(cut, points, cut.radius, pin_at) == pytest.approx(PIN, rel=1e-12)
        beyond = edge.psi[16] - psi[place]
        assert beyond > 0.0 if at_end else beyond < 0.0


def test_flanks_of_a_helix_are_two_helices():
    """Both flanks are the centre line shifted along itself: one angle and one height at each psi. To second
    order in pin over radius, the shift is the radius along the normal."""
    helix = LAWS["helix"]
    cut = GrooveCut(mechanism("helix"), 1, 1e-3 * helix.radius)
    psi = np.linspace(0.0, 0.6, 7)
    upper = cut.flanks(psi).upper
    assert np.ptp(upper.psi - psi) < 1e-15 and np.ptp(upper.z - cut.centre(psi).z) < 1e-16
    offset = 1e-3 * math.sqrt(0.5)
    assert upper.psi - psi == pytest.approx(-offset, rel=1e-6)
    assert (upper.z - cut.centre(psi).z) / helix.radius == pytest.approx(offset, rel=1e-6)
    # exact for 45 deg: cos(t)^2 = (1 - sqrt(1 - q^2))/q^2
    q = PIN / helix.radius
    flank = GrooveCut(mechanism("helix"), 1, PIN).flanks(0.3).upper
    cosine = math.sqrt(1.0 - math.sqrt(1.0 - q * q)) / q
    assert float(flank.psi) == pytest.approx(0.3 - math.asin(q * cosine), rel=1e-14)
    assert float(flank.z) == pytest.approx(0.3 * 0.02 + PIN * math.sqrt(1.0 - cosine**2), rel=1e-14)


@pytest.mark.parametrize("degrees", [5, 30, 45, 60, 80])
def test_error_of_the_plain_parallel_curve(degrees):
    """docs/cut-grooves.md: p^3 sin(lambda)^4/(6 rho^2) between the flank and the parallel curve at distance
    p, to leading order."""
    lead, radius = math.radians(degrees), 0.02
    cam = Mechanism((Helix(radius, lead),) * 2, (0.14, 0.14), SPRING, 0.8)
    for pin in (0.0005, 0.001):
        flank = GrooveCut(cam, 1, pin).flanks(0.2).upper
        across = -math.sin(lead) * radius * (float(flank.psi) - 0.2) + math.cos(lead) * (
            float(flank.z) - radius * math.tan(lead) * 0.2
        )
        said = pin**3 * math.sin(lead) ** 4 / (6.0 * radius**2)
        assert across - pin == pytest.approx(said, rel=0.02, abs=1e-15)


# ---- what cannot be cut ----


def test_undercut_is_refused_with_the_place_and_the_greatest_pin():
    """The unwrapped ellipse is sharpest at its end along the circumference: there its radius of curvature
    is h_z^2/h_x. The pin's section is wider there than the pin, by the roundness of the cylinder."""
    law = Ellipse(0.02, 0.9, 0.012, 0.008, -1)
    cam = Mechanism((law, law), (0.14, 0.14), SPRING, 0.5)
    psi = np.linspace(*GrooveCut(cam, 1, 0.001).travel, 2001)
    sharpest = 1.0 / np.abs(curvature(law, psi)).max()
    with pytest.raises(DesignError, match="the lower flank is undercut at psi = 0 rad") as found:
        GrooveCut(cam, 1, 1.2 * sharpest)
    greatest = 0.5e-3 * float(str(found.value).rpartition("diameter ")[2].split()[0])
    assert greatest < 1.3 * sharpest
    GrooveCut(cam, 1, greatest)
    with pytest.raises(DesignError, match="undercut"):
        GrooveCut(cam, 1, greatest + 2e-6)
    # by brute force: just above that radius the pin cuts a part of its own flank away
    for pin, is_cut in ((0.98 * greatest, False), (1.05 * greatest, True)):
        cut = object.__new__(GrooveCut)
        for name, value in {"mechanism": cam, "cam": 1, "pin_radius": pin, "run_out": 0.0}.items():
            object.__setattr__(cut, name, value)
        object.__setattr__(cut, "loading", "counterclockwise")
        dense = np.linspace(*cut.travel, 20_001)
        flank = in_space(cut, cut.flanks(dense[::100]).lower, cut.radius)
        depth = pin - distance_from_pin(cut, flank, cut.radius, dense)
        assert (depth.max() > 1e-8) == is_cut


def test_grooves_that_run_into_one_another_are_refused():
    """Both ends of the pin have a groove of the same slope, half a turn apart."""
    flat = Helix(0.02, math.radians(5))
    cam = Mechanism((flat, flat), (0.14, 0.14), SPRING, 7.0)
    with pytest.raises(DesignError, match="grooves of both ends of the pin run into one another"):
        GrooveCut(cam, 1, PIN)
    apart = 0.02 * math.pi * math.sin(math.radians(5))  # of two parallel lines
    GrooveCut(cam, 1, 0.49 * apart)
    with pytest.raises(DesignError, match="run into one another"):
        GrooveCut(cam, 1, 0.51 * apart)
    once = Mechanism((flat, flat), (0.14, 0.14), SPRING, 13.0, contacts=1)
    GrooveCut(once, 1, 0.98 * apart)
    with pytest.raises(DesignError, match="turns of the groove run into one another"):
        GrooveCut(once, 1, 1.02 * apart)


@pytest.mark.parametrize(
    "arguments, mention",
    [
        ({"cam": 3}, "cam = 3: allowed are 1 and 2"),
        ({"pin_radius": 0.03}, "below the radius of cam 1, 0.02 m"),
        ({"pin_radius": math.nan}, "pin_radius = nan m"),
        ({"run_out": -1e-3}, "run_out = -0.001 m: allowed is a finite number >= 0"),
        ({"run_out": math.inf}, "run_out = inf m"),
        ({"loading": "left"}, "allowed are counterclockwise, clockwise"),
    ],
)
def test_wrong_arguments_are_named(arguments, mention):
    with pytest.raises(DesignError, match=mention):
        GrooveCut(**{"mechanism": mechanism("helix"), "cam": 1, "pin_radius": PIN, **arguments})


def test_a_groove_in_which_the_pin_stays_is_refused():
    """Groove 1 is level, so that the pin stays at z = 0 and at psi = 0 of groove 2."""
    cam = Mechanism((Helix(0.02, 0.0), LAWS["helix"]), (0.14, 0.14), SPRING, 1.0)
    assert GrooveCut(cam, 1, PIN).travel == (0.0, 1.0)
    with pytest.raises(DesignError, match="cam 2: the pin stays at psi = 0 rad of this groove"):
        GrooveCut(cam, 2, PIN)


def test_a_groove_that_ends_before_the_stop_is_refused():
    with pytest.raises(
        DesignError, match=r"the grooves end at theta = 1\.8 rad, before the upper stop at 1\.9"
    ):
        GrooveCut(mechanism("table", upper=1.9), 1, PIN)


# ---- files ----


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("law", LAWS)
def test_points_in_space_of_the_csv_file(folder, law):
    """Columns by name. Centre line on the law; flanks at the pin; chords within 1 um of the curves."""
    cam = mechanism(law)
    for number, file in enumerate(export_groove(cam, "groove.csv", PIN, run_out=0.002), 1):
        rows = np.genfromtxt(file, delimiter=",", names=True)
        cut = GrooveCut(cam, number, PIN, run_out=0.002)
        psi, radius, inside = rows["psi_rad"], cut.radius, slice(None)
        low, high = cut.travel
        inside = (psi >= low) & (psi <= high)
        assert {low, high} <= set(psi.tolist()) and psi[0] < low and psi[-1] > high
        law_z = cam.grooves[number - 1].at(psi[inside]).z
        assert rows["z_m"][inside] == pytest.approx(law_z, abs=1e-15)
        sense = 1 if number == 1 else -1
        assert rows["centre_x_m"] == pytest.approx(radius * np.cos(psi), abs=1e-15)
        assert rows["centre_y_m"] == pytest.approx(sense * radius * np.sin(psi), abs=1e-15)
        dense = np.linspace(psi[0], psi[-1], 20_001)
        for name in ("upper", "lower"):
            points = np.stack([rows[f"{name}_{axis}_m"] for axis in "xyz"], axis=-1)
            assert np.hypot(*points.T[:2]) == pytest.approx(radius, abs=1e-15)
            assert distance_from_pin(cut, points[::3], radius, dense) == pytest.approx(PIN, abs=1e-9)
            middles = 0.5 * (points[1:] + points[:-1])[::3]
            assert distance_from_pin(cut, middles, radius, dense) == pytest.approx(PIN, abs=1e-6)


@pytest.mark.parametrize("law", LAWS)
def test_the_csv_file_is_a_groove_table_that_moves_as_the_law(folder, law):
    """The file in a design file, and the law itself: the same torque of slow motion in the FMU within 1e-6 of
    the largest, the same lift within 1 nm."""
    cam = mechanism(law)
    files = export_groove(cam, "groove.csv", PIN)
    radii = [groove.radius for groove in cam.grooves]
    tables = [
        f'[cam{i}]\nprofile = "table"\ntable = "{f.name}"\nradius = {r}\n'
        for i, (f, r) in enumerate(zip(files, radii, strict=True), 1)
    ]
    (folder / "my.toml").write_text(
        "".join(tables) + "[spring]\npreload = 50.0\nstiffness = 50e3\n[stop]\nupper = 1.2\n"
    )
    design = read_design("my.toml")
    theta = np.linspace(0.001, 1.199, 25)
    found = {}
    laws = cam.parameters(folder)
    for name, start in {"law": laws, "file": design.parameters}.items():
        with Fmu("inverse") as fmu:
            values = []
            for angle in theta:
                fmu.start({**start, "inertia.shaft": 0.0, "theta": angle, "omega": 1e-3})
                values.append((fmu.real("z"), fmu.real("tau")))
        found[name] = np.array(values).T
    (z, tau), (z_file, tau_file) = found["law"], found["file"]
    assert z_file == pytest.approx(z, abs=1e-9)
    assert tau_file == pytest.approx(tau, abs=1e-6 * np.abs(tau).max())


@pytest.mark.parametrize("law", LAWS)
def test_the_drawing_read_again(folder, law):
    """ezdxf finds no fault. Millimetres; all points of the flanks at the pin; lines within 1 um; the parts of
    the outline meet."""
    cam = mechanism(law)
    for number, file in enumerate(export_groove(cam, "groove.dxf", PIN, run_out=0.002), 1):
        cut = GrooveCut(cam, number, PIN, run_out=0.002)
        drawing = ezdxf.readfile(file)
        assert not drawing.audit().errors and drawing.units == ezdxf.units.MM
        lines = {}
        for line in drawing.modelspace().query("LWPOLYLINE"):
            lines.setdefault(line.dxf.layer, []).append(1e-3 * np.array(line.get_points("xy")))
        assert {name: len(found) for name, found in lines.items()} == {
            "CENTRE": 2,
            "FLANK_UPPER": 2,
            "FLANK_LOWER": 2,
            "ENDS": 4,
            "STOPS": 8,
            "CYLINDER": 2,
            "MARK": 1,
            "AXIS": 1,
        }
        dense = np.linspace(cut.begin, cut.end, 20_001)
        for end in range(2):
            shift = np.array([math.pi * cut.radius * end, 0.0])
            upper, lower = (lines[name][end] - shift for name in ("FLANK_UPPER", "FLANK_LOWER"))
            begin, last = (points - shift for points in lines["ENDS"][2 * end : 2 * end + 2])
            corners = [begin[0], last[0], begin[-1], last[-1]]
            flanks = [upper[0], upper[-1], lower[0], lower[-1]]
            assert np.array(corners) == pytest.approx(np.array(flanks), abs=1e-12)
            for points in (upper, lower, begin, last):
                for places, error in ((points[::3], 1e-9), (0.5 * (points[1:] + points[:-1])[::3], 1e-6)):
                    angle = places[:, 0] / cut.radius
                    x, y = cut.radius * np.cos(angle), cut.radius * np.sin(angle)
                    space = np.stack([x, y, places[:, 1]], axis=-1)
                    found = distance_from_pin(cut, space, cut.radius, dense)
                    assert found == pytest.approx(PIN, abs=error)
        edges = sorted(float(line[0, 0]) for line in lines["CYLINDER"])
        assert edges[1] - edges[0] == pytest.approx(2.0 * math.pi * cut.radius, rel=1e-12)
        for layer in ("FLANK_UPPER", "FLANK_LOWER", "ENDS"):
            assert all(
                (edges[0] < line[:, 0]).all() and (line[:, 0] < edges[1]).all() for line in lines[layer]
            )
        centre = lines["CENTRE"][0]
        psi = cut.hand * centre[:, 0] / cut.radius
        assert centre[:, 1] == pytest.approx(cut.centre(psi).z, abs=1e-12)
        texts = " ".join(text.dxf.text for text in drawing.modelspace().query("TEXT"))
        for words in (f"cam {number}", f"radius {1e3 * cut.radius:g} mm", "diameter 6 mm", "units mm"):
            assert words in texts
        assert ("right-handed" if number == 1 else "left-handed") in texts
        # the arrow starts at z = 0, points to greater z, where the groove goes, and is beside the surface
        arrow, (low, high) = lines["AXIS"][0], cut.centre(np.array(cut.travel)).z
        assert arrow[0, 1] == 0.0 and arrow[1, 1] == arrow[:, 1].max() > 0.0 and high > low
        assert (arrow[:, 0] < edges[0]).all() and "+z is up: the pin moves up" in texts


def test_a_helix_is_drawn_by_single_lines(folder):
    file, _ = export_groove(mechanism("helix"), "groove.dxf", PIN)
    lines = ezdxf.readfile(file).modelspace().query('LWPOLYLINE[layer=="FLANK_UPPER"]')
    assert [len(line) for line in lines] == [2, 2]


def test_loading_clockwise_is_the_mirror_image(folder):
    cam = mechanism("ellipse that flattens")
    files = [
        export_groove(cam, f"{loading}.csv", PIN, cams=[1], loading=loading)[0]
        for loading in ("clockwise", "counterclockwise")
    ]
    mirrored, given = (np.genfromtxt(file, delimiter=",", names=True) for file in files)
    for name in given.dtype.names:
        assert (mirrored[name] == (-given[name] if "_y_" in name else given[name])).all(), name
