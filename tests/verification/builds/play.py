"""Plays a scene in an FMU, and compares two records of it bit for bit or to a tolerance."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from ctypes import c_void_p
from dataclasses import dataclass
from itertools import zip_longest

from verification.builds.fmu import OK, Fmu, Instance, Names, Record
from verification.builds.scenes import Move, Scene, polynomial

MOST_EARLY_RETURNS = 200  # in one step
MOST_FAILURES = 3  # steps of a scene that the FMU refuses before the scene ends


@dataclass(frozen=True)
class Difference:
    """One value that is not the same in both builds."""

    scene: str
    time: float  # s
    what: str
    old: float | int | None
    new: float | int | None
    mended: bool = False  # a step that only the old build refuses

    def __str__(self) -> str:
        place = f"{self.scene}, t = {self.time:.9g} s: {self.what}"
        return f"{place}: {_shown(self.old)} -> {_shown(self.new)}" if self.old is not None else place


def _shown(value: float | int | None) -> str:
    return f"{value!r} ({value.hex()})" if isinstance(value, float) else repr(value)


# ---- playing ----


def play(fmu: Fmu, names: Names, scene: Scene) -> Record:
    """All that the FMU returns in that scene."""
    record = Record()
    instance = Instance(fmu, names, record, scene.use, events=scene.use == "early return")
    parameters = {**scene.parameters, **scene.moves[0].values}
    try:
        if scene.resets:
            instance.start(parameters, scene.tolerance)
            for move in scene.moves[:3]:
                _step(instance, scene, move)
            instance.reset()
        if not instance.enter(parameters, scene.tolerance):
            return record
        if scene.probes:
            _probe(instance)
        if not instance.leave():
            return record
        _read_all(instance)
        if scene.use == "exchange":
            _exchange(instance, scene)
        else:
            _co_simulate(instance, scene)
        if scene.probes:
            _probe(instance)
    finally:
        instance.free()
    return record


def _probe(instance: Instance) -> None:
    """Every real variable, and every derivative of one by another: most pairs are refused."""
    reals = [name for name, variable in instance.fmu.variables.items() if variable.kind == "Real"]
    instance.read()
    for known in reals:
        for unknown in reals:
            instance.read_derivatives((unknown,), known)


def _read_all(instance: Instance) -> None:
    instance.read()
    instance.read_step()
    instance.read_output_derivatives()
    instance.read_jacobian()


def _co_simulate(instance: Instance, scene: Scene) -> None:
    kept: tuple[c_void_p, float] | None = None
    failures = 0
    for number, move in enumerate(scene.moves, start=1):
        if move.state == "keep":
            kept = instance.take_state(), instance.time
        elif move.state and kept is not None:
            state, time = kept
            instance.restore_state(state if move.state == "restore" else instance.copy_state(state), time)
        failures += not _step(instance, scene, move)
        if failures > MOST_FAILURES:
            break
        last = number == len(scene.moves)
        if last or number % scene.read_every == 0:
            instance.read()
        if last or number % scene.read_most_every == 0:
            instance.read_step()
            instance.read_output_derivatives()
            instance.read_jacobian()


def _step(instance: Instance, scene: Scene, move: Move) -> bool:
    """False if the FMU refuses."""
    if scene.use != "early return":
        instance.set(move.values)
        instance.set_derivatives(move.derivatives)
        return instance.step(move.length)
    start, end = instance.time, instance.time + move.length
    inputs = {n: [v, *move.derivatives.get(n, ())] for n, v in move.values.items() if isinstance(v, float)}

    def input_at(time: float) -> Mapping[str, float]:
        return {name: polynomial(u, time - start)[0] for name, u in inputs.items()}

    instance.input_at = input_at
    for _ in range(MOST_EARLY_RETURNS):
        if not end - instance.time > 1e-12 * end:
            return True
        instance.set(dict(input_at(instance.time)))
        if not instance.step(end - instance.time):
            return False
        instance.read()
        instance.read_step()
    return True


def _exchange(instance: Instance, scene: Scene) -> None:
    states, indicators = instance.names.states, instance.names.indicators
    rates = "GetDerivatives" if instance.fmu.version == 2 else "GetContinuousStateDerivatives"
    for number, move in enumerate(scene.moves, start=1):
        instance.set(move.values)
        x = instance.vector("GetContinuousStates", states, "states")
        f = instance.vector(rates, states, "derivatives")
        instance.vector("GetEventIndicators", indicators, "indicators")
        euler = [a + move.length * b for a, b in zip(x, f, strict=True)]
        instance.set_continuous(instance.time + move.length, move.states or euler)
        instance.read()
        instance.vector(rates, states, "derivatives")
        instance.vector("GetEventIndicators", indicators, "indicators")
        if instance.completed_step() or number % 7 == 0:
            if instance.call("EnterEventMode") == OK:
                instance.settle()
            instance.vector("GetContinuousStates", states, "states")
        if number % scene.read_most_every == 0:
            instance.read()
            instance.read_jacobian()


# ---- comparing ----


def _unpack(record: Record, what: str, data: bytes) -> Iterator[tuple[str, float | int]]:
    labels, kind = record.labels[what]
    return zip(labels, struct.unpack(f"{len(labels)}{kind}", data), strict=True)


def _scales(records: tuple[Record, Record]) -> dict[tuple[str, str], float]:
    """Largest finite value of each variable in the scene; the accounts of energy share theirs."""
    found: dict[tuple[str, str], float] = {}
    for record in records:
        for _, what, data in record.rows:
            for label, value in _unpack(record, what, data):
                key = what, _scale_name(label)
                if math.isfinite(value):
                    found[key] = max(found.get(key, 0.0), abs(value))
    return found


def _scale_name(label: str) -> str:
    return "energy" if label.startswith("energy.") else label


def compare(title: str, old: Record, new: Record, tolerance: float = 0.0) -> list[Difference]:
    """All values that differ: in any bit, or by more than `tolerance` of the variable's largest value in the
    scene. Whole numbers have to be equal in any case. Behind a step that only the old build refuses, and
    behind calls that are not the same, nothing more is compared."""
    if old.rows == new.rows:
        return []
    scales = _scales((old, new)) if tolerance else {}
    found = []
    for index, (before, after) in enumerate(zip_longest(old.rows, new.rows)):
        if before is None or after is None or before[1] != after[1]:
            time = (before or after or (math.nan,))[0]
            names = [row[1] if row else "nothing" for row in (before, after)]
            found.append(Difference(title, time, f"the order of calls: {names[0]} -> {names[1]}", None, None))
            break
        time, what, data = before
        if data == after[2] and (time == after[0] or tolerance):
            continue
        refusal = old.refusals.get(index, "")
        if what.endswith("DoStep") and refusal and index not in new.refusals:
            found.append(Difference(title, time, f"only the old build refuses: {refusal}", None, None, True))
            break
        if data == after[2]:
            found.append(Difference(title, time, f"{what}: time", time, after[0]))
            continue
        pairs = zip(_unpack(old, what, data), _unpack(new, what, after[2]), strict=True)
        for (label, a), (_, b) in pairs:
            if not _same(a, b, tolerance * scales.get((what, _scale_name(label)), 0.0)):
                found.append(Difference(title, time, f"{label} ({what})", a, b))
    return found


def _same(a: float | int, b: float | int, allowed: float) -> bool:
    if isinstance(a, int) or isinstance(b, int):
        return a == b
    if struct.pack("d", a) == struct.pack("d", b):
        return True
    return allowed > 0.0 and (abs(a - b) <= allowed or (math.isnan(a) and math.isnan(b)))
