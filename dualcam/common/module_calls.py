"""Modules that have the name of a command: calling such a module says which function to call."""

import sys
from types import ModuleType
from typing import NoReturn

from dualcam.errors import DualcamError

CALLS = {
    "dualcam.design": "dualcam.design.design_groove(...), or dualcam.read_design(path) for a design file",
    "dualcam.export": "dualcam.export_fmu(design, path)",
    "dualcam.report": "dualcam.write_report(design, path)",
    "dualcam.ssp": "dualcam.export_ssp(design, path)",
    "dualcam.study": "dualcam.study.read_study(path)",
    "dualcam.view": "dualcam.write_view(design, path)",
}


class CommandModule(ModuleType):
    """A module that refuses to be called, and says what to call."""

    def __call__(self, *_: object, **__: object) -> NoReturn:
        """Always a DualcamError."""
        raise DualcamError(f"{self.__name__} is a module: call {CALLS[self.__name__]}")


def explain_call_of(module: str) -> None:
    """Let a call of the imported module say what to call."""
    sys.modules[module].__class__ = CommandModule
