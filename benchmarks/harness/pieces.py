"""An FMU through pieces of constant torque, stepped in C."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np

from benchmarks.harness import core
from benchmarks.harness.fmu import TOLERANCE, Parameters, Slave
from benchmarks.harness.timing import pointer

Piece = tuple[float, float]  # duration [s] and torque [N.m]


class StepFailure(Exception):
    """A call of FMI has failed."""


class PiecesStruct(ctypes.Structure):
    """`Pieces` of pieces.c."""

    _fields_ = [
        ("duration", ctypes.c_void_p),
        ("tau", ctypes.c_void_p),
        ("count", ctypes.c_size_t),
        ("steps", ctypes.c_size_t),
        ("read", ctypes.c_void_p),
        ("reads", ctypes.c_size_t),
    ]


class PieceRun:
    """An initialised instance with its settings, and how to time a run through all pieces.

    Each piece takes `steps` steps of equal length; the variables `reads` are read at its end. The rows of
    `points` are the values read. The forward FMU starts every run from its saved state. Other FMUs have no
    saved state: they are reset and initialised anew before each run, which is not timed."""

    def __init__(
        self,
        identifier: str,
        settings: Parameters,
        pieces: Sequence[Piece],
        reads: Sequence[str],
        steps: int = 1,
        tolerance: float = TOLERANCE,
        repeats: int = 1,
    ) -> None:
        self.settings, self.tolerance, self.steps, self.repeats = settings, tolerance, steps, repeats
        self.slave = Slave(identifier)
        self.loops = core.load_loops("harness/pieces.c", "seconds_pieces")
        self.struct = self.slave.struct()
        self.references = (ctypes.c_uint * len(reads))(*(self.slave.references[name] for name in reads))
        self.durations, self.torques = np.array(pieces).T.copy()
        self.points = np.zeros((len(pieces), len(reads)))
        self.pieces = PiecesStruct(
            self.durations.ctypes.data,
            self.torques.ctypes.data,
            len(pieces),
            steps,
            ctypes.addressof(self.references),
            len(reads),
        )
        self.initialise()
        self.state = self.slave.fmu.getFMUState() if identifier == core.FORWARD else None

    def initialise(self) -> None:
        self.slave.set(self.settings)
        self.slave.initialise(self.tolerance)

    def seconds(self) -> float:
        """Seconds of one run, the mean of `repeats` runs. StepFailure if a call of FMI fails."""
        if self.state is None:
            self.slave.fmu.reset()
            self.initialise()
        status = ctypes.c_int()
        seconds = self.loops.seconds_pieces(
            ctypes.byref(self.struct),
            ctypes.byref(self.pieces),
            self.state,
            ctypes.c_size_t(self.repeats),
            pointer(self.points),
            ctypes.byref(status),
        )
        if status.value != 0:
            raise StepFailure(f"status {status.value}")
        return float(seconds)
