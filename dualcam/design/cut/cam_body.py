"""The body of a cam around its groove: a tube, with a slot or a groove."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dualcam.design.cut.groove_cut import GrooveCut
from dualcam.design.statics import Array
from dualcam.errors import DesignError

RADII = 9  # cylinders between floor and outer surface on which the flanks are checked


@dataclass(frozen=True)
class CamBody:
    """A tube whose outer side has the groove. Lengths in m.

    Attributes
    ----------
    outer_radius : Outer radius.
    bore_radius : Radius of the bore; 0: a solid cylinder.
    floor_radius : Radius of the groove's floor. Not above the bore: the groove is a slot through the wall.
    low, high : Ends of the body along the axis; 0 is the height of the pin's axis at theta = 0.
    """

    outer_radius: float
    bore_radius: float
    floor_radius: float
    low: float
    high: float

    @property
    def is_slot(self) -> bool:
        """Whether the groove goes through the wall."""
        return self.floor_radius <= self.bore_radius

    @classmethod
    def around(
        cls,
        cut: GrooveCut,
        depth: float,
        *,
        outer_radius: float | None = None,
        bore_radius: float | None = None,
        length: float | None = None,
    ) -> CamBody:
        """The body around a groove.

        Parameters
        ----------
        cut : GrooveCut
        depth
            Length of the pin that bears on the flank [m]. The middle of that length is at the cam's radius,
            where the contact of the model acts. So the floor of the groove is half the depth below.
        outer_radius : Outer radius [m]; half the depth above the cam's radius if not given.
        bore_radius : Radius of the bore [m]; that of the floor if not given, so that the groove is a slot.
        length
            Length of the body along the axis [m]; that of the groove and two pin diameters if not given. The
            groove is in the middle.

        Returns
        -------
        CamBody

        Raises
        ------
        DesignError
            A body that the groove does not fit, or a flank that is undercut between floor and outer surface.

        Examples
        --------
        >>> from dualcam.design import CamBody, GrooveCut, Helix, Mechanism, Spring
        >>> helix = Helix(radius=0.02, lead_angle=0.7854)
        >>> mechanism = Mechanism((helix, helix), (0.14, 0.14), Spring(50.0, 5e4), upper=1.3963)
        >>> body = CamBody.around(GrooveCut(mechanism, cam=1, pin_radius=0.003), depth=0.008)
        >>> body.outer_radius, body.bore_radius, body.is_slot
        (0.024, 0.016, True)
        """
        name, radius = f"cam {cut.cam}", cut.radius
        floor = radius - 0.5 * depth
        if not (depth > 0.0 and floor > cut.pin_radius):
            raise DesignError(
                f"{name}: depth = {1e3 * depth:.6g} mm: allowed is a length > 0 and below"
                f" {2e3 * (radius - cut.pin_radius):.6g} mm, so that the floor's radius stays"
                " above the pin's radius"
            )
        outer = radius + 0.5 * depth if outer_radius is None else outer_radius
        if not radius <= outer < math.inf:
            raise DesignError(
                f"{name}: outer diameter = {2e3 * outer:.6g} mm: allowed is {2e3 * radius:.6g} mm, twice the"
                " cam's radius, or more"
            )
        bore = floor if bore_radius is None else bore_radius
        if not 0.0 <= bore < radius:
            raise DesignError(
                f"{name}: bore diameter = {2e3 * bore:.6g} mm: allowed is a number >= 0 and below"
                f" {2e3 * radius:.6g} mm, twice the cam's radius"
            )
        low, high = cls._ends(cut, length)
        for rho in np.linspace(max(floor, bore), outer, RADII):
            cut.require_no_undercut(float(rho))
        cut.require_walls(max(floor, bore))
        return cls(outer, bore, floor, low, high)

    @staticmethod
    def _ends(cut: GrooveCut, length: float | None) -> tuple[float, float]:
        pin, groove = cut.pin_radius, (float(cut.centre(cut.begin).z), float(cut.centre(cut.end).z))
        needed = groove[1] - groove[0] + 2.0 * pin
        chosen = needed + 4.0 * pin if length is None else length
        if not needed < chosen < math.inf:
            raise DesignError(
                f"cam {cut.cam}: length = {1e3 * chosen:.6g} mm: allowed is more than the groove's height,"
                f" {1e3 * needed:.6g} mm"
            )
        middle = 0.5 * (groove[0] + groove[1])
        return middle - 0.5 * chosen, middle + 0.5 * chosen

    def volume(self, cut: GrooveCut) -> float:
        """Volume of the body with all grooves of a `cut` [m3]."""
        from scipy.integrate import simpson

        tube = math.pi * (self.outer_radius**2 - self.bore_radius**2) * (self.high - self.low)
        radii = np.linspace(max(self.floor_radius, self.bore_radius), self.outer_radius, RADII)
        areas = [groove_area(cut, float(radius)) for radius in radii]
        return float(tube - cut.mechanism.contacts * simpson(areas, x=radii))


def groove_area(cut: GrooveCut, radius: float, points: int = 4001) -> float:
    """Area of the groove on a cylinder of this radius [m2]."""
    psi = np.linspace(cut.begin, cut.end, points)
    flanks = cut.flanks(psi, radius)
    share = np.linspace(0.0, 1.0, points)
    last, first = cut.round_end(True, share, radius), cut.round_end(False, share, radius)
    outline: Array = np.concatenate(
        [np.array(flanks.upper), np.array(last), np.array(flanks.lower)[:, ::-1], np.array(first)[:, ::-1]],
        axis=1,
    )
    x, z = radius * outline[0], outline[1]
    return abs(0.5 * float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1))))
