"""Section of the page: friction that varies with speed and load, and whether it explains the deviations."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np

from case_studies.paper.cams import Statics, pair
from case_studies.paper.fits import Fit, best, others
from case_studies.paper.fmus import FmuResults
from case_studies.paper.measurements import needed_friction
from case_studies.paper.published import (
    DIRECTIONS,
    GREASES,
    LOAD,
    LOAD_EXPONENTS,
    LOADING,
    OTHERS,
    PAIRS,
    PEAK,
    RANGE,
    RELEASING,
    SLIDING,
    STRIBECK_EXPONENT,
    STRIBECK_VELOCITY,
    VISCOUS,
)
from case_studies.paper.readings import rms
from case_studies.paper.text import paragraph, table
from case_studies.paper.varying import FrictionLaw, Turning, turning

ANGLE = np.linspace(0.0, RANGE, 57)
EXPONENTS = {
    "0": (0.0, 0.0),
    "0 to 1/3": (0.0, 1 / 3),
    "-1/3 to 1/3": (-1 / 3, 1 / 3),
    "-2/3 to 2/3": (-2 / 3, 2 / 3),
}


def speed_law(friction: float) -> FrictionLaw:
    """The law with the plausible numbers, by the grease's kinetic coefficient."""
    return FrictionLaw(friction, PEAK, STRIBECK_VELOCITY, STRIBECK_EXPONENT, VISCOUS)


def load_law(friction: float, exponent: float) -> FrictionLaw:
    """Friction that depends on the load alone."""
    return FrictionLaw(friction, load_exponent=exponent, load=LOAD)


def turn_rate(statics: Statics, sliding: float) -> float:
    """Speed of the cam [rad/s] whose mean sliding speed of both contacts is `sliding` [m/s]."""
    return sliding / float(np.mean(np.concatenate(statics.sliding(1.0))))


@cache
def at_speed(name: str, friction: float, direction: int, sliding: float) -> Turning:
    """A pair at a mean sliding speed [m/s] under the law with the plausible numbers."""
    statics = Statics(pair(name), ANGLE)
    return turning(statics, speed_law(friction), direction, turn_rate(statics, sliding))


def speed_rows() -> list[list[str]]:
    """Rows of the change of torque by the speed: mean over the range."""
    rows = []
    for name, mu, direction in product(PAIRS, GREASES, DIRECTIONS):
        line = Statics(pair(name), ANGLE).torque(direction, mu)
        cells = [f"{np.mean(at_speed(name, mu, direction, v).torque - line):+.2f}" for v in SLIDING]
        rows.append([name, f"{mu}", DIRECTIONS[direction], *cells])
    return rows


def load_rows() -> list[list[str]]:
    """Rows of the change of torque by the load, at the start, at the end, and its RMS."""
    rows = []
    for name, mu, direction in product(PAIRS, GREASES, DIRECTIONS):
        statics = Statics(pair(name), ANGLE)
        cells = []
        for exponent in LOAD_EXPONENTS:
            change = turning(statics, load_law(mu, exponent), direction).torque - statics.torque(
                direction, mu
            )
            cells.append(f"{change[0]:+.2f}, {change[-1]:+.2f} ({rms(change):.2f})")
        rows.append([name, f"{mu}", DIRECTIONS[direction], *cells])
    return rows


def bend(direction: int) -> float:
    """Largest share of the mean change of torque by the speed that is no change of level, over all cases at
    rest and in motion: RMS of the change less its best multiple of the torque's change by the friction."""
    found = []
    for name, mu, sliding in product(PAIRS, GREASES, SLIDING):
        statics = Statics(pair(name), ANGLE)
        line = statics.torque(direction, mu)
        change = at_speed(name, mu, direction, sliding).torque - line
        pattern = statics.torque(direction, 1.001 * mu) - line
        rest = change - pattern * float(change @ pattern) / float(pattern @ pattern)
        found.append(rms(rest) / rms(line))
    return max(found)


def given_back(name: str, friction: float, sliding: float) -> float:
    """Work given back over work put in, at one mean sliding speed."""
    up, down = (at_speed(name, friction, direction, sliding).torque for direction in (LOADING, RELEASING))
    return float(np.trapezoid(down, ANGLE) / np.trapezoid(up, ANGLE))


def fit_rows() -> list[list[str]]:
    """Rows of the laws that come nearest to the published RMSEs."""
    rows = []
    for mu, names in product(GREASES, ("A", "B", "AB")):
        cells = [_shown(best(names, mu, *ends)) for ends in EXPONENTS.values()]
        rows.append([f"{mu}", {"AB": "A and B"}.get(names, names), *cells])
    return rows


def _shown(fit: Fit) -> str:
    return f"{fit.misfit:.2f} (f = {fit.factor:.2f}, nu = {fit.exponent:.2f})".replace(
        "nu = -0.00", "nu = 0.00"
    )


def reactions_change() -> float:
    """Largest relative change of a reaction by the speed."""
    found = []
    for name, mu, direction, sliding in product(PAIRS, GREASES, DIRECTIONS, SLIDING):
        line = Statics(pair(name), ANGLE).reactions(direction, mu)
        now = at_speed(name, mu, direction, sliding).reactions
        found += [float(np.max(np.abs(a / b - 1.0))) for a, b in zip(now, line, strict=True)]
    return max(found)


def varying_friction(fmus: FmuResults) -> str:
    """Section on what friction that varies does to the figures."""
    still, quick = SLIDING[0], SLIDING[-1]
    back = {(name, mu): [given_back(name, mu, v) for v in SLIDING] for name, mu in product(PAIRS, GREASES)}
    law_speeds = [
        [f"{mu}", *(f"{float(speed_law(mu).at(np.array(v), np.array(LOAD))):.3f}" for v in SLIDING)]
        for mu in GREASES
    ]
    head = ["at rest, 0+", *(f"{1e3 * v:.0f} mm/s" for v in SLIDING[1:])]
    powers = " and ".join(_third(one) for one in LOAD_EXPONENTS)
    return "\n".join(
        [
            "## What friction that varies does to Figs. 6 to 9\n",
            paragraph(
                f"""
                The paper asks for friction that depends on sliding speed and pressure. The law is that of
                [the mechanism](mechanism.md), section 9: on the kinetic part acts about the factor
                (N/{LOAD:.0f} N)^nu, where N is the nominal load of one contact. The paper gives no
                numbers. Assumed are such as greased steel has: static over kinetic coefficient {PEAK},
                Stribeck velocity
                {1e3 * STRIBECK_VELOCITY:.0f} mm/s, exponent {STRIBECK_EXPONENT}, lubricated branch
                {VISCOUS} s/m; and nu = {powers}. The grease's coefficient is taken as the kinetic one.
                The torques are by formula; over the speed DualCamInverse.fmu has the same to better than
                1e-11.
                """
            ),
            "![Coefficient over speed, RMSE over friction, torque under the laws](paper_friction.png)\n",
            paragraph("Speed. The coefficient at a mean sliding speed, without dependence on the load:"),
            table(["grease", *head], law_speeds),
            paragraph(
                "Change of the torque against constant friction, mean over the range, in steady turning, N.m:"
            ),
            table(["pair", "friction", "direction", *head], speed_rows()),
            paragraph(
                f"""
                At rest friction is highest, at {1e3 * SLIDING[2]:.0f} to {1e3 * SLIDING[3]:.0f} mm/s
                lowest, above that the lubricated branch takes it up again. The curves of Figs. 6 to 9
                move up (loading) or down (releasing) nearly as with another constant friction: what
                remains is at most {100 * max(bend(direction) for direction in DIRECTIONS):.1f} % of the
                torque, because the sliding speed hardly changes along the range. Reactions change by at
                most {100 * reactions_change():.0f} %. The work given back changes from
                {100 * back["A", 0.14][0]:.1f} % at rest to {100 * back["A", 0.14][2]:.1f} % at
                {1e3 * SLIDING[2]:.0f} mm/s and {100 * back["A", 0.14][-1]:.1f} % at {1e3 * quick:.0f}
                mm/s (pair A, grease 1), with grease 2 {100 * back["A", 0.19][0]:.1f},
                {100 * back["A", 0.19][2]:.1f} and {100 * back["A", 0.19][-1]:.1f} %. At {1e3 * still:.0f}
                mm/s the torques are the edges of the stick band.
                """
            ),
            paragraph(
                f"""
                Load. Change of the torque at the start and at the end of the range and in brackets its RMS,
                N.m, with the grease's coefficient at {LOAD:.0f} N:
                """
            ),
            table(
                ["pair", "friction", "direction", *(f"nu = {_third(one)}" for one in LOAD_EXPONENTS)],
                load_rows(),
            ),
            paragraph(
                """
                So the load does bend the curves: friction that grows with the pressure takes torque away
                at the start when loading and adds torque at the end, and the reverse when releasing.
                """
            ),
        ]
    )


def explanation(fmus: FmuResults) -> str:
    """Section on whether such laws explain the published RMSEs."""
    _, factors = needed_friction(fmus)
    highest = {mu: max(factors[key] for key in factors if key[1] == mu) for mu in GREASES}
    near = {mu: others(mu, 1 / 3) for mu in GREASES}
    far = {mu: others(mu, 2 / 3) for mu in GREASES}
    steady = {mu: best("B", mu, 0.0, 0.0) for mu in GREASES}
    grows = [best("A", mu, 0.0, 1 / 3).misfit for mu in GREASES]
    falls = [best("A", mu, -1 / 3, 0.0).misfit for mu in GREASES]
    rest = [
        abs(float(np.mean(at_speed(name, mu, way, 0.0).torque - Statics(pair(name), ANGLE).torque(way, mu))))
        for name, mu, way in product(PAIRS, GREASES, DIRECTIONS)
    ]
    small, large = min(rest), max(rest)
    alone = {name: np.concatenate([near[mu].alone[name] for mu in GREASES]) for name in PAIRS}
    return "\n".join(
        [
            "## Does friction that varies explain the deviations?\n",
            paragraph(
                f"""
                At one speed the law is about f mu (N/{LOAD:.0f} N)^nu along the whole range: the factor f
                holds static coefficient, Stribeck's fall and lubricated branch. So there are two numbers,
                f and
                nu, and four published RMSEs. The law that comes nearest to the RMSEs, and the factor by
                which the worst RMSE is off (f from 0.3 to 2; signs of the deviations are not published,
                so both are allowed):
                """
            ),
            table(["friction", "pair", *(f"nu = {words}" for words in EXPONENTS)], fit_rows()),
            paragraph(
                f"""
                In {OTHERS} other pairs of each kind (|nu| up to 1/3) pair B alone comes within a factor
                of {np.median(alone["B"]):.2f} (median; 95 % below {np.quantile(alone["B"], 0.95):.2f}),
                pair A alone within {np.median(alone["A"]):.2f}, at best {alone["A"].min():.2f}. One law
                for all four RMSEs: of {near[GREASES[0]].together.size} combinations of a pair A and a
                pair B the best is off by {near[GREASES[0]].together.min():.2f} with grease 1 and by
                {near[GREASES[1]].together.min():.2f} with grease 2; with |nu| up to 2/3 by
                {far[GREASES[0]].together.min():.2f} and {far[GREASES[1]].together.min():.2f} (median
                {np.median(far[GREASES[0]].together):.2f} and {np.median(far[GREASES[1]].together):.2f}).
                """
            ),
            "What holds:\n",
            "\n".join(
                [
                    _item(
                        f"""
                        Pair B alone: yes, in size. Friction {steady[GREASES[0]].factor:.2f} times that of
                        grease 1 or {steady[GREASES[1]].factor:.2f} times that of grease 2 makes both
                        RMSEs within {100 * (max(fit.misfit for fit in steady.values()) - 1):.0f} %,
                        without any dependence on the load. As a Stribeck effect this is a static over
                        kinetic coefficient of that size, with the bench at rest or far below the Stribeck
                        velocity, and the grease's coefficient measured in motion. With the plausible
                        {PEAK} it is not reached. With the lubricated branch alone, at 0.1 m/s, it takes
                        {(steady[GREASES[0]].factor - 1) * GREASES[0] / 0.1:.1f} s/m (grease 1), so that
                        friction rises from {GREASES[0]} to {steady[GREASES[0]].factor * GREASES[0]:.2f}.
                        """
                    ),
                    _item(
                        f"""
                        Pair A alone: no. With nu from -1/3 to 1/3 it is off by a factor of
                        {min(best("A", mu, -1 / 3, 1 / 3).misfit for mu in GREASES):.2f} at best, with nu
                        from -2/3 to 2/3 by
                        {min(best("A", mu, -2 / 3, 2 / 3).misfit for mu in GREASES):.2f}. Pair A asks for
                        more friction when releasing than when loading, and the nominal load is the same
                        in both directions. An elastic point contact has nu = -1/3.
                        """
                    ),
                    _item(
                        f"""
                        Friction that grows with the pressure, as the paper has it, does not help pair A:
                        off by {min(grows):.2f} at best, and by {min(falls):.2f} if friction falls with
                        the pressure.
                        """
                    ),
                    _item(
                        f"""
                        All four RMSEs by one law at one speed: no. They are off by
                        {min(best("AB", mu, -2 / 3, 2 / 3).misfit for mu in GREASES):.2f} at best, even
                        with nu from -2/3 to 2/3. Of the other pairs, with |nu| up to 1/3, none come
                        within {100 * (min(near[mu].together.min() for mu in GREASES) - 1):.0f} %.
                        """
                    ),
                    _item(
                        f"""
                        All four by one law with an own speed for each series: possible, because each RMSE
                        then has its own factor (table above, "more friction"). It takes a static over
                        kinetic coefficient of {highest[GREASES[0]]:.2f} (grease 1) or
                        {highest[GREASES[1]]:.2f} (grease 2). The paper gives no speeds, so this can
                        neither be confirmed nor refuted; for torques read by hand at rest the speed is 0
                        in all series, which is the case above: no.
                        """
                    ),
                ]
            ),
            "",
            paragraph(
                f"""
                So friction that varies makes deviations of the published size, but no single law makes all
                four. With the plausible numbers the torque at rest changes by {small:.2f} to {large:.2f} N.m:
                more than the deviation of pair A when loading, less than each of the three others. Readings
                inside the stick band make errors of that size without any new law. What would decide: torques
                in both directions at two or three known speeds, with the signs of the deviations.
                """
            ),
        ]
    )


def _item(text: str) -> str:
    """An entry of a list."""
    lines = paragraph(text).rstrip().split("\n")
    return "- " + "\n  ".join(lines)


def _third(value: float) -> str:
    return f"{'-' if value < 0 else ''}1/{abs(1 / value):.0f}"
