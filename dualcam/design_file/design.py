"""A design, as read from a file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dualcam.common.arrays import Array
from dualcam.common.groove_laws import PARAMETERS
from dualcam.common.unit_guards import units_checked_before
from dualcam.design_file.findings import Finding
from dualcam.errors import DesignError
from dualcam.fmi.model_description import Scalar
from dualcam.fmi.variables import all_parameters, parameters_of

if TYPE_CHECKING:
    from dualcam.design import Groove, HelicalSpring, Limits, Mechanism, Pin, Roller
    from dualcam.design.load_law import LoadLaw
    from dualcam.scenario.scenario import Scenario

DEFAULT_SAMPLES = 1000  # where the scenario gives no output interval
MOST_SAMPLES = 2_000_000


class SpringLimits(NamedTuple):
    """Lengths of the spring."""

    free_length: float  # m, unloaded
    solid_length: float  # m, all coils in contact


@dataclass(frozen=True)
class DesignFile:
    """A design of the dual cam.

    Attributes
    ----------
    path : The file.
    parameters : dict
        Names of the FMUs' parameters and values in SI units: those that the file gives. Paths of tables are
        absolute, and the FMU reads these tables.
    model : The model that the scenario drives: "inverse" where the scenario gives theta, else "forward".
    scenario : Inputs over time, as in parameter studies.
    output_interval : Time between two samples of a simulation [s].
    pin : The pin and its material.
    roller : The roller with the radius of the pin.
    helical_spring : Wire and coil of the spring.
    spring_limits : Free and solid length of the spring.
    limits : What `dualcam check` allows; None where the file does not say.
    study : Table [study] as it stands in the file.
    title, description : Words for reports.
    warnings : What could be meant otherwise; nothing of that is refused.
    notes : How the files of groove tables were understood.
    lines : Lines of the keys in the file.
    """

    path: Path
    parameters: dict[str, Scalar]
    model: str = "forward"
    scenario: Scenario | None = None
    output_interval: float | None = None
    pin: Pin | None = None
    roller: Roller | None = None
    helical_spring: HelicalSpring | None = None
    spring_limits: SpringLimits | None = None
    limits: Limits | None = None
    study: dict[str, Any] | None = None
    title: str = ""
    description: str = ""
    warnings: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = ()
    lines: Mapping[tuple[str, ...], int] = field(default_factory=dict, repr=False)

    @property
    def name(self) -> str:
        """Stem of the file's name."""
        return self.path.stem

    def value(self, name: str) -> Any:  # noqa: ANN401
        """A parameter's value: that of the file, or else the FMU's default.

        Parameters
        ----------
        name : Name of the FMU's parameter.

        Returns
        -------
        float, int, bool or str
            In the FMU's unit.

        Raises
        ------
        DesignError
            No FMU has a parameter of that name.
        """
        known = all_parameters()
        if name not in known:
            near = get_close_matches(name, known, n=3)
            guess = f"did you mean {' or '.join(near)}?" if near else f"allowed are {', '.join(known)}"
            raise DesignError(f"{name} is no parameter: {guess}")
        return self.parameters.get(name, known[name].start)

    def parameters_for(self, model: str | None = None) -> dict[str, Scalar]:
        """The parameters that one model has.

        Parameters
        ----------
        model : "forward" or "inverse"; that of the design if not given.

        Returns
        -------
        dict
            Names and values: `initial.theta` for the forward model, `shaft.stiffness` for the inverse.
        """
        known = parameters_of(model or self.model)
        return {name: value for name, value in self.parameters.items() if name in known}

    def mechanism(self) -> Mechanism:
        """The grooves, friction, spring and range of the design.

        Returns
        -------
        Mechanism
            With the FMU's defaults where the file gives no value. Its coefficients of friction are the static
            ones, of rest and slow motion.

        Raises
        ------
        DesignError
            A mechanism that cannot be, such as an upper stop below the lower one.
        """
        from dualcam.design import Mechanism, Spring

        (first, first_law), (second, second_law) = (self._friction_at_rest(number) for number in (1, 2))
        with units_checked_before():  # the findings of the file have these warnings, with their lines
            return Mechanism(
                (self._named_groove(1), self._named_groove(2)),
                (first, second),
                Spring(*(self.value(f"spring.{name}") for name in SPRING_TERMS)),
                self.value("stop.upper"),
                self.value("contacts"),
                self.value("stop.lower"),
                (first_law, second_law),
            )

    def friction_note(self) -> str:
        """What the torques of slow motion leave out where friction depends on the speed; else empty.

        Returns
        -------
        str
            A sentence, or an empty text where friction does not depend on the speed.
        """
        tables = [name for name in ("cam1.friction_table", "cam2.friction_table") if self.value(name)]
        if tables:
            return (
                "Friction depends on the sliding speed: the torques of slow motion take the static"
                f" coefficients, of {' and '.join(tables)} the value at the speed 0."
            )
        peaks = [f"cam{i}.friction_peak = {self.value(f'cam{i}.friction_peak'):g}" for i in (1, 2)]
        viscous = [self.value(f"cam{i}.friction_viscous") for i in (1, 2)]
        if all(self.value(f"cam{i}.friction_peak") == 1.0 for i in (1, 2)) and not any(viscous):
            return ""
        return (
            "Friction depends on the sliding speed: the torques of slow motion take the static coefficients,"
            f" friction times {' and '.join(peaks)}."
        )

    def _friction_at_rest(self, number: int) -> tuple[float, LoadLaw | None]:
        """mu at rest and in slow motion, without the factor of the load law, and this law."""
        from dualcam.design.load_law import LoadPower, LoadSamples
        from dualcam.design_file.friction_tables import read_friction_table

        if table := self.value(f"cam{number}.friction_table"):
            loads, coefficients = read_friction_table(Path(table)).static_samples
            law = LoadSamples(loads, coefficients) if len(loads) > 1 else None
            return coefficients[len(coefficients) // 2], law
        exponent = self.value(f"cam{number}.friction_load_exponent")
        return (
            self.value(f"cam{number}.friction") * self.value(f"cam{number}.friction_peak"),
            LoadPower(exponent, self.value(f"cam{number}.friction_load")) if exponent else None,
        )

    def _named_groove(self, number: int) -> Groove:
        try:
            return self._groove(number)
        except DesignError as error:
            raise DesignError(f"cam{number}: {error}") from None

    def _groove(self, number: int) -> Groove:
        from dualcam.design.grooves import groove_of

        return groove_of(
            {name: self.value(f"cam{number}.{name}") for name in ("profile", "radius", *PARAMETERS)}
        )


SPRING_TERMS = ("preload", "stiffness", "stiffness2", "stiffness3")


def sample_times(stop: float, interval: float | None) -> Array:
    """Times [s] of the samples: multiples of the output interval, and the end. DesignError for an interval
    that is not above 0, or gives too many samples."""
    interval = stop / DEFAULT_SAMPLES if interval is None else interval
    if not (math.isfinite(interval) and interval > 0.0):
        raise DesignError(f"scenario.output_interval = {interval} s: allowed is a finite number above 0")
    if stop / interval > MOST_SAMPLES:
        raise DesignError(
            f"scenario.output_interval = {interval:g} s gives {stop / interval:.3g} samples: allowed are up"
            f" to {MOST_SAMPLES:,}, from {stop / MOST_SAMPLES:.3g} s on"
        )
    count = math.ceil(stop / interval * (1.0 - 1e-12))
    return np.minimum(np.arange(count + 1) * interval, stop)
