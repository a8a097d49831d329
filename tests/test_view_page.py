"""The page that `dualcam view` writes, driven in headless Chromium as a user would: scenes, sliders, mouse,
keys, refusals, small screens. tests/test_view_numbers.py compares the page's numbers with the FMU's."""

import json
import math
import re

import pytest
from pages import TEXTS
from view_scenes import CHROMIUM

from dualcam import Fmu, read_design, write_view
from dualcam.__main__ import main
from dualcam.design_file import write_template
from dualcam.errors import DualcamError, FmuError

STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP, WEDGED = range(1, 7)  # the FMU's `mode`


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api", reason="pip install playwright")
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed (Debian: chromium)")
    options = ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"]
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def default_page(tmp_path_factory):
    """The page of the default mechanism."""
    return write_view(None, tmp_path_factory.mktemp("view") / "default.html")


@pytest.fixture
def show(browser, default_page):
    """Opens a page; errors of its scripts and requests to anything but the file fail the test."""
    opened, faults = [], []

    def see_request(request):
        if not request.url.startswith(("file:", "data:", "blob:")):
            faults.append(f"request to {request.url}")

    def see_message(message):
        if message.type in ("error", "warning"):
            faults.append(message.text)

    def show(path=default_page, width=800, height=500, fragment="", init="", is_ready=True, **options):
        calm = {"reduced_motion": "reduce"}  # else the page plays a scene at once
        context = browser.new_context(viewport={"width": width, "height": height}, **(calm | options))
        opened.append(context)
        page = context.new_page()
        page.set_default_timeout(10_000)
        page.on("request", see_request)
        page.on("console", see_message)
        if is_ready:
            page.on("pageerror", lambda error: faults.append(str(error)))
        if init:
            page.add_init_script(init)
        page.goto(path.as_uri() + fragment)
        if is_ready:
            page.evaluate("dualcam.ready")
        return page

    yield show
    for context in opened:
        context.close()
    assert [fault for fault in faults if "GPU stall" not in fault and "WebGL" not in fault] == []


def get(page, name):
    return page.evaluate("name => dualcam.get(name)", name)


def field(page, name, kind="input[type=number]"):
    return page.locator(f'.field[data-name="{name}"] {kind}')


def enter(page, name, value):
    field(page, name).fill(str(value))
    field(page, name).press("Enter")


def frames(page, count=3):
    """Waits for some pictures."""
    page.evaluate(
        "count => new Promise(go => { const f = () => count-- ? requestAnimationFrame(f) : go(); f(); })",
        count,
    )


# ---- the file ----


def test_a_page_names_no_address(default_page):
    text = default_page.read_text(encoding="utf-8")
    markup = text.partition('<script type="importmap">')[0] + text.partition("</script>\n</head>")[2]
    assert re.findall(r"(?:src|href)=\"(?!data:|#)[^\"]*\"", markup) == []
    assert "default-src 'none'" in text
    assert "Copyright (c) 2010" in text or "three.js authors" in text  # the licence of three.js


def test_the_command_says_where_the_page_is(tmp_path, capsys):
    design = write_template("minimal", tmp_path / "my.toml")
    assert main(["view", str(design), "-o", str(tmp_path / "my.html")]) == 0
    assert f"{tmp_path / 'my.html'} written" in capsys.readouterr().out
    assert main(["view", "-o", str(tmp_path / "default.html"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["bytes"] == (tmp_path / "default.html").stat().st_size


def test_a_refused_design_has_no_page(tmp_path):
    """In Python the message is the FMU's."""
    design = tmp_path / "jams.toml"
    design.write_text('[cam1]\nlead_angle = "86 deg"\n[cam2]\nlead_angle = "86 deg"\n', encoding="utf-8")
    with Fmu("forward") as fmu, pytest.raises(FmuError, match="jam") as refused:
        fmu.start({"cam1.lead_angle": math.radians(86), "cam2.lead_angle": math.radians(86)})
    with pytest.raises(FmuError, match=re.escape(str(refused.value))):
        write_view(design, tmp_path / "my.html")
    assert not (tmp_path / "my.html").exists()


@pytest.mark.parametrize("words", [["view"], ["view", "my.toml"], ["view", "-o"]])
def test_wrong_use(words, capsys):
    assert main(words) == 2


def test_another_ending_is_refused(tmp_path):
    with pytest.raises(DualcamError, match=r"end in \.html"):
        write_view(None, tmp_path / "my.pdf")


def test_the_design_of_a_motion_says_what_the_page_shows(tmp_path, capsys, show):
    design = tmp_path / "imposed.toml"
    design.write_text(
        "[scenario]\nstop = 1.0\n[scenario.inputs.theta]\ntime = [0.0, 1.0]\nvalue = [0.0, 1.0]\n",
        encoding="utf-8",
    )
    assert read_design(design).model == "inverse"
    assert main(["view", str(design), "-o", str(tmp_path / "my.html")]) == 0
    assert "forward model" in capsys.readouterr().out
    page = show(tmp_path / "my.html")
    assert "forward model" in page.locator("#note").inner_text()
    assert get(page, "tau") == 0.0


# ---- clock and scripts ----


def test_the_page_plays_by_itself_until_a_script_comes(show):
    page = show(is_ready=False, reduced_motion="no-preference")
    page.wait_for_function("document.getElementById('clock').textContent > '0.05'")
    assert page.locator("#play").inner_text() == "Pause"
    page.evaluate("dualcam.ready")
    assert get(page, "time") == 0.0
    page.evaluate("dualcam.set('tau', 5); dualcam.step(0.01)")
    frames(page, 5)
    assert get(page, "time") == pytest.approx(0.01, abs=1e-15)
    assert page.locator("#clock").inner_text() == "0.010 s"
    page.locator("#play").click()
    page.wait_for_function("dualcam.get('time') > 0.1")
    assert get(page, "tau") == 5.0


def test_reduced_motion_waits_for_play(show):
    page = show(is_ready=False)
    page.wait_for_function("document.querySelectorAll('#presets button').length > 0")
    frames(page, 8)
    assert page.locator("#play").inner_text() == "Play"
    assert page.locator("#clock").inner_text() == "0.000 s"


def test_every_variable_can_be_read(show):
    page = show()
    with Fmu("forward") as fmu:
        fmu.start({})
        names = [v.name for v in fmu.description.variables]
        for name in names:
            value, expected = get(page, name), fmu.get(name)
            assert value == (
                pytest.approx(expected, rel=1e-9) if isinstance(expected, float) else expected
            ), name
    assert len(names) > 70


@pytest.mark.parametrize("call", ["dualcam.set('torque', 1)", "dualcam.get('torque')"])
def test_an_unknown_variable_is_named(show, call):
    page = show()
    assert "torque" in page.evaluate(
        f"(() => {{ try {{ {call} }} catch (e) {{ return e instanceof Error && e.message }} }})()"
    )


def test_the_block_of_the_documentation_runs(show):
    page = show()
    (block,) = re.findall(r"^```js\n(.*?)^```", TEXTS["docs/command-line.md"], re.M | re.S)
    page.evaluate(f"(async () => {{ {block} }})()")
    assert get(page, "time") == pytest.approx(0.5)
    assert get(page, "mode") == UPPER_STOP
    page.evaluate(f"(async () => {{ {block.partition('await dualcam.choose')[0]} }})()")
    assert get(page, "time") == pytest.approx(0.01)


# ---- scenes ----


def play(page, name, seconds, every=0.01):
    """Rows of time, mode, theta, tau, torque_load, torque_release of a scene."""
    return page.evaluate(
        """async ([name, seconds, every]) => {
          await dualcam.choose(name);
          const names = ["time", "mode", "theta", "tau", "torque_load", "torque_release"];
          const read = () => names.map(dualcam.get);
          const rows = [read()];
          for (let k = 0; k < seconds / every; k += 1) { dualcam.run(every); rows.push(read()); }
          return rows.map(row => row.map(x => x === -Infinity ? -1e300 : x)); }""",
        [name, seconds, every],
    )


def changes(rows):
    """The modes in their order, without repetition."""
    modes = [row[1] for row in rows]
    return [mode for k, mode in enumerate(modes) if k == 0 or mode != modes[k - 1]]


def test_scene_load(show):
    rows = play(show(), "Load", 3.0)
    assert changes(rows) == [LOWER_STOP, STICK, LOADING, STICK]
    assert rows[-1][2] > 1.0


def test_scene_release(show):
    """Cam 2 stands still until the torque is at the lower edge of the band."""
    rows = play(show(), "Release", 3.4)
    assert changes(rows) == [STICK, RELEASING, LOWER_STOP]
    still = [row for row in rows if row[1] == STICK]
    assert len({row[2] for row in still}) == 1
    assert still[0][3] == 7.0 and still[-1][3] == pytest.approx(still[-1][5], abs=0.05)


def test_scene_self_lock(show):
    """Without torque the loaded mechanism stands; a negative torque moves it back."""
    rows = play(show(), "Self-lock", 3.5)
    assert changes(rows) == [STICK, RELEASING, LOWER_STOP]
    assert all(row[5] < 0.0 and row[2] == 1.2 for row in rows if row[3] == 0.0)
    assert all(row[3] < 0.0 for row in rows if row[1] == RELEASING)


def test_scene_wedge(show):
    rows = play(show(), "Wedge", 3.2)
    assert changes(rows) == [WEDGED]
    assert {row[2] for row in rows} == {0.8}
    assert rows[-1][3] < -3.0 * rows[-1][4] < 0.0


def test_scene_stop(show):
    """It bounces more than once, comes to rest, and the list of events has it."""
    page = show()
    rows = play(page, "Stop", 1.0, 0.002)
    assert changes(rows)[-1] == UPPER_STOP and changes(rows).count(RELEASING) >= 2
    assert get(page, "energy.heat_stop") > 1.0
    assert "upper stop" in page.locator("#events li").first.inner_text()


def test_scene_stick_slip(show):
    rows = play(show(), "Stick-slip", 4.0)
    assert changes(rows).count(STICK) > 10 and changes(rows).count(LOADING) > 10
    assert rows[-1][2] > 1.0


def test_buttons_play_scenes_and_say_what_one_sees(show):
    page = show()
    buttons = page.locator("#presets button")
    names = buttons.all_inner_texts()
    assert names[1:] == ["Load", "Release", "Self-lock", "Wedge", "Stop", "Stick-slip"]
    said = set()
    for k in range(len(names)):
        buttons.nth(k).click()
        page.wait_for_function(
            "k => document.querySelectorAll('#presets button')[k].getAttribute('aria-pressed') === 'true'",
            arg=k,
        )
        said.add(page.locator("#preset-words").inner_text())
    assert len(said) == len(names) and all(words.endswith(".") for words in said)
    page.locator("#design").click()
    assert get(page, "cam1.lead_angle") == pytest.approx(math.pi / 4)


def test_scenario_of_a_design_plays(tmp_path, show):
    """Straight lines of torque, up and down, as in the file."""
    design = write_template("minimal", tmp_path / "my.toml")
    page = show(write_view(design, tmp_path / "my.html"))
    page.evaluate("dualcam.choose('Design').then(() => dualcam.run(0.5))")
    assert get(page, "tau") == pytest.approx(5.0, abs=0.01)
    page.evaluate("dualcam.run(1.0)")
    assert get(page, "tau") == pytest.approx(5.0, abs=0.01)
    assert page.title().startswith("Two helices of 45 deg")


# ---- sliders, mouse, keys ----


def test_fields_and_sliders_set_parameters(show):
    page = show()
    enter(page, "cam1.lead_angle", 30)
    assert get(page, "cam1.lead_angle") == pytest.approx(math.radians(30), abs=1e-15)
    assert page.locator('.field[data-name="cam1.lead_angle"] .other').inner_text() == "0.5236 rad"
    field(page, "cam1.friction", "input[type=range]").fill("0.3")
    assert get(page, "cam1.friction") == pytest.approx(0.3)
    assert field(page, "cam1.friction").input_value() == "0.3"
    assert not field(page, "cam1.ellipse_a").is_visible()
    field(page, "cam1.profile", "select").select_option("2")
    assert get(page, "cam1.profile") == 2
    page.wait_for_selector('.field[data-name="cam1.ellipse_a"]')
    field(page, "tau", "input[type=range]").fill("3")
    assert get(page, "tau") == pytest.approx(3.0, abs=0.02)


def test_a_fixed_parameter_that_begins_the_run_anew_says_so(show):
    """A tunable parameter changes at the present instant, and nothing begins anew before the run."""
    page = show()
    message = page.locator("#message")
    enter(page, "cam1.lead_angle", 40)
    assert not message.is_visible()
    page.evaluate("dualcam.set('tau', 5); dualcam.step(0.05)")
    enter(page, "cam1.friction", 0.2)
    assert not message.is_visible() and get(page, "energy.work_in") > 0.0
    enter(page, "cam1.lead_angle", 30)
    words = "cam1.lead_angle is fixed during a run: the model began anew with the present angle and speed"
    assert message.is_visible() and words in message.inner_text()
    assert get(page, "energy.work_in") == 0.0 and get(page, "time") == pytest.approx(0.05)
    enter(page, "cam1.friction", 0.1)
    assert not message.is_visible()
    page.evaluate("dualcam.set('initial.theta', 0.2)")
    assert "the model began anew at this start" in message.inner_text()


def test_all_parameters_have_a_field(show):
    page = show()
    named = page.evaluate("[...document.querySelectorAll('.field')].map(e => e.dataset.name)")
    with Fmu("forward") as fmu:
        known = [v.name for v in fmu.description.variables if v.causality in ("parameter", "input")]
    assert sorted(named) == sorted(known)


def test_every_control_has_a_name(show):
    """For screen readers: a label, an aria-label or a text."""
    page = show()
    nameless = page.evaluate(
        """[...document.querySelectorAll('button, input, select, canvas, a[href]')].filter(
          e => !(e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim())
        ).map(e => e.outerHTML)"""
    )
    assert nameless == []


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("spring.stiffness", -5, "spring.stiffness"),
        ("cam1.radius", 0, "cam1.radius"),
        ("stop.upper", -10, "stop.upper"),
    ],
)
def test_a_refused_value_is_explained_and_the_last_one_stays(show, name, value, words):
    page = show()
    before = get(page, name)
    enter(page, name, value)
    said = page.locator("#message").inner_text()
    assert words in said and "last good value stays" in said and "fmi2" not in said
    assert get(page, name) == before
    assert float(field(page, name).input_value()) > 0.0
    page.evaluate("dualcam.set('tau', 5); dualcam.step(0.01)")
    assert get(page, "theta") > 0.0
    enter(page, "cam1.friction", 0.1)
    assert not page.locator("#message").is_visible()


def test_a_parameter_is_dragged_to_where_the_mechanism_jams(show):
    page = show()
    enter(page, "cam1.lead_angle", 80)
    slider = field(page, "cam2.lead_angle", "input[type=range]")
    slider.evaluate("e => { e.value = 1.5; e.dispatchEvent(new Event('input')); }")
    assert "jam" in page.locator("#message").inner_text()
    assert get(page, "cam2.lead_angle") == pytest.approx(math.pi / 4)
    slider.evaluate("e => e.dispatchEvent(new Event('change'))")
    assert float(slider.input_value()) == pytest.approx(math.pi / 4, abs=2e-3)


def test_angles_of_the_drawing_stay_inside_the_stops(show):
    """lower + (upper - lower) is above upper by rounding."""
    lower, upper = -0.7, 1.3963
    assert lower + (upper - lower) > upper
    page = show()
    assert get(page, "stop.upper") == upper
    page.evaluate("lower => dualcam.set('stop.lower', lower)", lower)
    frames(page)
    assert not page.locator("#message").is_visible()
    page.locator("#step").click()
    frames(page)
    assert page.locator("#clock").inner_text() == "0.001 s"


@pytest.mark.parametrize("end", ["min", "max"])
@pytest.mark.parametrize("name", ["cam1.lead_angle", "cam2.lead_angle"])
def test_flat_and_steepest_grooves_leave_the_page_alive(show, name, end):
    page = show()
    slider = field(page, name, "input[type=range]")
    slider.evaluate(f"e => {{ e.value = e.{end}; e.dispatchEvent(new Event('input')); }}")
    frames(page)
    if page.locator("#message").is_visible():
        assert "cannot be drawn" not in page.locator("#message").inner_text()
        assert "allowed is 0 to" not in page.locator("#message").inner_text()  # the slider's own end
    assert "infinite" not in page.locator("#apart").inner_text()
    enter(page, name, 40)
    page.locator("#step").click()
    frames(page)
    assert page.locator("#clock").inner_text() == "0.001 s"


def test_reset_keeps_the_parameters_and_the_design_is_a_button_of_its_own(show):
    page = show()
    enter(page, "cam1.radius", 30)  # mm
    page.evaluate("dualcam.set('tau', 5); dualcam.step(0.01)")
    page.locator("#reset").click()
    assert [get(page, name) for name in ("time", "theta", "tau", "cam1.radius")] == [0, 0, 0, 0.03]
    page.locator("#design").click()
    assert get(page, "cam1.radius") == 0.02
    page.evaluate("dualcam.set('cam1.radius', 0.03); dualcam.reset()")  # as fmi2Reset
    assert get(page, "cam1.radius") == 0.02


def test_a_table_that_is_missing_is_explained(show):
    page = show()
    field(page, "cam1.profile", "select").select_option("3")
    assert "cam1.table" in page.locator("#message").inner_text()
    assert field(page, "cam1.profile", "select").input_value() == "1"


def test_dragging_turns_cam_2(show):
    page = show()
    box = page.locator("#view").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + 0.6 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y, steps=4)
    page.wait_for_function("dualcam.get('theta') > 0.2")
    assert "N.m" in page.locator("#hand").inner_text()
    page.wait_for_function("dualcam.get('mode') === 1")
    assert 0.5 < get(page, "tau") <= 1.6 * 9.92
    page.mouse.up()
    page.wait_for_function("dualcam.get('tau') === 0")
    assert not page.locator("#hand").is_visible()


def test_dragging_beside_the_mechanism_turns_the_view(show):
    page = show()
    view = page.locator(".view")
    before = view.screenshot()
    box = page.locator("#view").bounding_box()
    page.mouse.move(box["x"] + 12, box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + 150, box["y"] + 60, steps=3)
    page.mouse.up()
    frames(page)
    assert get(page, "time") == 0.0
    assert view.screenshot() != before


def test_keys(show):
    page = show()
    page.locator("body").click(position={"x": 2, "y": 2})
    page.keyboard.press("2")
    page.wait_for_function("dualcam.get('time') > 0.02")
    assert "rises" in page.locator("#preset-words").inner_text()
    page.keyboard.press("Space")
    assert page.locator("#play").inner_text() == "Play"
    time = get(page, "time")
    page.keyboard.press(".")
    assert get(page, "time") == pytest.approx(time + 1e-3)
    page.keyboard.press("[")
    assert page.locator("#speed").input_value() == "0.3"
    page.keyboard.press("r")
    assert get(page, "time") == 0.0
    page.evaluate("dualcam.reset()")
    page.keyboard.down("d")
    for _ in range(15):
        page.keyboard.down("d")
    page.wait_for_function("dualcam.get('tau') > 0.3")
    page.keyboard.up("d")
    page.wait_for_function("dualcam.get('tau') === 0")
    page.keyboard.press("Space")
    before = page.locator(".view").screenshot()
    page.locator("#view").focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("+")
    frames(page)
    assert page.locator(".view").screenshot() != before


def test_letters_in_a_field_are_no_keys(show):
    page = show()
    page.evaluate("dualcam.set('tau', 5); dualcam.step(0.01)")
    field(page, "cam1.friction").focus()
    page.keyboard.press("r")
    page.keyboard.press("2")
    assert get(page, "time") == pytest.approx(0.01)


# ---- screens and browsers ----


@pytest.mark.parametrize("fragment", ["", "#compact"])
@pytest.mark.parametrize("width", [360, 400, 700, 1000, 1400])
def test_no_sideways_scrolling(show, width, fragment):
    page = show(width=width, height=700, fragment=fragment)
    page.evaluate("dualcam.choose('Stop').then(() => dualcam.run(0.5))")
    frames(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    outside = page.evaluate(
        """[...document.querySelectorAll('button, input, select, canvas')].filter(
          e => e.getBoundingClientRect().right > innerWidth
        ).map(e => e.id || e.outerHTML)"""
    )
    assert outside == []


def test_compact_fits_a_frame(show):
    page = show(width=1000, height=700, fragment="#compact")
    assert page.evaluate("document.documentElement.scrollHeight") <= 700
    assert not page.locator("#parameters").is_visible()
    page.locator("#more").click()
    assert page.locator("#parameters").is_visible()


def test_the_frame_of_another_page_is_compact(tmp_path, default_page, show):
    (tmp_path / "frame.html").write_text(
        f'<iframe src="{default_page.as_uri()}" width="1000" height="700"></iframe>', encoding="utf-8"
    )
    page = show(tmp_path / "frame.html", width=1100, is_ready=False)
    frame = page.frame_locator("iframe")
    frame.locator("#more").wait_for()
    assert not frame.locator("#parameters").is_visible()
    assert not show().locator("#more").is_visible()


def test_light_and_dark(show):
    colour = "getComputedStyle(document.body).backgroundColor"
    page = show(color_scheme="dark")
    dark = page.evaluate(colour)
    page.locator("#theme").click()
    light = page.evaluate(colour)
    assert sum(map(int, re.findall(r"\d+", dark))) < 150 < 600 < sum(map(int, re.findall(r"\d+", light)))
    assert show(color_scheme="light").evaluate(colour) == light


WITHOUT_WEBGL = """
const get = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith("webgl") ? null : get.call(this, kind, ...more);
};
"""


def test_without_webgl_the_drawings_work(browser, default_page):
    page = browser.new_page()
    page.add_init_script(WITHOUT_WEBGL)
    page.goto(default_page.as_uri())
    page.evaluate("dualcam.ready")
    assert "WebGL is missing" in page.locator("#no-view").inner_text()
    before = page.locator("#torque").screenshot()
    page.evaluate("dualcam.choose('Load').then(() => dualcam.run(1.5))")
    frames(page)
    assert page.locator("#torque").screenshot() != before
    assert page.locator("#mode").inner_text() == "loading"
    page.close()


def test_without_webassembly_the_page_says_what_to_do(show):
    page = show(init="delete window.WebAssembly;", is_ready=False)
    page.wait_for_selector("#message:visible")
    said = page.locator("#message").inner_text()
    assert "WebAssembly" in said and "Use a current" in said


def test_groove_table_of_a_design(tmp_path, show):
    """The page holds the table; the drawings show the groove."""
    rows = "".join(f"{0.01 * k!r},{0.02 * math.tan(0.6) * 0.01 * k!r}\n" for k in range(150))
    (tmp_path / "groove.csv").write_text("psi_rad,z_m\n" + rows, encoding="utf-8")
    design = tmp_path / "my.toml"
    design.write_text('[cam1]\nprofile = "table"\ntable = "groove.csv"\n', encoding="utf-8")
    page = show(write_view(design, tmp_path / "my.html"))
    assert get(page, "cam1.table") == "cam1.csv"
    page.evaluate("dualcam.set('tau', 6); dualcam.step(0.05)")
    assert get(page, "theta") > 0.1
