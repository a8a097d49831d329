"""The schema of study plans as one pydantic model: which keys a plan has, of what kind, and what they mean.

The reference page docs/study-plan.md and plan.schema.json, for editors, are written from here."""

from collections.abc import Callable, Mapping
from functools import cache, partial
from types import GenericAlias
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, WithJsonSchema, create_model
from pydantic_core import PydanticCustomError

from dualcam.common.entries import (
    NUMBER,
    NUMBERS_BY_NAME,
    QUANTITIES_BY_NAME,
    QUANTITY,
    SCENARIO_NUMBER,
    SWITCH,
    TABLE,
    TEXT,
    VALUES,
    WHOLE,
    Kind,
)
from dualcam.common.toml_table import TomlTable
from dualcam.scenario.history import SHAPES
from dualcam.study.plan.arrangements import KINDS
from dualcam.study.plan.fields import ON_VIOLATION
from dualcam.study.plot_keys import KINDS as PLOTS


def _entry(kind: Kind, description: str, *, needed: bool = False, enum: tuple[str, ...] = ()) -> Any:  # noqa: ANN401
    """The type and the field of a key."""

    def checked(value: object) -> object:
        if not kind.suits(value):
            raise PydanticCustomError("kind", "{words}", {"words": kind.words})
        return value

    schema = {**kind.json, **({"enum": list(enum)} if enum else {})}
    annotated = Annotated[Any, BeforeValidator(checked), WithJsonSchema(schema)]
    return annotated, _field(description, kind.words, needed)


def _field(description: str, words: str, needed: bool) -> Any:  # noqa: ANN401
    extra: dict[str, Any] = {"words": words, "needed": needed}
    if needed:
        return Field(description=description, json_schema_extra=extra)
    return Field(default=None, description=description, json_schema_extra=extra)


def _table(name: str, description: str, fields: Mapping[str, Any]) -> Any:  # noqa: ANN401
    return create_model(name, __base__=TomlTable, __doc__=description, **fields)


def _nested(kind: Any, description: str, needed: bool = False) -> Any:  # noqa: ANN401
    return kind, _field(description, TABLE.words, needed)


def _by_name(kind: Any, description: str) -> Any:  # noqa: ANN401
    return _nested(GenericAlias(dict, (str, kind)), description)


def _tables(kind: Any, description: str, needed: bool = False) -> Any:  # noqa: ANN401
    return GenericAlias(list, (kind,)), _field(description, "a list of tables", needed)


VARY = _table(
    "Vary",
    "Values of one name: a range, a distribution, a list, or tables with a random error",
    {
        "from": _entry(QUANTITY, "start of the range; of a distribution: cut off below"),
        "to": _entry(QUANTITY, "end of the range; of a distribution: cut off above"),
        "count": _entry(
            WHOLE,
            "`grid`: number of values from start to end, both included; of a table with an error: number of "
            "tables",
        ),
        "log": _entry(SWITCH, "the values are spread evenly in the logarithm"),
        "values": _entry(VALUES, "these values; of a String: texts, such as paths of groove tables"),
        "weights": _entry(NUMBER.listed(), "how often each of `values` is drawn; equally often if not given"),
        "same_as": _entry(TEXT, "the value of this other name in each run"),
        "distribution": _entry(TEXT, '`"normal"`, or the name of any distribution of scipy.stats'),
        "mean": _entry(QUANTITY, "`normal`: mean"),
        "std": _entry(QUANTITY, "`normal`: standard deviation"),
        "arguments": _entry(
            QUANTITIES_BY_NAME, "arguments of a distribution of scipy.stats, by their names there"
        ),
        "unit": _entry(TEXT, "unit of a name that the FMU does not have, into which texts are converted"),
        "table": _entry(TEXT, "path of a groove table that gets a random smooth error of its profile"),
        "deviation": _entry(QUANTITY, "standard deviation of the error of z"),
        "correlation_length": _entry(QUANTITY, "angle psi over which the error is alike"),
    },
)
CORRELATION = _table(
    "Correlation",
    "Correlation of two names",
    {
        "of": _entry(TEXT.listed(), "the two names", needed=True),
        "rank": _entry(NUMBER, "Spearman's correlation of the ranks, above -1 and below 1"),
        "pearson": _entry(NUMBER, "instead: Pearson's correlation of the values"),
    },
)
PLAN = _table(
    "Plan",
    "Which values the runs have",
    {
        "kind": _entry(TEXT, "arrangement of the runs, see below", enum=KINDS),
        "runs": _entry(
            WHOLE,
            "runs of `random`, `latin` and `sobol`; of `indices` and `saltelli` a power of 2; of `morris` "
            "trajectories; of `fast` runs for each name",
        ),
        "seed": _entry(WHOLE, "start of the random numbers, 0 if not given"),
        "vary": _by_name(VARY, "the values by name, with the keys `vary.NAME`"),
        "derived": _entry(NUMBERS_BY_NAME, 'formulas by name, such as `"spring.stiffness" = "rate * coils"`'),
        "constraints": _entry(NUMBERS_BY_NAME, "formulas that must be true in each run, by a name of theirs"),
        "on_violation": _entry(
            TEXT,
            '`"redraw"` (if not given): a run that violates a constraint is drawn again; `"mark"`: the run '
            "is not made, its message names the constraint",
            enum=ON_VIOLATION,
        ),
        "correlation": _tables(CORRELATION, "correlations, each a `[[plan.correlation]]`"),
        "second_order": _entry(SWITCH, "`saltelli`: runs for second-order indices, true if not given"),
        "levels": _entry(WHOLE, "`morris`: levels of each name, an even number, 4 if not given"),
        "table": _entry(
            TEXT,
            "path of a CSV or Parquet file with a column for each name and a row for each run, in the FMU's "
            "units",
        ),
    },
)
HISTORY = _table(
    "History",
    "An input over time",
    {
        "time": _entry(SCENARIO_NUMBER.listed(), "times [s]; the same time twice is a jump"),
        "value": _entry(SCENARIO_NUMBER.listed(), "values at these times, in the FMU's unit"),
        "shape": _entry(
            TEXT, 'between the points: `"linear"` or `"smooth"`; `"sine"` has no points', enum=SHAPES
        ),
        "mean": _entry(SCENARIO_NUMBER, "`sine`: mean value"),
        "amplitude": _entry(SCENARIO_NUMBER, "`sine`: amplitude"),
        "frequency": _entry(SCENARIO_NUMBER, "`sine`: frequency [Hz]"),
        "phase": _entry(SCENARIO_NUMBER, "`sine`: phase at 0 s [rad]"),
        "derivative_of": _entry(
            TEXT, "the input is the time derivative of this other input, such as `omega` of `theta`"
        ),
    },
)
CONTROLLER = _table(
    "Controller",
    "A closed loop in Python",
    {
        "create_law": _entry(
            TEXT,
            '`"module:function"`; the function returns a new law(time, values) for each run',
            needed=True,
        ),
        "period": _entry(SCENARIO_NUMBER, "time between two calls of the law [s]", needed=True),
        "reads": _entry(TEXT.listed(), "variables that the law gets", needed=True),
        "writes": _entry(TEXT.listed(), "inputs that the law gives", needed=True),
        "arguments": _entry(NUMBERS_BY_NAME, "arguments that the function gets, by name"),
    },
)


def _history(value: object) -> object:
    """A number or a formula alone is a value that stands still."""
    return {"time": [0.0], "value": [value]} if SCENARIO_NUMBER.suits(value) else value


SCENARIO = _table(
    "Scenario",
    "What happens in each run",
    {
        "stop": _entry(SCENARIO_NUMBER, "end of the run [s]", needed=True),
        "step": _entry(
            SCENARIO_NUMBER, "step [s], only for FMUs that take no derivatives of inputs or need equal steps"
        ),
        "tolerance": _entry(NUMBER, "relative tolerance of the FMU's integrator"),
        "inputs": _by_name(
            Annotated[HISTORY, BeforeValidator(_history)],
            "inputs over time, by name: tables, or a number that stands still",
        ),
        "controller": _nested(CONTROLLER, "a closed loop in Python"),
    },
)
PLOT = _table(
    "Plot",
    "A picture",
    {
        "kind": _entry(TEXT, "kind of picture", enum=tuple(PLOTS)),
        "title": _entry(TEXT, "title of the picture"),
        "x": _entry(TEXT, "`map`, `pareto`: column along the horizontal axis"),
        "y": _entry(TEXT, "`map`, `pareto`: column along the vertical axis"),
        "z": _entry(
            TEXT, "`map`: column that the colours show; of a plan that is no grid, by its means over hexagons"
        ),
        "of": _entry(TEXT.listed(), "`sobol`: results; the plan is of kind `indices`"),
        "best": _entry(TEXT.listed(), '`pareto`: `"max"` or `"min"`, what is wanted of x and y'),
        "axes": _entry(TEXT.listed(), "`parallel`: columns"),
        "color": _entry(TEXT, "`pareto`, `parallel`: column that the colours show"),
        "highlight": _entry(
            NUMBER,
            "`parallel`: share of the runs with the highest colour that is drawn over the rest, 0.1 if not "
            "given",
        ),
    },
)
GOAL_LIMITS = _table(
    "GoalLimits",
    "Limits of a result",
    {
        "from": _entry(QUANTITY, "least value of the result or formula"),
        "to": _entry(QUANTITY, "greatest value of the result or formula"),
    },
)
TOLERANCE = _table(
    "Tolerance",
    "Deviation of made parts",
    {
        "plus_minus": _entry(QUANTITY, "half-width of the limits around the designed value", needed=True),
        "shape": _entry(
            TEXT,
            '`"normal"` (if not given; the limits are three standard deviations away), `"uniform"` or '
            '`"triangular"`',
            enum=("normal", "uniform", "triangular"),
        ),
    },
)
OPTIMISE = _table(
    "Optimise",
    "The search for the best design",
    {
        "objectives": _entry(
            NUMBERS_BY_NAME, '`"minimise"` or `"maximise"`, by the result or formula', needed=True
        ),
        "constraints": _by_name(GOAL_LIMITS, "limits by the result or formula, with the next two keys"),
        "method": _entry(TEXT, '`"slsqp"`, `"evolution"` or `"nsga2"`', enum=("slsqp", "evolution", "nsga2")),
        "budget": _entry(WHOLE, "most designs that are evaluated, 2000 if not given"),
        "population": _entry(WHOLE, "designs in a generation"),
        "starts": _entry(WHOLE, "`slsqp`: searches from different designs, 4 if not given"),
        "start": _entry(QUANTITIES_BY_NAME, "values of the design with which the search begins, by name"),
        "seed": _entry(WHOLE, "start of the random numbers, 0 if not given"),
        "tolerances": _by_name(TOLERANCE, "deviations of made parts by name, with the next two keys"),
        "percentile": _entry(NUMBER, "share of the parts [%], 95 if not given"),
        "samples": _entry(WHOLE, "parts of each design, 64 if not given"),
        "difference": _entry(
            NUMBER, "`slsqp`: step of the differences as a share of the bounds, 0.001 if not given"
        ),
    },
)
RESULTS = 'what is read in each run, such as `"theta"`, `"theta@0.2"` or `"top = max(theta, every=0.01)"`'
KEYS: dict[str, Callable[..., Any]] = {  # of a whole file
    "fmu": partial(_entry, TEXT, '`"forward"`, `"inverse"`, or the path of an FMU, relative to the file'),
    "results": partial(_entry, TEXT.listed(), RESULTS),
    "parameters": partial(_entry, TABLE, "start values that are the same in every run, by name"),
    "plan": partial(_nested, PLAN, "which values the runs have"),
    "scenario": partial(_nested, SCENARIO, "what happens in each run"),
    "plots": partial(_tables, PLOT, "pictures, each a `[[plots]]`"),
    "optimise": partial(_nested, OPTIMISE, "the search for the best design"),
}
FILES = {  # what it is; keys needed; others
    "StudyPlan": ("A parameter study of an FMU", "fmu results plan scenario", "parameters plots"),
    "StudySection": ("A parameter study of a design", "results plan", "scenario plots"),
    "Search": ("An optimisation of an FMU", "fmu plan scenario optimise", "results parameters plots"),
    "SearchSection": ("An optimisation of a design", "plan optimise", "results scenario plots"),
    "Plan": (  # every key that a plan may have
        "A parameter study or an optimisation of an FMU",
        "fmu plan scenario",
        "results parameters plots optimise",
    ),
}


@cache
def model_of(name: str) -> Any:  # noqa: ANN401
    """The pydantic model of a whole file, or of the section [study] of a design file: a key of FILES."""
    description, needed, others = FILES[name]
    keys = [key for key in KEYS if key in f"{needed} {others}".split()]
    return _table(name, description, {key: KEYS[key](needed=key in needed.split()) for key in keys})


def json_schema() -> dict[str, Any]:
    """JSON Schema of plans, for editors."""
    schema = model_of("Plan").model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | _plain(schema)


def _plain(schema: Any) -> Any:  # noqa: ANN401
    """Without what only the page and the messages need."""
    if isinstance(schema, dict):
        return {
            name: _plain(each)
            for name, each in schema.items()
            if not (name in ("words", "needed") and not isinstance(each, dict))
            and not (name == "default" and each is None)
        }
    return [_plain(each) for each in schema] if isinstance(schema, list) else schema
