"""Line contact between pin and flank by Hertz: pressure, half width, and the stress below the surface.

With the load N of one contact, the width L of the flank and the relative radius R (`relative_radius`):

    a = sqrt(4 N R/(pi L E*))     p_max = 2 N/(pi a L)     tau(z) = p_max u (1 - u/sqrt(1 + u^2)),  u = z/a

E* is `Pin.contact_modulus`. tau is largest at u^2 = (sqrt(5) - 1)/2. Source: K. L. Johnson, Contact Mechanics
(1985), section 4.2(c); docs/design-quantities.md.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import real_array
from dualcam.common.unit_guards import warn_units
from dualcam.design.statics import Array, check_numbers
from dualcam.errors import DesignError

DEPTH_SHARE = math.sqrt(0.5 * (math.sqrt(5.0) - 1.0))  # depth of the largest shear stress over half width
SHEAR_SHARE = DEPTH_SHARE * (1.0 - DEPTH_SHARE**2)  # largest shear stress over largest pressure


@dataclass(frozen=True)
class Pin:
    """A pin and the flanks that it bears on; steel unless said otherwise.

    Parameters
    ----------
    radius : Radius of the pin [m], > 0.
    width : Width of the flank along the pin [m], > 0.
    modulus, cam_modulus : Young's moduli of pin and cam [Pa], > 0.
    poisson, cam_poisson : Poisson's ratios of pin and cam [1], 0 to 0.5.
    wear : Specific wear rate of the pin [m3/(N.m)], 0 to 1; 0: the pin does not wear.

    Raises
    ------
    DesignError : A value outside its range.

    Examples
    --------
    >>> from dualcam.design import Pin
    >>> pin = Pin(radius=0.003, width=0.008)
    >>> f"{pin.contact_modulus:.4g}"  # Pa
    '1.154e+11'
    """

    radius: float
    width: float
    modulus: float = 210e9
    poisson: float = 0.3
    cam_modulus: float = 210e9
    cam_poisson: float = 0.3
    wear: float = 0.0

    def __post_init__(self) -> None:
        check_numbers(vars(self))
        for name in ("radius", "width", "modulus", "cam_modulus"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise DesignError(f"{name} = {getattr(self, name)}: allowed is a finite number > 0")
        for name in ("poisson", "cam_poisson"):
            if not 0.0 <= getattr(self, name) <= 0.5:
                raise DesignError(f"{name} = {getattr(self, name)}: allowed is 0 to 0.5")
        if not 0.0 <= self.wear <= 1.0:
            raise DesignError(f"wear = {self.wear}: allowed is a number from 0 to 1 in m3/(N.m)")
        guarded = ("radius", "width", "modulus", "cam_modulus", "wear")
        warn_units({name: (f"pin.{name}", getattr(self, name)) for name in guarded})

    @property
    def contact_modulus(self) -> float:
        """E* [Pa]"""
        return 1.0 / ((1.0 - self.poisson**2) / self.modulus + (1.0 - self.cam_poisson**2) / self.cam_modulus)


def hertz_pressure(load: ArrayLike, pin: Pin, curvature: ArrayLike = 0.0) -> Array:
    """Largest pressure [Pa] between pin and flank, by Hertz; infinite where the flank is undercut.

    `load`: normal force of one contact of the `pin` [N]. `curvature`: signed curvature of the path of the
    pin's centre [1/m], + where the groove steepens, for the flank below the path. For the flank above change
    the sign. Source: the formulas at the head of this file; K. L. Johnson, Contact Mechanics (1985), section
    4.2(c).

    Examples
    --------
    >>> from dualcam.design import Pin, hertz_pressure
    >>> round(float(hertz_pressure(400.0, Pin(radius=0.003, width=0.008))) / 1e6)  # MPa
    782
    """
    radius = relative_radius(pin, curvature)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        square = real_array(load, "load", DesignError) / pin.width * pin.contact_modulus / (math.pi * radius)
        return np.where(radius > 0.0, np.sqrt(square), np.inf)


@dataclass(frozen=True, eq=False)
class LineContact:
    """The line contact of a pin with a flank.

    Attributes
    ----------
    half_width : Half the width a of the contact along the groove [m].
    pressure : Largest pressure p_max [Pa].
    shear : Largest shear stress below the surface [Pa].
    depth : Depth of that shear stress below the surface [m].
    """

    half_width: Array
    pressure: Array
    shear: Array
    depth: Array


def relative_radius(pin: Pin, curvature: ArrayLike = 0.0) -> Array:
    """Relative radius of `pin` and flank [m]: 1/(1/r_pin + curvature of the flank, + where it bulges).

    It is r_pin for a straight flank, more on a hollow flank, less on a bulging one; 0 or less where the flank
    is undercut. `curvature`: k of the path, as in `hertz_pressure`. The flank is parallel to the path at
    distance r_pin, so its curvature is -k/(1 + k r_pin).

    Examples
    --------
    >>> from dualcam.design import Pin, relative_radius
    >>> pin = Pin(radius=0.003, width=0.008)
    >>> [round(1e3 * float(relative_radius(pin, bend)), 3) for bend in (0.0, 20.0, -20.0)]  # mm
    [3.0, 3.18, 2.82]
    """
    return np.asarray(pin.radius * (1.0 + pin.radius * real_array(curvature, "curvature", DesignError)))


def line_contact(load: ArrayLike, pin: Pin, curvature: ArrayLike = 0.0) -> LineContact:
    """Half width, pressure and shear stress of the line contact between pin and flank.

    `load`: normal force of one contact of the `pin` [N], >= 0. `curvature`: signed curvature of the path of
    the pin's centre [1/m], as in `hertz_pressure`. On an undercut flank the pressure is infinite.
    DesignError: a load that is negative or not finite. Source: the formulas at the head of this file; K. L.
    Johnson, Contact Mechanics (1985), section 4.2(c).

    Examples
    --------
    By hand: 400 N on 8 mm are 50 N/mm. E* = 115.4 GPa for steel on steel. So
    p_max = sqrt(50e3 * 115.4e9/(pi * 0.003)) = 782 MPa, and a = 2 * 50e3/(pi * 782e6) = 40.7 um.

    >>> from dualcam.design import Pin, line_contact
    >>> contact = line_contact(400.0, Pin(radius=0.003, width=0.008))
    >>> round(float(contact.pressure) / 1e6), round(1e6 * float(contact.half_width), 1)  # MPa, um
    (782, 40.7)
    >>> round(float(contact.shear) / 1e6), round(1e6 * float(contact.depth), 1)  # MPa, um
    (235, 32.0)
    """
    force = real_array(load, "load [N]", DesignError)
    if not (np.isfinite(force) & (force >= 0.0)).all():
        raise DesignError(f"load = {force}: allowed are finite forces >= 0 in N")
    radius = np.maximum(relative_radius(pin, curvature), 0.0)
    half_width = np.sqrt(4.0 * force * radius / (math.pi * pin.width * pin.contact_modulus))
    pressure = hertz_pressure(force, pin, curvature)
    return LineContact(half_width, pressure, SHEAR_SHARE * pressure, DEPTH_SHARE * half_width)


def shear_below(depth: ArrayLike, half_width: float, pressure: float) -> Array:
    """Largest shear stress [Pa] below the middle of a line contact, by McEwen, of the shape of `depth`.

    `depth` below the surface [m], >= 0. `half_width`: half the width a of the contact [m], > 0. `pressure`:
    largest pressure of the contact [Pa]. Source: K. L. Johnson, Contact Mechanics (1985), section 4.2(c).

    Examples
    --------
    >>> from dualcam.design import shear_below
    >>> float(shear_below(0.786e-4, 1e-4, 1e9).round(-6)) / 1e6  # MPa: 0.30 of 1000 MPa at 0.786 a
    300.0
    """
    u = real_array(depth, "depth", DesignError) / half_width
    return np.asarray(pressure * u * (1.0 - u / np.sqrt(1.0 + u**2)))
