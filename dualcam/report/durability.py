"""The part of the report about what lasts: contact stress, roller, spring, wear."""

from html import escape

import numpy as np

from dualcam.common.html_page import figure_element, table
from dualcam.design import Limits, Mechanism, Pin
from dualcam.design_file import DesignFile
from dualcam.design_file.durability import (
    largest_contact,
    roller_numbers,
    spring_fatigue,
    spring_numbers,
    torque_changes,
    wear_numbers,
    wear_of,
)
from dualcam.errors import DesignError
from dualcam.plots.design import plot_contact, plot_goodman, plot_wear
from dualcam.report.inputs import Row
from dualcam.report.summary import largest_loads, material_words, pressure_words


def durability_sections(design: DesignFile, mechanism: Mechanism) -> list[str]:
    """Sections as HTML, as far as the design has their data."""
    found = [_roller(design), _spring(design, mechanism), _wear(design, mechanism)]
    contact = [] if design.pin is None else [_contact(design, mechanism, design.pin)]
    return [*contact, *(section for section in found if section)]


def _contact(design: DesignFile, mechanism: Mechanism, pin: Pin) -> str:
    limit = (design.limits or Limits()).pressure
    default = "" if design.limits else ", the default limit for any material"
    largest = largest_loads(mechanism, pin).pressure
    if largest is None or not np.isfinite(largest.value):
        rows: list[Row] = [] if largest is None else [("largest contact pressure", pressure_words(largest))]
        return "<h2>Contact pressure</h2>\n" + table(("what", "value"), rows)
    contact = largest_contact(mechanism, pin, largest.cams[0], largest.theta)
    rows = [
        ("largest contact pressure", pressure_words(largest)),
        ("allowed contact pressure", f"{limit / 1e6:.4g} MPa{default}"),
        ("Young's moduli", material_words(pin)),
        ("width of the contact there", f"{2e3 * float(contact.half_width):.3g} mm"),
        ("largest shear stress there", f"{float(contact.shear) / 1e6:.4g} MPa"),
        ("depth of that stress below the surface", f"{1e3 * float(contact.depth):.3g} mm"),
    ]
    text = (
        "Pressure of a line contact by Hertz, for one contact, the larger one of slow loading and releasing."
        " The shear stress is the largest one below the surface. A hardened layer must reach deeper than that"
        " place."
    )
    picture = figure_element(plot_contact(mechanism, pin, limit), "Contact pressure along each groove")
    return f"<h2>Contact pressure</h2>\n<p>{text}</p>\n" + table(("what", "value"), rows) + picture


def _roller(design: DesignFile) -> str:
    numbers = roller_numbers(design)
    if numbers is None:
        return ""
    rows = [
        ("the roller", "rolls" if numbers.rolls else "slides"),
        ("coefficient of friction in effect", f"{numbers.friction:.4g}"),
        ("of rolling", f"{numbers.rolling_friction:.4g}"),
        ("of sliding", f"{numbers.sliding_friction:.4g}"),
    ]
    text = "A roller rolls while rolling needs at most the tangential force at which the roller would slide."
    return f"<h2>Roller</h2>\n<p>{text}</p>\n" + table(("what", "value"), rows)


def _spring(design: DesignFile, mechanism: Mechanism) -> str:
    spring = design.helical_spring
    try:
        numbers = spring_numbers(design, mechanism)
    except DesignError as error:
        return f'<h2>Helical spring</h2>\n<p class="error">No stresses: {escape(str(error))}</p>\n'
    if spring is None or numbers is None:
        return ""
    rows = [
        ("rate of wire and coil", f"{numbers.rate / 1e3:.4g} N/mm"),
        ("spring index", f"{spring.index:.3g}, stress correction {spring.correction:.4g}"),
        ("force", f"{numbers.least:.4g} to {numbers.largest:.4g} N"),
        ("corrected shear stress", f"{numbers.lower / 1e6:.4g} to {numbers.upper / 1e6:.4g} MPa"),
        ("tensile strength", f"{spring.strength / 1e6:.4g} MPa"),
        ("Goodman safety", f"{numbers.safety:.3g}, allowed {numbers.limit:g} or more"),
        ("static safety", f"{numbers.static_safety:.3g}"),
        ("solid length", f"{1e3 * spring.solid_length:.4g} mm"),
        ("least length in motion", f"{1e3 * spring.least_length:.4g} mm"),
        ("mass", f"{1e3 * spring.mass:.3g} g"),
    ]
    if not numbers.has_length:
        lacks = "not checked, the file gives no spring.free_length and spring.solid_length"
        rows.append(("length and buckling", lacks))
    text = "Stress by EN 13906-1. The Goodman line is that of the wire, for any number of cycles."
    cycle = spring_fatigue(spring, mechanism)
    picture = figure_element(plot_goodman(spring, cycle, numbers.limit), "Goodman diagram of the spring")
    return f"<h2>Helical spring</h2>\n<p>{text}</p>\n" + table(("what", "value"), rows) + picture


def _wear(design: DesignFile, mechanism: Mechanism) -> str:
    try:
        found, numbers = wear_of(design, mechanism), wear_numbers(design, mechanism)
    except DesignError as error:
        return f'<h2>Wear</h2>\n<p class="error">No wear: {escape(str(error))}</p>\n'
    if found is None or numbers is None:
        return ""
    life = found.life(numbers.depth)
    counts = {"groove 1": life.groove1, "groove 2": life.groove2, "pin": life.pin}
    try:
        worn = found.after(life.cycles)
    except DesignError:
        worn = None
    rows = [
        ("allowed depth of wear", f"{1e3 * numbers.depth:.4g} mm"),
        *((f"{name}: cycles until {1e3 * numbers.depth:.4g} mm", f"{n:.4g}") for name, n in counts.items()),
        ("sliding distance of a cycle", " and ".join(f"{1e3 * way:.4g} mm" for way in found.path)),
    ]
    if worn is not None:
        rows.append(("preload lost after that", f"{worn.preload_loss:.3g} N"))
        rows += [(f"{name} after that", words) for name, words in torque_changes(numbers)]
    text = (
        "Archard's law. One cycle is a slow move from stop to stop and back. The curves are those after"
        f" {life.cycles:.4g} cycles, when {life.part} has the allowed depth."
    )
    text += " The roller rolls: the wear rates must be those of a rolling contact." if found.turns else ""
    picture = figure_element(plot_wear(found, worn, life.cycles), "Wear along each groove")
    return f"<h2>Wear</h2>\n<p>{text}</p>\n" + table(("what", "value"), rows) + picture
