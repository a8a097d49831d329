"""Pictures of the page."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from case_studies.paper.cams import Statics, pair
from case_studies.paper.efficiency import efficiency
from case_studies.paper.fits import rmse_of_factors
from case_studies.paper.fmus import FmuResults, efficiency_of_fmu
from case_studies.paper.friction import ANGLE, load_law, speed_law, turn_rate
from case_studies.paper.published import (
    DIRECTIONS,
    EQUAL,
    GREASES,
    LOAD,
    LOADING,
    MAP,
    OTHERS,
    PAIRS,
    PEAK,
    PUBLISHED,
    RANGE,
    READINGS,
    RELEASING,
    SLIDING,
)
from case_studies.paper.readings import band_at_readings, rms, share_needed
from case_studies.paper.varying import FrictionLaw, turning
from dualcam.design import optimum

COLOURS = {LOADING: "tab:blue", RELEASING: "tab:orange"}
LINES = {GREASES[0]: "-", GREASES[1]: "--"}


def draw_map(figure: Figure, axes: Axes) -> None:
    """Efficiency over both lead angles."""
    degrees = np.linspace(0.25, 89.75, MAP)
    x, y = np.meshgrid(np.radians(degrees), np.radians(degrees))
    eta = efficiency((x, y), (GREASES[0], GREASES[0]), EQUAL)
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
        45.0, 45.0, "w*", ms=14, mec="k", ls="none", label=f"{optimum(GREASES[:1] * 2).efficiency:.4f} at 45"
    )
    axes.plot([47.0, 49.0], [47.0, 49.0], "wo", ms=4, mec="k", ls="none", label="starts of pair A, B")
    axes.set(title=f"Friction {GREASES[0]}, equal radii; white: locks or jams", aspect="equal")
    axes.set(
        xlabel="lead angle of cam 1 [deg]", ylabel="lead angle of cam 2 [deg]", xlim=(0, 90), ylim=(0, 90)
    )
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=4, fontsize=8)


def draw_cut(axes: Axes, fmus: FmuResults) -> None:
    """Cuts through the map, by formula and by the FMU."""
    lead = np.radians(np.linspace(0.5, 89.5, 400))
    points = np.radians(np.arange(15.0, 76.0, 5.0))
    for mu, colour in zip(GREASES, ("tab:blue", "tab:green"), strict=True):
        line = efficiency((lead, lead), (mu, mu), EQUAL)
        axes.plot(np.degrees(lead), line, color=colour, label=f"lead angles alike, friction {mu}")
        fmu = [efficiency_of_fmu(fmus.inverse, (x, x), (mu, mu), EQUAL) for x in points]
        axes.plot(np.degrees(points), fmu, "o", color=colour, ms=4)
    other = np.full_like(lead, math.radians(5.0))
    line = efficiency((lead, other), (GREASES[0],) * 2, EQUAL)
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


def draw_efficiency(fmus: FmuResults) -> Figure:
    """Map and cuts."""
    figure = Figure(figsize=(12.5, 5.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_map(figure, left)
    draw_cut(right, fmus)
    return figure


def draw_torque(fmus: FmuResults) -> Figure:
    """Torque and reactions of both pairs."""
    figure = Figure(figsize=(12.5, 8.0), layout="constrained")
    for column, name in zip(figure.subplots(2, 2, sharex=True, sharey="row").T, PAIRS, strict=True):
        for (_, mu, direction), drawn in ((k, c) for k, c in fmus.curves.items() if k[0] == name):
            label = f"{DIRECTIONS[direction]}, friction {mu}"
            column[0].plot(drawn.angle, drawn.torque, LINES[mu], color=COLOURS[direction], label=label)
            for reaction, width in zip(drawn.reactions, (1.0, 2.0), strict=True):
                column[1].plot(drawn.angle, reaction, LINES[mu], color=COLOURS[direction], lw=width)
        up, down = (fmus.curves[name, GREASES[0], direction].torque for direction in DIRECTIONS)
        column[0].fill_between(fmus.angle, down, up, color="0.9", label=f"stick band, friction {GREASES[0]}")
        column[0].set(title=f"Pair {name}: torque", ylabel="torque [N.m]", ylim=(0.0, 13.5))
        for width, cam in ((1.0, "inner"), (2.0, "outer")):
            column[1].plot([], [], "k", lw=width, label=f"{cam} cam; colours and dashes as above")
        column[1].legend(loc="upper left", fontsize=8)
        column[1].set(title=f"Pair {name}: normal reaction at each contact")
        column[1].set(xlabel="angle of the turning cam [rad]", ylabel="reaction [N]", ylim=(0.0, 420.0))
        column[1].set(xlim=(0.0, RANGE))
        column[0].legend(loc="upper left", fontsize=8)
    return figure


def draw_dependence(fmus: FmuResults) -> Figure:
    """Torque of other pairs that the published facts allow."""
    figure = Figure(figsize=(12.5, 4.6), layout="constrained")
    for axes, name in zip(figure.subplots(1, 2, sharey=True), PAIRS, strict=True):
        for direction, index in ((LOADING, 1), (RELEASING, 2)):
            for other in fmus.others[name]:
                axes.plot(fmus.angle, other[index], color=COLOURS[direction], lw=0.6, alpha=0.35)
            mine = fmus.curves[name, GREASES[0], direction].torque
            axes.plot(
                fmus.angle,
                mine,
                color=COLOURS[direction],
                lw=3,
                label=f"{DIRECTIONS[direction]}, as assumed here",
            )
        axes.plot([], [], color="0.5", lw=0.6, label=f"{OTHERS} other pairs that the facts allow")
        axes.set(title=f"Pair {name}, friction {GREASES[0]}", xlabel="angle of the turning cam [rad]")
        axes.set(ylabel="torque [N.m]", xlim=(0.0, RANGE), ylim=(0.0, 13.0))
        axes.legend(loc="upper left", fontsize=8)
    return figure


def draw_readings(axes: Axes, fmus: FmuResults) -> None:
    """One series of readings inside the stick band."""
    name, mu = "B", GREASES[0]
    up, down = (fmus.curves[name, mu, direction].torque for direction in DIRECTIONS)
    axes.fill_between(fmus.angle, down, up, color="0.9", label="stick band")
    axes.plot(fmus.angle, up, color=COLOURS[LOADING], label="kinetostatic line, loading")
    axes.plot(fmus.angle, down, color=COLOURS[RELEASING], label="kinetostatic line, releasing")
    angles = np.linspace(0.0, RANGE, READINGS)
    statics = Statics(pair(name), angles)
    random = np.random.default_rng(5)
    for direction, colour in COLOURS.items():
        depth = random.uniform(0.0, 1.0, READINGS)
        values = statics.torque(direction, mu) - direction * depth * statics.band(mu)
        error = rms(depth * statics.band(mu))
        label = f"readings anywhere, {DIRECTIONS[direction]}: RMSE {error:.2f} N.m"
        axes.plot(angles, values, "o", color=colour, mec="k", label=label)
    axes.set(title=f"Pair {name}, friction {mu}: one series of readings by hand", ylabel="torque [N.m]")
    axes.set(xlabel="angle of the turning cam [rad]", xlim=(-0.03, RANGE + 0.03), ylim=(0.0, 14.5))
    axes.legend(loc="upper left", fontsize=8)


def draw_shares(axes: Axes) -> None:
    """RMSE over the part of the band in which readings lie."""
    shares = np.linspace(0.0, 1.0, 21)
    for name, colour in zip(PAIRS, ("tab:purple", "tab:green"), strict=True):
        for mu in GREASES:
            whole = rms(band_at_readings(name, mu)) / math.sqrt(3.0)
            axes.plot(
                100 * shares, shares * whole, LINES[mu], color=colour, label=f"pair {name}, friction {mu}"
            )
        for direction, mark in ((LOADING, "^"), (RELEASING, "v")):
            error = PUBLISHED[name][direction]
            axes.axhline(error, color=colour, lw=0.7, ls=":")
            parts = [100 * share_needed(error, band_at_readings(name, mu)) for mu in GREASES]
            label = f"published, {name}, {DIRECTIONS[direction]}: {error}"
            axes.plot(parts, [error, error], mark, color=colour, mec="k", ls="none", label=label)
    axes.set(title="RMSE of readings spread over the part of the band next to the line")
    axes.set(xlabel="part of the band [%]", ylabel="RMSE [N.m]", xlim=(0, 100), ylim=(0, 3.2))
    axes.legend(loc="upper left", fontsize=8)


def draw_measurements(fmus: FmuResults) -> Figure:
    """Readings and parts of the band."""
    figure = Figure(figsize=(12.5, 5.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_readings(left, fmus)
    draw_shares(right)
    return figure


def draw_coefficients(axes: Axes) -> None:
    """The coefficient over the sliding speed."""
    speed = np.linspace(0.0, SLIDING[-1], 400)
    for mu, colour in zip(GREASES, ("tab:blue", "tab:green"), strict=True):
        law = speed_law(mu)
        axes.plot(1e3 * speed, law.at(speed, np.array(LOAD)), color=colour, label=f"grease with {mu}")
        low, high = (replace(law, peak=peak).at(speed, np.array(LOAD)) for peak in (1.1, 1.6))
        axes.fill_between(1e3 * speed, low, high, color=colour, alpha=0.2, lw=0)
        axes.axhline(mu, color=colour, lw=0.7, ls=":")
    axes.set(title=f"Static over kinetic coefficient {PEAK} (areas: 1.1 to 1.6)", xlim=(0, 1e3 * SLIDING[-1]))
    axes.set(xlabel="sliding speed [mm/s]", ylabel="coefficient of friction", ylim=(0, 0.32))
    axes.legend(fontsize=8)


def draw_varied(axes: Axes, laws: dict[str, tuple[FrictionLaw, float]], title: str) -> None:
    """Torque of pair B with grease 1 under laws at mean sliding speeds [m/s]."""
    name, mu = "B", GREASES[0]
    statics = Statics(pair(name), ANGLE)
    for direction in DIRECTIONS:
        line, error = statics.torque(direction, mu), PUBLISHED[name][direction]
        axes.fill_between(ANGLE, line - error, line + error, color="0.9", lw=0,
                          label="constant +- published RMSE" if direction == LOADING else None)  # fmt: skip
        axes.plot(ANGLE, line, "k:", lw=1, label=f"constant {mu}" if direction == LOADING else None)
        for (words, (law, speed)), style in zip(laws.items(), ("-", "--", "-."), strict=False):
            drawn = turning(statics, law, direction, turn_rate(statics, speed))
            label = words if direction == LOADING else None
            axes.plot(ANGLE, drawn.torque, style, color=COLOURS[direction], label=label)
    axes.set(title=title, xlabel="angle of the turning cam [rad]", ylabel="torque [N.m]")
    axes.set(xlim=(0.0, RANGE), ylim=(0.0, 13.5))
    axes.legend(loc="upper left", fontsize=8)


def draw_factors(axes: Axes) -> None:
    """RMSE over the published one, over the factor on the friction; areas: |nu| up to 1/3."""
    factors = np.linspace(0.3, 2.0, 137)
    colours = ("tab:purple", "tab:pink", "tab:green", "tab:olive")
    for (name, direction), colour in zip(product(PAIRS, DIRECTIONS), colours, strict=True):
        made = rmse_of_factors(name, GREASES[0], direction, factors)
        axes.fill_between(factors, made.min(axis=1), made.max(axis=1), color=colour, alpha=0.25, lw=0)
        axes.plot(factors, made[:, 1], color=colour, label=f"pair {name}, {DIRECTIONS[direction]}")
    axes.axhline(1.0, color="k", lw=0.8)
    axes.axvline(1.0, color="0.6", lw=0.8)
    axes.set(title="RMSE made over RMSE published, grease 1 (areas: |nu| up to 1/3)", ylim=(0, 2.5))
    axes.set(xlabel="friction over the grease's: f", ylabel="RMSE / published", xlim=(0.3, 2.0))
    axes.legend(loc="upper center", fontsize=8)


def draw_friction(fmus: FmuResults) -> Figure:
    """Friction that varies with speed and load."""
    figure = Figure(figsize=(12.5, 9.0), layout="constrained")
    (first, second), (third, fourth) = figure.subplots(2, 2)
    mu = GREASES[0]
    draw_coefficients(first)
    draw_factors(second)
    speeds = {"at rest": 0.0, "10 mm/s": 0.01, "100 mm/s": 0.1}
    draw_varied(
        third,
        {words: (speed_law(mu), v) for words, v in speeds.items()},
        f"Pair B, speed, friction {mu} (blue loading, orange releasing)",
    )
    loads = {f"nu = {words}": (load_law(mu, n), 0.01) for words, n in (("-1/3", -1 / 3), ("1/3", 1 / 3))}
    draw_varied(fourth, loads, f"Pair B, load, friction {mu} at {LOAD:.0f} N (colours likewise)")
    return figure


PICTURES = {
    "efficiency": draw_efficiency,
    "torque": draw_torque,
    "dependence": draw_dependence,
    "measurements": draw_measurements,
    "friction": draw_friction,
}
