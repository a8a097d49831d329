"""Results of a design in a few numbers and words, for the command line and for reports."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dualcam.design import Mechanism
from dualcam.design.hertz import Pin
from dualcam.design.strength import strength
from dualcam.simulation.run import Trajectory

POINTS = 721  # angles at which the largest values are searched
SAME = 1e-9  # loads of both cams with a smaller relative difference count as equal
ROUNDING = 1e-12  # an energy below this share of the energies of a run is rounding


@dataclass(frozen=True)
class Largest:
    """The largest value over the range of the angle."""

    value: float  # N of one contact, or Pa
    theta: float  # rad
    cams: tuple[int, ...]  # 1, 2, or both where they carry the same

    @property
    def place(self) -> str:
        """Angle and cam in words."""
        cams = "both cams" if len(self.cams) == 2 else f"cam {self.cams[0]}"
        return f"at theta = {math.degrees(self.theta):.4g} deg, {cams}"


@dataclass(frozen=True)
class LargestLoads:
    """The largest loads of slow loading and releasing, without F_ext."""

    reaction: Largest
    pressure: Largest | None  # None without a pin


def largest_loads(mechanism: Mechanism, pin: Pin | None) -> LargestLoads:
    """Largest reaction of one contact and, with a pin, largest contact pressure (Hertz, line contact)."""
    found = strength(mechanism, pin, mechanism.angles(POINTS))
    pressure = _largest(found.pressure, found.theta) if pin else None
    return LargestLoads(_largest(found.load, found.theta), pressure)


def _largest(values: NDArray[np.float64], theta: NDArray[np.float64]) -> Largest:
    """The largest of `values`, shape (2, n), for cam 1 and cam 2."""
    place = int(np.argmax(values.max(axis=0)))
    greatest = float(values[:, place].max())
    cams = (cam for cam in (1, 2) if math.isclose(values[cam - 1, place], greatest, rel_tol=SAME))
    return Largest(greatest, float(theta[place]), tuple(cams))


def reaction_words(largest: Largest, contacts: int) -> str:
    """A reaction with its place and the number of contacts that share the load."""
    shared = "1 contact carries" if contacts == 1 else f"{contacts} contacts share"
    return f"{largest.value:.4g} N on one contact {largest.place} ({shared} the load of each cam)"


def pressure_words(largest: Largest) -> str:
    """A contact pressure with its place."""
    if not math.isfinite(largest.value):
        return f"infinite {largest.place}: the flank is undercut there"
    return f"{largest.value / 1e6:.4g} MPa {largest.place}"


def material_words(pin: Pin) -> str:
    """Elastic moduli and Poisson's ratios of pin and cams."""
    moduli = f"pin {pin.modulus / 1e9:.4g} GPa, cams {pin.cam_modulus / 1e9:.4g} GPa"
    return f"{moduli}; Poisson's ratios {pin.poisson:g} and {pin.cam_poisson:g}"


def span_words(values: NDArray[np.float64], unit: str) -> str:
    """Least and greatest value; one number where both have the same three digits."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return "none"
    low, high = (f"{end:.3g}" for end in (finite.min(), finite.max()))
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"


def energy_scale(trajectory: Trajectory) -> float:
    """The largest work or stored energy of a run [J], to which an error relates."""
    names = ("energy.work_in", "energy.work_ext", "energy.spring", "energy.kinetic")
    return max((float(np.abs(trajectory[n]).max()) for n in names if n in trajectory.names), default=0.0)


def energy_words(energy: float, scale: float) -> str:
    """An energy [J]; 0 where only rounding differs from 0, compared with the energies of the run."""
    return "0 J" if abs(energy) <= ROUNDING * scale else f"{energy:.5g} J"


def residual_words(trajectory: Trajectory) -> str:
    """The residual of the energy balance at the end of a run, related to the energies of the run."""
    residual, scale = abs(float(trajectory["energy.residual"][-1])), energy_scale(trajectory)
    if residual <= ROUNDING * scale or residual == 0.0:
        return "0 (rounding)"
    if scale == 0.0:  # no other energy was recorded
        return f"{residual:.2g} J"
    return f"{residual:.2g} J, {residual / scale:.1g} of the largest energy"
