"""The page of results: one HTML file without script or network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import dualcam
from dualcam.common.html_page import figure_element, page, table
from dualcam.report.inputs import USUAL
from dualcam.study.optimisation.design_files import fits_design_file
from dualcam.study.optimisation.fields import share_of
from dualcam.study.optimisation.optimum import ACTIVE, Optimum
from dualcam.study.optimisation.units import DIGITS, shown_bounds, unit_of, units_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROWS = 12  # of the front's table; front.csv has all
WAYS = {"minimise": "less is better", "maximise": "more is better"}
METHODS = {
    "slsqp": "SLSQP with gradients by differences (scipy.optimize.minimize)",
    "evolution": "differential evolution (scipy.optimize.differential_evolution)",
    "nsga2": "NSGA-II (pymoo)",
}


def write_page(found: Optimum, path: Path, title: str) -> Path:
    """Write the page of a search."""
    path.write_text(page_text(found, title), encoding="utf-8")
    return path


def page_text(found: Optimum, title: str) -> str:
    """The page."""
    units = units_of(found.task)
    sections = [
        _verdict(found, units),
        _design(found, units),
        _constraints(found, units),
        _results(found, units),
    ]
    if len(found.task.objectives) > 1:
        sections.append(_front(found, units))
    sections += [_convergence(found, units), _next_steps(found), _search(found)]
    lead = f"Optimisation, by dualcam {dualcam.__version__}"
    return page(title, "optimum", lead, "".join(sections))


def _numbers(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table whose cells keep their numbers in one line."""
    return f'<div class="numbers">{table(heads, rows)}</div>\n'


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.{DIGITS}g}"


def _usual(value: float | str, unit: str) -> str:
    if unit not in USUAL or isinstance(value, str):
        return ""
    name, factor = USUAL[unit]
    return f"{value * factor:.{DIGITS}g} {name}"


def _kind(found: Optimum) -> str:
    """What a value of an objective or constraint is where parts differ."""
    return f", for {found.task.percentile:g} % of the parts" if found.task.is_robust else ""


def _verdict(found: Optimum, units: Mapping[str, str]) -> str:
    head = "The best design keeps all constraints."
    if not found.feasible:
        head = (
            f"None of {found.evaluated:,} designs keeps all constraints. The design below is the nearest one."
        )
    elif len(found.task.objectives) > 1:
        head = (
            f"{len(found.front[next(iter(found.task.objectives))])} designs are the front: no design is "
            "better in all objectives. The design below is the one nearest to the best of each objective."
        )
    rows = [
        (text, f"{_number(value)} {unit_of(text, units)}".strip(), found.task.objectives[text] + _kind(found))
        for text, value in found.objectives.items()
    ]
    missed = "".join(f'<li class="error">{escape(text)}</li>' for text in found.violated)
    return (
        f'<p class="{"good" if found.feasible else "error"}"><b>{escape(head)}</b></p>\n'
        + (f"<ul>{missed}</ul>\n" if missed else "")
        + _numbers(("objective", "value", "wanted"), rows)
    )


def _design(found: Optimum, units: Mapping[str, str]) -> str:
    rows = []
    for name, value in found.design.items():
        unit = unit_of(name, units)
        rows.append(
            (name, f"{_number(value)} {unit}".strip(), _usual(value, unit), _bounds(found, name, value))
        )
    active = "".join(f"<li>{escape(text)}</li>" for text in found.holding)
    held = f"<p>Active: a wider limit would give a better design.</p>\n<ul>{active}</ul>\n" if active else ""
    none = "" if active else "<p>No bound and no constraint is active: the optimum lies inside.</p>\n"
    idle = "".join(f"<p>{escape(text)}.</p>\n" for text in found.idle_words())
    return "<h2>Design</h2>\n" + _numbers(("value", "SI", "usual unit", "bounds"), rows) + held + none + idle


def _bounds(found: Optimum, name: str, value: float | str) -> str:
    if name in found.task.same_as:
        return f"same as {found.task.same_as[name]}"
    if name not in found.task.designed:
        return "follows from others"
    vary = found.task.designed[name]
    if vary.is_list:
        return shown_bounds(found.task, name)
    low, high = vary.limits()
    share = share_of(vary, value)
    words = (
        ", at the lower bound" if share < ACTIVE else ", at the upper bound" if share > 1.0 - ACTIVE else ""
    )
    return f"{_number(low)} to {_number(high)}{words}"


def _constraints(found: Optimum, units: Mapping[str, str]) -> str:
    if not found.task.constraints:
        return ""
    rows = []
    for text, value in found.constraints.items():
        least, most = found.task.constraints[text]
        limits = [f"at least {_number(least)}"] if least is not None else []
        limits += [f"at most {_number(most)}"] if most is not None else []
        rows.append((text, f"{_number(value)} {unit_of(text, units)}".strip(), " and ".join(limits)))
    return "<h2>Constraints</h2>\n" + _numbers(("constraint" + _kind(found), "value", "allowed"), rows)


def _results(found: Optimum, units: Mapping[str, str]) -> str:
    rows = []
    for name, value in found.results.items():
        unit = unit_of(name, units)
        rows.append((name, f"{_number(value)} {unit}".strip(), _usual(value, unit)))
    exact = "<p>Of a part that is exactly as designed.</p>\n" if found.task.is_robust else ""
    return "<h2>Results of this design</h2>\n" + exact + _numbers(("result", "SI", "usual unit"), rows)


def _front(found: Optimum, units: Mapping[str, str]) -> str:
    texts = [*found.task.objectives, *found.task.designed]
    count = len(found.front[texts[0]])
    chosen = shown(found)
    rows = [(str(k + 1), *(_number(found.front[text][k]) for text in texts)) for k in chosen]
    heads = ["design", *(f"{text} [{unit}]" if (unit := unit_of(text, units)) else text for text in texts)]
    return (
        "<h2>Front</h2>\n"
        + figure_element(draw_front(found, units), "Front")
        + f"<p>{len(chosen)} of {count} designs; front.csv has all of them.</p>\n"
        + _numbers(heads, rows)
    )


def shown(found: Optimum) -> list[int]:
    """Places of the designs of the front that the page shows, spread over it."""
    count = len(next(iter(found.front.values())))
    return sorted({round(place) for place in np.linspace(0, count - 1, min(ROWS, count))})


def draw_front(found: Optimum, units: Mapping[str, str]) -> Figure:
    """The first objective against each other one."""
    from matplotlib.figure import Figure

    first, *others = found.task.objectives
    figure = Figure(figsize=(5.4, 3.8 * len(others)), layout="constrained")
    for axes, other in zip(np.ravel(figure.subplots(len(others), 1)), others, strict=True):
        axes.plot(found.front[first], found.front[other], ".", color="tab:red", label="front")
        axes.plot(found.objectives[first], found.objectives[other], "o", mfc="none", mec="k", label="chosen")
        axes.set(xlabel=_label(found, first, units), ylabel=_label(found, other, units))
        axes.legend(fontsize=8)
    return figure


def _label(found: Optimum, text: str, units: Mapping[str, str]) -> str:
    unit = unit_of(text, units)
    return f"{text}{f' [{unit}]' if unit else ''}\n{WAYS[found.task.objectives[text]]}"


def _convergence(found: Optimum, units: Mapping[str, str]) -> str:
    if len(found.history) == 0:
        return ""
    return "<h2>Convergence</h2>\n" + figure_element(draw_convergence(found, units), "Convergence")


def draw_convergence(found: Optimum, units: Mapping[str, str]) -> Figure:
    """The best first objective over the designs evaluated."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.4, 3.2), layout="constrained")
    axes = figure.subplots()
    count, best = found.history.T
    count, best = np.append(count, found.evaluated), np.append(best, best[-1])
    axes.step(count, best, where="post", color="tab:blue")
    axes.set_xscale("log")
    label = _label(found, next(iter(found.task.objectives)), units)
    if len(found.task.objectives) > 1:
        label = "hypervolume of the front\nas a share of that at the end"
    axes.set(xlabel="designs evaluated", ylabel=label)
    axes.grid(alpha=0.3)
    return figure


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
