"""The scenario of a design, run in the FMU: variables over time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, KeysView, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dualcam.errors import DesignError, DualcamError
from dualcam.fmu import Fmu, Scalar
from dualcam.handle import names_of
from dualcam.library import fmu_path
from dualcam.paths import path_of, whole_file, write_text
from dualcam.unit_guards import units_checked_before

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile, DesignSource
    from dualcam.scenario.scenario import Step

Array = NDArray[np.float64]

DEFAULT_SAMPLES = 1000  # where the scenario gives no output interval
MOST_SAMPLES = 2_000_000
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
    names : tuple of str
        Names of the n columns; the first is `time`.
    values : ndarray, shape (samples, n)
        In the FMU's units; time in s.
    """

    names: tuple[str, ...]
    values: Array

    def __getitem__(self, name: str) -> Array:
        """One column.

        Parameters
        ----------
        name : str
            Name of the column.

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
        path : str or Path
            A name that ends in .csv or .parquet.

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
    design: DesignSource,
    variables: Sequence[str] = (),
    *,
    parameters: Mapping[str, Scalar] | None = None,
    fmu: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Run the scenario of a design.

    Parameters
    ----------
    design : DesignFile, str or Path
        A design with a scenario, from `read_design`, or the path of its file.
    variables : sequence of str
        Names of numeric variables to record; none: inputs, outputs, torque band, reactions and energies.
    parameters : mapping, optional
        Start values that replace those of the design, in the FMU's units.
    fmu : str or Path, optional
        Another FMU than the one of this package, such as an exported one.
    progress : function, optional
        Called with the share of the time that is done, 0 to 1.

    Returns
    -------
    Trajectory
        Samples at every output interval [s] of the scenario, the start and the end included.

    Raises
    ------
    DesignError
        The design has no scenario, or the file is refused.
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
    """
    from dualcam.design_file import as_design

    design = as_design(design)
    if not isinstance(parameters, Mapping | None):
        raise DualcamError(f"parameters = {parameters!r}: allowed is a dict of names and values, or None")
    scenario = design.scenario
    if scenario is None:
        raise DesignError(
            f"{design.path}: the file has no [scenario]: add one, such as\n"
            "[scenario]\nstop = 1.0  # s\ninputs.tau = { time = [0.0, 0.5], value = [0.0, 5.0] }  # s, N.m"
        )
    if scenario.controller is not None:
        raise DesignError(f"{design.path}: scenario.controller: only studies run controllers; leave it out")
    times = sample_times(scenario.stop, design.output_interval)
    names = tuple(names_of(variables, "variables")) or VARIABLES[design.model]
    with Fmu(fmu or fmu_path(design.model)) as handle, units_checked_before():
        _check_inputs(design, handle)
        recorder = _Recorder(handle, names)
        interpolates = _takes_derivatives(handle)
        steps = scenario.steps([float(time) for time in times], interpolates=interpolates, fixed=False)
        given = {**design.parameters_for(design.model), **(parameters or {}), **steps[0].values}
        handle.start(given, tolerance=scenario.tolerance)
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


def sample_times(stop: float, interval: float | None) -> Array:
    """Times [s] of the samples: multiples of the output interval, and the end.

    Raises
    ------
    DesignError
        For an interval that is not above 0, or gives too many samples.
    """
    interval = stop / DEFAULT_SAMPLES if interval is None else interval
    if not (math.isfinite(interval) and interval > 0.0):
        raise DesignError(f"scenario.output_interval = {interval} s: allowed is a finite number above 0")
    if stop / interval > MOST_SAMPLES:
        raise DesignError(
            f"scenario.output_interval = {interval:g} s gives {stop / interval:.3g} samples: allowed are up"
            f" to {MOST_SAMPLES:,}, from {stop / MOST_SAMPLES:.3g} s on"
        )
    count = math.ceil(stop / interval * (1.0 - 1e-12))
    return np.minimum(np.arange(count + 1) * interval, stop)


def _takes_derivatives(handle: Fmu) -> bool:
    """Whether the FMU takes derivatives of inputs, which FMI 3.0 has not."""
    interface = handle.description.co_simulation
    return handle.description.fmi_major == 2 and interface is not None and interface.can_interpolate_inputs


def _check_inputs(design: DesignFile, handle: Fmu) -> None:
    """DesignError if the FMU lacks an input that the scenario drives, as an FMU of the other model does."""
    assert design.scenario is not None
    inputs = [variable.name for variable in handle.description.variables if variable.causality == "input"]
    if absent := [name for name in design.scenario.inputs if name not in inputs]:
        raise DesignError(
            f"{handle.path} has no input {', '.join(absent)}, which the [scenario] of {design.path} gives:"
            f" allowed is an FMU of the {design.model} model; the inputs of this FMU are {', '.join(inputs)}"
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
