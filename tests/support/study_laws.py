"""Controllers of studies that take their time, fail or kill their process. Workers import this module, which
therefore imports nothing that takes long."""

import os
import signal
import time


def slow():
    """Each call takes 20 ms, and no processor."""

    def law(now, seen):
        time.sleep(0.02)
        return [8.0]

    return law


def brief():
    """Each call takes 5 ms, and no processor."""

    def law(now, seen):
        time.sleep(0.005)
        return [8.0]

    return law


def deadly():
    """A run that begins near 0.4 rad kills its process."""

    def law(now, seen):
        if now == 0.0 and 0.35 < seen[0] < 0.45:
            os.kill(os.getpid(), signal.SIGKILL)
        return [0.0]

    return law


def murderous():
    """Every run kills its process."""

    def law(now, seen):
        os.kill(os.getpid(), signal.SIGKILL)

    return law
