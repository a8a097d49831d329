"""The scenes of the step cost: mechanism, torque, the mode of motion and the least that a step needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from benchmarks.harness.fmu import LOADING, STICK
from benchmarks.harness.timing import Array
from benchmarks.mechanisms import (
    CUBIC,
    DAMPED,
    ELLIPSES,
    FORCES,
    LIGHT,
    START,
    STEP,
    STEPS,
    SWING,
    VISCOUS,
    Parameters,
    drive,
    inside_band,
    jitter,
    tables,
    to_and_fro,
)

# exp and sincos that a step may take, without the calls of FMI
STUCK_TARGET, SLIP_TARGET, GENERAL_TARGET = 1.5, 4.0, 25.0
HALF_SWING = 30  # steps of a block of the general mechanism, whose half swing lasts 40 ms and more


@dataclass(frozen=True)
class Least:
    """The work that a step cannot do without, beside the calls themselves: the limit of its time."""

    why: str
    units: int = 0  # one exp and one sincos each
    evaluations: int = 0  # of the acceleration in general grooves with all forces

    def seconds(self, calls: float, unit: float, evaluation: float) -> float:
        """The time of that work, given the times of the calls, of one unit and of one evaluation [s]."""
        return calls + self.units * unit + self.evaluations * evaluation


CALLS = Least("the calls")
KEPT = Least("the calls: of a step size known before, ten multiplications are left")
NEW = Least("the calls, one exp and one sincos", units=1)
PARTED = Least("the calls, exp and sincos for two parts of the step and for the instant between", units=3)
NODES = Least("the calls, the acceleration at the start and three nodes", evaluations=4)
EVENT = Least(
    "the calls, the acceleration at four points of each step over, to and from the event", evaluations=12
)


@dataclass
class Scene:
    """Parameters, the torque of every step given the stick band at the start, and the mode of motion."""

    name: str
    description: str
    target: float | None
    parameters: Parameters
    torque: Callable[[float, float], Array]  # (torque_release, torque_load) -> N.m, one per step
    mode: int | None = None  # throughout, without any mode change; None: there must be mode changes
    lead_in: int = 0  # untimed steps before the state is saved
    steps: Array = field(default_factory=lambda: np.full(STEPS, STEP))
    through_fmpy: bool = True
    separate: bool = False  # only the steps with mode changes, each from its own saved state
    least: Least | None = None


def straight_scenes() -> list[Scene]:
    """Two helices and linear forces: closed forms."""
    return [
        Scene(
            "stuck",
            "at rest, tau anywhere inside the stick band",
            STUCK_TARGET,
            {"initial.theta": 0.7},
            inside_band,
            STICK,
            least=CALLS,
        ),
        Scene(
            "slip undamped",
            "helices, soft spring, one half swing, tau = 1.30 +- 0.02 T_load",
            SLIP_TARGET,
            SWING,
            drive,
            LOADING,
            lead_in=10,
            least=KEPT,
        ),
        Scene(
            "slip, no ledger",
            "slip undamped with ledger = false",
            SLIP_TARGET,
            {**SWING, "ledger": False},
            drive,
            LOADING,
            lead_in=10,
            least=KEPT,
        ),
        Scene(
            "slip damped",
            "slip undamped, but with follower mass 0.3 kg, its inertia, damper 20 N.s/m",
            SLIP_TARGET,
            {**SWING, **DAMPED},
            drive,
            LOADING,
            lead_in=10,
            least=KEPT,
        ),
        Scene(
            "damped, h varies",
            "slip damped with steps of 0.9 to 1.1 ms: nothing can be kept from the step before",
            None,
            {**SWING, **DAMPED},
            drive,
            LOADING,
            lead_in=10,
            steps=jitter(0.9e-3, 1.1e-3),
            least=NEW,
        ),
        Scene(
            "damped, h = dt",
            "slip damped with h = t[k+1] - t[k], as some masters compute it: its last digits vary",
            None,
            {**SWING, **DAMPED},
            drive,
            LOADING,
            lead_in=10,
            steps=np.diff(np.arange(STEPS + 1) * STEP),
            least=KEPT,
        ),
        Scene(
            "stick-slip",
            "default mechanism, tau = 4 + 4 sin(2 pi 5 t) N.m: sticks, slips both ways, meets the stop",
            None,
            {},
            to_and_fro,
        ),
        Scene(
            "events",
            "the steps of stick-slip in which the mode changes",
            None,
            {},
            to_and_fro,
            through_fmpy=False,
            separate=True,
            least=PARTED,
        ),
    ]


def drive_half_swing(release: float, load: float) -> Array:
    return drive(release, load, HALF_SWING)


def general_scenes() -> list[Scene]:
    """Curved grooves or nonlinear forces: collocation, to the tolerance of the harness."""

    def slipping(name: str, description: str, parameters: Parameters) -> Scene:
        steps = np.full(HALF_SWING, STEP)
        start = START | parameters
        return Scene(
            name,
            description,
            GENERAL_TARGET,
            start,
            drive_half_swing,
            LOADING,
            3,
            steps,
            through_fmpy=False,
            least=NODES,
        )

    def events(name: str, description: str, parameters: Parameters) -> Scene:
        return Scene(
            name, description, None, parameters, to_and_fro, through_fmpy=False, separate=True, least=EVENT
        )

    table = tables()
    return [
        slipping("cubic spring", "helices, spring stiffness with its square and cube", CUBIC),
        slipping(
            "ellipses", "elliptical grooves, all else as it starts, tau = 1.30 +- 0.02 T_load", ELLIPSES
        ),
        slipping("ellipses, no ledger", "ellipses with ledger = false", ELLIPSES | {"ledger": False}),
        slipping(
            "all forces", "ellipses with cubic spring, quadratic damper, masses, losses", ELLIPSES | FORCES
        ),
        slipping("all, no ledger", "all forces with ledger = false", ELLIPSES | FORCES | {"ledger": False}),
        slipping("tables", "the grooves of ellipses, sampled at 37 points", table),
        slipping("tables, all forces", "tables with the forces of all forces", table | FORCES),
        slipping("viscous", "ellipses without inertia, damper 5000 N.s/m", ELLIPSES | VISCOUS),
        slipping("viscous, no ledger", "viscous with ledger = false", ELLIPSES | VISCOUS | {"ledger": False}),
        Scene(
            "ellipses stuck",
            "stuck in elliptical grooves",
            GENERAL_TARGET,
            START | ELLIPSES,
            inside_band,
            STICK,
            through_fmpy=False,
            least=CALLS,
        ),
        Scene(
            "ellipses to and fro",
            "elliptical grooves, tau of stick-slip",
            None,
            ELLIPSES,
            to_and_fro,
            through_fmpy=False,
        ),
        events("ellipses, events", "the steps of ellipses to and fro in which the mode changes", ELLIPSES),
        events("all, events", "the same with all forces", ELLIPSES | FORCES),
        events("tables, events", "the same in tables", table),
        events("viscous, events", "the same without inertia, damper 500 N.s/m", ELLIPSES | VISCOUS | LIGHT),
    ]
