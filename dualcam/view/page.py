"""Puts the page together: template, style, modules, three.js, WebAssembly and the values of the design."""

import base64
import json
import re
from collections.abc import Mapping
from html import escape
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

import dualcam
from dualcam.common.groove_laws import LAWS, PARAMETERS, laws_with
from dualcam.common.paths import page_path_of, write_text
from dualcam.common.unit_guards import units_checked_before
from dualcam.design_file import DesignFile, DesignSource, as_design
from dualcam.errors import ExportError
from dualcam.export.exporter import table_file
from dualcam.export.scenario import scenario_for, scenario_table
from dualcam.fmi.fmu import Fmu
from dualcam.fmi.library import MODELS, fmu_path, web_path
from dualcam.fmi.model_description import Scalar, read_model_description

FOLDER = Path(__file__).resolve().parent
MODEL = "forward"
THREE = "three"  # the folder of three.js among the files for the page
LIBRARY = {"three": "three.module.min.js"}  # bare name of an import -> file of three.js
RELATIVE_IMPORT = re.compile(r"""(from\s*|import\s*)(["'])\./([\w.]+\.js)\2""")
INVERSE = (
    "The scenario of this design imposes the motion. The page shows the forward model of the same mechanism:"
    " torque in, motion out."
)


def write_view(design: DesignSource | None, path: str | Path) -> Path:
    """Write the page in which a design lives.

    The page is one HTML file that asks no network for anything: the FMU's C code as WebAssembly, the
    mechanism in 3D, sliders for all parameters. It runs the forward model, also for an imposed motion.

    Parameters
    ----------
    design : The design, from `read_design`, or the path of its file. None: the default mechanism of the FMU.
    path : The HTML file. An existing file is replaced.

    Returns
    -------
    Path
        The written file.

    Raises
    ------
    FmuError
        The FMU refuses the design, with the FMU's message, or the package lacks the WebAssembly.
    DualcamError
        For another ending than .html, a groove table that cannot be read, or a file that cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_view(None, Path(folder) / "cam.html").name
    'cam.html'
    """
    path = page_path_of(path, "the page")
    write_text(path, view_page(None if design is None else as_design(design)))
    return path


def view_page(design: DesignFile | None = None) -> str:
    """The page as text; None: the default mechanism. FmuError if the FMU refuses the design."""
    content = page_content(design)
    third_party = (web_path(THREE) / "LICENSE").read_text(encoding="utf-8")
    model = base64.b64encode(web_path(f"{MODELS[MODEL]}.wasm").read_bytes()).decode()
    parts = {
        "title": escape(content["title"]),
        "style": (FOLDER / "style.css").read_text(encoding="utf-8"),
        "imports": json.dumps({"imports": _modules()}),
        "content": json.dumps(content).replace("<", "\\u003c"),  # cannot end the element that holds it
        "model": model,
        "licences": f"<h3>dualcam</h3><pre>{escape(_own_licence())}</pre>\n"
        f"<h3>three.js</h3><pre>{escape(third_party)}</pre>",
        "version": escape(dualcam.__version__),
    }
    template = (FOLDER / "page.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], template)


def page_content(design: DesignFile | None) -> dict[str, Any]:
    """What the page knows, for JSON: words, variables, start values, tables, scenario; None: the defaults."""
    parameters = {} if design is None else _start_values(design)
    with Fmu(fmu_path(MODEL)) as fmu, units_checked_before():
        fmu.start(parameters)  # refuses a design that cannot work, with the FMU's own words
    start, files = _with_tables(parameters)
    return {
        "title": "Dual cam" if design is None else design.title or design.name,
        "source": "" if design is None else design.path.name,
        "note": INVERSE if design is not None and design.model != MODEL else "",
        "description": _description(),
        "start": start,
        "files": files,
        "scenario": None if design is None else _scenario(design, start),
    }


def _start_values(design: DesignFile) -> dict[str, Scalar]:
    """Parameters of the forward model. A design that imposes the motion starts at 0, or the nearest stop."""
    given = design.parameters_for(MODEL)
    low, high = design.value("stop.lower"), design.value("stop.upper")
    if design.model == MODEL or low <= 0.0 <= high:
        return given
    return {"initial.theta": low if low > 0.0 else high} | given


def _description() -> dict[str, Any]:
    """The FMU's variables, as engine.js reads them."""
    read = read_model_description(fmu_path(MODEL))
    keys = ("name", "type", "causality", "variability", "start", "min", "max", "unit", "description")
    variables = [
        {
            "vr": variable.value_reference,
            **{key: getattr(variable, key) for key in keys},
            **_of_groove_laws(variable.name),
        }
        for variable in read.variables
    ]
    return {"guid": read.guid, "variables": variables}


def _of_groove_laws(name: str) -> dict[str, Any]:
    """The words of a cam's profile by their numbers; the profiles that use a parameter that not all use."""
    key = name.partition(".")[2]
    if key == "profile":
        return {"words": {law.number: law.word for law in LAWS.values()}}
    return {"profiles": [law.number for law in laws_with(key)]} if key in PARAMETERS else {}


def _with_tables(parameters: Mapping[str, Scalar]) -> tuple[dict[str, Scalar], dict[str, str]]:
    """Start values with the tables by short names, and the texts of the tables by these names."""
    start, files = dict(parameters), {}
    for name, value in parameters.items():
        if name.endswith("table") and value:
            start[name] = table_file(name)
            try:
                files[str(start[name])] = Path(str(value)).read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError) as error:
                raise ExportError(f"{name} = {value!r}: the file cannot be read ({error})") from error
    return start, files


def _scenario(design: DesignFile, start: Mapping[str, Scalar]) -> dict[str, list[float]] | None:
    """Columns time and inputs of a scenario that drives the forward model."""
    scenario = scenario_for(design.scenario, MODEL)
    if scenario is None:
        return None
    head, *rows = scenario_table(scenario, MODEL, start).decode().splitlines()
    columns = zip(*([float(cell) for cell in row.split(",")] for row in rows), strict=True)
    return {name.strip('"'): list(column) for name, column in zip(head.split(","), columns, strict=True)}


def _modules() -> dict[str, str]:
    """Bare name of an import -> module as a data URL: a page from disk can import no file beside it."""
    own = {f"dualcam/{path.stem}": path for path in sorted(FOLDER.glob("*.js"))}
    folder = web_path(THREE)
    library = {f"three/{path.name}": path for path in sorted(folder.glob("*.js"))}
    library |= {name: folder / file for name, file in LIBRARY.items()}
    found = {name: _data_url(path.read_text(encoding="utf-8"), name) for name, path in own.items()}
    for name, path in library.items():
        if path.name in LIBRARY.values() and name not in LIBRARY:
            continue  # imported by its bare name
        text = RELATIVE_IMPORT.sub(r"\1\2three/\3\2", path.read_text(encoding="utf-8"))
        found[name] = _data_url(text, name)
    return found


def _data_url(text: str, name: str) -> str:
    named = f"{text}\n//# sourceURL={name}.js\n"  # the name in messages of the browser
    return f"data:text/javascript;base64,{base64.b64encode(named.encode()).decode()}"


def _own_licence() -> str:
    beside = FOLDER.parent.parent / "LICENSE"  # in a clone
    if beside.is_file():
        return beside.read_text(encoding="utf-8")
    try:
        return distribution("dualcam").read_text("licenses/LICENSE") or ""
    except PackageNotFoundError:
        return ""
