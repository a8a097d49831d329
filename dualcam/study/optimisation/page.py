"""The page of results: one HTML file without script or network."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import dualcam
from dualcam.common.html_page import figure_element, page, table
from dualcam.report.inputs import USUAL
from dualcam.study.optimisation.design_files import fits_design_file
from dualcam.study.optimisation.designs import share_of
from dualcam.study.optimisation.optimum import ACTIVE, Optimum
from dualcam.study.optimisation.task import DIGITS, bounds_in_words, unit_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROWS = 12  # of the front's table; front.csv has all
WAYS = {"minimise": "less is better", "maximise": "more is better"}
METHODS = {
    "slsqp": "SLSQP with gradients by differences (scipy.optimize.minimize)",
    "evolution": "differential evolution (scipy.optimize.differential_evolution)",
    "nsga2": "NSGA-II (pymoo)",
}


def write_page(found: Optimum, path: Path, title: str) -> None:
    """Write the page of a search."""
    parts = [_verdict, _design, _constraints, _results, _front, _convergence, _next_steps, _search]
    lead = f"Optimisation, by dualcam {dualcam.__version__}"
    path.write_text(page(title, "optimum", lead, "".join(part(found) for part in parts)), encoding="utf-8")


def _numbers(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table whose cells keep their numbers in one line."""
    return f'<div class="numbers">{table(heads, rows)}</div>\n'


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.{DIGITS}g}"


def _si(found: Optimum, name: str, value: float | str) -> str:
    """A value of a name or of a formula, with the FMU's unit."""
    return f"{_number(value)} {unit_of(found.task, name)}".strip()


def _usual(found: Optimum, name: str, value: float | str) -> str:
    unit = unit_of(found.task, name)
    if unit not in USUAL or isinstance(value, str):
        return ""
    usual, factor = USUAL[unit]
    return f"{value * factor:.{DIGITS}g} {usual}"


def _kind(found: Optimum) -> str:
    """What a value of an objective or constraint is where parts differ."""
    return f", for {found.task.percentile:g} % of the parts" if found.task.is_robust else ""


def _verdict(found: Optimum) -> str:
    head = "The best design keeps all constraints."
    if not found.feasible:
        head = (
            f"None of {found.evaluated:,} designs keeps all constraints. The design below is the nearest one."
        )
    elif len(found.task.objectives) > 1:
        head = (
            f"{_front_size(found)} designs are the front: no design is better in all objectives. The design "
            "below is the one nearest to the best of each objective."
        )
    rows = [
        (text, _si(found, text, value), found.task.objectives[text] + _kind(found))
        for text, value in found.objectives.items()
    ]
    missed = "".join(f'<li class="error">{escape(text)}</li>' for text in found.violated)
    return (
        f'<p class="{"good" if found.feasible else "error"}"><b>{escape(head)}</b></p>\n'
        + (f"<ul>{missed}</ul>\n" if missed else "")
        + _numbers(("objective", "value", "wanted"), rows)
    )


def _design(found: Optimum) -> str:
    rows = [
        (name, _si(found, name, value), _usual(found, name, value), _bounds(found, name, value))
        for name, value in found.design.items()
    ]
    active = "".join(f"<li>{escape(text)}</li>" for text in found.holding)
    held = "<p>No bound and no constraint is active: the optimum lies inside.</p>\n"
    if active:
        held = f"<p>Active: a wider limit would give a better design.</p>\n<ul>{active}</ul>\n"
    idle = "".join(f"<p>{escape(text)}.</p>\n" for text in found.idle_words())
    return "<h2>Design</h2>\n" + _numbers(("value", "SI", "usual unit", "bounds"), rows) + held + idle


def _bounds(found: Optimum, name: str, value: float | str) -> str:
    if name in found.task.same_as:
        return f"same as {found.task.same_as[name]}"
    if name not in found.task.designed:
        return "follows from others"
    vary = found.task.designed[name]
    if vary.is_list:
        return bounds_in_words(found.task, name)
    share = share_of(vary, value)
    end = "lower" if share < ACTIVE else "upper" if share > 1.0 - ACTIVE else ""
    return " to ".join(map(_number, vary.limits())) + (f", at the {end} bound" if end else "")


def _constraints(found: Optimum) -> str:
    if not found.task.constraints:
        return ""
    rows = []
    for text, value in found.constraints.items():
        limits = zip(("at least", "at most"), found.task.constraints[text], strict=True)
        allowed = [f"{words} {_number(limit)}" for words, limit in limits if limit is not None]
        rows.append((text, _si(found, text, value), " and ".join(allowed)))
    return "<h2>Constraints</h2>\n" + _numbers(("constraint" + _kind(found), "value", "allowed"), rows)


def _results(found: Optimum) -> str:
    rows = [
        (name, _si(found, name, value), _usual(found, name, value)) for name, value in found.results.items()
    ]
    exact = "<p>Of a part that is exactly as designed.</p>\n" if found.task.is_robust else ""
    return "<h2>Results of this design</h2>\n" + exact + _numbers(("result", "SI", "usual unit"), rows)


def _front(found: Optimum) -> str:
    if len(found.task.objectives) == 1:
        return ""
    texts = [*found.task.objectives, *found.task.designed]
    chosen = front_rows(found)
    rows = [(str(k + 1), *(_number(found.front[text][k]) for text in texts)) for k in chosen]
    return (
        "<h2>Front</h2>\n"
        + figure_element(_front_figure(found), "Front")
        + f"<p>{len(chosen)} of {_front_size(found)} designs; front.csv has all of them.</p>\n"
        + _numbers(["design", *(_head(found, text) for text in texts)], rows)
    )


def _front_size(found: Optimum) -> int:
    return len(next(iter(found.front.values())))


def front_rows(found: Optimum) -> list[int]:
    """Places of the designs of the front that the page shows, spread over it."""
    count = _front_size(found)
    return sorted({round(place) for place in np.linspace(0, count - 1, min(ROWS, count))})


def _head(found: Optimum, text: str) -> str:
    """A name or a formula, with its unit."""
    unit = unit_of(found.task, text)
    return f"{text} [{unit}]" if unit else text


def _label(found: Optimum, text: str) -> str:
    return f"{_head(found, text)}\n{WAYS[found.task.objectives[text]]}"


def _front_figure(found: Optimum) -> Figure:
    """The first objective against each other one."""
    from matplotlib.figure import Figure

    first, *others = found.task.objectives
    figure = Figure(figsize=(5.4, 3.8 * len(others)), layout="constrained")
    for axes, other in zip(np.ravel(figure.subplots(len(others), 1)), others, strict=True):
        axes.plot(found.front[first], found.front[other], ".", color="tab:red", label="front")
        axes.plot(found.objectives[first], found.objectives[other], "o", mfc="none", mec="k", label="chosen")
        axes.set(xlabel=_label(found, first), ylabel=_label(found, other))
        axes.legend(fontsize=8)
    return figure


def _convergence(found: Optimum) -> str:
    """The best first objective, or the hypervolume of the front, over the designs evaluated."""
    from matplotlib.figure import Figure

    if len(found.history) == 0:
        return ""
    figure = Figure(figsize=(5.4, 3.2), layout="constrained")
    axes = figure.subplots()
    count, best = found.history.T
    count, best = np.append(count, found.evaluated), np.append(best, best[-1])
    axes.step(count, best, where="post", color="tab:blue")
    axes.set_xscale("log")
    label = _label(found, next(iter(found.task.objectives)))
    if len(found.task.objectives) > 1:
        label = "hypervolume of the front\nas a share of that at the end"
    axes.set(xlabel="designs evaluated", ylabel=label)
    axes.grid(alpha=0.3)
    return "<h2>Convergence</h2>\n" + figure_element(figure, "Convergence")


def _next_steps(found: Optimum) -> str:
    if not fits_design_file(found.task):
        return "<h2>Go on</h2>\n<p>designs.csv has all designs, front.csv the best ones.</p>\n"
    more = ""
    if len(found.task.objectives) > 1:
        more = "<p>front_designs has such a file for each design in the table of the front.</p>\n"
    return (
        "<h2>Go on</h2>\n<p>best.toml, beside this page, is the best design as a design file:</p>\n"
        "<pre>dualcam check best.toml\ndualcam report best.toml -o best.html\n"
        f"dualcam export best.toml -o Best.fmu</pre>\n{more}"
        "<p>designs.csv has all designs that were evaluated, front.csv the best ones.</p>\n"
    )


def _search(found: Optimum) -> str:
    task = found.task
    rows = [
        ("method", METHODS[task.method_used]),
        ("designs evaluated", f"{found.evaluated:,} of at most {task.budget:,}"),
        ("designs that miss a constraint", f"{found.infeasible - found.failed:,}"),
        ("designs that failed", f"{found.failed:,}"),
        ("seed", str(task.seed)),
    ]
    if task.is_robust:
        parts = f"{task.samples} of each design, the same deviations for all designs"
        rows += [("parts as made", parts), ("percentile", f"{task.percentile:g} %")]
        rows += [
            (f"tolerance of {name}", f"+- {each.plus_minus:g}, {each.shape}")
            for name, each in task.tolerances.items()
        ]
        rows += [(f"distribution of {name}", vary.distribution) for name, vary in task.chance.items()]
    reasons = sorted(found.messages.items(), key=lambda item: -item[1])[:3]
    rows += [(f"{count:,} failed designs", text) for text, count in reasons]
    return "<h2>Search</h2>\n" + table(("what", "value"), rows)
