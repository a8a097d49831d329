"""Friction laws for hypothesis, over many decades: Stribeck's law, lubricated branches, load laws, and tables
over speed and load."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

MASSES = ("inertia.shaft", "inertia.follower_mass", "inertia.follower")
DAMPER = ("damper.c_load", "damper.c_release", "damper.q_load", "damper.q_release")
LARGEST_POWER = 0.9  # of the load


def decades(low: float, high: float) -> SearchStrategy[float]:
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


def or_zero(strategy: SearchStrategy[float]) -> SearchStrategy[float]:
    return st.one_of(strategy, st.just(0.0))


def is_inertial(parameters: Mapping[str, Any]) -> bool:
    return any(parameters[name] for name in MASSES)


SPEED_LAWS: SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {f"cam{i}.friction_viscous": or_zero(decades(-4, 1)) for i in (1, 2)}
    | {f"cam{i}.friction_peak": st.one_of(st.just(1.0), st.floats(1.0, 5.0)) for i in (1, 2)}
    | {f"cam{i}.stribeck_velocity": decades(-6, 1) for i in (1, 2)}
    | {f"cam{i}.stribeck_exponent": st.sampled_from([1, 2]) for i in (1, 2)}
)
LOAD_LAWS: SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {f"cam{i}.friction_load_exponent": or_zero(st.floats(-LARGEST_POWER, LARGEST_POWER)) for i in (1, 2)}
    | {f"cam{i}.friction_load": decades(-1, 5) for i in (1, 2)}
)


def table_files(folder: Path) -> SearchStrategy[str]:
    """Files v_m_s,R_N,mu: three to five speeds, two to four loads. From load to load mu goes with a power of
    the load, which the FMU limits."""

    def write(drawn: tuple[list[float], float, list[float], list[float], list[float]]) -> str:
        gaps, load, ratios, logs, powers = drawn
        speeds = [0.0, *np.cumsum(gaps)]
        rows, at_load = [], [0.1 * math.exp(x) for x in logs[: len(speeds)]]
        for ratio, power in zip([1.0, *ratios], [0.0, *powers], strict=False):
            load *= ratio
            at_load = [min(mu * ratio**power, 10.0) for mu in at_load]
            rows += [f"{v!r},{load!r},{mu!r}" for v, mu in zip(map(float, speeds), at_load, strict=True)]
        path = folder / f"law-{abs(hash(tuple(rows))):x}.csv"
        path.write_text("\n".join(["v_m_s,R_N,mu", *rows, ""]))
        return str(path)

    return st.tuples(
        st.lists(decades(-3, 1), min_size=2, max_size=4),
        decades(0, 3),
        st.lists(st.floats(1.2, 10.0), min_size=1, max_size=3),
        st.lists(st.floats(-2.0, 1.0), min_size=5, max_size=5),
        st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3),
    ).map(write)


def friction_laws(parameters: Mapping[str, Any], folder: Path) -> SearchStrategy[dict[str, Any]]:
    """The laws of both cams: over the speed, and in every second draw over the load too. Without inertia
    friction takes no law over the speed, and beside a damper none over the load."""
    if not is_inertial(parameters):
        return st.just({}) if any(parameters.get(name) for name in DAMPER) else LOAD_LAWS
    both = st.tuples(SPEED_LAWS, LOAD_LAWS).map(lambda pair: pair[0] | pair[1])
    tables = st.fixed_dictionaries({"cam1.friction_table": st.one_of(table_files(folder), st.just(""))})
    return st.one_of(SPEED_LAWS, both, st.tuples(both, tables).map(lambda pair: pair[0] | pair[1]))
