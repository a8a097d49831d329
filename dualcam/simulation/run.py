"""The scenario of a design, run in the FMU: variables over time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, KeysView, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dualcam.common.paths import path_of, whole_file, write_text
from dualcam.common.unit_guards import units_checked_before
from dualcam.errors import DesignError, DualcamError
from dualcam.fmi.fmu import Fmu, Scalar
from dualcam.fmi.handle import names_of
from dualcam.fmi.library import MODELS, fmu_path
from dualcam.fmi.variables import inputs_of

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile, DesignSource
    from dualcam.scenario.scenario import Scenario, Step

Array = NDArray[np.float64]

ENERGIES = (
    "energy.work_in",
    "energy.work_ext",
    "energy.spring",
    "energy.kinetic",
    "energy.heat_cam1",
    "energy.heat_cam2",
    "energy.heat_damper",
    "energy.heat_shaft",
    "energy.heat_stop",
    "energy.residual",
)
LOADS = ("torque_release", "torque_load", "spring.force", "cam1.reaction", "cam2.reaction", "mode")
VARIABLES = {
    "forward": ("tau", "F_ext", "theta", "omega", "alpha", "z", "v", *LOADS, "events", *ENERGIES),
    "inverse": ("theta", "omega", "alpha", "F_ext", "tau", "z", "v", *LOADS, *ENERGIES),
}
FORMATS = (".csv", ".parquet")


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """Variables of one run over time. Iteration gives the names, as for a dict: `dict(trajectory)` works.

    Attributes
    ----------
    names : Names of the n columns; the first is `time`.
    values : Shape (samples, n), in the FMU's units; time in s.
    """

    names: tuple[str, ...]
    values: Array

    def __getitem__(self, name: str) -> Array:
        """One column.

        Parameters
        ----------
        name : Name of the column.

        Returns
        -------
        ndarray, shape (samples,)

        Raises
        ------
        DualcamError
            For a name that is no column.
        """
        if name not in self.names:
            raise DualcamError(f"the trajectory has no column {name!r}: allowed are {', '.join(self.names)}")
        return self.values[:, self.names.index(name)]

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        return f"<Trajectory of {len(self.values):,} samples: {', '.join(self.names)}>"

    def keys(self) -> KeysView[str]:
        """The names of the columns, so that `dict(trajectory)` has one array for each name.

        Returns
        -------
        KeysView
        """
        return dict.fromkeys(self.names).keys()

    def write(self, path: str | Path) -> None:
        """Write all columns to a file: CSV with all digits, or Parquet, by the end of the name.

        Parameters
        ----------
        path : A name that ends in .csv or .parquet.

        Raises
        ------
        DualcamError
            For another ending than .csv or .parquet, or where pyarrow is missing for Parquet.
        FileError
            The system refuses to write the file.
        """
        path = path_of(path, "the table of samples")
        suffix = checked_format(path)
        if suffix == ".csv":
            rows = [",".join(map(repr, row)) for row in self.values.tolist()]
            write_text(path, "\n".join([",".join(self.names), *rows]) + "\n")
        else:
            import pyarrow
            from pyarrow import parquet

            columns = {name: self.values[:, k] for k, name in enumerate(self.names)}
            with whole_file(path) as unfinished:
                parquet.write_table(pyarrow.table(columns), unfinished)


def checked_format(path: Path) -> str:
    """The ending of a file of results, if it can be written here.

    Raises
    ------
    DualcamError
        For another ending than .csv or .parquet, or where pyarrow is missing for Parquet.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise DualcamError(f"{path}: allowed are names that end in {' or '.join(FORMATS)}")
    if suffix == ".parquet":
        from importlib.util import find_spec

        if find_spec("pyarrow") is None:
            raise DualcamError(f"{path}: Parquet needs pyarrow: pip install pyarrow, or write a .csv")
    return suffix


def simulate(
    design: DesignSource | Fmu,
    variables: Sequence[str] = (),
    *,
    scenario: Scenario | None = None,
    output_interval: float | None = None,
    parameters: Mapping[str, Scalar] | None = None,
    fmu: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Run the scenario of a design, or any scenario with an FMU.

    Parameters
    ----------
    design : DesignFile, str, Path or Fmu
        A design from `read_design`, or the path of its file; or "forward", "inverse", the path of any FMU for
        co-simulation (.fmu), or a handle, which begins a new run and stays open.
    variables : sequence of str
        Names of numeric variables to record; none: inputs, outputs, and of a design torque band, reactions
        and energies.
    scenario : What is done, instead of the [scenario] of the design. An FMU needs one.
    output_interval : Time between two samples [s]. None: that of the design, else a thousandth of the whole.
    parameters : Start values that replace those of the design, in the FMU's units.
    fmu : For a design, another FMU than the one of this package, such as an exported one.
    progress : Called with the share of the time that is done, 0 to 1.

    Returns
    -------
    Trajectory
        Samples at every output interval [s] of the scenario, the start and the end included.

    Raises
    ------
    DesignError
        There is no scenario, or the design file is refused.
    FmuError
        The FMU refuses a value or a step.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from dualcam.design_file import write_template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     trajectory = simulate(write_template("minimal", Path(folder) / "my.toml"), ["theta", "tau"])
    >>> float(trajectory["theta"].max())  # rad, the upper stop
    1.3962634015954636
    >>> from dualcam.study import History, Scenario
    >>> push = Scenario(0.1, {"tau": History([0.0, 0.1], [0.0, 3.0])})  # s, N.m
    >>> float(simulate("forward", ["tau"], scenario=push)["tau"][-1])
    3.0
    """
    if not isinstance(parameters, Mapping | None):
        raise DualcamError(f"parameters = {parameters!r}: allowed is a dict of names and values, or None")
    if isinstance(design, Fmu) or (isinstance(design, str | Path) and _is_fmu(design)):
        case = _case_of_fmu(design, scenario, fmu)
    else:
        from dualcam.design_file import as_design

        case = _case_of_design(as_design(design), scenario, fmu)
    interval = case.interval if output_interval is None else output_interval
    with case.opened() as handle, case.warnings():
        return _run(handle, case, interval, variables, parameters or {}, progress)


@dataclass(frozen=True)
class _Case:
    """What is run. `model` and `design` are empty for an FMU without a design."""

    fmu: str | Path | Fmu
    scenario: Scenario
    interval: float | None = None
    model: str = ""
    design: DesignFile | None = None

    def opened(self) -> AbstractContextManager[Fmu]:
        """The handle; one that was given stays open."""
        return nullcontext(self.fmu) if isinstance(self.fmu, Fmu) else Fmu(self.fmu)

    def warnings(self) -> AbstractContextManager[None]:
        """Units of a design are checked where it is read."""
        return units_checked_before() if self.design else nullcontext()

    def start(self) -> dict[str, Scalar]:
        """Start values of the design."""
        return self.design.parameters_for(self.model) if self.design else {}

    def variables(self, handle: Fmu) -> tuple[str, ...]:
        """What is recorded unless names are given."""
        return VARIABLES[self.model] if self.design else _inputs_and_outputs(handle)


def _is_fmu(path: str | Path) -> bool:
    return str(path) in MODELS or Path(path).suffix == ".fmu"


def _case_of_fmu(source: str | Path | Fmu, scenario: Scenario | None, fmu: object) -> _Case:
    if scenario is None:
        raise DesignError(
            f"{source}: an FMU has no scenario: give one, such as scenario=Scenario(1.0, {{'tau':"
            " History([0.0, 0.5], [0.0, 5.0])}) of dualcam.study"
        )
    if fmu is not None:
        raise DesignError(f"fmu = {fmu!r} beside the FMU {source}: fmu is the FMU of a design")
    _check_controller(scenario, "the scenario")
    return _Case(source, scenario)


def _case_of_design(design: DesignFile, given: Scenario | None, fmu: str | Path | None) -> _Case:
    scenario = design.scenario if given is None else given
    if scenario is None:
        raise DesignError(
            f"{design.path}: the file has no [scenario]: add one, such as\n"
            "[scenario]\nstop = 1.0  # s\ninputs.tau = { time = [0.0, 0.5], value = [0.0, 5.0] }  # s, N.m"
        )
    _check_controller(scenario, f"{design.path}: scenario.controller")
    fits = [model for model in MODELS if given and set(given.inputs) <= set(inputs_of(model))]
    model = fits[0] if fits and design.model not in fits else design.model
    return _Case(fmu or fmu_path(model), scenario, design.output_interval, model, design)


def _check_controller(scenario: Scenario, where: str) -> None:
    if scenario.controller is not None:
        raise DesignError(f"{where}: only studies run controllers; leave it out")


def _inputs_and_outputs(handle: Fmu) -> tuple[str, ...]:
    return tuple(
        variable.name
        for variable in handle.description.variables
        if variable.causality in ("input", "output") and variable.kind != "string"
    )


def _run(
    handle: Fmu,
    case: _Case,
    interval: float | None,
    variables: Sequence[str],
    parameters: Mapping[str, Scalar],
    progress: Callable[[float], None] | None,
) -> Trajectory:
    """The steps of the scenario, and the samples."""
    from dualcam.design_file.design import sample_times

    scenario = case.scenario
    times = sample_times(scenario.stop, interval)
    names = tuple(names_of(variables, "variables")) or case.variables(handle)
    _check_inputs(case, handle)
    recorder = _Recorder(handle, names)
    interpolates = _takes_derivatives(handle)
    steps = scenario.steps([float(time) for time in times], interpolates=interpolates, fixed=False)
    handle.start({**case.start(), **parameters, **steps[0].values}, tolerance=scenario.tolerance)
    inputs = _Inputs(handle)
    rows = [recorder.row(0.0)]
    for step, due in zip(steps, _is_sample(steps, times), strict=True):
        inputs.send(step)
        handle.step(step.size)
        if due:
            rows.append(recorder.row(step.time + step.size))
            if progress is not None:
                progress(min(1.0, (step.time + step.size) / scenario.stop))
    return Trajectory(("time", *names), np.array(rows))


def _takes_derivatives(handle: Fmu) -> bool:
    """Whether the FMU takes derivatives of inputs, which FMI 3.0 has not."""
    interface = handle.description.co_simulation
    return handle.description.fmi_major == 2 and interface is not None and interface.can_interpolate_inputs


def _check_inputs(case: _Case, handle: Fmu) -> None:
    """DesignError if the FMU lacks an input that the scenario drives, as an FMU of the other model does."""
    inputs = [variable.name for variable in handle.description.variables if variable.causality == "input"]
    if absent := [name for name in case.scenario.inputs if name not in inputs]:
        of = f"[scenario] of {case.design.path}" if case.design else "scenario"
        allowed = f" allowed is an FMU of the {case.model} model;" if case.design else ""
        raise DesignError(
            f"{handle.path} has no input {', '.join(absent)}, which the {of} gives:{allowed}"
            f" the inputs of this FMU are {', '.join(inputs)}"
        )


class _Recorder:
    """Reads the recorded variables of an instance."""

    def __init__(self, handle: Fmu, names: Sequence[str]) -> None:
        texts = [name for name in names if handle.variable(name).kind == "string"]
        if texts:
            raise DualcamError(f"{', '.join(texts)} is a text: allowed are numeric variables")
        self._handle = handle
        self._real = [name for name in names if handle.variable(name).kind == "real"]
        self._others = [name for name in names if name not in self._real]
        self._group = handle.reals(*self._real)
        order = [*self._real, *self._others]
        self._places = [order.index(name) for name in names]

    def row(self, time: float) -> list[float]:
        read = [*self._group.read(), *(float(self._handle.get(name)) for name in self._others)]
        return [time, *(read[k] for k in self._places)]


def _is_sample(steps: Sequence[Step], times: Array) -> list[bool]:
    """Whether each step ends at one of the sample times."""
    ends = np.array([step.time + step.size for step in steps])
    place = np.clip(np.searchsorted(times, ends), 1, len(times) - 1)
    nearest = np.minimum(np.abs(times[place] - ends), np.abs(times[place - 1] - ends))
    return list(nearest <= 1e-9 * times[-1])


class _Inputs:
    """Sends the inputs of steps. Each group of variables is laid out once for all steps."""

    def __init__(self, handle: Fmu) -> None:
        self._group = cache(handle.reals)

    def send(self, step: Step) -> None:
        """The inputs of one step and their derivatives."""
        inputs = self._group(*step.values)
        inputs.values[:] = list(step.values.values())
        inputs.write()
        for (name, order), rate in step.rates.items():
            self._group(name).write_derivatives(order, [rate])
