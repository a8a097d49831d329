"""The paper on the dual cylindrical cam, reproduced and corrected: writes docs/paper.md and its pictures.

    ./build.sh paper

Every number of the page is computed here or in paper_model.py, through the FMUs where they can. The page has
no date, so that a test can write it anew and compare.
"""

from __future__ import annotations

import argparse
import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from pathlib import Path

import numpy as np
import paper_model as model
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from paper_model import GREASES, LOADING, PUBLISHED, RANGE, RELEASING, Array, Case, Curve, Pair, Statics, rms

from dualcam import Fmu

ROOT = Path(__file__).resolve().parent.parent
PAIRS = ("A", "B")
WAYS = {LOADING: "loading", RELEASING: "releasing"}
UNEQUAL, RADII = GREASES, (model.INNER_RADIUS, model.OUTER_RADIUS)
EQUAL = (0.02, 0.02)  # radii, m
OTHERS = 60  # other pairs of each kind that the published facts allow
MAP = 360  # points along each axis of the efficiency map
READINGS = 15  # angles at which a torque is read by hand, assumed
FEW = 5  # and if they are few
SPEED, QUADRATIC = 0.1, 1000.0  # m/s and N.s2/m2: example of a damper
PULL = -1500.0  # N: example of an external axial force
EXPONENTS = (1 / 3, 1 / 2, 1.0)  # of the load, by which friction falls
WEAR, HARDNESS = 1e-5, 2e9  # Archard's K and H [Pa], assumed


@dataclass(frozen=True)
class Work:
    """All that is taken from the FMUs."""

    inverse: Fmu
    forward: Fmu

    @cached_property
    def angle(self) -> Array:
        return np.linspace(0.0, RANGE, 57)

    @cached_property
    def curves(self) -> dict[tuple[str, float, int], Curve]:
        return {
            (name, mu, way): model.curve(self.inverse, model.pair(name), mu, way, self.angle)
            for name in PAIRS
            for mu in GREASES
            for way in WAYS
        }

    @cached_property
    def others(self) -> dict[str, list[tuple[Pair, Array, Array]]]:
        """Other pairs with their torques when loading and releasing, grease 1."""
        found: dict[str, list[tuple[Pair, Array, Array]]] = {name: [] for name in PAIRS}
        for name in PAIRS:
            for cams in model.other_pairs(name, OTHERS):
                up, down = (
                    model.curve(self.inverse, cams, GREASES[0], way, self.angle).torque for way in WAYS
                )
                found[name].append((cams, up, down))
        return found

    @cached_property
    def heat(self) -> dict[tuple[str, float], float]:
        """Friction heat of a slow cycle, J."""
        return {
            (name, mu): sum(model.friction_heat(self.forward, model.pair(name), mu))
            for name in PAIRS
            for mu in GREASES
        }

    def best_on_grid(self, friction: float) -> tuple[float, float, float]:
        """Largest efficiency on a grid of lead angles with pi/4 in it: lead angles and efficiency."""
        grid = np.linspace(0.3, 0.5 * math.pi - 0.3, 21)
        found = [
            (model.efficiency_of_fmu(self.inverse, (x, y), (friction, friction), EQUAL), x, y)
            for x in grid
            for y in grid
        ]
        best, x, y = max(found)
        return float(x), float(y), best


# ---- Words and tables --------------------------------------------------------------------------------


def paragraph(text: str) -> str:
    return textwrap.fill(" ".join(text.split()), 110, break_on_hyphens=False, break_long_words=False) + "\n"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    assert all(len(line) == len(head) for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def span(values: Sequence[float] | Array, digits: int = 2) -> str:
    """From the 5th to the 95th percentile."""
    low, high = np.quantile(np.asarray(values), [0.05, 0.95])
    return f"{low:.{digits}f} to {high:.{digits}f}"


def percent(value: float, digits: int = 1) -> str:
    return f"{100.0 * value:.{digits}f} %"


# ---- Sections of the page ----------------------------------------------------------------------------


def opening() -> str:
    rows = [
        ["friction", f"{GREASES[0]} (grease 1), {GREASES[1]} (grease 2)", "published"],
        ["range", f"0 to {RANGE} rad", "published"],
        ["inner cam, lead angle at the start", "A 0.8203 rad, B 0.8552 rad", "published"],
        ["outer arc", "A smaller, B larger", "published, without its size"],
        ["largest torque, loading, grease 1", f"{model.TORQUE:.0f} N.m", "published as an order"],
        ["radii", f"inner {1e3 * RADII[0]:.0f} mm, outer {1e3 * RADII[1]:.0f} mm", "assumed"],
        ["shape of the arcs", "circles of the unwrapped groove, flattening", "assumed"],
        [
            "radii of the arcs",
            f"inner {1e3 * model.ARCS['A'][1]:.0f} mm; outer A {1e3 * model.ARCS['A'][2]:.0f},"
            f" B {1e3 * model.ARCS['B'][2]:.0f} mm",
            "assumed",
        ],
        ["outer cam, lead angle at the start", "that of the inner cam", "assumed"],
        ["spring", f"preload {percent(model.PRELOAD, 0)} of its largest force", "assumed"],
    ]
    springs = "; ".join(
        f"{name}: {model.pair(name).preload * model.pair(name).force:.0f} N +"
        f" {model.pair(name).rate / 1e3:.1f} N/mm over {1e3 * model.pair(name).stroke:.1f} mm"
        for name in PAIRS
    )
    return "\n".join(
        [
            "# The paper, reproduced and corrected\n",
            paragraph(
                """
                M. Monfrini, R. Pagani, A. Borboni, "Optimisation of a Dual Cylindrical Cam Mechanism for
                Energy Storage and Torque Efficiency", Reports in Mechanical Engineering, 2026, is where the
                mechanism comes from. This page takes its equations, figures and claims one by one:
                reproduced, corrected or not reproducible. Numbers in brackets are the paper's equations.
                What is judged is our excerpt of it, not the whole text; (1), (2), (5) and (18) are not in
                the excerpt and not judged. `./build.sh paper` writes this page (system_examples/paper.py);
                tests/test_paper.py checks it.
                """
            ),
            "## What is known and what is assumed\n",
            table(["", "value", "source"], rows),
            paragraph(
                f"""
                The spring then follows from the largest torque ({springs}). The torque does not depend on
                which of the two cams turns. Two contacts share the load; reactions are per contact.
                """
            ),
        ]
    )


def verdicts(work: Work) -> str:
    case, level = Case(), replace(Case(), radii=EQUAL)
    budget = model.budget()
    loading, releasing = correct(work, case)
    row_1, row_2 = case.balance(LOADING, axial=-1), case.balance(RELEASING, tangential=-1)
    x, y, best = work.best_on_grid(GREASES[0])
    lead_1, lead_2, unequal = model.unequal_optimum(UNEQUAL, RADII)
    rows = [
        ["(3), (6)", "torque", "corrected", f"{level.printed_3():.1f} N.m printed, not"
         f" {level.correct():.2f}, for equal radii; plus in the denominator"],
        ["(4)", "damper", "corrected", f"at -{SPEED} m/s the printed law drives with"
         f" {QUADRATIC * SPEED**2:.0f} W, the right one takes {QUADRATIC * SPEED**3:.0f} W"],
        ["(7), section 3", "balance", "corrected", f"{case.tangential():.2f} N.m printed, not {loading:.2f},"
         " for unequal radii: moments, not tangential forces"],
        ["section 3", "slope of the outer cam", "corrected", "the printed slope is the reciprocal"],
        ["(8), (9)", "rows of the balance", "corrected", f"{row_1:.2f} printed, not {loading:.2f} N.m;"
         f" {row_2:.2f} printed, not {releasing:.2f} N.m"],
        ["(10), (11)", "rows of the balance", "corrected", "a misprint of form: as printed no equation"],
        ["(12) to (17)", "torque, reactions", "reproduced", f"{loading:.4f} and {releasing:.4f} N.m from the"
         " FMU, the balance of forces and moments and the formula"],
        ["section 4", "pairing of angles and radii", "corrected", f"{case.swapped():.2f} printed, not"
         f" {loading:.2f} N.m"],
        ["section 5, Fig. 5", "efficiency map", "reproduced", f"largest {best:.6f} at {x:.4f}, {y:.4f} rad"],
        ["section 5, Fig. 5", "its range of angles", "corrected", "has a pole and efficiencies above 1 in a"
         " corner where the mechanism locks"],
        ["not in the paper", "optimum, unequal friction", "added", f"{unequal:.4f} at {lead_1:.4f},"
         f" {lead_2:.4f} rad"],
        ["Figs. 6 to 9", "torque, reactions", "not reproducible", "in numbers: radii, arcs, spring are not"
         " published; shapes below"],
        ["(19) to (21)", "uncertainty", "corrected", f"misalignment {percent(budget.as_cosine, 2)}, not"
         f" {percent(budget.as_sine)}; total {percent(model.UNCERTAINTY, 2)},"
         f" {model.UNCERTAINTY * model.TORQUE:.3f} N.m"],
        ["section 7", "RMSE against the bench", "not reproducible", "neither readings nor dimensions are"
         " published; bounds below"],
        ["section 8", "bounds of the RMSE", "contradicted", "by section 7: 1.51 > 1.5 and 0.735 > 0.7 N.m"],
        ["wear", "Archard's law", "corrected", f"hardness divides: the printed volume is H^2 ="
         f" {HARDNESS**2:.0e} Pa^2 times as large and no volume"],
    ]  # fmt: skip
    return "\n".join(["## Verdicts\n", table(["where", "what", "verdict", "our number"], rows)])


def correct(work: Work, case: Case) -> tuple[float, float]:
    """Torques of the FMU when loading and releasing."""
    parameters = model.helices(case.lead, (case.friction, case.friction), case.radii, case.force)
    return model.edges(work.inverse, parameters)


def efficiency_section(work: Work) -> str:
    rows = []
    for mu in GREASES:
        x, y, best = work.best_on_grid(mu)
        rows.append([f"{mu}", f"{best:.10f}", f"{x:.4f}, {y:.4f}", f"{model.best_efficiency(mu):.10f}"])
    starts = [
        model.efficiency_of_fmu(work.inverse, (model.ARCS[name][0],) * 2, (GREASES[0],) * 2, RADII)
        for name in PAIRS
    ]
    x, y, formula = model.unequal_optimum(UNEQUAL, RADII)
    searched = model.searched_optimum(UNEQUAL, RADII)
    fmu = model.efficiency_of_fmu(work.inverse, (x, y), UNEQUAL, RADII)
    naive = model.efficiency_of_fmu(work.inverse, (math.pi / 4,) * 2, UNEQUAL, RADII)
    share, _ = beyond_one(GREASES[0])
    return "\n".join(
        [
            "## Efficiency over the lead angles (Fig. 5)\n",
            "![Efficiency over the lead angles](paper_efficiency.png)\n",
            table(
                ["friction", "largest of the FMU on a grid", "at lead angles, rad", "((1 - mu)/(1 + mu))^2"],
                rows,
            ),
            paragraph(
                f"""
                Why pi/4, for every radius and load: the efficiency is the mean of (sin 2 lambda_i - sin 2
                phi)/(sin 2 lambda_i + sin 2 phi) with the weights cot(lambda_i - phi)/r_i, which are
                positive where the mechanism does not lock; each of the two is largest at pi/4, so the mean
                is. The optimum is flat: where pair A and B start (both cams alike) it is {starts[0]:.4f}
                and {starts[1]:.4f}.
                """
            ),
            paragraph(
                f"""
                The map over the whole square from 0 to pi/2 is not an efficiency everywhere. Where a
                contact locks (lambda_i < phi = atan mu) a weight is negative, the spring cannot drive back,
                and the denominator can be zero: for equal radii on the line lambda_1 + lambda_2 = 2 phi
                ({2 * math.atan(GREASES[0]):.4f} rad), a pole. Around it |eta| exceeds 1, on
                {percent(share, 2)} of the square, never where both lambda_i > phi. Where both are near pi/2
                loading jams and eta is negative. Only lambda_i > phi counts, and of that what does not jam.
                """
            ),
            paragraph(
                f"""
                Unequal friction is not in the paper. With mu_1 = {UNEQUAL[0]}, mu_2 = {UNEQUAL[1]} and
                radii of {1e3 * RADII[0]:.0f} and {1e3 * RADII[1]:.0f} mm, mu_e^2 = (mu_1/r_1 +
                mu_2/r_2)/(1/(mu_1 r_1) + 1/(mu_2 r_2)) gives tan lambda_i = mu_i/mu_e, i.e. {x:.4f} and
                {y:.4f} rad, and ((1 - mu_e)/(1 + mu_e))^2 = {formula:.6f}. A search that knows the
                efficiency alone finds {searched[0]:.4f}, {searched[1]:.4f} rad and {searched[2]:.6f}; the
                FMU has {fmu:.6f} there and {naive:.6f} at pi/4.
                """
            ),
        ]
    )


def beyond_one(friction: float) -> tuple[float, float]:
    """Share of the square with |eta| > 1, and the largest of the smaller lead angle there (equal radii)."""
    axis = (np.arange(1800) + 0.5) / 1800 * 0.5 * math.pi
    x, y = np.meshgrid(axis, axis)
    above = np.abs(model.efficiency((x, y), (friction, friction), EQUAL)) > 1.0
    return float(np.mean(above)), float(np.max(np.minimum(x, y)[above]))


def torque_section(work: Work) -> str:
    rows = []
    for name in PAIRS:
        for mu in GREASES:
            up, down = (work.curves[name, mu, way] for way in WAYS)
            work_in, work_out = (float(np.trapezoid(c.torque, work.angle)) for c in (up, down))
            rows.append(
                [
                    name,
                    f"{mu}",
                    f"{up.torque[0]:.2f} to {up.torque[-1]:.2f}",
                    f"{down.torque[0]:.2f} to {down.torque[-1]:.2f}",
                    *(f"{up.reactions[i][0]:.0f} to {up.reactions[i][-1]:.0f}" for i in (0, 1)),
                    *(f"{down.reactions[i][0]:.0f} to {down.reactions[i][-1]:.0f}" for i in (0, 1)),
                    percent(work_out / work_in),
                ]
            )
    spread = []
    for name in PAIRS:
        middle = work.angle.size // 2
        ups, downs = (np.array([other[i] for other in work.others[name]]) for i in (1, 2))
        spread.append(
            [
                name,
                span(ups[:, 0]),
                span(ups[:, middle]),
                span(downs[:, middle]),
                span((downs / ups)[:, -1], 3),
                span([rms(up - down) for up, down in zip(ups, downs, strict=True)]),
            ]
        )
    return "\n".join(
        [
            "## Torque and reactions over the range (Figs. 6 to 9, in shape)\n",
            "![Torque and reactions of pair A and B](paper_torque.png)\n",
            table(
                ["pair", "friction", "torque loading, N.m", "releasing, N.m", "reaction inner, loading, N",
                 "outer, loading", "inner, releasing", "outer, releasing", "work given back"],
                rows,
            ),
            paragraph(
                "From DualCamInverse.fmu at 1 rad/s without inertia; the formula of the statics agrees to"
                " better than 1e-9. The friction heat of a slow cycle of DualCamForward.fmu, "
                + ", ".join(f"{name} {work.heat[name, GREASES[0]]:.4f} J" for name in PAIRS)
                + " with grease 1, is the area between the curves."
            ),
            "![How much the shape depends on what is assumed](paper_dependence.png)\n",
            paragraph(
                f"""
                {OTHERS} other pairs of each kind with the published start angle of the inner cam: radii 10
                to 30 mm, inner arc 40 to 200 mm, outer arc 0.4 to 1 (A) or 1 to 2.5 (B) times that, either
                curvature, outer start angle 0.6 to 0.95 rad, preload 0 to 60 %, all lead angles within 15
                to 70 degrees, grease 1, 10 N.m at most. From the 5th to the 95th percentile:
                """
            ),
            table(
                ["pair", "loading at 0, N.m", "at half", "releasing at half",
                 "efficiency at the end", "RMS width of the stick band, N.m"],
                spread,
            ),
            paragraph(
                """
                So the published facts fix neither the level nor the curvature of the torque between its
                ends. The ratio of the two directions depends less on what is assumed.
                """
            ),
        ]
    )  # fmt: skip


def errata(work: Work) -> str:
    case = Case()
    loading, releasing = correct(work, case)
    row_1, row_2 = case.balance(LOADING, axial=-1), case.balance(RELEASING, tangential=-1)
    level = replace(case, radii=EQUAL)
    level_torque, _ = correct(work, level)
    alike = Case((0.7, 0.7), EQUAL)
    alike_torque, _ = correct(work, alike)
    damper_force, damped = damper_of_fmu(work, case)
    pulled, speed = pull_of_fmu(work, case)
    force = case.force + PULL
    wrong_flank = force * loading / case.force
    lead, wrong_lead = case.lead[1], math.pi / 2 - case.lead[1]
    wrong_slope = Case((case.lead[0], wrong_lead)).correct()
    smooth = [Case(friction=0.0, radii=radii) for radii in ((0.02, 0.016), EQUAL, (0.02, 0.025))]
    distance = work.heat["A", GREASES[0]] / GREASES[0]
    rows = [
        ["(3)", "1 - tan/tan", f"{level.printed_3():.2f} N.m for radii of 20 mm",
         f"{level_torque:.2f} N.m (16)"],
        ["(3)", "lead angles alike", "infinite", f"{alike_torque:.2f} N.m, both 0.7 rad"],
        ["(6)", "sign of friction by v, not v F", f"{wrong_flank:.2f} N.m, F = {force:.0f} N;"
         f" at 1 rad/s friction takes {wrong_flank - force * speed:.2f} W", f"{pulled:.2f} N.m;"
         f" {pulled - force * speed:.2f} W"],
        ["section 3", "tan lambda_2 = r phi'", f"{wrong_lead:.4f} rad for {lead} rad:"
         f" {wrong_slope:.2f} N.m", f"1/(r phi'): {loading:.2f} N.m"],
        ["(7)", "tangential forces", f"{case.tangential():.2f} N.m", f"moments: {loading:.2f} N.m"],
        ["", "the same without friction, work out over in", ", ".join(
            f"{c.correct() / c.tangential():.3f} (r2 = {1e3 * c.radii[1]:.0f} mm)" for c in smooth),
         "1 each"],
        ["(4), damper", "+ q abs(v) on the way down", f"{QUADRATIC * SPEED:+.0f} N at v = -{SPEED} m/s,"
         f" q = {QUADRATIC:.0f}", f"q v abs(v): {damper_force:+.0f} N, torque {damped:.3f} N.m,"
         f" undamped {releasing:.3f}"],
        ["(8) row 1", "+ A2 sin", f"{row_1:.2f} N.m", f"- A2 sin: {loading:.2f} N.m"],
        ["(9) row 2", "+ A2 cos", f"{row_2:.2f} N.m", f"- A2 cos: {releasing:.2f} N.m"],
        ["(10), (11)", "= inside the first rows", "no equation, no number", "- inside, = 0 at the end"],
        ["section 4", "lambda_1 with r2", f"{case.swapped():.2f} N.m", f"{loading:.2f} N.m"],
        ["wear", "V = K F s H", f"{WEAR * distance * HARDNESS:.1e} N^2/m",
         f"V = K F s/H: {1e9 * WEAR * distance / HARDNESS:.1e} mm^3 a cycle"],
    ]  # fmt: skip
    return "\n".join(
        [
            "## The errata in numbers\n",
            paragraph(
                f"""
                Two helices under {case.force:.0f} N, lead angles {case.lead[0]} and {case.lead[1]} rad,
                radii {1e3 * RADII[0]:.0f} and {1e3 * RADII[1]:.0f} mm, friction {case.friction}, unless the
                row says otherwise. Correct values are the FMU's. Rows (8) and (9) are taken as the
                follower's axial forces and moments, with that one sign changed; (3) as T = F r2 t2/(1 - r2
                t2/(r1 t1)), t_i = tan(lambda_i + phi).
                """
            ),
            table(["where", "printed", "gives", "correct"], rows),
            paragraph(
                f"""
                For equal radii (3) is off by the factor (t1 + t2)/|t1 - t2|: the less the cams differ the
                worse. The damper as printed pushes the way it moves on the way down, its q has another
                unit, and (4) uses both c and q. Wear: pair A, grease 1, a slow cycle of DualCamForward.fmu,
                whose friction heat over mu is F s = {distance:.1f} N.m; K = {WEAR:.0e} and H =
                {HARDNESS / 1e9:.0f} GPa are assumed.
                """
            ),
        ]
    )


def damper_of_fmu(work: Work, case: Case) -> tuple[float, float]:
    """Damper force and torque when releasing at SPEED."""
    s1, s2 = (r * math.tan(x) for r, x in zip(case.radii, case.lead, strict=True))
    parameters = model.helices(case.lead, (case.friction,) * 2, case.radii, case.force)
    omega = -SPEED * (s1 + s2) / (s1 * s2)
    work.inverse.start({**parameters, "inertia.shaft": 0.0, "damper.q_release": QUADRATIC, "omega": omega})
    return work.inverse.real("damper.force"), work.inverse.real("tau")


def pull_of_fmu(work: Work, case: Case) -> tuple[float, float]:
    """Torque when loading at 1 rad/s with the follower pulled up, and its speed: friction takes T - F v."""
    parameters = model.helices(case.lead, (case.friction,) * 2, case.radii, case.force)
    work.inverse.start({**parameters, "inertia.shaft": 0.0, "F_ext": PULL, "omega": 1.0})
    return work.inverse.real("tau"), work.inverse.real("v")


def uncertainty(work: Work) -> str:
    budget = model.budget()
    rows = [
        [
            name,
            WAYS[way],
            f"{error}",
            percent(error / model.TORQUE, 2),
            f"{error / (model.UNCERTAINTY * model.TORQUE):.0f}",
        ]
        for name in PAIRS
        for way, error in PUBLISHED[name].items()
    ]
    return "\n".join(
        [
            "## Uncertainty and the published RMSE ((19) to (21), sections 7 and 8)\n",
            paragraph(
                f"""
                The force at the {1e3 * model.LEVER:.0f} mm lever may be up to {model.TILT} rad (3 degrees)
                off the perpendicular. Torque goes with the sine of an angle near pi/2, so that costs 1 -
                cos = {percent(budget.as_cosine, 2)}, not sin = {percent(budget.as_sine, 2)}. With the total
                of {percent(model.UNCERTAINTY, 2)}, all else together is {percent(budget.rest, 2)} (root of
                squares); the sine would make it {percent(budget.printed_total, 2)},
                {budget.printed_total * model.TORQUE:.2f} N.m of {model.TORQUE:.0f} N.m, instead of
                {model.UNCERTAINTY * model.TORQUE:.3f} N.m. As it only ever loses torque it is a bias: if
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
                {sum(e / model.TORQUE > 0.05 for w in PUBLISHED.values() for e in w.values())} of 4 are
                above 5 %. No RMSE is explained by the uncertainty of the measurement.
                """
            ),
        ]
    )


def band_at_readings(name: str, friction: float, count: int = READINGS) -> Array:
    return Statics(model.pair(name), np.linspace(0.0, RANGE, count)).band(friction)


def measurements(work: Work) -> str:
    rows = []
    for draw in model.DRAWS:
        cells = [draw]
        for name in PAIRS:
            for mu in GREASES:
                found, _ = model.readings(band_at_readings(name, mu), draw)
                cells.append(f"{found.mean:.2f} ({found.low:.2f} to {found.high:.2f})")
        rows.append(cells)
    uniform = next(iter(model.DRAWS))
    shares = [
        [
            name,
            WAYS[way],
            f"{error}",
            *(f"{share_needed(error, band_at_readings(name, mu)):.2f}" for mu in GREASES),
            span([math.sqrt(3.0) * error / rms(up - down) for _, up, down in work.others[name]]),
        ]
        for name in PAIRS
        for way, error in PUBLISHED[name].items()
    ]
    ratios = {
        count: model.readings(band_at_readings("B", GREASES[0], count), uniform)[1]
        for count in (READINGS, FEW)
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


def share_needed(error: float, band: Array) -> float:
    """Part of the band, next to the line, over which evenly spread readings have that RMSE."""
    return math.sqrt(3.0) * error / rms(band)


def needed_friction(work: Work) -> tuple[list[list[str]], dict[tuple[str, float, int], float]]:
    """Rows of the constant frictions that make the published RMSE; the larger one over the grease's."""
    rows, factors = [], {}
    for name, mu in product(PAIRS, GREASES):
        statics = Statics(model.pair(name), work.angle)
        for way, error in PUBLISHED[name].items():
            more, less = (model.friction_for(statics, mu, way, error, sign) for sign in (1, -1))
            factors[name, mu, way] = more / mu
            share = error / rms(work.curves[name, mu, way].torque)
            cells = (f"{friction:.3f} ({friction / mu:.2f})" for friction in (more, less))
            rows.append([name, f"{mu}", WAYS[way], f"{error}", *cells, percent(share)])
    return rows, factors


def load_laws(work: Work) -> list[list[str]]:
    """Rows of the RMSE that friction which falls with the load makes, and that the other grease makes."""
    rows = []
    for name, way in product(PAIRS, WAYS):
        statics = Statics(model.pair(name), work.angle)
        cells = [
            ", ".join("locks" if math.isnan(error) else f"{error:.2f}" for error in errors)
            for errors in (model.law_error(statics, GREASES[0], n, way) for n in EXPONENTS)
        ]
        other = rms(statics.torque(way, GREASES[1]) - statics.torque(way, GREASES[0]))
        rows.append([name, WAYS[way], f"{PUBLISHED[name][way]}", *cells, f"{other:.2f}"])
    return rows


def friction_laws(work: Work) -> str:
    needed, factors = needed_friction(work)
    pair_b = [factor for (name, _, _), factor in factors.items() if name == "B"]
    others = [Statics(cams, work.angle) for cams, _, _ in work.others["B"]]
    level = {
        way: [model.friction_for(s, GREASES[0], way, PUBLISHED["B"][way], 1) for s in others] for way in WAYS
    }
    ratio = max(
        float(sliding.max() / sliding.min())
        for name in PAIRS
        for sliding in work.curves[name, GREASES[0], LOADING].sliding
    )
    change = model.largest_change(ratio)
    first, second = (tuple(factors[name, mu, LOADING] for mu in GREASES) for name in ("B", "A"))
    reaction = np.concatenate(Statics(model.pair("B"), work.angle).reactions(LOADING))
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
                Load. Reactions of pair B change by {reaction.max() / reaction.min():.1f} to 1. With mu ~
                R^-n: n = 1/3 is an elastic point contact whose friction goes with its area, n = 1/2 a line
                contact, n = 1 friction that does not depend on the load at all. RMSE against constant
                friction 0.14, N.m, when both agree at the least, the mean and the largest reaction:
                """
            ),
            table(
                ["pair", "direction", "published", "n = 1/3", "n = 1/2", "n = 1", "friction 0.19 for 0.14"],
                load_laws(work),
            ),
            paragraph(law_conclusion(work)),
        ]
    )


def law_conclusion(work: Work) -> str:
    statics = Statics(model.pair("B"), work.angle)
    most = {
        (way, n): max(model.law_error(statics, GREASES[0], n, way)) for way, n in product(WAYS, EXPONENTS)
    }
    loose = {
        n: [
            max(model.law_error(Statics(cams, work.angle), GREASES[0], n, LOADING))
            for cams, _, _ in work.others["B"]
        ]
        for n in EXPONENTS[1:]
    }
    loading, releasing = (PUBLISHED["B"][way] for way in WAYS)
    return f"""
    The {loading} N.m of pair B when loading are out of reach of all of these: at most
    {most[LOADING, 1 / 3]:.2f}, {most[LOADING, 1 / 2]:.2f} and {most[LOADING, 1.0]:.2f} N.m. So are its
    {releasing} N.m when releasing of n = 1/3 ({most[RELEASING, 1 / 3]:.2f}) and n = 1/2
    ({most[RELEASING, 1 / 2]:.2f}), not of n = 1, which can even lock. In the other pairs of kind B n = 1/2
    makes {span(loose[1 / 2])} N.m when loading (5th to 95th percentile), n = 1 {span(loose[1.0])} N.m, so
    only friction that hardly grows with the load could, in some pairs. Taking one grease for the other is not
    enough for B's loading either. What is enough is a friction that is higher all along, by the factors
    above, or a spring, radius or lead angle that is off, or stick; only the bench's data could tell which.
    """


# ---- Pictures ----------------------------------------------------------------------------------------

COLOURS = {LOADING: "tab:blue", RELEASING: "tab:orange"}
LINES = {GREASES[0]: "-", GREASES[1]: "--"}


def draw_map(figure: Figure, axes: Axes) -> None:
    degrees = np.linspace(0.25, 89.75, MAP)
    x, y = np.meshgrid(np.radians(degrees), np.radians(degrees))
    eta = model.efficiency((x, y), (GREASES[0], GREASES[0]), EQUAL)
    lock = math.degrees(math.atan(GREASES[0]))
    meant = np.where((np.minimum(x, y) > math.atan(GREASES[0])) & (eta > 0.0), eta, np.nan)
    shown = axes.contourf(degrees, degrees, meant, levels=np.linspace(0.0, 0.6, 13), cmap="viridis")
    axes.contourf(degrees, degrees, np.abs(eta) > 1.0, levels=[0.5, 1.5], colors=["tab:red"])
    figure.colorbar(shown, ax=axes, label="efficiency")
    axes.plot([0.0, 2.0 * lock], [2.0 * lock, 0.0], "k:", lw=1.5, label="pole")
    axes.plot([], [], color="tab:red", lw=6, label="|eta| > 1")
    axes.axvline(lock, color="0.4", lw=0.8)
    axes.axhline(lock, color="0.4", lw=0.8)
    axes.plot(
        45.0, 45.0, "w*", ms=14, mec="k", ls="none", label=f"{model.best_efficiency(GREASES[0]):.4f} at 45"
    )
    axes.plot([47.0, 49.0], [47.0, 49.0], "wo", ms=4, mec="k", ls="none", label="starts of pair A, B")
    axes.set(title=f"Friction {GREASES[0]}, equal radii; white: locks or jams", aspect="equal")
    axes.set(
        xlabel="lead angle of cam 1 [deg]", ylabel="lead angle of cam 2 [deg]", xlim=(0, 90), ylim=(0, 90)
    )
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=4, fontsize=8)


def draw_cut(axes: Axes, work: Work) -> None:
    lead = np.radians(np.linspace(0.5, 89.5, 400))
    points = np.radians(np.arange(15.0, 76.0, 5.0))
    for mu, colour in zip(GREASES, ("tab:blue", "tab:green"), strict=True):
        line = model.efficiency((lead, lead), (mu, mu), EQUAL)
        axes.plot(np.degrees(lead), line, color=colour, label=f"lead angles alike, friction {mu}")
        fmu = [model.efficiency_of_fmu(work.inverse, (x, x), (mu, mu), EQUAL) for x in points]
        axes.plot(np.degrees(points), fmu, "o", color=colour, ms=4)
    other = np.full_like(lead, math.radians(5.0))
    line = model.efficiency((lead, other), (GREASES[0],) * 2, EQUAL)
    pole = 2.0 * math.degrees(math.atan(GREASES[0])) - 5.0
    line[np.argmin(np.abs(np.degrees(lead) - pole))] = np.nan
    axes.plot(
        np.degrees(lead),
        line,
        color="tab:red",
        lw=1,
        label="other lead angle 5 deg, friction 0.14: no efficiency",
    )
    axes.plot([], [], "ko", ms=4, label="DualCamInverse.fmu")
    axes.axhline(0.0, color="0.6", lw=0.8)
    axes.set(title="Cuts through the map", xlabel="lead angle [deg]", ylabel="torque releasing / loading")
    axes.set(xlim=(0, 90), ylim=(-1.5, 2.0))
    axes.legend(loc="upper right", fontsize=8)


def draw_efficiency(work: Work) -> Figure:
    figure = Figure(figsize=(12.5, 5.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_map(figure, left)
    draw_cut(right, work)
    return figure


def draw_torque(work: Work) -> Figure:
    figure = Figure(figsize=(12.5, 8.0), layout="constrained")
    for column, name in zip(figure.subplots(2, 2, sharex=True, sharey="row").T, PAIRS, strict=True):
        for (_, mu, way), drawn in ((k, c) for k, c in work.curves.items() if k[0] == name):
            label = f"{WAYS[way]}, friction {mu}"
            column[0].plot(drawn.angle, drawn.torque, LINES[mu], color=COLOURS[way], label=label)
            for reaction, width in zip(drawn.reactions, (1.0, 2.0), strict=True):
                column[1].plot(drawn.angle, reaction, LINES[mu], color=COLOURS[way], lw=width)
        up, down = (work.curves[name, GREASES[0], way].torque for way in WAYS)
        column[0].fill_between(work.angle, down, up, color="0.9", label=f"stick band, friction {GREASES[0]}")
        column[0].set(title=f"Pair {name}: torque", ylabel="torque [N.m]", ylim=(0.0, 13.5))
        for width, cam in ((1.0, "inner"), (2.0, "outer")):
            column[1].plot([], [], "k", lw=width, label=f"{cam} cam; colours and dashes as above")
        column[1].legend(loc="upper left", fontsize=8)
        column[1].set(title=f"Pair {name}: normal reaction at each contact")
        column[1].set(xlabel="angle of the turning cam [rad]", ylabel="reaction [N]", ylim=(0.0, 420.0))
        column[1].set(xlim=(0.0, RANGE))
        column[0].legend(loc="upper left", fontsize=8)
    return figure


def draw_dependence(work: Work) -> Figure:
    figure = Figure(figsize=(12.5, 4.6), layout="constrained")
    for axes, name in zip(figure.subplots(1, 2, sharey=True), PAIRS, strict=True):
        for way, index in ((LOADING, 1), (RELEASING, 2)):
            for other in work.others[name]:
                axes.plot(work.angle, other[index], color=COLOURS[way], lw=0.6, alpha=0.35)
            mine = work.curves[name, GREASES[0], way].torque
            axes.plot(work.angle, mine, color=COLOURS[way], lw=3, label=f"{WAYS[way]}, as assumed here")
        axes.plot([], [], color="0.5", lw=0.6, label=f"{OTHERS} other pairs that the facts allow")
        axes.set(title=f"Pair {name}, friction {GREASES[0]}", xlabel="angle of the turning cam [rad]")
        axes.set(ylabel="torque [N.m]", xlim=(0.0, RANGE), ylim=(0.0, 13.0))
        axes.legend(loc="upper left", fontsize=8)
    return figure


def draw_readings(axes: Axes, work: Work) -> None:
    name, mu = "B", GREASES[0]
    up, down = (work.curves[name, mu, way].torque for way in WAYS)
    axes.fill_between(work.angle, down, up, color="0.9", label="stick band")
    axes.plot(work.angle, up, color=COLOURS[LOADING], label="kinetostatic line, loading")
    axes.plot(work.angle, down, color=COLOURS[RELEASING], label="kinetostatic line, releasing")
    places = np.linspace(0.0, RANGE, READINGS)
    statics = Statics(model.pair(name), places)
    random = np.random.default_rng(5)
    for way, colour in COLOURS.items():
        depth = random.uniform(0.0, 1.0, READINGS)
        values = statics.torque(way, mu) - way * depth * statics.band(mu)
        error = rms(depth * statics.band(mu))
        label = f"readings anywhere, {WAYS[way]}: RMSE {error:.2f} N.m"
        axes.plot(places, values, "o", color=colour, mec="k", label=label)
    axes.set(title=f"Pair {name}, friction {mu}: one series of readings by hand", ylabel="torque [N.m]")
    axes.set(xlabel="angle of the turning cam [rad]", xlim=(-0.03, RANGE + 0.03), ylim=(0.0, 14.5))
    axes.legend(loc="upper left", fontsize=8)


def draw_shares(axes: Axes) -> None:
    shares = np.linspace(0.0, 1.0, 21)
    for name, colour in zip(PAIRS, ("tab:purple", "tab:green"), strict=True):
        for mu in GREASES:
            whole = rms(band_at_readings(name, mu)) / math.sqrt(3.0)
            axes.plot(
                100 * shares, shares * whole, LINES[mu], color=colour, label=f"pair {name}, friction {mu}"
            )
        for way, mark in ((LOADING, "^"), (RELEASING, "v")):
            error = PUBLISHED[name][way]
            axes.axhline(error, color=colour, lw=0.7, ls=":")
            parts = [100 * share_needed(error, band_at_readings(name, mu)) for mu in GREASES]
            label = f"published, {name}, {WAYS[way]}: {error}"
            axes.plot(parts, [error, error], mark, color=colour, mec="k", ls="none", label=label)
    axes.set(title="RMSE of readings spread over the part of the band next to the line")
    axes.set(xlabel="part of the band [%]", ylabel="RMSE [N.m]", xlim=(0, 100), ylim=(0, 3.2))
    axes.legend(loc="upper left", fontsize=8)


def draw_measurements(work: Work) -> Figure:
    figure = Figure(figsize=(12.5, 5.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_readings(left, work)
    draw_shares(right)
    return figure


PICTURES = {
    "efficiency": draw_efficiency,
    "torque": draw_torque,
    "dependence": draw_dependence,
    "measurements": draw_measurements,
}

# ---- The page ----------------------------------------------------------------------------------------

SECTIONS = (verdicts, efficiency_section, torque_section, errata, uncertainty, measurements, friction_laws)


def page(work: Work) -> str:
    """The text of docs/paper.md."""
    return "\n".join([opening(), *(section(work) for section in SECTIONS)])


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=ROOT / "docs", help="folder of paper.md and pictures")
    options = parser.parse_args(arguments)
    build = ROOT / "build"
    options.output.mkdir(parents=True, exist_ok=True)
    with Fmu(build / "DualCamInverse.fmu") as inverse, Fmu(build / "DualCamForward.fmu") as forward:
        work = Work(inverse, forward)
        (options.output / "paper.md").write_text(page(work), encoding="utf-8")
        for name, draw in PICTURES.items():
            draw(work).savefig(options.output / f"paper_{name}.png", dpi=100)
    print(f"Written: {options.output / 'paper.md'} and {len(PICTURES)} pictures beside it")


if __name__ == "__main__":
    main()
