"""One verdict on a design: what is found, the words a user sees, and that each proposed value works."""

import json
import math

import numpy as np
import pytest

from dualcam import Fmu
from dualcam.checking import check_design
from dualcam.checking.remedies import nearest_working, round_away
from dualcam.checking.rules import troubles
from dualcam.checking.trouble import with_value
from dualcam.design import Ellipse, Helix, Limits, Mechanism, Pin, Spring, Table, assess, hertz_pressure
from dualcam.design_file import TEMPLATES, read_design, write_template
from dualcam.errors import DesignError, FmuError
from dualcam.fmi.library import fmu_path
from dualcam.fmi.variables import all_parameters

NEST = 'cam1.radius = "15 mm"\ncam2.radius = "30 mm"\n'  # of the same torque and stroke as the defaults


@pytest.fixture
def design(tmp_path):
    """The design of a text, with two tables beside it."""
    for name, last in (("short", 0.5), ("long", 1.2)):
        psi = np.linspace(0.0, last, 30)
        Table(0.02, psi, 0.02 * psi).write(tmp_path / f"{name}.csv")

    def read(text):
        path = tmp_path / "my.toml"
        path.write_text(text)
        return read_design(path)

    return read


@pytest.mark.parametrize("name", TEMPLATES)
def test_templates_are_good(tmp_path, name):
    verdict = check_design(read_design(write_template(name, tmp_path / "my.toml")))
    assert verdict.good and verdict.starts and verdict.findings == (), verdict.findings


# Text of the file, start of the only error, proposed key and value; None: the value is worked out below.
SINGLE = {
    "stop beyond a table": (
        'cam1 = {profile = "table", table = "short.csv"}',
        "stop.upper: groove 1 ends at psi = 0.5 rad, reached at theta = 1 rad: allowed is an upper stop",
        ("stop.upper", 1.0),  # equal slopes: theta = 2 psi
    ),
    "stop beyond a cycloid": (
        'cam1 = {profile = "cycloid", cycloid_rise = "8 mm", cycloid_angle = "40 deg"}\n'
        'limits = {self_locking = true, lead_angle = ["0 deg", "80 deg"]}',
        "stop.upper: groove 1 ends at psi = 0.698132 rad, reached at theta = 1.09813 rad",
        ("stop.upper", math.radians(40) + 0.4),  # 8 mm on the helix of 20 mm/rad
    ),
    "locking by accident": (
        'cam1.lead_angle = "6 deg"',
        "self-locking: lead angle of groove 1 at theta = 0 deg is 6 deg: allowed is more than the angle of",
        ("cam1.lead_angle", math.atan(0.14)),
    ),
    "friction that locks a table": (
        'cam1 = {profile = "table", table = "long.csv", friction = 0.9, radius = "25 mm"}\n'
        "stop.upper = 1.0\ncam2.friction = 0.05",
        "self-locking: lead angle of groove 1",
        ("cam1.friction", 0.8),  # slope 20 mm/rad over radius
    ),
    "jam": (
        'cam1 = {lead_angle = "80 deg", friction = 0.3}\ncam2 = {lead_angle = "80 deg", friction = 0.3}',
        "jam: friction is too high for the lead angles; at theta = 0 deg no torque can turn cam 2",
        # equal radii and slopes s: jams where (1 - mu1 s)(s + mu2) + (1 - mu2 s)(s + mu1) = 0
        ("cam1.friction", None),
    ),
    "solid length": (
        '[spring]\nfree_length = "30 mm"\nsolid_length = "20 mm"',
        "spring at solid length: at stop.upper = 1.3963 rad its deflection is preload/stiffness + z =",
        ("stop.upper", 0.9),  # 1 mm from the preload; z = 0.01 m theta
    ),
    "spring that pulls": (
        "spring.preload = -10",
        "spring force at theta = 0 deg is -10 N",
        ("spring.preload", 0),
    ),
    "pressure": (
        '[pin]\nradius = "1 mm"\nwidth = "0.1 mm"\n[spring]\nstiffness = 0',
        "contact pressure of groove 1 at theta = 0 deg is 2747.66 MPa: allowed is 1500",
        ("pin.width", 0.1e-3 * (2747.66 / 1500) ** 2),
    ),
    "undercut": (
        'cam1 = {profile = "ellipse", ellipse_a = "10 mm", ellipse_b = "10 mm"}\nstop.upper = 0.3\n'
        'pin = {radius = "11 mm", width = "8 mm"}\n[limits]\npressure = 1e15',
        "undercut: curvature of groove 1 at theta = 0 deg is 100 1/m: allowed is less than 1/(pin radius)",
        ("pin.radius", 0.01),  # a circle
    ),
    "start outside": (
        "initial.theta = 3.0",
        "initial.theta = 3 rad: allowed is stop.lower = 0 rad to stop.upper = 1.3963 rad",
        ("initial.theta", 1.3963),
    ),
    "imposed angle beyond the stop": (
        "[scenario]\nstop = 1\ninputs.theta = {time = [0, 1], value = [0, 2]}",
        "scenario.inputs.theta reaches 2 rad: allowed is stop.lower = 0 rad to stop.upper = 1.3963 rad",
        ("stop.upper", 2.0),
    ),
    "imposed curve beyond the stop, its points before": (
        "[scenario]\nstop = 3\n"
        'inputs.theta = {time = [0, 1, 2, 3], value = [0, 1.2, 1.2, 0], shape = "smooth"}',
        "scenario.inputs.theta reaches 1.5 rad at 1.5 s, between its points: allowed is stop.lower = 0 rad",
        ("stop.upper", 1.5),  # see test_a_smooth_curve_beyond_its_points_gets_a_warning
    ),
    "lead angle out of limits": (
        "[limits]\nlead_angle = ['50 deg', '80 deg']\n[cam2]\nlead_angle = '60 deg'",
        "lead angle of groove 1 at theta = 0 deg is 45 deg: allowed is 50 to 80",
        ("cam1.lead_angle", math.radians(50)),
    ),
}


def jam_friction():
    """mu1 at which helices of 80 deg with mu2 = 0.3 and equal radii begin to jam."""
    s, m = math.tan(math.radians(80)), 0.3
    return (2 * s + m - m * s**2) / (s**2 + 2 * m * s - 1)


@pytest.mark.parametrize("name", SINGLE)
def test_the_proposed_value_works_and_is_the_nearest(design, name):
    text, words, (key, edge) = SINGLE[name]
    edge = jam_friction() if edge is None else edge
    wrong = design(text)
    verdict = check_design(wrong)
    first = verdict.errors[0]
    assert not verdict.good and words in first.text and first.change == key, verdict.findings
    is_length = key in ("pin.radius", "pin.width")  # with its unit, as a design file has it
    shown = f'"{1e3 * first.nearest:.10g} mm"' if is_length else f"{first.nearest:.10g}"
    assert f"{key} = {shown}" in first.text and first.text.count(" works") == 1
    assert first.nearest == pytest.approx(edge, rel=2e-3, abs=0.02)
    put_in = wrong
    for finding in verdict.errors:
        put_in = with_value(put_in, finding.change, finding.nearest)
    again = check_design(put_in)
    assert again.good, again.findings
    with Fmu(fmu_path("forward")) as fmu:
        fmu.start(put_in.parameters_for("forward"))


def test_hints(design):
    """What could be meant, besides the value that works."""

    def texts(text):
        return " ".join(finding.text for finding in check_design(design(text)).findings)

    tables = 'cam1 = {profile = "table", table = "long.csv"}\ncam2 = {profile = "table", table = "short.csv"}'
    assert "swapped" not in texts(tables)  # exchanged tables reach exactly as far
    assert "If locking is meant, write self_locking = true below [limits]" in texts(
        'cam1.lead_angle = "6 deg"'
    )
    assert "Two cycloids need stop.lower and initial.theta > 0" in texts(
        'cam1.profile = "cycloid"\ncam2.profile = 4'
    )
    swapped = 'cam1 = {friction = 0.3, lead_angle = "10 deg"}\ncam2.lead_angle = "45 deg"'
    assert "are cam 1 and cam 2 swapped?" in texts(swapped)
    assert "swapped" not in texts('spring = {free_length = "40 mm", solid_length = "39 mm"}\n' + swapped)
    assert "Is the sign of stop.upper wrong: 1.309 rad?" in texts('stop.upper = "-75 deg"')
    assert "Are the stops exchanged?" in texts("stop = {lower = 1.2, upper = 0.0}")
    degrees = 'stop.upper = 75\ncam1 = {profile = "table", table = "short.csv"}'
    assert "this looks like degrees; 75 deg is 1.309 rad" in texts(degrees)


@pytest.mark.parametrize(
    "text",
    [
        'cam1 = {friction = 0.9, lead_angle = "60 deg"}\ncam2 = {friction = 0.9, lead_angle = "40 deg"}',
        'stop.upper = "75 deg"\npin = {radius = "1 mm", width = "0.02 mm"}\nlimits.pressure = "400 MPa"',
        'cam1.lead_angle = "1 deg"\npin = {radius = "1 mm", width = "0.02 mm"}',
    ],
)
def test_a_value_is_said_to_work_only_if_the_whole_check_passes(design, text):
    one = design(text)
    verdict = check_design(one)
    assert len(verdict.errors) > 1
    for finding in verdict.errors:
        if finding.nearest is None:
            assert " works" not in finding.text and "mends" not in finding.text
            continue
        after = check_design(with_value(one, finding.change, finding.nearest))
        assert after.good == (" works" in finding.text)
        assert len(after.errors) < len(verdict.errors), finding.text


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ('cam1.radius = 18\ncam2.radius = 22\npin = {radius = "3 mm", width = "8 mm"}', "cam1.radius"),
        ('stop.upper = 75\npin = {radius = "3 mm", width = "0.1 mm"}', "stop.upper"),
        ('stop.upper = 75\ncam1 = {profile = "table", table = "short.csv"}', "stop.upper"),
        ('[spring]\nstiffness = 35\nfree_length = "70 mm"\nsolid_length = "38 mm"', "spring.stiffness"),
    ],
)
def test_a_likely_wrong_unit_comes_first_and_no_other_value_is_proposed(design, text, key):
    verdict = check_design(design(text))
    assert verdict.errors and verdict.findings[0].key == key and "this looks like" in verdict.findings[0].text
    assert all(finding.nearest is None and " works" not in finding.text for finding in verdict.findings)
    assert not any("swapped" in finding.text for finding in verdict.findings)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("inertia.shaft = 4", "inertia.shaft = 4 kg.m2: this looks like kg.cm2; 4 kg.cm2 is 0.0004 kg.m2"),
        ("[scenario]\nstop = 1\ninputs.tau = {time = [0, 1], value = [0, 900]}", "900 N.cm is 9 N.m"),
        ("[scenario]\nstop = 500\ninputs.tau = 9.0", "this looks like milliseconds; 500 ms is 0.5 s"),
    ],
)
def test_values_that_are_strange_beside_the_torque(design, text, words):
    verdict = check_design(design(text))
    (strange,) = verdict.strange_units
    assert verdict.good and words in strange.text and strange.line


def test_pressure_is_given_at_its_largest_with_its_limit(design):
    """By Hertz for the equal helices of 45 deg: the pressure grows with the root of the spring's force."""
    text = '[pin]\nradius = "3 mm"\nwidth = "8 mm"\n[limits]\npressure = {}'
    one = design(text.format('"1500 MPa"'))
    verdict = check_design(one)
    largest = verdict.numbers.pressure
    assert largest.theta == pytest.approx(1.3963) and largest.limit == 1.5e9
    force = 50.0 + 50e3 * 0.02 * 1.3963 / 2  # both pins run half of the way, slope 1
    # equal grooves bear half of the spring's force each, on 2 contacts
    lead, rub = math.radians(45), math.atan(0.14)
    load = force / 4 * math.cos(rub) / math.cos(lead + rub)
    expected = float(hertz_pressure(load, one.pin))
    assert largest.pressure == pytest.approx(expected, rel=1e-6)
    finding = check_design(design(text.format('"400 MPa"'))).errors[0]
    at = f"reaches {expected / 1e6:.6g} MPa at theta = 80 deg: allowed is 400 MPa; outside from theta ="
    assert at in finding.text and "default" not in finding.text
    narrow = check_design(design('[pin]\nradius = "3 mm"\nwidth = "0.5 mm"')).errors[0]
    assert "allowed is 1500 MPa" in narrow.text and "the default of limits.pressure" in narrow.text


def test_self_locking_may_be_meant(design):
    assert check_design(design('cam1.lead_angle = "6 deg"\nlimits.self_locking = true')).good


@pytest.mark.parametrize(
    "leads, words",
    [
        ((45, 45), "one motion under every load (unique)"),
        ((6, 45), "one motion under every load (unique)"),
        ((6, 6), "several motions or none under some loads, where a fixed rule chooses (self-locking)"),
    ],
)
def test_the_class_of_the_mechanism_is_said_in_words(design, leads, words):
    """By the least Delta/r^3 of the corners: d_i = 1 - f_i s_i and n_i = s_i + f_i on equal radii. One locked
    contact alone leaves Delta > 0."""
    s = [math.tan(math.radians(lead)) for lead in leads]
    corners = [(f, g) for f in (-0.14, 0.14) for g in (-0.14, 0.14)]
    least = min((1 - f * s[0]) * (s[1] + g) + (1 - g * s[1]) * (s[0] + f) for f, g in corners)
    text = "limits.self_locking = true\n" + "".join(
        f'cam{i}.lead_angle = "{lead} deg"\n' for i, lead in enumerate(leads, 1)
    )
    numbers = check_design(design(text)).numbers
    assert f"friction: {words}" in numbers.lines() and numbers.friction_class == (1 if least > 0 else 2)


def test_default_limits_of_the_lead_angle_only_warn(design):
    verdict = check_design(design(NEST + 'cam1.lead_angle = "82 deg"\ncam2.lead_angle = "30 deg"'))
    assert verdict.good and [finding.severity for finding in verdict.findings] == ["warning"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the walls of cam 1 and cam 2 overlap"),
        (
            'cam2.radius = 0.0200000000001\npin = {radius = "3 mm", width = "8 mm"}',
            "the walls of cam 1 (radius 16 to 24 mm) and cam 2 (radius 16 to 24 mm) overlap and the cams"
            " cannot stand inside one another. Give the cams radii that differ by wall and clearance, at"
            " least pin.width = 8 mm. These grooves have the same torque and stroke with radii of 15"
            " and 30 mm",
        ),
    ],
)
def test_equal_radii_get_a_warning(design, text, words):
    """The walls are those of the solids that `dualcam design --export cam.step` writes."""
    verdict = check_design(design(text))
    (finding,) = (one for one in verdict.findings if one.kind == "equal radii")
    assert verdict.good and (finding.severity, finding.key) == ("warning", "cam2.radius")
    assert finding.text.startswith("cam1.radius = cam2.radius = 20 mm: equal radii cannot be built")
    assert words in finding.text
    before, after = verdict.numbers, check_design(design(NEST)).numbers
    assert after.load == pytest.approx(before.load) and after.stroke == pytest.approx(before.stroke)
    assert all(one.kind != "equal radii" for one in check_design(design("cam2.radius = 0.021")).findings)


@pytest.mark.parametrize(
    ("radii", "words"),
    [
        (("20 mm", "27.9 mm"), "cam 1 (radius 16 to 24 mm) and cam 2 (radius 23.9 to 31.9 mm) overlap"),
        (("27.9 mm", "20 mm"), "cam 1 (radius 23.9 to 31.9 mm) and cam 2 (radius 16 to 24 mm) overlap"),
        (("20 mm", "28 mm"), ""),
        (("14 mm", "22 mm"), ""),  # in m they differ by less than 0.008, by rounding
    ],
)
def test_radii_that_differ_by_less_than_the_pin_get_a_warning(design, radii, words):
    """A wall reaches from r - w/2 to r + w/2."""
    text = f'cam1.radius = "{radii[0]}"\ncam2.radius = "{radii[1]}"\n'
    verdict = check_design(design(text + 'pin = {radius = "3 mm", width = "8 mm"}'))
    found = [one for one in verdict.findings if one.kind == "equal radii"]
    assert verdict.good and len(found) == bool(words)
    if found:
        assert found[0].text.startswith(f"cam1.radius = {radii[0]} and cam2.radius = {radii[1]} cannot be")
        assert words in found[0].text
        assert "radii that differ by wall and clearance, at least pin.width = 8 mm" in found[0].text
    assert all(one.kind != "equal radii" for one in check_design(design(text)).findings)


CYCLOIDS = "stop.lower = 0.7\ninitial.theta = 0.8\n" + "".join(
    f"cam{i} = {{profile = 'cycloid', friction = MU}}\n" for i in (1, 2)
)


@pytest.mark.parametrize(
    ("text", "is_same"),
    [
        ("cam1.lead_angle = 0.7\ncam2.lead_angle = 0.7", True),
        ("cam1.lead_angle = 0.7\ncam2.lead_angle = 0.6", False),
        ("cam1.friction = 0.1\ncam2.friction = 0.2", False),
        ("cam1.profile = 'ellipse'\ncam2.profile = 'ellipse'", True),
        ("cam1.profile = 'ellipse'", False),
        (CYCLOIDS.replace("MU", "0.1"), False),  # psi counts and not the arc: the lead angles change
        (CYCLOIDS.replace("MU", "0.0"), True),  # without friction the radius does not matter
        ('pin = {radius = "3 mm", width = "16 mm"}', False),  # radii of 15 and 30 mm: the walls overlap
    ],
)
def test_radii_of_the_same_torque_are_proposed_where_there_are_some(design, text, is_same):
    verdict = check_design(design(text))
    (finding,) = (one for one in verdict.findings if one.kind == "equal radii")
    proposal = "These grooves have the same torque and stroke with radii of 15 and 30 mm"
    assert (proposal in finding.text) == is_same
    other = design(text)
    for name, radius in (("cam1.radius", 0.015), ("cam2.radius", 0.03)):
        other = with_value(other, name, radius)
    before, after = verdict.numbers, check_design(other).numbers
    if "pin" not in text:
        is_equal = after.load == pytest.approx(before.load) and after.stroke == pytest.approx(before.stroke)
        assert is_equal == is_same


def test_a_spring_without_preload_is_no_error(design):
    assert check_design(design("spring.preload = 0")).good


def test_warnings_of_the_file_are_in_the_verdict(design):
    verdict = check_design(design(NEST + "stop.upper = 75"))
    assert verdict.good and [finding.key for finding in verdict.findings] == ["stop.upper"]


def test_what_only_the_fmu_refuses(design, monkeypatch):
    """The FMU has the last word, in its own words."""
    monkeypatch.setattr("dualcam.checking.verdict.troubles", lambda design: [])
    verdict = check_design(design("stop.upper = -1.0"))
    assert not verdict.good and not verdict.starts
    assert "the FMU does not start: " in verdict.errors[0].text and "stop.lower" in verdict.errors[0].text


def test_json(design):
    short = 'cam1 = {profile = "table", table = "short.csv"}\ncam2.radius = "30 mm"'
    verdict = check_design(design(short))
    read = json.loads(json.dumps(verdict.to_json(), allow_nan=False))
    assert (read["good"], read["starts"], read["model"], read["name"]) == (False, False, "forward", "my")
    (finding,) = read["findings"]
    assert finding["change"] == "stop.upper" and finding["nearest"] == pytest.approx(0.5 + 1 / 3, rel=1e-3)
    assert finding["severity"] == "error" and finding["key"] == "stop.upper" and finding["value"] == 1.3963


def test_search():
    assert nearest_working(0.0, 10.0, lambda x: x >= 1.23456) == 1.235
    assert nearest_working(10.0, 0.0, lambda x: x <= 1.23456) == 1.234
    assert nearest_working(0.0, 1.0, lambda x: False) is None
    assert nearest_working(75.0, 0.5, lambda x: x <= 1.0) == pytest.approx(1.0, rel=2e-3)
    assert round_away(-0.123456, 3, up=True) == -0.123 and round_away(0.0, 3, up=True) == 0.0


# ---- assess: good means that the FMU starts ----

ALL_ALLOWED = Limits((0.0, 0.5 * math.pi), math.inf, self_locking=True)
GEOMETRY = ("ends", "jam", "level", "start", "spring.stiffness", "radius")


def random_groove(rng):
    radius = 10.0 ** rng.uniform(-2.3, -1.0) * rng.choice([1.0, 1e6], p=[0.98, 0.02])
    lead = rng.choice([0.0, rng.uniform(0.0, 1.56), rng.uniform(0.1, 1.3)], p=[0.05, 0.25, 0.7])
    kind = rng.integers(3)
    if kind == 0:
        return Helix(radius, lead)
    if kind == 1:
        return Ellipse(radius, lead, *10.0 ** rng.uniform(-2.5, -0.5, 2), int(rng.choice([-1, 1])))
    low = rng.choice([0.0, -rng.uniform(0.0, 1.0)])
    psi = np.unique(np.append(rng.uniform(low, rng.uniform(0.2, 3.0), rng.integers(4, 40)), 0.0))
    slope = rng.uniform(0.0, 2.0, len(psi) - 1) ** rng.integers(1, 4) * (rng.random(len(psi) - 1) < 0.95)
    return Table(radius, psi, np.append(0.0, np.cumsum(slope * np.diff(psi) * radius)))


def random_mechanism(rng):
    """Any mechanism, many of them bad. DesignError where the classes refuse their values."""
    friction = tuple(float(x) for x in rng.choice([0.0, rng.uniform(0, 0.4), rng.uniform(0, 2), -0.1], 2))
    stiffness = rng.choice([0.0, 1e4, -1e3, math.nan], p=[0.2, 0.6, 0.1, 0.1])
    lower = rng.choice([0.0, -rng.uniform(0, 1), rng.uniform(0, 1)], p=[0.45, 0.45, 0.1])
    spring = Spring(rng.uniform(-10, 200), stiffness)
    return Mechanism(
        (random_groove(rng), random_groove(rng)), friction, spring, rng.uniform(0, 2.5), 2, lower
    )


@pytest.mark.filterwarnings("ignore::dualcam.errors.UnitWarning")
@pytest.mark.parametrize("seed", range(3))
def test_good_means_that_the_fmu_starts(tmp_path, seed):
    """And what is found of the geometry is what the FMU refuses."""
    rng = np.random.default_rng(seed)
    seen = {True: 0, False: 0}
    with Fmu(fmu_path("forward")) as forward, Fmu(fmu_path("inverse")) as inverse:
        for _ in range(200):
            try:
                mechanism = random_mechanism(rng)
            except DesignError:
                continue
            report = assess(mechanism, Pin(0.002, 0.01), ALL_ALLOWED)
            geometry = [str(one) for one in report.findings if any(word in one.what for word in GEOMETRY)]
            starts = []
            for fmu in (forward, inverse):
                try:
                    fmu.start(mechanism.parameters(tmp_path))
                    starts.append("")
                except FmuError as error:
                    starts.append(str(error))
            assert bool(starts[0]) == bool(geometry), (mechanism, starts, geometry)
            assert not (report.good and any(starts)), (mechanism, starts)
            seen[report.good] += 1
    assert min(seen.values()) > 15


def test_what_was_called_good():
    """A table that ends before the upper stop, negative friction, a spring that is no number."""
    psi = np.linspace(0.0, 0.5, 9)
    short = Mechanism((Table(0.02, psi, 0.02 * psi), Helix(0.02, 0.7)), (0.1, 0.1), Spring(50, 5e4), 1.3963)
    report = assess(short, Pin(0.003, 0.008))
    assert not report.good and "groove 1 ends at psi = 0.5 rad, reached at theta = " in str(
        report.findings[0]
    )
    assert report.theta[-1] < 1.3963 and np.isfinite(report.force).all()
    for wrong in (
        lambda: Mechanism((Helix(0.02, 0.7),) * 2, (-0.1, 0.1), Spring(50, 5e4), 1.0),
        lambda: Mechanism((Helix(0.02, 0.7),) * 2, (0.1, math.nan), Spring(50, 5e4), 1.0),
        lambda: Spring(math.nan, 5e4),
        lambda: Spring(50.0, 5e4, math.inf),
        lambda: Mechanism((Helix(0.02, 0.7),) * 2, (0.1, 0.1), Spring(50, 5e4), math.nan),
        lambda: Ellipse(0.02, 1.5707963, 10.0, 1e-3),
    ):
        with pytest.raises(DesignError, match="allowed"):
            wrong()


@pytest.mark.filterwarnings("ignore::dualcam.errors.UnitWarning")  # beyond the limits
def test_limits_of_the_fmu():
    """Values that the FMU's modelDescription.xml does not allow."""
    large = Mechanism((Helix(0.02, 0.7),) * 2, (11.0, 0.0), Spring(50, 5e4), 1.0)
    texts = [str(one) for one in assess(large, None, ALL_ALLOWED).findings]
    assert "cam1.friction = 11: allowed is a number from 0 to 10" in texts
    soft = Mechanism((Helix(0.02, 0.7),) * 2, (0.1, 0.1), Spring(500, -1.0), 1.0)
    assert [str(one) for one in assess(soft, None, ALL_ALLOWED).findings] == [
        "spring.stiffness = -1: allowed is a number >= 0 in N/m"
    ]


def test_without_a_pin_there_is_no_pressure():
    report = assess(Mechanism((Helix(0.02, 0.7),) * 2, (0.1, 0.1), Spring(50, 5e4), 1.0), None)
    assert report.good and np.isnan(report.pressure).all()


# ---- any design gets a verdict ----


def random_text(rng):
    """Parameters anywhere in their limits, some with spring lengths and pin."""
    known = {name: v for name, v in all_parameters().items() if not name.endswith("table")}

    def value(variable):
        if variable.kind is bool:
            return "true"
        if variable.kind is int:
            return str(int(rng.choice([variable.least, min(variable.greatest, 2)])))  # no table
        low, high = max(variable.least, -1e12), min(variable.greatest, 1e12)
        near = variable.start * rng.uniform(0.3, 2.0)
        far = variable.start * 10.0 ** rng.uniform(-3.0, 3.0)
        return repr(float(np.clip(rng.choice([low, high, near, near, far, 1e-300, 0.0]), low, high)))

    names = rng.choice(list(known), rng.integers(1, 6), replace=False)
    lines = [f"{name} = {value(known[name])}" for name in names]
    if rng.random() < 0.3:
        lines.append(f"spring.free_length = {rng.uniform(0.05, 0.1)}\nspring.solid_length = 0.04")
    if rng.random() < 0.3:
        lines.append(f"pin.radius = {10 ** rng.uniform(-4, -1)}\npin.width = {10 ** rng.uniform(-4, -1)}")
    return "\n".join(lines)


def test_any_design_gets_a_verdict_and_every_proposal_cures_its_finding(design):
    rng = np.random.default_rng(5)
    proposals = 0
    for _ in range(40):
        text = random_text(rng)
        one = design(text)
        verdict = check_design(one)
        json.dumps(verdict.to_json(), allow_nan=False)
        assert verdict.good == (verdict.starts and not verdict.errors)
        assert verdict.starts or verdict.errors, text
        for finding in verdict.findings:
            if finding.nearest is None:
                continue
            proposals += 1
            left = troubles(with_value(one, finding.change, finding.nearest))
            assert finding.kind not in {trouble.finding.kind for trouble in left}, (text, finding)
            if " works" in finding.text:
                assert check_design(with_value(one, finding.change, finding.nearest)).good, (text, finding)
    assert proposals > 5


def test_a_parameter_of_the_other_model_is_named(design):
    verdict = check_design(design(NEST + "[shaft]\nstiffness = 100.0\n[scenario]\nstop = 1.0\n"))
    (finding,) = verdict.findings
    assert verdict.good and (finding.severity, finding.line) == ("warning", 4)
    assert finding.text == "shaft.stiffness = 100.0 is not used: the forward model has no such parameter"


def test_an_unknown_parameter_is_answered_by_the_nearest_name(design):
    one = design("[cam1]\nradius = 0.03\n")
    assert (one.value("cam1.radius"), one.value("cam2.radius")) == (0.03, 0.02)
    with pytest.raises(DesignError, match=r"cam1\.raduis is no parameter: did you mean cam1\.radius"):
        one.value("cam1.raduis")


@pytest.mark.parametrize(
    ("scenario", "words"),
    [
        (
            "stop = 1.0\ninputs.tau = {time = [0.0, 0.5], value = [0.0, 0.3]}",
            "the cam never leaves theta = 0 deg",
        ),
        ("stop = 0.5\ninputs.tau = {time = [0.0, 300.0], value = [0.0, 9.0]}", "points up to 300 s"),
        ("stop = 1.0\ninputs.tau = {time = [0.0, 0.5], value = [0.0, 9000.0]}", "9000 N.mm is 9 N.m"),
        ("stop = 1.0\ninputs.tau = {time = [0.0, 0.5], value = [0.0, 6.0]}", ""),
    ],
)
def test_scenarios_that_do_nothing_get_a_warning(design, scenario, words):
    """The default mechanism loads at 0.66 N.m at theta = 0 and at 9.9 N.m at the upper stop."""
    verdict = check_design(design(f"{NEST}[scenario]\n{scenario}\n"))
    assert verdict.good
    texts = [finding.text for finding in verdict.findings]
    assert any(words in text for text in texts) if words else texts == []


# Values of tau at 0, 1, 2, 3 s, and where the spline between them is beyond. Its slopes by hand, with y' = 0
# at both ends: 4 m1 + m2 = 3 (y2 - y0), m1 + 4 m2 = 3 (y3 - y1).
SPLINES = {
    "above": ("[0, 8, 8, 0]", "reaches 10 N.m at 1.5 s, and"),  # m1 = 8: y = 8 + 8 h (1 - h) in the middle
    "below": ("[8, 0, 0, 8]", "reaches -2 N.m at 1.5 s, and"),
    # m1 = m2 = -2.4: y = 4 + 14.4 h^2 - 10.4 h^3 at first, which is largest at h = 12/13
    "on both sides": ("[4, 8, 0, 4]", "reaches -0.08994 N.m at 2.077 s and 8.09 N.m at 0.9231 s, and"),
    "on both sides, by 0.8 %": ("[3.5, 8, 0, 4.5]", ""),
    "not at all": ("[0, 3, 6, 8]", ""),
}


@pytest.mark.parametrize("name", SPLINES)
def test_a_smooth_curve_beyond_its_points_gets_a_warning(design, name):
    values, words = SPLINES[name]
    curve = f"inputs.tau = {{time = [0, 1, 2, 3], value = {values}, shape = 'smooth'}}\n"
    verdict = check_design(design(f"{NEST}[scenario]\nstop = 3\n{curve}"))
    found = [finding for finding in verdict.warnings if finding.key == "scenario.inputs.tau"]
    assert verdict.good and len(found) == bool(words)
    if found:
        assert words in found[0].text and found[0].line == 5
        assert "its points are between 0 and 8 N.m" in found[0].text
        assert 'Closer points, or shape = "linear", keep the curve' in found[0].text
    straight = check_design(design(f"{NEST}[scenario]\nstop = 3\n{curve.replace('smooth', 'linear')}"))
    assert straight.findings == ()


@pytest.mark.parametrize("motion", ["tau = 3.0", "theta = 0.5"])
def test_stick_slip_behind_a_soft_shaft_is_told_where_to_go(design, motion):
    """The inverse FMU refuses, the forward FMU has no such shaft: both texts name the page."""
    law = "cam1.friction_peak = 1.5\nshaft.stiffness = 5.0\n"
    scenario = f"[scenario]\nstop = 1.0\n[scenario.inputs]\n{motion}\n"
    verdict = check_design(design(law + scenario))
    (finding,) = (one for one in verdict.findings if "shaft.stiffness" in one.text)
    assert "outside a forward FMU: docs/stick-slip.md" in finding.text
    assert verdict.starts == motion.startswith("tau")
    calm = check_design(design("shaft.stiffness = 5.0\n" + scenario))
    assert not any("stick-slip" in one.text for one in calm.findings)
