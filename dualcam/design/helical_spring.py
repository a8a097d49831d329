"""A helical compression spring of round wire: rate, stress, lengths, buckling, fatigue.

Equations and sources (EN 13906-1:2013, Zimmerli): docs/design-quantities.md. Static stress is compared
without the factor k for the curvature of the wire, fatigue with k. With Zimmerli's amplitude tau_Z up to the
mean stress tau_mZ and the Goodman line from there, the safety is the lesser one of

    tau_Z/tau_a     1/(tau_a/tau_W + tau_m/(0.67 R_m)),  tau_W = tau_Z/(1 - tau_mZ/(0.67 R_m))
"""

import math
from dataclasses import dataclass

from dualcam.common.unit_guards import unit_warning, warn_units
from dualcam.design.spring_steel import (
    DENSITY,
    SHEAR_MODULUS,
    SHEAR_STRENGTH,
    STATIC_STRESS,
    YOUNGS_MODULUS,
    ZIMMERLI,
    tensile_strength,
)
from dualcam.design.statics import check_numbers
from dualcam.errors import DesignError

END_COILS = 2.0  # closed and ground ends
RANGES = {  # least and greatest value with the unit; 2 active coils are the least of EN 13906-1
    "wire_diameter": (1e-6, 1.0, " in m"),
    "coil_diameter": (1e-6, 100.0, " in m"),
    "active_coils": (2.0, 1e4, ""),
    "total_coils": (2.0, 1e5, ""),
    "tensile_strength": (1e6, 1e11, " in Pa"),
    "shear_modulus": (1e6, 1e13, " in Pa"),
    "fatigue_strength": (1e3, 1e11, " in Pa"),
}
INDEX = (4.0, 20.0)  # least and greatest w of a spring coiled cold, EN 13906-1
SEATING = 0.5  # seating coefficient of buckling: both ends on parallel plates
DYNAMIC_GAP = 1.5  # EN 13906-1: the gaps of a spring that moves often, over those at rest


@dataclass(frozen=True)
class Fatigue:
    """Stresses of one cycle and the Goodman safety.

    Attributes
    ----------
    lower, upper : Corrected shear stress at the least and at the largest force [Pa].
    amplitude, mean : Half the difference and the mean of both [Pa].
    strength : Largest amplitude that the wire endures, at a mean stress up to `knee` [Pa].
    knee : Mean stress from which the Goodman line falls [Pa]: Zimmerli's point, or 0 with a given strength.
    shear_strength : Shear strength of the wire: the end of the Goodman line [Pa].
    safety
        Factor by which amplitude and mean stress may grow together up to that line [1]; infinite without
        force.
    """

    lower: float
    upper: float
    amplitude: float
    mean: float
    strength: float
    knee: float
    shear_strength: float
    safety: float


@dataclass(frozen=True)
class HelicalSpring:
    """A helical compression spring, coiled cold from round wire, with closed and ground ends.

    Parameters
    ----------
    wire_diameter : Diameter d of the wire [m].
    coil_diameter : Mean diameter D of the coil [m], more than d.
    active_coils : Number n of active coils, >= 2.
    total_coils : Number of all coils; n + 2 if not given.
    grade : Grade of EN 10270-1: "SL", "SM", "DM", "SH" or "DH".
    tensile_strength : Tensile strength R_m of the wire [Pa]; that of the grade if not given.
    shear_modulus : Shear modulus G of the wire [Pa].
    shot_peened : Whether the spring is shot-peened.
    fatigue_strength
        Shear stress amplitude that the wire endures at mean stress 0 [Pa], for example from the Goodman
        diagram of EN 13906-1 for the wire; from Zimmerli's measurements if not given.
    guided : Whether a rod or a sleeve guides the spring, so that the spring cannot buckle.

    Raises
    ------
    DesignError : A value outside its range, or neither grade nor tensile strength.

    Examples
    --------
    By hand: w = 32/5 = 6.4, R = 81500 * 5^4/(8 * 32^3 * 4.7) = 41.34 N/mm, k = 6.9/5.65 = 1.221. At 875 N
    tau = 8 * 32 * 875/(pi * 125) = 570 MPa and tau_k = 697 MPa.

    >>> from dualcam.design import HelicalSpring
    >>> spring = HelicalSpring(wire_diameter=0.005, coil_diameter=0.032, active_coils=4.7, grade="DH")
    >>> round(spring.rate / 1e3, 2), round(spring.correction, 3)  # N/mm, 1
    (41.34, 1.221)
    >>> round(spring.stress(875.0) / 1e6), round(spring.corrected_stress(875.0) / 1e6)  # MPa
    (570, 697)
    """

    wire_diameter: float
    coil_diameter: float
    active_coils: float
    total_coils: float | None = None
    grade: str | None = None
    tensile_strength: float | None = None
    shear_modulus: float = SHEAR_MODULUS
    shot_peened: bool = False
    fatigue_strength: float | None = None
    guided: bool = False

    def __post_init__(self) -> None:
        check_numbers({name: getattr(self, name) for name in RANGES if getattr(self, name) is not None})
        for name, (low, high, unit) in RANGES.items():
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                hint = (unit_warning(f"helical_spring.{name}", value) or "").partition(": ")[2]
                raise DesignError(
                    f"{name} = {value:g}: allowed is a number from {low:g} to {high:g}{unit}"
                    + (f"; {hint}" if hint else "")
                )
        if not self.wire_diameter < self.coil_diameter:
            raise DesignError(
                f"coil_diameter = {self.coil_diameter:g} m: allowed is more than wire_diameter ="
                f" {self.wire_diameter:g} m; the mean diameter of the coil is meant"
            )
        if self.total_coils is not None and not self.active_coils <= self.total_coils:
            raise DesignError(
                f"total_coils = {self.total_coils:g}: allowed is active_coils = {self.active_coils:g} or more"
            )
        if self.tensile_strength is None:
            if self.grade is None:
                raise DesignError(
                    'no material: give grade = "DH", or SL, SM, DM or SH of EN 10270-1, or tensile_strength'
                )
            tensile_strength(self.grade, self.wire_diameter)
        if self.fatigue_strength is None and self.shear_strength <= ZIMMERLI[self.shot_peened][1]:
            raise DesignError(
                f"tensile_strength = {self.strength:g} Pa: too low for Zimmerli's strength against fatigue;"
                " give fatigue_strength of the wire in Pa"
            )
        lengths = ("wire_diameter", "coil_diameter")
        warn_units({name: (f"helical_spring.{name}", getattr(self, name)) for name in lengths})

    @property
    def index(self) -> float:
        """The spring index w = D/d [1]."""
        return self.coil_diameter / self.wire_diameter

    @property
    def correction(self) -> float:
        """The stress correction factor k for the curvature of the wire [1]."""
        return (self.index + 0.5) / (self.index - 0.75)

    @property
    def rate(self) -> float:
        """The spring rate R [N/m], for `spring.stiffness`."""
        stiff = self.shear_modulus * self.wire_diameter**4
        return stiff / (8.0 * self.coil_diameter**3 * self.active_coils)

    @property
    def outer_diameter(self) -> float:
        """Outer diameter of the unloaded coil [m]."""
        return self.coil_diameter + self.wire_diameter

    @property
    def coils(self) -> float:
        """Number of all coils."""
        return self.active_coils + END_COILS if self.total_coils is None else self.total_coils

    @property
    def solid_length(self) -> float:
        """Length with all coils in contact [m]: all coils times d."""
        return self.coils * self.wire_diameter

    @property
    def least_length(self) -> float:
        """Least length of one that moves often [m]: solid length, and 1.5 times the gaps of EN 13906-1."""
        d = self.wire_diameter
        gap = 0.0015 * self.coil_diameter**2 / d + 0.1 * d
        return self.solid_length + DYNAMIC_GAP * self.active_coils * gap

    @property
    def mass(self) -> float:
        """Mass of the wire, of steel [kg]."""
        length = math.pi * self.coil_diameter * self.coils
        return DENSITY * length * math.pi / 4.0 * self.wire_diameter**2

    @property
    def strength(self) -> float:
        """Tensile strength R_m [Pa]: the given one, or that of the grade."""
        if self.tensile_strength is not None:
            return self.tensile_strength
        return tensile_strength(str(self.grade), self.wire_diameter)

    @property
    def shear_strength(self) -> float:
        """Shear strength 0.67 R_m [Pa]."""
        return SHEAR_STRENGTH * self.strength

    @property
    def allowed_stress(self) -> float:
        """Allowed shear stress without k, 0.56 R_m [Pa]; above it the spring sets."""
        return STATIC_STRESS * self.strength

    def stress(self, force: float) -> float:
        """Shear stress without correction [Pa] under a `force` [N]."""
        return 8.0 * self.coil_diameter * force / (math.pi * self.wire_diameter**3)

    def corrected_stress(self, force: float) -> float:
        """Shear stress on the inside of the coil [Pa], with the factor k, under a `force` [N]."""
        return self.correction * self.stress(force)

    def static_safety(self, force: float) -> float:
        """Safety against setting [1]: allowed over uncorrected shear stress under the largest `force` [N];
        infinite without force."""
        return self.allowed_stress / self.stress(force) if force > 0.0 else math.inf

    def fatigue(self, least: float, largest: float) -> Fatigue:
        """Stresses of a cycle between two forces, and the safety against fatigue.

        `least`, `largest`: forces at preload and at full stroke [N], 0 <= least <= largest. DesignError:
        forces that are negative, not finite or exchanged. Source: the formulas at the head of this file.

        Examples
        --------
        Example 10-4 of Shigley's Mechanical Engineering Design (8th edition): music wire of 0.092 in, outer
        diameter 9/16 in, between 5 and 35 lbf. By hand: C = 5.11, k = 1.287, tau_a = 29.7 kpsi,
        tau_m = 39.6 kpsi, below Zimmerli's 55 kpsi. So S = 35/29.7 = 1.18.

        >>> from dualcam.design import HelicalSpring
        >>> inch, pound = 0.0254, 4.44822
        >>> kpsi = 1e3 * pound / inch**2
        >>> wire = HelicalSpring(0.092 * inch, 0.4705 * inch, 21.0, tensile_strength=284.1 * kpsi)
        >>> cycle = wire.fatigue(5.0 * pound, 35.0 * pound)
        >>> round(cycle.amplitude / kpsi, 1), round(cycle.mean / kpsi, 1), round(cycle.safety, 2)
        (29.7, 39.6, 1.18)
        """
        if not 0.0 <= least <= largest < math.inf:
            raise DesignError(
                f"forces {least:g} and {largest:g} N: allowed are 0 <= least <= largest, finite"
            )
        lower, upper = self.corrected_stress(least), self.corrected_stress(largest)
        amplitude, mean = 0.5 * (upper - lower), 0.5 * (upper + lower)
        strength, knee = self._endured()
        end = self.shear_strength
        at_zero = strength / (1.0 - knee / end)  # of the Goodman line, extended to mean stress 0
        used = max(amplitude / strength, amplitude / at_zero + mean / end)
        safety = 1.0 / used if used > 0.0 else math.inf
        return Fatigue(lower, upper, amplitude, mean, strength, knee, end, safety)

    def _endured(self) -> tuple[float, float]:
        """Largest amplitude, and mean stress up to which the wire endures this amplitude: the given strength
        at mean stress 0, else Zimmerli's point."""
        if self.fatigue_strength is not None:
            return self.fatigue_strength, 0.0
        return ZIMMERLI[self.shot_peened]

    def buckling_deflection(self, free_length: float) -> float:
        """Deflection [m] at which the spring buckles between parallel plates, infinite if never or guided.

        `free_length`: length of the unloaded spring [m]. DesignError: a length that is not above 0. Source:
        EN 13906-1, buckling, with the seating coefficient 0.5 and steel.

        Examples
        --------
        By hand: the root has the argument 1 - 0.6748 (pi D/(0.5 L_0))^2. A spring with L_0 = 3 D never
        buckles. With L_0 = 8 D the argument is 0.5837, and the deflection 0.827 * 8 D * 0.2360 = 1.56 D.

        >>> from dualcam.design import HelicalSpring
        >>> spring = HelicalSpring(wire_diameter=0.002, coil_diameter=0.010, active_coils=20, grade="DH")
        >>> spring.buckling_deflection(0.030)
        inf
        >>> round(spring.buckling_deflection(0.080) / 0.010, 2)  # over D
        1.56
        """
        if not 0.0 < free_length < math.inf:
            raise DesignError(f"free_length = {free_length}: allowed is a finite number > 0 in m")
        share = self.shear_modulus / YOUNGS_MODULUS
        slender = math.pi * self.coil_diameter / (SEATING * free_length)
        argument = 1.0 - (1.0 - share) / (0.5 + share) * slender**2
        if argument < 0.0 or self.guided:
            return math.inf
        return free_length * 0.5 / (1.0 - share) * (1.0 - math.sqrt(argument))
