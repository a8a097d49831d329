"""Spring steel wire: grades, tensile strength, standard diameters, and strength against fatigue.

The least tensile strength of EN 10270-1 falls with the diameter d in mm, by the formulas of the classes A, B,
C and D of DIN 17223-1:1984, which meet the table of EN 10270-1 within 1 %:

    R_m = a - b lg(d) MPa     SL: 1720, 660     SM, DM: 1980, 740     SH, DH: 2220, 820

Fatigue by F. P. Zimmerli, Human failings in spring design, The Mainspring (1957); R. G. Budynas, J. K.
Nisbett, Shigley's Mechanical Engineering Design, chapter 10, also for the shear strength 0.67 R_m.
"""

import math
from collections.abc import Mapping

from dualcam.errors import DesignError

STRENGTHS: Mapping[str, tuple[float, float]] = {  # grade -> a, b [MPa] of R_m = a - b lg(d in mm)
    "SL": (1720.0, 660.0),
    "SM": (1980.0, 740.0),
    "DM": (1980.0, 740.0),
    "SH": (2220.0, 820.0),
    "DH": (2220.0, 820.0),
}
DYNAMIC_GRADES: Mapping[str, str] = {  # grade for static duty -> that for dynamic duty, as strong or stronger
    "SL": "DM",
    "SM": "DM",
    "SH": "DH",
}
RANGES: Mapping[str, tuple[float, float]] = {  # m, diameters of the formulas
    grade: (1e-3, 10e-3) if grade == "SL" else (0.3e-3, 20e-3) for grade in STRENGTHS
}
SHEAR_MODULUS = 81.5e9  # Pa, EN 13906-1 for wire of EN 10270-1
YOUNGS_MODULUS = 206e9  # Pa, likewise
DENSITY = 7850.0  # kg/m3, likewise
SHEAR_STRENGTH = 0.67  # of the tensile strength
STATIC_STRESS = 0.56  # of the tensile strength: allowed stress at the solid length, EN 13906-1, coiled cold
ZIMMERLI = {False: (241e6, 379e6), True: (398e6, 534e6)}  # shot-peened -> amplitude, mean stress [Pa]
# Usual nominal diameters of wire of EN 10270-1 [mm].
_MILLIMETRES = """
0.3 0.32 0.34 0.36 0.38 0.4 0.43 0.45 0.48 0.5 0.53 0.56 0.6 0.63 0.65 0.7 0.75 0.8 0.85 0.9 0.95
1 1.05 1.1 1.2 1.25 1.3 1.4 1.5 1.6 1.7 1.8 1.9 2 2.1 2.25 2.4 2.5 2.6 2.8 3 3.2 3.4 3.6 3.8 4 4.25 4.5 4.75
5 5.3 5.6 6 6.3 6.5 7 7.5 8 8.5 9 9.5 10 10.5 11 12 12.5 13 14 15 16 17 18 19 20
"""
DIAMETERS = tuple(float(f"{number}e-3") for number in _MILLIMETRES.split())  # m


def tensile_strength(grade: str, diameter: float) -> float:
    """Least tensile strength of a wire of EN 10270-1 [Pa].

    `grade` of the wire: low, medium or high strength, for static (S) or dynamic (D) load, one of "SL", "SM",
    "DM", "SH", "DH". `diameter` of the wire [m]: 0.3 to 20 mm, for SL 1 to 10 mm. DesignError: another grade
    or diameter.

    Examples
    --------
    By hand: 1980 - 740 lg(4) = 1980 - 740 * 0.60206 = 1534 MPa; the table of EN 10270-1 has 1530 MPa.

    >>> from dualcam.design import tensile_strength
    >>> round(tensile_strength("SM", 0.004) / 1e6)  # MPa
    1534
    """
    if grade not in STRENGTHS:
        raise DesignError(
            f"grade = {grade!r}: allowed are {', '.join(STRENGTHS)} of EN 10270-1; for another wire give"
            " tensile_strength in Pa"
        )
    thinnest, thickest = RANGES[grade]
    if not thinnest <= diameter <= thickest:
        raise DesignError(
            f"wire_diameter = {diameter:g} m: grade {grade} is known from {1e3 * thinnest:g} to"
            f" {1e3 * thickest:g} mm; for another diameter give tensile_strength in Pa"
        )
    first, second = STRENGTHS[grade]
    return 1e6 * (first - second * math.log10(1e3 * diameter))
