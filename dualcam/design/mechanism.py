"""A pair of grooves with friction and a spring: geometry and slow torque over the whole range at once."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import real_array
from dualcam.common.unit_guards import unit_warning, warn_units
from dualcam.design.grooves import Groove, Table, both_parameters, curvature
from dualcam.design.load_law import LoadLaw, friction_under
from dualcam.design.statics import Array, Pair, band, sign_of, transfer
from dualcam.errors import DesignError

POINTS = 721  # of theta, where a property of the whole range is sought
STOP_SLACK = 1e-9  # of an angle: rounding of degrees and of sums of steps may pass a stop by that much
END_SLACK = 1e-12  # of an angle: a groove may end that much before a stop, as in the FMU


@dataclass(frozen=True)
class Spring:
    """The spring: F_s(z) = preload + stiffness z + stiffness2 z^2 + stiffness3 z^3.

    `preload`: force at z = 0 [N]. `stiffness`, `stiffness2`, `stiffness3`: coefficients [N/m, N/m2, N/m3].

    Examples
    --------
    >>> from dualcam.design import Spring
    >>> spring = Spring(preload=50.0, stiffness=5e4)
    >>> float(spring.force(0.01))  # N, at 10 mm
    550.0
    """

    preload: float
    stiffness: float
    stiffness2: float = 0.0
    stiffness3: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not math.isfinite(value):
                raise DesignError(f"spring: {name} = {value}: allowed is a finite number")
        warn_units({"stiffness": ("spring.stiffness", self.stiffness)})

    def force(self, z: ArrayLike) -> Array:
        """The force [N] at a compression `z` [m]."""
        z = real_array(z, "z", DesignError)
        return self.preload + z * (self.stiffness + z * (self.stiffness2 + z * self.stiffness3))

    def energy(self, z: ArrayLike) -> Array:
        """The energy stored from z = 0 to a compression `z` [m], in J."""
        z = real_array(z, "z", DesignError)
        thirds = self.stiffness2 / 3.0 + z * self.stiffness3 / 4.0
        return z * (self.preload + z * (0.5 * self.stiffness + z * thirds))

    def parameters(self) -> dict[str, float]:
        """The FMU's parameters: start values by name."""
        return {f"spring.{name}": value for name, value in vars(self).items()}


class Configuration(NamedTuple):
    """Position of the pin at given theta."""

    psi: Array  # angles gamma and phi = theta - gamma along the grooves [rad], shape (2, ...)
    z: Array  # lift [m]
    slope: Array  # a_i = dz/dpsi at psi_i [m/rad], shape (2, ...)
    d2z_dpsi2: Array  # g_i'' at psi_i [m/rad2], shape (2, ...)


@dataclass(frozen=True)
class Mechanism:
    """A pair of grooves with friction and a spring: geometry and torque of slow motion.

    Source: docs/mechanism.md, sections 2 and 3.

    Parameters
    ----------
    grooves : Groove laws of cam 1 and cam 2.
    friction : Coefficients of friction mu_1, mu_2 [1].
    spring : The spring on the follower.
    upper : Upper end of cam 2's angle theta [rad].
    contacts : Follower ends that share each load, 1 or 2.
    lower : Lower end of the angle [rad], 0 or less.
    load_laws : How the coefficient of each contact depends on its nominal load; None: it does not.

    Raises
    ------
    DesignError : A value that no mechanism has, such as another number of contacts.

    Examples
    --------
    >>> import math
    >>> from dualcam.design import Helix, Mechanism, Spring
    >>> groove = Helix(radius=0.02, lead_angle=math.pi / 4)
    >>> cam = Mechanism((groove, groove), (0.14, 0.14), Spring(50.0, 5e4), upper=1.3963)
    >>> release, load = cam.band(0.5)
    >>> round(float(release), 4), round(float(load), 4)  # N.m
    (2.2632, 3.9767)
    """

    grooves: tuple[Groove, Groove]
    friction: tuple[float, float]
    spring: Spring
    upper: float
    contacts: int = 2
    lower: float = 0.0
    load_laws: tuple[LoadLaw | None, LoadLaw | None] = (None, None)

    def __post_init__(self) -> None:
        if len(self.grooves) != 2:
            raise DesignError(f"{len(self.grooves)} grooves: allowed are 2, those of cam 1 and cam 2")
        check_pair("friction", self.friction, 0.0)
        if not (math.isfinite(self.lower) and math.isfinite(self.upper) and self.lower < self.upper):
            raise DesignError(
                f"upper = {self.upper} rad: allowed is a finite angle above lower = {self.lower} rad"
            )
        stops = {"lower": ("stop.lower", self.lower), "upper": ("stop.upper", self.upper)}
        pair = {f"friction[{i}]": (f"cam{i + 1}.friction", mu) for i, mu in enumerate(self.friction)}
        warn_units(stops | pair)
        if self.contacts not in (1, 2):
            raise DesignError(f"contacts = {self.contacts!r}: allowed are 1 and 2")

    @property
    def radius(self) -> tuple[float, float]:
        """Radii of both cams [m]."""
        return self.grooves[0].radius, self.grooves[1].radius

    def angles(self, points: int = POINTS) -> Array:
        """As many angles as `points` evenly over the range [rad]."""
        return np.linspace(self.lower, self.upper, points)

    def reach(self) -> tuple[float, float]:
        """The part of the range where the pin is in both grooves [rad]; the whole range if they are long
        enough. Both grooves meet at theta = 0, so they meet between 0 and any angle where they meet."""
        return self._farthest(self.lower), self._farthest(self.upper)

    def _farthest(self, stop: float) -> float:
        """The stop, or the last angle before it where the grooves meet [rad]."""
        if self._meets(stop):
            return stop
        good, bad = 0.0, stop
        for _ in range(200):
            middle = 0.5 * (good + bad)
            if middle in (good, bad):
                break
            good, bad = (middle, bad) if self._meets(middle) else (good, middle)
        return stop if abs(stop - good) <= END_SLACK * (1.0 + abs(stop)) else good

    def _meets(self, theta: float) -> bool:
        """Whether some gamma has both grooves at one height; the difference of heights grows with gamma."""
        first, second = self.grooves
        low = max(first.range[0], theta - second.range[1], min(theta, 0.0))
        high = min(first.range[1], theta - second.range[0], max(theta, 0.0))
        if low > high:
            return False
        below = float(first.at(low).z) - float(second.at(theta - low).z)
        above = float(first.at(high).z) - float(second.at(theta - high).z)
        return below <= 0.0 <= above

    def configuration(self, theta: ArrayLike) -> Configuration:
        """Geometry at an angle `theta` of cam 2 [rad]: the root gamma of g_1(gamma) = g_2(theta - gamma).

        DesignError: an angle beyond a stop.
        """
        theta = self._between_stops(theta)
        first, second = self.grooves
        gamma = 0.5 * theta if first is second else meeting(first, second, theta)
        one, two = first.at(gamma), second.at(theta - gamma)
        return Configuration(
            np.stack([gamma, theta - gamma]),
            one.z,
            *(np.stack(pair) for pair in zip(one[1:], two[1:], strict=True)),
        )

    def _between_stops(self, theta: ArrayLike) -> Array:
        """`theta` [rad] as an array. DesignError, with the farthest angle, where one is beyond a stop.

        Zero is allowed, too: the preload is that at theta = 0.
        """
        theta = real_array(theta, "theta", DesignError)
        low, high = min(self.lower, 0.0), max(self.upper, 0.0)
        beyond = np.maximum(low - theta - STOP_SLACK * (1.0 - low), theta - high - STOP_SLACK * (1.0 + high))
        if not (beyond > 0.0).any():
            return theta
        angle = float(np.ravel(theta)[np.nanargmax(beyond)])
        looks = (unit_warning("table.theta", angle) or "").partition(": ")[2]
        raise DesignError(
            f"theta = {angle:.9g} rad: allowed are angles between the stops, {low:.6g} to {high:.6g} rad"
            f"{looks and f'; {looks}'}"
        )

    def torque(self, theta: ArrayLike, direction: str) -> Array:
        """The torque of slow motion rho_sigma F_s [N.m] at `theta` [rad], on the flanks that support the
        spring.

        `direction`: "loading", "releasing" or "frictionless". DesignError: another direction, or an angle
        beyond a stop.
        """
        configuration = self.configuration(theta)
        force = self.spring.force(configuration.z)
        friction = self.friction_under(configuration.slope, force)
        rho = transfer(configuration.slope, friction, self.radius, sign_of(direction)).rho
        return np.asarray(rho * force)

    def band(self, theta: ArrayLike) -> tuple[Array, Array]:
        """The FMU's `torque_release` and `torque_load` [N.m] at `theta` [rad]; F_s must be > 0.

        DesignError: an angle beyond a stop.
        """
        configuration = self.configuration(theta)
        force = self.spring.force(configuration.z)
        (release, load), _ = self.edges(configuration.slope, force)
        return release * force, load * force

    def friction_under(self, slope: Pair, force: Array) -> Pair:
        """Coefficients of friction at rest [1] on grooves of `slope` [m/rad] under an axial `force` [N]."""
        return friction_under(self.friction, self.load_laws, slope, self.radius, force / self.contacts)

    def edges(self, slope: Pair, force: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """The edges of the stick band over the axial `force` [m], and the reactions there over it [1].

        They are (T_release/F, T_load/F) and the normal forces over F. `slope`: dz/dpsi of both grooves
        [m/rad]. `force` [N]: on it depend coefficients that have a load law.
        """
        return band(slope, self.friction_under(slope, force), self.radius)

    def curvature(self, theta: ArrayLike) -> Array:
        """Curvature of both unwrapped grooves at the pin [1/m], shape (2, ...), at `theta` [rad].

        DesignError: an angle beyond a stop.
        """
        psi = self.configuration(theta).psi
        return np.stack([curvature(groove, psi[i]) for i, groove in enumerate(self.grooves)])

    def parameters_without_tables(self) -> dict[str, float | int]:
        """The FMU's parameters that are numbers."""
        found: dict[str, float | int] = {"stop.lower": self.lower, "stop.upper": self.upper}
        found |= self.spring.parameters() | both_parameters(self.grooves) | {"contacts": self.contacts}
        return found | {f"cam{i}.friction": mu for i, mu in enumerate(self.friction, 1)}

    def parameters(self, directory: str | Path) -> dict[str, float | int | str]:
        """Start values for `Fmu.start`. Tables go into `directory`, as `groove1.csv`, `groove2.csv`."""
        found: dict[str, float | int | str] = {**self.parameters_without_tables()}
        for i, groove in enumerate(self.grooves, 1):
            if isinstance(groove, Table):
                path = Path(directory).resolve() / f"groove{i}.csv"
                groove.write(path)
                found[f"cam{i}.table"] = str(path)
        return found


def meeting(first: Groove, second: Groove, theta: Array) -> Array:
    """The angle gamma [rad] at which both grooves are equally high; an end where they do not meet."""
    low = np.maximum(first.range[0], theta - second.range[1])
    high = np.minimum(first.range[1], theta - second.range[0])
    # both grooves rise, so gamma is not outside [0, theta], but for rounding
    low, high = (
        np.maximum(low, np.minimum(theta, 0.0) - 1e-9),
        np.minimum(high, np.maximum(theta, 0.0) + 1e-9),
    )
    gamma = np.clip(0.5 * theta, low, high)
    before = high - low
    # Newton's steps can go to and fro between two slopes: where they do not shrink, the bracket is halved
    for _ in range(200):
        one, two = first.at(gamma), second.at(theta - gamma)
        excess, slope = one.z - two.z, one.slope + two.slope
        low, high = np.where(excess <= 0.0, gamma, low), np.where(excess >= 0.0, gamma, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            following = gamma - excess / slope
        step, close = np.abs(following - gamma), 4e-16 * (1.0 + np.abs(gamma))
        good = (following >= low) & (following <= high) & (step <= np.maximum(0.5 * before, close))
        following = np.where(good, following, 0.5 * (low + high))
        before, gamma = np.abs(following - gamma), following
        if (before <= close).all():
            break
    return gamma


def check_pair(name: str, values: Sequence[float], low: float) -> tuple[float, float]:
    """Two finite numbers from `low` on, else a DesignError that calls them `name`."""
    try:
        pair = tuple(float(value) for value in values)
    except (TypeError, ValueError):
        pair = ()
    if len(pair) != 2 or not all(math.isfinite(value) and value >= low for value in pair):
        raise DesignError(f"{name} = {values!r}: allowed are two finite numbers >= {low:g}")
    return pair[0], pair[1]
