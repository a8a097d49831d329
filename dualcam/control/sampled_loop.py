"""The forward FMU in the loop with a sampled controller: where the loop settles."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import control
import numpy as np

from dualcam.control.forward import LOWER_STOP, STICK, UPPER_STOP, Names, Source, name_list, open_forward
from dualcam.errors import FmuError
from dualcam.fmi.fmu import Fmu, RepeatedStart
from dualcam.fmi.model_description import Scalar
from dualcam.fmi.reals import Array

CHUNK = 1000  # samples between two looks at the record
CYCLES = 8  # latest ones that must be equal in a limit cycle
EQUAL = 0.005  # relative: cycles whose amplitudes and periods differ by less
REST = 1e-5  # of the room between the stops: a swing below is rest
FEW, MANY = 2, 40  # unequal cycles in the latest part of the record: enough at its end, enough to end it
PERSISTENT = 1.3  # most range of the last two parts over that of the last one, of unequal cycles that stay
GROWN, FADED = 1.002, 0.5  # least growth of a swing that grows; last growth over the first one
LATE = 0.4  # of the record, its end: the part that says where the loop settles
BLOCK = 4096  # samples of the controller at rest, computed at once
MOST_SAMPLES = 4e6  # of one run: a minute, and 600 MB of record
MOST_TORQUE = 1e12  # N.m: only a controller that is unstable gets there
# The inputs that a controller may have, as shares of the error (theta less the angle) and of the speed.
SIGNALS = {"error": (1.0, 0.0), "theta": (-1.0, 0.0), "omega": (0.0, 1.0), "reference": (0.0, 0.0)}
CONSTANT = re.compile(r"[xu]d\[\d+\]")  # references of control.create_statefbk_iosystem
ENDLESS = 1e150  # states of a controller at rest are cut off here, far from the end of the doubles

Law: TypeAlias = control.NonlinearIOSystem | control.TransferFunction  # a StateSpace is a NonlinearIOSystem


class SampledController:
    """A linear controller of the angle, whose torque [N.m] is held over a period: x after = A x + B y,
    torque = C x + D y, with y the error of the angle [rad] and the speed [rad/s]."""

    def __init__(self, law: Law, inputs: Names = None) -> None:
        if not isinstance(law, Law):
            raise FmuError(
                f"controller = {law!r}: allowed is a control.StateSpace or control.TransferFunction with a"
                " sampling time, such as control.ss([], [], [], 50.0, 1e-3) for the gain 50 N.m/rad each 1 ms"
            )
        period = getattr(law, "dt", None)
        if isinstance(period, bool) or not isinstance(period, (int, float)) or not period > 0.0:
            raise FmuError(
                f"controller with dt = {period!r}: allowed is a sampled controller, since the torque is held"
                " over its period [s]; control.sample_system(controller, 1e-3) makes one of a continuous one"
            )
        if law.noutputs != 1:
            raise FmuError(
                f"controller with {law.noutputs} outputs: allowed is a controller without the cam, with one"
                " output, the torque [N.m]"
            )
        signals = np.array([SIGNALS[name] for name in _signals(law, inputs)])
        system = _state_space(law)
        self.period = float(period)
        self.A, self.B, self.C, self.D = system.A, system.B @ signals, system.C[0], system.D[0] @ signals
        self._of_state, self._of_error = self._constant_error()

    def _constant_error(self) -> tuple[Array, Array]:
        """States after 0 to BLOCK samples with a constant error: their parts of the first state, shape
        (BLOCK + 1, states, states), and of the error, shape (BLOCK + 1, states)."""
        of_state, of_error = [np.eye(self.states)], [np.zeros(self.states)]
        for _ in range(BLOCK):
            of_state.append(np.clip(self.A @ of_state[-1], -ENDLESS, ENDLESS))
            of_error.append(np.clip(self.A @ of_error[-1] + self.B[:, 0], -ENDLESS, ENDLESS))
        return np.array(of_state), np.array(of_error)

    @property
    def largest_pole(self) -> float:
        """Largest magnitude of the controller's poles; 0 without states."""
        return float(np.abs(np.linalg.eigvals(self.A)).max(initial=0.0))

    @property
    def integrates(self) -> bool:
        """Whether a constant error can make the torque grow without end."""
        return self.largest_pole > 1.0 - 1e-9

    @property
    def unstable(self) -> bool:
        """Whether the torque grows exponentially if the cam does not move."""
        return self.largest_pole > 1.0 + 1e-9

    def ahead(self, x: Array, error: float) -> Array:
        """States after 0 to BLOCK samples with a constant error [rad], shape (BLOCK + 1, states)."""
        return self._of_state @ x + error * self._of_error

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.A)

    def state_phasor(self, frequency: float) -> Array:
        """States over the error, at an angular frequency [rad/s]; complex, shape (states,)."""
        z = np.exp(1j * frequency * self.period)
        return np.linalg.solve(z * np.eye(self.states) - self.A, self.B @ [1.0, -1j * frequency])

    def response(self, frequency: float) -> complex:
        """First harmonic of the held torque over the error [N.m/rad]."""
        held = 1j * frequency * self.period
        direct = self.D @ [1.0, -1j * frequency]
        return complex((self.C @ self.state_phasor(frequency) + direct) * -np.expm1(-held) / held)


def _signals(law: Law, inputs: Names) -> list[str]:
    """The signal at each input of the controller. FmuError for what is none, or if the angle is none."""
    labels = law.input_labels if inputs is None else name_list(inputs)
    found = ["reference" if CONSTANT.fullmatch(label) else label for label in labels]
    if inputs is None and len(found) == 1 and found[0] not in SIGNALS:
        return ["error"]
    if len(found) != law.ninputs or not set(found) <= SIGNALS.keys() or not {"error", "theta"} & set(found):
        raise FmuError(
            f"controller with {law.ninputs} input{'s'[: law.ninputs != 1]}, named {', '.join(found)}:"
            " allowed are error (theta less the angle) [rad], theta (the angle) [rad], omega [rad/s], and"
            " reference for each input that stays constant; error or theta must be one. Name them in the"
            " controller's order, such as"
            ' inputs=["reference", "theta"]'
        )
    return found


def _state_space(law: Law) -> control.StateSpace:
    """The controller with states. FmuError if there is none, or none with finite coefficients."""
    if not isinstance(law, control.StateSpace | control.TransferFunction):
        law = _linear_part(law)
    if isinstance(law, control.TransferFunction):
        numbers = [part for row in (*law.num, *law.den) for part in row]
    else:
        numbers = [law.A, law.B, law.C, law.D]
    if not all(np.isfinite(part).all() for part in numbers):
        listed = ", ".join(str(np.asarray(part).tolist()) for part in numbers)
        raise FmuError(f"controller with the coefficients {listed}: allowed are finite numbers")
    if isinstance(law, control.StateSpace):
        return law
    try:
        parts = control.append(*(control.ss(law[0, column]) for column in range(law.ninputs)))
    except ValueError as error:
        raise FmuError(
            f"controller that python-control cannot write with states: {error}; allowed is a numerator whose"
            " degree is not above that of the denominator"
        ) from error
    total = np.ones((1, law.ninputs))
    return control.ss(parts.A, parts.B, total @ parts.C, total @ parts.D, law.dt)


def _linear_part(law: control.NonlinearIOSystem) -> control.StateSpace:
    """A controller by functions, without its constants. FmuError unless it is linear in states and inputs."""
    size = law.nstates + law.ninputs

    def value(at: Array) -> Array:
        x, u = np.split(at, [law.nstates])
        return np.concatenate([np.ravel(law.dynamics(0.0, x, u)), np.ravel(law.output(0.0, x, u))])

    constant = value(np.zeros(size))
    matrix = np.array([value(unit) - constant for unit in np.eye(size)]).T
    for at in np.random.default_rng(0).normal(size=(4, size)) * [[1e-3], [1.0], [1e3], [1e6]]:
        linear = matrix @ at
        if not np.allclose(value(at) - constant, linear, rtol=1e-6, atol=1e-6 * np.abs(linear).max()):
            raise FmuError(
                f"controller = {law!r} is not linear in its states and inputs: allowed is a linear controller"
                " without the cam; control.linearize(controller, states, inputs) makes one"
            )
    (A, B), (C, D) = (np.hsplit(rows, [law.nstates]) for rows in np.vsplit(matrix, [law.nstates]))
    return control.ss(A, B, C, D, law.dt)


def check_duration(duration: float, period: float) -> None:
    """FmuError for a duration [s] of runs that is no time, or too many samples of the period [s]."""
    if isinstance(duration, bool) or not isinstance(duration, (int, float)) or not 0.0 < duration < math.inf:
        raise FmuError(f"duration = {duration!r} s: allowed is a finite number > 0")
    if duration > MOST_SAMPLES * period:
        raise FmuError(
            f"duration = {duration:g} s with the controller's period of {period:g} s is"
            f" {duration / period:.3g} samples per run: allowed are {MOST_SAMPLES:g}. A duration up to"
            f" {MOST_SAMPLES * period:.3g} s works, or a period from {duration / MOST_SAMPLES:.3g} s on, or"
            " check=False"
        )


@dataclass(frozen=True)
class LoopMotion:
    """Where a loop settles.

    Attributes
    ----------
    kind
        "rest"; "stop" where the torque presses the cam on a stop; "cycle"; "irregular" where the cam goes on
        to move in unequal cycles; "grows" where the last cycles still grow; "diverges" where the controller's
        torque passes 1e12 N.m, or a state 1e308; or "undecided" where the swing still decays or the motion is
        too slow for the duration.
    amplitude : Half the range of the angle [rad], 0 at rest.
    torque : Half the range of the torque [N.m].
    frequency : Angular frequency of cycles [rad/s], the mean one of irregular cycles; else NaN.
    lowest, highest : Ends of the angle's range [rad].
    """

    kind: str
    amplitude: float
    torque: float
    frequency: float
    lowest: float
    highest: float


class SampledLoop:
    """The forward FMU with a controller on its angle. The loop has no reference but `theta` [rad]."""

    def __init__(
        self, source: Source, parameters: Mapping[str, Scalar], controller: SampledController, theta: float
    ) -> None:
        self.fmu, values = open_forward(Fmu, source, parameters)
        self._runs = RepeatedStart(self.fmu, values, ["initial.theta", "initial.omega", "tau"])
        self._tau, self._motion = self.fmu.reals("tau"), self.fmu.reals("theta", "omega")
        self._edges = self.fmu.reals("torque_release", "torque_load")
        self._room = self.fmu.real("stop.upper") - self.fmu.real("stop.lower")
        self.controller, self.theta = controller, theta

    def close(self) -> None:
        """Free the FMU."""
        self.fmu.close()

    @np.errstate(over="ignore", invalid="ignore")  # of states that grow without end
    def settle(self, theta: float, omega: float, x: Array, bias: float, duration: float) -> LoopMotion:
        """Run from an angle [rad], a speed [rad/s] and states of the controller, until the loop rests or
        swings in equal cycles, or `duration` [s] has passed. `bias`: torque beside the controller's [N.m]."""
        law, record = self.controller, _Record(self._room)
        x, samples, last = np.array(x, dtype=float), 0, round(duration / law.period)
        self._runs.start([theta, omega, bias])
        while samples < last:
            for _ in range(CHUNK):
                theta, omega = self._motion.read()
                measured = np.array([self.theta - theta, omega])
                torque = bias + float(law.C @ x + law.D @ measured)
                record.add(samples * law.period, theta, torque)
                if not abs(torque) <= MOST_TORQUE:  # NaN where a state has left the doubles
                    return record.late("diverges")
                x = law.A @ x + law.B @ measured
                self._tau.values[:] = torque
                self._tau.write()
                self.fmu.step(law.period)
                samples += 1
            if self.fmu.get("mode") == STICK:
                samples, x = self._wait(x, bias, samples, last, record)
            if record.rests(self.theta) or record.decided():
                break
        pressed = self.fmu.get("mode") in (LOWER_STOP, UPPER_STOP)
        return record.settled(self.theta, pressed, law.integrates)

    def _wait(self, x: Array, bias: float, samples: int, last: int, record: _Record) -> tuple[int, Array]:
        """While the torque stays in the stick band nothing moves: only the controller goes on."""
        law = self.controller
        theta, _ = self._motion.read()
        release, load = self._edges.read()
        error = self.theta - theta
        while samples < last:
            states = law.ahead(x, error)
            torques = bias + states @ law.C + law.D[0] * error
            out = np.flatnonzero(~((torques > release) & (torques < load)))
            passed = int(out[0]) if out.size else BLOCK
            samples, x = samples + passed, states[passed]
            record.add(samples * law.period, theta, float(torques[passed]))
            if out.size:
                break
        return samples, x


class _Record:
    """Time, angle and torque of a run."""

    def __init__(self, room: float) -> None:
        self._rows: list[tuple[float, float, float]] = []
        self._seen = np.empty((0, 3))  # the rows at the latest look
        self._least = REST * room
        self._next = 0  # rows at which the record is looked at again

    def add(self, time: float, theta: float, torque: float) -> None:
        self._rows.append((time, theta, torque))

    def decided(self) -> bool:
        """Whether the latest cycles are equal, or unequal for long. The record is looked at each time it has
        grown by a fifth."""
        if len(self._rows) < self._next:
            return False
        self._next = math.ceil(1.2 * len(self._rows))
        return self.cycle() is not None or (self.irregular(MANY) is not None and not self.grows())

    def rests(self, reference: float) -> bool:
        """Whether the latest samples are at the reference, but for what counts as rest."""
        recent = np.array(self._rows[-CHUNK:])[:, 1]
        return bool(np.abs(recent - reference).max() <= self._least)

    def _late(self, share: float) -> tuple[Array, Array, Array]:
        """The last part of the record."""
        if len(self._seen) < len(self._rows):
            self._seen = np.array(self._rows)
        time, theta, torque = self._seen.T
        late = time >= (1.0 - share) * time[-1]
        return time[late], theta[late], torque[late]

    def cycle(self) -> LoopMotion | None:
        """The limit cycle, if the latest cycles are equal and do not grow."""
        time, theta, torque = self._late(0.5)
        ups = _rises(theta)[-CYCLES - 1 :]
        if np.ptp(theta) <= self._least or len(ups) <= CYCLES:
            return None
        ranges, periods = _ranges(theta, ups), np.diff(time[ups])
        resolution = 2.0 * (time[1] - time[0])  # of a period, a sample at each end
        if np.ptp(ranges) > EQUAL * ranges.max() or np.ptp(periods) > EQUAL * periods.max() + resolution:
            return None
        return None if self.grows() else _settled("cycle", ups, time, theta, torque)

    def grows(self) -> bool:
        """Whether the swing is larger in each quarter of the latest cycles, and the growth does not fade."""
        theta = self._late(0.5)[1]
        quarters = np.array_split(_ranges(theta, _rises(theta)), 4)
        if np.ptp(theta) <= self._least or not all(map(len, quarters)):
            return False
        mean = np.array([np.mean(quarter) for quarter in quarters])
        rise, scatter = np.diff(mean), max(map(np.ptp, quarters))
        steady = rise.min() > 0.0 and rise[-1] > FADED * rise[0]
        return bool(steady and mean[3] - mean[0] > max(scatter, (GROWN - 1.0) * mean[0]))

    def settled(self, reference: float, pressed: bool, integrates: bool) -> LoopMotion:
        """The limit cycle, rest, a stop on which the cam is pressed, or none of them. At rest a torque that
        an integrator still changes is not settled."""
        if found := self.cycle():
            return found
        if self.rests(reference):
            return self._still("rest")
        if self._quiet() and pressed:
            return self._still("stop")
        if self._quiet() and not (integrates and self._torque_changes()):
            return self._still("rest")
        return self.late("grows") if self.grows() else self.irregular(FEW) or self.late("undecided")

    def _quiet(self) -> bool:
        return bool(np.ptp(self._late(LATE)[1]) <= self._least)

    def _torque_changes(self) -> bool:
        """At the end: between the last two rows, which are a wait apart where the cam sticks."""
        return self._rows[-1][2] != self._rows[-2][2]

    def _still(self, kind: str) -> LoopMotion:
        _, theta, _ = self._late(LATE)
        return LoopMotion(kind, 0.0, 0.0, math.nan, float(theta.min()), float(theta.max()))

    def late(self, kind: str) -> LoopMotion:
        """Ranges of angle and torque at the end of the record."""
        _, theta, torque = self._late(LATE)
        low, high = float(theta.min()), float(theta.max())
        return LoopMotion(kind, 0.5 * (high - low), 0.5 * float(np.ptp(torque)), math.nan, low, high)

    def irregular(self, least: int) -> LoopMotion | None:
        """Unequal cycles that do not decay, at least so many of them."""
        time, theta, torque = self._late(LATE)
        swing = np.ptp(theta)
        if swing <= self._least or np.ptp(self._late(2.0 * LATE)[1]) > PERSISTENT * swing:
            return None
        ups = _rises(theta)
        return _settled("irregular", ups, time, theta, torque) if len(ups) > least else None


def _settled(kind: str, ups: list[int], time: Array, theta: Array, torque: Array) -> LoopMotion:
    """Between the first and the last rise."""
    whole = slice(ups[0], ups[-1] + 1)
    low, high = float(theta[whole].min()), float(theta[whole].max())
    frequency = 2.0 * math.pi * (len(ups) - 1) / float(time[ups[-1]] - time[ups[0]])
    return LoopMotion(kind, 0.5 * (high - low), 0.5 * float(np.ptp(torque[whole])), frequency, low, high)


def _ranges(theta: Array, ups: list[int]) -> Array:
    """The range of the angle in each cycle, from rise to rise."""
    return np.array([np.ptp(theta[a : b + 1]) for a, b in pairwise(ups)])


def _rises(theta: Array) -> list[int]:
    """Samples at which the angle rises through the middle of its range, after it has been below by a quarter
    of the range."""
    margin = 0.25 * np.ptp(theta)
    found, armed = [], False
    for k, value in enumerate(theta - 0.5 * (theta.min() + theta.max())):
        if value < -margin:
            armed = True
        elif armed and value >= 0.0:
            found.append(k)
            armed = False
    return found
