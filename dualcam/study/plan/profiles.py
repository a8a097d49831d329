"""Groove tables with a random smooth error of their profile: the tolerance of a cut groove.

The error of the height z is a Gaussian process along psi with mean 0, standard deviation s and covariance

    s^2 exp(-(psi - psi')^2 / (2 l^2)),

where l is the correlation length (the squared exponential of Rasmussen and Williams, Gaussian Processes for
Machine Learning, 2006, equation 4.9). The process is drawn exactly at the points of the table, by the
eigenvectors of the covariance matrix."""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from dualcam.common.mistakes import StudyError
from dualcam.common.tables import GROOVE_HEADER, fmu_text
from dualcam.fmi.reals import Array
from dualcam.study.plan.texts import kept_file

POINTS_MAX = 2000  # of a table: the covariance matrix has the square of this
POINTS_PER_LENGTH = 2.0  # of the correlation length; fewer would cut the error's bends


@dataclass(frozen=True)
class RandomProfiles:
    """`count` tables of the groove z(psi) with a random error, each made where a run needs it. StudyError for
    numbers with which no such tables can be."""

    psi: Array  # rad
    z: Array  # m
    deviation: float  # of z, m
    correlation_length: float  # of the error, rad
    count: int
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("deviation", "correlation_length"):
            number = getattr(self, name)
            if not (np.isfinite(number) and number > 0.0):
                raise StudyError(f"{name} = {number:g}: allowed is a finite number above 0")
        if self.count < 1:
            raise StudyError(f"count = {self.count}: allowed is the number of tables, 1 or more")
        if len(self.psi) > POINTS_MAX:
            raise StudyError(f"a table of {len(self.psi)} points: allowed are up to {POINTS_MAX}")
        farthest = float(np.diff(self.psi).max())
        least = POINTS_PER_LENGTH * farthest
        if self.correlation_length < least:
            raise StudyError(
                f"correlation_length = {self.correlation_length:g} rad: the points of the table are up to "
                f"{farthest:.3g} rad apart: allowed is {least:.3g} rad or more; or give a table with more "
                "points"
            )
        self._check_rise()

    def _check_rise(self) -> None:
        falling = sum(bool(np.any(np.diff(self.height(place)) < 0.0)) for place in range(self.count))
        if falling:
            slope = float((np.diff(self.z) / np.diff(self.psi)).min())
            share, bend = 100.0 * falling / self.count, self.deviation / self.correlation_length
            raise StudyError(
                f"deviation = {self.deviation:g} m, correlation_length = {self.correlation_length:g} rad: "
                f"{share:.3g} % of the tables would fall somewhere, which the FMU refuses. The slope of the "
                f"error has the standard deviation {bend:.3g} m/rad, the least slope of the groove is "
                f"{slope:.3g} m/rad: give a smaller deviation or a longer correlation length"
            )

    @cached_property
    def _factor(self) -> Array:
        """F with F F^T = the covariance of the error at the points."""
        distance = (self.psi[:, None] - self.psi) / self.correlation_length
        eigenvalues, vectors = np.linalg.eigh(np.exp(-0.5 * distance**2))
        kept = eigenvalues > 1e-12 * eigenvalues[-1]
        return np.asarray(self.deviation * vectors[:, kept] * np.sqrt(eigenvalues[kept]))

    def height(self, place: int) -> Array:
        """Heights z [m] of a table with its error, by its number from 0, at the points `psi`."""
        random = np.random.default_rng([self.seed, place])
        return np.asarray(self.z + self._factor @ random.standard_normal(self._factor.shape[1]))

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, place: int) -> str:
        """The path of a table, which is written once on each machine."""
        text = fmu_text(GROOVE_HEADER, self.psi, self.height(place))
        return str(kept_file(f"profile{place}.csv", text.encode()))

    def label(self, place: int) -> str:
        """The number of the table, in the table of results."""
        return f"profile {place}"

    def facts(self) -> list[str]:
        """What makes two of these the same."""
        digest = hashlib.sha256(np.stack([self.psi, self.z]).tobytes()).hexdigest()
        numbers = (self.deviation, self.correlation_length, self.count, self.seed)
        return [digest, *(repr(number) for number in numbers)]


def profiles_of_file(
    path: Path, deviation: float, correlation_length: float, count: int, seed: int
) -> RandomProfiles:
    """Tables of a groove of a file, with an error. StudyError for a file that is no groove table."""
    from dualcam.design.groove_files import read_groove
    from dualcam.errors import DualcamError

    try:
        groove = read_groove(path)
    except (DualcamError, OSError, ValueError) as error:
        raise StudyError(f"table = {str(path)!r}: {error}") from error
    return RandomProfiles(groove.psi, groove.z, deviation, correlation_length, count, seed)
