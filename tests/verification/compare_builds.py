"""Do two builds of the FMUs compute the same, bit for bit?

    ./build.sh run compare OLD_DIRECTORY [NEW_DIRECTORY]

Each directory holds DualCamForward.fmu, DualCamInverse.fmu and fmi3/ with both again, as `./build.sh` leaves
them in build/, the default for the new ones. The drivers of the tests play the same random scenes in both.
All variables and derivatives are compared after each step, and which scenes are refused. Neither messages nor
the bytes of FMU states are compared. Exit code 1: something differs. Linux x86-64.
"""

from __future__ import annotations

import argparse
import itertools
import math
import sys
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from ctypes import c_double
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import driver3
import numpy as np

from benchmarks.harness.oracles import Interval, driver, reference
from benchmarks.harness.repository import ROOT

Rng = np.random.Generator
Values = dict[str, Any]
FORWARD, INVERSE = "DualCamForward", "DualCamInverse"
FORWARD_ONLY = ("initial.", "stop.restitution")  # parameters that the inverse FMU has not
TOLERANCES = (1e-4, 1e-6, 1e-9, 1e-11)
MOST_STEPS = 40  # of a scene
LISTED = 5  # differences that are shown, and variables
REFUSED = "only one build refuses the step"


# ---- scenes ----


@dataclass(frozen=True)
class Step:
    """One communication step."""

    length: float  # s
    values: Values  # set before the step
    derivatives: Mapping[str, Sequence[float]] = field(default_factory=dict)  # of inputs, by time
    goes_back: bool = False  # to the state that the first step found


@dataclass(frozen=True)
class Scene:
    title: str
    parameters: Values
    steps: Sequence[Step]
    tolerance: float | None = None
    model: str = FORWARD
    version: int = 2
    exchange: bool = False  # model exchange, at states drawn between the stops


def steps_of(rng: Rng, intervals: Iterable[Interval]) -> list[Step]:
    """The intervals whole, in some parts, or in many."""
    found = []
    for interval in intervals:
        cuts = np.sort(rng.uniform(0.0, interval.duration, rng.choice([0, 0, 1, 4, 11]))).tolist()
        for start, end in itertools.pairwise([0.0, *cuts, interval.duration]):
            inputs = {name: interval.at(name, start) for name in ("tau", "F_ext")}
            rates = {name: u[1:] for name, u in inputs.items() if any(u[1:])}
            found.append(Step(end - start, {name: u[0] for name, u in inputs.items()}, rates))
    return found[:MOST_STEPS]


def changed(rng: Rng, parameters: Values, steps: Sequence[Step]) -> list[Step]:
    """The same steps with a tunable parameter changed on the way, and the state restored."""
    tunable = [n for n, v in parameters.items() if n.startswith(("spring.", "damper.")) and v]
    found = list(steps)
    for place in rng.integers(1, len(found) + 1, 2).tolist():
        if place < len(found):
            name = str(rng.choice(["cam1.friction", "cam2.friction", *tunable]))
            tuned = {name: float(parameters[name]) * rng.uniform(0.6, 1.2)}
            found[place] = replace(found[place], values=found[place].values | tuned, goes_back=True)
    return found


def random_scene(number: int, folder: Path, helical: bool) -> Scene:
    rng = np.random.default_rng([int(helical), number])
    p, intervals = reference.random_scene(rng) if helical else reference.random_general_scene(rng, folder)
    p["ledger"] = bool(rng.random() < 0.85)
    steps = steps_of(rng, intervals)
    if rng.random() < 0.4:
        steps = changed(rng, p, steps)
    tolerance = None if rng.random() < 0.3 else float(rng.choice(TOLERANCES))
    return Scene(f"{'helices' if helical else 'grooves'} {number}", p, steps, tolerance)


def groove_scene(number: int, folder: Path) -> Scene:
    return random_scene(number, folder, helical=False)


def inverse_scene(number: int, folder: Path) -> Scene:
    """An imposed swing between the stops or slightly beyond; the shaft rigid or elastic."""
    rng = np.random.default_rng([3, number])
    scene = random_scene(number, folder, bool(number % 2))
    p = {name: value for name, value in scene.parameters.items() if not name.startswith(FORWARD_ONLY)}
    lower, upper = p.get("stop.lower", 0.0), p.get("stop.upper", 1.3963)
    p["shaft.stiffness"] = float(rng.choice([0.0, 10.0 ** rng.uniform(1.0, 4.0)]))
    rate, middle, swing = rng.uniform(1.0, 100.0), 0.5 * (lower + upper), 0.5 * (upper - lower)
    swing *= rng.uniform(0.1, 1.02)
    steps = []
    for t in np.arange(0.0, 6.0, 0.2) / rate:
        wave = [swing * rate**k * math.sin(rate * t + k * math.pi / 2) for k in range(6)]
        wave[0] += middle
        values = dict(zip(("theta", "omega", "alpha"), wave, strict=False))
        rates = {"theta": wave[1:4], "omega": wave[2:5], "alpha": wave[3:6]} if number % 3 else {}
        steps.append(Step(0.2 / rate, values, rates))
    return Scene(f"inverse {number}", p, steps, scene.tolerance, INVERSE)


def version_3_scene(number: int, folder: Path) -> Scene:
    """FMI 3.0 has no derivatives of inputs."""
    scene = inverse_scene(number, folder) if number % 4 == 3 else groove_scene(number, folder)
    steps = [replace(step, derivatives={}) for step in scene.steps]
    return replace(scene, title=f"FMI 3.0, {scene.title}", steps=steps, version=3)


def exchange_scene(number: int, folder: Path) -> Scene:
    scene = groove_scene(number, folder)
    return replace(scene, title=f"exchange, {scene.title}", exchange=True)


def refused_scene(number: int, folder: Path) -> Scene:
    """One value that is not allowed, at the start or in the third step."""
    rng = np.random.default_rng([4, number])
    scene = groove_scene(number, folder)
    bad = float(rng.choice([math.nan, math.inf, -1.0, 1e300]))
    name = str(rng.choice([n for n, v in scene.parameters.items() if isinstance(v, float)]))
    wrong = {name: bad} if number % 2 else {"tau": bad}
    steps = list(scene.steps)
    steps[2:3] = [replace(steps[2], values=steps[2].values | wrong)]
    return replace(scene, title=f"{name} = {bad}, {scene.title}", steps=steps)


# ---- playing ----


class Build:
    """The FMUs of a folder, by model and version of FMI."""

    def __init__(self, directory: Path, folder: Path) -> None:
        self.fmus: dict[tuple[str, int], tuple[Any, Any]] = {}
        for name, (version, kind) in itertools.product((FORWARD, INVERSE), ((2, driver), (3, driver3))):
            place = folder / f"{name}-{version}"
            model = kind.Model(name)
            with zipfile.ZipFile(path_of(directory, name, version)) as archive:
                archive.extractall(place)
            model.xml = place / "modelDescription.xml"
            platform = "linux64" if version == 2 else "x86_64-linux"
            self.fmus[name, version] = model, kind.load(place / "binaries" / platform / f"{name}.so")

    def start(self, scene: Scene) -> Any:
        model, library = self.fmus[scene.model, scene.version]
        if scene.version == 3:
            return driver3.Driver(library, model=model)
        kind = driver.MODEL_EXCHANGE if scene.exchange else driver.CO_SIMULATION
        return driver.Driver(library, kind=kind, model=model)


def path_of(directory: Path, name: str, version: int) -> Path:
    return directory / ("fmi3" if version == 3 else "") / f"{name}.fmu"


def all_values(fmu: Any) -> Values:
    """Of all variables, in few calls."""
    names = fmu.model.names(causality=["output", "local"])
    values: Values = {}
    for key, some in itertools.groupby(sorted(names, key=kind_of(fmu)), kind_of(fmu)):
        group = list(some)
        status, found = fmu.try_get(group)
        shown = [value.hex() if isinstance(value, float) else value for value in found]
        values |= dict(zip(group, shown, strict=True)) if status == driver.OK else {str(key): "refused"}
    return values


def kind_of(fmu: Any) -> Callable[[str], tuple[str, bool]]:
    """Type of a variable, and whether it is a derivative of the latest step."""
    return lambda name: (fmu.variables[name].type, name.startswith("step."))


def seen(fmu: Any) -> Values:
    """All variables, and derivatives of the outputs by time and by the inputs."""
    values = all_values(fmu)
    outputs = fmu.model.names(causality=["output"])
    for order in (1, 2):
        values |= {f"{n}, derivative {order}": fmu.output_derivative(n, order).hex() for n in outputs}
    if fmu.PREFIX == "fmi2":
        for known in fmu.model.names(causality=["input"]):
            slopes, known_reference = (c_double * len(outputs))(), fmu.model.references([known])
            unknowns = fmu.model.references(outputs), len(outputs)
            fmu.ok("GetDirectionalDerivative", *unknowns, known_reference, 1, (c_double * 1)(1.0), slopes)
            values |= {f"{n} by {known}": s.hex() for n, s in zip(outputs, slopes, strict=True)}
    return values


def play(build: Build, scene: Scene) -> list[Values]:
    """What each communication point shows; the last one says where the FMU has refused a call."""
    record: list[Values] = []
    fmu = build.start(scene)
    try:
        first = scene.parameters | (scene.steps[0].values if scene.steps else {})
        fmu.start(first, tolerance=scene.tolerance)
        exchange(fmu, scene, record) if scene.exchange else co_simulate(fmu, scene, record)
    except AssertionError:
        record.append({REFUSED: True})
    finally:
        fmu.free()
    return record


def co_simulate(fmu: Any, scene: Scene, record: list[Values]) -> None:
    record.append(seen(fmu))
    first, start = fmu.take(), fmu.time
    for step in scene.steps:
        if step.goes_back:
            fmu.restore(first)
            fmu.time = start
        fmu.set(step.values)
        if step.derivatives:
            fmu.set_derivatives(step.derivatives)
        fmu.step(step.length)
        record.append(seen(fmu))


def exchange(fmu: Any, scene: Scene, record: list[Values]) -> None:
    rng = np.random.default_rng(5)
    lower, upper = scene.parameters.get("stop.lower", 0.0), scene.parameters.get("stop.upper", 1.3963)
    indicators = int(fmu.model.document.attrib["numberOfEventIndicators"])
    fmu.settle()
    for step in scene.steps:
        fmu.set(step.values)
        fmu.set_vector("SetContinuousStates", [rng.uniform(lower, upper), rng.choice([-1.0, 0.0, 1.0])])
        rates, borders = fmu.vector("GetDerivatives", 2), fmu.vector("GetEventIndicators", indicators)
        shown = {f"number {k}": value.hex() for k, value in enumerate((*rates, *borders))}
        record.append(all_values(fmu) | shown)
        fmu.ok("EnterEventMode")
        fmu.settle()


# ---- comparing ----


def number(value: Any) -> float:
    return float.fromhex(value) if isinstance(value, str) and "0x" in value else math.nan


def differences(old: Sequence[Values], new: Sequence[Values], tolerance: float) -> list[tuple[str, str]]:
    """Variable and words of each value that is not the same. `tolerance`: share of the variable's largest
    value that a difference may have."""
    found = []
    largest: dict[str, float] = {}
    for point in (*old, *new) if tolerance else ():
        for name, value in point.items():
            size = abs(number(value))
            largest[name] = max(largest.get(name, 0.0), size if math.isfinite(size) else 0.0)
    nothing: Values = {}
    for k, (before, after) in enumerate(itertools.zip_longest(old, new, fillvalue=nothing)):
        common = sorted(before.keys() & after.keys())
        if not common:
            found.append((REFUSED, f"point {k}: {REFUSED}"))
        for name in common:
            a, b = before[name], after[name]
            if a != b and not (tolerance and abs(number(a) - number(b)) <= tolerance * largest[name]):
                found.append((name, f"point {k}: {name}: {a} -> {b}"))
    return found


@dataclass(frozen=True)
class Group:
    title: str
    count: int
    make: Callable[[int, Path], Scene]


def groups(count: int, share: float) -> list[Group]:
    def part(number: int) -> int:
        return max(1, round(share * number))

    return [
        Group("random helices", count, lambda k, folder: random_scene(k, folder, True)),
        Group("random grooves", count // 3, groove_scene),
        Group("inverse", part(300), inverse_scene),
        Group("model exchange", part(220), exchange_scene),
        Group("FMI 3.0", part(220), version_3_scene),
        Group("refused values", part(220), refused_scene),
    ]


def compare(group: Group, old: Build, new: Build, folder: Path, tolerance: float) -> int:
    """Plays the scenes of a group in both builds, and tells the number of differences."""
    shown: list[str] = []
    variables: Counter[str] = Counter()
    points = 0
    for k in range(group.count):
        scene = group.make(k, folder)
        before, after = play(old, scene), play(new, scene)
        points += len(before)
        found = differences(before, after, tolerance)
        variables.update(name for name, _ in found)
        shown += [f"{scene.title}, {words}" for _, words in found[:2]]
    total = variables.total()
    print(f"{group.title:20}{group.count:6} scenes{points:8} points{total:8} differences", flush=True)
    for line in shown[:LISTED]:
        print(f"    {line}")
    if variables:
        often = ", ".join(f"{name} {count}" for name, count in variables.most_common(LISTED))
        print(f"    most often: {often}")
    return total


def main(arguments: Sequence[str] | None = None) -> int:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("old", type=Path, help="directory of the old build")
    parser.add_argument("new", type=Path, nargs="?", default=ROOT / "build", help="default: build")
    parser.add_argument("--quick", action="store_true", help="a tenth of the scenes")
    parser.add_argument("--count", type=int, default=1000, help="random scenes with helices (1000)")
    parser.add_argument("--only", default="", help="only groups with this text in their title")
    words = "a difference up to this part of the variable's largest value in the scene is none"
    parser.add_argument("--tolerance", type=float, default=0.0, metavar="REL", help=words)
    given = parser.parse_args(arguments)
    for directory in (given.old, given.new):
        for name, version in itertools.product((FORWARD, INVERSE), (2, 3)):
            if not path_of(directory, name, version).exists():
                path = path_of(directory, name, version)
                parser.error(f"{path} is missing: run ./build.sh in the tree of that build")
    begin, share = time.perf_counter(), 0.1 if given.quick else 1.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        old, new = Build(given.old, folder / "old"), Build(given.new, folder / "new")
        chosen = [group for group in groups(round(share * given.count), share) if given.only in group.title]
        total = sum(compare(group, old, new, folder, given.tolerance) for group in chosen)
    print(f"{total} differences, {time.perf_counter() - begin:.0f} s")
    return int(total > 0)


if __name__ == "__main__":
    sys.exit(main())
