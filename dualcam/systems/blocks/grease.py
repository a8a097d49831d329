"""Grease whose viscosity falls with the temperature, and the friction in a groove that follows from it.

docs/use-temperature.md explains Vogel's law, from two viscosities of a data sheet and the line of ASTM D341
through both, and the friction that keeps its shape over viscosity times speed (Hersey number):

    eta(T) = A exp(B/(T - C))                         log10(log10(nu + 0.7)) = a - b log10(T)
    v_s(T) = v_s(40 degC) eta(40 degC)/eta(T)         the Stribeck velocity: the thinner the oil, the faster
    mu_v(T) = mu_v(40 degC) eta(T)/eta(40 degC)       the slope of the lubricated branch

Sources: H. Vogel, Physikalische Zeitschrift 22 (1921); ASTM D341; M. D. Hersey, The laws of lubrication of
horizontal journal bearings, Journal of the Washington Academy of Sciences 4 (1914).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from dualcam.design.statics import is_number
from dualcam.errors import DesignError

CELSIUS = 273.15  # K, 0 degC
REFERENCE = CELSIUS + 40.0  # K, the temperature of viscosity grades (ISO 3448)
BOILING = CELSIUS + 100.0  # K, the other temperature of data sheets
LOWEST_AIR = 150.0  # K: air on earth is warmer, so a lower number is in degC
COLDEST, HOTTEST = CELSIUS, CELSIUS + 120.0  # K, where the law is used


def check_number(name: str, value: float, least: float, unit: str, *, above: bool = False) -> None:
    """Refuse with a DesignError a value that is not finite or too small.

    `name` and `unit` of the `value` are for the message. `least`: the least allowed value; `above`: refuse
    this one, too.
    """
    if not _is_finite(value) or value < least or (above and value == least):
        sign = ">" if above else ">="
        allowed = f"{name} = {value!r}: allowed is a finite number {sign} {least:g} {unit}".rstrip()
        raise DesignError(f"{allowed}, without quotes" if isinstance(value, str) else allowed)


def _is_finite(value: object) -> bool:
    """Whether a value is a finite number, and no text or truth value."""
    return is_number(value) and math.isfinite(value)  # type: ignore[arg-type]


def check_temperature(name: str, value: float) -> None:
    """DesignError for a `value` [K] that is no number, or so low that degrees Celsius are meant.

    `name`: what the value is, for the message.
    """
    if _is_finite(value) and value < LOWEST_AIR:
        raise DesignError(
            f"{name} = {value:g} K: is this degC? Add {CELSIUS}: {name} = {value + CELSIUS:g}; allowed are"
            " temperatures in K"
        )
    check_number(name, value, LOWEST_AIR, "K")


@dataclass(frozen=True)
class BaseOil:
    """The base oil of a grease, from its data sheet.

    `viscosity_40`: kinematic viscosity at 40 degC [mm2/s]. `viscosity_100`: kinematic viscosity at 100 degC
    [mm2/s], above 1 and below that at 40 degC. `density` [kg/m3]. DesignError: a value is not finite or not
    in its range.

    Examples
    --------
    >>> from dualcam.systems.blocks.grease import BaseOil
    >>> oil = BaseOil(viscosity_40=110.0, viscosity_100=11.0, density=900.0)
    >>> [round(oil.viscosity(273.15 + t), 4) for t in (0.0, 40.0, 100.0)]  # Pa.s
    [2.2107, 0.099, 0.0099]
    """

    viscosity_40: float
    viscosity_100: float
    density: float = 900.0

    def __post_init__(self) -> None:
        check_number("density", self.density, 0.0, "kg/m3", above=True)
        check_number("viscosity_100", self.viscosity_100, 1.0, "mm2/s", above=True)
        check_number("viscosity_40", self.viscosity_40, self.viscosity_100, "mm2/s", above=True)

    @cached_property
    def vogel(self) -> tuple[float, float, float]:
        """Vogel's A [Pa.s], B [K] and C [K]."""
        points = (CELSIUS, REFERENCE, BOILING)
        cold, middle, hot = (math.log(1e-6 * self.density * self._astm_d341(t)) for t in points)
        # (cold - middle)/(middle - hot) holds C alone, linear in numerator and denominator.
        ratio = (cold - middle) / (middle - hot)
        spans = (points[1] - points[0]) / (points[2] - points[1])
        c = (ratio * points[0] - spans * points[2]) / (ratio - spans)
        b = (middle - hot) / (1.0 / (points[1] - c) - 1.0 / (points[2] - c))
        return math.exp(middle - b / (points[1] - c)), b, c

    def _astm_d341(self, temperature: float) -> float:
        """Kinematic viscosity [mm2/s] on the line of ASTM D341."""
        at_40, at_100 = (math.log10(math.log10(nu + 0.7)) for nu in (self.viscosity_40, self.viscosity_100))
        share = math.log10(temperature / REFERENCE) / math.log10(BOILING / REFERENCE)
        return float(10.0 ** (10.0 ** (at_40 + share * (at_100 - at_40))) - 0.7)

    def viscosity(self, temperature: float) -> float:
        """Dynamic viscosity by Vogel's law [Pa.s].

        `temperature` [K], from 0 to 120 degC. DesignError: the temperature is outside that range.
        """
        check_temperature("temperature", temperature)
        if not COLDEST <= temperature <= HOTTEST:
            raise DesignError(
                f"temperature = {temperature!r} K: allowed is {COLDEST:g} to {HOTTEST:g} K (0 to 120 degC),"
                " the range of the viscosity law"
            )
        a, b, c = self.vogel
        return a * math.exp(b / (temperature - c))

    def relative_viscosity(self, temperature: float) -> float:
        """Viscosity over that at 40 degC: eta(T)/eta(40 degC) [1].

        `temperature` [K], from 0 to 120 degC. DesignError: the temperature is outside that range.
        """
        return self.viscosity(temperature) / self.viscosity(REFERENCE)


@dataclass(frozen=True)
class GreasedContact:
    """The friction of both grooves with one grease.

    Parameters
    ----------
    oil : The base oil of the grease.
    kinetic : Kinetic coefficient mu_k of the boundary layer [1].
    peak : Static over kinetic coefficient [1].
    stribeck_velocity : v_s at 40 degC [m/s].
    viscous : Slope mu_v of the lubricated branch at 40 degC [s/m].

    Raises
    ------
    DesignError : A value is not finite or too small.

    Examples
    --------
    >>> from dualcam.systems.blocks.grease import BaseOil, GreasedContact
    >>> contact = GreasedContact(BaseOil(110.0, 11.0), 0.08, 1.5, 0.02, 0.25)
    >>> [round(contact.coefficient(0.05, 273.15 + t), 3) for t in (5.0, 20.0, 40.0)]  # 0.05 m/s
    [0.246, 0.125, 0.093]
    """

    oil: BaseOil
    kinetic: float
    peak: float
    stribeck_velocity: float
    viscous: float

    def __post_init__(self) -> None:
        check_number("kinetic", self.kinetic, 0.0, "")
        check_number("peak", self.peak, 1.0, "")
        check_number("stribeck_velocity", self.stribeck_velocity, 0.0, "m/s", above=True)
        check_number("viscous", self.viscous, 0.0, "s/m")

    def law(self, temperature: float) -> tuple[float, float]:
        """The Stribeck velocity [m/s] and the slope of the lubricated branch [s/m], which follow the
        temperature.

        `temperature` [K], from 0 to 120 degC. DesignError: the temperature is outside that range.
        """
        ratio = self.oil.relative_viscosity(temperature)
        return self.stribeck_velocity / ratio, self.viscous * ratio

    def coefficient(self, speed: float, temperature: float) -> float:
        """The friction coefficient of a sliding contact: mu(v, T) [1].

        `speed`: sliding speed [m/s], >= 0; 0: at rest. `temperature` [K], from 0 to 120 degC. DesignError:
        the temperature is outside that range.
        """
        stribeck_velocity, viscous = self.law(temperature)
        fall = math.exp(-((speed / stribeck_velocity) ** 2))
        return self.kinetic * (1.0 + (self.peak - 1.0) * fall) + viscous * speed

    def parameters(self, temperature: float) -> Mapping[str, float]:
        """The FMU's parameters for both grooves, by name.

        `temperature` [K], from 0 to 120 degC. DesignError: the temperature is outside that range.
        """
        stribeck_velocity, viscous = self.law(temperature)
        values = {
            "friction": self.kinetic,
            "friction_peak": self.peak,
            "stribeck_velocity": stribeck_velocity,
            "friction_viscous": viscous,
        }
        return {f"cam{i}.{name}": value for i in (1, 2) for name, value in values.items()}
