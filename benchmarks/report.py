"""docs/performance.md from what the benchmarks have written.

    .venv/bin/python benchmarks/report.py        (./build.sh bench ends with it)

All numbers of the page are those of the CSV files.
"""

from __future__ import annotations

import argparse
import csv
import os
import textwrap
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results"
PAGE = ROOT / "docs" / "performance.md"
LEVELS = (1e-4, 1e-8)
FLAT = 1.5  # times as much per unit at the largest size as at the smallest counts as flat
FACTS = ("command", "date", "machine", "versions", "commit")
Row = dict[str, str]


def read(folder: Path, name: str) -> list[Row]:
    """Without the lines of circumstances at the end of work_precision.csv."""
    path = folder / f"{name}.csv"
    if not path.exists():
        raise SystemExit(f"report: {path} is missing: run ./build.sh bench")
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    facts = {}
    for row in rows:
        first = next(iter(row.values()))
        if first.startswith("# "):
            key, _, value = first[2:].partition(": ")
            facts[key] = value
    return [{**row, **facts} for row in rows if not next(iter(row.values())).startswith("# ")]


def prose(text: str) -> str:
    hang = "  " if text.startswith("- ") else ""
    line = " ".join(text.split())
    return textwrap.fill(line, 118, subsequent_indent=hang, break_long_words=False, break_on_hyphens=False)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def rounded(text: str, digits: int = 3) -> str:
    """Three significant digits, without an exponent below 10^6."""
    if not text:
        return ""
    value = float(text)
    if value == 0.0:
        return "0"
    if abs(value) >= 1e6:
        return f"{value:.{digits}g}".replace("e+0", "e").replace("e+", "e")
    return f"{float(f'{value:.{digits}g}'):,.10g}"


def row_of(rows: Sequence[Row], **wanted: str) -> Row:
    return next(row for row in rows if all(row[key] == value for key, value in wanted.items()))


# ---- The parts ----------------------------------------------------------------------------------------


def precision(folder: Path, picture: str) -> str:
    rows = read(folder, "work_precision")
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    lines = [line for line in dict.fromkeys(row["line"] for row in rows) if line != "reference"]

    def best(scene: str, line: str, level: float) -> float | None:
        """Least time of a setting that is as exact."""
        times = [
            float(row["us_per_simulated_s"])
            for row in rows
            if row["scene"] == scene and row["line"] == line and row["us_per_simulated_s"]
            if not row["failure"] and worst_error(row) <= level
        ]
        return min(times, default=None)

    def cell(scene: str, line: str, level: float) -> str:
        time, own = best(scene, line, level), best(scene, "FMU from C", level)
        if time is None or own is None:
            return "no"
        return f"{rounded(str(time))} us" if line == "FMU from C" else rounded(str(time / own))

    parts = [
        "## Run time against error",
        f"![Run time against error]({picture})",
        prose(
            """Four scenes; the error is the largest of angle, speed and dissipated energy, relative to the
            largest of each, against references that two methods agree on. Every other way to simulate runs
            at the best of its settings for that error; the FMU is stepped from C without its ledger, which
            no other way keeps. For the FMU: run time per simulated second; for all others: how many times
            as long; "no": does not get so far in a second of computing."""
        ),
    ]
    for level in LEVELS:
        parts.append(f"At an error of {level:g}:")
        cells = [[line, *(cell(scene, line, level) for scene in scenes)] for line in lines]
        parts.append(table(["", *scenes], cells))
    return "\n\n".join([*parts, *why_not_more(folder, best)])


def why_not_more(folder: Path, best: Callable[[str, str, float], float | None]) -> list[str]:
    """What keeps the ratio to SciPy below a thousand."""
    price = 1e-3 * float(row_of(read(folder, "step_cost"), scene="evaluation")["ns_per_step"])
    cells = []
    for row in read(folder, "evaluations"):
        number, own = float(row["evaluations_per_simulated_s"]), best(row["scene"], "FMU from C", LEVELS[-1])
        bare = price * number
        cells.append(
            [
                row["scene"],
                f"{row['line'].removeprefix('SciPy ')}, {row['setting']}",
                rounded(row["us_per_simulated_s"]),
                rounded(row["evaluations_per_simulated_s"]),
                rounded(row["us_per_evaluation"]),
                rounded(str(bare)),
                rounded(str(float(row["us_per_simulated_s"]) / bare)),
                rounded(str(own)) if own else "",
            ]
        )
    return [
        prose(
            f"""What SciPy's time is made of, at its fastest setting with an error of at most {LEVELS[-1]:g}:
            evaluations of the equations in Python. At the price of one in C ({rounded(str(1e3 * price))} ns
            in elliptical grooves with every force) as many of them, and nothing else, no step control, no
            search for events, no implicit solution, would be faster by the factor in the last column but
            one. More than that is had only by needing fewer evaluations, as the closed form does. What the
            FMU takes, with all of that, is in the last column."""
        ),
        table(
            [
                "scene",
                "SciPy",
                "us per s",
                "evaluations per s",
                "us each",
                "us per s, in C",
                "factor",
                "FMU, us per s",
            ],
            cells,
        ),
    ]


def worst_error(row: Row) -> float:
    return max(float(row[f"error_{name}"] or "inf") for name in ("theta", "omega", "energy"))


def step_cost(folder: Path, picture: str) -> str:
    rows = read(folder, "step_cost")
    unit, null = row_of(rows, scene="exp+sincos"), row_of(rows, scene="null")
    shown = [row for row in rows if row["scene"] not in ("exp+sincos", "dependent", "null", "evaluation")]
    reasons = list(dict.fromkeys(row["least_is"] for row in shown if row["least_is"]))
    cells = [
        [
            row["scene"],
            rounded(row["ns_per_step"]),
            rounded(row["ratio_to_exp_sincos"]),
            rounded(row["less_null_fmu"]) + (f" (of {row['target']})" if row["target"] else ""),
            rounded(row["ratio_to_null_fmu"]),
            rounded(row["instructions_per_step"]),
            rounded(row["least_ns"])
            + (f" ({reasons.index(row['least_is']) + 1})" if row["least_is"] else ""),
            rounded(row["ratio_to_least"]),
            rounded(row["fmpy_ratio_to_null_fmu"]),
        ]
        for row in shown
    ]
    head = [
        "scene",
        "ns",
        "x exp+sincos",
        "less null FMU",
        "x null FMU",
        "instructions",
        "limit, ns",
        "x limit",
        "FMPy, x null FMU",
    ]
    paths = [row for row in shown if row["ratio_to_least"]]
    nearest, farthest = (f(paths, key=lambda row: float(row["ratio_to_least"])) for f in (min, max))
    text = [
        "## One step",
        f"![Time of one step]({picture})",
        prose(
            f"""Set the torque, a step of 1 ms, read angle and speed. One exp and one sincos, called for many
            numbers, take {rounded(unit["ns_per_step"])} ns here, the three calls of an FMU that does
            nothing {rounded(null["ns_per_step"])} ns, the acceleration in elliptical grooves with every
            force {rounded(row_of(rows, scene="evaluation")["ns_per_step"])} ns. "Less null FMU": without
            those three calls, in units of exp and sincos, against the target. Instructions are callgrind's.
            Through FMPy the calls themselves cost so much that the model hardly shows."""
        ),
        table(head, cells),
        "The limit is the time of what cannot be left out, at the price that it has by itself:",
        "\n".join(f"{number}. {reason}" for number, reason in enumerate(reasons, 1)),
        prose(
            f"""Nearest to it is `{nearest["scene"]}` ({rounded(nearest["ratio_to_least"])} times), farthest
            `{farthest["scene"]}` ({rounded(farthest["ratio_to_least"])} times). What is above the limit in
            slip of known step size: the checks that no event happens inside the step, whose answer is the
            reason why events are exact; the ledger's accounts and peaks; sums carried with twice the
            digits. In general grooves: two sweeps over the nodes, in which nearly every operation waits for
            the one before (the grooves' polynomials, the balance, two integrals, three divisions), then the
            same checks and accounts. So it is latency that counts: compiled for vectors twice as wide
            (AVX) the step has fewer instructions and takes as long."""
        ),
        "Scenes:",
        "\n".join(f"- {row['scene']}: {row['what']}" for row in shown),
    ]
    return "\n\n".join(text)


def worst_step(folder: Path, picture: str) -> str:
    rows = read(folder, "worst_step")
    scenes = [scene for scene in dict.fromkeys(row["scene"] for row in rows) if scene != "bound"]
    whole = {scene: row_of(rows, scene=scene, what="all") for scene in scenes}
    quantiles = [
        row["what"] for row in rows if row["scene"] == scenes[0] and row["what"].startswith("quantile")
    ]
    kinds = [
        row["what"] for row in rows if row["scene"] == scenes[0] and row["what"] not in ("all", *quantiles)
    ]

    def of(scene: str, what: str, column: str) -> str:
        return rounded(row_of(rows, scene=scene, what=what)[column])

    def in_us(scene: str, what: str, column: str) -> str:
        text = row_of(rows, scene=scene, what=what)[column]
        return rounded(str(1e-3 * float(text))) if text else ""

    def limit(what: str) -> str:
        return rounded(row_of(rows, scene="bound", what=what)["limit"])

    def kind_cells(what: str) -> list[str]:
        cells = [what]
        for scene in scenes:
            steps, counted = of(scene, what, "steps"), of(scene, what, "instructions_worst")
            longest = f"{steps}: {in_us(scene, what, 'ns_worst')} us" + (f", {counted}" if counted else "")
            cells.append(longest if steps != "0" else "none")
        return cells

    evaluation = float(row_of(read(folder, "step_cost"), scene="evaluation")["ns_per_step"])
    bound = 1e-9 * evaluation * float(row_of(rows, scene="bound", what="evaluations per step")["limit"])
    longest = 1e-9 * max(float(row["ns_worst"]) for row in whole.values())
    counted = {scene: rounded(row["instructions_per_change_worst"]) for scene, row in whole.items()}
    per_change = ", ".join(f"{number} ({scene})" for scene, number in counted.items() if number)
    allowed = limit("legs per step")
    rest = ", ".join(f"{in_us(scene, 'not counted', 'ns_worst')} us ({scene})" for scene in scenes)
    unseen = "Where callgrind is missing nothing is counted."
    if counted[scenes[0]]:
        unseen = f"The longest of the steps that were not counted took {rest}."
    text = [
        "## The worst step",
        f"![Time of a step: how often; instructions against time]({picture})",
        prose(
            f"""For hardware in the loop: {rounded(whole[scenes[0]]["steps"])} steps of 1 ms per scene under
            inputs of random kind, with all that can happen in them. A step's time is its least over several
            runs, which takes interrupts out; the instructions of the longest steps (also of each kind, and
            of some at random) are counted by callgrind. Time in us:"""
        ),
        table(
            ["share of steps that take at most", *scenes],
            [
                [f"{100.0 * float(q.split()[1]):g} %", *(in_us(scene, q, "ns_median") for scene in scenes)]
                for q in quantiles
            ],
        ),
        "The worst:",
        "\n".join(
            prose(
                f"""- {scene}: {rounded(whole[scene]["instructions_worst"]) or "not counted"} instructions, at
                most {in_us(scene, "all", "ns_worst")} us. In it: {whole[scene]["happens"]}."""
            )
            for scene in scenes
        ),
        unseen,
        prose(
            """What makes a step long is the number of mode changes in it, most of all bounces at a stop: each
            is lower than the one before and all that are left fall into one step, until theta does not show
            them. A `stop.restitution` of 0 has none. Number of steps, longest time, most instructions:"""
        ),
        table(["kind of step", *scenes], [kind_cells(what) for what in kinds]),
        prose(
            f"""**Bound.** A step is made in legs, each to a mode change, to a border between two pieces of a
            course, or as far as a single leap can go; beyond {allowed} of them (MAX_EVENTS_PER_STEP), or
            {limit("jams per step")} times that contacts jam and let go again, it is refused with fmi2Error.
            For each leg passage_find() tries at most {limit("searches per leg")} lengths with
            {limit("solves per search")} solves each, and a solve is at most {limit("evaluations per solve")}
            evaluations of the balance of forces ({limit("evaluations per solve, play")} without inertia and
            damping): {limit("evaluations per leg")} evaluations per leg, {limit("evaluations per step")} per
            step. The instant of an event is sought in polynomials, halved {limit("depth of halving")} deep
            at most. In closed form, for steps up to half a period of the oscillation, a leg is at most
            {limit("closed form: evaluations per leg")} evaluations, a step
            {limit("closed form: evaluations per step")}."""
        ),
        prose(
            f"""That is a proof that a step ends, far above what is met: at the price of the acceleration
            alone ({rounded(str(evaluation))} ns) the first product is {rounded(str(bound / 3600.0))} hours,
            {rounded(str(bound / longest))} times the longest step met. What a mode change costs varies much
            less than what is allowed for it: the instructions of a step, divided by its mode changes and
            one more, are at most {per_change or "not counted"}. A motion that changes its mode without end
            takes up to {allowed} times as much until it is refused."""
        ),
        prose(
            """Two things have no constant bound: the pieces of a course that a step passes, of which a table
            has one per knot; and the half periods that a longer step in closed form goes through. Who needs
            a hard limit in real time sets `stop.restitution` to 0, takes steps that are short against the
            oscillation and passes few knots of a table in each: then a step has one mode change or two."""
        ),
    ]
    return "\n\n".join(text)


def skipping(folder: Path, picture: str) -> str:
    rows = read(folder, "skipping")
    parts = [
        "## What is absent",
        f"![Time of a step before and after leaving something out]({picture})",
        "Each thing that a scene can lack, left out one at a time: time of a slipping step before and after.",
    ]
    for title in dict.fromkeys(row["mechanism"] for row in rows):
        cells = [
            [
                row["without"].strip("()"),
                rounded(row["ns_before"]),
                rounded(row["ns_per_step"]),
                row["verdict"].replace("DEFECT", "saves nothing, though it could"),
            ]
            for row in rows
            if row["mechanism"] == title and row["without"] != "everything"
        ]
        parts += [f"In {title}:", table(["without", "before, ns", "after, ns", ""], cells)]
    return "\n\n".join(parts)


GROWTH = {  # why what is not flat is not
    "table points: step": "in proportion to the knots that it passes, each of which ends a leap: see below",
    "table points: knot passed": "what a step costs by itself is shared by more knots",
    "table points: initialise": "what initialising takes without any table is shared by few points",
    "steps": "the first step after instantiating meets cold caches",
    "instances: step": "many do not fit into the processor's caches",
    "instances: initialise": "a single one meets cold caches",
    "instances: instantiate": "many do not fit into the processor's caches, and the system clears new memory",
}


def growth(folder: Path, picture: str) -> str:
    rows = read(folder, "growth")
    whats = [what for what in dict.fromkeys(row["what"] for row in rows) if not what.startswith("start-up")]
    cells = []
    for what in whats:
        found = [row for row in rows if row["what"] == what]
        first, last = found[0], found[-1]
        times = [float(row["us_per_unit"]) for row in found]
        grows = times[-1] / times[0]
        flat = 1.0 / FLAT <= grows <= FLAT
        verdict = "flat" if flat else GROWTH.get(what, "not flat")
        if what == "threads":
            verdict = f"two do {rounded(str(1.0 / grows))} times the work of one"
        memory = last["bytes_per_unit"]
        cells.append(
            [
                what,
                f"{rounded(first['size'])} to {rounded(last['size'])}",
                f"{rounded(first['us_per_unit'])} to {rounded(last['us_per_unit'])}",
                last["unit"],
                rounded(memory),
                verdict,
            ]
        )
    starts = [row for row in rows if row["what"].startswith("start-up")]
    total = sum(float(row["us_per_unit"]) for row in starts)
    shares = [
        [
            row["what"].removeprefix("start-up: "),
            rounded(row["us_per_unit"]),
            f"{100.0 * float(row['us_per_unit']) / total:.0f} %",
        ]
        for row in starts
    ]
    return "\n\n".join(
        [
            "## Growth and start-up",
            f"![Time per unit against their number, and the parts of start-up]({picture})",
            "Time and memory per unit, from the smallest number to the largest:",
            table(["what", "number", "us per unit", "unit", "bytes per unit at the largest", ""], cells),
            "Start-up, from C, in a new process each:",
            table(["part", "us", "share"], [*shares, ["all", rounded(str(total)), ""]]),
        ]
    )


def loop(folder: Path) -> str:
    rows = read(folder, "loop_cost")
    turns = int(rows[0]["turns"])
    cells = [
        [r["through"], rounded(str(1e6 * float(r["seconds"]) / turns)), rounded(r["share_of_cam"])]
        for r in rows
    ]
    return "\n\n".join(
        [
            "## A control loop in Python",
            prose(
                f"""{turns:,} turns of: set a torque, step 1 ms, read angle and speed, through `dualcam.Fmu`
                (cam), the same with an FMU that does nothing, without any handle, and by FMPy's methods:"""
            ),
            table(["through", "us per turn", "share of cam"], cells),
        ]
    )


def circumstances(folder: Path) -> str:
    names = ("work_precision", "step_cost", "worst_step", "skipping", "growth", "loop_cost")
    cells = []
    for name in names:
        row = read(folder, name)[0]
        cells.append([f"`{name}.csv`", *(row[fact] for fact in FACTS)])
    return "## Circumstances\n\n" + table(["file", *FACTS], cells)


def page(results: Path, place: Path) -> str:
    """`place`: the folder of the page, which the pictures are linked from."""

    def picture(name: str) -> str:
        return Path(os.path.relpath(results / f"{name}.png", place)).as_posix()

    return (
        "\n\n".join(
            [
                "# How fast, and how near to the limit",
                prose(
                    """Written by `benchmarks/report.py` at the end of `./build.sh bench` (about ten minutes)
                    from `benchmarks/results/*.csv`, where spreads are too; every part has a command of its
                    own, named below."""
                ),
                precision(results, picture("work_precision")),
                step_cost(results, picture("step_cost")),
                worst_step(results, picture("worst_step")),
                skipping(results, picture("skipping")),
                growth(results, picture("growth")),
                loop(results),
                circumstances(results),
            ]
        )
        + "\n"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--page", type=Path, default=PAGE)
    arguments = parser.parse_args()
    arguments.page.write_text(page(arguments.results.resolve(), arguments.page.resolve().parent))
    print(f"written: {arguments.page}")


if __name__ == "__main__":
    main()
