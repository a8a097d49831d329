"""What comes out of a run: values at an instant, series, extremes, integrals, and formulas over them.

docs/use-study-results.md, "What can be read", lists the texts of which results are made.
The FMU is asked for plain values at instants alone, `Readings.raw`; all else is computed of those."""

import ast
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dualcam.common.mistakes import StudyError, refuse
from dualcam.fmi.reals import Array
from dualcam.scenario.formula import Formula, formula
from dualcam.study.store.encoding import Column

SERIES, FORMULA, VALUE = "series", "formula", "value"
SAMPLED = (SERIES, "max", "min", "mean", "integral")
SAMPLES_MAX = 1_000_000  # of one result in a run
CALL = re.compile(rf"({'|'.join(SAMPLED)})\s*\(([^=]+?)(?:,\s*(\w+)\s*=\s*([^()]*?))?\s*\)")
OF_VALUES = re.compile(r"(max|min)\s*\([^=]*,[^=]*\)")  # of values at the end; a formula
ONE_AND_NUMBER = re.compile(r"\w+\s*\(\s*[A-Za-z_][\w.]*\s*,\s*[\d.eE+-]+\s*\)")  # `every=` is forgotten
INNER = re.compile(  # one that stands in a formula
    r"\b(max|min|mean|integral)\(\s*([A-Za-z_][\w.]*)\s*,\s*(every|count|at)\s*=\s*(\[[^\]]*\]|[^,()\s]+)\s*\)"
)
AT_END = re.compile(r"`?([A-Za-z_][\w.\[\],]*)@end\b`?")
NAMED = re.compile(r"([^=<>!`@()]+?)\s*=(?!=)\s*(.+)")
RESERVED = ("run", "message")


@dataclass(frozen=True)
class Reading:
    """One column of results: of what kind, of which plain values, or by which formula."""

    column: str
    kind: str
    raw: tuple[str, ...] = ()
    times: tuple[float, ...] = ()  # s, of samples
    formula: Formula | None = None

    @property
    def width(self) -> int:
        """Numbers in a run."""
        return len(self.raw) if self.kind == SERIES else 1


class Readings:
    """The results of a study, by their texts, which the page named above lists. StudyError with all texts
    that are no results.

    `stop` is the end of the runs [s], a formula where it varies; `varied` are the names of the plan.
    `columns` are the names of the results; `raw` is what the FMU is asked for, names and `name@time`;
    `series` has the instants [s] of each series; `used` are the names of the plan that formulas use."""

    def __init__(self, results: Sequence[str], stop: float | str, varied: Sequence[str] = ()) -> None:
        self._varied = tuple(varied)
        self._parsed: dict[str, Reading] = {}
        self._inner: dict[str, Reading] = {}  # samples inside formulas, which are no columns
        self.used: set[str] = set()
        problems = []
        for text in results:
            try:
                reading = self._reading(text.strip(), stop)
                if reading.column in self._parsed:
                    raise StudyError(f"{reading.column} is named twice: allowed is once")
                self._parsed[reading.column] = reading
            except StudyError as error:
                problems.append(f"result {text!r}: {error}")
        refuse(problems)
        self.columns = list(self._parsed)
        self.raw = list(dict.fromkeys(name for each in self._parsed.values() for name in each.raw))
        self.series = {each.column: each.times for each in self._parsed.values() if each.kind == SERIES}

    @property
    def width(self) -> int:
        """Numbers that a run gives, and that it is read for: the size of a run in memory."""
        return max(len(self.raw), sum(each.width for each in self._parsed.values()))

    # ---- texts ----

    def _reading(self, text: str, stop: float | str) -> Reading:
        name, body = _split(text)
        if name in (*self._varied, *RESERVED):
            raise StudyError(f"{name} is the name of another column: give another name")
        if "@end" in body:
            return self._of_formula(name or text, AT_END.sub(r"`\1`", body), stop)
        if call := _sampling(body):
            return _sampled(name or text, call, stop)
        if name:
            return self._of_formula(name, body, stop)
        if not text:
            raise StudyError("an empty text: allowed is the name of a variable")
        return Reading(text, VALUE, (text,))

    def _of_formula(self, column: str, body: str, stop: float | str) -> Reading:
        inner: dict[str, Reading] = {}

        def stand_in(call: re.Match[str]) -> str:
            inner[call[0]] = _sampled(call[0], call, stop)
            return f"`{call[0]}`"

        body = INNER.sub(stand_in, body)
        if "series(" in body:
            raise StudyError("a series is no part of a formula: allowed are results with one value")
        found = formula(body)
        for name in found.names:
            if name in self._parsed and self._parsed[name].kind == SERIES:
                raise StudyError(f"{name} is a series: allowed in formulas are results with one value")
        self._inner |= inner
        known = (*self._varied, *self._parsed, *inner)
        raw = [name for name in found.names if name not in known]
        raw += [name for each in inner.values() for name in each.raw]
        self.used |= {name for name in found.names if name in self._varied}
        return Reading(column, FORMULA, tuple(raw), formula=found)

    # ---- values ----

    def of(self, raw: Array, varied: Mapping[str, Column], failed: Sequence[int] = ()) -> dict[str, Column]:
        """The columns of results, shape (runs,) or (runs, instants), of what the FMU gave, shape (runs, raw),
        and of the values of the plan, for formulas. Runs at the places `failed` have no results."""
        if all(each.kind == VALUE for each in self._parsed.values()):
            return dict(zip(self.columns, raw.T, strict=True))
        places = {name: k for k, name in enumerate(self.raw)}
        by_name = {name: raw[:, k] for name, k in places.items()}

        def reduced(each: Reading) -> Column:
            samples = raw[:, [places[name] for name in each.raw]]
            return np.asarray(_REDUCED[each.kind](samples, np.array(each.times)))

        by_name |= {name: reduced(each) for name, each in self._inner.items()}
        found: dict[str, Column] = {}
        for each in self._parsed.values():
            if each.formula is not None:
                values = {**by_name, **varied, **found}
                found[each.column] = each.formula.numbers(values, len(raw))
            elif each.kind == VALUE:
                found[each.column] = by_name[each.raw[0]]
            else:
                found[each.column] = reduced(each)
        if len(failed):
            for name, column in found.items():
                found[name] = column = np.array(column)
                column[list(failed)] = np.nan
        return found

    def table(self, raw: Array, varied: Mapping[str, Column], failed: Sequence[int] = ()) -> Array:
        """The same as one array, shape (runs, columns); each instant of a series is a column."""
        found = self.of(raw, varied, failed).values()
        columns = [column if column.ndim > 1 else column[:, None] for column in found]
        return np.concatenate(columns, axis=1) if columns else np.empty((len(raw), 0))


_REDUCED: dict[str, Any] = {
    SERIES: lambda samples, times: samples,
    "max": lambda samples, times: samples.max(axis=1),
    "min": lambda samples, times: samples.min(axis=1),
    "mean": lambda samples, times: np.trapezoid(samples, times, axis=1) / (times[-1] - times[0]),
    "integral": lambda samples, times: np.trapezoid(samples, times, axis=1),
}


def column_of(text: str) -> str:
    """The name of the column of a result."""
    return _split(text)[0] or text.strip()


def is_series(text: str) -> bool:
    """Whether a result has several values in a run."""
    call = _sampling(_split(text)[1])
    return call is not None and call[1] == SERIES


def _split(text: str) -> tuple[str, str]:
    """The name that the text gives to the result, empty without one, and what is computed."""
    text = text.strip()
    named = None if _sampling(text) else NAMED.fullmatch(text)
    return (named[1].strip(), named[2].strip()) if named else ("", text)


def _sampling(text: str) -> re.Match[str] | None:
    """The parts of a text such as max(theta, every=0.01); None for max(theta, omega), which is a formula."""
    if OF_VALUES.fullmatch(text) and not ONE_AND_NUMBER.fullmatch(text):
        return None
    return CALL.fullmatch(text)


def _sampled(column: str, call: re.Match[str], stop: float | str) -> Reading:
    kind, variable, key, value = call[1], call[2].strip(), call[3], call[4]
    if isinstance(stop, str):
        raise StudyError(f"{kind}(...) needs runs of one length: allowed is a stop that does not vary")
    times = _instants(key, value, stop)
    if kind in ("mean", "integral") and len(times) < 2:
        raise StudyError(f"{kind} at {len(times)} instant: allowed are two or more")
    # The end is read by the plain name: rounding of its time does not matter.
    raw = tuple(variable if time == stop else f"{variable}@{time!r}" for time in times)
    return Reading(column, kind, raw, times)


def _instants(key: str | None, value: str, stop: float) -> tuple[float, ...]:
    """The times of samples. The end is one of them where they come at a rate."""
    try:
        number: Any = ast.literal_eval(value) if key else None
    except (ValueError, SyntaxError):
        number = None
    if key == "every" and _is_number(number) and number > 0.0 and stop / number <= SAMPLES_MAX:
        steps = np.arange(math.ceil(stop / number * (1.0 - 1e-12))) * number
        return (*steps.tolist(), stop)
    if key == "count" and isinstance(number, int) and 2 <= number <= SAMPLES_MAX:
        return (*np.linspace(0.0, stop, number)[:-1].tolist(), stop)
    if key == "at" and isinstance(number, list | tuple) and number and all(map(_is_number, number)):
        times = tuple(float(each) for each in number)
        if times[0] >= 0.0 and times[-1] <= stop and all(np.diff(times) > 0.0):
            return times
    raise StudyError(
        f"allowed after the variable is every=SECONDS (down to {stop / SAMPLES_MAX:g}), "
        f"count=NUMBER (2 or more), or at=[TIMES] with increasing times from 0 to {stop:g} s"
    )


def _is_number(number: object) -> bool:
    return isinstance(number, int | float) and not isinstance(number, bool) and math.isfinite(number)
