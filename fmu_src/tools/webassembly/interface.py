"""What a component must export and import by the working draft of the layered standard.

The facts are those of the draft's interface package fmi:fmi3@3.0.0: names and types of functions, in the
draft's order. The names of types and of FMI's functions are those of FMI 3.0 in small letters with hyphens.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from webassembly.types import Enumeration, Function, Handle, List, Named, Option, Record, Result, Tuple, Type

Argument = tuple[str, Type]

LAYERED_STANDARD = "org.modelica.fmi-ls-wasm"
DRAFT = "0.1.0"  # the draft's example of a version: it has no other yet
FOLDER = "wasm32-wasip2"
PACKAGE, VERSION = "fmi:fmi3", "3.0.0"

REFERENCE, STATUS, STATE = Named("value-reference"), Named("status"), Named("fmu-state")
QUALIFIER, FRACTION = Named("interval-qualifier"), Named("interval-fraction")
STATES_INFO, DEPENDENCY = Named("discrete-states-info"), Named("variable-dependency")
REFERENCES, REALS = List(REFERENCE), List("f64")

# The interface `types`: each type is made of earlier ones.
TYPES: dict[str, Type] = {
    "value-reference": "u32",
    "status": Enumeration(("ok", "warning", "discard", "error", "fatal")),
    "interval-qualifier": Enumeration(("interval-not-yet-known", "interval-unchanged", "interval-changed")),
    "dependency-kind": Enumeration(("dependent", "constant", "fixed", "tunable", "discrete")),
    "fmu-state": List("u8"),
    "interval-fraction": Record((("counter", "u64"), ("resolution", "u64"))),
    "variable-dependency": Record(
        (
            ("dependent-value-reference", REFERENCE),
            ("element-index-of-dependent", "u32"),
            ("independent-value-reference", REFERENCE),
            ("element-index-of-independent", "u32"),
            ("kind", Named("dependency-kind")),
        )
    ),
    "discrete-states-info": Record(
        (
            ("new-discrete-states-needed", "bool"),
            ("terminate-simulation", "bool"),
            ("nominals-of-continuous-states-changed", "bool"),
            ("values-of-continuous-states-changed", "bool"),
            ("next-event-time-defined", "bool"),
            ("next-event-time", "f64"),
        )
    ),
}
# The types that both interfaces of instances take from there.
USED = (
    *("value-reference", "status", "fmu-state", "interval-qualifier", "interval-fraction"),
    *("variable-dependency", "discrete-states-info"),
)
VALUES: dict[str, Type] = {
    "float32": "f32", "float64": "f64", "int8": "s8", "int16": "s16", "int32": "s32", "int64": "s64",
    "uint8": "u8", "uint16": "u16", "uint32": "u32", "uint64": "u64", "boolean": "bool", "string": "string",
    "binary": List("u8"), "clock": "bool",
}  # fmt: skip

# ---- what the host provides ----
# The draft's callbacks for clocks and for scheduled execution, and those of intermediate updates, are left
# out: a component needs not import what it does not call, and the world of model exchange does not have the
# latter.

LOG_MESSAGE = Function(
    "log-message",
    (("instance-name", "string"), ("status", STATUS), ("category", "string"), ("message", "string")),
)
# ---- what the FMU provides ----


def _or_status(good: Type) -> Result:
    return Result(good, STATUS)


def _shared_methods() -> list[Function]:
    """The methods of both resources, without the instance itself, the first argument of each."""

    def mode(name: str) -> Function:
        return Function(name, (), STATUS)

    def about(name: str, result: Type) -> Function:
        return Function(name, (("value-references", REFERENCES),), _or_status(List(result)))

    def change(name: str, values: str, element: Type) -> Function:
        return Function(name, (("value-references", REFERENCES), (values, List(element))), STATUS)

    def derivative(name: str) -> Function:
        arguments = (("unknowns", REFERENCES), ("knowns", REFERENCES), ("seed", REALS))
        return Function(name, arguments, _or_status(REALS))

    real_or_none = Option("f64")
    start = (("tolerance", real_or_none), ("start-time", "f64"), ("stop-time", real_or_none))
    return [
        Function("set-debug-logging", (("logging-on", "bool"), ("categories", List("string"))), STATUS),
        Function("enter-initialization-mode", start, STATUS),
        mode("exit-initialization-mode"),
        mode("enter-event-mode"),
        Function("update-discrete-states", (), _or_status(STATES_INFO)),
        *map(mode, ("terminate", "reset", "enter-configuration-mode", "exit-configuration-mode")),
        *(about(f"get-{name}", content) for name, content in VALUES.items()),
        *(change(f"set-{name}", "values", content) for name, content in VALUES.items()),
        Function("get-number-of-variable-dependencies", (("vr", REFERENCE),), _or_status("u64")),
        Function("get-variable-dependencies", (("dependent", REFERENCE),), _or_status(List(DEPENDENCY))),
        Function("get-fmu-state", (), _or_status(STATE)),
        Function("set-fmu-state", (("state", STATE),), STATUS),
        *map(derivative, ("get-directional-derivative", "get-adjoint-derivative")),
        about("get-interval-decimal", Tuple(("f64", QUALIFIER))),
        about("get-interval-fraction", Tuple((FRACTION, QUALIFIER))),
        about("get-shift-decimal", "f64"),
        about("get-shift-fraction", FRACTION),
        change("set-interval-decimal", "intervals", "f64"),
        change("set-interval-fraction", "intervals", FRACTION),
        change("set-shift-decimal", "shifts", "f64"),
        change("set-shift-fraction", "shifts", FRACTION),
        mode("evaluate-discrete-states"),
        mode("enter-step-mode"),
        Function(
            "get-output-derivatives", (("requests", List(Tuple((REFERENCE, "u32")))),), _or_status(REALS)
        ),
    ]


NAME_TOKEN_PATH: tuple[Argument, ...] = (
    *(("instance-name", "string"), ("instantiation-token", "string"), ("resource-path", "string")),
    *(("visible", "bool"), ("logging-on", "bool")),
)
STEP_RESULT = Record(
    (
        ("last-successful-time", "f64"),
        ("event-handling-needed", "bool"),
        ("terminate-simulation", "bool"),
        ("early-return", "bool"),
    )
)
INTEGRATOR_STEP_RESULT = Record((("enter-event-mode", "bool"), ("terminate-simulation", "bool")))
NO_STATE_BEFORE: Argument = ("no-set-fmu-state-prior-to-current-point", "bool")


@dataclass(frozen=True)
class Interface:
    """What the component exports under one name.

    `own_types` are defined here, besides those of the interface `types`. `resource` is the name of the type
    that stands for an instance of the FMU, or "".
    """

    name: str
    functions: tuple[Function, ...]
    resource: str = ""
    own_types: dict[str, Type] = field(default_factory=dict)

    @property
    def types(self) -> dict[str, Type]:
        """All types of which the functions are made, each after those of which it is made itself."""
        return {**TYPES, **self.own_types} if self.resource else {}

    @property
    def exported_types(self) -> tuple[str, ...]:
        return (*USED, *self.own_types, self.resource) if self.resource else ()


def _of_instances(
    name: str, own_types: dict[str, Type], arguments: Iterable[Argument], methods: Iterable[Function]
) -> Interface:
    """An interface of instances: `arguments` of the instantiation and `methods` that this interface alone
    has."""
    resource = f"{name}-instance"
    me = ("self", Handle(resource, owned=False))
    instantiate = Function(
        f"[static]{resource}.instantiate-{name}",
        (*NAME_TOKEN_PATH, *arguments),
        Option(Handle(resource, owned=True)),
    )
    all_methods = (
        Function(f"[method]{resource}.{f.name}", (me, *f.parameters), f.result)
        for f in (*_shared_methods(), *methods)
    )
    return Interface(name, (instantiate, *all_methods), resource, own_types)


COMMON = Interface("common", (Function("get-version", (), "string"),))
CO_SIMULATION = _of_instances(
    "co-simulation",
    {"do-step-result": STEP_RESULT},
    (
        ("event-mode-used", "bool"),
        ("early-return-allowed", "bool"),
        ("required-intermediate-variables", REFERENCES),
    ),
    [
        Function(
            "set-input-derivatives",
            (("requests", List(Tuple((REFERENCE, "u32")))), ("values", REALS)),
            STATUS,
        ),
        Function(
            "do-step",
            (("current-communication-point", "f64"), ("communication-step-size", "f64"), NO_STATE_BEFORE),
            _or_status(Named("do-step-result")),
        ),
    ],
)
MODEL_EXCHANGE = _of_instances(
    "model-exchange",
    {"completed-step-result": INTEGRATOR_STEP_RESULT},
    (),
    [
        Function("enter-continuous-time-mode", (), STATUS),
        Function("set-time", (("time", "f64"),), STATUS),
        Function("set-continuous-states", (("continuous-states", REALS),), STATUS),
        *(
            Function(f"get-{name}", (), _or_status(REALS))
            for name in (
                *("continuous-state-derivatives", "event-indicators", "continuous-states"),
                "nominals-of-continuous-states",
            )
        ),
        *(
            Function(f"get-number-of-{name}", (), _or_status("u64"))
            for name in ("event-indicators", "continuous-states")
        ),
        Function("completed-integrator-step", (NO_STATE_BEFORE,), _or_status(Named("completed-step-result"))),
    ],
)


def manifests() -> dict[str, str]:
    """Member of the FMU -> content, by which an FMU says that it follows the layered standard. The draft and
    FMI 3.0 name the file differently: the FMU holds the file under both names."""
    text = f"""\
<?xml version="1.0" encoding="UTF-8"?>
<fmi-ls:fmiLayeredStandardManifest
  xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
  fmi-ls:fmi-ls-name="{LAYERED_STANDARD}"
  fmi-ls:fmi-ls-version="{DRAFT}"
  fmi-ls:fmi-ls-description="FMI Layered Standard for WebAssembly"/>
"""
    return {f"extra/{LAYERED_STANDARD}/{name}": text for name in ("manifest.xml", "fmi-ls-manifest.xml")}
