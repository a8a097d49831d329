"""The key numbers of a design that works: torques, efficiency, stroke, contact pressure."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from dualcam.design import Limits, Pin, torque_band
from dualcam.design.mechanism import POINTS
from dualcam.design.strength import strength
from dualcam.design.torque_band import span
from dualcam.design_file import DesignFile


@dataclass(frozen=True)
class LargestPressure:
    """The largest Hertz pressure of the line contacts.

    Attributes
    ----------
    pressure, limit : float
        Largest and allowed pressure [Pa].
    theta : float
        Where the pressure is largest [rad].
    cam : int
        In whose groove: 1 or 2.
    modulus, cam_modulus : float
        Young's moduli of pin and cams [Pa].
    """

    pressure: float
    limit: float
    theta: float
    cam: int
    modulus: float
    cam_modulus: float


@dataclass(frozen=True)
class KeyNumbers:
    """Numbers by which a design is judged, in slow motion over the whole range of theta.

    Attributes
    ----------
    load, release : tuple of float
        Least and largest torque to load, and torque given back [N.m].
    efficiency : tuple of float
        Least and largest torque given back over torque to load, at the same angle [1].
    self_locking : bool
        Whether the spring cannot turn cam 2 back at some angle.
    stroke : float
        Way of the follower from stop to stop [m].
    pressure : LargestPressure or None
        None without a pin.
    """

    load: tuple[float, float]
    release: tuple[float, float]
    efficiency: tuple[float, float]
    self_locking: bool
    stroke: float
    pressure: LargestPressure | None

    def as_dict(self) -> dict[str, Any]:
        """The numbers as JSON has them, in SI units."""
        return asdict(self)

    def lines(self) -> list[str]:
        """One line for each number, with its unit."""
        locking = "yes, the spring cannot turn cam 2 back everywhere" if self.self_locking else "no"
        return [
            f"torque to load: {span(np.array(self.load))} N.m",
            f"torque given back: {span(np.array(self.release))} N.m",
            f"efficiency: {span(100.0 * np.array(self.efficiency))} %",
            f"self-locking: {locking}",
            f"stroke of the follower: {1e3 * self.stroke:.4g} mm",
            f"contact pressure: {self._pressure_in_words()}",
        ]

    def _pressure_in_words(self) -> str:
        largest = self.pressure
        if largest is None:
            return "not checked, the file gives no [pin]"
        is_default = " (the default)" if largest.limit == Limits().pressure else ""
        steel = Pin.modulus
        is_steel = " (the default, steel)" if largest.modulus == largest.cam_modulus == steel else ""
        return (
            f"at most {largest.pressure / 1e6:.4g} MPa, at theta = {math.degrees(largest.theta):.4g} deg"
            f" on cam {largest.cam}; limit {largest.limit / 1e6:.6g} MPa{is_default}; Young's modulus of the"
            f" pin {largest.modulus / 1e9:.4g} GPa, of the cams {largest.cam_modulus / 1e9:.4g} GPa{is_steel}"
        )


def key_numbers(design: DesignFile) -> KeyNumbers:
    """The key numbers of a design that works.

    Parameters
    ----------
    design : DesignFile
        A design whose check finds no error.

    Returns
    -------
    KeyNumbers
    """
    mechanism = design.mechanism()
    band = torque_band(mechanism)
    return KeyNumbers(
        load=_ends(band.load),
        release=_ends(band.release),
        efficiency=_ends(band.efficiency),
        self_locking=band.self_locking,
        stroke=float(band.z[-1] - band.z[0]),
        pressure=None if design.pin is None else _largest_pressure(design, design.pin),
    )


def _ends(values: np.ndarray) -> tuple[float, float]:
    return float(np.nanmin(values)), float(np.nanmax(values))


def _largest_pressure(design: DesignFile, pin: Pin) -> LargestPressure:
    mechanism = design.mechanism()
    found = strength(mechanism, pin, np.linspace(*mechanism.reach(), POINTS))
    cam, place = np.unravel_index(int(np.argmax(found.pressure)), found.pressure.shape)
    return LargestPressure(
        pressure=float(found.pressure[cam, place]),
        limit=(design.limits or Limits()).pressure,
        theta=float(found.theta[place]),
        cam=int(cam) + 1,
        modulus=pin.modulus,
        cam_modulus=pin.cam_modulus,
    )
