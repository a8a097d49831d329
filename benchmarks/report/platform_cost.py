"""The section on the cost of a step on other platforms."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.harness.markdown import Row, prose, read, rounded, table


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
