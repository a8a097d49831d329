"""A roller on the pin: does it roll in the groove, and with which coefficient of friction?

Bearing and rolling resistance brake the roller: mu_eff = (mu_b r_b + f)/r. It rolls while mu_eff is at most
the coefficient mu of sliding on the flank; else mu acts. Source: docs/design-quantities.md.
"""

import math
from dataclasses import dataclass

from dualcam.common.unit_guards import warn_units
from dualcam.design.statics import check_numbers
from dualcam.errors import DesignError


@dataclass(frozen=True)
class Roller:
    """A roller that turns on the pin.

    Parameters
    ----------
    radius : Outer radius of the roller [m], > 0.
    bearing_friction : Coefficient of friction in the bearing of the roller [1], >= 0.
    bearing_radius : Radius at which the bearing rubs [m], > 0 and less than `radius`.
    lever_arm : Lever arm of rolling resistance between roller and flank [m], >= 0 and less than `radius`.
    sliding_friction : Coefficient of friction of a roller that slides on the flank [1], >= 0.

    Raises
    ------
    DesignError : A value outside its range.

    Examples
    --------
    By hand: (0.08 * 2 mm + 0.01 mm)/5 mm = 0.17/5 = 0.034, less than 0.14.

    >>> from dualcam.design import Roller
    >>> roller = Roller(radius=0.005, bearing_friction=0.08, bearing_radius=0.002, lever_arm=1e-5)
    >>> round(roller.rolling_friction, 4), roller.rolls
    (0.034, True)
    """

    radius: float
    bearing_friction: float
    bearing_radius: float
    lever_arm: float = 0.0
    sliding_friction: float = 0.14

    def __post_init__(self) -> None:
        check_numbers(vars(self))
        if not 0.0 < self.radius < math.inf:
            raise DesignError(f"radius = {self.radius}: allowed is a finite number > 0 in m")
        for name in ("bearing_friction", "sliding_friction"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise DesignError(f"{name} = {getattr(self, name)}: allowed is a finite number >= 0")
        if not 0.0 < self.bearing_radius < self.radius:
            raise DesignError(
                f"bearing_radius = {self.bearing_radius:g} m: allowed is more than 0 and less than the radius"
                f" of the roller, {self.radius:g} m"
            )
        if not 0.0 <= self.lever_arm < self.radius:
            raise DesignError(
                f"lever_arm = {self.lever_arm:g} m: allowed is 0 to less than the radius of the roller,"
                f" {self.radius:g} m; hardened steel on hardened steel has about 1e-5 m"
            )
        lengths = ("bearing_radius", "lever_arm")
        warn_units({name: (f"roller.{name}", getattr(self, name)) for name in lengths})

    @property
    def rolling_friction(self) -> float:
        """Tangential over normal force of a roller that rolls [1]."""
        return (self.bearing_friction * self.bearing_radius + self.lever_arm) / self.radius

    @property
    def rolls(self) -> bool:
        """Whether the roller rolls: sliding would need at least as large a force."""
        return self.rolling_friction <= self.sliding_friction

    @property
    def friction(self) -> float:
        """The coefficient of friction in effect [1], for `cam1.friction` and `cam2.friction`."""
        return min(self.rolling_friction, self.sliding_friction)

    @property
    def largest_bearing_friction(self) -> float:
        """The largest coefficient of friction in the bearing with which the roller still rolls [1]; below 0
        where the lever arm alone makes the roller slide."""
        return (self.sliding_friction * self.radius - self.lever_arm) / self.bearing_radius
