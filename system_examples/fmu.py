"""Step one FMI 2.0 co-simulation FMU from Python, fast enough for a 1 kHz loop.

FMPy loads the binary and checks every status; what is added here are names instead of value references,
buffers that are laid out once, and a clock. Reading a group of reals costs one call into the FMU:

    with Slave("build/DualCamForward.fmu") as slave:
        command, state = slave.reals("tau"), slave.reals("theta", "omega")
        slave.start({"inertia.shaft": 0.2})
        command.values[0] = 1.5
        command.write()
        slave.step(1e-3)
        theta, omega = state.read()
"""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Mapping, Sequence
from os import PathLike

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.model_description import ScalarVariable

Scalar = float | int | bool | str


class Reals:
    """A fixed group of real variables with its own buffer `values`, in the order in which they were named."""

    def __init__(self, fmu: FMU2Slave, references: list[int]) -> None:
        self.values = np.zeros(len(references))
        self._fmu = fmu
        self._count = len(references)
        self._references = (ctypes.c_uint * self._count)(*references)
        self._pointer = self.values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

    def read(self) -> list[float]:
        """Fetch the group from the FMU into `values`; return it as plain floats, fastest for scalar code."""
        self._fmu.fmi2GetReal(self._fmu.component, self._references, self._count, self._pointer)
        return self.values.tolist()

    def write(self) -> None:
        """Send `values` to the FMU."""
        self._fmu.fmi2SetReal(self._fmu.component, self._references, self._count, self._pointer)

    def read_derivatives(self, order: int) -> list[float]:
        """Time derivatives of that order of the group, all of them outputs."""
        found = (ctypes.c_double * self._count)()
        self._fmu.fmi2GetRealOutputDerivatives(
            self._fmu.component, self._references, self._count, self._orders(order), found
        )
        return list(found)

    def write_derivatives(self, order: int, values: Sequence[float]) -> None:
        """Time derivatives of that order of the group, all of them inputs, for the next step only."""
        sent = (ctypes.c_double * self._count)(*values)
        self._fmu.fmi2SetRealInputDerivatives(
            self._fmu.component, self._references, self._count, self._orders(order), sent
        )

    def _orders(self, order: int) -> ctypes.Array[ctypes.c_int]:
        return (ctypes.c_int * self._count)(*[order] * self._count)


class Slave:
    """One instance of an FMU. `start` begins a run, any number of times; `step` advances `time` [s]."""

    def __init__(self, path: str | PathLike[str]) -> None:
        description = read_model_description(path)
        self._variables = {variable.name: variable for variable in description.modelVariables}
        self._directory = extract(path)
        try:
            self._fmu = FMU2Slave(
                instanceName=description.modelName,
                guid=description.guid,
                modelIdentifier=description.coSimulation.modelIdentifier,
                unzipDirectory=self._directory,
            )
            self._fmu.instantiate()
        except Exception:
            shutil.rmtree(self._directory, ignore_errors=True)
            raise
        self._fresh = True
        self.time = 0.0

    def __enter__(self) -> Slave:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the instance, unload the library, delete the unpacked files."""
        self._fmu.freeInstance()
        shutil.rmtree(self._directory, ignore_errors=True)

    def start(
        self, parameters: Mapping[str, Scalar], time: float = 0.0, tolerance: float | None = None
    ) -> None:
        """Begin a run at `time` [s] with these values; everything not named has its start value again."""
        if not self._fresh:
            self._fmu.reset()
        self._fresh = False
        for name, value in parameters.items():
            self.set(name, value)
        self._fmu.setupExperiment(tolerance=tolerance, startTime=time)
        self._fmu.enterInitializationMode()
        self._fmu.exitInitializationMode()
        self.time = time

    def step(self, size: float) -> None:
        """Advance by `size` [s] with the inputs as they were last written."""
        self._fmu.fmi2DoStep(self._fmu.component, self.time, size, True)
        self.time += size

    def reals(self, *names: str) -> Reals:
        """A group of real variables that is read or written often."""
        return Reals(self._fmu, [self._variable(name, "Real").valueReference for name in names])

    def get(self, name: str) -> Scalar:
        """One variable of any type, for use outside the loop."""
        variable = self._variable(name)
        reference = [variable.valueReference]
        if variable.type == "Real":
            return self._fmu.getReal(reference)[0]
        if variable.type == "Boolean":
            return bool(self._fmu.getBoolean(reference)[0])
        if variable.type == "String":
            return self._fmu.getString(reference)[0].decode()
        return self._fmu.getInteger(reference)[0]

    def set(self, name: str, value: Scalar) -> None:
        """One variable of any type, for use outside the loop."""
        variable = self._variable(name)
        reference = [variable.valueReference]
        if variable.type == "Real":
            self._fmu.setReal(reference, [float(value)])
        elif variable.type == "Boolean":
            self._fmu.setBoolean(reference, [bool(value)])
        elif variable.type == "String":
            self._fmu.setString(reference, [str(value)])
        else:
            self._fmu.setInteger(reference, [int(value)])

    def _variable(self, name: str, kind: str | None = None) -> ScalarVariable:
        variable = self._variables.get(name)
        if variable is None:
            raise KeyError(f"the FMU has no variable {name!r}")
        if kind is not None and variable.type != kind:
            raise TypeError(f"{name!r} is {variable.type}, not {kind}")
        return variable
