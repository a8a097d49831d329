"""Correlated values by a Gaussian copula.

Each variable keeps its own distribution. Normal scores z = Phi^-1(share) get the correlation matrix R of the
copula: z' = L z with L L^T = R, and the new shares are Phi(z'). R follows from what the user states:

- rank (Spearman) correlation rho_s: R = 2 sin(pi rho_s/6), whatever the distributions (Kruskal 1958);
- Pearson correlation of the values: R solves E[F1^-1(Phi(z1)) F2^-1(Phi(z2))] (Nataf; NORTA of Cario and
  Nelson 1997), by Gauss-Hermite quadrature and Brent's method.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dualcam.common.entries import hint
from dualcam.common.mistakes import StudyError
from dualcam.fmi.reals import Array
from dualcam.study.plan.vary import Vary

NODES = 40  # of Gauss-Hermite quadrature in each direction
OPEN = 2.0**-53  # least distance of shares from 0 and 1, where scores are infinite
LEAST_EIGENVALUE = 1e-10  # of the matrix of the copula


@dataclass(frozen=True)
class Correlation:
    """How two variables go together.

    Parameters
    ----------
    first, second : Names of two variables that vary.
    value : Correlation, above -1 and below 1.
    kind : "rank": Spearman's correlation of the ranks. "pearson": Pearson's correlation of the values.

    Examples
    --------
    >>> from dualcam.study import Correlation
    >>> Correlation("cam1.friction", "cam2.friction", 0.8).kind
    'rank'
    """

    first: str
    second: str
    value: float
    kind: str = "rank"

    def problems(self, vary: Mapping[str, Vary]) -> list[str]:
        """All that is wrong.

        Parameters
        ----------
        vary : What varies, by name.

        Returns
        -------
        list of str
            What is given and what is allowed.
        """
        found = []
        if self.kind not in ("rank", "pearson"):
            found.append(f"kind = {self.kind!r}: allowed are rank, pearson")
        if self.first == self.second:
            found.append(f"{self.first} with itself: allowed are two variables")
        for name in dict.fromkeys((self.first, self.second)):
            if name not in vary:
                found.append(f"{name} does not vary{hint(name, vary)}")
            elif vary[name].texts is not None:
                found.append(f"{name} varies over texts, which have no order: allowed are numbers")
        if not -1.0 < self.value < 1.0:
            found.append(f"{self.kind} = {self.value:g}: allowed is above -1 and below 1; use same_as for 1")
        return found


class Copula:
    """The Gaussian copula of some variables, in the order of `vary`. The correlations have no problems, and
    each pair of names stands once.

    StudyError for correlations that contradict each other or that these distributions cannot have."""

    def __init__(self, vary: Mapping[str, Vary], correlations: Sequence[Correlation]) -> None:
        names = list(vary)
        matrix = np.eye(len(names))
        for each in correlations:
            i, j = names.index(each.first), names.index(each.second)
            is_rank = each.kind == "rank"
            score = 2.0 * math.sin(math.pi * each.value / 6.0) if is_rank else _nataf(vary, each)
            matrix[i, j] = matrix[j, i] = score
        eigenvalues, vectors = np.linalg.eigh(matrix)
        if eigenvalues[0] < LEAST_EIGENVALUE:
            raise StudyError(_contradiction(names, matrix, vectors[:, 0], eigenvalues[0]))
        self.matrix = matrix
        self._factor = np.linalg.cholesky(matrix)

    def shares(self, independent: Array) -> Array:
        """Shares with the correlation, of independent shares in (0, 1), shape (n, variables)."""
        from scipy.special import ndtr, ndtri

        return np.asarray(ndtr(ndtri(independent) @ self._factor.T))


def _contradiction(names: Sequence[str], matrix: Array, vector: Array, eigenvalue: float) -> str:
    """The message, with the share of all correlations that would work."""
    involved = [name for name, part in zip(names, vector, strict=True) if abs(part) > 0.1]
    # The eigenvalues of I + s (R - I) are 1 + s (eigenvalue - 1).
    share = math.floor(100.0 * (1.0 - LEAST_EIGENVALUE) / (1.0 - eigenvalue)) / 100.0
    return (
        f"correlations of {', '.join(involved)} contradict each other: their matrix has the eigenvalue "
        f"{eigenvalue:.3g}, allowed is above 0. All of them times {share:.2f} would work"
    )


def _nataf(vary: Mapping[str, Vary], wanted: Correlation) -> float:
    """Correlation of the normal scores that gives the values their Pearson correlation."""
    from scipy.optimize import brentq

    reached = _pearson(vary[wanted.first], vary[wanted.second])
    low, high = reached(-1.0 + 1e-9), reached(1.0 - 1e-9)
    if not low < wanted.value < high:
        found = f"correlation of {wanted.first} and {wanted.second}: pearson = {wanted.value:g}"
        raise StudyError(f"{found}: these distributions allow {low:.3f} to {high:.3f}")
    return float(brentq(lambda rho: reached(rho) - wanted.value, -1.0 + 1e-9, 1.0 - 1e-9, xtol=1e-10))


def _pearson(one: Vary, other: Vary) -> Callable[[float], float]:
    """Pearson's correlation of the values as a function of that of the normal scores."""
    from scipy.special import ndtr

    def at(vary: Vary, scores: Array) -> Array:
        return vary.at(np.clip(ndtr(scores), OPEN, 1.0 - OPEN))

    nodes, weights = np.polynomial.hermite_e.hermegauss(NODES)
    weights = weights / weights.sum()
    x, y = at(one, nodes), at(other, nodes)
    mean_x, mean_y = weights @ x, weights @ y
    std_x, std_y = (math.sqrt(weights @ (v - mean) ** 2) for v, mean in ((x, mean_x), (y, mean_y)))

    def correlation(rho: float) -> float:
        second = rho * nodes[:, None] + math.sqrt(1.0 - rho * rho) * nodes
        values = at(other, second.ravel()).reshape(second.shape)
        mixed = weights @ ((x - mean_x)[:, None] * (values - mean_y)) @ weights
        return float(mixed / (std_x * std_y))

    return correlation
