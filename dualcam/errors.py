"""The errors and warnings of this package. Every error is a DualcamError, which is a ValueError."""

from __future__ import annotations


class DualcamError(ValueError):
    """This package refuses a request. The message names the value and what is allowed."""


class FmuError(DualcamError):
    """The FMU, or its handle, refuses a call."""


class UnknownVariableError(FmuError):
    """The FMU has no variable of that name."""


class DesignError(DualcamError):
    """A design that cannot be: the message names the place, the value and what is allowed."""


class ExportError(DualcamError):
    """No FMU can be made from a design: the message names the file or value, and what is allowed."""


class UnitWarning(UserWarning):
    """A value that is allowed, but looks as if it were given in another unit. The message names that unit."""
