"""The result of an identification, with all that is made of it: doubts, picture, page, design file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dualcam.identification.doubts import doubts_of, recording_faults
from dualcam.identification.result import Fit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Identification(Fit):
    """The result of `identify`. Indexing by a name gives the fitted parameter.

    Attributes
    ----------
    design : The design of the start values.
    recording : All samples.
    motion : Motion at the samples that count.
    time, measured : Time [s] and measured torque [N.m] of these samples, shape (n,).
    low, high : Limits of the fitted model's torque [N.m], shape (n,); both are alike where the cam slips.
    before
        Torque of the model with the start values that is nearest to the measured torque [N.m], shape (n,).
    residual : Fitted minus measured torque [N.m], shape (n,); 0 where a torque at rest is allowed.
    sliding_speed : Sliding speed of the faster contact [m/s], shape (n,).
    noise : Standard deviation of the noise of the measured torque [N.m], from neighbouring samples.
    parameters : In the order of `fit`.
    correlation : Correlation of the fitted values, shape (p, p).
    ambiguities : What the data cannot tell apart.
    missing : Values outside of the fit that the residuals ask for, the best one first; see `lack_of_fit`.
    levers : Fitted values that a small error of a held value would change strongly.
    """

    def warnings(self) -> list[str]:
        """What the data cannot tell apart, and other doubts."""
        return doubts_of(self)

    def recording_faults(self) -> list[str]:
        """What makes the recording useless as read: another unit of time, or a torque of opposite sign."""
        return recording_faults(self)

    def as_dict(self) -> dict[str, Any]:
        """The result as plain data, for JSON."""
        return {
            "samples": len(self.recording),
            "loading": self.motion.count(1),
            "releasing": self.motion.count(-1),
            "at_rest": self.motion.count(0),
            "motion": self.motion.kind,
            "residual_rms": self.rms,
            "residual_rms_before": self.rms_before,
            "noise": self.noise,
            "parameters": {
                one.name: {
                    "start": one.start,
                    "value": one.value,
                    "interval": [one.low, one.high],
                    "unit": one.unit,
                    "status": one.status,
                }
                for one in self.parameters
            },
            "correlation": self.correlation,
            "not_told_apart": [list(one.names) for one in self.ambiguities],
            "residuals_ask_for": [one.name for one in self.missing],
            "samples_that_count": len(self.time),
            "warnings": self.warnings(),
        }

    def plot(self) -> Figure:
        """Measured and fitted torque over the angle, and residuals over angle, sliding speed and time."""
        from dualcam.identification.picture import plot_identification

        return plot_identification(self)

    def write_report(self, path: str | Path) -> Path:
        """Write one HTML page with the result to `path` (.html), and return that path."""
        from dualcam.identification.page import write_page

        return write_page(self, path)

    def write_design(self, path: str | Path) -> Path:
        """Write the design file with the fitted values to `path`, and return that path. Comments and all
        other lines stay.

        IdentificationError: the path is that of the design itself, the recording has another unit of time or
        the opposite sign of the torque, `dualcam check` would refuse the fitted values, or the lines of the
        design file cannot be changed one by one. DesignFileError: the new file would be refused, for example
        because a groove table is not in its folder.
        """
        from dualcam.identification.fitted_design import write_fitted

        return write_fitted(self, path)
