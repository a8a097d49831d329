"""The section on the worst step."""

from __future__ import annotations

from pathlib import Path

from benchmarks.harness.markdown import Row, prose, read, rounded, row_of, table


class Found:
    """The results of the worst steps."""

    def __init__(self, folder: Path) -> None:
        self.rows = read(folder, "worst_step")
        self.scenes = [
            scene for scene in dict.fromkeys(row["scene"] for row in self.rows) if scene != "bound"
        ]
        names = [row["what"] for row in self.rows if row["scene"] == self.scenes[0]]
        self.quantiles = [name for name in names if name.startswith("quantile")]
        self.kinds = [name for name in names if name not in ("all", *self.quantiles)]
        evaluation = row_of(read(folder, "step_cost"), scene="evaluation")
        self.evaluation_ns = float(evaluation["ns_per_step"])

    def row(self, scene: str, what: str) -> Row:
        return row_of(self.rows, scene=scene, what=what)

    def whole(self, scene: str) -> Row:
        return self.row(scene, "all")

    def in_us(self, scene: str, what: str, column: str) -> str:
        text = self.row(scene, what)[column]
        return rounded(str(1e-3 * float(text))) if text else ""

    def limit(self, what: str) -> str:
        return rounded(self.row("bound", what)["limit"])


def worst_step(folder: Path, picture: str) -> str:
    found = Found(folder)
    return "\n\n".join(
        [
            "## The worst step",
            f"![Time of a step: how often; instructions against time]({picture})",
            *times(found),
            *worst(found),
            *kinds(found),
            *bound(found),
        ]
    )


def times(found: Found) -> list[str]:
    return [
        prose(
            f"""This section is for hardware in the loop. Each scene has
            {rounded(found.whole(found.scenes[0])["steps"])} steps of 1 ms under inputs of random kind, with
            every kind of event. The time of a step is its least time over several runs, which excludes
            interrupts. Callgrind counts the instructions of the longest steps, of the longest of each kind,
            and of some steps at random. Time in us:"""
        ),
        table(
            ["share of steps that take at most", *found.scenes],
            [
                [
                    f"{100.0 * float(quantile.split()[1]):g} %",
                    *(found.in_us(scene, quantile, "ns_median") for scene in found.scenes),
                ]
                for quantile in found.quantiles
            ],
        ),
    ]


def worst(found: Found) -> list[str]:
    items = []
    for scene in found.scenes:
        whole = found.whole(scene)
        items.append(
            prose(
                f"""- {scene}: {rounded(whole["instructions_worst"]) or "not counted"} instructions, at most
                {found.in_us(scene, "all", "ns_worst")} us. Its events: {whole["happens"]}."""
            )
        )
    rest = ", ".join(
        f"{found.in_us(scene, 'not counted', 'ns_worst')} us ({scene})" for scene in found.scenes
    )
    uncounted = f"The longest of the steps that were not counted took {rest}."
    if not found.whole(found.scenes[0])["instructions_per_change_worst"]:
        uncounted = "Where callgrind is missing nothing is counted."
    return ["The worst step of each scene:", "\n".join(items), uncounted]


def kinds(found: Found) -> list[str]:
    def cell(scene: str, kind: str) -> str:
        row = found.row(scene, kind)
        steps, counted = rounded(row["steps"]), rounded(row["instructions_worst"])
        if steps == "0":
            return "none"
        return f"{steps}: {found.in_us(scene, kind, 'ns_worst')} us" + (f", {counted}" if counted else "")

    return [
        prose(
            """The number of mode changes makes a step long, most of all bounces at a stop. Each bounce is
            lower than the one before, and all that are left fall into one step, until theta does not show
            them. With a `stop.restitution` of 0 there are no bounces. Number of steps, longest time, most
            instructions:"""
        ),
        table(
            ["kind of step", *found.scenes],
            [[kind, *(cell(scene, kind) for scene in found.scenes)] for kind in found.kinds],
        ),
    ]


def bound(found: Found) -> list[str]:
    limit, allowed = found.limit, found.limit("segments per step")
    whole = {scene: found.whole(scene) for scene in found.scenes}
    longest = 1e-9 * max(float(row["ns_worst"]) for row in whole.values())
    product = 1e-9 * found.evaluation_ns * float(found.row("bound", "evaluations per step")["limit"])
    counted = {scene: rounded(row["instructions_per_change_worst"]) for scene, row in whole.items()}
    per_change = ", ".join(f"{number} ({scene})" for scene, number in counted.items() if number)
    return [
        prose(
            f"""**Bound.** A step is a sequence of segments. Each segment ends at a mode change, at a
            breakpoint of the transmission, or where a single collocation step can go no further. A step with
            more than {allowed} segments, or in which contacts wedge more than
            {limit("jams per step")} times, is refused with fmi2Error. The event location tries at most
            {limit("searches per segment")} lengths of a segment, with at most {limit("solves per search")}
            solves for each length. A solve takes at most {limit("evaluations per solve")} evaluations of the
            balance of forces ({limit("evaluations per solve, quasi-static")} without inertia and damping).
            The product is {limit("evaluations per segment")} evaluations per segment. One counter adds up the
            evaluations of all segments and searches of a step, in closed form too. A step that needs more
            than {limit("evaluations per step")} is refused. The instant of an event is found in polynomials,
            whose interval is halved at most {limit("depth of halving")} times. In closed form, for steps up
            to half a period of the oscillation, a segment takes at most
            {limit("closed form: evaluations per segment")} evaluations."""
        ),
        prose(
            f"""The bound proves that a step ends. It is far above the steps that occur: at the price of the
            acceleration alone ({rounded(str(found.evaluation_ns))} ns) these evaluations take
            {rounded(str(product))} s, {rounded(str(product / longest))} times the longest step of the runs.
            The cost of a mode change varies much less than the bound allows: the instructions of a step,
            divided by its mode changes and one more, are at most {per_change or "not counted"}. A motion that
            changes its mode without end takes up to {allowed} times as much until it is refused."""
        ),
        prose(
            """Long steps come nearer to this bound: through many breakpoints of the transmission, of which a
            table has one per knot, and over many half periods of the oscillation. A hard limit in real time
            needs three settings: a `stop.restitution` of 0, steps that are short against the oscillation, and
            few knots of a table in each step. Then a step has one mode change or two."""
        ),
    ]
