"""What a groove law is, and what laws by a formula share."""

import math
from abc import ABC, abstractmethod
from dataclasses import fields
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import real_array
from dualcam.common.groove_laws import GrooveLaw
from dualcam.common.unit_guards import unit_warning
from dualcam.design.statics import Array
from dualcam.errors import DesignError

Numbers = Any  # a number or an array, also of complex numbers


class Point(NamedTuple):
    """A groove law at one angle or at many."""

    z: Array  # height [m], of the shape of psi
    slope: Array  # dz/dpsi [m/rad]
    d2z_dpsi2: Array  # second derivative [m/rad2]


class Groove(Protocol):
    """A groove law: its cam's radius [m], the range of angles where the law holds [rad], its values."""

    @property
    def radius(self) -> float: ...
    @property
    def range(self) -> tuple[float, float]: ...
    def at(self, psi: ArrayLike) -> Point:
        """The law at an angle `psi` [rad]; beyond its range, its value at that end."""
        ...

    def parameters(self) -> dict[str, float | int]:
        """The FMU's parameters after `cam1.` or `cam2.`, the file of a table apart."""
        ...


def curvature(groove: Groove, psi: ArrayLike) -> Array:
    """Curvature (g''/r^2)/(1 + (g'/r)^2)^(3/2) [1/m] of the unwrapped path of the pin's centre, + where the
    groove steepens.

    `groove`: the groove law z = g(psi) on a cam of radius r. `psi`: angle of the pin along the groove [rad].

    Examples
    --------
    >>> from dualcam.design import Helix, curvature
    >>> float(curvature(Helix(radius=0.02, lead_angle=0.7854), 0.3))  # a helix unwraps to a straight line
    0.0
    """
    point, r = groove.at(psi), groove.radius
    return point.d2z_dpsi2 / r**2 / (1.0 + (point.slope / r) ** 2) ** 1.5


class ClosedForm(ABC):
    """A groove law by a formula.

    A law is a dataclass: its fields are the radius and the parameters of `law`, in the order of both."""

    law: ClassVar[GrooveLaw]
    radius: float

    @staticmethod
    @abstractmethod
    def ends(radius: Numbers, *shape: Numbers) -> tuple[Numbers, Numbers]:
        """Where the law holds [rad], by `radius` [m] and the other fields, `shape`; also of arrays."""

    @staticmethod
    @abstractmethod
    def formula(psi: NDArray[Any], radius: Numbers, *shape: Numbers) -> Point:
        """The law at `psi` [rad] between its ends, by `radius` [m] and `shape`; also of arrays."""

    def steepness(self, lead_angle: float) -> float:
        """The value of `law.steepness` for a `lead_angle` [rad]: that at psi = 0, where the law has one."""
        return lead_angle

    @cached_property
    def _values(self) -> list[float]:
        return [getattr(self, field.name) for field in fields(self)]  # type: ignore[arg-type]

    @property
    def range(self) -> tuple[float, float]:
        """Where the law holds [rad]."""
        low, high = self.ends(*self._values)
        return float(low), float(high)

    def at(self, psi: ArrayLike) -> Point:
        """The law at `psi` [rad]; beyond its range, its value at that end."""
        low, high = self.range
        inside = np.minimum(np.maximum(real_array(psi, "psi", DesignError), low), high)
        return self.formula(inside, *self._values)

    def parameters(self) -> dict[str, float | int]:
        """The FMU's parameters after `cam1.` or `cam2.`."""
        names = ("radius", *self.law.parameters)
        return {"profile": self.law.number, **dict(zip(names, self._values, strict=True))}


def check(what: str, value: float, good: bool, allowed: str) -> None:
    """DesignError unless the value is good."""
    if not good:
        raise DesignError(f"{what} = {value}: allowed is {allowed}")


def check_radius(radius: float) -> None:
    """DesignError for a radius that no cam has."""
    check("radius", radius, 0.0 < radius < math.inf, "a finite number > 0 in m")


def check_lead_angle(value: float) -> None:
    """DesignError for a lead angle outside [0, pi/2), with the likely unit."""
    hint = unit_warning("cam1.lead_angle", value, "lead_angle") or ""
    likely = f"; {hint.partition(': ')[2]}" if hint else ""
    check("lead_angle", value, 0.0 <= value < 0.5 * math.pi, f"[0, pi/2) in rad{likely}")
