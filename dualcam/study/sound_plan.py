"""What can be known of a plan of which some parts are refused."""

from __future__ import annotations

from collections.abc import Iterable
from graphlib import TopologicalSorter

from dualcam.study.plan import Plan
from dualcam.study.problem import Findings, Place, StudyError
from dualcam.study.sampling.formula import CONSTANTS, formula
from dualcam.study.sampling.vary import Vary

STAND_IN = Vary(0.0, 1.0, count=2)  # for values that are refused, so that the rest can be checked
RUNS = 1000  # where the arrangement of the runs is refused


def place_of(plan: Plan, name: str) -> Place:
    """Where the values of a name stand."""
    return "plan", "derived" if name in plan.derived else "vary", name


def is_sound_name(plan: Plan, name: str, findings: Findings) -> bool:
    """Whether the values of a name are known."""
    return name in plan.names and findings.is_sound(*place_of(plan, name))


def sound_plan(plan: Plan, findings: Findings) -> Plan | None:
    """The plan itself if nothing is wrong with it; else one of its sound parts.

    The other one has all names, with a stand-in for each whose values are refused, and runs at random where
    the arrangement is refused. None: nothing varies."""
    if findings.is_sound("plan"):
        return plan
    names = [name for name in dict.fromkeys(plan.names) if name not in CONSTANTS]
    if not names:
        return None
    _spoil_derived(plan, findings)
    vary = {
        name: plan.vary[name] if name in plan.vary and findings.is_sound("plan", "vary", name) else STAND_IN
        for name in names
    }
    same_as = {name: other for name, other in plan.same_as.items() if _is_sound_same(plan, name, findings)}
    derived = {
        name: text for name, text in plan.derived.items() if findings.is_sound("plan", "derived", name)
    }
    vary = {name: each for name, each in vary.items() if name not in same_as and name not in derived}
    constraints = _constraints(plan, findings)
    try:
        if plan.kind == "table" and findings.is_sound("plan", "table"):
            return Plan("table", vary, table=plan.table, same_as=same_as, derived=derived)
        if all(findings.is_sound("plan", key) for key in ("kind", "runs", "levels", "correlation")):
            seed = plan.seed if findings.is_sound("plan", "seed") else 0
            parts = (None, same_as, derived, constraints, "mark", plan.correlations)
            return Plan(plan.kind, vary, plan.runs, seed, *parts, bool(plan.second_order), plan.levels)
        return Plan("random", vary, RUNS, 0, None, same_as, derived, constraints, "mark")
    except StudyError:  # parts that are sound alone
        return Plan("random", dict.fromkeys(names, STAND_IN), RUNS)


def _is_sound_same(plan: Plan, name: str, findings: Findings) -> bool:
    return findings.is_sound("plan", "vary", name) and plan.same_as[name] in plan.vary


def _spoil_derived(plan: Plan, findings: Findings) -> None:
    """Marks derived values that follow from refused ones; in the order in which they follow."""
    uses = {
        name: formula(text).names
        for name, text in plan.derived.items()
        if findings.is_sound("plan", "derived", name)
    }
    for name in TopologicalSorter(uses).static_order():
        if name in uses and not all(_is_known(plan, other, findings) for other in uses[name]):
            findings.spoil("plan", "derived", name)


def _is_known(plan: Plan, name: str, findings: Findings) -> bool:
    source = plan.same_as.get(name, name)
    return is_sound_name(plan, name, findings) and is_sound_name(plan, source, findings)


def _constraints(plan: Plan, findings: Findings) -> dict[str, str]:
    """Those whose names have known values."""
    return {
        name: text
        for name, text in plan.constraints.items()
        if findings.is_sound("plan", "constraints", name)
        and all(_is_known(plan, other, findings) for other in formula(text).names)
    }


def names_known(plan: Plan, names: Iterable[str], findings: Findings) -> bool:
    """Whether the values of all these names are known."""
    return all(_is_known(plan, name, findings) for name in names)
