"""The handle of an FMU for model exchange."""

from collections.abc import Mapping
from ctypes import c_double
from pathlib import Path

from numpy.typing import ArrayLike

from dualcam.common.arrays import number_of, real_array
from dualcam.errors import FmuError
from dualcam.fmi.handle import Handle
from dualcam.fmi.instance import Reals
from dualcam.fmi.model_description import Scalar


class ContinuousFmu(Handle):
    """One instance of an FMU for model exchange: the caller integrates the states.

    The states of the forward FMU are theta [rad] and omega [rad/s]. `set_states_and_mode` sets the states
    and lets the FMU decide its mode there. After that `derivatives` can be read. `set_states` sets other
    states in the same mode, as solvers do between events.

    Parameters
    ----------
    source
        "forward" for this package's own FMU, or the path of any FMU of FMI 2.0 or FMI 3.0 that has model
        exchange.
    fmi : Version of FMI of a named FMU, one of 2, 3. Default: 2.

    Raises
    ------
    FmuError
        The file is missing or no FMU, has no model exchange, or has no library for this platform. All methods
        raise it as those of Fmu.

    Examples
    --------
    >>> from dualcam import ContinuousFmu
    >>> with ContinuousFmu("forward") as fmu:
    ...     fmu.start({"tau": 3.0})
    ...     fmu.set_states_and_mode([0.5, 2.0])
    ...     omega, alpha = fmu.derivatives()
    >>> omega, round(alpha, 1)  # rad/s, rad/s2
    (2.0, -488.4)
    """

    _use = "model exchange"

    def __init__(self, source: str | Path, fmi: int | None = None) -> None:
        super().__init__(source, fmi)
        states, indicators = self.description.state_count, self.description.event_indicator_count
        self._states, self._rates = (c_double * states)(), (c_double * states)()
        self._indicators = (c_double * indicators)()

    def start(self, parameters: Mapping[str, Scalar] | None = None, time: float = 0.0) -> None:
        """Begin in continuous-time mode. FmuError where the FMU has no inertia: then speed is no state.

        `parameters`: start values of parameters and inputs, in their units. `time`: start time [s].
        """
        self._begin({} if parameters is None else parameters, time, None)
        self._instance.call(self._instance.EXIT_INITIALIZATION)
        self._settle()
        self._instance.allow_calls()

    def _settle(self) -> None:
        """Event iteration, then continuous-time mode."""
        while self._instance.update_discrete_states():
            pass
        self._instance.call(self._instance.named("EnterContinuousTimeMode"))

    def set_states(self, states: ArrayLike) -> None:
        """Set the states in the present mode.

        `states`: theta [rad] and omega [rad/s] of the forward FMU, shape (states,).
        """
        self._instance.require_calls_allowed()
        self._states[:] = real_array(states, "states", FmuError, (len(self._states),)).tolist()
        self._instance.call_on_vector(self._instance.named("SetContinuousStates"), self._states)

    def set_states_and_mode(self, states: ArrayLike) -> None:
        """Set the states, and carry out the mode changes due there.

        `states`: theta [rad] and omega [rad/s] of the forward FMU, shape (states,).
        """
        self.set_states(states)
        self.enter_event_mode()

    def enter_event_mode(self) -> None:
        """Carry out the mode changes that are due now; continuous-time mode again after that."""
        self._instance.require_calls_allowed()
        self._instance.call(self._instance.named("EnterEventMode"))
        self._settle()

    def states(self) -> list[float]:
        """The states: theta [rad] and omega [rad/s] of the forward FMU."""
        return self._read("GetContinuousStates", self._states)

    def derivatives(self) -> list[float]:
        """Time derivatives of the states: rad/s and rad/s2 of the forward FMU."""
        return self._read("GetDerivatives", self._rates, "GetContinuousStateDerivatives")

    def event_indicators(self) -> list[float]:
        """Event indicators: where one changes its sign, the mode may change."""
        return self._read("GetEventIndicators", self._indicators)

    def _read(self, two: str, values: Reals, three: str = "") -> list[float]:
        self._instance.require_calls_allowed()
        self._instance.call_on_vector(self._instance.named(two, three), values)
        return values[:]

    def set_time(self, time: float) -> None:
        """Set the time at which the next values are computed. `time` [s]."""
        self._instance.require_calls_allowed()
        time = number_of(time, "time")
        self._instance.call(self._instance.named("SetTime"), c_double(time))
        self._time = time
