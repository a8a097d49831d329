"""The cost of a step where friction depends on speed or load, beside the same step with Coulomb's law.

    ./build.sh run friction

Instructions of general steps of 1 ms are counted by callgrind (harness/instructions.py), so that a busy
machine does not matter. The mechanisms are those of benchmarks/step_cost: 30 steps of a half swing under 1.30
times the torque that the stick band needs. Each runs with Coulomb's law, then with a static excess, a
Stribeck curve of exponent 2 or 1 and a lubricated branch, with a table of the same law, with a power of the
load, with power and Stribeck curve together, and with a table of both over speed and load, at both cams and
at cam 1 alone.

Two ratios to Coulomb's law are reported. "Per communication step" holds all that the law costs. A Stribeck
curve bends the motion, and a bent motion needs more collocation steps: that is physics. "Per collocation
step" divides by the number of collocation steps. Callgrind counts them as the calls of segment_apply(), in
the FMU's library compiled with the names of its functions. Of a friction table the instructions of its own
functions are counted too: what the law alone costs, without the step around it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console

from benchmarks.harness import core, instructions, results, steps
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.steps import StepBlock
from benchmarks.mechanisms import Parameters
from benchmarks.step_cost.measure import prepare
from benchmarks.step_cost.scenes import Scene, general_scenes

MECHANISMS = ("cubic spring", "ellipses", "tables", "all forces")
TARGET, TARGET_LOADED = 1.3, 2.0  # of the instructions of a collocation step
SEGMENT = "segment_apply"  # is called once for each collocation step
# of a table: the piece at the start, the values at the nodes, the way to the next samples
SAMPLES_OF_SPEED = ("start_on_tables", "find_friction_by_tables", "approach_samples", "aim_at_samples")
# of a table over the load: besides, the values under the nominal loads
TABLE = (*SAMPLES_OF_SPEED, "friction_on_patch")
KINETIC, PEAK, STRIBECK, VISCOUS = 0.14, 1.5, 0.01, 0.1  # 1, 1, m/s, s/m
LOAD_EXPONENT = 0.3
LOAD = 1000.0  # N, N_ref
LOADS = (100.0, 300.0, 1000.0, 3000.0)  # N, of the table over the load
SAMPLES = np.array([0.0, *np.geomspace(2e-3, 0.5, 24)])  # m/s, of the table

Row = dict[str, str]


def write(path: Path, lines: Sequence[str]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    text = "\n".join(lines) + "\n"
    if not path.exists() or path.read_text() != text:  # another process may be reading the file
        path.write_text(text)
    return path


def write_table(path: Path) -> Path:
    """Samples of the law of exponent 2."""
    mu = KINETIC * (1.0 + (PEAK - 1.0) * np.exp(-((SAMPLES / STRIBECK) ** 2))) + VISCOUS * SAMPLES
    rows = [f"{v!r},{m!r}" for v, m in zip(SAMPLES.tolist(), mu.tolist(), strict=True)]
    return write(path, ["v_m_s,mu", *rows])


def write_table_over_load(path: Path) -> Path:
    """Samples of the law of exponent 2, times the power of the load."""
    mu = KINETIC * (1.0 + (PEAK - 1.0) * np.exp(-((SAMPLES / STRIBECK) ** 2)))
    rows = [
        f"{v!r},{R!r},{m * (R / LOAD) ** LOAD_EXPONENT + VISCOUS * v!r}"
        for R in LOADS
        for v, m in zip(SAMPLES.tolist(), mu.tolist(), strict=True)
    ]
    return write(path, ["v_m_s,R_N,mu", *rows])


@dataclass(frozen=True)
class Law:
    name: str
    cams: str
    parameters: Parameters
    target: float | None


def at_cams(cams: Sequence[int], values: Mapping[str, float | str]) -> Parameters:
    return {f"cam{i}.{name}": value for i in cams for name, value in values.items()}


def stribeck(exponent: int) -> Parameters:
    return {
        "friction_peak": PEAK,
        "stribeck_velocity": STRIBECK,
        "stribeck_exponent": exponent,
        "friction_viscous": VISCOUS,
    }


def laws() -> Iterator[Law]:
    """Coulomb's law first."""
    yield Law("Coulomb", "both", {}, None)
    table: Parameters = {"friction_table": str(write_table(core.BUILD / "tables" / "friction.csv"))}
    path = write_table_over_load(core.BUILD / "tables" / "friction_over_load.csv")
    table_over_load: Parameters = {"friction_table": str(path)}
    power: Parameters = {"friction_load_exponent": LOAD_EXPONENT}
    for cams, label in (((1, 2), "both"), ((1,), "cam 1")):
        yield Law("Stribeck, exponent 2", label, at_cams(cams, stribeck(2)), TARGET)
        yield Law("Stribeck, exponent 1", label, at_cams(cams, stribeck(1)), TARGET)
        yield Law("friction table", label, at_cams(cams, table), TARGET)
        yield Law("load", label, at_cams(cams, power), TARGET_LOADED)
        yield Law("load and Stribeck, exponent 2", label, at_cams(cams, stribeck(2) | power), TARGET_LOADED)
        yield Law("friction table over load", label, at_cams(cams, table_over_load), TARGET_LOADED)


def job(scene: Scene, library: Path) -> instructions.Job:
    """One block of the scene in `library`."""
    block, _ = prepare(scene, steps.load_loops())
    if not isinstance(block, StepBlock):
        raise TypeError(f"{scene.name}: the steps are not consecutive")
    made = block.job()
    _, guid, resources = made["fmu"]
    return {**made, "fmu": (str(library), guid, resources)}


def row_of(scene: Scene, law: Law, counted: instructions.Counted, coulomb: instructions.Counted) -> Row:
    count, segments, before = len(scene.steps), counted.calls[SEGMENT], coulomb.calls[SEGMENT]
    step, step_before = counted.instructions / count, coulomb.instructions / count
    ratio = step / step_before
    each = (counted.instructions / segments) / (coulomb.instructions / before)
    of_table = sum(counted.own.get(name, 0) for name in TABLE) / segments
    return {
        "mechanism": scene.name,
        "law": law.name,
        "cams": law.cams,
        "instructions_per_communication_step": f"{step:.1f}",
        "collocation_steps_per_communication_step": f"{segments / count:.4f}",
        "instructions_per_collocation_step": f"{counted.instructions / segments:.1f}",
        "table_instructions_per_collocation_step": f"{of_table:.1f}",
        "ratio_per_communication_step": f"{ratio:.4f}",
        "ratio_per_collocation_step": f"{each:.4f}",
        "target": "" if law.target is None else f"{law.target:g}",
    }


def measure(mechanisms: int, console: Console) -> list[Row]:
    if not instructions.available():
        raise SystemExit(instructions.WITHOUT)
    library = core.library_with_symbols(core.BUILD / "loops" / "DualCamForward-symbols.so")
    cast = [scene for scene in general_scenes() if scene.name in MECHANISMS[:mechanisms]]
    pairs = [(scene, law) for scene in cast for law in laws()]
    console.print(f"{len(pairs)} runs under callgrind")
    jobs = [
        job(replace(scene, parameters=scene.parameters | law.parameters), library) for scene, law in pairs
    ]
    counts = instructions.count_calls(steps.library(), jobs)
    if not all(counted.calls.get(SEGMENT, 0) for counted in counts):
        raise SystemExit(
            f"callgrind saw no call of {SEGMENT}(): the compiler has copied the function into another"
        )
    coulomb = {scene.name: n for (scene, law), n in zip(pairs, counts, strict=True) if law.name == "Coulomb"}
    return [row_of(s, law, n, coulomb[s.name]) for (s, law), n in zip(pairs, counts, strict=True)]


def report(rows: Sequence[Row], console: Console) -> None:
    shown = results.table(
        "Instructions where friction depends on speed or load; ratio to Coulomb's law",
        *(
            "mechanism",
            "law",
            "cams",
            "per comm. step",
            "coll. steps",
            "ratio/comm.",
            "ratio/coll.",
            "target",
        ),
    )
    for row in rows:
        each = float(row["ratio_per_collocation_step"])
        shown.add_row(
            *(row["mechanism"], row["law"], row["cams"], row["instructions_per_communication_step"]),
            f"{float(row['collocation_steps_per_communication_step']):.2f}",
            f"{float(row['ratio_per_communication_step']):.2f}",
            f"{each:.2f}",
            results.verdict(each, float(row["target"]) if row["target"] else None),
        )
    console.print(shown)


def main() -> None:
    parser = results.options(__doc__, "friction_cost")
    parser.add_argument("--mechanisms", type=int, default=len(MECHANISMS), help="the first of them (all)")
    arguments = parser.parse_args()
    console = results.new_console()
    rows = measure(arguments.mechanisms, console)
    report(rows, console)
    results.publish(rows, circumstances("friction"), arguments.output, console)


if __name__ == "__main__":
    main()
