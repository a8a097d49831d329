"""A loaded FMU with its instances in C: opened, closed once, and the reasons of failures."""

import ctypes
import threading
import weakref
from ctypes import POINTER, byref
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array
from dualcam.common.process_bound import ProcessBound
from dualcam.errors import FleetError, FmuError
from dualcam.fleet.native import (
    ALL_FAILED,
    FATAL,
    NOT_FINITE,
    Experiment,
    Report,
    address,
    functions_of,
    native,
)
from dualcam.fmi.binary import Unpacked, interface_of, library_file, load, unload
from dualcam.fmi.model_description import ModelDescription

CLOSED = "this fleet is closed: open a new one"
BUSY = "this fleet is at work in another thread: one call at a time"
CUT_OFF = "this fleet was at work in another thread when this process was forked: open a new one"
NONE_LEFT = "all instances have failed: bring them back by reset or restore"
LOST = "the FMU returned fmi2Fatal: FMI allows no further call of this FMU in this process"
REASONS_TOLD = 3  # in a message


class NotFiniteError(Exception):
    """An input is not finite, and no instance was stepped."""


class Core:
    """The instances, not yet started. It has no reference to the Fleet: a dropped Fleet can close it."""

    def __init__(
        self,
        path: Path,
        description: ModelDescription,
        count: int,
        threads: int,
        time: float,
        tolerance: float,
    ) -> None:
        self.count = count
        self._handle: int | None = None
        self._states: dict[int, NDArray[np.uintp]] = {}
        self._lock = threading.Lock()
        self._native = native()
        interface = interface_of(path, description, "co-simulation")
        self._unpacked = Unpacked(path, description.fmi_major)
        self._library: ctypes.CDLL | None = None
        try:
            folder = self._unpacked.folder
            file = library_file(path, folder, interface, description.fmi_major)
            self._library = load(ctypes.CDLL, path, file)
            self._experiment = Experiment(
                description.model_name.encode(),
                description.guid.encode(),
                (folder / "resources").as_uri().encode(),
                time,
                tolerance,
            )
            functions = functions_of(self._library, interface.can_save_state)
            self._handle = self._native.fleet_open(byref(functions), byref(self._experiment), count, threads)
            if self._handle is None:
                raise FmuError(f"no memory for {count} instances, or no {threads} threads: use fewer")
            self.check(self._native.fleet_instantiate(self._handle))
        except BaseException:
            self.close()
            raise

    @property
    def is_open(self) -> bool:
        return self._handle is not None

    def close(self) -> None:
        """Free all instances and files, once, after other threads' calls. A forked child forgets its copy."""
        if not self._unpacked.is_own:
            self._handle = None
            return
        with self._lock:
            if self._handle is not None:
                for key in list(self._states):
                    self.forget_states(key)
                self._native.fleet_close(self._handle)
                self._handle = None
        if self._library is not None:
            unload(self._library._handle)
            self._library = None
        self._unpacked.delete()

    def call(self, name: str, *arguments: object) -> None:
        """A function of fleet.h. FleetError where instances fail, FmuError where the fleet is closed."""
        if self._handle is None:
            raise FmuError(CLOSED)
        if not self._lock.acquire(False):
            raise FmuError(BUSY if self._unpacked.is_own else CUT_OFF)
        try:
            failures = getattr(self._native, name)(self._handle, *arguments)
            if failures:
                self.check(failures)
        finally:
            self._lock.release()

    def failed(self) -> NDArray[np.bool_]:
        """Which instances have failed, shape (count,)."""
        return self._told("fleet_failed", np.uint8).astype(bool)

    def times(self) -> NDArray[np.float64]:
        """Present time of each instance [s], shape (count,)."""
        return self._told("fleet_times", np.float64)

    def _told(self, name: str, kind: type[np.generic]) -> NDArray[Any]:
        if self._handle is None:
            raise FmuError(CLOSED)
        values = np.zeros(self.count, kind)
        getattr(self._native, name)(self._handle, address(values))
        return values

    def check(self, failures: int) -> None:
        """FleetError that names the instances which failed in the last call."""
        if failures == FATAL:
            raise FmuError(LOST)
        if failures == NOT_FINITE:
            raise NotFiniteError
        if failures == ALL_FAILED:
            raise FleetError(NONE_LEFT, tuple(range(self.count)))
        if failures == 0:
            return
        reports = POINTER(Report)()
        listed = self._native.fleet_reports(self._handle, byref(reports))
        texts = {reports[k].instance: reports[k].text.decode(errors="replace") for k in range(listed)}
        reasons = {instance: text.replace("##", "#") for instance, text in sorted(texts.items())}
        told = "; ".join(f"instance {i}: {reason}" for i, reason in list(reasons.items())[:REASONS_TOLD])
        more = f"; and {failures - REASONS_TOLD} more" if failures > REASONS_TOLD else ""
        head = f"{failures} of {self.count} instances failed: " if failures > 1 else ""
        instances = reasons if failures <= len(reasons) else np.flatnonzero(self.failed()).tolist()
        raise FleetError(f"{head}{told}{more}", tuple(instances), reasons)

    def keep_states(self, states: NDArray[np.uintp]) -> int:
        """A key for states that `close` is to free."""
        self._states[id(states)] = states
        return id(states)

    def forget_states(self, key: int) -> None:
        """Free saved states, once."""
        states = self._states.pop(key, None)
        if states is not None and self._handle is not None:
            self._native.fleet_free_states(self._handle, address(states))


class FleetState(ProcessBound):
    """States of some instances of a fleet, from `Fleet.save`. Freed with the last reference to this.

    Attributes
    ----------
    instances : Booleans of shape (count,): the instances whose states these are.
    """

    _instead = "restore it into its own fleet"

    def __init__(
        self, core: Core, instances: NDArray[np.bool_], addresses: NDArray[np.uintp], times: Array
    ) -> None:
        self.instances, self._core = instances, core
        self._addresses, self._times = addresses, times
        weakref.finalize(self, core.forget_states, core.keep_states(addresses))

    def __repr__(self) -> str:
        return f"<FleetState of {int(self.instances.sum())} instances>"
