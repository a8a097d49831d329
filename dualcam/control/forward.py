"""The forward FMU as a function of state and inputs, for linear models and plants of python-control."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from dualcam.common.arrays import given_once, positive_number
from dualcam.common.entries import repeated
from dualcam.errors import FmuError
from dualcam.fmi.continuous_fmu import ContinuousFmu
from dualcam.fmi.handle import Handle
from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import Scalar

STATES = ("theta", "omega")  # rad, rad/s
INPUTS = ("tau", "F_ext")  # N.m, N
OUTPUTS = ("theta", "omega", "z", "v")  # rad, rad/s, m, m/s
STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP, WEDGED = range(1, 7)  # the FMU's `mode`

Source = str | Path | Handle
Names = str | Sequence[str] | None
HandleType = TypeVar("HandleType", bound=Handle)


def open_forward(
    kind: type[HandleType], source: Source, parameters: Mapping[str, Scalar] | None
) -> tuple[HandleType, dict[str, Scalar]]:
    """A new instance of the FMU at a path or behind a handle, and its start values: those of the handle's
    last start, overridden by `parameters`. FmuError unless torque is an input and angle an output."""
    inherited = source.parameters if isinstance(source, Handle) else {}
    fmu = kind(source.path if isinstance(source, Handle) else source_path(source))
    causality = {name: fmu.variable(name).causality for name in (*INPUTS, *OUTPUTS) if name in fmu.names}
    wanted = dict.fromkeys(INPUTS, "input") | dict.fromkeys(OUTPUTS, "output")
    if causality != wanted:
        fmu.close()
        raise FmuError(
            f"{fmu.path} ({fmu.description.model_name}) is no plant with input tau and output theta: use"
            ' "forward" (in "inverse" the motion goes in and the torque comes out)'
        )
    return fmu, {**inherited, **(parameters or {})}


def name_list(names: object) -> list[str]:
    """Names of signals: of a list or an array, or of one text with commas between the names."""
    if isinstance(names, str):
        return [name.strip() for name in names.split(",")]
    if isinstance(names, Iterable) and not isinstance(names, np.ndarray):
        names = list(names)  # also the keys of a dict
    return [str(name) for name in np.ravel(np.array(names, dtype=object))]


def selected_names(names: Names, allowed: Sequence[str], what: str) -> list[str]:
    """Names of signals, all of `allowed` for None. FmuError for other names and for repeated ones."""
    found = list(allowed) if names is None else name_list(names)
    for name in found:
        if name not in allowed:
            raise FmuError(f"{what} {name!r}: allowed are {', '.join(allowed)}")
    if not found or repeated(found):
        raise FmuError(f"{what}s {found}: allowed are one or more of {', '.join(allowed)}, each once")
    return found


def sampling_period(period: float | None, dt: float | None) -> float | None:
    """The period [s] of a sampled model, given by either name; None for continuous time.

    FmuError if it is no finite number > 0, or if both are given."""
    name, value = given_once(period=period, dt=dt)
    allowed = "a finite number > 0 in s, or None for continuous time"
    return None if value is None else positive_number(value, name, allowed)


class CamAtState:
    """The forward FMU in model exchange, as a function of state and input alone.

    Besides theta and omega the FMU's state has the mode, with the flanks on which the contacts bear. Before
    each new state the FMU returns to rest. Then it decides the mode anew: slip by the sign of omega, and at
    omega = 0 slip or stick by the torque."""

    def __init__(self, source: Source, parameters: Mapping[str, Scalar] | None) -> None:
        self.fmu, values = open_forward(ContinuousFmu, source, parameters)
        start = values | {"initial.omega": 0.0}
        start.pop("initial.theta", None)
        self.fmu.start(start | {"initial.theta": self._stop("lower", start)})
        self.lower, self.upper = (self._stop(name, start) for name in ("lower", "upper"))
        self._inputs, self._edges = self.fmu.reals(*INPUTS), self.fmu.reals("torque_release", "torque_load")
        # Pressed against a stop the cam is at rest with any friction.
        self._inputs.values[:] = -1e12, 0.0
        self._inputs.write()
        self.fmu.enter_event_mode()
        self._at_rest = self.fmu.save_state()

    def _stop(self, name: str, start: Mapping[str, Scalar]) -> float:
        variable = self.fmu.variable(f"stop.{name}")
        return float(start.get(variable.name, variable.start or 0.0))

    def set_state(self, theta: float, omega: float, tau: float, F_ext: float) -> None:
        """Set state and inputs [rad, rad/s, N.m, N], and the mode that follows. FmuError if the FMU refuses a
        value."""
        self.fmu.restore_state(self._at_rest)
        self.fmu.set_states((theta, omega))
        self.set_inputs(tau, F_ext)
        self.fmu.enter_event_mode()

    def set_inputs(self, tau: float, F_ext: float) -> None:
        """Set other inputs [N.m, N] in the present mode."""
        self._inputs.values[:] = tau, F_ext
        self._inputs.write()

    def band(self) -> tuple[float, float]:
        """Edges of the stick band [N.m] at the present theta and F_ext; infinite where no torque moves the
        cam."""
        release, load = self._edges.read()
        return release, load

    @property
    def mode(self) -> int:
        """The FMU's `mode`."""
        return int(self.fmu.get("mode"))

    @property
    def alpha(self) -> float:
        """Angular acceleration, rad/s2."""
        return self.fmu.derivatives()[1]
