"""What an unknown key could mean."""

import re
from collections.abc import Iterable, Mapping
from decimal import Decimal
from difflib import get_close_matches

DIAMETERS = ("diameter", "d", "dia")
# Words of other programs and languages for the keys of this one.
OTHER_WORDS = {
    "r": "radius",
    "mu": "friction",
    "mu_k": "friction",
    "mu_s": "friction_peak",
    "static_friction": "friction_peak",
    "friction_static": "friction_peak",
    "stribeck_speed": "stribeck_velocity",
    "v_stribeck": "stribeck_velocity",
    "v_s": "stribeck_velocity",
    "angle": "lead_angle",
    "helix_angle": "lead_angle",
    "pitch": "lead_angle",
    "k": "stiffness",
    "rate": "stiffness",
    "f0": "preload",
    "force": "preload",
    "mass": "follower_mass",
    "j": "shaft",
    "csv": "table",
    "file": "table",
    "max": "upper",
    "min": "lower",
    "end": "stop",
    "duration": "stop",
    "stop_time": "stop",
    "torque": "tau",
    "n": "active_coils",
    "coils": "active_coils",
    "d": "wire_diameter",
    "mean_diameter": "coil_diameter",
    "material": "grade",
    "steel": "grade",
    "rm": "tensile_strength",
    "g": "shear_modulus",
}


def unknown_key(key: str, known: Mapping[str, str], value: object = None) -> str:
    """A sentence about an unknown key, dotted, with a value: the nearest names, also in other tables."""
    table, _, last = key.rpartition(".")
    if last.lower() in DIAMETERS and f"{table}.radius" in known:
        half = _half(value)
        written = f": write {table}.radius = {half}" if half else ""
        return f"{key} is no key: {table}.radius is half of the diameter{written}"
    guesses = nearest_keys(key, known)
    if guesses:
        return f"{key} is no key: did you mean {' or '.join(guesses)}?"
    if table in known:
        return f"{key} is no key: allowed in [{table}] are {', '.join(_within(table, known))}"
    return f"{key} is no key: allowed are {', '.join(_within('', known))}"


def _half(value: object) -> str:
    """Half of a number, or of a text with a number and a unit, as TOML; empty for another value."""
    number, unit = value, ""
    if isinstance(value, str) and (match := re.fullmatch(r"\s*([\d.]+)\s*(\D*)", value)):
        number, unit = match[1], match[2].strip()
    try:
        half = f"{Decimal(str(number)) / 2:f}"
    except ArithmeticError:
        return ""
    return f'"{half} {unit}"' if unit else half


def nearest_keys(key: str, known: Iterable[str]) -> list[str]:
    """The known keys that an unknown one is most likely to mean, at most three."""
    known = list(known)
    table, _, last = key.rpartition(".")
    last = last.lower()
    own = {name.rpartition(".")[2]: name for name in known if name.rpartition(".")[0] == table}
    if (meant := OTHER_WORDS.get(last)) in own:
        return [own[meant]]
    if close := get_close_matches(last, own, n=1, cutoff=0.7):
        return [own[close[0]]]
    if same := [name for name in known if name.rpartition(".")[2] == last]:
        return _first(same)
    if meant and not table:
        return _first([name for name in known if name.rpartition(".")[2] == meant])
    if close := get_close_matches(key.lower(), known, n=2, cutoff=0.8):
        return close
    elsewhere = {name.rpartition(".")[2] for name in known}
    if close := get_close_matches(last, elsewhere, n=1, cutoff=0.75):
        return _first([name for name in known if name.rpartition(".")[2] == close[0]])
    if close := get_close_matches(last, own, n=1, cutoff=0.6):
        return [own[close[0]]]
    return []


def _first(names: list[str]) -> list[str]:
    """At most three; those of the FMU's parameters if there are any, else those of other tables."""
    others = ("scenario", "pin", "roller", "helical_spring", "limits", "study")
    return ([name for name in names if not name.startswith(others)] or names)[:3]


def _within(table: str, known: Mapping[str, str]) -> list[str]:
    return [name.rpartition(".")[2] for name in known if name.rpartition(".")[0] == table]
