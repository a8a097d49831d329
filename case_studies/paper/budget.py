"""Section of the page: the uncertainty budget redone by Monte Carlo, and the model's own budget."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from scipy.stats import norm

from case_studies.paper.cams import Pair, pair
from case_studies.paper.fmus import FmuResults
from case_studies.paper.published import (
    CLEARANCE,
    DIRECTIONS,
    FRICTION_SPREAD,
    GREASES,
    LEAD_LIMIT,
    LOADING,
    PAIRS,
    PUBLISHED,
    RADIUS_LIMIT,
    RANGE,
    SHAPE_LIMIT,
    SPRING_LIMIT,
    TILT,
    TORQUE,
    UNCERTAINTY,
)
from case_studies.paper.readings import uncertainty_budget
from case_studies.paper.text import paragraph, percent, table
from dualcam.design.tolerances import Propagation, Tolerance, ToleranceAnalysis, analyse, propagate

QUANTITY = {direction: "load" if direction == LOADING else "release" for direction in DIRECTIONS}
SAMPLES = 20_000


@cache
def measurement() -> Propagation:
    """The torque of TORQUE [N.m] at the lever: the tilt with its cosine, and all else together."""
    return propagate(
        lambda x: TORQUE * x["all else"] * np.cos(x["tilt"]),
        [
            Tolerance("all else", norm(1.0, uncertainty_budget().rest)),
            Tolerance.within("tilt", -TILT, TILT, "uniform"),
        ],
        samples=100_000,
    )


def tolerances(cams: Pair) -> list[Tolerance]:
    """Tolerances of a pair with grease 1, assumed."""
    found = [Tolerance(("cam1.friction", "cam2.friction"), norm(GREASES[0], FRICTION_SPREAD))]
    for name, value in (("preload", cams.spring.preload), ("stiffness", cams.spring.stiffness)):
        slack = value * SPRING_LIMIT
        found.append(Tolerance.within(f"spring.{name}", value - slack, value + slack))
    for number, groove in enumerate((cams.inner, cams.outer), 1):
        least, greatest = groove.a * (1.0 - SHAPE_LIMIT), groove.a * (1.0 + SHAPE_LIMIT)
        lead, radius = groove.lead_angle, groove.radius
        cam = f"cam{number}"
        found += [
            Tolerance.within(f"{cam}.lead_angle", lead - LEAD_LIMIT, lead + LEAD_LIMIT),
            Tolerance.within((f"{cam}.ellipse_a", f"{cam}.ellipse_b"), least, greatest, "uniform"),
            Tolerance.within(f"{cam}.radius", radius - RADIUS_LIMIT, radius + RADIUS_LIMIT, "uniform"),
            Tolerance.within(f"{cam}.clearance", 0.0, CLEARANCE, "uniform"),
        ]
    return found


@cache
def model(name: str) -> ToleranceAnalysis:
    """A pair within its tolerances, at 15 angles."""
    cams = pair(name)
    mechanism = cams.mechanism(GREASES[0], cams.spring)
    return analyse(mechanism, tolerances(cams), angles=15, samples=SAMPLES)


def errors(name: str, direction: int) -> np.ndarray:
    """RMSE of each mechanism against the line of the means [N.m], shape (samples,)."""
    found = model(name)[QUANTITY[direction]]
    return np.asarray(np.sqrt(np.mean((found.values - found.budget.value) ** 2, axis=1)))


def names() -> list[str]:
    """The tolerances in words, in the order of `tolerances`."""
    spring = f"within {percent(SPRING_LIMIT, 0)}"
    each = [
        f"lead angle, within {math.degrees(LEAD_LIMIT):.1f} deg",
        f"arc, uniform within {percent(SHAPE_LIMIT, 0)}",
        f"radius, uniform within {1e3 * RADIUS_LIMIT:.2f} mm",
        f"clearance, uniform, 0 to {1e3 * CLEARANCE:.1f} mm",
    ]
    return [
        f"friction, normal, standard deviation {FRICTION_SPREAD}",
        f"preload, {spring}",
        f"stiffness, {spring}",
        *(f"{cam} cam, {what}" for cam in ("inner", "outer") for what in each),
    ]


def budget_section(fmus: FmuResults) -> str:
    """Section on the budget by Monte Carlo."""
    torque, series = measurement(), [(name, way) for name in PAIRS for way in DIRECTIONS]
    middle = model("A").nearest(0.5 * RANGE)
    found = {key: model(key[0])[QUANTITY[key[1]]] for key in series}
    deviations = [
        (one.budget.standard_uncertainty[middle], one.standard_deviation[middle]) for one in found.values()
    ]
    rows = [
        [words, *(f"{found[key].budget.contribution[j, middle]:.1f}" for key in series)]
        for j, words in enumerate(names())
    ]
    rows += [
        ["u to first order, N.m", *(f"{first:.3f}" for first, _ in deviations)],
        ["u by Monte Carlo, N.m", *(f"{second:.3f}" for _, second in deviations)],
        ["RMSE that 95 % do not exceed, N.m", *(f"{np.quantile(errors(*key), 0.95):.2f}" for key in series)],
        ["published RMSE, N.m", *(f"{PUBLISHED[name][way]}" for name, way in series)],
        ["mechanisms with more than that", *(_beyond(*key) for key in series)],
    ]  # fmt: skip
    low, _, high = torque.percentiles[:, 0]
    share = torque.budget.contribution[:, 0]
    return "\n".join(
        [
            "## The budget redone by Monte Carlo\n",
            paragraph(
                f"""
                The measurement. The same two parts as distributions ([tolerances](design-tolerances.md)):
                all else normal with {percent(uncertainty_budget().rest, 2)}, the tilt uniform within
                {TILT} rad, the torque with the cosine of the tilt. To first order (GUM) the tilt has
                {share[1]:.0f} % of the variance, because the cosine has no slope at the perpendicular. By
                Monte Carlo (JCGM 101) the mean is {torque.mean[0] - TORQUE:.4f} N.m off {TORQUE:.0f} N.m
                and the standard deviation is {torque.standard_deviation[0]:.4f} N.m, against
                {torque.budget.standard_uncertainty[0]:.4f} N.m to first order; 95 % of the readings are
                within {low - TORQUE:.3f} and +{high - TORQUE:.3f} N.m. So the tilt is a small bias with
                hardly any spread, and the {UNCERTAINTY * TORQUE:.3f} N.m are on the safe side.
                """
            ),
            paragraph(
                """
                The model. The line that the bench is compared with is uncertain, too: friction, spring and
                grooves of the prototype are not exactly the model's. With tolerances as they are usual
                (assumed), shares of the variance at the middle of the range, in percent:
                """
            ),
            table(["tolerance", *(f"{name}, {DIRECTIONS[way]}" for name, way in series)], rows),
            paragraph(
                f"""
                First order and Monte Carlo agree. The model's own uncertainty is
                {_ratio(found, middle)[0]:.0f} to {_ratio(found, middle)[1]:.0f} times that of the
                measurement, and most of it is friction. "Within" is normal with three standard deviations
                to the limit. Tolerances of this size make an RMSE like that of pair A when loading in
                {_beyond("A", LOADING)} of the mechanisms; the others need more than tolerances.
                """
            ),
        ]
    )


def _ratio(found: dict[tuple[str, int], Propagation], middle: int) -> tuple[float, float]:
    """Least and largest standard deviation over that of a measured torque of the same size."""
    share = measurement().standard_deviation[0] / TORQUE
    ratios = [one.standard_deviation[middle] / (share * one.mean[middle]) for one in found.values()]
    return min(ratios), max(ratios)


def _beyond(name: str, direction: int) -> str:
    """Share of the mechanisms with a larger RMSE than the published one."""
    share = float(np.mean(errors(name, direction) > PUBLISHED[name][direction]))
    return percent(share) if share > 0.0 else f"none of {SAMPLES}"
