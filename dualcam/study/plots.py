"""Pictures of a finished study: efficiency maps, Sobol's indices, Pareto fronts, parallel coordinates.

`plot_keys` says which keys each kind has, docs/study-plan.md what they mean."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.text import Text
from numpy.typing import NDArray

from dualcam.common.mistakes import StudyError, refuse
from dualcam.common.paths import check_picture, whole_file
from dualcam.fmi.fmu import Array, Fmu
from dualcam.study.plot_keys import columns_of, problems_of_columns, problems_of_keys
from dualcam.study.store.results import read_results
from dualcam.study.study import Study

DPI = 90
LEVELS = 12  # of a map
LINES = 500  # of parallel coordinates: more hide each other
DOTS = 6_000  # of a cloud, likewise
RESAMPLES = 200  # of the runs, for the 95 % intervals of Sobol's indices
SEED = 1  # of what is chosen at random here
THIN = {"elinewidth": 0.8, "ecolor": "0.3"}  # of an interval


def draw(studies: Sequence[tuple[Study, str | Path]], path: Path) -> None:
    """All plots of these studies, whose results are in these folders, as panels of one picture."""
    for study, _ in studies:
        refuse(problems_of_keys(study.plots))
        refuse(problems_of_columns(study.plots, study.plan, study.readings))
    panels = [(study, folder, plot) for study, folder in studies for plot in study.plots]
    check_file([study for study, _ in studies], path)
    columns = min(2, len(panels))
    lines = -(-len(panels) // columns)
    size = 7.2 * columns, 5.2 * lines
    figure, axes = plt.subplots(lines, columns, figsize=size, layout="constrained", squeeze=False)
    try:
        for axis, (study, folder, plot) in zip(axes.flat, panels, strict=False):
            _draw_one(axis, study, folder, plot)
        for axis in axes.flat[len(panels) :]:
            axis.axis("off")
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as unfinished:
            figure.savefig(unfinished, dpi=DPI)
    except OSError as error:
        raise StudyError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        plt.close(figure)


def check_file(studies: Sequence[Study], path: Path) -> None:
    """DualcamError if no picture of these studies can be written there."""
    if not any(study.plots for study in studies):
        raise StudyError("these plans have no plots: add [[plots]] to one")
    check_picture(path)


def _draw_one(axis: Axes, study: Study, folder: str | Path, plot: Mapping[str, Any]) -> None:
    table = read_results(folder, columns_of(plot))
    columns = {name: np.asarray(values, float) for name, values in table.items()}
    with Fmu(study.path) as fmu:
        labels = {name: _label(fmu, study, name) for name in columns}
    if plot["kind"] == "sobol":
        _sobol(axis, study, columns, plot["of"])
    else:
        whole = np.all([np.isfinite(values) for values in columns.values()], axis=0)
        if not whole.any():
            raise StudyError(f"{folder}: every run failed, there is nothing to draw: see column message")
        sound = {name: values[whole] for name, values in columns.items()}
        draw_kind = {"map": _map, "pareto": _pareto, "parallel": _parallel}[plot["kind"]]
        draw_kind(axis, study, sound, labels, plot)
    axis.set_title(plot.get("title", ""), loc="left")


def _label(fmu: Fmu, study: Study, name: str) -> str:
    """Name and unit; a dimensionless quantity, and a name whose unit nobody says, has none."""
    variable, at, time = name.partition("@")
    vary = study.plan.vary.get(name)
    unit = fmu.variable(variable).unit if variable in fmu.names else vary.unit if vary else ""
    when = " at the end" if time == "end" else f" at {time} s" if at else ""
    return variable + when + (f" [{unit}]" if unit and unit != "1" else "")


def _map(
    axis: Axes, study: Study, columns: Mapping[str, Array], labels: Mapping[str, str], plot: Mapping[str, Any]
) -> None:
    x, y, z = (columns[plot[key]] for key in "xyz")
    scales: dict[str, Any] = {f"{key}scale": "log" if _is_log(study, plot[key]) else "linear" for key in "xy"}
    if study.plan.kind == "grid" and {plot["x"], plot["y"]} <= set(study.plan.vary):
        across, along, mean = _means(x, y, z)
        shades = axis.contourf(across, along, mean, LEVELS, cmap="viridis")
        lines = axis.contour(across, along, mean, LEVELS, colors="white", linewidths=0.5)
        axis.set(**scales)
        _drop_cut(axis, axis.clabel(lines, fontsize=7))
        line, column = np.unravel_index(np.nanargmax(mean), mean.shape)
        axis.plot(across[column], along[line], "w+", markersize=9)
        style: dict[str, Any] = {"textcoords": "offset points", "color": "black", "fontsize": 8}
        axis.annotate(f"{mean[line, column]:.4g}", (across[column], along[line]), (5, 5), **style)
        axis.figure.colorbar(shades, ax=axis, label=labels[plot["z"]])
    else:
        cells = axis.hexbin(x, y, z, gridsize=30, cmap="viridis", linewidths=0.1, **scales)
        axis.figure.colorbar(cells, ax=axis, label=f"mean of {labels[plot['z']]}")
    axis.set(xlabel=labels[plot["x"]], ylabel=labels[plot["y"]])


def _is_log(study: Study, name: str) -> bool:
    """Whether it varies evenly in the logarithm."""
    vary = study.plan.vary.get(study.plan.same_as.get(name, name))
    return vary is not None and vary.log


def _drop_cut(axis: Axes, texts: Sequence[Text]) -> None:
    """Numbers of lines so close to the edge that they would be cut off."""
    for text in texts:
        place = axis.transAxes.inverted().transform(axis.transData.transform(text.get_position()))
        text.set_visible(bool(np.all((place > 0.05) & (place < 0.95))))


def _means(x: Array, y: Array, z: Array) -> tuple[Array, Array, Array]:
    """Over what else varies; NaN where no run succeeded."""
    across, column = np.unique(x, return_inverse=True)
    along, line = np.unique(y, return_inverse=True)
    total, count = np.zeros((len(along), len(across))), np.zeros((len(along), len(across)))
    np.add.at(total, (line, column), z)
    np.add.at(count, (line, column), 1.0)
    with np.errstate(invalid="ignore"):
        return across, along, total / count


def indices(study: Study, values: Array) -> Any:  # noqa: ANN401
    """Sobol's indices of one result over all runs of a plan of kind "indices": SciPy's SobolResult, with
    first_order and total_order, shape (variables,), and bootstrap."""
    from scipy.stats import sobol_indices

    failed = int(np.sum(~np.isfinite(values)))
    if failed:
        raise StudyError(
            f"{failed} of {len(values)} runs have no value: Sobol's indices need all. See column message, "
            "and narrow the ranges so that every run can be made"
        )
    blocks = values.reshape(len(study.plan.vary) + 2, study.plan.runs)
    parts = {"f_A": blocks[:1], "f_B": blocks[1:2], "f_AB": blocks[2:, None, :]}
    return sobol_indices(func=parts, n=study.plan.runs)


def spread(study: Study, values: Array) -> tuple[Array, Array]:
    """Ends of the 95 % intervals of first and total indices, shape (2, variables) each, by resampling of the
    runs. SciPy's own bootstrap does the same by copying all runs, which takes minutes."""
    blocks = values.reshape(len(study.plan.vary) + 2, study.plan.runs)
    first, second, mixed = blocks[0], blocks[1], blocks[2:]
    middle = (first.mean() + second.mean()) / 2.0
    first, second, mixed = first - middle, second - middle, mixed - middle
    count = len(first)
    random = np.random.default_rng(SEED)
    weights = random.multinomial(count, np.full(count, 1.0 / count), size=RESAMPLES) / count
    mean = weights @ (first + second) / 2.0
    variance = weights @ (first**2 + second**2) / 2.0 - mean**2
    # Saltelli et al. 2010, table 2, rows (b) and (f): as scipy.stats.sobol_indices
    of_first = weights @ (second * (mixed - first)).T
    of_total = weights @ ((first - mixed) ** 2).T / 2.0
    ends = [2.5, 97.5]
    with np.errstate(invalid="ignore"):  # of a result that is always the same no share is anyone's
        shares = of_first / variance[:, None], of_total / variance[:, None]
    return np.percentile(shares[0], ends, axis=0), np.percentile(shares[1], ends, axis=0)


def _sobol(axis: Axes, study: Study, columns: Mapping[str, Array], of: Sequence[str]) -> None:
    names = list(study.plan.vary)
    width = 0.8 / len(of)
    for k, result in enumerate(of):
        found = indices(study, columns[result])
        ends = spread(study, columns[result])
        places = np.arange(len(names)) + (k - (len(of) - 1) / 2) * width
        bars = (("total", 0.35, found.total_order, ends[1]), ("first order", 1.0, found.first_order, ends[0]))
        for kind, alpha, values, (low, high) in bars:
            reach = np.maximum([values - low, high - values], 0.0)
            label = f"{result}, {kind}" + (", constant" if np.ptp(columns[result]) == 0.0 else "")
            style: dict[str, Any] = {"color": f"C{k}", "alpha": alpha, "label": label}
            axis.barh(places, values, width * 0.95, xerr=reach, error_kw=THIN, **style)
    axis.set_yticks(np.arange(len(names)), names)
    axis.invert_yaxis()
    axis.set_xlabel("share of the variance (lines: 95 %)")
    axis.set_xlim(left=0.0)
    axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.45, -0.12), ncols=len(of))


def front(x: Array, y: Array, best: Sequence[str] = ("max", "max")) -> NDArray[np.intp]:
    """Places of the runs that no other beats in one of the two without losing in the other, by growing x."""
    gain_x, gain_y = (x if best[0] == "max" else -x), (y if best[1] == "max" else -y)
    order = np.lexsort((-gain_y, -gain_x))  # the best x first, and of equals the best y
    before = np.concatenate([[-np.inf], np.maximum.accumulate(gain_y[order])[:-1]])
    kept = order[gain_y[order] > before]
    return kept[np.argsort(x[kept])]


def _pareto(
    axis: Axes, study: Study, columns: Mapping[str, Array], labels: Mapping[str, str], plot: Mapping[str, Any]
) -> None:
    x, y = columns[plot["x"]], columns[plot["y"]]
    best = plot.get("best", ("max", "max"))
    some = _some(len(x), DOTS)
    style: dict[str, Any] = {"s": 4, "linewidths": 0, "rasterized": True}
    if "color" in plot:
        dots = axis.scatter(x[some], y[some], c=columns[plot["color"]][some], cmap="viridis", **style)
        axis.figure.colorbar(dots, ax=axis, label=labels[plot["color"]])
    else:
        axis.scatter(x[some], y[some], color="0.6", **style)
    kept = front(x, y, best)
    label = f"front: {len(kept)} of {len(x)}"
    axis.plot(x[kept], y[kept], "o-", color="C3", markersize=3, linewidth=1, label=label)
    wanted = {"max": "more is better", "min": "less is better"}
    across, along = (f"{labels[plot[key]]}, {wanted[way]}" for key, way in zip("xy", best, strict=True))
    axis.set(xlabel=across, ylabel=along)
    axis.legend(fontsize=8)


def _parallel(
    axis: Axes, study: Study, columns: Mapping[str, Array], labels: Mapping[str, str], plot: Mapping[str, Any]
) -> None:
    names = list(plot["axes"])
    logs = {name: np.log(columns[name]) if _is_log(study, name) else columns[name] for name in names}
    scaled = np.column_stack([_scaled(logs[name]) for name in names])
    crowded = len(names) > 10
    shade = columns[plot["color"]] if "color" in plot else columns[names[-1]]
    ranks = np.argsort(np.argsort(shade)) / max(len(shade) - 1, 1)
    chosen = ranks >= 1.0 - plot.get("highlight", 0.1)
    styles: tuple[tuple[NDArray[np.intp], dict[str, Any]], ...] = (
        (np.flatnonzero(~chosen), {"colors": "0.8", "alpha": 0.3}),
        (np.flatnonzero(chosen), {"cmap": "viridis", "alpha": 0.6}),
    )
    for places, style in styles:
        some = places[_some(len(places), LINES)]
        some = some[np.argsort(shade[some])]
        places_of_axes = np.broadcast_to(np.arange(len(names)), scaled[some].shape)
        paths = np.stack([places_of_axes, scaled[some]], axis=-1)
        lines = LineCollection(list(paths), linewidths=0.6, rasterized=True, **style)
        if "cmap" in style:
            lines.set_array(shade[some])
        axis.add_collection(lines)
    axis.figure.colorbar(lines, ax=axis, label=labels[plot.get("color", names[-1])])
    axis.set(xlim=(-0.2, len(names) - 0.8), ylim=(-0.06, 1.06), yticks=[])
    words = [labels[name].replace(" [", "\n[") for name in names]
    axis.set_xticks(range(len(names)), words, rotation=70 if crowded else 35, ha="right")
    axis.tick_params(axis="x", labelsize=7)
    for k, name in enumerate(names):
        axis.axvline(k, color="0.5", linewidth=0.6)
        ends = ((-0.01, columns[name].min(), "top"), (1.01, columns[name].max(), "bottom"))
        for height, value, place in ends:
            axis.text(k, height, f"{value:.3g}", fontsize=5 if crowded else 7, ha="center", va=place)


def _scaled(values: Array) -> Array:
    spread = np.ptp(values)
    return (values - values.min()) / spread if spread > 0.0 else np.full(len(values), 0.5)


def _some(count: int, most: int) -> NDArray[np.intp]:
    """Places of as many as can be seen, the same every time."""
    if count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(SEED).choice(count, most, replace=False))
