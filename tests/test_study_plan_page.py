"""The page of all keys of a plan and the schema for editors are fresh; plans that run keep the schema."""

import json
import re
import runpy
import tomllib

import jsonschema
import pytest
from driver import ROOT
from pages import TEXTS, load

from dualcam.cli.study import PLAN
from dualcam.study import plot_keys
from dualcam.study.file.schema import json_schema

SCRIPT = runpy.run_path(str(ROOT / "docs" / "tools" / "study_plan_page.py"))
SCHEMA = ROOT / "dualcam" / "study" / "plan.schema.json"
run_page = load(ROOT / "docs" / "tools" / "run_page.py")
PAGES = (
    "docs/use-studies.md",
    "docs/use-optimise.md",
    "docs/use-study-results.md",
)
PLANS = {
    f"{page} {block.file}": tomllib.loads(block.code)
    for page in PAGES
    for block in run_page.blocks_of(TEXTS[page])
    if block.language == "toml"
}
PLANS |= {
    path.name: tomllib.loads(path.read_text(encoding="utf-8"))
    for path in sorted((ROOT / "system_examples" / "study").glob("*.toml"))
}
PLANS["dualcam study --help"] = tomllib.loads(PLAN)


def test_page_and_schema_are_fresh():
    """`./build.sh run figures` writes both."""
    assert SCHEMA.read_text(encoding="utf-8") == SCRIPT["schema_text"]()
    assert json.loads(SCHEMA.read_text(encoding="utf-8")) == json_schema()
    assert TEXTS["docs/study-plan.md"] == SCRIPT["page"]()


def keys_of(table, prefix=""):
    """Dotted keys of a plan; a name of the user's is NAME."""
    for key, value in table.items():
        free = prefix in {f"{name}." for name in (*SCRIPT["ANY_NAME"], *FREE)}
        name = f"{prefix}{'NAME' if free else key}"
        if not free:
            yield name
        for each in value if isinstance(value, list) else [value]:
            if isinstance(each, dict) and name not in FREE:
                yield from keys_of(each, f"{name}.")


FREE = ("parameters", "plan.derived", "plan.constraints", "scenario.controller.arguments",
        "plan.vary.NAME.arguments", "optimise.objectives", "optimise.start")  # fmt: skip


@pytest.mark.parametrize("name", PLANS)
def test_all_keys_of_a_plan_that_runs_are_on_the_page(name):
    plan = PLANS[name]
    plan = plan.get("study", plan)
    shown = set(re.findall(r"^\| `([\w.]+)` \|", TEXTS["docs/study-plan.md"], re.MULTILINE))
    assert set(keys_of(plan)) <= shown


@pytest.mark.parametrize("name", [name for name, plan in PLANS.items() if "study" not in plan])
def test_a_plan_that_runs_keeps_the_schema(name):
    jsonschema.validate(PLANS[name], json_schema())


@pytest.mark.parametrize("change, path", [
    ({"run": 5}, []),
    ({"plan": {"kind": "lattin"}}, ["plan", "kind"]),
    ({"plan": {"kind": "latin", "vary": {"a": {"form": 1}}}}, ["plan", "vary", "a"]),
    ({"scenario": {"stop": []}}, ["scenario", "stop"]),
    ({"plan": {"kind": "latin", "correlation": [{"of": "a"}]}}, ["plan", "correlation", 0, "of"]),
])  # fmt: skip
def test_an_editor_shows_a_mistake(change, path):
    plan = PLANS["docs/use-studies.md made.toml"] | change
    errors = list(jsonschema.Draft202012Validator(json_schema()).iter_errors(plan))
    assert [list(error.absolute_path) for error in errors] == [path]


def test_kinds_and_shapes_are_all_on_the_page():
    from dualcam.scenario.history import SHAPES
    from dualcam.study.plan.arrangements import KINDS

    text = TEXTS["docs/study-plan.md"]
    assert all(f"| `{kind}` |" in text for kind in KINDS)
    assert all(f"`{shape}`" in text or f'"{shape}"' in text for shape in SHAPES)


def test_keys_of_pictures_are_those_that_are_read():
    """Their reader knows them apart from the schema."""
    shown = set(re.findall(r"^\| `([\w.]+)` \|", TEXTS["docs/study-plan.md"], re.MULTILINE))
    of_plots = {"kind", "title"}.union(*plot_keys.KINDS.values())
    assert {key for key in shown if key.startswith("plots.")} == {f"plots.{key}" for key in of_plots}
