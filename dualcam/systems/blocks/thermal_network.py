"""A thermal network of two masses: friction heats the contact zone, the housing cools in the air.

    C_contact dT_contact/dt = P - G_contact (T_contact - T_housing)
    C_housing dT_housing/dt = G_contact (T_contact - T_housing) - G_air (T_housing - T_air)

Under a constant power P the answer over any time is exact: a matrix exponential of both temperatures
together with the heat that has gone to the air. The account of that heat is an integral of its own, so the
energy balance is a check.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from dualcam.design.statics import Array
from dualcam.errors import DesignError
from dualcam.systems.blocks.grease import check_number, check_temperature


class ThermalState(NamedTuple):
    """Temperatures and accounts of a network.

    Parameters
    ----------
    contact : Temperature of the contact zone [K].
    housing : Temperature of the housing [K].
    heat_in : Heat that has come in so far [J].
    heat_out : Heat that has gone to the air so far [J].
    """

    contact: float
    housing: float
    heat_in: float = 0.0
    heat_out: float = 0.0


@dataclass(frozen=True)
class TwoMassNetwork:
    """Contact zone and housing, in air.

    Parameters
    ----------
    contact_capacity
        Heat capacity of the contact zone: pins, followers and the surface of the grooves [J/K].
    housing_capacity : Heat capacity of cams and housing [J/K].
    contact_conductance : Thermal conductance from the contact zone to the housing [W/K].
    air_conductance : Thermal conductance from the housing to the air [W/K].
    air : Temperature of the air [K].

    Raises
    ------
    DesignError : A value is not finite or not > 0, or `air` looks like degrees Celsius (below 150 K).

    Examples
    --------
    >>> from dualcam.systems.blocks.thermal_network import TwoMassNetwork
    >>> network = TwoMassNetwork(50.0, 500.0, 0.5, 0.25, air=278.15)
    >>> state = network.advance(network.start(), power=4.0, duration=3600.0)
    >>> round(state.contact - 273.15, 2), round(state.housing - 273.15, 2)  # degC
    (25.57, 17.73)
    >>> round(state.heat_in - state.heat_out - network.stored(state), 6)  # J
    0.0
    """

    contact_capacity: float
    housing_capacity: float
    contact_conductance: float
    air_conductance: float
    air: float

    def __post_init__(self) -> None:
        for name in ("contact_capacity", "housing_capacity"):
            check_number(name, getattr(self, name), 0.0, "J/K", above=True)
        for name in ("contact_conductance", "air_conductance"):
            check_number(name, getattr(self, name), 0.0, "W/K", above=True)
        check_temperature("air", self.air)

    def start(self) -> ThermalState:
        """Both masses as warm as the air."""
        return ThermalState(self.air, self.air)

    def stored(self, state: ThermalState) -> float:
        """Heat [J] in both masses in a `state`, above that at the temperature of the air."""
        return self.contact_capacity * (state.contact - self.air) + self.housing_capacity * (
            state.housing - self.air
        )

    def settled(self, power: float) -> ThermalState:
        """Temperatures after long under a constant `power` into the contact zone [W]; accounts are 0."""
        housing = self.air + power / self.air_conductance
        return ThermalState(housing + power / self.contact_conductance, housing)

    def advance(self, state: ThermalState, power: float, duration: float) -> ThermalState:
        """The state after some time under a constant power, exactly, from a `state`.

        `power` into the contact zone [W]. `duration`: time [s], >= 0. DesignError: `duration` is negative or
        not finite, or `power` is not finite.
        """
        check_number("duration", duration, 0.0, "s")
        if not math.isfinite(power):
            raise DesignError(f"power = {power!r}: allowed is a finite number [W]")
        rise = np.array([state.contact - self.air, state.housing - self.air, 0.0, power])
        contact, housing, heat_out, _ = _transition(self, duration) @ rise
        return ThermalState(
            self.air + float(contact),
            self.air + float(housing),
            state.heat_in + power * duration,
            state.heat_out + float(heat_out),
        )


@lru_cache(maxsize=32)
def _transition(network: TwoMassNetwork, duration: float) -> Array:
    """Matrix that maps (contact - air, housing - air, heat to the air, power) over that time."""
    rates = np.zeros((4, 4))
    to_housing, to_air = network.contact_conductance, network.air_conductance
    rates[0, [0, 1, 3]] = np.array([-to_housing, to_housing, 1.0]) / network.contact_capacity
    rates[1, [0, 1]] = np.array([to_housing, -to_housing - to_air]) / network.housing_capacity
    rates[2, 1] = to_air
    return np.asarray(expm(rates * duration))
