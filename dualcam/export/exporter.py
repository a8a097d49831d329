"""From a design to its own FMU, without a compiler: the project's FMU with other names and start values."""

import tempfile
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from dualcam.common.archive import read_members, write_archive
from dualcam.common.paths import path_of
from dualcam.common.unit_guards import units_checked_before
from dualcam.design_file import as_design
from dualcam.errors import DualcamWarning, ExportError
from dualcam.export.changed import PAGE, Change, Members, changed_members, exported_related_files
from dualcam.export.description import Description, model_identifier, typed
from dualcam.export.page import exported_page, figures
from dualcam.export.reference import (
    START_INPUTS,
    Reference,
    SlowMotionCurves,
    reference_result,
    slow_motion_curves,
    stops_of,
)
from dualcam.export.scenario import FILE as SCENARIO_FILE
from dualcam.export.scenario import scenario_for, scenario_table, scenario_text
from dualcam.fmi.fmu import Fmu
from dualcam.fmi.library import MODELS, fmu_path
from dualcam.fmi.model_description import XML, Scalar
from dualcam.fmi.variables import all_parameters, inputs_of, parameters_of, unused
from dualcam.scenario.scenario import Scenario

SUFFIX = ".fmu"


@runtime_checkable
class ExportableDesign(Protocol):
    """What the export needs of a design, such as dualcam.design_file.DesignFile."""

    @property
    def name(self) -> str:
        """For the description of the FMU."""

    @property
    def parameters(self) -> Mapping[str, Scalar]:
        """The FMU's name -> value in SI units; table files as absolute paths."""

    @property
    def model(self) -> str:
        """ "forward" or "inverse"."""

    @property
    def title(self) -> str:
        """For the description of the FMU; may be empty."""

    @property
    def scenario(self) -> Scenario | None:
        """What `dualcam simulate` plays; the FMU then holds the inputs as a file."""


@dataclass(frozen=True)
class ExportPlan:
    """What the exported FMU is to be."""

    design: str  # name and title of the design
    name: str
    identifier: str
    model: str
    start: dict[str, Scalar]  # tables by their names in the FMU's resources
    tables: dict[str, bytes]  # file name in the FMU's resources -> content
    scenario: Scenario | None  # where it drives this model
    stop: float | None  # end of the design's scenario [s]


def export_fmu(
    design: ExportableDesign | str | Path, path: str | Path, fmi: int = 2, model: str | None = None
) -> Path:
    """Make an FMU whose start values are those of a design. No compiler is needed.

    In the binaries, for all platforms of the project's FMU, only the block with GUID and start values
    differs: with the same parameters both FMUs compute the same bits. Tables become `cam1.csv` and `cam2.csv`
    in the FMU's resources, the inputs of a scenario that drives this model `extra/scenario_in.csv`, which the
    FMU's page shows how to play. The scenario's end is the stop time of the default experiment. The same
    design and name give the same GUID and bytes; the figures depend on the version of Matplotlib.

    Parameters
    ----------
    design : The design, for example from `dualcam.design_file.read_design`, or the path of its file.
    path : File name of the FMU, which ends in .fmu; its stem is the model name. An existing file is replaced.
    fmi : Version of FMI, 2 or 3.
    model
        "forward" or "inverse"; None: as the design says. In the inverse FMU `initial.theta` and
        `initial.omega` become the start values of its inputs `theta` and `omega`. Where the stops exclude
        theta = 0 and the design has no `initial.theta`, `theta` starts at the nearest stop.

    Returns
    -------
    The absolute path of the FMU.

    Raises
    ------
    ExportError : The path is no good, a table cannot be read, or the project's FMU cannot be changed.
    FmuError : The FMU refuses the design; the message is the FMU's.

    Warns
    -----
    UserWarning : The stem of `path` is no C identifier: the names of the binaries differ from the model name.

    Examples
    --------
    >>> from dualcam.design_file import write_template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     design = write_template("minimal", Path(folder) / "my.toml")
    ...     export_fmu(design, Path(folder) / "MyCam.fmu", fmi=3).name
    'MyCam.fmu'
    """
    design = design if isinstance(design, ExportableDesign) else as_design(design)
    target = target_path(path)
    model = design.model if model is None else model
    original = fmu_path(model, fmi)
    if target.resolve().parent == original.parent and target.stem in MODELS.values():
        raise ExportError(f"{target} is the project's own FMU: choose another folder or name")
    parameters = _parameters_of_model(design, model)
    with Fmu(fmu_path(model)) as fmu, units_checked_before():
        fmu.start(parameters)  # refuses unknown names, values out of range, and a design that jams
    plan = _plan(design, target.stem, model, parameters)
    if plan.identifier != plan.name:
        warnings.warn(
            f"{plan.name!r} is no C identifier: the binaries in the FMU are named {plan.identifier!r}",
            DualcamWarning,
            stacklevel=2,
        )
    curves = slow_motion_curves(parameters)
    try:
        with tempfile.TemporaryDirectory(prefix=f".{target.stem}.", dir=target.parent) as scratch:
            reference = _reference(plan, curves, Path(scratch) / "trial.fmu")
            unfinished = Path(scratch) / target.name
            write_archive(unfinished, _members(plan, original, curves, reference))
            unfinished.replace(target)
    except OSError as error:
        raise ExportError(f"{target} cannot be written: {error}") from error
    return target


def _parameters_of_model(design: ExportableDesign, model: str) -> dict[str, Scalar]:
    """The design's parameters by their names in this model, without those that only the other model has."""
    renamed = START_INPUTS if model == "inverse" else {}
    given = {renamed.get(name, name): value for name, value in design.parameters.items()}
    known = {**parameters_of(model), **inputs_of(model)}
    absent = [name for name in given if name not in known and name in all_parameters()]
    for name in absent:
        warnings.warn(unused(name, given[name], model), DualcamWarning, stacklevel=3)
    return _with_theta_in_range(model, {name: v for name, v in given.items() if name not in absent})


def _with_theta_in_range(model: str, given: dict[str, Scalar]) -> dict[str, Scalar]:
    """For the inverse model whose range excludes theta = 0: the start value of theta is the nearest stop."""
    if model != "inverse" or "theta" in given:
        return given
    low, high = stops_of(given)
    return given if low <= 0.0 <= high else given | {"theta": low if low > 0.0 else high}


def _plan(design: ExportableDesign, name: str, model: str, parameters: Mapping[str, Scalar]) -> ExportPlan:
    """Types as in the FMU; tables read."""
    variables = Description(read_members(fmu_path(model))[XML]).variables
    start: dict[str, Scalar] = {}
    tables: dict[str, bytes] = {}
    for key, value in parameters.items():
        start[key] = typed(variables[key], value)
        if variables[key].type == "String" and value:
            start[key] = table_file(key)
            tables[str(start[key])] = _table(key, str(value))
    called = f'{design.name}, "{design.title}"' if design.title else design.name
    scenario = scenario_for(design.scenario, model)
    stop = None if design.scenario is None else design.scenario.stop
    return ExportPlan(called, name, model_identifier(name), model, start, tables, scenario, stop)


def table_file(name: str) -> str:
    """The file in the FMU's resources of a table: `cam1.csv` of `cam1.table`, `cam1_friction.csv`."""
    cam, _, kind = name.partition(".")
    return cam + {"table": ".csv", "friction_table": "_friction.csv"}[kind]


def _table(name: str, path: str) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError as error:
        text = f"{name} = {path!r}: the file cannot be read ({error.strerror or error})"
        raise ExportError(text) from error


def _reference(plan: ExportPlan, curves: SlowMotionCurves, trial: Path) -> Reference:
    """Start the exported FMU, of FMI 2.0 in any case, since both versions share the core; play the run."""
    members, _ = _core_members(plan, read_members(fmu_path(plan.model)))
    write_archive(trial, members)
    with Fmu(trial) as fmu:
        return reference_result(fmu, plan.model, curves)


def _members(plan: ExportPlan, original: Path, curves: SlowMotionCurves, reference: Reference) -> Members:
    """All members of the exported FMU."""
    before = read_members(original)
    members, names = _core_members(plan, before)
    page = exported_page(
        before[PAGE].decode(),
        Description(before[XML]),
        names,
        plan.start,
        figures(curves, reference),
        scenario_text(f"{plan.name}.fmu", plan.scenario, plan.model) if plan.scenario else "",
    )
    members |= reference.members(plan.identifier)
    if plan.scenario:
        members[SCENARIO_FILE] = scenario_table(plan.scenario, plan.model, plan.start)
    return members | {PAGE: page.encode()}


def _core_members(plan: ExportPlan, before: Mapping[str, bytes]) -> tuple[dict[str, bytes], dict[str, str]]:
    """All members without page and reference result; the names of the exported FMU."""
    description = Description(before[XML])
    sentence = f"{description.root.attributes['description']}; start values of the design {plan.design}"
    names = {"name": plan.name, "identifier": plan.identifier, "description": sentence}
    root = {
        "modelName": plan.name,
        "description": sentence,
        "generationTool": f"dualcam export {description.root.attributes['version']}",
    }
    members = changed_members(before, Change(plan.identifier, root, plan.start, plan.tables, plan.stop))
    members |= exported_related_files(before, description.identifier, plan.identifier)
    return members, names


def target_path(path: str | Path) -> Path:
    """The absolute path of the FMU to be written. ExportError for a bad ending, sign or folder."""
    target = path_of(path, "the FMU").expanduser().absolute()
    if target.suffix.lower() != SUFFIX or not target.stem.isprintable():
        text = f"{str(path)!r}: allowed is a file name that ends in {SUFFIX}, such as MyCam{SUFFIX}"
        raise ExportError(text)
    try:
        is_folder, has_folder = target.is_dir(), target.parent.is_dir()
    except OSError as error:  # as a name that is too long
        raise ExportError(f"{target} cannot be written: {error.strerror}") from error
    if is_folder:
        text = f"{target} is a folder: allowed is the name of a file; remove the folder or choose another"
        raise ExportError(text)
    if not has_folder:
        text = f"the folder {target.parent} does not exist: create it first, or choose another folder"
        raise ExportError(text)
    return target
