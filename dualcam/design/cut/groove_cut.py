"""A groove as a workshop cuts it: path of the pin's axis between the stops, both flanks, round ends."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import real_array
from dualcam.common.unit_guards import warn_units
from dualcam.design.cut.pin_section import contact, contact_turn, section, section_radius
from dualcam.design.grooves import Groove, Point
from dualcam.design.mechanism import POINTS, Mechanism
from dualcam.design.statics import Array
from dualcam.errors import DesignError

LEAST_TRAVEL = 1e-6  # rad
ROTATIONS = {"counterclockwise": 1, "clockwise": -1}  # of cam 2 while loading, seen from +z


class Curve(NamedTuple):
    """A curve on a cylinder around the cam's axis.

    `psi`: angle [rad], in the direction in which the pin moves along the groove while loading. `z`: height
    [m]; 0 is the height of the pin's axis at theta = 0.
    """

    psi: Array
    z: Array


class Flanks(NamedTuple):
    """Both flanks of a groove on one cylinder.

    `upper`: the flank above the pin. `lower`: the flank below the pin: the flank that carries the spring.
    """

    upper: Curve
    lower: Curve


@dataclass(frozen=True, eq=False)
class GrooveCut:
    """The groove of one cam, for a pin whose axis is radial.

    Source: docs/cut-grooves.md, which derives the flanks.

    Parameters
    ----------
    mechanism : Both grooves and the stops: they say how far the pin moves in each groove.
    cam : Which cam, 1 or 2. Cam 1 stands still, cam 2 turns.
    pin_radius : Radius of the pin [m].
    run_out
        Length by which the groove goes on beyond both ends of the pin's travel [m], straight at the lead
        angle of that end, also where the groove law goes on. 0: the round ends of the groove touch the pin at
        the stops.
    loading : {"counterclockwise", "clockwise"}
        In which direction cam 2 turns while the spring is loaded, seen from +z. The groove of cam 1 is
        right-handed for counterclockwise, that of cam 2 left-handed; for clockwise the other way round.

    Raises
    ------
    DesignError
        A groove that cannot be cut: an undercut flank, a groove that ends before a stop, grooves that run
        into one another, a value outside its range.

    Examples
    --------
    >>> from dualcam.design import GrooveCut, Helix, Mechanism, Spring
    >>> helix = Helix(radius=0.02, lead_angle=0.7854)
    >>> mechanism = Mechanism((helix, helix), (0.14, 0.14), Spring(50.0, 5e4), upper=1.3963)
    >>> cut = GrooveCut(mechanism, cam=1, pin_radius=0.003)
    >>> round(1e3 * float(cut.centre(cut.end).z), 4)  # mm, height of the pin's axis at the upper stop
    13.9631
    >>> flanks = cut.flanks(0.3)
    >>> round(1e3 * float(flanks.upper.z - flanks.lower.z), 4)  # mm, between both contacts of the pin
    4.2305
    """

    mechanism: Mechanism
    cam: int
    pin_radius: float
    run_out: float = 0.0
    loading: str = "counterclockwise"

    def __post_init__(self) -> None:
        if self.cam not in (1, 2):
            raise DesignError(f"cam = {self.cam!r}: allowed are 1 and 2")
        if self.loading not in ROTATIONS:
            raise DesignError(f"loading = {self.loading!r}: allowed are {', '.join(ROTATIONS)}")
        if not 0.0 < self.pin_radius < self.radius:
            raise DesignError(
                f"pin_radius = {self.pin_radius:g} m: allowed is a number > 0 and below the radius of cam"
                f" {self.cam}, {self.radius:g} m"
            )
        if not 0.0 <= self.run_out < math.inf:
            raise DesignError(f"run_out = {self.run_out:g} m: allowed is a finite number >= 0")
        warn_units({"pin_radius": ("pin.radius", self.pin_radius)})
        self._require_reach()
        self._require_travel()
        self.require_no_undercut(self.radius)
        self.require_walls(self.radius)

    # ---- the path of the pin's axis ----

    @property
    def groove(self) -> Groove:
        """The groove law."""
        return self.mechanism.grooves[self.cam - 1]

    @property
    def radius(self) -> float:
        """Radius of the cam [m], where the model's contact acts."""
        return self.groove.radius

    @property
    def hand(self) -> int:
        """+1: a right-handed groove, -1: a left-handed one."""
        return ROTATIONS[self.loading] * (1 if self.cam == 1 else -1)

    @cached_property
    def travel(self) -> tuple[float, float]:
        """psi of the pin at the lower and at the upper stop [rad]."""
        stops = np.array([self.mechanism.lower, self.mechanism.upper])
        low, high = self.mechanism.configuration(stops).psi[self.cam - 1]
        return float(low), float(high)

    @cached_property
    def begin(self) -> float:
        """psi of the pin's axis where the groove begins [rad]."""
        return self.travel[0] - self._run_out_angle(self.travel[0])

    @cached_property
    def end(self) -> float:
        """psi of the pin's axis where the groove ends [rad]."""
        return self.travel[1] + self._run_out_angle(self.travel[1])

    def _run_out_angle(self, psi: float) -> float:
        return self.run_out / math.hypot(self.radius, float(self.groove.at(psi).slope))

    def centre(self, psi: ArrayLike) -> Point:
        """The height of the path of the pin's axis [m] and its derivatives by `psi` [rad], along the groove.

        Beyond the stops the path goes on straight.
        """
        angle = real_array(psi, "psi", DesignError)
        inside = np.clip(angle, *self.travel)
        point, beyond = self.groove.at(inside), angle - inside
        return Point(
            point.z + point.slope * beyond, point.slope, np.where(beyond == 0.0, point.d2z_dpsi2, 0.0)
        )

    def stops(self) -> Curve:
        """Where the pin's axis is at the lower and at the upper stop."""
        psi = np.array(self.travel)
        return Curve(psi, self.groove.at(psi).z)

    # ---- flanks ----

    def flanks(self, psi: ArrayLike, radius: float | None = None) -> Flanks:
        """The points where the pin touches both flanks, of the shape of `psi`.

        `psi`: angle of the pin's axis along the groove [rad]. `radius` of the cylinder on which the flanks
        are sought [m]; that of the cam if not given.
        """
        angle, point = real_array(psi, "psi", DesignError), self.centre(psi)
        touch = contact(point.slope, self.pin_radius, self.radius if radius is None else radius)
        return Flanks(
            Curve(angle + touch.angle, point.z + touch.height),
            Curve(angle - touch.angle, point.z - touch.height),
        )

    def round_end(self, at_end: bool, share: ArrayLike, radius: float | None = None) -> Curve:
        """Points of the groove's round end: the edge of the pin between its contacts with both flanks.

        They have the shape of `share`: places along the round end, 0 at the upper flank, 1 at the lower.
        `at_end`: the end beyond the upper stop, else beyond the lower one. `radius` of the cylinder [m]; that
        of the cam if not given.
        """
        rho = self.radius if radius is None else radius
        psi = self.end if at_end else self.begin
        point = self.centre(psi)
        first = contact_turn(point.slope, self.pin_radius, rho)
        half_turn = -math.pi if at_end else math.pi
        edge = section(first + half_turn * real_array(share, "share", DesignError), self.pin_radius, rho)
        return Curve(psi + edge.angle, point.z + edge.height)

    def angle(self, psi: ArrayLike, end: int = 0) -> Array:
        """The angle on the body of the cam [rad], counterclockwise seen from +z, 0 at the mark of the cam.

        At the mark the first end of the pin is at theta = 0. `psi`: angle along the groove [rad]. `end`:
        which end of the pin: a pin with two ends has a second groove, half a turn apart.
        """
        return self.hand * real_array(psi, "psi", DesignError) + 2.0 * math.pi * end / self.mechanism.contacts

    # ---- what cannot be cut ----

    def _require_reach(self) -> None:
        low, high = self.mechanism.reach()
        for name, stop, found in (
            ("lower", self.mechanism.lower, low),
            ("upper", self.mechanism.upper, high),
        ):
            if found != stop:
                raise DesignError(
                    f"the grooves end at theta = {found:.6g} rad, before the {name} stop at {stop:.6g} rad:"
                    f" allowed is a stop.{name} up to there, or grooves that go on"
                )

    def _require_travel(self) -> None:
        low, high = self.travel
        if not high - low > LEAST_TRAVEL:
            raise DesignError(
                f"cam {self.cam}: the pin stays at psi = {low:.6g} rad of this groove from stop to stop:"
                " allowed is a groove along which the pin moves; the other groove must not be level"
            )

    def require_no_undercut(self, radius: float) -> None:
        """DesignError, with the place and the greatest pin that works, if a flank folds at a `radius` [m]."""
        psi = np.linspace(*self.travel, POINTS)
        path = self.centre(psi)
        bend = path.d2z_dpsi2 * radius / np.hypot(radius, path.slope) ** 3
        share = np.abs(bend) * section_radius(path.slope, self.pin_radius, radius)
        worst = int(np.argmax(share))
        if share[worst] < 1.0:
            return
        greatest = self._greatest_pin(np.abs(bend), path.slope, radius)
        theta = self.mechanism.angles()
        at = float(np.interp(psi[worst], self.mechanism.configuration(theta).psi[self.cam - 1], theta))
        raise DesignError(
            f"cam {self.cam}: the {'upper' if bend[worst] > 0.0 else 'lower'} flank is undercut at"
            f" psi = {psi[worst]:.6g} rad (theta = {at:.6g} rad): the pin of radius"
            f" {1e3 * self.pin_radius:.6g} mm does not fit into the bend of radius"
            f" {1e3 / abs(bend[worst]):.6g} mm on the cylinder of radius {1e3 * radius:.6g} mm. The"
            f" greatest pin that works has the diameter {2e3 * greatest:.6g} mm"
        )

    def _greatest_pin(self, bend: Array, slope: Array, radius: float) -> float:
        """Radius of the greatest pin without undercut [m], by halving, rounded down."""
        good, bad = 0.0, self.pin_radius
        while bad - good > 1e-9 * bad:
            middle = 0.5 * (good + bad)
            fits = bool((bend * section_radius(slope, middle, radius) < 1.0).all())
            good, bad = (middle, bad) if fits else (good, middle)
        return math.floor(good * 1e6) * 1e-6

    def require_walls(self, radius: float) -> None:
        """DesignError where the grooves of both ends of the pin, or turns of one groove, run into one another
        on the cylinder of a `radius` [m].

        Two sections of the pin, at two places, overlap if the middle between the places is inside a section:
        the section is convex and symmetric about its centre."""
        turn = 2.0 * math.pi / self.mechanism.contacts
        widest = 2.0 * math.asin(self.pin_radius / radius)
        if self.end - self.begin < turn - widest:
            return
        psi = np.linspace(self.begin, self.end, POINTS)
        z = self.centre(psi).z
        for k in range(1, math.ceil((self.end - self.begin + widest) / turn) + 1):
            half_turned = 0.5 * (psi[:, None] - psi[None, :] - k * turn)
            across = np.where(np.abs(half_turned) < 0.5 * math.pi, radius * np.sin(half_turned), np.inf)
            apart = np.hypot(across, 0.5 * (z[:, None] - z[None, :]))
            row, column = np.unravel_index(int(np.argmin(apart)), apart.shape)
            if apart[row, column] > self.pin_radius:
                continue
            ends = "grooves of both ends of the pin" if k % self.mechanism.contacts else "turns of the groove"
            raise DesignError(
                f"cam {self.cam}: the {ends} run into one another on the cylinder of radius"
                f" {1e3 * radius:.6g} mm, at psi = {psi[column]:.4g} and {psi[row]:.4g} rad: allowed is a pin"
                f" of diameter below {2e3 * apart[row, column]:.4g} mm, or less travel"
            )
