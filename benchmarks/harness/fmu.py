"""Instances of the FMUs through FMPy, with their variables by name."""

from __future__ import annotations

import atexit
import functools
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

from benchmarks.harness import core
from benchmarks.harness.slave import SlaveStruct, slave_struct

TOLERANCE = 1e-9  # of the timed steps
STICK, LOADING, RELEASING, LOWER, UPPER, WEDGED = range(1, 7)  # values of the output `mode`

Parameters = Mapping[str, float | str]


@functools.cache
def unpacked(path: Path) -> str:
    """The folder of an unpacked FMU. All instances of a process run from the same file. Each process has a
    folder of its own, since unpacking over a library in use crashes the process that runs it."""
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return str(extract(str(path), unzipdir=folder))


class Slave:
    """An instance of an FMU of the build folder."""

    def __init__(self, identifier: str = core.FORWARD) -> None:
        folder = unpacked(core.fmu_path(identifier))
        self.description = read_model_description(folder)
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.types = {v.name: v.type for v in self.description.modelVariables}
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=folder,
            modelIdentifier=identifier,
            instanceName=identifier,
        )
        self.fmu.instantiate()

    def set(self, values: Parameters) -> None:
        for name, value in values.items():
            if self.types[name] == "Real":
                self.fmu.setReal([self.references[name]], [value])
            elif self.types[name] == "String":
                self.fmu.setString([self.references[name]], [str(value)])
            elif self.types[name] == "Integer":
                self.fmu.setInteger([self.references[name]], [int(value)])
            else:
                self.fmu.setBoolean([self.references[name]], [bool(value)])

    def real(self, name: str) -> float:
        return float(self.fmu.getReal([self.references[name]])[0])

    def integer(self, name: str) -> int:
        return int(self.fmu.getInteger([self.references[name]])[0])

    def struct(self) -> SlaveStruct:
        """For the loops in C."""
        return slave_struct(self.fmu.dll, self.fmu.component, self.references)

    def enter_initialization(self, tolerance: float = TOLERANCE) -> None:
        """Ends the setting of parameters. Outputs can be read and inputs be set."""
        self.fmu.setupExperiment(tolerance=tolerance, startTime=0.0)
        self.fmu.enterInitializationMode()

    def initialise(self, tolerance: float = TOLERANCE) -> None:
        """Leads to the first step."""
        self.enter_initialization(tolerance)
        self.fmu.exitInitializationMode()
