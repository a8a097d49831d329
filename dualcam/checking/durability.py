"""Rules about what lasts: stress and fatigue of the spring, the roller, wear. No rule needs the FMU."""

import math
from dataclasses import replace

from dualcam.checking.trouble import Remedy, Trouble, shown_beside, trouble
from dualcam.design import HelicalSpring, Limits, Mechanism, find_springs
from dualcam.design.helical_spring import INDEX
from dualcam.design.spring_steel import DYNAMIC_GRADES
from dualcam.design_file import DesignFile
from dualcam.design_file.durability import spring_fatigue, spring_forces, wear_life, wear_of
from dualcam.design_file.findings import ERROR, WARNING
from dualcam.errors import DesignError

SAME_RATE = 0.03  # relative difference of rates below which both count as equal
OTHER_SPRING = 0.10  # likewise above which the stress is that of a spring that cannot be
SAME_LENGTH = 0.03  # likewise of solid lengths
ROUNDING = 1.002  # a proposed spring has as much more safety, so that its rounded diameter lasts, too
SAME_FRICTION = 0.02  # likewise of coefficients of friction
WIRE = "helical_spring.wire_diameter"


def durability(design: DesignFile, mechanism: Mechanism, propose: bool) -> list[Trouble]:
    """Findings about spring, roller and wear. With `propose` a spring in a standard wire is searched."""
    return [*_spring(design, mechanism, propose), *_roller(design), *_wear(design, mechanism)]


def _spring(design: DesignFile, mechanism: Mechanism, propose: bool) -> list[Trouble]:
    spring = design.helical_spring
    least, largest = spring_forces(mechanism)
    if spring is None or not 0.0 <= least <= largest:  # a spring that pulls has a finding of its own
        return []
    found = [_rate(design, spring), _grade(design, spring), _index(design, spring)]
    found += _lengths(design, mechanism, spring)
    found += [_static(design, spring, largest), _fatigue(design, mechanism, spring)]
    troubles = [one for one in found if one]
    if propose and (found[-1] or found[-2]):
        troubles[-1] = replace(troubles[-1], hint=_proposal(design, mechanism, spring))
    return troubles


def _rate(design: DesignFile, spring: HelicalSpring) -> Trouble | None:
    """The rate of wire and coil beside the stiffness of the model."""
    stiffness = design.value("spring.stiffness")
    curved = design.value("spring.stiffness2") or design.value("spring.stiffness3")
    if curved or abs(spring.rate - stiffness) <= SAME_RATE * stiffness:
        return None
    coils = spring.active_coils * spring.rate / stiffness if stiffness > 0.0 else 0.0
    text = (
        f"helical_spring has the rate {spring.rate / 1e3:.4g} N/mm, and spring.stiffness is"
        f" {stiffness / 1e3:.4g} N/mm: both must be one rate. spring.stiffness = {spring.rate:.6g} N/m fits"
    )
    text += f", or helical_spring.active_coils = {coils:.4g}" if coils >= 2.0 else ""
    is_other = abs(spring.rate - stiffness) > OTHER_SPRING * stiffness
    severity = ERROR if is_other else WARNING
    return trouble(design, "spring rate", "helical_spring.active_coils", text, severity)


def _grade(design: DesignFile, spring: HelicalSpring) -> Trouble | None:
    """A wire for static duty where the design asks for many cycles."""
    limits = design.limits or Limits()
    is_asked = limits.cycles > 0.0 or ("limits", "spring_safety") in design.lines
    if spring.grade is None or spring.grade not in DYNAMIC_GRADES or not is_asked:
        return None
    text = (
        f"helical_spring.grade = {spring.grade}: EN 10270-1 has this wire for static duty; write"
        f' grade = "{DYNAMIC_GRADES[spring.grade]}", a wire for dynamic duty'
    )
    return trouble(design, "spring grade", "helical_spring.grade", text, WARNING)


def _index(design: DesignFile, spring: HelicalSpring) -> Trouble | None:
    low, high = INDEX
    if low <= spring.index <= high:
        return None
    text = (
        f"spring index coil_diameter/wire_diameter = {spring.index:.4g}: a spring coiled cold has {low:g} to"
        f" {high:g} (EN 13906-1)"
    )
    return trouble(design, "spring index", "helical_spring.coil_diameter", text, WARNING)


def _lengths(design: DesignFile, mechanism: Mechanism, spring: HelicalSpring) -> list[Trouble]:
    """Length at full stroke and buckling, where the free length is known."""
    if design.spring_limits is None or mechanism.spring.stiffness <= 0.0:
        return []
    free = design.spring_limits.free_length
    z = float(mechanism.configuration(mechanism.reach()[1]).z)
    deflection = mechanism.spring.preload / mechanism.spring.stiffness + z
    found = []
    given = design.spring_limits.solid_length
    if given < (1.0 - SAME_LENGTH) * spring.solid_length:
        text = (
            f"spring.solid_length = {1e3 * given:.4g} mm: wire and coil of helical_spring give"
            f" {1e3 * spring.solid_length:.4g} mm; write the larger one"
        )
        found.append(trouble(design, "coil length", "spring.solid_length", text, WARNING))
    if free - deflection < spring.least_length:
        is_solid = free - deflection <= spring.solid_length
        text = (
            f"spring length at full stroke, {1e3 * (free - deflection):.4g} mm: allowed is"
            f" {1e3 * spring.least_length:.4g} mm or more, the solid length of helical_spring,"
            f" {1e3 * spring.solid_length:.4g} mm, and the gaps between the coils (EN 13906-1)"
        )
        severity = ERROR if is_solid else WARNING
        found.append(trouble(design, "spring length", "spring.free_length", text, severity))
    critical = spring.buckling_deflection(free)
    if deflection >= critical:
        text = (
            f"buckling: between parallel plates the spring of free_length = {1e3 * free:.4g} mm buckles at"
            f" the deflection {1e3 * critical:.4g} mm; full stroke needs {1e3 * deflection:.4g} mm. Write"
            " guided = true below [helical_spring] if a rod or a sleeve guides the spring"
        )
        found.append(trouble(design, "buckling", "helical_spring.coil_diameter", text, WARNING))
    return found


def _static(design: DesignFile, spring: HelicalSpring, largest: float) -> Trouble | None:
    stress, allowed = spring.stress(largest), spring.allowed_stress / 1e6
    if stress <= spring.allowed_stress:
        return None
    text = (
        f"spring stress: at full stroke, {largest:.4g} N, the shear stress is"
        f" {shown_beside(stress / 1e6, allowed, 4)} MPa: allowed is 0.56 of the tensile strength,"
        f" {allowed:.4g} MPa (EN 13906-1); with more"
        " stress the spring sets"
    )
    return trouble(design, "spring stress", WIRE, text)


def _fatigue(design: DesignFile, mechanism: Mechanism, spring: HelicalSpring) -> Trouble | None:
    cycle, limit = spring_fatigue(spring, mechanism), (design.limits or Limits()).spring_safety
    if cycle.safety >= limit:
        return None
    default = "" if ("limits", "spring_safety") in design.lines else ", the default of limits.spring_safety"
    text = (
        f"spring fatigue: between {cycle.lower / 1e6:.4g} and {cycle.upper / 1e6:.4g} MPa the Goodman safety"
        f" is {shown_beside(cycle.safety, limit)}: allowed is {limit:g} or more{default}"
    )
    return trouble(design, "spring fatigue", WIRE, text)


def _proposal(design: DesignFile, mechanism: Mechanism, spring: HelicalSpring) -> str:
    """The lightest spring in a standard wire that lasts, of the same strength or of DH, for dynamic duty."""
    least, largest = spring_forces(mechanism)
    stiffness = mechanism.spring.stiffness
    if stiffness <= 0.0 or largest <= least:
        return ""
    safety = (design.limits or Limits()).spring_safety
    space = design.spring_limits.free_length if design.spring_limits else math.inf
    for outer, free in ((spring.outer_diameter, space), (math.inf, math.inf)):
        try:
            best = find_springs(
                least,
                stiffness,
                (largest - least) / stiffness,
                grade=DYNAMIC_GRADES.get(spring.grade or "DH", spring.grade or "DH"),
                shot_peened=spring.shot_peened,
                safety=ROUNDING * safety,
                outer_diameter=outer,
                free_length=free,
                guided=spring.guided,
            )[0]
        except DesignError:
            continue
        rounded = replace(best, coil_diameter=float(f"{best.coil_diameter:.4g}"))
        return _followable(rounded, mechanism, least, largest)
    peened = "" if spring.shot_peened else "; shot_peened = true makes a wire endure more"
    return f"No spring in a standard wire lasts{peened}"


def _followable(spring: HelicalSpring, mechanism: Mechanism, least: float, largest: float) -> str:
    """All keys of a spring, as a design file has them. Lengths are rounded up."""
    free = spring.least_length + largest / mechanism.spring.stiffness
    return (
        f'A spring that lasts: helical_spring.grade = "{spring.grade}",'
        f' wire_diameter = "{1e3 * spring.wire_diameter:g} mm",'
        f' coil_diameter = "{1e3 * spring.coil_diameter:.4g} mm", active_coils = {spring.active_coils:g};'
        f' spring.free_length = "{_rounded_up(1e3 * free):g} mm",'
        f' solid_length = "{_rounded_up(1e3 * spring.solid_length):g} mm". This spring has the safety'
        f" {spring.fatigue(least, largest).safety:.3g}"
    )


def _rounded_up(length: float) -> float:
    """A length of four digits or less that is not shorter."""
    scale = 10.0 ** (math.floor(math.log10(length)) - 3)
    return float(f"{math.ceil(length / scale - 1e-9) * scale:.4g}")


def _roller(design: DesignFile) -> list[Trouble]:
    roller = design.roller
    if roller is None:
        return []
    found = []
    if not roller.rolls:
        text = (
            f"the roller slides: rolling needs the coefficient {roller.rolling_friction:.4g}, sliding only"
            f" sliding_friction = {roller.sliding_friction:.4g}"
        )
        if roller.largest_bearing_friction > 0.0:
            text += f"; the roller rolls with bearing_friction up to {roller.largest_bearing_friction:.4g}"
        found.append(trouble(design, "roller", "roller.bearing_friction", text, WARNING))
    for key in ("cam1.friction", "cam2.friction"):
        given = design.value(key)
        if abs(given - roller.friction) > SAME_FRICTION * max(given, roller.friction):
            motion = "rolls" if roller.rolls else "slides"
            text = (
                f"{key} = {given:.4g}: the roller {motion} with the coefficient {roller.friction:.4g}; write"
                f" {key} = {roller.friction:.4g}"
            )
            found.append(trouble(design, "roller friction", key, text, WARNING))
    return found


def _wear(design: DesignFile, mechanism: Mechanism) -> list[Trouble]:
    limits = design.limits or Limits()
    if limits.cycles == 0.0:
        return []
    try:
        found = wear_of(design, mechanism)
    except DesignError:  # undercut and level grooves have findings of their own
        return []
    if found is None:
        rates = "cam1.wear, cam2.wear"
        needed = rates if design.pin else f"[pin] and {rates} or pin.wear"
        text = f"limits.cycles = {limits.cycles:g} is not checked: give {needed}, the specific wear rates"
        return [trouble(design, "wear unknown", "limits.cycles", text, WARNING)]
    life = wear_life(design, found)
    if life.cycles >= limits.cycles:
        return []
    text = (
        f"wear: {life.part} is {1e3 * limits.wear_depth:.4g} mm deep (limits.wear_depth) after"
        f" {shown_beside(life.cycles, limits.cycles, 4)} cycles: allowed is limits.cycles ="
        f" {limits.cycles:.4g} cycles or more"
    )
    return [trouble(design, "wear", "pin.width", text, ERROR, Remedy("pin.width", 0.2))]
