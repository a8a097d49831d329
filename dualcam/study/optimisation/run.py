"""The whole of an optimisation: search, record, optimum."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from dualcam.common.entries import is_whole
from dualcam.common.mistakes import StudyError
from dualcam.fmi.library import source_path
from dualcam.fmi.reals import Array
from dualcam.study.optimisation import evolution, gradient
from dualcam.study.optimisation.designs import FmuRuns
from dualcam.study.optimisation.evaluation import DesignEvaluator, EvaluatedDesigns
from dualcam.study.optimisation.optimum import ACTIVE, Optimum, unbeaten
from dualcam.study.optimisation.record import Record
from dualcam.study.optimisation.search import BudgetSpent, Search
from dualcam.study.optimisation.task import NUMBERS, Optimisation, in_words

if TYPE_CHECKING:
    from distributed import Client

RUNS = {"slsqp": gradient.run, "evolution": evolution.differential_evolution, "nsga2": evolution.nsga2}
CHECKS = 40  # of the front's hypervolume over the search
STATE = ("feasible", "message")  # of a design, beside its values
BEYOND = 1.01  # reference point of the hypervolume, in extents of the front from its best corner


def optimise(
    task: Optimisation,
    folder: str | Path | None = None,
    workers: int = 0,
    scheduler: str | Client | None = None,
    console: Console | None = None,
) -> Optimum:
    """Search for the best design.

    Parameters
    ----------
    task : What is wanted.
    folder : str or Path, optional
        Folder of the results. A search that was interrupted continues there: no design is evaluated twice,
        and the end is that of an uninterrupted search, bit for bit.
    workers : int
        Processes that share the runs of a batch. 0: all in this process. Values do not depend on `workers`.
    scheduler : Dask workers are used instead, for runs of an FMU: address of the scheduler, or a client.
    console : Shows the progress.

    Returns
    -------
    Optimum
        The best design found. Its `feasible` says whether it keeps all constraints.

    Raises
    ------
    StudyError
        The task cannot be done, or no design could be evaluated; the message says why.

    Examples
    --------
    >>> from dualcam.study import FmuRuns, Optimisation, Scenario, Vary, optimise
    >>> angles = {"cam1.lead_angle": Vary(0.4, 1.2), "cam2.lead_angle": Vary(0.4, 1.2)}  # rad
    >>> model = FmuRuns("forward", Scenario(0.001))
    >>> best = optimise(Optimisation(model, angles, {"efficiency": "maximise"}, method="slsqp"))
    >>> round(best.design["cam1.lead_angle"], 4), round(best.objectives["efficiency"], 4)  # pi/4
    (0.7854, 0.5691)
    """
    if not is_whole(workers) or workers < 0:
        raise StudyError(f"workers = {workers!r}: allowed is a whole number, 0 or more")
    packages = ["numpy", "scipy"]
    if task.method_used == "nsga2":
        evolution.pymoo_classes()
        packages.append("pymoo")
    place = None if folder is None else Path(folder)
    with closing(DesignEvaluator(task, workers, scheduler)) as evaluator:
        record = Record(place, facts(task), {name: version(name) for name in packages})
        with closing(record), _progress(console, task, record.resumed) as on_batch:
            search = Search(evaluator, record, on_batch)
            with suppress(BudgetSpent):
                RUNS[task.method_used](search)
        return _optimum(search, place)


def facts(task: Optimisation) -> dict[str, Any]:
    """What makes two searches the same, plain data."""
    model = task.model
    described: dict[str, Any] | str
    if isinstance(model, FmuRuns):
        described = {
            "fmu": hashlib.sha256(source_path(model.fmu).read_bytes()).hexdigest(),
            "scenario": model.scenario.facts(),
            "parameters": dict(model.parameters),
            "derived": dict(model.derived),
            "conditions": dict(model.conditions),
        }
    else:
        described = f"{model.__module__}.{getattr(model, '__qualname__', type(model).__qualname__)}"
    return {
        "model": described,
        "vary": {name: vary.facts() for name, vary in task.vary.items()},
        "constraints": {text: list(limits) for text, limits in task.constraints.items()},
        "tolerances": {name: [each.plus_minus, each.shape] for name, each in task.tolerances.items()},
        "correlations": [[each.first, each.second, each.value, each.kind] for each in task.correlations],
        "results": list(task.results),
        **{name: dict(getattr(task, name)) for name in ("objectives", "start", "same_as")},
        **{name: getattr(task, name) for name in NUMBERS},
    }


def _optimum(search: Search, folder: Path | None) -> Optimum:
    task, evaluator = search.task, search.evaluator
    whole = EvaluatedDesigns.joined(search.batches)
    messages = Counter(whole.messages.values())
    if search.best is None:
        first = messages.most_common(1)[0][0]
        raise StudyError(f"none of {search.count} designs could be evaluated, most of them because: {first}")
    fit = np.array([place for place in range(search.count) if search.feasible(place)], np.intp)
    losses = np.array(search.losses)
    places = fit[unbeaten(losses[fit])] if len(fit) else np.array([search.best])
    if len(task.objectives) == 1:
        places = np.array([search.best])
    best = int(places[_nearest(losses[places])])
    designs = _designs(search, whole)
    return Optimum(
        task=task,
        design=evaluator.design(whole.shares[best]),
        results=dict(zip(task.columns, whole.results[best].tolist(), strict=True)),
        objectives=dict(zip(task.objectives, whole.objectives[best].tolist(), strict=True)),
        constraints=_nearer(search, whole.constraints[best], search.excess[best]),
        feasible=len(fit) > 0,
        active=[*_active_bounds(task, whole.shares[best]), *_active_limits(search, best)],
        violated=_violated(search, whole.constraints[best], search.excess[best]),
        front={name: column[places] for name, column in designs.items() if name not in STATE},
        designs=designs,
        history=_history(search, losses, fit),
        evaluated=search.count,
        infeasible=search.count - len(fit),
        failed=search.failed,
        messages=dict(messages),
        folder=folder,
    )


def _history(search: Search, losses: Array, fit: NDArray[np.intp]) -> Array:
    """Designs evaluated, and how good the best ones are."""
    if len(search.task.objectives) == 1:
        sign = search.task.signs[0]
        return np.array([(count, loss * sign) for count, loss in search.history], float).reshape(-1, 2)
    if len(fit) == 0:
        return np.empty((0, 2))
    front = losses[fit[unbeaten(losses[fit])]]
    worst, best = front.max(axis=0), front.min(axis=0)
    extent = np.where(worst > best, worst - best, 1.0)
    counts = np.unique(np.linspace(fit[0] + 1, search.count, CHECKS).round().astype(int))
    volumes = []
    for count in counts:
        scaled = (losses[fit[fit < count]] - best) / extent
        volumes.append(evolution.hypervolume(scaled[np.all(scaled <= 1.0, axis=1)], BEYOND))
    return np.column_stack([counts, np.array(volumes) / volumes[-1]])


def _designs(search: Search, whole: EvaluatedDesigns) -> dict[str, Any]:
    """All designs, as columns."""
    task, plan = search.task, search.evaluator.plan
    rows = search.evaluator.rows(whole.shares)
    columns: dict[str, Any] = {name: rows[:, plan.names.index(name)] for name in search.evaluator.chosen}
    for name, texts in plan.texts.items():
        columns[name] = np.array([texts[int(place)] for place in columns[name]], dtype=object)
    columns |= {name: whole.results[:, k] for k, name in enumerate(task.columns)}
    columns |= {text: whole.objectives[:, k] for k, text in enumerate(task.objectives)}
    columns[STATE[0]] = np.array([int(search.feasible(place)) for place in range(search.count)])
    messages = [whole.messages.get(place, "") for place in range(search.count)]
    return columns | {STATE[1]: np.array(messages, dtype=object)}


def _nearest(losses: Array) -> int:
    """Of a front the design that is nearest to the best of each objective, as shares of the extents."""
    low, extent = losses.min(axis=0), np.ptp(losses, axis=0)
    return int(np.argmin(np.sum(((losses - low) / np.where(extent > 0.0, extent, 1.0)) ** 2, axis=1)))


def _nearer(search: Search, values: Array, excess: Array) -> dict[str, float]:
    """Of each constraint the value that is nearer to its limit."""
    found: dict[str, float] = {}
    nearest: dict[str, float] = {}
    for place, (text, _, _) in enumerate(search.evaluator.limits):
        if excess[place] > nearest.get(text, -np.inf):
            nearest[text], found[text] = excess[place], float(values[place])
    return found


def _active_bounds(task: Optimisation, shares: Array) -> list[str]:
    found = []
    for share, (name, vary) in zip(shares, task.designed.items(), strict=True):
        if vary.is_list:
            continue
        low, high = vary.limits()
        if share < ACTIVE:
            found.append(f"{name} is at its lower bound, {in_words(task, name, low)}")
        if share > 1.0 - ACTIVE:
            found.append(f"{name} is at its upper bound, {in_words(task, name, high)}")
    return found


def _active_limits(search: Search, best: int) -> list[str]:
    task = search.task
    return [
        f"{text} is at its {'greatest' if sign > 0.0 else 'least'} value, {in_words(task, text, limit)}"
        for (text, sign, limit), missed in zip(search.evaluator.limits, search.excess[best], strict=True)
        if abs(missed) < ACTIVE
    ]


def _violated(search: Search, values: Array, excess: Array) -> list[str]:
    task = search.task
    return [
        f"{text} = {in_words(task, text, value)}: allowed is {'at most' if sign > 0.0 else 'at least'} "
        f"{in_words(task, text, limit)}, which it misses by {in_words(task, text, abs(value - limit), 3)}"
        for (text, sign, limit), value, missed in zip(search.evaluator.limits, values, excess, strict=True)
        if missed > 1e-6
    ]


@contextmanager
def _progress(
    console: Console | None, task: Optimisation, resumed: int
) -> Iterator[Callable[[Search], None]]:
    if console is None:
        yield lambda search: None
        return
    text = TextColumn("{task.completed:,.0f} of {task.total:,.0f} designs, {task.fields[best]}")
    with Progress(BarColumn(), text, TimeRemainingColumn(), console=console) as progress:
        row = progress.add_task("designs", total=task.budget, best="")

        def advance(search: Search) -> None:
            progress.update(row, completed=search.count, best=_best_words(search))

        yield advance


def _best_words(search: Search) -> str:
    if search.best is None:
        return f"{search.failed:,} failed"
    if not search.feasible(search.best):
        return "none keeps all constraints yet"
    loss = float(search.losses[search.best][0])
    return f"{next(iter(search.task.objectives))} = {search.task.signs[0] * loss:.6g}"
