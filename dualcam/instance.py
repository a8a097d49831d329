"""The binary of an FMI 2.0 FMU with one instance in it."""

from __future__ import annotations

import shutil
import tempfile
from collections import deque
from ctypes import byref, c_void_p
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.model_description import ModelDescription

from dualcam.errors import FmuError

OK_OR_WARNING = 1  # fmi2Status up to this is success
MESSAGES_KEPT = 8  # an FMU may log warnings without end


class Instance:
    """A loaded binary with one instance in it, freed once. The instance has no reference to its handle, so
    that a dropped handle can free it."""

    def __init__(self, path: Path, description: ModelDescription, kind: type[FMU2Slave | FMU2Model]) -> None:
        self.messages: deque[str] = deque(maxlen=MESSAGES_KEPT)  # logged since the last error
        self.states: set[int] = set()  # addresses of FMU states not yet freed
        identifier = (
            description.coSimulation if kind is FMU2Slave else description.modelExchange
        ).modelIdentifier
        wanted = (f"binaries/{fmpy.platform}/", "resources/")
        self._directory = _extracted(path, wanted)
        try:
            (Path(self._directory) / "resources").mkdir(exist_ok=True)
            self._fmu = kind(
                instanceName=description.modelName,
                guid=description.guid,
                modelIdentifier=identifier,
                unzipDirectory=self._directory,
            )
            # not FMPy's proxy for printf arguments: it has one logger for the whole process
            callbacks = fmi2CallbackFunctions()
            callbacks.logger = self._logger()
            self._fmu.instantiate(callbacks=callbacks)
        except Exception as error:
            shutil.rmtree(self._directory, ignore_errors=True)
            raise FmuError("; ".join([f"{path}: {error}", *self.messages])) from error
        self.component = self._fmu.component
        library = self._fmu.dll
        self.get_real, self.set_real = library.fmi2GetReal, library.fmi2SetReal
        self.do_step = library.fmi2DoStep
        self.is_open = True

    def _logger(self) -> fmi2CallbackLoggerTYPE:
        messages = self.messages

        def log(_: object, name: bytes, status: int, category: bytes, text: bytes) -> None:
            # FMI doubles the characters % and #, which its printf format would interpret
            messages.append(text.decode(errors="replace").replace("%%", "%").replace("##", "#"))

        return fmi2CallbackLoggerTYPE(log)

    def call(self, name: str, *arguments: object) -> None:
        """Call the FMI function `name`; FmuError with the FMU's message if the call fails."""
        if not self.is_open:
            _refuse_closed()
        self.check(getattr(self._fmu.dll, name)(self.component, *arguments), name)

    def check(self, status: int, name: str) -> None:
        """FmuError with the messages of the FMU if `status` of function `name` is no success."""
        if status > OK_OR_WARNING:
            text = "; ".join(self.messages) or f"{name} returned status {status}, without a message"
            self.messages.clear()
            raise FmuError(text)

    def free_state(self, address: int) -> None:
        """Free a saved state, once."""
        if address in self.states:
            self.states.remove(address)
            self.call("fmi2FreeFMUstate", byref(c_void_p(address)))

    def free(self) -> None:
        """Free the instance and the unpacked files, once."""
        if not self.is_open:
            return
        for address in list(self.states):
            self.free_state(address)
        self.is_open = False
        self.get_real = self.set_real = self.do_step = _refuse_closed
        self._fmu.freeInstance()
        shutil.rmtree(self._directory, ignore_errors=True)

    def abandon(self) -> None:
        """After fmi2Fatal no function may be called, not even to free the instance: its memory is lost."""
        self.states.clear()
        self.is_open = False
        self.get_real = self.set_real = self.do_step = _refuse_closed
        shutil.rmtree(self._directory, ignore_errors=True)


def _extracted(path: Path, wanted: tuple[str, ...]) -> str:
    """A new folder with these parts of the FMU. FmuError if they are damaged or there is no room."""
    folder = tempfile.mkdtemp()
    try:
        fmpy.extract(path, folder, include=lambda name: name.startswith(wanted))
    except Exception as error:  # zipfile's, zlib's and the system's
        shutil.rmtree(folder, ignore_errors=True)
        raise FmuError(f"{path} cannot be unpacked into {folder}: {error}") from error
    return folder


def _refuse_closed(*_: object) -> int:
    raise FmuError("this FMU is closed: open a new one")
