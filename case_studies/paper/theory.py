"""Sections of the page: assumptions, verdicts, efficiency, torque and reactions, errata."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from case_studies.paper.cams import pair
from case_studies.paper.efficiency import beyond_one, searched_optimum
from case_studies.paper.fits import best as best_law
from case_studies.paper.fmus import FmuResults, damper_of_fmu, efficiency_of_fmu, pull_of_fmu, torques_of_fmu
from case_studies.paper.printed import Case
from case_studies.paper.published import (
    ARCS,
    DIRECTIONS,
    EQUAL,
    GREASES,
    HARDNESS,
    LOADING,
    OTHERS,
    PAIRS,
    PRELOAD,
    PULL,
    QUADRATIC,
    RADII,
    RANGE,
    RELEASING,
    SPEED,
    TORQUE,
    UNCERTAINTY,
    UNEQUAL,
    WEAR,
)
from case_studies.paper.readings import rms, uncertainty_budget
from case_studies.paper.text import paragraph, percent, span, table
from dualcam.design import optimum


def opening() -> str:
    """Title, and the published and assumed values."""
    rows = [
        ["friction", f"{GREASES[0]} (grease 1), {GREASES[1]} (grease 2)", "published"],
        ["range", f"0 to {RANGE} rad", "published"],
        ["inner cam, lead angle at the start", "A 0.8203 rad, B 0.8552 rad", "published"],
        ["outer arc", "A smaller, B larger", "published, without its size"],
        ["largest torque, loading, grease 1", f"{TORQUE:.0f} N.m", "published as an order"],
        ["radii", f"inner {1e3 * RADII[0]:.0f} mm, outer {1e3 * RADII[1]:.0f} mm", "assumed"],
        ["shape of the arcs", "circles of the unwrapped groove, flattening", "assumed"],
        [
            "radii of the arcs",
            f"inner {1e3 * ARCS['A'][1]:.0f} mm; outer A {1e3 * ARCS['A'][2]:.0f},"
            f" B {1e3 * ARCS['B'][2]:.0f} mm",
            "assumed",
        ],
        ["outer cam, lead angle at the start", "that of the inner cam", "assumed"],
        ["spring", f"preload {percent(PRELOAD, 0)} of its largest force", "assumed"],
    ]
    springs = "; ".join(
        f"{name}: {pair(name).spring.preload:.0f} N +"
        f" {pair(name).spring.stiffness / 1e3:.1f} N/mm over {1e3 * pair(name).stroke:.1f} mm"
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
                the excerpt and not judged. `./build.sh run paper` writes this page (case_studies/paper);
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


def verdicts(fmus: FmuResults) -> str:
    """The table of verdicts."""
    case, level = Case(), replace(Case(), radii=EQUAL)
    budget = uncertainty_budget()
    loading, releasing = torques_of_fmu(fmus, case)
    row_1, row_2 = case.balance(LOADING, axial=-1), case.balance(RELEASING, tangential=-1)
    x, y, best = fmus.best_on_grid(GREASES[0])
    unequal = optimum(UNEQUAL, RADII)
    fits = {names: best_law(names, GREASES[0], -1 / 3, 1 / 3) for names in ("A", "B", "AB")}
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
        ["not in the paper", "optimum, unequal friction", "added", f"{unequal.efficiency:.4f} at"
         f" {unequal.lead_angle[0]:.4f}, {unequal.lead_angle[1]:.4f} rad"],
        ["Figs. 6 to 9", "torque, reactions", "not reproducible", "in numbers: radii, arcs, spring are not"
         " published; shapes below"],
        ["(19) to (21)", "uncertainty", "corrected", f"misalignment {percent(budget.as_cosine, 2)}, not"
         f" {percent(budget.as_sine)}; total {percent(UNCERTAINTY, 2)},"
         f" {UNCERTAINTY * TORQUE:.3f} N.m"],
        ["section 7", "RMSE against the bench", "not reproducible", "neither readings nor dimensions are"
         " published; bounds below"],
        ["section 8", "bounds of the RMSE", "contradicted", "by section 7: 1.51 > 1.5 and 0.735 > 0.7 N.m"],
        ["sections 4, 8", "friction that varies, as the cause of the deviations", "not confirmed",
         f"pair B: friction {fits['B'].factor:.2f} times grease 1; pair A off by a factor of"
         f" {fits['A'].misfit:.2f}, one law for both pairs by {fits['AB'].misfit:.2f}"],
        ["wear", "Archard's law", "corrected", f"hardness divides: the printed volume is H^2 ="
         f" {HARDNESS**2:.0e} Pa^2 times as large and no volume"],
    ]  # fmt: skip
    return "\n".join(["## Verdicts\n", table(["where", "what", "verdict", "our number"], rows)])


def efficiency_section(fmus: FmuResults) -> str:
    """Section on the efficiency map and its optimum."""
    rows = []
    for mu in GREASES:
        x, y, best = fmus.best_on_grid(mu)
        rows.append([f"{mu}", f"{best:.10f}", f"{x:.4f}, {y:.4f}", f"{optimum((mu, mu)).efficiency:.10f}"])
    starts = [
        efficiency_of_fmu(fmus.inverse, (ARCS[name][0],) * 2, (GREASES[0],) * 2, RADII) for name in PAIRS
    ]
    unequal = optimum(UNEQUAL, RADII)
    (x, y), formula = unequal.lead_angle, unequal.efficiency
    searched = searched_optimum(UNEQUAL, RADII)
    fmu = efficiency_of_fmu(fmus.inverse, (x, y), UNEQUAL, RADII)
    naive = efficiency_of_fmu(fmus.inverse, (math.pi / 4,) * 2, UNEQUAL, RADII)
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


def torque_section(fmus: FmuResults) -> str:
    """Section on torque and reactions over the range."""
    rows = []
    for name in PAIRS:
        for mu in GREASES:
            up, down = (fmus.curves[name, mu, direction] for direction in DIRECTIONS)
            work_in, work_out = (float(np.trapezoid(c.torque, fmus.angle)) for c in (up, down))
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
        middle = fmus.angle.size // 2
        ups, downs = (np.array([other[i] for other in fmus.others[name]]) for i in (1, 2))
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
                + ", ".join(f"{name} {fmus.heat[name, GREASES[0]]:.4f} J" for name in PAIRS)
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


def errata(fmus: FmuResults) -> str:
    """Section on the errata in numbers."""
    case = Case()
    loading, releasing = torques_of_fmu(fmus, case)
    row_1, row_2 = case.balance(LOADING, axial=-1), case.balance(RELEASING, tangential=-1)
    level = replace(case, radii=EQUAL)
    level_torque, _ = torques_of_fmu(fmus, level)
    alike = Case((0.7, 0.7), EQUAL)
    alike_torque, _ = torques_of_fmu(fmus, alike)
    damper_force, damped = damper_of_fmu(fmus, case)
    pulled, speed = pull_of_fmu(fmus, case)
    force = case.force + PULL
    wrong_flank = force * loading / case.force
    lead, wrong_lead = case.lead[1], math.pi / 2 - case.lead[1]
    wrong_slope = Case((case.lead[0], wrong_lead)).correct()
    smooth = [Case(friction=0.0, radii=radii) for radii in ((0.02, 0.016), EQUAL, (0.02, 0.025))]
    distance = fmus.heat["A", GREASES[0]] / GREASES[0]
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
