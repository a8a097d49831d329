"""A scene, the trace of the FMU through it, and the verdict of its judge."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from benchmarks.harness.oracles import Interval, driver, reference

DEFAULT_TOLERANCE = 1e-9
MOTION = ("theta", "omega")
ACCOUNTS = ("work_in", "work_ext", "spring", "kinetic", *reference.HEATS)
COMPARED = (*MOTION, *(f"energy.{name}" for name in ACCOUNTS))
REALS = driver.FORWARD.names(type=["Real"])
Params = dict[str, Any]


@dataclass(frozen=True)
class Scene:
    row: str
    params: Params
    intervals: list[Interval]
    judge: str = "laws"  # or "simulate", "exact", "radau", "limit", "cuts": see judges.py
    label: str = ""
    tolerance: float | None = None
    steps: int = 1  # equal communication steps per interval
    general: bool = False  # with the FMU compiled without closed forms
    instead: Params | None = None  # parameters of the reference, where they differ
    slack: float = 0.0  # error of a limit, relative
    compared: tuple[str, ...] = COMPARED
    points: list[Any] | None = None  # solved already

    @property
    def allowed(self) -> float:
        return 10.0 * (self.tolerance or DEFAULT_TOLERANCE) + self.slack


@dataclass
class Trace:
    """A run of the FMU: the outputs after each interval, the largest sizes, the cost and the broken laws."""

    read: list[dict[str, float]] = field(default_factory=list)
    largest: dict[str, float] = field(default_factory=dict)
    turnover: float = 0.0  # J, the largest torque times the angle between the stops
    residual: float = 0.0  # relative to the largest account
    step: float = 0.0  # longest doStep, s
    total: float = 0.0  # all doSteps, s
    simulated: float = 0.0
    refusal: str = ""
    problems: list[str] = field(default_factory=list)


@dataclass
class Verdict:
    error: float = math.nan
    residual: float = 0.0
    step: float = 0.0
    rate: float = 0.0  # s per simulated s
    refusal: str = ""
    problems: list[str] = field(default_factory=list)
    judged: bool = False  # by more than the laws
    note: str = ""
