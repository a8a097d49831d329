"""Sections of the page: uncertainty, readings by hand, other friction laws."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from case_studies.paper.cams import Statics, pair
from case_studies.paper.fmus import FmuResults
from case_studies.paper.published import (
    DIRECTIONS,
    EXPONENTS,
    FEW,
    GREASES,
    LEVER,
    LOADING,
    PAIRS,
    PUBLISHED,
    READINGS,
    RELEASING,
    TILT,
    TORQUE,
    UNCERTAINTY,
)
from case_studies.paper.readings import (
    DRAWS,
    band_at_readings,
    friction_for,
    largest_change,
    law_error,
    readings,
    rms,
    share_needed,
    uncertainty_budget,
)
from case_studies.paper.text import paragraph, percent, span, table


def uncertainty(fmus: FmuResults) -> str:
    """Section on the uncertainty and the published RMSE."""
    budget = uncertainty_budget()
    rows = [
        [
            name,
            DIRECTIONS[direction],
            f"{error}",
            percent(error / TORQUE, 2),
            f"{error / (UNCERTAINTY * TORQUE):.0f}",
        ]
        for name in PAIRS
        for direction, error in PUBLISHED[name].items()
    ]
    return "\n".join(
        [
            "## Uncertainty and the published RMSE ((19) to (21), sections 7 and 8)\n",
            paragraph(
                f"""
                The force at the {1e3 * LEVER:.0f} mm lever may be up to {TILT} rad (3 degrees)
                off the perpendicular. Torque goes with the sine of an angle near pi/2, so that costs 1 -
                cos = {percent(budget.as_cosine, 2)}, not sin = {percent(budget.as_sine, 2)}. With the total
                of {percent(UNCERTAINTY, 2)}, all else together is {percent(budget.rest, 2)} (root of
                squares); the sine would make it {percent(budget.printed_total, 2)},
                {budget.printed_total * TORQUE:.2f} N.m of {TORQUE:.0f} N.m, instead of
                {UNCERTAINTY * TORQUE:.3f} N.m. As it only ever loses torque it is a bias: if
                all tilts up to that are equally likely, {percent(budget.bias, 3)} with a standard deviation
                of {percent(budget.spread, 3)}.
                """
            ),
            table(
                ["pair", "direction", "published RMSE, N.m", "of 10 N.m", "times the uncertainty"],
                rows,
            ),
            paragraph(
                f"""
                Section 8 has all of them below 1.5 N.m (loading) and 0.7 N.m (releasing) and within 5 %.
                Neither holds: 1.51 and 0.735 N.m, and of 10 N.m
                {sum(e / TORQUE > 0.05 for w in PUBLISHED.values() for e in w.values())} of 4 are
                above 5 %. No RMSE is explained by the uncertainty of the measurement.
                """
            ),
        ]
    )


def measurements(fmus: FmuResults) -> str:
    """Section on hand-read static torques."""
    rows = []
    for draw in DRAWS:
        cells = [draw]
        for name in PAIRS:
            for mu in GREASES:
                found, _ = readings(band_at_readings(name, mu), draw)
                cells.append(f"{found.mean:.2f} ({found.low:.2f} to {found.high:.2f})")
        rows.append(cells)
    uniform = next(iter(DRAWS))
    shares = [
        [
            name,
            DIRECTIONS[direction],
            f"{error}",
            *(f"{share_needed(error, band_at_readings(name, mu)):.2f}" for mu in GREASES),
            span([math.sqrt(3.0) * error / rms(up - down) for _, up, down in fmus.others[name]]),
        ]
        for name in PAIRS
        for direction, error in PUBLISHED[name].items()
    ]
    ratios = {
        count: readings(band_at_readings("B", GREASES[0], count), uniform)[1] for count in (READINGS, FEW)
    }
    ratio = {name: max(PUBLISHED[name].values()) / min(PUBLISHED[name].values()) for name in PAIRS}
    return "\n".join(
        [
            "## What hand-read static torques must show\n",
            "![Readings inside the stick band](paper_measurements.png)\n",
            paragraph(
                f"""
                At rest any torque between the two edges of the stick band is in equilibrium, so a torque
                that is read by hand with the mechanism at rest can be any of them. The kinetostatic line is
                the edge: readings are one-sided, below the line when loading, above it when releasing. RMSE
                against the line, N.m, of {READINGS} readings along the range (number assumed), mean of 4000
                series and in brackets 95 % of them:
                """
            ),
            table(["readings lie", *(f"{name}, friction {mu}" for name in PAIRS for mu in GREASES)], rows),
            paragraph(
                """
                Readings anywhere in the band would have an RMSE of 1/sqrt(3) of its RMS width, more than
                any published one. If nothing else is wrong and readings spread evenly over the part of the
                band next to the line, that part is:
                """
            ),
            table(
                ["pair", "direction", "published RMSE, N.m", *(f"part, friction {mu}" for mu in GREASES),
                 "part, other pairs, friction 0.14"],
                shares,
            ),
            paragraph(
                f"""
                So stick alone makes errors of the published size, and those RMSEs neither confirm nor
                refute the model. One habit in both directions is not the whole story: published RMSEs
                differ {ratio['A']:.2f}-fold (A, releasing larger) and {ratio['B']:.2f}-fold (B, loading
                larger); two series of {READINGS} readings from the same even spread differ by
                {ratios[READINGS][0]:.2f} to {ratios[READINGS][1]:.2f} (95 %), of {FEW} readings by
                {ratios[FEW][0]:.2f} to {ratios[FEW][1]:.2f}. What would tell: the signs of the errors
                (stick makes loading too low and releasing too high, more friction the reverse), and torques
                that are raised and lowered until it just moves.
                """
            ),
        ]
    )  # fmt: skip


def needed_friction(fmus: FmuResults) -> tuple[list[list[str]], dict[tuple[str, float, int], float]]:
    """Rows of the constant frictions that make the published RMSE; the larger one over the grease's."""
    rows, factors = [], {}
    for name, mu in product(PAIRS, GREASES):
        statics = Statics(pair(name), fmus.angle)
        for direction, error in PUBLISHED[name].items():
            more, less = (friction_for(statics, mu, direction, error, sign) for sign in (1, -1))
            factors[name, mu, direction] = more / mu
            share = error / rms(fmus.curves[name, mu, direction].torque)
            cells = (f"{friction:.3f} ({friction / mu:.2f})" for friction in (more, less))
            rows.append([name, f"{mu}", DIRECTIONS[direction], f"{error}", *cells, percent(share)])
    return rows, factors


def load_laws(fmus: FmuResults) -> list[list[str]]:
    """Rows of the RMSE that friction which falls with the load makes, and that the other grease makes."""
    rows = []
    for name, direction in product(PAIRS, DIRECTIONS):
        statics = Statics(pair(name), fmus.angle)
        cells = [
            ", ".join("locks" if math.isnan(error) else f"{error:.2f}" for error in errors)
            for errors in (law_error(statics, GREASES[0], n, direction) for n in EXPONENTS)
        ]
        other = rms(statics.torque(direction, GREASES[1]) - statics.torque(direction, GREASES[0]))
        rows.append([name, DIRECTIONS[direction], f"{PUBLISHED[name][direction]}", *cells, f"{other:.2f}"])
    return rows


def friction_laws(fmus: FmuResults) -> str:
    """Section on other friction laws for pair B."""
    needed, factors = needed_friction(fmus)
    pair_b = [factor for (name, _, _), factor in factors.items() if name == "B"]
    others = [Statics(cams, fmus.angle) for cams, _, _ in fmus.others["B"]]
    level = {
        direction: [friction_for(s, GREASES[0], direction, PUBLISHED["B"][direction], 1) for s in others]
        for direction in DIRECTIONS
    }
    ratio = max(
        float(sliding.max() / sliding.min())
        for name in PAIRS
        for sliding in fmus.curves[name, GREASES[0], LOADING].sliding
    )
    change = largest_change(ratio)
    first, second = (tuple(factors[name, mu, LOADING] for mu in GREASES) for name in ("B", "A"))
    load = np.concatenate(Statics(pair("B"), fmus.angle).nominal_loads())
    return "\n".join(
        [
            "## Could another friction law explain pair B?\n",
            paragraph(
                """
                The constant friction that would make the whole RMSE (in brackets: times that of the
                grease), and the error of the spring's force, or of anything else that scales the torque,
                that would:
                """
            ),
            table(
                ["pair", "friction", "direction", "RMSE, N.m", "more friction", "less friction", "force, by"],
                needed,
            ),
            paragraph(
                f"""
                For both RMSEs of pair B to come from more friction it takes {min(pair_b):.2f} to
                {max(pair_b):.2f} times the grease's; the two directions then ask for about the same, in the
                pairs assumed, as they do for a spring force that is off. With less friction they agree
                worse, with grease 1 not at all. In other pairs of kind B (grease 1) it is
                {span(level[LOADING], 3)} (loading) and {span(level[RELEASING], 3)} (releasing). Pair A's
                two directions ask for different frictions; both of its RMSEs do not come from one.
                """
            ),
            paragraph(
                f"""
                Stribeck. Along the range the sliding speed of steady turning changes by no more than
                {ratio:.2f} to 1 (pairs A and B, both contacts), so of mu_s - mu_k at most {percent(change)}
                can appear or vanish along the range, whatever the Stribeck velocity (exponential law): it
                lifts the curve, it does not bend it. To make pair B's errors it must lift friction by the
                factors above: torques of breaking loose, compared with a friction that was measured in
                motion, and mu_s/mu_k of {first[0]:.2f} for grease 1 or {first[1]:.2f} for grease 2, more
                than the step from one grease to the other ({GREASES[1] / GREASES[0]:.2f}). Pair A on the
                same grease allows {second[0]:.2f} or {second[1]:.2f} when loading.
                """
            ),
            paragraph(
                f"""
                Load. The nominal load of pair B, its reaction without friction, changes by
                {load.max() / load.min():.1f} to 1. With mu ~ N^-n: n = 1/3 is an elastic point contact whose
                friction goes with its area, n = 1/2 a line contact. RMSE against constant friction 0.14,
                N.m, when both agree at the least, the mean and the largest load:
                """
            ),
            table(
                ["pair", "direction", "published", "n = 1/3", "n = 1/2", "friction 0.19 for 0.14"],
                load_laws(fmus),
            ),
            paragraph(law_conclusion(fmus)),
        ]
    )


def law_conclusion(fmus: FmuResults) -> str:
    """Conclusion on friction that falls with the load."""
    statics = Statics(pair("B"), fmus.angle)
    most = {
        (direction, n): max(law_error(statics, GREASES[0], n, direction))
        for direction, n in product(DIRECTIONS, EXPONENTS)
    }
    loose = [
        max(law_error(Statics(cams, fmus.angle), GREASES[0], 1 / 2, LOADING))
        for cams, _, _ in fmus.others["B"]
    ]
    loading, releasing = (PUBLISHED["B"][direction] for direction in DIRECTIONS)
    return f"""
    The {loading} N.m of pair B when loading are out of reach of both: at most {most[LOADING, 1 / 3]:.2f} and
    {most[LOADING, 1 / 2]:.2f} N.m. So are its {releasing} N.m when releasing: at most
    {most[RELEASING, 1 / 3]:.2f} and {most[RELEASING, 1 / 2]:.2f} N.m. In the other pairs of kind B n = 1/2
    makes {span(loose)} N.m when loading (5th to 95th percentile). Taking one grease for the other is not
    enough for B's loading either. What is enough is a friction that is higher all along, by the factors
    above, or a spring, radius or lead angle that is off, or stick; only the bench's data could tell which.
    """
