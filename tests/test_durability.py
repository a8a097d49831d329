"""What lasts, as a user of design files meets it: keys, messages, findings of the check, the report."""

import itertools
import json
import math
import re
import runpy

import pytest
from driver import ROOT
from lxml import etree

from dualcam.checking import check_design
from dualcam.checking.trouble import shown_beside, with_value
from dualcam.cli import main
from dualcam.design import HelicalSpring, Pin, Roller, line_contact, wear
from dualcam.design_file import read_design, write_template
from dualcam.design_file.durability import change_words, wear_words
from dualcam.errors import DesignFileError
from dualcam.report.page import report_page

PIN = '[pin]\nradius = "3 mm"\nwidth = "8 mm"\n'
COIL = '[helical_spring]\nwire_diameter = "5 mm"\ncoil_diameter = "26 mm"\nactive_coils = 7.5\n'
RATES = 'cam1.wear = "1e-6 mm^3/(N.m)"\ncam2.wear = 1e-15\n'
NEST = 'cam1.radius = "15 mm"\ncam2.radius = "30 mm"\n'
STIFFNESS = NEST + 'spring.stiffness = "48.3 N/mm"\n'
STRONG = STIFFNESS + COIL + 'grade = "DH"\nshot_peened = true\nguided = true\n'


@pytest.fixture
def design(tmp_path):
    def read(text):
        path = tmp_path / "my.toml"
        path.write_text(text)
        return read_design(path)

    return read


@pytest.fixture
def texts(design):
    """Severity and text of each finding."""
    return lambda text: [(one.severity, one.text) for one in check_design(design(text)).findings]


# ---- reading ----


def test_tables_become_objects(design):
    found = design(
        PIN
        + "wear = 1e-16\n[roller]\nbearing_friction = 0.1\nbearing_radius = '1 mm'\n"
        + COIL
        + 'grade = "SM"'
    )
    assert found.pin == Pin(0.003, 0.008, wear=1e-16)
    assert found.roller == Roller(0.003, 0.1, 0.001)
    assert found.helical_spring == HelicalSpring(0.005, 0.026, 7.5, grade="SM")
    limits = design('[limits]\nspring_safety = 1.5\nwear_depth = "50 um"\ncycles = 1e5').limits
    assert (limits.spring_safety, limits.wear_depth, limits.cycles) == (1.5, pytest.approx(50e-6), 1e5)


def test_another_pin_is_another_roller(design):
    found = design(PIN + "[roller]\nbearing_friction = 0.1\nbearing_radius = '1 mm'")
    assert with_value(found, "pin.radius", 0.004).roller == Roller(0.004, 0.1, 0.001)


@pytest.mark.parametrize(
    "text, words",
    [
        (PIN.replace("3 mm", "-3 mm"), "line 2: pin.radius = \"-3 mm\": allowed is a number >= 0"),
        (PIN + "wear = -1", "line 4: pin.wear = -1: allowed is a number from 0 to 1 in m3/(N.m)"),
        (COIL, 'line 1: [helical_spring] no material: give grade = "DH", or SL, SM, DM or SH of EN 10270-1'),
        (COIL + 'grade = "piano"', "[helical_spring] grade = 'piano': allowed are SL, SM, DM, SH, DH"),
        (COIL.replace("5 mm", "25 mm") + 'grade = "DH"', "grade DH is known from 0.3 to 20 mm"),
        (COIL.replace("26 mm", "4 mm") + 'grade = "DH"', "allowed is more than wire_diameter = 0.005 m"),
        ("[helical_spring]\nwire_diameter = 0.005", "[helical_spring] lacks coil_diameter, active_coils"),
        (COIL.replace("7.5", "1"), "helical_spring.active_coils = 1: allowed is a number from 2 to 10000"),
        (COIL + "material = 1", "helical_spring.material is no key: did you mean helical_spring.grade?"),
        (COIL + "d = 1", "helical_spring.d is no key: did you mean helical_spring.wire_diameter?"),
        ("[roller]\nbearing_friction = 0.1\nbearing_radius = 1e-3", "[roller] without [pin]: give pin"),
        (PIN + "[roller]\nbearing_friction = 0.1", "line 4: [roller] lacks bearing_radius: give"),
        (
            PIN + '[roller]\nbearing_friction = 0.1\nbearing_radius = "4 mm"',
            "[roller] bearing_radius = 0.004 m: allowed is more than 0 and less than the radius of the",
        ),
        ("[limits]\ncycles = -5", "line 2: limits.cycles = -5: allowed is a number from 0 to 1e+15"),
        ("[limits]\nwear_depth = 0", "limits.wear_depth = 0: allowed is a number from 1e-09 to 1 in m"),
        ("[limits]\nspring_safety = 0", "limits.spring_safety = 0: allowed is a number from 0.01 to 100"),
    ],
)  # fmt: skip
def test_refused_files(design, text, words):
    with pytest.raises(DesignFileError) as error:
        design(text)
    assert words in str(error.value)


def test_numbers_that_look_like_another_unit(design):
    found = design(
        "[pin]\nradius = 0.003\nwidth = 0.008\nwear = 1e-6\n"
        "[helical_spring]\nwire_diameter = 0.5\ncoil_diameter = 26\nactive_coils = 7\n"
        'tensile_strength = "1 GPa"'
    ).warnings
    assert [one.key for one in found] == [
        "pin.wear",
        "helical_spring.wire_diameter",
        "helical_spring.coil_diameter",
    ]
    assert "this looks like millimetres; 0.5 mm is 0.0005 m" in found[1].text


# ---- findings ----


def test_a_good_spring_has_no_finding(texts):
    assert texts(STRONG) == []


def followed(text, said):
    """The text of a design with all keys that a proposal of a spring names, taken from the message."""
    keys = r'(grade|wire_diameter|coil_diameter|active_coils|free_length|solid_length) = ("[^"]*"|[\d.]+)'
    found = dict(re.findall(keys, said.partition("A spring that lasts:")[2].rstrip(".")))
    assert len(found) == 6
    for key in ("grade", "wire_diameter", "coil_diameter", "active_coils"):
        text = re.sub(rf"\n{key} = .*", f"\n{key} = {found[key].rstrip('.')}", text)
    lengths = (f"spring.{key} = {found[key]}\n" for key in ("free_length", "solid_length"))
    return "".join(lengths) + text


def test_a_proposed_spring_can_be_followed_to_the_letter(design):
    """Weak springs of several rates and grades: with all keys of the proposal nothing is found."""
    count = 0
    for grade, stiffness, guided in itertools.product(("SL", "SM", "SH", "DM"), (9.7, 31.3, 66.6), (0, 1)):
        # the coils for the rate, D = 26 mm, d = 4 mm: G d^4/(8 D^3 R)
        coils = 81.5e9 * 0.004**4 / (8.0 * 0.026**3 * 1e3 * stiffness)
        text = (
            f'{NEST}spring.stiffness = "{stiffness} N/mm"\nlimits.spring_safety = 1.45\n[helical_spring]\n'
            f'wire_diameter = "4 mm"\ncoil_diameter = "26 mm"\nactive_coils = {coils:.6f}\n'
            f'grade = "{grade}"\nguided = {"true" if guided else "false"}\n'
        )
        said = " ".join(one.text for one in check_design(design(text)).errors)
        if "A spring that lasts" in said:
            count += 1
            assert check_design(design(followed(text, said))).findings == ()
    assert count >= 4


def test_fatigue(design, texts):
    """By hand: 50 N and 724.4 N, k = (5.2 + 0.5)/(5.2 - 0.75) = 1.2809, tau_k = k 8 D F/(pi d^3)."""
    weak = STIFFNESS + COIL + 'grade = "SM"\nguided = true\n'
    forces = (50.0, 50.0 + 48.3e3 * 0.01 * 1.3963)
    stress = [5.7 / 4.45 * 8.0 * 0.026 * force / (math.pi * 0.005**3) for force in forces]
    amplitude, mean = (stress[1] - stress[0]) / 2.0, (stress[1] + stress[0]) / 2.0
    shear = 0.67e6 * (1980.0 - 740.0 * math.log10(5.0))
    falling = 1.0 / (amplitude / (241e6 / (1.0 - 379e6 / shear)) + mean / shear)
    safety = min(241e6 / amplitude, falling)
    ((severity, text),) = texts(weak)
    assert severity == "error"
    assert (
        f"between {stress[0] / 1e6:.4g} and {stress[1] / 1e6:.4g} MPa the Goodman safety is {safety:.3g}"
        in text
    )
    assert "allowed is 1.2 or more, the default of limits.spring_safety" in text
    assert check_design(design(followed(weak, text))).findings == ()
    assert texts(weak.replace("SM", "DM") + f"[limits]\nspring_safety = {safety - 0.01:.3f}") == []


def test_a_spring_that_sets(texts):
    thin = COIL.replace('"5 mm"', '"3.2 mm"').replace("7.5", "2") + 'grade = "SL"'
    found = dict(reversed([(text.partition(":")[0], text) for _, text in texts(thin)]))
    assert "allowed is 0.56 of the tensile strength" in found["spring stress"]


def test_no_spring_lasts(texts):
    """So stiff that no wire up to 20 mm endures the force."""
    found = texts("[spring]\nstiffness = 9e6\n" + COIL + 'grade = "DH"')
    assert any(
        "No spring in a standard wire lasts; shot_peened = true makes a wire endure more" in t
        for _, t in found
    )


@pytest.mark.parametrize(
    "text, words",
    [
        (
            STRONG.replace("48.3", "52"),
            "helical_spring has the rate 48.3 N/mm, and spring.stiffness is 52 N/mm",
        ),
        (STRONG.replace("48.3", "52"), "active_coils = 6.967"),
        (
            STRONG.replace("DH", "SH") + "[limits]\nspring_safety = 1.1",
            'helical_spring.grade = SH: EN 10270-1 has this wire for static duty; write grade = "DH"',
        ),
        (STRONG.replace("DH", "SM") + "[limits]\ncycles = 1e6", 'static duty; write grade = "DM"'),
        (
            STRONG.replace("26 mm", "18 mm").replace("7.5", "22.6"),
            "spring index coil_diameter/wire_diameter = 3.6: a spring coiled cold has 4 to 20",
        ),
        ('spring.free_length = "60 mm"\nspring.solid_length = "40 mm"\n' + STRONG, "write the larger one"),
        (
            'spring.free_length = "65 mm"\nspring.solid_length = "47 mm"\n' + STRONG,
            "spring length at full stroke, 50 mm: allowed is 55.41 mm or more",
        ),
        (
            'spring.free_length = "260 mm"\nspring.solid_length = "47.5 mm"\n'
            + STRONG.replace("guided = true", "guided = false").replace("48.3", "49")
            + "[stop]\nupper = 3.5",
            "buckling: between parallel plates the spring of free_length = 260 mm buckles at the deflection",
        ),
        (
            PIN + '[roller]\nbearing_friction = 0.3\nbearing_radius = "2.5 mm"',
            "the roller slides: rolling needs the coefficient 0.25, sliding only sliding_friction = 0.14; the"
            " roller rolls with bearing_friction up to 0.168",
        ),
        (
            PIN + '[roller]\nbearing_friction = 0.06\nbearing_radius = "1.5 mm"',
            "cam1.friction = 0.14: the roller rolls with the coefficient 0.03; write cam1.friction = 0.03",
        ),
        (PIN + "[limits]\ncycles = 1e6", "limits.cycles = 1e+06 is not checked: give cam1.wear, cam2.wear"),
        (
            "[limits]\ncycles = 1e6",
            "give [pin] and cam1.wear, cam2.wear or pin.wear, the specific wear rates",
        ),
    ],
)
def test_warnings(texts, text, words):
    found = [message for severity, message in texts(text) if severity == "warning"]
    assert any(words in message for message in found), found


def test_a_spring_of_another_rate_is_an_error(texts):
    """Its stress is that of a spring that cannot be: 48.3 N/mm of the coil beside 60 N/mm."""
    ((severity, text),) = texts(STRONG.replace("48.3", "60"))
    assert severity == "error" and "active_coils = 6.038" in text


def test_grades_for_dynamic_duty_get_no_warning(texts):
    assert texts(STRONG + "[limits]\nspring_safety = 1.1") == []
    assert texts(STRONG.replace("DH", "SH")) == []  # nobody asks for a number of cycles or a safety


def test_a_pin_thicker_than_its_cam(texts):
    found = dict(reversed(texts('cam1.radius = "20 mm"\n[pin]\nradius = "30 mm"\nwidth = "8 mm"')))
    assert any("pin.radius = 30 mm: allowed is less than cam1.radius = 20 mm" in t for t in found.values())


def test_a_value_just_beside_its_limit_does_not_look_like_the_limit(texts):
    assert shown_beside(1.1996, 1.2) == "1.1996" and shown_beside(1.1, 1.2) == "1.1"
    assert shown_beside(1.2, 1.2) == "1.2"
    spring = HelicalSpring(0.005, 0.026, 7.5, grade="DM")
    safety = spring.fatigue(50.0, 50.0 + 48.3e3 * 0.013963).safety
    ((_, text),) = texts(STIFFNESS + COIL + f'grade = "DM"\n[limits]\nspring_safety = {safety + 1e-4:.5f}')
    shown = re.search(r"Goodman safety is ([\d.]+): allowed is ([\d.]+) or more", text)
    assert float(shown[1]) < float(shown[2])


def test_lengths_that_are_not_checked_are_named(design):
    lines = check_design(design(STRONG)).numbers.lines()
    words = "spring length and buckling: not checked, the file gives no spring.free_length"
    assert any(words in line for line in lines)
    lengths = 'spring.free_length = "75 mm"\nspring.solid_length = "47.5 mm"\n'
    assert not any(words in line for line in check_design(design(lengths + STRONG)).numbers.lines())


def test_a_value_that_works_keeps_the_coils_apart(design):
    """Not at the solid length, which would leave a warning."""
    solid = design('spring.free_length = "60 mm"\nspring.solid_length = "47.5 mm"\n' + STRONG)
    errors = {finding.kind: finding for finding in check_design(solid).errors}
    assert set(errors) == {"solid length", "spring length"}
    # 60 mm - 55.41 mm - 50 N/(48.3 N/mm) on two equal helices of 45 deg, 10 mm/rad
    assert errors["solid length"].nearest == pytest.approx(0.3555, abs=1e-3)
    assert check_design(with_value(solid, "stop.upper", errors["solid length"].nearest)).findings == ()


def test_a_spring_at_the_solid_length_of_its_coil_is_an_error(texts):
    found = texts('spring.free_length = "55 mm"\nspring.solid_length = "30 mm"\n' + STRONG)
    assert any(
        severity == "error" and "spring length at full stroke, 40 mm" in text for severity, text in found
    )


def test_wear_proposes_a_width_that_lasts(design):
    text = RATES + PIN + "[limits]\ncycles = 2e6"
    verdict = check_design(design(text))
    (finding,) = verdict.errors
    assert "wear: groove 1 is 0.1 mm deep (limits.wear_depth) after" in finding.text
    assert finding.change == "pin.width"
    assert finding.nearest == pytest.approx(0.008 * 2e6 / 1482585, rel=2e-3)  # depth per cycle as 1/width
    assert check_design(with_value(design(text), "pin.width", finding.nearest)).good


def test_a_roller_that_rolls_wears_all_around(design):
    """The roller of a rolling pin has no flat, so it lasts longer."""
    pin = PIN + 'wear = "1e-6 mm^3/(N.m)"\n'
    roller = '[roller]\nbearing_friction = 0.14\nbearing_radius = "2.99 mm"\n'
    sliding, rolling = (check_design(design(pin + more)).numbers.wear for more in ("", roller))
    assert sliding.part == rolling.part == "pin" and rolling.cycles > 10.0 * sliding.cycles
    words = "the wear rates must be those of a rolling contact"
    assert words in wear_words(rolling) and words not in wear_words(sliding)


# ---- numbers, command line and report ----


def test_numbers_are_those_of_the_functions(design):
    found = design(RATES + STRONG.removeprefix(NEST) + PIN)  # equal radii
    numbers, mechanism = check_design(found).numbers, found.mechanism()
    load = 50.0 + 48.3e3 * 0.013963
    contact = line_contact(load / 4.0 * math.sqrt(2.0) / 0.86, found.pin)  # two helices of 45 deg, by hand
    assert (numbers.pressure.shear, numbers.pressure.depth) == pytest.approx((contact.shear, contact.depth))
    assert (numbers.spring.least, numbers.spring.largest) == pytest.approx((50.0, load))
    assert numbers.spring.safety == found.helical_spring.fatigue(50.0, numbers.spring.largest).safety
    worn = wear(mechanism, found.pin, (1e-15, 1e-15))
    assert numbers.wear.cycles == worn.life(1e-4).cycles
    assert numbers.wear.preload_loss == worn.after(numbers.wear.cycles).preload_loss
    assert numbers.roller is None
    worn, before = worn_and_new(worn.after(numbers.wear.cycles))
    for change, after, new in zip(("load_change", "release_change"), worn, before, strict=True):
        low, high = getattr(numbers.wear, change)
        assert (low, high) == pytest.approx(((after / new - 1.0).min(), (after / new - 1.0).max()))
    assert -0.1 < numbers.wear.load_change[0] < numbers.wear.load_change[1] < 0.0
    assert " % less, the releasing torque is " in wear_words(numbers.wear)


def worn_and_new(found):
    return (found.load, found.release), (found.new_load, found.new_release)


@pytest.mark.parametrize("ends, words", [
    ((0.000176, 0.00524), "0.0176 % to 0.524 % more"),
    ((-0.0173, 0.041), "1.73 % less to 4.1 % more"),
    ((-0.0385, -0.012), "1.2 % to 3.85 % less"),
    ((-0.02, 1e-16), "0 % to 2 % less"),
    ((0.013, 0.013), "1.3 % more"),
])  # fmt: skip
def test_both_ends_of_a_change_are_said(ends, words):
    assert change_words(*ends) == words


def test_a_worn_cam_may_need_more_torque(design):
    """Ellipses that flatten wear most at the lower stop, so the groove gets steeper than it was."""
    ellipse = 'profile = "ellipse", lead_angle = "35 deg", wear = 1e-15'
    spring = "[spring]\npreload = 500\nstiffness = 1e4\n"
    text = f"cam1 = {{{ellipse}}}\ncam2 = {{{ellipse}}}\nstop.upper = 0.8\n{spring}{PIN}"
    found = check_design(design(text)).numbers.wear
    assert 0.0 < found.load_change[0] < found.load_change[1]
    assert re.search(r"the torque to load is [\d.]+ % to [\d.]+ % more, the releasing", wear_words(found))


def test_a_self_locking_cam_has_no_releasing_torque(design):
    cams = "".join(f'cam{i} = {{lead_angle = "10 deg", friction = 0.3, wear = 1e-15}}\n' for i in (1, 2))
    text = cams + PIN + "[limits]\nself_locking = true\n"
    found = check_design(design(text)).numbers.wear
    assert found.load_change is not None and found.release_change is None
    assert "releasing torque" not in wear_words(found)


def test_wear_deeper_than_the_formulas_hold_has_no_torque(design):
    found = check_design(design(RATES + PIN + "[limits]\nwear_depth = 0.002")).numbers
    assert found.wear.preload_loss is None
    assert any("the cam does not work any more then" in line for line in found.lines())


def test_check_prints_and_writes_json(tmp_path, capsys):
    path = write_template("robot", tmp_path / "my.toml")
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().out
    for words in (
        "shear stress below the surface: at most",
        "spring: rate 41.",
        "Goodman safety 1.2",
        "wear: pin is",
    ):
        assert words in said
    assert main(["check", str(path), "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)["numbers"]
    assert (
        numbers["spring"]["safety"] > 1.2 and numbers["wear"]["part"] == "pin" and numbers["roller"] is None
    )


def test_report_has_the_quantities_and_their_pictures(design):
    roller = '[roller]\nbearing_friction = 0.1\nbearing_radius = "1.5 mm"\n'
    page = etree.HTML(
        report_page(design('title = "Cam"\n' + RATES + STRONG + PIN + "wear = 1e-16\n" + roller))
    )
    assert [head.text for head in page.iter("h2")][2:7] == [
        *("Reactions", "Contact pressure", "Roller", "Helical spring", "Wear"),
    ]
    words = re.sub(r"\s+", " ", " ".join(page.itertext()))
    for piece in (
        "largest shear stress there",
        "Goodman safety",
        "groove 1: cycles until 0.1 mm",
        "Goodman line",
        "the roller rolls",
        "torque to load after that",
        "releasing torque after that",
    ):
        assert piece in words
    titles = {svg.get("aria-label") for svg in page.iter("svg")}
    assert titles >= {
        *("Contact pressure along each groove", "Wear along each groove", "Goodman diagram of the spring"),
    }
    inputs = [row[0].text for row in page.iter("tr") if len(row)]
    assert {"helical_spring.grade", "roller.bearing_radius", "pin.wear"} <= set(inputs)


def test_report_of_a_design_that_does_not_work(design):
    """An undercut flank and a spring that pulls: the report says so, and has no numbers of these."""
    ellipse = 'profile = "ellipse", ellipse_a = "10 mm", ellipse_b = "10 mm"'
    sharp = f"cam1 = {{{ellipse}, wear = 1e-15}}\nstop.upper = 0.3\n"
    words = " ".join(etree.HTML(report_page(design(sharp + PIN.replace("3 mm", "11 mm")))).itertext())
    assert "No wear: pin.radius = 0.011 m: a flank is undercut" in words
    slack = "[spring]\npreload = 0\nstiffness = 0\n" + COIL + 'grade = "DH"'
    assert "Goodman safety" in " ".join(etree.HTML(report_page(design(slack))).itertext())
    pulls = "[spring]\npreload = -10\n" + COIL + 'grade = "DH"'
    words = " ".join(etree.HTML(report_page(design(pulls))).itertext())
    assert "No stresses: forces -10 and" in words


def test_pictures_of_the_page_are_drawn(tmp_path):
    """Those that docs/design-quantities.md shows, from the design on that page."""
    script = ROOT / "docs" / "figures" / "design_quantities.py"
    runpy.run_path(str(script))["draw_all"](tmp_path)
    page = (ROOT / "docs" / "design-quantities.md").read_text(encoding="utf-8")
    assert {path.name for path in tmp_path.iterdir()} == set(re.findall(r"\]\((design_\w+\.png)\)", page))
