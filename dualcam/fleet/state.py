"""Saved states of a fleet's instances."""

from __future__ import annotations

import weakref

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array
from dualcam.common.process_bound import ProcessBound
from dualcam.fleet.core import Core


class FleetState(ProcessBound):
    """States of some instances of a fleet, from `Fleet.save`. Freed with the last reference to this.

    Attributes
    ----------
    instances : ndarray of bool, shape (count,)
        The instances whose states these are.
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
