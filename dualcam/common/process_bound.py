"""What belongs to the process that made it: handles of memory outside Python, and locks."""

import os
import threading
from typing import ClassVar, NoReturn

from dualcam.errors import FmuError


class ProcessBound:
    """Has memory outside Python, which pickle and copy do not see."""

    _instead: ClassVar[str]  # what works

    def __reduce__(self) -> NoReturn:
        raise FmuError(f"{self!r} cannot be pickled or copied: {self._instead}")


class ProcessLock:
    """A lock that is free in a forked child, which does not have the thread that may have taken the lock."""

    def __init__(self) -> None:
        self._renew()

    def _renew(self) -> None:
        self._lock, self._process = threading.Lock(), os.getpid()

    def __enter__(self) -> None:
        if os.getpid() != self._process:
            self._renew()
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()
