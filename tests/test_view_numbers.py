"""The engine of the page (dualcam/view/engine.js) against the FMU: the same C code, as WebAssembly in node
and in Chromium, and as the binary of this machine behind dualcam.Fmu."""

import json
import subprocess

import numpy as np
import pytest
import view_scenes
from view_scenes import CHROMIUM, NODE, READ, SCENES, Scene, numbers, refusals, run_in_node, run_on_fmu

import dualcam.view
from dualcam import Fmu
from dualcam.errors import FmuError
from dualcam.fmi.library import web_path

STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP = range(1, 6)  # the FMU's `mode`

needs_node = pytest.mark.skipif(NODE is None, reason="node is not installed (Debian: nodejs)")
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed (Debian: chromium)")


@pytest.fixture(scope="module")
def on_fmu(tmp_path_factory):
    """The results of the FMU, each scene once."""
    found = {}

    def run(name):
        if name not in found:
            found[name] = run_on_fmu(SCENES[name], tmp_path_factory.mktemp("tables"))
        return found[name]

    return run


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_goes_through_all_modes(name, on_fmu):
    """Stick, slip in both directions, both stops and reversals. Without inertia the cam is at rest after each
    step."""
    rows = numbers(on_fmu(name))
    modes, theta = set(rows[:, READ["forward"].index("mode")]), rows[:, READ["forward"].index("theta")]
    slip = set() if name == "without inertia" else {LOADING, RELEASING}
    assert modes == {STICK, LOWER_STOP, UPPER_STOP} | slip
    assert (np.diff(theta) > 0).any() and (np.diff(theta) < 0).any()


@needs_node
@pytest.mark.parametrize("name", SCENES)
def test_engine_in_node(name, on_fmu):
    view_scenes.assert_equal(run_in_node(SCENES[name]), on_fmu(name))


# ---- in Chromium ----


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api", reason="pip install playwright")
    options = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield chromium
        chromium.close()


@needs_chromium
@pytest.mark.parametrize("name", SCENES)
def test_page_in_chromium(name, browser, on_fmu, tmp_path):
    """window.dualcam of the page that `dualcam view` writes."""
    scene = SCENES[name]
    design = tmp_path / "design.toml"
    design.write_text(view_scenes.design_text(scene), encoding="utf-8")
    for file, text in scene.files.items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    page = browser.new_page(viewport={"width": 320, "height": 200})
    page.goto(dualcam.view.write_view(design, tmp_path / "page.html").as_uri())
    try:
        view_scenes.assert_equal(view_scenes.run_in_page(page, scene), on_fmu(name))
    finally:
        page.close()


# ---- the inverse model ----


@needs_node
@pytest.mark.parametrize("stiffness", [0.0, 300.0], ids=["rigid shaft", "elastic shaft"])
def test_inverse_model(stiffness, tmp_path):
    scene = Scene({"shaft.stiffness": stiffness}, view_scenes.imposed(), model="inverse")
    expected = run_on_fmu(scene, tmp_path)
    view_scenes.assert_equal(run_in_node(scene), expected, "inverse")
    assert np.ptp(numbers(expected, "inverse")[:, READ["inverse"].index("tau")]) > 1.0


# ---- refusals ----


@needs_node
def test_refusals_have_the_words_of_the_fmu(on_fmu):
    """dualcam.Fmu refuses a step size by itself; all other texts are the FMU's in both."""
    found, expected = refusals(run_in_node(SCENES["refusals"])), refusals(on_fmu("refusals"))
    assert len(found) == len(expected) == 13
    for (_, text), (_, words) in zip(found, expected, strict=True):
        if "StepSize" not in text:
            assert text.removesuffix(" (the present angle)") == words
    assert any("jam" in text for _, text in found)


@needs_node
@pytest.mark.parametrize(
    ("command", "words"),
    [
        (("set", "torque", 1.0), 'the FMU has no variable "torque"'),
        (("get", "torque"), 'the FMU has no variable "torque"'),
        (("set", "theta", 1.0), "theta is calculated: allowed are parameters and inputs"),
        (("set", "tau", "5"), "tau = 5 is refused: allowed is a number"),
        (("set", "cam1.profile", 1.5), "cam1.profile = 1.5 is refused: allowed is a whole number"),
        (("set", "cam1.profile", 2**32 + 1), "allowed is a whole number"),
        (("set", "ledger", 1), "ledger = 1 is refused: allowed is true or false"),
        (("set", "cam1.table", "a\0b"), "is refused: allowed is a text"),
        (("set", "cam1.table", "x" * 5000), "cam1.table"),
        (("set", "cam1.table", "x" * 100_000), "100000 bytes is too long"),
        (("step", "x"), "communicationStepSize = nan"),
        (("band", [0.5, 2.0]), "initial.theta = 2 must be <= stop.upper = 1.3963"),
    ],
)
def test_other_refusals(command, words):
    """The model goes on as before each of them."""
    loading = [("set", "tau", 5.0), ("step", 0.01)]
    *_, refused, row = run_in_node(Scene({}, [*loading, command, ("step", 0.01), ("read",)]))
    assert words in refused["refused"]
    assert [row] == run_in_node(Scene({}, [*loading, ("step", 0.01), ("read",)]))


@needs_node
@pytest.mark.parametrize(
    ("start", "files", "words"),
    [
        ({"stop.upper": -1.0}, {}, "stop.upper"),
        ({"cam1.profile": 3, "cam1.table": "groove.csv"}, {}, "groove.csv"),
        (
            {"cam1.profile": 3, "cam1.table": "groove.csv"},
            {"groove.csv": "psi_rad,z_m\n0,0\n1,x\n"},
            "line 3",
        ),
        ({"cam1.profile": 3, "cam1.table": "groove.csv"}, {"groove.csv": ""}, "groove.csv"),
        ({"cam1.radius": "20 mm"}, {}, "allowed is a number"),
    ],
)
def test_a_design_that_is_refused(start, files, words):
    (result,) = run_in_node(Scene(start, [("read",)], files))
    assert words in result["refused"]


# ---- tables, states, band ----


@needs_node
def test_a_table_by_its_absolute_path(tmp_path):
    """The name in `files` is the one in the start values, whatever it is."""
    scene = SCENES["tables"]
    names = {"first.csv": "/somewhere else/grö ove.csv", "the second.csv": "folder/two.csv"}
    start = {name: names.get(value, value) for name, value in scene.start.items()}
    files = {names[name]: text for name, text in scene.files.items()}
    assert run_in_node(Scene(start, scene.commands, files)) == run_in_node(scene)


@needs_node
def test_a_restored_state_repeats_bit_for_bit():
    """Also after the design has become another one."""
    loading = view_scenes.loading(10.0, 30.0)
    first, second = loading[:1500], loading[1500:]
    other = [("set", "cam1.radius", 0.03), ("set", "cam1.friction", 0.3), ("set", "tau", 1.0), ("step", 0.1)]
    results = run_in_node(
        Scene({}, [*first, ("save",), *second, *other, ("restore",), *second, ("restore",), *second])
    )
    last = sum(command[0] == "read" for command in second)
    assert results[-last:] == results[-2 * last : -last] == results[-3 * last : -2 * last]
    assert len({json.dumps(row) for row in results[-last:]}) > last // 2


@needs_node
def test_reset_brings_the_design_back():
    commands = view_scenes.loading(9.0)
    changes = [
        ("set", "cam1.friction", 0.3),
        ("set", "cam2.radius", 0.03),
        ("set", "F_ext", 9.0),
        ("step", 0.1),
    ]
    start = {"cam1.friction": 0.1, "initial.theta": 0.3, "inertia.shaft": 0.003}
    results = run_in_node(Scene(start, [*commands, *changes, ("reset",), ("get", "F_ext"), *commands]))
    half = len(results) // 2
    assert results[half] == 0.0
    assert results[:half] == results[half + 1 :]


@needs_node
def test_values_of_all_types():
    commands = [
        *(("set", "ledger", False), ("set", "contacts", 1), ("set", "cam1.table", "groove ß.csv")),
        *(("set", "initial.theta", 0.25), ("set", "tau", 8.0), ("step", 0.05)),
        *(("get", name) for name in ("ledger", "contacts", "cam1.table", "initial.theta", "time")),
    ]
    assert run_in_node(Scene({}, commands)) == [False, 1, "groove ß.csv", 0.25, 0.05]


@needs_node
@pytest.mark.parametrize("name", ["helices", "both ellipses", "cycloid and helix", "tables"])
def test_stick_band(name, tmp_path):
    """Each angle against an FMU that starts there."""
    scene, angles = SCENES[name], [0.0, 0.3, 0.999, 1.0]
    changes = [("set", "cam1.friction", 0.2), ("set", "F_ext", 25.0), ("set", "tau", 4.0), ("step", 0.02)]
    band, row = run_in_node(Scene(scene.start, [*changes, ("band", angles), ("read",)], scene.files))
    assert [row] == run_in_node(Scene(scene.start, [*changes, ("read",)], scene.files))
    design = view_scenes.Twin(scene, tmp_path)
    design.fmu.close()
    expected = {"torque_load": [], "torque_release": []}
    for angle in angles:
        with Fmu("forward") as fmu:
            fmu.start({**design.design, "cam1.friction": 0.2, "F_ext": 25.0, "initial.theta": angle})
            for edge, values in expected.items():
                values.append(fmu.get(edge))
    np.testing.assert_allclose(band, np.concatenate(list(expected.values())), rtol=1e-12)


@needs_node
def test_stick_band_of_the_inverse_model():
    angles = [0.1, 1.2]
    (band,) = run_in_node(Scene({}, [("set", "omega", 3.0), ("band", angles)], model="inverse"))
    (expected,) = run_in_node(Scene({}, [("band", angles)]))
    np.testing.assert_allclose(band, expected, rtol=1e-12)


GET_ALL = """
import { readFileSync } from "node:fs";
const [engine, wasm] = process.argv.slice(1);
const { Engine } = await import(engine);
const description = JSON.parse(readFileSync(0, "utf8"));
const model = await Engine.create(readFileSync(wasm), description);
model.setAll({ tau: 6, "initial.theta": 0.2, ledger: true, "cam1.friction": 0.1 });
model.step(0.03);
const names = description.variables.filter((v) => v.type !== "String").map((v) => v.name);
const all = model.getAll([...names, "time"]);
const each = [...names, "time"].map((name) => Number(model.get(name)));
console.log(JSON.stringify({ same: each.every((value, i) => Object.is(value, all[i])), count: all.length }));
"""


@needs_node
def test_all_variables_at_once():
    description = view_scenes.description("forward")
    words = [NODE, "--input-type=module", "-e", GET_ALL, view_scenes.ENGINE, web_path("DualCamForward.wasm")]
    done = subprocess.run(words, input=json.dumps(description), capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    texts = sum(row["type"] == "String" for row in description["variables"])
    assert json.loads(done.stdout) == {"same": True, "count": len(description["variables"]) - texts + 1}


# ---- the files ----

MODULE = """
const module = new WebAssembly.Module(require("fs").readFileSync(process.argv[1]));
const names = (list) => list.map((entry) => entry.name);
console.log(JSON.stringify({
  imports: [...new Set(WebAssembly.Module.imports(module).map((entry) => entry.module))],
  exports: names(WebAssembly.Module.exports(module)),
}));
"""


@needs_node
@pytest.mark.parametrize("model", ["DualCamForward", "DualCamInverse"])
def test_a_module_is_small_and_imports_files_alone(model):
    path = web_path(f"{model}.wasm")
    found = json.loads(subprocess.check_output([NODE, "-e", MODULE, path], encoding="utf-8"))
    assert found["imports"] == ["wasi_snapshot_preview1"]
    assert {"fmi2DoStep", "fmi2GetFMUstate", "web_message", "malloc", "memory"} <= set(found["exports"])
    assert path.stat().st_size < 500_000


def test_a_missing_file_says_how_to_get_it():
    with pytest.raises(FmuError, match=r"three/none\.js is missing: .*run \./build\.sh"):
        web_path("three/none.js")
    with pytest.raises(FmuError, match="allowed is the name of a file"):
        web_path(3)
