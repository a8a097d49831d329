"""One instance of an FMU of FMI 2.0 or FMI 3.0 from Python, with names instead of value references, the FMU's
messages in errors, and fast enough for a 1 kHz loop.

    with Fmu("forward") as fmu:
        command, state = fmu.reals("tau"), fmu.reals("theta", "omega")
        fmu.start({"inertia.shaft": 0.2})
        command.values[0] = 1.5
        command.write()
        fmu.step(1e-3)
        theta, omega = state.read()

An instance must not be used from two threads at once; instances share nothing.
"""

import math
from collections.abc import Mapping, Sequence

from numpy.typing import ArrayLike

from dualcam.common.arrays import Array, given_once, positive_number
from dualcam.errors import FmuError
from dualcam.fmi.handle import Handle, names_of
from dualcam.fmi.instance import OK_OR_WARNING
from dualcam.fmi.model_description import Scalar

__all__ = ["Array", "Fmu", "FmuError", "RepeatedStart", "Scalar"]

STEP_SIZES = "a finite number > 0, in s"


class Fmu(Handle):
    """One instance of an FMU for co-simulation.

    `start` begins a run, any number of times; `step` advances `time`. The instance is freed by `close`, by
    leaving a with statement, or with the last reference to the handle.

    Parameters
    ----------
    source : "forward" or "inverse" for this package's own FMUs, or the path of any FMU of FMI 2.0 or FMI 3.0.
    fmi : Version of FMI of a named FMU, one of 2, 3. Default: 2. The file at a path says its version itself.

    Raises
    ------
    FmuError
        The file is missing or no FMU, has no co-simulation, or has no library for this platform. All methods
        raise it for a wrong argument, where the FMU refuses, before a run has begun and after `close`; the
        UnknownVariableError among them names near variables.

    Examples
    --------
    >>> from dualcam import Fmu
    >>> with Fmu("forward", fmi=3) as fmu:
    ...     fmu.start({"inertia.shaft": 0.01, "tau": 5.0})
    ...     for _ in range(50):
    ...         fmu.step(1e-3)
    ...     round(fmu.time, 3), round(fmu.real("theta"), 4)  # s, rad
    (0.05, 0.4713)
    """

    _use = "co-simulation"

    def start(
        self,
        parameters: Mapping[str, Scalar] | None = None,
        time: float = 0.0,
        tolerance: float | None = None,
    ) -> None:
        """Begin a run. All variables that are not named get their default start values.

        `parameters`: start values of parameters and inputs, in their units. `time`: start time [s].
        `tolerance`: relative tolerance of the FMU's integrator. None: the FMU's default, here 1e-9.
        """
        self._begin({} if parameters is None else parameters, time, tolerance)
        self._instance.call(self._instance.EXIT_INITIALIZATION)
        self._instance.allow_calls()

    def step(self, step: float | None = None, *, size: float | None = None) -> None:
        """Advance with the inputs as they were last written.

        `step`, `size`: length of the step [s], > 0, by either name. FmuError: `step` is no finite number > 0,
        no run has begun, or the FMU refuses the step.
        """
        instance = self._instance
        if size is not None:
            _, step = given_once(step=step, size=size)
        if type(step) is not float or not 0.0 < step < math.inf:
            step = positive_number(step, "step", STEP_SIZES)
        status = instance.do_step(instance.component, self._time, step, *instance.step_end)
        if status > OK_OR_WARNING:
            instance.check(status, instance.DO_STEP)
        self._time += step


class RepeatedStart:
    """Many runs of one FMU from different start values. The FMU keeps its precomputed geometry, so a start
    costs about as much as a step. FmuError where the FMU refuses a value, or cannot save its state.

    Parameters
    ----------
    fmu : The instance that makes the runs.
    parameters : Start values that all runs share, as in `Fmu.start`.
    names : Real start values, of parameters or inputs, that differ between the runs, shape (n,).

    Examples
    --------
    >>> from dualcam.fmi import Fmu, RepeatedStart
    >>> with Fmu("forward") as fmu:
    ...     runs = RepeatedStart(fmu, {"inertia.shaft": 0.01}, ["tau"])
    ...     for torque in (2.0, 5.0):  # N.m
    ...         runs.start([torque])
    ...         fmu.step(0.05)
    ...         print(round(fmu.real("theta"), 4))  # rad
    0.1453
    0.4713
    """

    def __init__(self, fmu: Fmu, parameters: Mapping[str, Scalar], names: Sequence[str]) -> None:
        if not isinstance(fmu, Fmu):
            raise FmuError(f"RepeatedStart({fmu!r}, ...): allowed is an Fmu")
        names = names_of(names, "names")
        self.fmu = fmu
        fmu._begin(parameters, 0.0, None)
        fmu._instance.allow_calls()
        self.start_values = fmu.reals(*names)
        self._state = fmu.save_state()

    def __repr__(self) -> str:
        return f"<RepeatedStart of {self.fmu!r} with {', '.join(self.start_values.names)}>"

    def initialize(self, values: ArrayLike) -> None:
        """Back to initialization mode with these start values, where variables that need no step can be read.

        `values`: start values in the order of `names`, shape (n,).
        """
        self.fmu.restore_state(self._state)
        self.start_values.values = values
        self.start_values.write()

    def start(self, values: ArrayLike) -> None:
        """Begin a run at 0 s. `values`: start values in the order of `names`, shape (n,)."""
        self.initialize(values)
        self.fmu._instance.call(self.fmu._instance.EXIT_INITIALIZATION)
