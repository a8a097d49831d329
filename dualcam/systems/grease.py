"""Grease whose viscosity falls with the temperature, and the friction in a groove that follows from it.

The base oil obeys Vogel's law, with the temperature T [K]:

    eta(T) = A exp(B/(T - C))

The friction coefficient of a lubricated contact under a given load depends on the product of viscosity and
sliding speed (Hersey number eta v/p). The FMU's law over the sliding speed v (docs/mechanism.md, section 9)
keeps its shape over eta v, so two of its coefficients move with the temperature:

    mu(v, T) = mu_k [1 + (peak - 1) exp(-(v/v_s)^delta)] + mu_v v
    v_s(T) = v_s(40 degC) eta(40 degC)/eta(T)         the Stribeck velocity: the thinner the oil, the faster
    mu_v(T) = mu_v(40 degC) eta(T)/eta(40 degC)       the slope of the lubricated branch

The static and the kinetic coefficient are those of the boundary layer and stay as they are.

Sources. Vogel's law with all constants from the viscosity grade, for mineral oils of viscosity index 100:
ISO 7902-1 (plain bearings; formerly DIN 31652), with eta_x = 0.18 mPa.s and C = -95 degC. Viscosity grades:
ISO 3448. Hersey number: M. D. Hersey, The laws of lubrication of horizontal journal bearings (1914).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from dualcam.errors import DesignError

CELSIUS = 273.15  # K, 0 degC
REFERENCE = CELSIUS + 40.0  # K, the temperature of viscosity grades (ISO 3448)
COLDEST, HOTTEST = CELSIUS - 20.0, CELSIUS + 120.0  # K, where the law is used

# ln(eta/eta_x) = (159.56 K/(T - C) - 0.1819) ln(eta(40 degC)/eta_x), for viscosity index 100
ETA_X = 0.18e-3  # Pa.s
POLE = CELSIUS - 95.0  # K, Vogel's C
NUMERATOR, SUBTRAHEND = 159.56, 0.1819  # K, 1


def check_number(name: str, value: float, least: float, unit: str, *, above: bool = False) -> None:
    """Refuse a value that is not finite or too small.

    Parameters
    ----------
    name : str
        What the value is, for the message.
    value : float
        The value.
    least : float
        The least allowed value.
    unit : str
        Unit of the value, for the message.
    above : bool
        Whether the least value itself is refused, too.

    Raises
    ------
    DesignError
        The value is refused.

    Examples
    --------
    >>> from dualcam.systems.grease import check_number
    >>> check_number("density", 880.0, 0.0, "kg/m3", above=True)
    """
    if not math.isfinite(value) or value < least or (above and value == least):
        sign = ">" if above else ">="
        raise DesignError(f"{name} = {value!r}: allowed is a finite number {sign} {least:g} {unit}")


@dataclass(frozen=True)
class BaseOil:
    """The base oil of a grease: a mineral oil of viscosity index 100.

    Parameters
    ----------
    grade : float
        Viscosity grade by ISO 3448: kinematic viscosity at 40 degC [mm2/s].
    density : float
        Density [kg/m3].

    Raises
    ------
    DesignError
        A value is not finite or not > 0.

    Examples
    --------
    >>> from dualcam.systems.grease import BaseOil
    >>> oil = BaseOil(grade=100.0, density=880.0)
    >>> [round(oil.viscosity(273.15 + t), 4) for t in (0.0, 40.0, 100.0)]  # Pa.s
    [1.918, 0.088, 0.0093]
    """

    grade: float
    density: float = 880.0

    def __post_init__(self) -> None:
        check_number("grade", self.grade, 0.0, "mm2/s", above=True)
        check_number("density", self.density, 0.0, "kg/m3", above=True)

    @property
    def _exponent(self) -> float:
        """ln(eta(40 degC)/eta_x)."""
        return math.log(self.density * self.grade * 1e-6 / ETA_X)

    @property
    def vogel(self) -> tuple[float, float, float]:
        """Vogel's A [Pa.s], B [K] and C [K]."""
        return ETA_X * math.exp(-SUBTRAHEND * self._exponent), NUMERATOR * self._exponent, POLE

    def viscosity(self, temperature: float) -> float:
        """Dynamic viscosity by Vogel's law.

        Parameters
        ----------
        temperature : float
            Temperature [K], from -20 to 120 degC.

        Returns
        -------
        float
            Viscosity [Pa.s].

        Raises
        ------
        DesignError
            The temperature is outside that range.
        """
        if not COLDEST <= temperature <= HOTTEST:
            raise DesignError(
                f"temperature = {temperature!r} K: allowed is {COLDEST:g} to {HOTTEST:g} K (-20 to 120 degC),"
                " the range of the viscosity law"
            )
        a, b, c = self.vogel
        return a * math.exp(b / (temperature - c))

    def relative_viscosity(self, temperature: float) -> float:
        """Viscosity over that at 40 degC.

        Parameters
        ----------
        temperature : float
            Temperature [K], from -20 to 120 degC.

        Returns
        -------
        float
            eta(T)/eta(40 degC) [1].

        Raises
        ------
        DesignError
            The temperature is outside that range.
        """
        return self.viscosity(temperature) / self.viscosity(REFERENCE)


@dataclass(frozen=True)
class GreasedContact:
    """The friction of both grooves with one grease.

    Parameters
    ----------
    oil : BaseOil
        The base oil of the grease.
    kinetic : float
        Kinetic coefficient mu_k of the boundary layer [1].
    peak : float
        Static over kinetic coefficient [1].
    stribeck_velocity : float
        v_s at 40 degC [m/s].
    viscous : float
        Slope mu_v of the lubricated branch at 40 degC [s/m].

    Raises
    ------
    DesignError
        A value is not finite or too small.

    Examples
    --------
    >>> from dualcam.systems.grease import BaseOil, GreasedContact
    >>> contact = GreasedContact(BaseOil(100.0), 0.08, 1.5, 0.02, 0.25)
    >>> [round(contact.coefficient(0.05, 273.15 + t), 3) for t in (5.0, 20.0, 40.0)]  # 0.05 m/s
    [0.242, 0.125, 0.093]
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
        """The two coefficients that move with the temperature.

        Parameters
        ----------
        temperature : float
            Temperature [K], from -20 to 120 degC.

        Returns
        -------
        tuple of float
            Stribeck velocity [m/s] and slope of the lubricated branch [s/m].

        Raises
        ------
        DesignError
            The temperature is outside that range.
        """
        ratio = self.oil.relative_viscosity(temperature)
        return self.stribeck_velocity / ratio, self.viscous * ratio

    def coefficient(self, speed: float, temperature: float) -> float:
        """The friction coefficient of a sliding contact.

        Parameters
        ----------
        speed : float
            Sliding speed [m/s], >= 0; 0: at rest.
        temperature : float
            Temperature [K], from -20 to 120 degC.

        Returns
        -------
        float
            mu(v, T) [1].

        Raises
        ------
        DesignError
            The temperature is outside that range.
        """
        stribeck_velocity, viscous = self.law(temperature)
        fall = math.exp(-((speed / stribeck_velocity) ** 2))
        return self.kinetic * (1.0 + (self.peak - 1.0) * fall) + viscous * speed

    def parameters(self, temperature: float) -> Mapping[str, float]:
        """The FMU's parameters for both grooves.

        Parameters
        ----------
        temperature : float
            Temperature [K], from -20 to 120 degC.

        Returns
        -------
        mapping of str to float
            Values by the names of the FMU's parameters.

        Raises
        ------
        DesignError
            The temperature is outside that range.
        """
        stribeck_velocity, viscous = self.law(temperature)
        values = {
            "friction": self.kinetic,
            "friction_peak": self.peak,
            "stribeck_velocity": stribeck_velocity,
            "friction_viscous": viscous,
        }
        return {f"cam{i}.{name}": value for i in (1, 2) for name, value in values.items()}
