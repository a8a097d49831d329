"""Coefficients of the candidate integrators, to the last digit, as a header in C: integrator_tables.h."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.integrate._ivp import dop853_coefficients as dop853
from scipy.integrate._ivp.rk import RK45

NODES = 7  # of the largest collocation method
Long = np.longdouble


def legendre(degree: int) -> np.ndarray:
    """Power coefficients of the Legendre polynomial on [0, 1], lowest first."""
    powers = range(degree + 1)
    return np.array(
        [(-1) ** (degree + k) * math.comb(degree, k) * math.comb(degree + k, k) for k in powers], dtype=Long
    )


def evaluate(power: np.ndarray, x: Any) -> Any:  # noqa: ANN401
    total = Long(0) * x
    for c in power[::-1]:
        total = total * x + c
    return total


def integral(power: np.ndarray) -> np.ndarray:
    return np.concatenate([[Long(0)], power / np.arange(1, len(power) + 1, dtype=Long)])


def nodes(stages: int, radau: bool) -> np.ndarray:
    """Roots of P_s (Gauss) or of P_s - P_{s-1} (Radau IIA), polished in extended precision."""
    power = legendre(stages)
    if radau:
        power = power - np.append(legendre(stages - 1), Long(0))
    slope = power[1:] * np.arange(1, stages + 1, dtype=Long)
    x = np.sort(np.roots(power[::-1].astype(float)).real).astype(Long)
    for _ in range(6):
        x = x - evaluate(power, x) / evaluate(slope, x)
    if radau:
        x[-1] = Long(1)
    return x


def product_of(roots: Iterable[Long]) -> np.ndarray:
    """Power coefficients of the product of (1 - x / root)."""
    power = np.array([1], dtype=Long)
    for root in roots:
        power = np.append(power, Long(0)) - np.append(Long(0), power) / root
    return power


def lagrange(x: np.ndarray, k: int) -> np.ndarray:
    power = np.array([1], dtype=Long)
    for j, root in enumerate(x):
        if j != k:
            power = (np.append(Long(0), power) - np.append(power, Long(0)) * root) / (x[k] - root)
    return power


def number(value: float) -> str:
    return float(value).hex()


def braces(values: np.ndarray) -> str:
    if values.ndim == 1:
        return "{" + ", ".join(number(v) for v in values) + "}"
    return "{" + ",\n     ".join(braces(row) for row in values) + "}"


def collocation(name: str, stages: int, radau: bool) -> str:
    x = nodes(stages, radau)
    basis = [lagrange(x, k) for k in range(stages)]
    a = np.array([[evaluate(integral(p), xj) for p in basis] for xj in x])
    b = np.array([evaluate(integral(p), Long(1)) for p in basis])
    once = integral(product_of(x))
    grid = np.linspace(0, 1, 2001).astype(Long)
    fields = {
        "c": x,
        "b": b,
        "ba": np.array([sum(b[j] * a[j, k] for j in range(stages)) for k in range(stages)]),
        "start": np.array([p[0] for p in basis]),
        "a": a,
        "aa": np.array(
            [[sum(a[i, j] * a[j, k] for j in range(stages)) for k in range(stages)] for i in range(stages)]
        ),
    }
    lines = [f"    .{key} = {braces(values)}," for key, values in fields.items()]
    lines.append(f"    .omega_error = {number(np.abs(evaluate(once, grid)).max())},")
    lines.append(f"    .theta_error = {number(np.abs(evaluate(integral(once), grid)).max())},")
    return f"static const Collocation {name} = {{\n" + "\n".join(lines) + "\n};\n"


def weighted(row: np.ndarray, name: str) -> str:
    return " + ".join(f"{number(a)} * {name}[{j}]" for j, a in enumerate(row) if a != 0.0)


def explicit(name: str, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> str:
    """Straight-line code for the stages: zeros of the tableau cost nothing."""
    head = "(const Scene *m, const State *y, double h, double w[], double f[])"
    lines = [f"static inline void {name}_stages{head} {{", "    w[0] = y->omega;"]
    for i in range(1, len(b)):
        lines.append(f"    w[{i}] = y->omega + h * ({weighted(a[i, :i], 'f')});")
        at = f"y->theta + h * ({weighted(a[i, :i], 'w')})"
        lines.append(f"    f[{i}] = acceleration(m, y->t + {number(c[i])} * h, {at}, w[{i}]);")
    lines += ["}", f"INLINE double {name}_weigh(const double x[]) {{", f"    return {weighted(b, 'x')};", "}"]
    return "\n".join(lines) + "\n"


def tables() -> str:
    """The header with the coefficients of all methods."""
    rows = f"[{NODES}]"
    made = [
        "/* Written by benchmarks/integrators/tables.py. */",
        "#ifndef INTEGRATOR_TABLES_H",
        "#define INTEGRATOR_TABLES_H",
        f"typedef struct {{ double c{rows}, b{rows}, ba{rows}, start{rows}, a{rows}{rows}, aa{rows}{rows}; "
        "double omega_error, theta_error; } Collocation;",
        explicit("dp5", RK45.A, RK45.B, RK45.C),
        f"static const double DP5_ERROR[7] = {braces(RK45.E)};",
        explicit("dop853", dop853.A[:12, :12], dop853.B, dop853.C[:12]),
        f"static const double DOP853_ERROR3[12] = {braces(dop853.E3[:12])};",
        f"static const double DOP853_ERROR5[12] = {braces(dop853.E5[:12])};",
    ]
    made += [collocation(f"RADAU{s}", s, True) for s in (2, 3, 5, 7)]
    made += [collocation(f"GAUSS{s}", s, False) for s in (3, 5)]
    made.append("#endif\n")
    return "\n".join(made)
