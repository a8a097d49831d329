"""Writes radau_table.h and lobatto_table.h: the coefficients of collocation, computed at 60 digits.

    python fmu_src/tools/make_collocation.py [--check]

Radau IIA: nodes c_1 < ... < c_s = 1 are the zeros of the polynomial of degree s that is orthogonal to all of
degree s - 2 on [0, 1] with weight 1 and vanishes at 1: P_s(2c - 1) - P_{s-1}(2c - 1), P Legendre polynomials
(E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.5). Lobatto IIIA with four stages: nodes
0, (5 - sqrt 5)/10, (5 + sqrt 5)/10, 1 (the same section). All other numbers follow from interpolation in
the nodes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

import generated
import mpmath

NUMERICS = Path(__file__).resolve().parent.parent / "numerics"
RADAU, LOBATTO = NUMERICS / "radau_table.h", NUMERICS / "lobatto_table.h"
STAGES = (3, 5, 7)
MP = mpmath.MPContext()
MP.dps = 60
Number = Any  # of MP
Polynomial = list[Any]  # coefficients, constant first


def multiply(p: Polynomial, q: Polynomial) -> Polynomial:
    product = [MP.mpf(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            product[i + j] += a * b
    return product


def integral(p: Polynomial) -> Polynomial:
    return [MP.mpf(0), *(a / (k + 1) for k, a in enumerate(p))]


def value(p: Polynomial, x: Number) -> Number:
    return MP.polyval(p[::-1], x)


def nodes(s: int) -> list[Number]:
    def legendre(n: int, c: Number) -> Number:
        return MP.legendre(n, 2 * c - 1)

    def defining(c: Number) -> Number:
        return legendre(s, c) - legendre(s - 1, c)

    grid = [MP.mpf(k) / 2000 for k in range(2000)]
    found = [
        MP.findroot(defining, (a, b), solver="anderson", tol=MP.mpf(10) ** -55)
        for a, b in pairwise(grid)
        if defining(a) * defining(b) < 0
    ]
    assert len(found) == s - 1
    return [*found, MP.mpf(1)]


def lagrange(points: list[Number], j: int) -> Polynomial:
    """Coefficients of the polynomial that is 1 at points[j] and 0 at the other points."""
    p = [MP.mpf(1)]
    for k, x in enumerate(points):
        if k != j:
            p = multiply(p, [-x / (points[j] - x), 1 / (points[j] - x)])
    return p


def largest(p: Polynomial) -> Number:
    return max(abs(value(p, MP.mpf(k) / 1000)) for k in range(1001))


def bernstein_of_monomials(degree: int) -> Callable[[Polynomial], list[Number]]:
    def convert(p: Polynomial) -> list[Number]:
        return [
            MP.fsum(MP.binomial(i, k) / MP.binomial(degree, k) * p[k] for k in range(i + 1))
            for i in range(degree + 1)
        ]

    return convert


def row(numbers: Iterable[Number]) -> str:
    exact = (x if abs(x) > MP.mpf(10) ** -40 else MP.mpf(0) for x in numbers)
    return "{" + ", ".join(MP.nstr(x, 20, strip_zeros=True) for x in exact) + "}"


def declaration(name: str, lines: Iterable[str]) -> str:
    return f"static const {name} = {{\n" + "\n".join(lines) + "\n};\n"


def matrix(
    name: str, rows: Iterable[Iterable[Number]], write: Callable[[Iterable[Number]], str] = row
) -> str:
    indent = ",\n" + " " * (len(name) + 9)
    return f"    .{name} = {{{indent.join(write(numbers) for numbers in rows)}}},"


def defects(name: str, c: list[Number]) -> list[str]:
    """Lines with the largest single and double integral of prod(1 - x/c_i) over [0, 1].

    This product is the shape of the error of a polynomial through the nodes c_i."""
    defect = [MP.mpf(1)]
    for x in c:
        defect = multiply(defect, [MP.mpf(1), -1 / x])
    sweep = integral(defect)
    return [
        f"    .{name}_once = {MP.nstr(largest(sweep), 6)},",
        f"    .{name}_twice = {MP.nstr(largest(integral(sweep)), 6)},",
    ]


def radau(s: int) -> str:
    c = nodes(s)
    basis = [lagrange(c, j) for j in range(s)]
    once = [integral(p) for p in basis]
    twice = [integral(p) for p in once]
    to_bernstein = bernstein_of_monomials(s)
    return declaration(
        f"Radau RADAU_{s}",
        [
            f"    .stages = {s},",
            f"    .node = {row(c)},",
            matrix("once", ([value(p, x) for x in c] for p in once)),
            matrix("twice", ([value(p, x) for x in c] for p in twice)),
            f"    .weight = {row(value(p, MP.mpf(1)) for p in once)},",
            f"    .at_start = {row(value(p, MP.mpf(0)) for p in basis)},",
            *defects("defect", c),
            matrix("bernstein", (to_bernstein(lagrange([MP.mpf(0), *c], j)) for j in range(s + 1))),
        ],
    )


def union(numbers: Iterable[Number]) -> str:
    return "{" + row(numbers) + "}"


def lobatto() -> str:
    c = [MP.mpf(0), (5 - MP.sqrt(5)) / 10, (5 + MP.sqrt(5)) / 10, MP.mpf(1)]
    basis = [lagrange(c, j) for j in range(4)]
    once = [integral(p) for p in basis]
    twice = [integral(p) for p in once]
    return declaration(
        "Lobatto LOBATTO",
        [
            f"    .node = {union(c)},",
            matrix("once", ([value(p, x) for x in c] for p in once), union),
            matrix("twice", ([value(p, x) for x in c] for p in twice), union),
            f"    .weight = {union(value(p, MP.mpf(1)) for p in once)},",
            f"    .missed = {MP.nstr(MP.fprod(c[1:]), 20)},",
            *defects("missed", c[1:]),
            matrix("bernstein", (bernstein_of_monomials(3)(p) for p in basis), union),
        ],
    )


def texts() -> dict[Path, str]:
    head = generated.head_of(__file__)
    return {RADAU: head + "\n".join(radau(s) for s in STAGES), LOBATTO: head + lobatto()}


if __name__ == "__main__":
    sys.exit(generated.write_or_check(texts, __file__))
