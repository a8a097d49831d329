"""The torque band of slow motion under tolerances: percentiles, yield, uncertainty budget."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import real_array
from dualcam.common.entries import is_whole
from dualcam.design.mechanism import Mechanism
from dualcam.design.statics import Array
from dualcam.design.tolerances.limits import Limit, Yield, check_quantity, yield_of
from dualcam.design.tolerances.propagation import (
    PERCENTILES,
    STEP,
    Propagation,
    budget_of,
    check_confidence,
    check_levels,
    summarize,
)
from dualcam.design.tolerances.sampled_mechanism import (
    QUANTITIES,
    UNITS,
    SampledBand,
    allowed,
    names_of,
    own_value,
    sampled_band,
)
from dualcam.design.tolerances.tolerance import Tolerance, check_names, complex_steps, draw, means
from dualcam.errors import DesignError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLOCK = 200_000  # values of each quantity that are computed at once
MOST_VALUES = 20_000_000  # of each quantity: 0.8 GB of memory in all
ANGLES = 57


@runtime_checkable
class HasMechanism(Protocol):
    """What has a mechanism, such as a design from read_design."""

    def mechanism(self) -> Mechanism:
        """The mechanism."""


@dataclass(frozen=True, eq=False)
class ToleranceAnalysis:
    """The torque band under tolerances. Each quantity is a `Propagation` over the angles.

    Attributes
    ----------
    theta : Angles [rad], shape (n,).
    parameters : The drawn values by name, shape (samples,).
    quantities
        "load" and "release" [N.m]: edges of the stick band. "efficiency" [1]: release over load. "z" [m]:
        height of the pin. "backlash" [rad]: play of cam 2 where the axial force changes its sign.
    yields : One for each limit.
    total_yield : All limits at once; None without limits.
    locking, jamming : Share of the samples that lock themselves, or that no torque loads, at some angle.
    """

    theta: Array
    parameters: dict[str, Array]
    quantities: dict[str, Propagation]
    yields: tuple[Yield, ...]
    total_yield: Yield | None
    locking: float
    jamming: float

    def __getitem__(self, quantity: str) -> Propagation:
        check_quantity(quantity)
        return self.quantities[quantity]

    def nearest(self, angle: float) -> int:
        """Place in `theta` of the angle that is nearest to an `angle` [rad]."""
        return int(np.argmin(np.abs(self.theta - angle)))

    def budget_table(self, quantity: str, angle: float) -> str:
        """The first-order budget at one angle as text, with the Monte Carlo result below.

        `quantity`: "load", "release", "efficiency", "z" or "backlash". `angle` [rad]; the nearest analysed
        angle counts.
        """
        found, k = self[quantity], self.nearest(angle)
        budget, unit = found.budget, UNITS[quantity]
        width = max(map(len, budget.names))
        lines = [f"{quantity} at theta = {self.theta[k]:.4g} rad: {budget.value[k]:.6g} {unit}"]
        order = np.argsort(-np.round(budget.contribution[:, k], 6), kind="stable")  # rounding decides no tie
        lines += [
            f"  {budget.names[j]:{width}}  {budget.part[j, k]:+.3g} {unit}"
            f"  {budget.contribution[j, k]:5.1f} %"
            for j in order
        ]
        first, second = budget.standard_uncertainty[k], found.standard_deviation[k]
        lines.append(
            f"standard uncertainty {first:.3g} {unit} to first order, {second:.3g} {unit} by Monte Carlo"
        )
        return "\n".join(lines)

    def __str__(self) -> str:
        middle = self.nearest(0.5 * (self.theta[0] + self.theta[-1]))
        lines = [self.budget_table(name, self.theta[middle]) for name in ("load", "release")]
        lines += map(str, self.yields)
        if self.total_yield is not None and len(self.yields) > 1:
            lines.append(str(self.total_yield))
        for share, what in ((self.locking, "lock themselves"), (self.jamming, "jam")):
            if share > 0.0:
                lines.append(f"{100.0 * share:.3g} % of the samples {what} at some angle")
        return "\n".join(lines)

    def draw_band(self, axes: Axes) -> None:
        """The edges of the stick band in `axes`: median, and between the outer percentiles an area."""
        degrees = np.degrees(self.theta)
        for name, colour in (("load", "C0"), ("release", "C1")):
            found = self.quantities[name]
            order = np.argsort(found.levels)
            low, high = found.percentiles[order[0]], found.percentiles[order[-1]]
            ends = f"{found.levels[order[0]]:g} to {found.levels[order[-1]]:g} %"
            axes.fill_between(degrees, low, high, color=colour, alpha=0.3, lw=0, label=f"{name}, {ends}")
            axes.plot(degrees, np.median(found.values, axis=0), color=colour, label=f"{name}, median")
        axes.set(xlabel="angle theta [deg]", ylabel="torque [N.m]")
        axes.margins(x=0.0)
        axes.legend()

    def draw_budget(self, axes: Axes, angle: float, quantities: Sequence[str] = ("load", "release")) -> None:
        """Contributions of the `quantities` to the variance at one angle, as bars in `axes`.

        `angle` [rad]; the nearest analysed angle counts.
        """
        k, names = self.nearest(angle), self.quantities["load"].budget.names
        places, width = np.arange(len(names)), 0.8 / len(quantities)
        for i, name in enumerate(quantities):
            found = self[name]
            deviation = f"{found.standard_deviation[k]:.3g} {UNITS[name]}".removesuffix(" 1")
            shift = (i - 0.5 * (len(quantities) - 1)) * width
            label = f"{name}: u = {deviation}"
            axes.barh(places + shift, found.budget.contribution[:, k], width, color=f"C{i}", label=label)
        axes.set_yticks(places, names)
        axes.invert_yaxis()
        degrees = math.degrees(self.theta[k])
        axes.set(xlabel=f"share of the variance at {degrees:.3g} deg [%]")
        axes.legend()


def analyse(
    design: Mechanism | HasMechanism,
    tolerances: Sequence[Tolerance],
    angles: int | ArrayLike = ANGLES,
    samples: int = 10_000,
    seed: int = 0,
    limits: Sequence[Limit] = (),
    percentiles: Sequence[float] = PERCENTILES,
    confidence: float = 0.95,
) -> ToleranceAnalysis:
    """The torque band of slow motion under tolerances.

    Monte Carlo: JCGM 101:2008. First-order budget: JCGM 100:2008. Physics: docs/mechanism.md, sections 2 and
    3, and for the clearance docs/design-tolerances.md.

    Parameters
    ----------
    design
        The nominal mechanism. Parameters without a tolerance keep its values. The friction of a design file
        with `friction_peak` is the static one.
    tolerances
        Independent distributions of `cam1.radius`, the groove law's parameters such as `cam1.lead_angle`,
        `cam1.friction`, likewise cam2, `spring.preload`, `spring.stiffness`, `spring.stiffness2`,
        `spring.stiffness3`; and of `cam1.clearance` [m], width of the groove less diameter of the pin, and
        `cam1.groove_scale` [1], the factor on all heights of the groove.
    angles : How many angles, evenly over the range, or the angles [rad], shape (n,).
    samples : Mechanisms of the Monte Carlo method.
    seed : Start of the random numbers. The same seed gives the same mechanisms.
    limits : What a good mechanism keeps.
    percentiles : Percentages, 0 to 100.
    confidence : Probability of the intervals of the yields.

    Returns
    -------
    ToleranceAnalysis

    Raises
    ------
    DesignError
        Unknown names, a distribution with values that are not allowed, grooves that end inside the range, a
        spring that pulls, a mechanism that jams at the means, or other bad arguments. The message names the
        value and what is allowed.

    Examples
    --------
    >>> import math
    >>> from scipy.stats import norm
    >>> from dualcam.design import Helix, Mechanism, Spring
    >>> from dualcam.design.tolerances import Limit, Tolerance, analyse
    >>> groove = Helix(radius=0.02, lead_angle=math.pi / 4)
    >>> cam = Mechanism((groove, groove), (0.14, 0.14), Spring(50.0, 5e4), upper=1.3963)
    >>> grease = Tolerance(("cam1.friction", "cam2.friction"), norm(0.14, 0.01))
    >>> found = analyse(cam, [grease], angles=[0.5], limits=[Limit("load", most=4.1)])
    >>> found["load"].budget.standard_uncertainty.round(4)  # N.m
    array([0.0811])
    >>> round(found.total_yield.share, 2)
    0.93
    """
    mechanism = design if isinstance(design, Mechanism) else _mechanism_of(design)
    _check_tolerances(mechanism, tolerances)
    theta = _angles(mechanism, angles)
    levels = check_levels(percentiles)
    check_confidence(confidence)
    if not isinstance(limits, Sequence) or not all(isinstance(one, Limit) for one in limits):
        raise DesignError(f"limits = {limits!r:.60}: allowed is a list of Limit")
    at_means = sampled_band(
        mechanism, {name: np.array([mean]) for name, mean in means(tolerances).items()}, theta
    )
    if not np.isfinite(at_means.load).all() or not np.isfinite(at_means.release).all():
        jam = theta[~(np.isfinite(at_means.load) & np.isfinite(at_means.release))[0]][0]
        raise DesignError(
            f"with the means of all tolerances friction jams the mechanism at theta = {jam:.4g} rad"
        )
    steps = sampled_band(mechanism, complex_steps(tolerances, STEP), theta)
    if is_whole(samples) and samples * len(theta) > MOST_VALUES:
        raise DesignError(
            f"samples = {samples} at {len(theta)} angles: allowed are {MOST_VALUES} in all, which is"
            f" {MOST_VALUES // len(theta)} samples at these angles"
        )
    parameters = draw(tolerances, samples, seed)
    _require_allowed(parameters)
    band = _in_blocks(mechanism, parameters, theta, samples)
    quantities = {
        name: summarize(
            getattr(band, name),
            budget_of(tolerances, getattr(at_means, name)[0], getattr(steps, name)),
            levels,
        )
        for name in QUANTITIES
    }
    good = [limit.holds(quantities[limit.quantity].values, theta) for limit in limits]
    total = yield_of(np.all(good, axis=0), "all limits", confidence) if good else None
    return ToleranceAnalysis(
        theta,
        parameters,
        quantities,
        tuple(yield_of(one, limit.label, confidence) for one, limit in zip(good, limits, strict=True)),
        total,
        float((band.release <= 0.0).any(axis=1).mean()),
        float(np.isinf(band.load).any(axis=1).mean()),
    )


def _mechanism_of(design: object) -> Mechanism:
    if isinstance(design, HasMechanism):
        return design.mechanism()
    raise DesignError(f"design = {design!r:.60}: allowed is a Mechanism, or a design from read_design")


def _check_tolerances(mechanism: Mechanism, tolerances: Sequence[Tolerance]) -> None:
    check_names(tolerances)
    known = names_of(mechanism)
    for tolerance in tolerances:
        for name in tolerance.names:
            if name not in known:
                near = get_close_matches(name, known, n=3)
                guess = f"did you mean {' or '.join(near)}?" if near else ""
                raise DesignError(
                    f"tolerance of {name!r}: allowed are {', '.join(known)}; {guess}".rstrip("; ")
                )
            least, greatest, words = allowed(name)
            tolerance.require_inside(least, greatest, words)
            if (value := own_value(mechanism, name)) is not None:
                tolerance.warn_without(name, value)


def _require_allowed(parameters: dict[str, Array]) -> None:
    for name, values in parameters.items():
        least, greatest, words = allowed(name)
        bad = ~((values >= least) & (values <= greatest))
        if bad.any():
            raise DesignError(
                f"{name}: {int(bad.sum())} of {len(values)} samples are not allowed, the first is"
                f" {values[bad][0]:.6g}: allowed is {words}"
            )


def _angles(mechanism: Mechanism, angles: int | ArrayLike) -> Array:
    if is_whole(angles):
        angles = int(angles)
        if angles < 2:
            raise DesignError(f"angles = {angles}: allowed is 2 or more, or a list of angles in rad")
        return mechanism.angles(angles)
    theta = np.atleast_1d(real_array(angles, "angles", DesignError))
    low, high = mechanism.lower, mechanism.upper
    if theta.ndim != 1 or not len(theta) or not ((theta >= low) & (theta <= high)).all():
        raise DesignError(
            f"angles = {angles!r:.60}: allowed is a whole number, or angles from {low:.6g} to {high:.6g} rad"
        )
    return theta


def _in_blocks(mechanism: Mechanism, parameters: dict[str, Array], theta: Array, samples: int) -> SampledBand:
    """The band of all samples, in blocks that fit into the memory of the processor."""
    size = max(1, BLOCK // len(theta))
    blocks = [
        sampled_band(mechanism, {name: values[k : k + size] for name, values in parameters.items()}, theta)
        for k in range(0, samples, size)
    ]
    return SampledBand(*(np.concatenate([getattr(block, name) for block in blocks]) for name in QUANTITIES))
