"""Steps and inputs at the end of the range of numbers, in a process of its own: a step that never ends cannot
be stopped from inside.

    python tests/support/extreme_scenes.py BINARY DualCamForward

One line for each scene that breaks a law: the step is refused with a reason, or all values are numbers; a
step lasts less than LONGEST; afterwards the instance goes on with ordinary inputs.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import driver
from driver import CO_SIMULATION, ERROR, OK, Driver

LONGEST = 2.0  # s, processor time of a step
HUGE = 1e308
MAY_BE_INFINITE = ("torque_load", "torque_release", "efficiency")
WORD = "allowed"  # that each refusal has
ELLIPSE = {
    "cam1.profile": 2,
    "cam1.lead_angle": 0.7,
    "cam1.ellipse_a": 0.15,
    "cam1.ellipse_b": 0.15,
    "cam1.radius": 0.03,
}
NO_INERTIA = {"inertia.shaft": 0.0}
STRIBECK = {"cam1.friction_peak": 1.5, "cam1.stribeck_velocity": 0.01, "cam2.friction_viscous": 0.1}
LOADED = {"cam1.friction_load_exponent": -0.4, "cam2.friction_load_exponent": 0.3}
MECHANISMS: dict[str, dict[str, Any]] = {
    "helices": {"initial.omega": 3.0},
    "damped shaft": {"shaft.damping": 10.0},
    "damped follower": {"damper.c_load": 1e6, "damper.c_release": 1e6},
    "without friction": {"cam1.friction": 0.0, "cam2.friction": 0.0, "stop.lower": -1e3, "stop.upper": 1e3},
    "helices without inertia": NO_INERTIA,
    "viscous helices": NO_INERTIA | {"damper.c_load": 100.0, "damper.c_release": 100.0},
    "ellipse": ELLIPSE,
    "viscous ellipse": ELLIPSE | NO_INERTIA | {"shaft.damping": 0.1},
    "ellipse without inertia": ELLIPSE | NO_INERTIA,
    "Stribeck": STRIBECK,
    "loads": LOADED,
    "ellipse with loads": ELLIPSE | STRIBECK | LOADED,
    "stiff": {"spring.stiffness": 1e9, "stop.restitution": 1.0, "shaft.damping": 1e-3},
    "fast start": {"initial.omega": 1e200},
}
STEPS = (1e-308, 1e-3, 1e10, 1e154, 1e305, HUGE)
INPUTS: dict[str, dict[str, list[float]]] = {
    "no inputs": {"tau": [0.0]},
    "torque": {"tau": [HUGE]},
    "torque down": {"tau": [-HUGE]},
    "force": {"F_ext": [HUGE]},
    "both": {"tau": [HUGE], "F_ext": [-HUGE]},
    "ramp": {"tau": [8.0, 1.0]},
    "steep ramp": {"tau": [8.0, -HUGE]},
    "rising force": {"tau": [8.0], "F_ext": [0.0, HUGE]},
    "second derivative": {"tau": [8.0, 0.0, -HUGE]},
    "third derivative": {"tau": [8.0, 0.0, 0.0, HUGE]},
    "all": {"tau": [HUGE, -HUGE, HUGE, -HUGE], "F_ext": [-HUGE, HUGE, HUGE, -HUGE]},
    "mixed": {"tau": [8.0, 1e300], "F_ext": [10.0, -1e200, 1e100]},
}
MOTIONS: dict[str, dict[str, list[float]]] = {
    "rest": {"theta": [0.3]},
    "end": {"theta": [0.3], "omega": [HUGE]},
    "acceleration": {"theta": [0.3], "omega": [-HUGE], "alpha": [HUGE]},
    "rate": {"theta": [0.3, HUGE]},
    "second derivative": {"theta": [0.3, -1.0, HUGE]},
    "derivative of omega": {"theta": [0.3], "omega": [1.0, 0.0, -HUGE]},
    "derivative of alpha": {"theta": [0.3], "alpha": [1.0, -HUGE, HUGE]},
    "force": {"theta": [0.4], "F_ext": [HUGE, -HUGE, HUGE]},
}


def set_inputs(fmu: Driver, inputs: dict[str, list[float]]) -> str:
    """Why the inputs are refused, or nothing."""
    for name, (value, *rates) in inputs.items():
        if fmu.try_set({name: value}) != OK or (rates and fmu.try_set_derivatives({name: rates}) != OK):
            return fmu.messages[-1].text
    return ""


def values_of(fmu: Driver) -> dict[str, float | None]:
    """All Reals and the derivatives of the outputs; None where the FMU refuses the value with a reason."""
    found: dict[str, float | None] = {}
    for name in fmu.model.names(type=["Real"]):
        status, (value,) = fmu.try_get([name])
        found[name] = value if status == OK else None
    for name in fmu.model.names(type=["Real"], causality=["output"]):
        for order in (1, 2):
            value = driver.to_c("Real", [0.0])
            orders = (driver.c_int * 1)(order)
            status = fmu.call("GetRealOutputDerivatives", fmu.model.references([name]), 1, orders, value)
            found[f"{name}, order {order}"] = value[0] if status == OK else None
    return found


def is_allowed(name: str, value: float | None) -> bool:
    """Is the value refused or finite? Where a contact locks, an edge of the stick band is infinite."""
    if value is None or math.isfinite(value):
        return True
    return name in MAY_BE_INFINITE and not math.isnan(value)


def problems_of(fmu: Driver, inputs: dict[str, list[float]], h: float) -> Iterator[str]:
    why = set_inputs(fmu, inputs)
    if why:
        yield from () if WORD in why else (f"unclear refusal: {why}",)
        return
    begun = time.process_time()
    status = fmu.call("DoStep", 0.0, h, 1)
    took = time.process_time() - begun
    if took > LONGEST:
        yield f"a step of {took:.1f} s"
    if status == ERROR and WORD not in fmu.messages[-1].text:
        yield f"unclear refusal: {fmu.messages[-1].text}"
    bad = [name for name, value in values_of(fmu).items() if not is_allowed(name, value)]
    if bad:
        yield f"not finite under {'OK' if status == OK else 'error'}: {bad}"
    yield from problems_after(fmu, inputs, h if status == OK else 0.0)


def problems_after(fmu: Driver, inputs: dict[str, list[float]], now: float) -> Iterator[str]:
    """With ordinary inputs the instance goes on, unless the time has no digits left for a step."""
    ordinary = {name: [0.3 if name == "theta" else 0.0, 0.0, 0.0, 0.0] for name in inputs}
    why = set_inputs(fmu, ordinary)
    if why:
        yield f"then refused: {why}"
        return
    h = max(1e-3, abs(now) * 1e-3)
    status = fmu.call("DoStep", now, h, 1)
    if status != OK and WORD not in fmu.messages[-1].text:
        yield f"then unclear refusal: {fmu.messages[-1].text}"
    lost = [name for name, value in values_of(fmu).items() if value is None or not is_allowed(name, value)]
    if lost:
        yield f"then without value: {lost}"


def scenes(identifier: str) -> Iterator[tuple[str, dict[str, Any], dict[str, list[float]], float]]:
    inverse = identifier == "DualCamInverse"
    for (name, parameters), (which, inputs), h in product(
        MECHANISMS.items(), (MOTIONS if inverse else INPUTS).items(), STEPS
    ):
        given = {n: v for n, v in parameters.items() if not (inverse and n.startswith("initial."))}
        yield f"{name}, {which}, h = {h:g}", given, inputs, h


def main(binary: str, identifier: str) -> None:
    library, model = driver.load(Path(binary)), driver.models[identifier]
    count = 0
    for label, parameters, inputs, h in scenes(identifier):
        print(f"begins {label}", flush=True)
        fmu = Driver(library, kind=CO_SIMULATION, model=model)
        fmu.set(parameters)
        fmu.setup()
        fmu.ok("EnterInitializationMode")
        if fmu.call("ExitInitializationMode") == OK:
            for problem in problems_of(fmu, inputs, h):
                print(f"wrong {label}: {problem}", flush=True)
        elif WORD not in fmu.messages[-1].text:
            print(f"wrong {label}: unclear refusal: {fmu.messages[-1].text}", flush=True)
        fmu.free()
        count += 1
    print(f"scenes {count}")


if __name__ == "__main__":
    main(*sys.argv[1:])
