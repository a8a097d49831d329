"""Does a design last: stresses, wear and fatigue of a design file, by the formulas of dualcam.design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from dualcam.common.arrays import Array
from dualcam.design import Limits, LineContact, line_contact, wear
from dualcam.design.strength import strength

if TYPE_CHECKING:
    from dualcam.design import Fatigue, HelicalSpring, Mechanism, Pin, Wear, WearLife
    from dualcam.design_file.design import DesignFile


@dataclass(frozen=True)
class SpringNumbers:
    """Forces and stresses of the helical spring at preload and at full stroke."""

    least: float  # N
    largest: float  # N
    rate: float  # of wire and coil, N/m
    lower: float  # corrected shear stress at the least force, Pa
    upper: float  # corrected shear stress at the largest force, Pa
    safety: float  # of Goodman
    static_safety: float  # allowed over largest uncorrected shear stress
    limit: float  # least safety of Goodman that is allowed
    has_length: bool  # whether the free length is given: else neither length nor buckling is checked


@dataclass(frozen=True)
class RollerNumbers:
    """Whether the roller rolls, and its coefficients of friction."""

    rolls: bool
    friction: float  # in effect
    rolling_friction: float
    sliding_friction: float


@dataclass(frozen=True)
class WearNumbers:
    """Wear up to the allowed depth."""

    depth: float  # that is allowed, m
    part: str  # that first has this depth: groove 1, groove 2 or pin
    cycles: float  # slow ones, until then
    preload_loss: float | None  # of the spring then, N; None if the mechanism does not work any more
    load_loss: float | None  # largest share of the torque to load that is then lost
    load_change: tuple[float, float] | None  # least and greatest change of the torque to load, a share
    release_change: tuple[float, float] | None  # the same of the releasing torque; None if self-locking
    rolls: bool  # whether a roller rolls, so that the wear rates must be those of a rolling contact


def spring_forces(mechanism: Mechanism) -> tuple[float, float]:
    """Least and largest force of the spring between the stops [N]."""
    low, high = mechanism.spring.force(mechanism.configuration(np.array(mechanism.reach())).z)
    return float(low), float(high)


def spring_fatigue(spring: HelicalSpring, mechanism: Mechanism) -> Fatigue:
    """Stresses and Goodman safety of the spring between the stops. DesignError where the spring pulls."""
    return spring.fatigue(*spring_forces(mechanism))


def spring_numbers(design: DesignFile, mechanism: Mechanism) -> SpringNumbers | None:
    """The spring of the design; None without wire and coil."""
    spring = design.helical_spring
    if spring is None:
        return None
    least, largest = spring_forces(mechanism)
    cycle = spring.fatigue(least, largest)
    return SpringNumbers(
        least=least,
        largest=largest,
        rate=spring.rate,
        lower=cycle.lower,
        upper=cycle.upper,
        safety=cycle.safety,
        static_safety=spring.static_safety(largest),
        limit=(design.limits or Limits()).spring_safety,
        has_length=design.spring_limits is not None,
    )


def roller_numbers(design: DesignFile) -> RollerNumbers | None:
    """The roller of the design; None without one."""
    roller = design.roller
    if roller is None:
        return None
    return RollerNumbers(roller.rolls, roller.friction, roller.rolling_friction, roller.sliding_friction)


def wear_of(design: DesignFile, mechanism: Mechanism) -> Wear | None:
    """Wear of one slow cycle; None without a pin, and where nothing wears."""
    rates = (design.value("cam1.wear"), design.value("cam2.wear"))
    if design.pin is None or not (any(rates) or design.pin.wear):
        return None
    turns = design.roller is not None and design.roller.rolls
    return wear(mechanism, design.pin, rates, turns)


def wear_life(design: DesignFile, found: Wear) -> WearLife:
    """Cycles until a part has the allowed depth of wear."""
    return found.life((design.limits or Limits()).wear_depth)


def wear_numbers(design: DesignFile, mechanism: Mechanism) -> WearNumbers | None:
    """Wear of the design up to the allowed depth; None where nothing wears."""
    from dualcam.errors import DesignError

    found = wear_of(design, mechanism)
    if found is None:
        return None
    life = wear_life(design, found)
    try:
        worn = found.after(life.cycles)
    except DesignError:  # the allowed depth is deeper than the formulas hold, or slackens the spring
        worn = None
    return WearNumbers(
        depth=(design.limits or Limits()).wear_depth,
        part=life.part,
        cycles=life.cycles,
        preload_loss=worn.preload_loss if worn else None,
        load_loss=float(np.nanmax(worn.load_loss)) if worn else None,
        load_change=_change(worn.load_loss) if worn else None,
        release_change=_change(worn.release_loss) if worn else None,
        rolls=found.turns,
    )


def _change(loss: Array) -> tuple[float, float] | None:
    """Least and greatest change of a torque, as a share, from its losses; None where no loss is known."""
    known = loss[np.isfinite(loss)]
    return (-float(known.max()), -float(known.min())) if len(known) else None


def largest_contact(mechanism: Mechanism, pin: Pin, cam: int, theta: float) -> LineContact:
    """The line contact in the groove of that cam at theta, of slow loading or releasing: the larger load."""
    found = strength(mechanism, pin, np.array([theta]))
    bend, load = float(found.curvature[cam - 1, 0]), float(found.load[cam - 1, 0])
    return line_contact(load, pin, bend)


# ---- words ----


def roller_words(roller: RollerNumbers) -> str:
    """Whether the roller rolls, and its friction."""
    motion = "rolls" if roller.rolls else "slides"
    return (
        f"{motion}, coefficient of friction {roller.friction:.4g} (rolling {roller.rolling_friction:.4g},"
        f" sliding {roller.sliding_friction:.4g})"
    )


def spring_words(spring: SpringNumbers) -> str:
    """Rate, stresses and safeties."""
    return (
        f"rate {spring.rate / 1e3:.4g} N/mm, shear stress {spring.lower / 1e6:.4g} to"
        f" {spring.upper / 1e6:.4g} MPa, Goodman safety {spring.safety:.3g}, limit {spring.limit:g}; static"
        f" safety {spring.static_safety:.3g}"
    )


def wear_words(found: WearNumbers) -> str:
    """The part that wears first, its cycles, and what is then lost."""
    first = f"{found.part} is {1e3 * found.depth:.4g} mm deep after {found.cycles:.4g} cycles"
    rolling = "; the roller rolls: the wear rates must be those of a rolling contact" if found.rolls else ""
    if found.preload_loss is None:
        return f"{first}; the cam does not work any more then{rolling}"
    lost = f"the spring has lost {found.preload_loss:.3g} N of its preload"
    changes = [f"the {name} is {words}" for name, words in torque_changes(found)]
    return f"{first}; then {', '.join([lost, *changes])}{rolling}"


def torque_changes(found: WearNumbers) -> list[tuple[str, str]]:
    """Names of the torques whose change is known, and both ends of the change in words."""
    changes = {"torque to load": found.load_change, "releasing torque": found.release_change}
    return [(name, change_words(*change)) for name, change in changes.items() if change]


def change_words(low: float, high: float) -> str:
    """Least and greatest change, shares, such as "0.02 % to 0.5 % more" or "2 % less to 4 % more"."""
    low, high = (round(100.0 * share, 9) for share in (low, high))  # rounding is no change
    if low < 0.0 < high:
        return f"{-low:.3g} % less to {high:.3g} % more"
    near, far = (f"{size:.3g} %" for size in sorted((abs(low), abs(high))))
    side = "less" if low < 0.0 else "more"
    return f"{far} {side}" if near == far else f"{near} to {far} {side}"
