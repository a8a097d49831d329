"""Tabulated grooves: interpolation, and the CSV files that hold the points."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

from .parameters import Refused


class Table:
    """Quintic Hermite pieces through (psi_j, z_j), twice continuously differentiable and monotone.

    Slope d_j and second derivative c_j are those of the polynomial through the five nearest knots (four, if
    there are no more). With the pieces' mean slopes Delta and widths h:
    1. d_j = max(d_j, 0); d_j = c_j = 0 beside a piece with Delta = 0
    2. c_j into [-4 d_j/h_right, 4 d_j/h_left]: then all Bernstein coefficients of g' but the middle one
       are >= 0
    3. per piece f = min(1, 5 Delta/s), s = 2 d_0 + c_0 h/4 + 2 d_1 - c_1 h/4: then so is the middle one
    4. d_j, c_j times the smaller f of the pieces beside knot j
    """

    def __init__(self, psi: Sequence[float], z: Sequence[float]) -> None:
        x, y = [float(v) for v in psi], [float(v) for v in z]
        if len(x) < 4 or any(b <= a for a, b in pairwise(x)) or any(b < a for a, b in pairwise(y)):
            raise Refused("a table needs 4 increasing points")
        h = [b - a for a, b in pairwise(x)]
        mean = [(b - a) / w for (a, b), w in zip(pairwise(y), h, strict=True)]
        n = len(x)
        d, c = [0.0] * n, [0.0] * n
        for j in range(n):
            d[j], c[j] = self._local_derivatives(x, y, j)
            beside = [k for k in (j - 1, j) if 0 <= k < n - 1]
            d[j] = max(d[j], 0.0)
            if any(mean[k] == 0 for k in beside):
                d[j] = c[j] = 0.0
            if j < n - 1:
                c[j] = max(c[j], -4 * d[j] / h[j])
            if j > 0:
                c[j] = min(c[j], 4 * d[j] / h[j - 1])
        factor = []
        for k in range(n - 1):
            s = 2 * d[k] + c[k] * h[k] / 4 + 2 * d[k + 1] - c[k + 1] * h[k] / 4
            factor.append(min(1.0, 5 * mean[k] / s) if s > 0 else 1.0)
        for j in range(n):
            f = min(factor[k] for k in (j - 1, j) if 0 <= k < n - 1)
            d[j], c[j] = f * d[j], f * c[j]
        self.knots, self.range, self.slopes, self.seconds = x, (x[0], x[-1]), d, c
        self.pieces = [
            self._piece(x[k], h[k], y[k], y[k + 1] - y[k], d[k], d[k + 1], c[k], c[k + 1])
            for k in range(n - 1)
        ]
        if not x[0] <= 0 <= x[-1]:
            raise Refused("a table must hold psi = 0")
        zero = self.derivatives(0.0, min(max(bisect_right(x, 0.0) - 1, 0), n - 2))[0]
        self.pieces = [(start, c0 - zero, *rest) for start, c0, *rest in self.pieces]

    @staticmethod
    def _local_derivatives(x: list[float], y: list[float], j: int) -> tuple[float, float]:
        """First and second derivative at x_j of the polynomial through the nearest knots, by Newton's form
        with x_j as the first point: p = y_j + t (u_1 + (t - t_1)(u_2 + (t - t_2)(u_3 + ...)))."""
        size = min(5, len(x))
        start = min(max(j - 2, 0), len(x) - size)
        order = [j] + [i for i in range(start, start + size) if i != j]
        t = [x[i] - x[j] for i in order]
        u = [y[i] - y[j] for i in order]
        for level in range(1, size):
            for i in range(size - 1, level - 1, -1):
                u[i] = (u[i] - u[i - 1]) / (t[i] - t[i - level])
        inner, slope = u[-1], 0.0  # value and slope of the factor of t
        for i in range(size - 2, 0, -1):
            slope = inner - t[i] * slope
            inner = u[i] - t[i] * inner
        return inner, 2 * slope

    @staticmethod
    def _piece(
        start: float, h: float, y: float, rise: float, d0: float, d1: float, c0: float, c1: float
    ) -> tuple[float, ...]:
        return (
            start,
            y,
            d0,
            c0 / 2,
            (20 * rise - (8 * d1 + 12 * d0) * h - (3 * c0 - c1) * h * h) / (2 * h**3),
            (-30 * rise + (14 * d1 + 16 * d0) * h + (3 * c0 - 2 * c1) * h * h) / (2 * h**4),
            (12 * rise - 6 * (d1 + d0) * h - (c0 - c1) * h * h) / (2 * h**5),
        )

    def derivatives(self, psi: float, piece: int) -> tuple[float, float, float]:
        start, c0, c1, c2, c3, c4, c5 = self.pieces[piece]
        t = psi - start
        return (
            c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))),
            c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4 + t * (5 * c5)))),
            2 * c2 + t * (6 * c3 + t * (12 * c4 + t * (20 * c5))),
        )


def read_table(path: str | Path) -> tuple[list[float], list[float]]:
    """psi and z of a CSV file, with or without a line of names."""
    lines = [line.split(",") for line in Path(path).read_text().splitlines() if line.strip()]
    if any(character.isalpha() and character not in "eE" for character in lines[0][0]):
        lines = lines[1:]
    return [float(line[0]) for line in lines], [float(line[1]) for line in lines]


def write_table(path: str | Path, psi: Iterable[float], z: Iterable[float]) -> None:
    rows = [f"{float(a)!r},{float(b)!r}" for a, b in zip(psi, z, strict=True)]
    Path(path).write_text("\n".join(["psi_rad,z_m", *rows]) + "\n")
