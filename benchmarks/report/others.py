"""The sections on absent parts, growth, start-up, control loops in Python and other platforms."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.harness.markdown import Row, prose, read, rounded, table


def skipping(folder: Path, picture: str) -> str:
    rows = read(folder, "skipping")
    parts = [
        "## Absent parts",
        f"![Time of a step before and after leaving a part out]({picture})",
        prose(
            """Each part of the mechanism is left out by itself: time of a slipping step before and after.
            This page has three numbers for the null FMU, which does nothing. The null FMU is measured once
            for the section [One step](#one-step) and once for each mechanism of this section. The loop of
            this section does more around a step: a fourth call, which reads a list of outputs (an empty list
            for the null FMU), and a look at the clock after every 25 steps. Compare each number with the
            steps of the same table only."""
        ),
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


FLAT = 1.5  # a cost per unit that grows or falls by less than this factor is flat
GROWTH = {  # the reason why a cost is not flat
    "table points: step": "in proportion to the knots that the step passes, each of which ends a segment",
    "table points: knot passed": "the cost of the step itself is shared by more knots",
    "table points: initialise": "the cost of initialising without a table is shared by few points",
    "steps": "the first step after instantiating meets cold caches",
    "instances: step": "many instances exceed the processor's caches",
    "instances: initialise": "a single instance meets cold caches",
    "instances: instantiate": "many instances exceed the caches, and the system clears new memory",
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
            verdict = f"two threads do {rounded(str(1.0 / grows))} times the work of one"
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
    rows = read(folder, "loop")
    cells = [[row["way"], rounded(row["us"]), rounded(row["ratio"])] for row in rows]
    return "\n\n".join(
        [
            "## A control loop in Python",
            prose(
                """The loop has 10,000 turns. Each turn sets a torque, steps 1 ms, reads angle and speed.
                "cam" is the FMU through `dualcam.Fmu`. The other rows are an FMU that does nothing: through
                `dualcam.Fmu`, by bare ctypes, and by FMPy's methods. All four loops are
                timed in each of many rounds. "us per turn" is the median over the rounds. "share of cam" is
                the median of the ratios to "cam" of the same round. So the share can differ by some percent
                from the ratio of the medians."""
            ),
            table(["through", "us per turn", "share of cam"], cells),
        ]
    )


def span(rows: Sequence[Row], quantity: str) -> str:
    ratios = sorted(float(row["ratio"]) for row in rows if row["quantity"] == quantity)
    return f"{ratios[0]:.2f} to {ratios[-1]:.2f}" if ratios else "not measured"


def platform_cost(folder: Path) -> str:
    rows = read(folder, "platform_cost")
    cells = [
        [
            row["scene"],
            row["platform"],
            row["quantity"],
            rounded(row["linux_x86_64"]),
            rounded(row["value"]),
            f"{float(row['ratio']):.2f}",
        ]
        for row in rows
    ]
    return "\n\n".join(
        [
            "## Windows and aarch64",
            prose(
                f"""`./build.sh run platforms` makes the same steps with the binary of each platform, and
                divides by the Linux x86-64 binary of the same run. One step sets the torque, steps 1 ms and
                reads the angle. The Windows x64 binary takes {span(rows, "ns")} times as long. wine runs the
                machine code of that binary directly. The binary differs from that of Linux in two ways: it is
                linked without link-time optimisation, and its functions save ten registers of floating-point
                numbers that functions on Linux may overwrite. The aarch64 binary executes
                {span(rows, "instructions")} times as many instructions, which a plugin of qemu counts. No
                time has been measured on a processor with aarch64. All platforms reach the same bits."""
            ),
            table(["scene", "platform", "unit", "Linux x86-64", "here", "ratio"], cells),
        ]
    )
