"""Groove laws (fmu_src/geometry/groove*.c) and the transmission along theta (transmission*.c beside them)."""

import locale
import math
from ctypes import byref
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from groove_core import (
    CYCLOID,
    DEGREE,
    ELLIPSE,
    FILES,
    HELIX,
    SHIM,
    STRUCTURES,
    TABLE,
    Fault,
    Groove,
    Transmission,
    cam,
    params_of,
    with_signatures,
    write_table,
)
from hypothesis import given
from hypothesis import strategies as st

EPS = np.finfo(float).eps


@pytest.fixture(scope="module")
def library(core):
    return with_signatures(core(FILES, STRUCTURES, SHIM))


@pytest.fixture
def grooves(library):
    """groove_build that must succeed; freed at the end."""
    made = []

    def build(params, resources=None):
        groove, fault = Groove(), Fault()
        both = params_of(params, params)
        assert library.groove_build(byref(groove), byref(both), 1, resources, byref(fault)), fault.text
        made.append(groove)
        return groove

    yield build
    for groove in made:
        library.groove_free(byref(groove))
        library.groove_free(byref(groove))


@pytest.fixture
def courses(library):
    made = []

    def build(first, second, lower=0.0, upper=1.3963):
        transmission, fault = Transmission(), Fault()
        params = params_of(first, second, lower, upper)
        good = library.transmission_build(byref(transmission), byref(params), None, byref(fault))
        assert good, fault.text.decode()
        made.append(transmission)
        return transmission

    yield build
    for transmission in made:
        library.transmission_free(byref(transmission))
        library.transmission_free(byref(transmission))
        assert transmission.count == 0


def groove_refusal(library, params, resources=None):
    groove, fault = Groove(), Fault()
    both = params_of(params, params)
    assert not library.groove_build(byref(groove), byref(both), 2, resources, byref(fault))
    assert not groove.table.piece
    return fault.text.decode()


def course_refusal(library, first, second, lower=0.0, upper=1.3963):
    transmission, fault = Transmission(), Fault()
    params = params_of(first, second, lower, upper)
    assert not library.transmission_build(byref(transmission), byref(params), None, byref(fault))
    assert not transmission.piece and transmission.count == 0
    text = fault.text.decode()
    assert len(text) < 511 and ("must" in text or "allowed" in text)
    return text


# ---- one groove ----


def exact_ellipse(params, psi, digits=50):
    """z, slope, bend and S, straight from the definition."""
    with mpmath.workdps(digits):
        r, a, b = (mpmath.mpf(x) for x in (params.radius, params.ellipse_a, params.ellipse_b))
        start = mpmath.sin(mpmath.atan(a / b * mpmath.tan(mpmath.mpf(params.lead_angle))))
        k = params.ellipse_curvature
        S = start + k * r * mpmath.mpf(psi) / a
        z = k * b * (mpmath.sqrt(1 - start**2) - mpmath.sqrt(1 - S**2))
        return z, r * b / a * S / mpmath.sqrt(1 - S**2), r * b / a * (k * r / a) / (1 - S**2) ** 1.5, S


@pytest.mark.parametrize("kappa", [1, -1])
@pytest.mark.parametrize(("lead", "a", "b"), [(0.8203, 0.05, 0.05), (0.3, 0.03, 0.08), (1.2, 0.1, 0.04)])
def test_ellipse(library, grooves, kappa, lead, a, b):
    params = cam(ELLIPSE, lead=lead, a=a, b=b, kappa=kappa)
    groove = grooves(params)
    for psi in [*np.linspace(groove.first, groove.last, 41), 1e-9, -1e-9, 1e-300, 0.0]:
        point = library.groove_at(byref(groove), psi)
        # 50 digits and, for the definition cancels them, as many more as psi is small
        z, slope, bend, S = exact_ellipse(params, psi, 50 if abs(psi) > 1e-20 else 400)
        room = float(1 - S**2)  # rounding of S counts that much more close to vertical
        assert point.z == pytest.approx(float(z), rel=2e-14 / math.sqrt(room), abs=1e-18 * abs(psi))
        assert point.slope == pytest.approx(float(slope), rel=4 * EPS / room, abs=4 * EPS * params.radius)
        assert point.dslope_dpsi == pytest.approx(float(bend), rel=16 * EPS / room)


@pytest.mark.parametrize("kappa", [1, -1])
def test_ellipse_ends(library, grooves, kappa):
    params = cam(ELLIPSE, kappa=kappa)
    groove = grooves(params)
    level, vertical = (groove.first, groove.last) if kappa > 0 else (groove.last, groove.first)
    assert abs(library.groove_at(byref(groove), level).slope) < 1e-16
    psi = (1 - 1e-9 - groove.S0) / groove.rate
    assert min(0, vertical) < psi < max(0, vertical)
    z, slope, _, _ = exact_ellipse(params, psi)
    assert library.groove_at(byref(groove), psi).slope == pytest.approx(float(slope), rel=1e-6)
    # with the height known, the slope is exact where the angle alone leaves 6 digits
    assert library.groove_slope(byref(groove), psi, float(z)) == pytest.approx(float(slope), rel=1e-11)
    for psi in np.linspace(level, vertical, 33):
        back = library.groove_angle(byref(groove), library.groove_at(byref(groove), psi).z)
        assert back == pytest.approx(psi, abs=1e-7)
        if abs(psi - level) > 0.1:
            assert back == pytest.approx(psi, abs=2e-15)


@pytest.mark.parametrize("share", [1e-3, 1e-5, 1e-7])
def test_slope_close_to_the_level_end_of_an_ellipse(library, grooves, share):
    """A circle that flattens: the slope is r tan(angle), with sin(angle) = S_0 (1 - psi/psi_end). The height
    has no digits of the slope left there."""
    radius, a, start = 0.02, 0.05, math.sin(0.8)
    groove = grooves(cam(ELLIPSE, radius=radius, lead=0.8, a=a, b=a, kappa=-1))
    psi = start * a / radius * (1.0 - share)
    sine = start - psi * radius / a
    found = library.groove_slope(byref(groove), psi, library.groove_at(byref(groove), psi).z)
    assert found == pytest.approx(radius * sine / math.sqrt(1.0 - sine * sine), abs=4 * EPS * radius, rel=0.0)


def test_ellipse_from_vertical_is_refused(library):
    text = groove_refusal(library, cam(ELLIPSE, lead=math.pi / 2))
    assert "cam2.lead_angle = 1.57" in text and "must" in text


def exact_cycloid(params, psi, digits):
    """z, slope and bend, straight from the definition."""
    with mpmath.workdps(digits):
        H, B = mpmath.mpf(params.cycloid_rise), mpmath.mpf(params.cycloid_angle)
        turn = 2 * mpmath.pi * mpmath.mpf(psi) / B
        z = H * (mpmath.mpf(psi) / B - mpmath.sin(turn) / (2 * mpmath.pi))
        return z, H / B * (1 - mpmath.cos(turn)), 2 * mpmath.pi * H / B**2 * mpmath.sin(turn)


@pytest.mark.parametrize(("rise", "angle"), [(0.02, 1.3963), (1e-3, 3.0), (0.5, 0.1)])
def test_cycloid(library, grooves, rise, angle):
    params = cam(CYCLOID, rise=rise, angle=angle)
    groove = grooves(params)
    assert (groove.first, groove.last) == (0.0, angle)
    near = [angle * share for share in (1e-9, 1e-5, 1e-3, 0.1, 0.16, 0.4999, 0.5001, 0.84, 0.999, 1 - 1e-9)]
    for psi in [*np.linspace(0.0, angle, 41), *near, 1e-300, math.nextafter(angle, 0.0)]:
        point = library.groove_at(byref(groove), psi)
        z, slope, bend = (
            float(x) for x in exact_cycloid(params, psi, 50 if psi > 1e-20 or not psi else 1000)
        )
        # psi/B is rounded: a share EPS of psi is lost, that much more close to the upper end
        room = max(1.0 - psi / angle, EPS)
        assert point.z == pytest.approx(z, rel=16 * EPS, abs=1e-307)
        assert point.slope == pytest.approx(slope, rel=8 * EPS / room, abs=16 * EPS * EPS * rise / angle)
        assert point.dslope_dpsi == pytest.approx(bend, rel=8 * EPS / room, abs=16 * EPS * rise / angle**2)


@pytest.mark.parametrize(("rise", "angle"), [(0.02, 1.3963), (1e-3, 3.0), (0.5, 0.1)])
def test_cycloid_inverse(library, grooves, rise, angle):
    """The angle of a height, to the rounding of the height divided by the slope."""
    groove = grooves(cam(CYCLOID, rise=rise, angle=angle))
    for psi in [*np.linspace(0.0, angle, 97), 1e-9 * angle, 1e-4 * angle, 0.999 * angle]:
        point = library.groove_at(byref(groove), psi)
        back = library.groove_angle(byref(groove), point.z)
        lost = 4 * EPS * point.z
        assert library.groove_at(byref(groove), back).z == pytest.approx(point.z, abs=lost)
        if point.slope > 1e-6 * rise:
            assert back == pytest.approx(psi, abs=4 * EPS * angle + lost / point.slope)
    for z, end in ((-1.0, 0.0), (0.0, 0.0), (rise, angle), (2 * rise, angle)):
        assert library.groove_angle(byref(groove), z) == end


def test_cycloid_ends_are_level_without_a_step_of_the_second_derivative(library, grooves):
    groove = grooves(cam(CYCLOID))
    for psi, z in ((0.0, 0.0), (-1.0, 0.0), (1.3963, 0.02), (2.0, 0.02)):
        point = library.groove_at(byref(groove), psi)
        assert (point.z, point.slope, point.dslope_dpsi) == (z, 0.0, 0.0)


@pytest.mark.parametrize(
    ("lower", "upper", "stop"), [(0.0, 1.6, "stop.upper = 1.6"), (-0.2, 0.8, "stop.lower = -0.2")]
)
def test_cycloid_left_before_a_stop(library, lower, upper, stop):
    """With a helix whose slope is large, theta is nearly the angle of the cycloid."""
    first, second = cam(CYCLOID, angle=0.9), cam(HELIX, lead=1.55)
    text = course_refusal(library, first, second, lower, upper)
    assert text.startswith("cam1.cycloid_angle = 0.9: the cycloidal groove of cam 1 ends at psi = ")
    assert stop in text and text.endswith("psi must stay in [0, cycloid_angle]")
    text = course_refusal(library, second, first, lower, upper)
    assert text.startswith("cam2.cycloid_angle = 0.9: the cycloidal groove of cam 2 ends at psi = ")


def test_two_cycloids_need_a_lower_stop_above_zero(library, courses):
    first, second = cam(CYCLOID, angle=0.9), cam(CYCLOID, angle=1.1)
    text = course_refusal(library, first, second, 0.0, 1.5)
    assert text.startswith("cam1.cycloid_angle = 0.9 and cam2.cycloid_angle = 1.1: both grooves are level at")
    assert courses(first, second, 0.2, 1.5).count > 1
    assert "both grooves are level" in course_refusal(library, first, first, 0.2, 1.8)


def test_helix(library, grooves):
    groove = grooves(cam(HELIX, lead=0.5))
    point = library.groove_at(byref(groove), -3.0)
    assert (point.z, point.slope, point.dslope_dpsi) == (-3.0 * groove.gain, groove.gain, 0.0)
    assert groove.gain == 0.02 * math.tan(0.5) and groove.first == -math.inf and groove.last == math.inf


# ---- tables ----


def test_table_of_a_polynomial(library, grooves, tmp_path):
    """Degree 4 is reproduced, on unequal spacing too; z counts from psi = 0, which is no knot."""
    p = np.polynomial.Polynomial([0.3, 0.02, 0.004, -0.001, 0.0005])
    psi = np.array([-0.7, -0.5, -0.1, 0.15, 0.2, 0.5, 0.9, 1.0, 1.4])
    groove = grooves(cam(TABLE, table=write_table(tmp_path / "t.csv", psi.tolist(), p(psi).tolist())))
    assert library.groove_at(byref(groove), 0.0).z == 0.0
    for x in np.linspace(-0.7, 1.4, 101):
        point = library.groove_at(byref(groove), x)
        assert point.z == pytest.approx(p(x) - p(0), abs=1e-15)
        assert point.slope == pytest.approx(p.deriv()(x), abs=1e-13)
        assert point.dslope_dpsi == pytest.approx(p.deriv(2)(x), abs=1e-11)
    assert (groove.first, groove.last) == (-0.7, 1.4)


@pytest.mark.parametrize("first, last", [(0.0, 1.4), (-1.4, 0.0)])
def test_psi_of_zero_may_be_an_end_of_the_table(library, grooves, tmp_path, first, last):
    psi = np.linspace(first, last, 8)
    groove = grooves(cam(TABLE, table=write_table(tmp_path / "t.csv", psi.tolist(), (0.02 * psi).tolist())))
    assert (groove.first, groove.last) == (first, last)
    assert library.groove_at(byref(groove), 0.5 * (first + last)).z == pytest.approx(0.01 * (first + last))


def test_four_points(library, grooves, tmp_path):
    p = np.polynomial.Polynomial([0.0, 0.02, 0.004, -0.001])
    psi = np.array([0.0, 0.3, 0.8, 1.0])
    groove = grooves(cam(TABLE, table=write_table(tmp_path / "t.csv", psi.tolist(), p(psi).tolist())))
    for x in np.linspace(0, 1, 21):
        assert library.groove_at(byref(groove), x).z == pytest.approx(p(x), abs=1e-16)


@pytest.mark.parametrize("kappa", [1, -1])
def test_table_of_an_ellipse(library, grooves, tmp_path, kappa):
    ellipse = grooves(cam(ELLIPSE, lead=0.6, kappa=kappa))
    x = np.linspace(0, 0.8, 997)
    true = np.array([library.groove_at(byref(ellipse), v).z for v in x])
    errors = []
    for n in (40, 80, 160):
        psi = np.linspace(0, 0.8, n + 1)
        z = [library.groove_at(byref(ellipse), v).z for v in psi]
        groove = grooves(cam(TABLE, table=write_table(tmp_path / f"{n}.csv", psi.tolist(), z)))
        errors.append(max(abs(true - [library.groove_at(byref(groove), v).z for v in x])))
    orders = [math.log2(a / b) for a, b in pairwise(errors) if b > 1e-14]
    assert orders and min(orders) >= 4.5, errors


def steps_of(data):
    widths, rises = zip(*data, strict=True)
    psi = np.concatenate([[0.0], np.cumsum(widths)])
    return psi, np.concatenate([[0.0], np.cumsum(rises)])


STEP = st.tuples(st.floats(1e-3, 1.0), st.sampled_from([0.0, 1e-9, 1e-4, 0.01, 0.5]) | st.floats(0.0, 0.1))


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("scratch") / "t.csv"


@given(st.lists(STEP, min_size=3, max_size=12))
def test_table_stays_monotone_and_smooth(library, scratch, data):
    psi, z = steps_of(data)
    groove, fault = Groove(), Fault()
    sampled = cam(TABLE, table=write_table(scratch, psi.tolist(), z.tolist()))
    params = params_of(sampled, sampled)
    assert library.groove_build(byref(groove), byref(params), 1, None, byref(fault)), fault.text
    at = lambda x: library.groove_at(byref(groove), x)  # noqa: E731
    scale = z[-1] + 1e-300
    for j in range(len(psi) - 1):
        inside = [at(x) for x in np.linspace(psi[j], psi[j + 1], 17)]
        assert all(p.slope >= 0.0 for p in inside)
        assert all(b.z - a.z >= -2 * EPS * scale for a, b in pairwise(inside))
        assert inside[0].z == pytest.approx(z[j], abs=4 * EPS * scale)
        if z[j] == z[j + 1]:
            assert all(p.slope == 0.0 and p.dslope_dpsi == 0.0 for p in inside)
    for j in range(1, len(psi) - 1):
        left, right = at(np.nextafter(psi[j], -1.0)), at(psi[j])
        widths = [groove.table.piece[i].width for i in (j - 1, j)]
        steep = max(max(groove.table.piece[i].slope) for i in (j - 1, j)) + 1e-300
        assert left.z == pytest.approx(right.z, abs=8 * EPS * (scale + steep * psi[-1]))
        assert left.slope == pytest.approx(right.slope, abs=1e-12 * steep * psi[-1] / min(widths))
        assert left.dslope_dpsi == pytest.approx(
            right.dslope_dpsi, abs=1e-12 * steep * psi[-1] / min(widths) ** 2
        )
    library.groove_free(byref(groove))


GOOD = "psi_rad,z_m\n0,0\n0.5,0.01\n1,0.02\n1.5,0.03\n"


@pytest.mark.parametrize(
    "text",
    [
        GOOD,
        "\ufeff" + GOOD,
        GOOD.replace("\n", "\r\n"),
        GOOD + "\n\n  \n",
        GOOD.rstrip("\n"),
        "psi_rad,z_m\n 0 , 0 \n5e-1,\t1.0E-2\n+1,.02\n1.5 ,0.03\n",
    ],
)
def test_table_formats(library, grooves, tmp_path, text):
    path = tmp_path / "t.csv"
    path.write_bytes(text.encode())
    groove = grooves(cam(TABLE, table=path))
    assert groove.table.count == 3
    assert library.groove_at(byref(groove), 0.75).z == pytest.approx(0.015, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "mentions"),
    [
        ("", ("line 1", "psi_rad,z_m")),
        (GOOD.replace("psi_rad", "psi"), ("line 1", "psi,z_m", "psi_rad,z_m")),
        (GOOD.replace("0.5,", "nan,"), ("line 3", "nan,0.01")),
        (GOOD.replace("0.5,", "inf,"), ("line 3",)),
        (GOOD.replace("0.5,", "1e999,"), ("line 3",)),
        (GOOD.replace("0.5,", "0x1p-1,"), ("line 3",)),
        (GOOD.replace("0.5,", "half,"), ("line 3", "half")),
        (GOOD.replace("0.5,0.01", "0.5"), ("line 3",)),
        (GOOD.replace("0.5,0.01", "0.5,0.01,1"), ("line 3",)),
        (GOOD.replace("0.5,0.01", "0,5,0,01"), ("line 3",)),
        (GOOD.replace("0.5,0.01", "0.5,"), ("line 3",)),
        (GOOD.replace("0.5,0.01", "0.5,0.01\0"), ("line 3", "0.01?")),
        (GOOD.replace("0.5,0.01\n", "\n0.5,0.01\n"), ("line 3", '""')),
        (GOOD.replace("0.5,0.01\n", "0" * 64 + "0.5,0.01\n"), ("line 3",)),
        (GOOD.replace("1.5,0.03\n", ""), ("3 points", "4")),
        (GOOD.replace("1,0.02", "0.5,0.02"), ("line 4", "psi_rad = 0.5", "> 0.5")),
        (GOOD.replace("1,0.02", "1,0.005"), ("line 4", "z_m = 0.005", ">= 0.01")),
        (GOOD.replace("\n0,0", "\n0.1,0"), ("psi_rad", "0.1", "1.5")),
        ("psi_rad,z_m\n" + "".join(f"{k},0\n" for k in range(100_001)), ("too long", "100000")),
        (GOOD + " " * (16 * 1024 * 1024), ("too large", "16777216")),
        ("psi_rad,z_m\n0,0\n1e-300,1\n2e-300,2\n3e-300,3\n", ("close",)),
    ],
)
def test_table_refused(library, tmp_path, text, mentions):
    path = tmp_path / "t.csv"
    path.write_bytes(text.encode())
    message = groove_refusal(library, cam(TABLE, table=path))
    assert message.startswith('cam2.table = "') and ("must" in message or "allowed" in message)
    for part in mentions:
        assert part in message


def test_table_path_refused(library, tmp_path):
    resources = str(tmp_path).encode()
    assert 'cam2.table = "": ' in groove_refusal(library, cam(TABLE))
    assert "must" in groove_refusal(library, cam(TABLE))
    assert "must be absolute" in groove_refusal(library, cam(TABLE, table="t.csv"))
    said = groove_refusal(library, cam(TABLE, table="none.csv"), resources)
    assert "cannot be opened" in said and f'resources, "{tmp_path}": give an absolute path' in said
    assert "must be a readable" in groove_refusal(library, cam(TABLE, table=tmp_path))
    assert "must be a readable" in groove_refusal(library, cam(TABLE, table="/dev/zero"))
    with (tmp_path / "large.csv").open("wb") as large:
        large.truncate(1 << 30)
    assert "too large" in groove_refusal(library, cam(TABLE, table=tmp_path / "large.csv"))
    text = groove_refusal(library, cam(TABLE, table="\u00e9" * 400), resources)
    assert "must" in text and text.count("\u00e9") == 60
    said = groove_refusal(library, cam(TABLE, table="n" * 400), b"/" + b"r" * 4000)
    assert "r" * 119 + '": give an absolute path' in said and "r" * 120 not in said
    assert "cam2.profile = 99" in groove_refusal(library, cam(99))


def test_table_path_ignores_the_working_directory(library, grooves, tmp_path, monkeypatch):
    (tmp_path / "resources").mkdir()
    (tmp_path / "resources" / "t.csv").write_text(GOOD)
    monkeypatch.chdir(tmp_path / "resources")
    groove_refusal(library, cam(TABLE, table="t.csv"), str(tmp_path).encode())
    monkeypatch.chdir("/")
    grooves(cam(TABLE, table="t.csv"), str(tmp_path / "resources").encode())


def comma_locale():
    before = locale.setlocale(locale.LC_ALL)
    for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "it_IT.UTF-8", "de_DE", "fr_FR", "it_IT"):
        try:
            locale.setlocale(locale.LC_ALL, name)
        except locale.Error:
            continue
        if locale.localeconv()["decimal_point"] == ",":
            return before
    locale.setlocale(locale.LC_ALL, before)
    pytest.skip("no locale with a decimal comma is installed (Debian: locales-all)")


def test_table_ignores_the_locale(library, grooves, tmp_path):
    (tmp_path / "t.csv").write_text(GOOD)
    before = comma_locale()
    try:
        groove = grooves(cam(TABLE, table=tmp_path / "t.csv"))
        assert library.groove_at(byref(groove), 0.75).z == pytest.approx(0.015, rel=1e-15)
        assert locale.localeconv()["decimal_point"] == ","
    finally:
        locale.setlocale(locale.LC_ALL, before)


# ---- the transmission ----


@pytest.fixture(scope="module")
def laws(tmp_path_factory):
    directory = tmp_path_factory.mktemp("tables")
    psi = np.linspace(-0.5, 2.5, 61)
    wavy = write_table(directory / "wavy.csv", psi.tolist(), (0.02 * psi + 0.003 * np.sin(2 * psi)).tolist())
    flat = np.interp(psi, [-0.5, 0.5, 0.8, 2.5], [-0.01, 0.01, 0.01, 0.044])
    dwell = write_table(directory / "dwell.csv", psi.tolist(), flat.tolist())
    return {
        "helix": cam(HELIX, lead=math.pi / 4),
        "level": cam(HELIX, lead=0.0),
        "flattening": cam(ELLIPSE, lead=0.8203),
        "wide": cam(ELLIPSE, lead=0.8552, a=0.08, b=0.06, radius=0.03),
        "steepening": cam(ELLIPSE, lead=0.5, kappa=1),
        "wavy": cam(TABLE, table=wavy),
        "dwell": cam(TABLE, table=dwell),
    }


PAIRS = [
    ("helix", "helix", 0.0),
    ("helix", "level", -0.2),
    ("helix", "flattening", -0.3),
    ("steepening", "helix", -0.3),
    ("flattening", "wide", 0.0),
    ("steepening", "flattening", -0.3),
    ("steepening", "steepening", -0.3),
    ("wavy", "helix", -0.3),
    ("wide", "wavy", -0.3),
    ("wavy", "wavy", 0.2),
    ("dwell", "helix", -0.3),
    ("helix", "dwell", 0.0),
    ("dwell", "flattening", 0.0),
    ("wavy", "dwell", 0.0),
    ("level", "steepening", -0.3),
]


@pytest.mark.parametrize(("first", "second", "lower"), PAIRS)
def test_course(library, courses, laws, first, second, lower):
    """Polynomials against the laws at the root; the root's residual; derivatives that belong together."""
    transmission = courses(laws[first], laws[second], lower, 1.3963)
    thetas = np.linspace(lower, 1.3963, 401)
    steep, high = np.zeros(2), 1e-300
    errors = []
    for theta in thetas:
        gamma = library.transmission_gamma(byref(transmission), theta)
        phi = theta - gamma
        p = [library.groove_at(byref(transmission.groove[i]), x) for i, x in enumerate((gamma, phi))]
        rounding = abs(p[0].z) + (p[0].slope + p[1].slope) * (abs(gamma) + abs(phi))
        assert abs(p[0].z - p[1].z) <= 4 * EPS * rounding
        point = library.point(library.transmission_piece(byref(transmission), theta, 0), theta)
        a = np.array([q.slope for q in p])
        z = library.transmission_z(byref(transmission), theta)
        turn = np.array([a[1], a[0]]) / a.sum()
        bend = np.array([q.dslope_dpsi for q in p]) * turn
        errors.append([*abs(a - list(point.slope)), abs(z - point.z), *abs(bend - list(point.dslope_dtheta))])
        steep, high = np.maximum(steep, a), max(high, abs(z))
    worst = np.max(errors, axis=0)
    assert (worst[:2] <= 1e-12 * steep).all()
    assert worst[2] <= 1e-12 * high
    assert (worst[3:] <= 1e-9 * (1 + steep)).all()


@pytest.mark.parametrize(("first", "second", "lower"), PAIRS)
def test_course_derivatives(library, courses, laws, first, second, lower):
    """bend, twist and dz/dtheta are the derivatives of the polynomials, and dz/dtheta is a1 a2/(a1+a2)."""
    transmission = courses(laws[first], laws[second], lower, 1.3963)
    for k in range(transmission.count):
        piece = transmission.piece[k]
        for theta in np.linspace(piece.lower, piece.upper, 7):
            x = (theta - piece.middle) * piece.scale
            point = library.point(byref(piece), theta)
            for i in range(2):
                p = np.polynomial.Polynomial([both[i] for both in piece.slope])
                size = sum(abs(p.coef)) * (1 + piece.scale) ** 2 * DEGREE**2
                assert point.slope[i] == pytest.approx(p(x), abs=1e-15 * size)
                assert point.dslope_dtheta[i] == pytest.approx(p.deriv()(x) * piece.scale, abs=1e-15 * size)
                assert point.d2slope_dtheta2[i] == pytest.approx(
                    p.deriv(2)(x) * piece.scale**2, abs=1e-15 * size
                )
            lift = point.slope[0] * point.slope[1] / (point.slope[0] + point.slope[1])
            z = np.polynomial.Polynomial(list(piece.z))
            assert point.z == pytest.approx(z(x), abs=1e-16)
            assert z.deriv()(x) * piece.scale == pytest.approx(lift, abs=3e-13 * (0.02 + max(point.slope)))


def test_course_of_ellipses_to_50_digits(library, courses, laws):
    first, second = laws["steepening"], laws["flattening"]
    transmission = courses(first, second)
    for theta in np.linspace(0.0, 1.3963, 9):
        with mpmath.workdps(40):
            gap = lambda g, t=theta: exact_ellipse(first, g)[0] - exact_ellipse(second, mpmath.mpf(t) - g)[0]  # noqa: E731
            gamma = mpmath.findroot(gap, (theta / 3, theta / 2 + 0.01), solver="anderson", tol=1e-60)
            one, two = exact_ellipse(first, gamma), exact_ellipse(second, mpmath.mpf(theta) - gamma)
        assert library.transmission_gamma(byref(transmission), theta) == pytest.approx(
            float(gamma), abs=4e-16
        )
        assert library.transmission_z(byref(transmission), theta) == pytest.approx(float(one[0]), abs=1e-17)
        point = library.point(library.transmission_piece(byref(transmission), theta, 0), theta)
        assert list(point.slope) == pytest.approx([float(one[1]), float(two[1])], rel=1e-13)


def test_two_helices_are_exact(library, courses, laws):
    transmission = courses(laws["helix"], cam(HELIX, lead=0.5, radius=0.03), -2.0, 3.0)
    assert transmission.straight and transmission.count == 1
    a = [transmission.groove[i].gain for i in range(2)]
    point = library.point(library.transmission_piece(byref(transmission), 1.7, 0), 1.7)
    assert list(point.slope) == a and list(point.dslope_dtheta) == list(point.d2slope_dtheta2) == [0.0, 0.0]
    assert point.z == library.transmission_z(byref(transmission), 1.7) == a[0] * (a[1] / (a[0] + a[1])) * 1.7


def test_pieces_meet(library, courses, laws):
    """In order, without gaps; values agree where they meet; knots of the table are marked."""
    transmission = courses(laws["wavy"], laws["flattening"], -0.3, 1.3963)
    pieces = [transmission.piece[k] for k in range(transmission.count)]
    assert pieces[0].lower == -0.3 and pieces[-1].upper == 1.3963
    knots = 0
    for left, right in pairwise(pieces):
        assert left.upper == right.lower and left.knot_upper == right.knot_lower
        a, b = (library.point(byref(p), left.upper) for p in (left, right))
        assert list(a.slope) == pytest.approx(list(b.slope), rel=1e-13)
        assert list(a.dslope_dtheta) == pytest.approx(list(b.dslope_dtheta), abs=1e-10)
        assert a.z == pytest.approx(b.z, abs=1e-16)
        gamma = library.transmission_gamma(byref(transmission), left.upper)
        if left.knot_upper:
            knots += 1
            assert gamma / 0.05 == pytest.approx(round(gamma / 0.05), abs=1e-12)
    first, last = (library.transmission_gamma(byref(transmission), theta) for theta in (-0.3, 1.3963))
    assert knots == math.floor(last / 0.05) - math.ceil(first / 0.05) + 1
    transmission = courses(laws["wavy"], laws["wavy"])  # a knot lies at the lower stop
    assert transmission.piece[0].knot_lower and not transmission.piece[transmission.count - 1].knot_upper


def test_piece_lookup(library, courses, laws):
    transmission = courses(laws["wavy"], laws["helix"])
    border = transmission.piece[2].upper
    width = transmission.piece[2].upper - transmission.piece[2].lower
    index = lambda theta, way: library.transmission_piece(byref(transmission), theta, way).contents.lower  # noqa: E731
    lower = [transmission.piece[k].lower for k in range(transmission.count)]
    for theta in (border, border + 1e-10 * width, border - 1e-10 * width):
        assert index(theta, 1) == lower[3]
        assert index(theta, -1) == lower[2]
    for way in (-1, 0, 1):
        assert index(border + 1e-3 * width, way) == lower[3]
        assert index(-5.0, way) == lower[0]
        assert index(9.0, way) == lower[-1]


def test_dwell_is_ordinary(library, courses, laws):
    """While cam 1 dwells, z stands still, the pin turns in it and nowhere else."""
    transmission = courses(laws["dwell"], laws["helix"])
    phi = 0.01 / 0.02
    for gamma in (0.55, 0.65, 0.75):
        theta = gamma + phi
        assert library.transmission_gamma(byref(transmission), theta) == pytest.approx(gamma, abs=1e-14)
        assert library.transmission_z(byref(transmission), theta) == pytest.approx(0.01, abs=1e-16)
        point = library.point(library.transmission_piece(byref(transmission), theta, 0), theta)
        assert point.slope[0] == pytest.approx(0.0, abs=1e-30)


@pytest.mark.parametrize("other", ["wavy", "flattening"])
@pytest.mark.parametrize("lead", [1e-300, 1e-310, 7e-315, 1e-320])
def test_a_nearly_level_helix_needs_few_pieces(library, courses, laws, lead, other):
    """Slopes and heights below 2e-308 have few digits, which no piece can be too wide for."""
    transmission = courses(cam(HELIX, lead=lead), laws[other], 0.0, 0.5)
    assert transmission.count < 100
    assert library.transmission_gamma(byref(transmission), 0.4) == pytest.approx(0.4)


def test_stops_on_one_side_of_zero(library, courses, laws):
    whole = courses(laws["flattening"], laws["helix"], -0.4, 1.3963)
    for lower, upper in ((0.4, 1.2), (-0.3, -0.1)):
        part = courses(laws["flattening"], laws["helix"], lower, upper)
        theta = 0.5 * (lower + upper)
        assert library.transmission_z(byref(part), theta) == library.transmission_z(byref(whole), theta)


def test_up_to_the_end_of_an_ellipse(library, courses, laws):
    """Level and close to vertical ends, the stop exactly there."""
    for name in ("flattening", "steepening"):
        probe = courses(laws[name], laws["helix"], 0.0, 0.1).groove[0]
        end = probe.last + library.groove_at(byref(probe), probe.last).z / 0.02
        transmission = courses(laws[name], laws["helix"], 0.0, end)
        assert transmission.count < 60
        for share in np.linspace(0.01, 0.999, 40):
            theta = share * end
            gamma = library.transmission_gamma(byref(transmission), theta)
            z = library.transmission_z(byref(transmission), theta)
            point = library.point(library.transmission_piece(byref(transmission), theta, 0), theta)
            exact = library.groove_slope(byref(transmission.groove[0]), gamma, z)
            assert point.slope[0] == pytest.approx(exact, rel=1e-11, abs=1e-15)


def test_end_of_a_groove_is_refused(library, laws):
    text = course_refusal(library, laws["helix"], laws["steepening"], 0.0, 5.0)
    for part in ("cam2.ellipse_a = 0.05", "stop.upper = 5", "S = S0 + kappa r psi/a must", "[0, 1)"):
        assert part in text
    last, theta = (float(text.split(key)[1].split()[0]) for key in ("psi = ", "theta = "))
    z, _, _, S = exact_ellipse(laws["steepening"], last)
    assert abs(float(S) - 1) < 2e-10 and theta == pytest.approx(last + float(z) / 0.02, abs=1e-4)
    text = course_refusal(library, laws["flattening"], laws["helix"], -5.0, 1.0)
    assert "cam1.ellipse_a" in text and "before stop.lower = -5" in text
    text = course_refusal(library, laws["wavy"], laws["helix"], 0.0, 9.0)
    assert "cam1.table" in text and "psi = 2.5" in text and "samples must reach" in text
    assert "stop.upper" in course_refusal(library, laws["wavy"], laws["helix"], 8.0, 9.0)
    assert "stop.lower" in course_refusal(library, laws["wavy"], laws["helix"], -9.0, -8.0)


def test_undetermined_pin_is_refused(library, laws):
    text = course_refusal(library, laws["level"], laws["level"])
    assert "cam1.lead_angle = 0 and cam2.lead_angle = 0" in text and "nothing fixes the pin" in text
    text = course_refusal(library, laws["dwell"], laws["dwell"], 0.0, 3.0)
    assert "cam1.table" in text and "cam2.table" in text and "nothing fixes the pin" in text


def test_stops_are_checked(library, laws):
    for lower, upper in ((1.0, 1.0), (2.0, 1.0), (math.nan, 1.0), (0.0, math.inf)):
        assert "stop.lower" in course_refusal(library, laws["helix"], laws["flattening"], lower, upper)


def test_too_many_pieces(library, tmp_path):
    """A table of more points than pieces are allowed is still possible: each knot adds to the limit."""
    psi = np.linspace(0.0, 2.0, 30_001)
    table = write_table(tmp_path / "t.csv", psi.tolist(), (0.02 * psi).tolist())
    transmission, fault = Transmission(), Fault()
    params = params_of(cam(TABLE, table=table), cam(HELIX, lead=math.pi / 4), 0.0, 1.0)
    assert library.transmission_build(byref(transmission), byref(params), None, byref(fault)), fault.text
    assert 7500 <= transmission.count <= 27500
    library.transmission_free(byref(transmission))


def test_course_is_of_its_grooves_and_stops(library, laws, courses):
    first, second = laws["wavy"], laws["flattening"]
    transmission = courses(first, second, 0.0, 1.0)

    def fits(*changes):
        params = params_of(first, second, 0.0, 1.0)
        for change in changes:
            change(params)
        return library.transmission_is_of(byref(transmission), byref(params))

    def path(i, text):
        return lambda params: setattr(params.table[i], "value", text)

    assert fits()
    assert fits(lambda p: setattr(p.cam[0], "friction", 0.3), path(1, b"of no matter to an ellipse"))
    assert not fits(path(0, b"another.csv"))
    assert not fits(lambda p: setattr(p.cam[1], "radius", 0.021))
    assert not fits(lambda p: setattr(p.cam[0], "profile", HELIX))
    assert not fits(lambda p: setattr(p.stop, "upper", 0.9))
    assert not library.transmission_is_of(byref(Transmission()), byref(params_of(first, second, 0.0, 0.0)))
