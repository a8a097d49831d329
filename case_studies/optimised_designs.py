"""By how much do the hand-made cams of the prosthetic knee and of the robot's elbow miss the optimum?

    python -m case_studies.optimised_designs --workers 2

Both cams are fitted by least squares to a torque (dualcam.systems.machines.knee,
dualcam.systems.machines.elbow): the cam's torque along the planned motion should equal what the motion asks
for. What counts is the motor's heat in the closed loop. Here the same parameters are chosen for the heat, by
dualcam.study.optimise:

  knee          SLSQP: least heat over three cadences; no harder impact than 20 deg/s. The second subject, who
                has no part in the search, checks the result
  knee, robust  differential evolution: the same for 95 % of the parts, with friction 0.10 to 0.18, spring and
                damper +- 10 %
  elbow         SLSQP: least heat at the payload of the hand-made cam, 1.5 kg
  elbow, front  NSGA-II: heat without payload against heat_3kg

The searches take some minutes. They continue in --folder after an interruption.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.console import Console

from dualcam import Fmu
from dualcam.errors import DualcamError
from dualcam.study import Deviation, Optimisation, Optimum, Vary, optimise
from dualcam.study.optimisation.evaluation import DesignEvaluator
from dualcam.systems.blocks.axis import CamAxis, simulate_closed_loop
from dualcam.systems.blocks.current_loop import CurrentLoop
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.machines import elbow, knee
from dualcam.systems.machines.gait import CHECK_WALKER, DESIGN_WALKER, Walker
from dualcam.systems.machines.swing import Swing

HERE = Path(__file__).resolve().parent
FMU = HERE.parent / "build" / "DualCamForward.fmu"
RESULTS = HERE / "optimised_designs.csv"
CADENCES = (0.8, 1.0, 1.2)  # of the self-selected one
IMPACT = 20.0  # deg/s; the hand-made cam has 15 deg/s
HAND, BEST, ROBUST = "hand-made", "optimum", "robust optimum"
COLOURS = {HAND: "0.6", BEST: "tab:blue", ROBUST: "tab:green"}
Design = Mapping[str, float]
Row = tuple[str, str, str, float]  # system, design, quantity, value

KNEE = {
    "slope": Vary(0.5, 5.0),
    "end": Vary(0.3, 0.97),
    "stiffness": Vary(5e3, 2e5, log=True),
    "damping": Vary(1e3, 8e4, log=True),
}
ELBOW = {
    "lead_angle1": Vary(0.5, 1.1),
    "lead_angle2": Vary(0.5, 1.1),
    "preload": Vary(0.0, 600.0),
    "stiffness": Vary(1e4, 1e5, log=True),
}


# ---- models: one design in, results out ----


@cache
def fmu() -> Fmu:
    """The FMU of this process."""
    return Fmu(FMU)


@cache
def swing(walker: Walker, cadence: float) -> Swing:
    """The measured swing."""
    return knee.swing(walker, cadence)


def knee_of(design: Mapping[str, float | str], walker: Walker = DESIGN_WALKER) -> dict[str, float]:
    """Heat of the motor [J] over all cadences, and the hardest impact [deg/s]."""
    slope, end, stiffness, damping = (float(design[name]) for name in KNEE)
    cam = knee.elliptical_cam(slope, end, stiffness, damping, float(design.get("friction", knee.FRICTION)))
    impedance = knee.impedance(knee.inertia(walker))
    runs = [
        knee.simulate(fmu(), swing(walker, cadence), cam.with_damping_scaled(cadence).parameters(), impedance)
        for cadence in CADENCES
    ]
    return {"heat": sum(run.heat for run in runs), "impact": max(run.impact_speed for run in runs)}


def elbow_heat(design: Mapping[str, float | str], payload: float) -> float:
    """Heat of the motor [J] per cycle."""
    lead1, lead2, preload, stiffness = (float(design[name]) for name in ELBOW)
    cam = replace(elbow.HELIX, lead_angle=(lead1, lead2), preload=preload, stiffness=stiffness)
    axis = CamAxis(fmu())
    axis.start(elbow.plant_parameters(cam, payload), angle=elbow.MOTION.start)
    controller, loop = elbow.controller(cam, payload), CurrentLoop(AK80_6)
    record = simulate_closed_loop(axis, elbow.weight(payload), controller, loop, elbow.reference_motion())
    cycle = elbow.Cycle(payload, "", record)
    if not cycle.lifts:
        raise DualcamError(f"the elbow does not follow its plan with {payload} kg")
    return cycle.joule_heat


def elbow_of(design: Mapping[str, float | str]) -> dict[str, float]:
    """Heat at the payload for which the cam was designed."""
    return {"heat": elbow_heat(design, elbow.DESIGN_PAYLOAD)}


def elbow_of_two(design: Mapping[str, float | str]) -> dict[str, float]:
    """Heat without payload and with the largest one; both grooves have 45 deg."""
    full = {"lead_angle1": math.pi / 4, "lead_angle2": math.pi / 4, **design}
    return {"heat_0kg": elbow_heat(full, 0.0), "heat_3kg": elbow_heat(full, 3.0)}


# ---- what is wanted ----


def hand_made_knee() -> dict[str, float]:
    """The parameters of knee.design_cam."""
    cam = knee.design_cam()
    end = knee.START_SINE - 0.5 * cam.radius * knee.RANGE / cam.ellipse_a
    values = math.tan(cam.lead_angle), end, cam.stiffness, cam.release_damping
    return dict(zip(KNEE, values, strict=True))


def hand_made_elbow() -> dict[str, float]:
    """The parameters of elbow.design_cam."""
    cam = elbow.design_cam()
    return dict(zip(ELBOW, (*cam.lead_angle, cam.preload, cam.stiffness), strict=True))


def tasks(scale: float) -> dict[str, Optimisation]:
    """All searches; `scale`: of the budgets."""

    def budget(designs: int) -> int:
        return max(5, round(scale * designs))

    hand, least = hand_made_knee(), {"heat": "minimise"}
    limits = {"impact": (None, IMPACT)}
    parts = {"stiffness": Deviation(0.1 * hand["stiffness"]), "damping": Deviation(0.1 * hand["damping"])}
    spread = {"friction": Vary(0.10, 0.18, distribution="uniform", arguments={"loc": 0.10, "scale": 0.08})}
    two = {name: ELBOW[name] for name in ("preload", "stiffness")}
    front = {"heat_0kg": "minimise", "heat_3kg": "minimise"}
    return {
        "knee": Optimisation(
            knee_of, KNEE, least, limits, method="slsqp", budget=budget(500), starts=1, start=hand
        ),
        "knee_robust": Optimisation(
            knee_of,
            KNEE | spread,
            least,
            limits,
            budget=budget(400),
            start=hand,
            tolerances=parts,
            samples=16,
        ),
        "elbow": Optimisation(
            elbow_of, ELBOW, least, method="slsqp", budget=budget(120), starts=1, start=hand_made_elbow()
        ),
        "elbow_front": Optimisation(
            elbow_of_two,
            two,
            front,
            budget=budget(200),
            population=budget(40),
            start={name: hand_made_elbow()[name] for name in two},
        ),
    }


# ---- results ----


def percentile_of(task: Optimisation, design: Design) -> dict[str, float]:
    """Objectives of a design, with the parts of the task."""
    evaluator = DesignEvaluator(replace(task, start=dict(design)))
    batch = evaluator.evaluate(evaluator.start()[None, :])
    evaluator.close()
    return dict(zip(task.objectives, batch.objectives[0].tolist(), strict=True))


def rows_of(found: Mapping[str, Optimum]) -> list[Row]:
    """All numbers of the page."""
    rows: list[Row] = []
    knees = {BEST: found["knee"].design, ROBUST: found["knee_robust"].design}
    designs: dict[str, Mapping[str, float | str]] = {HAND: hand_made_knee(), **knees}
    for name, design in designs.items():
        values = {key: float(value) for key, value in design.items()}
        first, second = knee_of(values), knee_of(values, CHECK_WALKER)
        robust = percentile_of(found["knee_robust"].task, values)["heat"]
        rows += [("knee", name, key, values[key]) for key in KNEE]
        rows += [("knee", name, f"{key}, first subject", value) for key, value in first.items()]
        rows += [("knee", name, f"{key}, second subject", value) for key, value in second.items()]
        rows.append(("knee", name, "heat of 95 % of the parts, first subject", robust))
    elbows: dict[str, Mapping[str, float | str]] = {HAND: hand_made_elbow(), BEST: found["elbow"].design}
    for name, design in elbows.items():
        values = {key: float(value) for key, value in design.items()}
        rows += [("elbow", name, key, values[key]) for key in ELBOW]
        rows.append(("elbow", name, "heat_1.5kg", elbow_of(values)["heat"]))
        rows += [("elbow", name, key, value) for key, value in elbow_of_two(values).items()]
    front = found["elbow_front"].front
    for k in range(len(front["preload"])):
        rows += [("elbow", f"front {k + 1}", name, float(column[k])) for name, column in front.items()]
    return rows


def write(rows: Sequence[Row], path: Path) -> None:
    """Save the numbers."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("system", "design", "quantity", "value"))
        writer.writerows((*names, f"{value:.6g}") for *names, value in rows)


def value_of(rows: Sequence[Row], system: str, design: str, quantity: str) -> float:
    """One number."""
    return next(value for *names, value in rows if names == [system, design, quantity])


def table(rows: Sequence[Row]) -> list[str]:
    """The numbers as lines, without the front."""
    lines = []
    for system, designs in (("knee", (HAND, BEST, ROBUST)), ("elbow", (HAND, BEST))):
        lines += ["", f"{system:42s}" + "".join(f"{name:>16s}" for name in designs)]
        for quantity in dict.fromkeys(row[2] for row in rows if row[:2] == (system, HAND)):
            values = (value_of(rows, system, design, quantity) for design in designs)
            lines.append(f"{quantity:42s}" + "".join(f"{value:16.4g}" for value in values))
    return lines


# ---- picture ----


def picture(rows: Sequence[Row], output: Path) -> None:
    """Save the comparison as an image."""
    figure = Figure(figsize=(6.4, 8.4), layout="constrained")
    bars, front = figure.subplots(2, 1, height_ratios=(1.0, 1.3))
    draw_knee(bars, rows)
    draw_front(front, rows)
    figure.savefig(output, dpi=110)


def draw_knee(axes: Axes, rows: Sequence[Row]) -> None:
    """Heat of the knee's motor."""
    quantities = ("heat, first subject", "heat of 95 % of the parts, first subject", "heat, second subject")
    labels = ("first subject", "first subject,\n95 % of the parts", "second subject,\nnot used")
    for k, design in enumerate((HAND, BEST, ROBUST)):
        heat = [value_of(rows, "knee", design, quantity) for quantity in quantities]
        bars = axes.bar(np.arange(3) + 0.27 * (k - 1), heat, 0.25, color=COLOURS[design], label=design)
        axes.bar_label(bars, fmt="%.2f", fontsize=9)
    axes.set_xticks(range(3), labels)
    axes.set(title="Knee: motor heat of three cadences", ylabel="heat [J]")
    axes.margins(y=0.12)
    axes.legend(fontsize=9, loc="upper left")


def draw_front(axes: Axes, rows: Sequence[Row]) -> None:
    """Heat of the elbow's motor at both payloads."""
    names = dict.fromkeys(row[1] for row in rows if row[1].startswith("front"))
    x, y = (
        [value_of(rows, "elbow", name, quantity) for name in names] for quantity in ("heat_0kg", "heat_3kg")
    )
    axes.plot(x, y, ".", color="tab:red", label="front: preload and stiffness")
    for design, mark in ((HAND, "s"), (BEST, "o")):
        point = [value_of(rows, "elbow", design, f"heat_{payload}kg") for payload in (0, 3)]
        label = f"{design} for 1.5 kg"
        axes.plot(*point, mark, color=COLOURS[design], ms=9, mec="k", label=label)
    axes.set(title="Elbow: motor heat per cycle", xlabel="without payload [J]", ylabel="with 3 kg [J]")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=9)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--workers", type=int, default=0, help="processes")
    parser.add_argument("--scale", type=float, default=1.0, help="of the numbers of designs")
    parser.add_argument("--folder", type=Path, default=HERE.parent / "build" / "optimised_designs")
    parser.add_argument("--results", type=Path, default=RESULTS, help="table to write (.csv)")
    parser.add_argument("--output", type=Path, default=HERE.parent / "docs" / "optimised_designs.png")
    options = parser.parse_args(arguments)
    console = Console()
    found = {
        name: optimise(task, options.folder / name, options.workers, console=console)
        for name, task in tasks(options.scale).items()
    }
    rows = rows_of(found)
    write(rows, options.results)
    picture(rows, options.output)
    print("\n".join(table(rows)))
    for name, one in found.items():
        print(f"{name}: {one.evaluated} designs, {one.infeasible} infeasible; active: {one.active or 'none'}")


if __name__ == "__main__":
    main()
