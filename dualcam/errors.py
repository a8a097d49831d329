"""The errors and warnings of this package. Every error is a DualcamError, which is a ValueError."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray


class DualcamError(ValueError):
    """This package refuses a request. The message names the value and what is allowed."""


class FmuError(DualcamError):
    """The FMU, or its handle, refuses a call."""


class FileError(DualcamError, OSError):
    """A file cannot be written. The message names the file, the system's reason and what would work.

    Attributes
    ----------
    errno, strerror, filename
        As those of an OSError.
    """

    def __init__(self, error: OSError, path: Path) -> None:
        OSError.__init__(self, error.errno, error.strerror or str(error), str(path))

    def __str__(self) -> str:
        return f"{self.filename} cannot be written: {self.strerror}. {self._remedy()}"

    def _remedy(self) -> str:
        if self.errno in (errno.ENOENT, errno.ENOTDIR):
            return "Make its folder first, or give another folder"
        if self.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            return "Make room, or give another folder"
        return "Give another folder, or check the rights of this one"


class FleetError(FmuError):
    """Some instances of a fleet failed. The others did what was asked.

    Attributes
    ----------
    instances : tuple of int
        The instances that failed in this call.
    reasons : dict of int to str
        Why, of the first 16 of them at most.
    outputs : ndarray or None
        What `Fleet.step` or `Fleet.rollout` would have returned: NaN where an instance has failed.
    """

    def __init__(
        self, message: str, instances: tuple[int, ...] = (), reasons: dict[int, str] | None = None
    ) -> None:
        super().__init__(message)
        self.instances, self.reasons = instances, reasons or {}
        self.outputs: NDArray[np.float64] | None = None


class UnknownVariableError(FmuError):
    """The FMU has no variable of that name."""


class OperatingPointError(FmuError):
    """There is no linear model at this point; the message says where there is one."""


class StudyError(FmuError):
    """This study cannot be made, or not be continued; the message says what to do.

    Attributes
    ----------
    problems : tuple of str
        All that is wrong, one text each; a single one for most errors.
    """

    def __init__(self, message: str, problems: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.problems = tuple(problems) or (message,)

    def __reduce__(self) -> tuple[type[StudyError], tuple[str, tuple[str, ...]]]:
        return type(self), (str(self), self.problems)


class DesignError(DualcamError):
    """A design that cannot be: the message names the place, the value and what is allowed."""


class DesignFileError(DesignError):
    """A design file is refused. The text lists all errors, line by line; `advice` is its last line.

    Attributes
    ----------
    findings : tuple of Finding
        One for each error, in the order of the lines.
    """

    def __init__(self, path: object, findings: Sequence[Any], advice: str = "") -> None:
        self.path = path
        self.findings = tuple(sorted(findings, key=lambda finding: finding.line or 0))
        count = len(self.findings)
        head = f"{path}: {count} error{'s' if count > 1 else ''}"
        lines = [*map(str, self.findings), *filter(None, [advice])]
        super().__init__("\n".join([head, *(f"  {line}" for line in lines)]))


class ExportError(DualcamError):
    """No FMU can be made from a design: the message names the file or value, and what is allowed."""


class TableError(DualcamError):
    """A table cannot be understood; the message names line, column and what is allowed."""


class CouplingError(DualcamError):
    """An own plant cannot be coupled with the FMU as asked."""


class TaskError(DualcamError):
    """A task of `dualcam.gym` cannot be made or stepped as asked. The message says what is allowed."""


class MujocoError(DualcamError):
    """A cam cannot sit on a joint of a MuJoCo model, or be stepped, as asked. The message says what works."""


class IdentificationError(DualcamError):
    """A recording, or the wish what to fit to the recording, is refused. The message says what is allowed."""


class DualcamWarning(UserWarning):
    """A request is carried out, but the result may not be what was meant."""


class UnstableCouplingWarning(DualcamWarning):
    """Errors of a coupling grow from step to step. The message names the numbers and what works."""


class LimitCycleWarning(DualcamWarning):
    """The FMU in the loop moves otherwise than a describing function predicts. The message has numbers."""


class UnitWarning(DualcamWarning):
    """A value that is allowed, but looks as if it were given in another unit. The message names that unit."""
