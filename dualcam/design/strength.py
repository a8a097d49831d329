"""Can the grooves be made, and do they carry their load?

With the signed curvature k of the unwrapped path of the pin's centre (+ where the groove steepens) the inner
flank of a pin of radius p is undercut where p |k| >= 1. On the flank below the path, which supports the
spring, the relative radius is p (1 + k p), on the other flank p (1 - k p) (hertz.py). The flank counts as the
cylinder into which it unwraps at the cam's radius, as in the FMU's statics.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dualcam.common.unit_guards import unit_warning, warn_units
from dualcam.design.hertz import Pin, hertz_pressure
from dualcam.design.mechanism import POINTS, Mechanism
from dualcam.design.statics import Array, check_points
from dualcam.errors import DesignError
from dualcam.fmi.variables import parameters_of

JAM = "jam"
RANGES = {"spring_safety": (0.01, 100.0), "wear_depth": (1e-9, 1.0), "cycles": (0.0, 1e15)}  # 1, m, 1
LEVEL = 1e-9  # rad: a lead angle up to this counts as level, as in the FMU


@dataclass(frozen=True)
class Limits:
    """Allowed values.

    Parameters
    ----------
    lead_angle : Least and greatest lead angle [rad].
    pressure : Greatest contact pressure [Pa].
    self_locking : Whether a contact may lock itself.
    spring_safety : Least Goodman safety of the helical spring [1].
    wear_depth : Greatest depth of wear of each groove and of the pin [m].
    cycles : Least number of slow cycles until the wear has that depth; 0: any number.

    Raises
    ------
    DesignError : Lead angles that do not grow inside [0, pi/2], or another value outside its range.

    Examples
    --------
    >>> from dualcam.design import Limits
    >>> Limits(pressure=1.2e9).self_locking
    False
    """

    lead_angle: tuple[float, float] = (math.radians(5.0), math.radians(80.0))
    pressure: float = 1.5e9
    self_locking: bool = False
    spring_safety: float = 1.2
    wear_depth: float = 0.1e-3
    cycles: float = 0.0

    def __post_init__(self) -> None:
        low, high = self.lead_angle
        if not 0.0 <= low < high <= 0.5 * math.pi:
            hint = unit_warning("limits.lead_angle", high) or ""
            raise DesignError(
                f"lead_angle = {self.lead_angle}: allowed are two growing angles in [0, pi/2] in rad"
                + (f"; {hint.partition(': ')[2]}" if hint else "")
            )
        if not self.pressure > 0.0:
            raise DesignError(f"pressure = {self.pressure}: allowed is a number > 0")
        for name, (low, high) in RANGES.items():
            if not low <= getattr(self, name) <= high:
                raise DesignError(
                    f"{name} = {getattr(self, name):g}: allowed is a number from {low:g} to {high:g}"
                )
        warn_units({name: (f"limits.{name}", getattr(self, name)) for name in ("pressure", "wear_depth")})


@dataclass(frozen=True)
class LimitViolation:
    """The first angle where a property is outside its limits."""

    what: str
    theta: float  # rad
    value: float
    text: str  # a sentence with angle, value and allowed values

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, eq=False)
class Strength:
    """Properties at angles theta, shape (n,); pairs have shape (2, n)."""

    theta: Array  # rad
    force: Array  # N, of the spring
    rho: Array  # m, torque of loading per spring force, infinite in a jam
    lead_angle: Array  # rad
    friction_angle: Array  # rad, atan of the coefficient of friction at rest
    curvature: Array  # 1/m, signed
    load: Array  # N per contact: the larger one of slow loading and releasing
    pressure: Array  # Pa, likewise


@dataclass(frozen=True, eq=False)
class Assessment(Strength):
    """Properties over the range, and all findings."""

    findings: tuple[LimitViolation, ...]

    @property
    def good(self) -> bool:
        """Whether there are no findings."""
        return not self.findings

    def require(self) -> Assessment:
        """This assessment; DesignError with all findings if there are any."""
        if self.findings:
            raise DesignError("; ".join(map(str, self.findings)))
        return self


def assess(
    mechanism: Mechanism, pin: Pin | None, limits: Limits | None = None, points: int = POINTS
) -> Assessment:
    """Can the grooves of a `mechanism` be made, do they carry their load, and does the FMU start with them?

    The assessment has the properties where both grooves reach, shape (points,), and findings: each kind of
    failure once for each groove, at the first angle where it occurs. Without findings (`good`) the FMU starts
    with `mechanism.parameters(...)`.

    `pin`: without a pin neither undercut nor contact pressure is checked. `limits`: allowed lead
    angles, pressure and self-locking. `points`: angles, evenly over the range, at which the properties are
    computed; a failure is located in between. DesignError: for fewer than 2 points.

    Examples
    --------
    >>> import math
    >>> from dualcam.design import Helix, Mechanism, Pin, Spring, assess
    >>> groove = Helix(radius=0.02, lead_angle=math.pi / 4)
    >>> cam = Mechanism((groove, groove), (0.14, 0.14), Spring(50.0, 5e4), upper=1.3963)
    >>> assess(cam, Pin(radius=0.003, width=0.008)).good
    True
    """
    check_points(points, 2)
    outside = [] if mechanism.lower <= 0.0 <= mechanism.upper else [_start_outside(mechanism)]
    found, findings = examine(mechanism, pin, limits or Limits(), points)
    return Assessment(**vars(found), findings=(*outside, *findings))


def examine(
    mechanism: Mechanism, pin: Pin | None, limits: Limits, points: int = POINTS, locate: bool = True
) -> tuple[Strength, tuple[LimitViolation, ...]]:
    """Properties and findings as in `assess`, whether or not theta = 0 is between the stops. Without `locate`
    a failure is given at the first of the `points` angles that fails, which takes less time."""
    low, high = mechanism.reach()
    found = strength(mechanism, pin, np.linspace(low, high, points))
    failures = (check.first(mechanism, pin, found, locate) for check in _checks(mechanism, pin, limits))
    ends = (
        _groove_end(mechanism, end, stop) for end, stop in ((low, mechanism.lower), (high, mechanism.upper))
    )
    findings = [*ends, *failures, *_outside_limits(mechanism)]
    return found, tuple(finding for finding in findings if finding)


def _start_outside(mechanism: Mechanism) -> LimitViolation:
    low, high = mechanism.lower, mechanism.upper
    text = f"start at theta = 0: allowed is a range that includes 0, not {low:.6g} to {high:.6g} rad"
    return LimitViolation("start", 0.0, 0.0, text)


def _outside_limits(mechanism: Mechanism) -> list[LimitViolation]:
    """Parameters that the FMU refuses, by the limits in its modelDescription.xml."""
    known = parameters_of("forward")
    return [
        LimitViolation(
            name, mechanism.lower, float(value), f"{name} = {value:.6g}: allowed is {known[name].allowed()}"
        )
        for name, value in mechanism.parameters_without_tables().items()
        if not known[name].least <= value <= known[name].greatest
    ]


def _groove_end(mechanism: Mechanism, end: float, stop: float) -> LimitViolation | None:
    """The groove that ends before a stop, if one does."""
    if end == stop:
        return None
    psi = mechanism.configuration(end).psi
    side, name = (1, "an upper") if stop > 0.0 else (0, "a lower")
    ends = [groove.range[side] for groove in mechanism.grooves]
    i = int(np.argmin([abs(ends[k] - float(psi[k])) for k in range(2)]))
    text = (
        f"groove {i + 1} ends at psi = {ends[i]:.6g} rad, reached at theta = {end:.6g} rad: allowed is {name}"
        f" stop up to there, not {stop:.6g} rad"
    )
    return LimitViolation(f"groove {i + 1} ends", end, end, text)


def strength(mechanism: Mechanism, pin: Pin | None, theta: Array) -> Strength:
    """Properties at angles theta [rad], shape (n,). Without a pin the pressure is NaN."""
    configuration = mechanism.configuration(theta)
    bends = mechanism.curvature(theta)
    force = mechanism.spring.force(configuration.z)
    (_, rho), reaction = mechanism.edges(configuration.slope, force)
    friction = mechanism.friction_under(configuration.slope, force)
    # [releasing or loading, groove, theta]; no load of motion where no torque moves the cam in that direction
    reactions = np.where(np.isfinite(reaction), reaction, 0.0) * force / mechanism.contacts
    loads = np.abs(reactions)
    # a pin that bears on the other flank has a negative reaction
    flank = np.where(reactions < 0.0, -1.0, 1.0)
    pressures = np.full(loads.shape, np.nan) if pin is None else hertz_pressure(loads, pin, flank * bends)
    lead = np.arctan(configuration.slope / np.array(mechanism.radius)[:, None])
    angle = np.arctan(np.stack([np.broadcast_to(mu, theta.shape) for mu in friction]))
    return Strength(theta, force, rho, lead, angle, bends, loads.max(axis=0), pressures.max(axis=0))


@dataclass(frozen=True)
class _Check:
    """One property and its limits."""

    what: str
    value: Callable[[Strength], Array]  # in `unit`
    good: Callable[[Strength], NDArray[np.bool_]]
    unit: str
    allowed: str
    excess: Callable[[Array], Array]  # of values: larger where they are farther outside the limits

    def first(
        self, mechanism: Mechanism, pin: Pin | None, found: Strength, locate: bool
    ) -> LimitViolation | None:
        """The first angle where the property is outside its limits, located between the checked angles."""
        whole, good = found, self.good(found)
        while not good.all():
            k = int(np.argmin(good))
            low, high = float(found.theta[max(k - 1, 0)]), float(found.theta[k])
            if high - low <= 1e-9 or not locate:
                value = float(self.value(found)[k])
                return LimitViolation(self.what, high, value, self._text(whole, high, value))
            found = strength(mechanism, pin, np.linspace(low, high, 33))
            good = self.good(found)
        return None

    def _text(self, whole: Strength, theta: float, value: float) -> str:
        """The property at the first angle outside the limits; also the worst value, where that is another."""
        first = f"theta = {math.degrees(theta):.4g} deg"
        if self.what == JAM:
            return f"{JAM}: friction is too high for the lead angles; at {first} no torque can turn cam 2"
        bad = np.flatnonzero(~self.good(whole))
        values = self.value(whole)[bad]
        k = int(np.argmax(self.excess(values)))
        if f"{values[k]:.6g}" == f"{value:.6g}":
            return f"{self.what} at {first} is {value:.6g} {self.unit}: allowed is {self.allowed}"
        worst = f"theta = {math.degrees(whole.theta[bad[k]]):.4g} deg"
        return (
            f"{self.what} reaches {values[k]:.6g} {self.unit} at {worst}: allowed is {self.allowed}; outside"
            f" from {first}"
        )


def _checks(mechanism: Mechanism, pin: Pin | None, limits: Limits) -> list[_Check]:
    checks = [
        _Check(
            "spring force",
            lambda s: s.force,
            # a spring without preload: the force begins at 0 where z = 0
            lambda s: (s.force > 0.0) | ((s.force == 0.0) & (s.theta == 0.0)),
            "N",
            "> 0",
            np.negative,
        ),
        _Check(
            "both grooves level: steeper lead angle",
            lambda s: np.degrees(s.lead_angle.max(axis=0)),
            lambda s: s.lead_angle.max(axis=0) > LEVEL,
            "deg",
            "> 0, or nothing fixes the pin",
            np.negative,
        ),
        _Check(
            JAM,
            lambda s: s.rho,
            lambda s: np.isfinite(s.rho),
            "m",
            "a finite torque of loading per spring force",
            np.positive,
        ),
    ]
    for i in range(2):
        checks += _checks_of_groove(i, mechanism, pin, limits)
    return checks


def _checks_of_groove(i: int, mechanism: Mechanism, pin: Pin | None, limits: Limits) -> list[_Check]:
    name, (low, high) = f"of groove {i + 1}", limits.lead_angle
    least, greatest = math.degrees(low), math.degrees(high)
    locking = f"{math.degrees(math.atan(mechanism.friction[i])):.6g} deg"
    checks = [
        _Check(
            f"lead angle {name}",
            lambda s: np.degrees(s.lead_angle[i]),
            lambda s: (s.lead_angle[i] >= low) & (s.lead_angle[i] <= high),
            "deg",
            f"{least:.6g} to {greatest:.6g} deg",
            lambda lead: np.maximum(least - lead, lead - greatest),
        ),
        _Check(
            f"self-locking: lead angle {name}",
            lambda s: np.degrees(s.lead_angle[i]),
            lambda s: (s.lead_angle[i] > s.friction_angle[i]) | limits.self_locking,
            "deg",
            f"more than the angle of friction{', ' + locking if mechanism.load_laws[i] is None else ''}",
            np.negative,
        ),
    ]
    return checks if pin is None else [*checks, *_checks_of_pin(i, pin, limits)]


def _checks_of_pin(i: int, pin: Pin, limits: Limits) -> list[_Check]:
    name = f"of groove {i + 1}"
    return [
        _Check(
            f"undercut: curvature {name}",
            lambda s: np.abs(s.curvature[i]),
            lambda s: pin.radius * np.abs(s.curvature[i]) < 1.0,
            "1/m",
            f"less than 1/(pin radius) = {1.0 / pin.radius:.6g} 1/m",
            np.positive,
        ),
        _Check(
            f"contact pressure {name}",
            lambda s: s.pressure[i] / 1e6,
            # an undercut flank has a finding of its own
            lambda s: (s.pressure[i] <= limits.pressure) | np.isinf(s.pressure[i]),
            "MPa",
            f"{limits.pressure / 1e6:.6g} MPa",
            np.positive,
        ),
    ]
