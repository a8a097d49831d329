"""The torque band of many mechanisms at once: each parameter is an array over samples.

The axial force presses the pin onto the lower flank of both grooves, so its centre is e = clearance/2 below
the centre of the groove, along the normal (docs/design-tolerances.md):

    psi_i = u_i + (e_i/r_i) sin lambda_i     z = g_i(u_i) - e_i cos lambda_i     tan lambda_i = g_i'(u_i)/r_i

Unknown are u_1 and u_2, from psi_1 + psi_2 = theta and z_1 = z_2. The backlash is the angle by which cam 2
turns at the same z while the pin crosses to the other flanks. Complex parameters give derivatives: u is
solved for the real parts, and Newton's step from there has the exact imaginary part.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dualcam.design.grooves import ClosedForm, Groove, Point
from dualcam.design.load_law import friction_under
from dualcam.design.mechanism import Mechanism, meeting
from dualcam.design.statics import Array, band
from dualcam.errors import DesignError
from dualcam.fmi.variables import parameters_of

CLEARANCE, SCALE = "clearance", "groove_scale"
OWN = {  # parameters of this file: nominal value, allowed values
    CLEARANCE: (0.0, "a number >= 0 in m"),
    SCALE: (1.0, "a number > 0"),
}
COMMON = ("radius", "friction", CLEARANCE, SCALE)
WHOLE = ("ellipse_curvature",)  # parameters that are integers
SPRING = ("preload", "stiffness", "stiffness2", "stiffness3")
NEWTON = 50  # steps at most; a few are needed
SETTLED = 1e-13  # rad, a step that small is the last one
MISSED = 1e-9  # m, heights of the two grooves that differ by more do not meet

Values = Mapping[str, NDArray[Any]]
"""Name -> array of shape (samples,), real or complex."""


def names_of(mechanism: Mechanism) -> list[str]:
    """The parameters that can have a tolerance."""
    found = []
    for number, groove in enumerate(mechanism.grooves, 1):
        shape = groove.law.parameters if isinstance(groove, ClosedForm) else ()
        found += [f"cam{number}.{name}" for name in (*COMMON, *shape) if name not in WHOLE]
    return [*found, *(f"spring.{name}" for name in SPRING)]


def nominal(mechanism: Mechanism, name: str) -> float:
    """The mechanism's own value of a parameter."""
    owner, _, word = name.partition(".")
    if word in OWN:
        return OWN[word][0]
    if owner == "spring":
        return float(getattr(mechanism.spring, word))
    place = int(owner[-1]) - 1
    return float(
        mechanism.friction[place] if word == "friction" else mechanism.grooves[place].parameters()[word]
    )


def own_value(mechanism: Mechanism, name: str) -> float | None:
    """The value that a mechanism gives to a parameter; None for clearance and scale, which it lacks."""
    return None if name.partition(".")[2] in OWN else nominal(mechanism, name)


def allowed(name: str) -> tuple[float, float, str]:
    """Least and greatest value of a parameter, and both in words."""
    word = name.partition(".")[2]
    if word in OWN:
        return (0.0 if word == CLEARANCE else math.nextafter(0.0, 1.0)), math.inf, OWN[word][1]
    known = parameters_of("forward")[name]
    if word == "lead_angle":
        return 0.0, math.nextafter(0.5 * math.pi, 0.0), "a number from 0 to less than pi/2 in rad"
    return known.least, known.greatest, known.allowed()


@dataclass(frozen=True, eq=False)
class SampledBand:
    """Quantities of many mechanisms over the angle, each of shape (samples, n)."""

    load: Array  # edge of the stick band [N.m], +inf where a mechanism jams
    release: Array  # likewise, <= 0 where a mechanism locks itself
    efficiency: Array  # release over load [1]
    z: Array  # height of the pin [m]
    backlash: Array  # play of cam 2 where the axial force changes its sign [rad]


QUANTITIES = tuple(field.name for field in fields(SampledBand))
UNITS = {"load": "N.m", "release": "N.m", "efficiency": "1", "z": "m", "backlash": "rad"}


class _SampledGroove:
    """A groove law with parameters of shape (samples, 1), as the class Groove has it."""

    def __init__(self, groove: Groove, number: int, values: Values) -> None:
        given = {
            name.partition(".")[2]: np.asarray(array)[:, None]
            for name, array in values.items()
            if name.startswith(f"cam{number}.")
        }
        own = groove.parameters()
        self.law, self._scale = groove, given.get(SCALE, 1.0)
        self.radius = given.get("radius", groove.radius)
        self.half_clearance = 0.5 * given.get(CLEARANCE, 0.0)
        if isinstance(groove, ClosedForm):
            shape = [given.get(name, own[name]) for name in groove.law.parameters]
            self._values: list[Any] = [self.radius, *shape]

    @property
    def range(self) -> tuple[Any, Any]:
        if not isinstance(self.law, ClosedForm):
            return self.law.range
        return self.law.ends(*(np.real(value) for value in self._values))

    def at(self, psi: NDArray[Any]) -> Point:
        """The law. A table goes on straight beyond its ends."""
        z, slope, second = self._law(psi)
        return Point(self._scale * z, self._scale * slope, self._scale * second)

    def _law(self, psi: NDArray[Any]) -> Point:
        groove = self.law
        if isinstance(groove, ClosedForm):
            return groove.formula(psi, *self._values)
        inside = np.clip(psi.real, *groove.range)
        point = groove.at(inside)
        beyond = psi - inside  # also the imaginary part
        second = np.where(inside == psi.real, point.d2z_dpsi2, 0.0)
        return Point(point.z + point.slope * beyond, point.slope + second * beyond, second)


class _Flank:
    """A point of the pin's path on the lower flank of a groove, at the angle u along its centre."""

    def __init__(self, groove: _SampledGroove, u: NDArray[Any]) -> None:
        point = groove.at(u)
        tangent, e = point.slope / groove.radius, groove.half_clearance
        cosine = 1.0 / np.sqrt(1.0 + tangent**2)
        sine = tangent * cosine
        turn = point.d2z_dpsi2 / groove.radius * cosine**2  # d lambda/du
        self.slope = point.slope
        self.psi, self.z = u + e / groove.radius * sine, point.z - e * cosine
        self.upper_psi, self.upper_z = u - e / groove.radius * sine, point.z + e * cosine
        self.dpsi_du, self.dz_du = 1.0 + e / groove.radius * cosine * turn, point.slope + e * sine * turn
        self.upper_dz_du = point.slope - e * sine * turn


def sampled_band(mechanism: Mechanism, values: Values, theta: Array) -> SampledBand:
    """The torque band of each sample at the angles `theta`, of parameters `values`, complex ones too.
    DesignError: grooves that do not reach to an angle."""
    first, second = (_SampledGroove(groove, i, values) for i, groove in enumerate(mechanism.grooves, 1))
    one, two = _settle(first, second, values, theta)

    def value(name: str) -> Any:  # noqa: ANN401, array or number
        return np.asarray(values[name])[:, None] if name in values else nominal(mechanism, name)

    terms = [value(f"spring.{name}") for name in SPRING]
    force = terms[0] + one.z * (terms[1] + one.z * (terms[2] + one.z * terms[3]))
    slope, radius = (one.slope, two.slope), (first.radius, second.radius)
    at_rest = value("cam1.friction"), value("cam2.friction")
    friction = friction_under(at_rest, mechanism.load_laws, slope, radius, force / mechanism.contacts)
    (release, load), _ = band(slope, friction, radius)
    _require_pressing(force, theta)
    with np.errstate(invalid="ignore", divide="ignore"):
        efficiency = release / load
    backlash = sum(_play(groove, flank) for groove, flank in ((first, one), (second, two)))
    return SampledBand(load * force, release * force, efficiency, one.z, backlash)


def _settle(
    first: _SampledGroove, second: _SampledGroove, values: Values, theta: Array
) -> tuple[_Flank, _Flank]:
    """Where the pin is: Newton's method for u_1 and u_2, from the meeting without clearance."""
    real = {name: np.real(array) for name, array in values.items()}
    count = len(next(iter(values.values())))
    centres: Any = [_SampledGroove(one.law, i, real) for i, one in enumerate((first, second), 1)]
    wanted = np.broadcast_to(theta, (count, len(theta)))
    with np.errstate(invalid="ignore"):  # grooves that do not reach are refused below
        u1 = meeting(centres[0], centres[1], wanted)
    u2 = wanted - u1
    _require_meeting(centres, u1, u2, theta)
    for _ in range(NEWTON):
        one, two = _Flank(first, u1), _Flank(second, u2)
        angle, height = one.psi + two.psi - wanted, one.z - two.z
        with np.errstate(invalid="ignore", divide="ignore"):
            determinant = one.dpsi_du * two.dz_du + two.dpsi_du * one.dz_du
            step1 = (angle * two.dz_du + height * two.dpsi_du) / determinant
            step2 = (angle * one.dz_du - height * one.dpsi_du) / determinant
        if not np.isfinite(step1 + step2).all():
            raise DesignError("a sample has two level grooves at one angle: nothing fixes the pin there")
        u1, u2 = u1 - step1, u2 - step2
        if max(np.abs(step1).max(), np.abs(step2).max()) <= SETTLED:
            return _Flank(first, u1), _Flank(second, u2)
    raise DesignError(
        "the pin's place in the grooves is not found: the clearance is too large for the grooves"
    )


def _play(groove: _SampledGroove, flank: _Flank) -> Any:  # noqa: ANN401, array
    """Angle psi between the paths on the lower and on the upper flank at the same height [rad]."""
    if np.all(groove.half_clearance == 0.0) and not np.iscomplexobj(groove.half_clearance):
        return np.zeros(flank.z.shape, flank.z.dtype)
    u = flank.psi
    for _ in range(NEWTON):
        upper = _Flank(groove, u)
        with np.errstate(invalid="ignore", divide="ignore"):
            step = (upper.upper_z - flank.z) / upper.upper_dz_du
        u = u - step
        if np.nanmax(np.abs(step)) <= SETTLED:
            break
    return flank.psi - _Flank(groove, u).upper_psi


def _require_meeting(grooves: list[_SampledGroove], u1: Array, u2: Array, theta: Array) -> None:
    """DesignError if the grooves of a sample end before the range of angles does."""
    bad = ~(np.abs(grooves[0].at(u1).z - grooves[1].at(u2).z) <= MISSED)
    for groove, u in zip(grooves, (u1, u2), strict=True):
        low, high = groove.range
        bad |= (u < low - SETTLED) | (u > high + SETTLED)
    if bad.any():
        share = 100.0 * bad.any(axis=1).mean()
        first = theta[np.flatnonzero(bad.any(axis=0))[0]]
        raise DesignError(
            f"in {share:.3g} % of the samples a groove ends before the last angle, first at theta ="
            f" {first:.4g} rad: allowed are angles up to there, longer grooves, or narrower tolerances"
        )


def _require_pressing(force: NDArray[Any], theta: Array) -> None:
    """DesignError if the spring pulls: the band is that of a pin on the lower flanks."""
    bad = ~(force.real >= 0.0)
    if bad.any():
        share = 100.0 * bad.any(axis=1).mean()
        first = theta[np.flatnonzero(bad.any(axis=0))[0]]
        raise DesignError(
            f"in {share:.3g} % of the samples the spring force is below 0, first at theta = {first:.4g} rad:"
            " allowed is a spring that presses the pin down; more preload or narrower tolerances work"
        )
