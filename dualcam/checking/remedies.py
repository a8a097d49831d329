"""Values that mend a finding, found by search: only values of a sensible size, and each of them is tried."""

import math
from collections.abc import Callable
from dataclasses import replace

from dualcam.checking.rules import troubles
from dualcam.checking.trouble import Remedy, Trouble, value_of, with_value
from dualcam.design_file import DesignFile, Finding
from dualcam.design_file.findings import ERROR
from dualcam.errors import DualcamError
from dualcam.fmi.variables import all_parameters

PIN_UNITS = {"pin.radius": "m", "pin.width": "m"}
SMALLEST_RANGE = math.radians(1.0)  # of theta
SMALLEST_SHARE = 0.1  # of the range that the file gives
SMALLEST_LEAD_ANGLE = math.radians(1.0)
SMALLEST_FRICTION = 0.02  # of a lubricated contact
LARGEST_FACTOR = {"spring.preload": 3.0, "pin.width": 5.0, "pin.radius": 5.0}
DIGITS = 4  # of a proposed value
# Shares of the way to the bound that are tried until one works: denser at both ends.
SHARES = sorted({(k / 24) ** 2 for k in range(1, 25)} | {1.0 - 0.5**k for k in range(1, 20)})
HALVINGS = 40


class RemedySearch:
    """Searches values for the findings of one design. A value that was tried once is not tried again."""

    def __init__(self, design: DesignFile, found: list[Trouble], reason: Callable[[DesignFile], str]) -> None:
        self.design = design
        self.refusal = reason  # the FMU's message if it does not start with a design
        self.errors = frozenset(one.finding.kind for one in found if one.finding.severity == ERROR)
        self._tried: dict[tuple[str, float], dict[str, bool] | None] = {}

    def mended(self, trouble: Trouble) -> Finding:
        """The finding with a value that "works": the whole check passes, and no former error is left as a
        warning. Else with one that removes this finding and makes no new error."""
        for whole, words in ((True, "works"), (False, "mends this finding, not the others")):
            for remedy in trouble.remedies:
                value = self._value(trouble.finding, remedy, whole)
                if value is not None:
                    shown = f"{remedy.key} = {_shown(remedy.key, value)} {words}"
                    text = ". ".join(filter(None, [trouble.finding.text, shown, trouble.hint]))
                    return replace(trouble.finding, text=text, nearest=value, change=remedy.key)
        text = ". ".join(filter(None, [trouble.finding.text, trouble.hint]))
        return replace(trouble.finding, text=text)

    def _value(self, finding: Finding, remedy: Remedy, whole: bool) -> float | None:
        """The nearest value of the remedy's key without the finding; if `whole`, without any error."""
        current = value_of(self.design, remedy.key)
        if current is None or current == remedy.bound:
            return None
        allowed = frozenset() if whole else self.errors - {finding.kind}
        mended = {finding.kind, *(self.errors if whole else ())}

        def works(value: float) -> bool:
            if not is_sensible(self.design, remedy.key, value):
                return False
            kinds = self._kinds(remedy.key, value)
            if kinds is None or mended & kinds.keys():
                return False
            return {kind for kind, is_error in kinds.items() if is_error} <= allowed

        value = nearest_working(float(current), remedy.bound, works)
        if value is not None and whole and self.refusal(with_value(self.design, remedy.key, value)):
            return None
        return value

    def _kinds(self, key: str, value: float) -> dict[str, bool] | None:
        """Kinds of what is found with another value -> whether errors; None for a design that cannot be."""
        place = (key, value)
        if place not in self._tried:
            try:
                left = [one.finding for one in troubles(with_value(self.design, key, value), locate=False)]
                severities = sorted((one.kind, one.severity == ERROR) for one in left)  # an error comes last
                self._tried[place] = dict(severities)
            except DualcamError:
                self._tried[place] = None
        return self._tried[place]


def is_sensible(design: DesignFile, key: str, value: float) -> bool:
    """Whether an engineer could mean this value in place of the one in the file."""
    given = value_of(design, key)
    if key in ("stop.lower", "stop.upper"):
        width = design.value("stop.upper") - design.value("stop.lower")
        left = width + (value - given) * (1.0 if key == "stop.upper" else -1.0)
        return bool(left >= max(SMALLEST_RANGE, SMALLEST_SHARE * width))
    if key.endswith(".lead_angle"):
        return value >= SMALLEST_LEAD_ANGLE
    if key.endswith(".friction"):
        return value >= SMALLEST_FRICTION
    factor = LARGEST_FACTOR.get(key)
    if factor is None or given <= 0.0:
        return True
    return bool(given / factor <= value <= given * factor)


def _shown(key: str, value: float) -> str:
    """The value with its unit; a length as a design file has it, in mm."""
    known = all_parameters()
    unit = known[key].unit if key in known else PIN_UNITS.get(key, "1")
    if unit == "m":
        return f'"{1e3 * value:.10g} mm"'
    degrees = f" ({math.degrees(value):.4g} deg)" if unit == "rad" else ""
    return f"{value:.10g}" if unit == "1" else f"{value:.10g} {unit}{degrees}"


def nearest_working(current: float, bound: float, works: Callable[[float], bool]) -> float | None:
    """The value nearest to `current` on the way to `bound` that works, rounded towards `bound`, or None."""
    last = current
    for share in SHARES:
        probe = current + (bound - current) * share
        if works(probe):
            edge = _edge(last, probe, 1e-6 * abs(bound - current), works)
            return _rounded(edge, current, bound, works)
        last = probe
    return None


def _edge(bad: float, good: float, close: float, works: Callable[[float], bool]) -> float:
    """The working value next to values that do not work, to `close` or a ten-millionth of the value."""
    for _ in range(HALVINGS):
        middle = 0.5 * (bad + good)
        if middle in (bad, good) or abs(good - bad) <= max(close, 1e-7 * abs(good)):
            break
        if works(middle):
            good = middle
        else:
            bad = middle
    return good


def _rounded(edge: float, current: float, bound: float, works: Callable[[float], bool]) -> float:
    """`edge` with few digits, rounded towards the bound; `edge` itself if no such value works."""
    for digits in range(DIGITS, 10):
        rounded = round_away(edge, digits, up=bound > current)
        within = min(current, bound) <= rounded <= max(current, bound)
        if within and works(rounded):
            return rounded
    return edge


def round_away(value: float, digits: int, up: bool) -> float:
    """`value` to that many digits, up or down."""
    if value == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - digits + 1)
    count = math.ceil(value / unit) if up else math.floor(value / unit)
    return float(f"{count * unit:.{digits}g}")
