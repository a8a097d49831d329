"""The key numbers of a design that works: torques, efficiency, stroke, contact pressure."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from dualcam.design import Limits, Pin, torque_band
from dualcam.design.mechanism import POINTS, Mechanism
from dualcam.design.strength import strength
from dualcam.design.torque_band import NOT_LOCKING, span
from dualcam.design_file import DesignFile
from dualcam.design_file.durability import (
    RollerNumbers,
    SpringNumbers,
    WearNumbers,
    largest_contact,
    roller_numbers,
    roller_words,
    spring_numbers,
    spring_words,
    wear_numbers,
    wear_words,
)

FRICTION_CLASSES = {  # by the FMU's friction_class
    1: "one motion under every load (unique)",
    2: "several motions or none under some loads, where a fixed rule chooses (self-locking)",
}


@dataclass(frozen=True)
class LargestPressure:
    """The largest Hertz pressure of the line contacts."""

    pressure: float  # Pa, as limit, moduli and shear
    limit: float
    theta: float  # rad
    cam: int  # 1 or 2
    modulus: float  # Young's, of the pin; cam_modulus of both cams
    cam_modulus: float
    shear: float  # largest shear stress below the surface
    depth: float  # of this shear stress [m]


@dataclass(frozen=True)
class KeyNumbers:
    """Numbers by which a design is judged, in slow motion over the whole range of theta."""

    load: tuple[float, float]  # least and largest torque to load [N.m]
    release: tuple[float, float]  # likewise torque given back [N.m]
    efficiency: tuple[float, float]  # likewise release over load at the same angle [1]
    self_locking: bool  # the spring cannot turn cam 2 back at some angle
    friction_class: int  # the FMU's: 1 unique, 2 self-locking
    stroke: float  # way of the follower from stop to stop [m]
    pressure: LargestPressure | None  # None without a pin
    roller: RollerNumbers | None = None  # None without a roller
    spring: SpringNumbers | None = None  # None without wire and coil
    wear: WearNumbers | None = None  # None where nothing wears

    def as_dict(self) -> dict[str, Any]:
        """The numbers as JSON has them, in SI units."""
        return asdict(self)

    def lines(self) -> list[str]:
        """One line for each number, with its unit."""
        turns = f"no, {NOT_LOCKING}"
        locking = "yes, the spring cannot turn cam 2 back everywhere" if self.self_locking else turns
        return [
            f"torque to load: {span(np.array(self.load))} N.m",
            f"torque given back: {span(np.array(self.release))} N.m",
            f"efficiency: {span(100.0 * np.array(self.efficiency))} %",
            f"self-locking: {locking}",
            f"friction: {self.friction_words()}",
            f"stroke of the follower: {1e3 * self.stroke:.4g} mm",
            f"contact pressure: {self._pressure_in_words()}",
            *self._durability_lines(),
        ]

    def friction_words(self) -> str:
        """The class of the mechanism under friction."""
        return FRICTION_CLASSES[self.friction_class]

    def _durability_lines(self) -> list[str]:
        """Shear stress, roller, spring and wear, as far as they are known."""
        found = []
        if (contact := self.pressure) is not None:
            found.append(
                f"shear stress below the surface: at most {contact.shear / 1e6:.4g} MPa,"
                f" {1e3 * contact.depth:.3g} mm deep"
            )
        if self.roller is not None:
            found.append(f"roller: {roller_words(self.roller)}")
        if self.spring is not None:
            found.append(f"spring: {spring_words(self.spring)}")
            if not self.spring.has_length:
                found.append(
                    "spring length and buckling: not checked, the file gives no spring.free_length and"
                    " spring.solid_length"
                )
        if self.wear is not None:
            found.append(f"wear: {wear_words(self.wear)}")
        return found

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


def key_numbers(design: DesignFile, friction_class: int) -> KeyNumbers:
    """The key numbers of a design whose check finds no error."""
    mechanism = design.mechanism()
    band = torque_band(mechanism)
    return KeyNumbers(
        load=_ends(band.load),
        release=_ends(band.release),
        efficiency=_ends(band.efficiency),
        self_locking=band.self_locking,
        friction_class=friction_class,
        stroke=float(band.z[-1] - band.z[0]),
        pressure=None if design.pin is None else _largest_pressure(design, mechanism, design.pin),
        roller=roller_numbers(design),
        spring=spring_numbers(design, mechanism),
        wear=wear_numbers(design, mechanism),
    )


def _ends(values: np.ndarray) -> tuple[float, float]:
    return float(np.nanmin(values)), float(np.nanmax(values))


def _largest_pressure(design: DesignFile, mechanism: Mechanism, pin: Pin) -> LargestPressure:
    found = strength(mechanism, pin, np.linspace(*mechanism.reach(), POINTS))
    cam, place = np.unravel_index(int(np.argmax(found.pressure)), found.pressure.shape)
    contact = largest_contact(mechanism, pin, int(cam) + 1, float(found.theta[place]))
    return LargestPressure(
        pressure=float(found.pressure[cam, place]),
        limit=(design.limits or Limits()).pressure,
        theta=float(found.theta[place]),
        cam=int(cam) + 1,
        modulus=pin.modulus,
        cam_modulus=pin.cam_modulus,
        shear=float(contact.shear),
        depth=float(contact.depth),
    )
