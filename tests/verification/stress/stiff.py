"""The judge of stiff motion: scipy's Radau method on the pointwise equations of the reference."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import Radau

from benchmarks.harness.oracles import Interval, reference
from verification.stress.scene import Params


def radau(params: Params, intervals: Sequence[Interval]) -> list[dict[str, float]]:
    """One smooth motion upwards on the flanks on which it starts. Refused if it leaves them, or where a run
    at a coarser tolerance differs."""
    runs = [integrated(params, intervals, rtol) for rtol in (1e-8, 3e-10)]
    sizes = {name: max(abs(point[name]) for point in runs[1]) for name in runs[1][0]}
    for coarse, fine in zip(*runs, strict=True):
        for name, size in sizes.items():
            if abs(coarse[name] - fine[name]) > 3e-9 * (size or 1.0):
                raise reference.Refused(
                    f"Radau itself is uncertain by {abs(coarse[name] - fine[name]) / size:.1e}"
                )
    return runs[1]


def integrated(params: Params, intervals: Sequence[Interval], rtol: float) -> list[dict[str, float]]:
    mechanism, found = reference.Mechanism(params, reference.DOUBLE), []
    groove, slip = mechanism.groove, reference.Slip(+1, (1, 1))
    y = np.array([mechanism.theta0, mechanism.omega0])

    def load_at(t: float, y: np.ndarray, interval: Interval) -> Any:
        theta = float(y[0])
        kin = groove.at(theta, groove.ahead(theta, +1)[0])
        tau, f_ext = (interval.at(name, t)[0] for name in ("tau", "F_ext"))
        return mechanism.load(kin, slip, float(y[1]), tau, f_ext)

    def rates(t: float, y: np.ndarray, interval: Interval) -> list[float]:
        return [float(y[1]), float(load_at(t, y, interval).alpha)]

    for interval in intervals:
        scale = rtol * np.array([1e-2, 0.1 / interval.duration])
        solver = Radau(partial(rates, interval=interval), 0.0, y, interval.duration, rtol=rtol, atol=scale)
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise reference.Refused(f"Radau: {message}")
            load = load_at(float(solver.t), solver.y, interval)
            if min(load.x1, load.x2, solver.y[1]) < 0 or solver.y[0] >= mechanism.upper:
                raise reference.Refused("not one smooth stretch")
        y = np.array(solver.y)
        kin = groove.at(float(y[0]))
        point = {"theta": float(y[0]), "omega": float(y[1])}
        point["energy.spring"] = mechanism.spring_energy(kin.z)
        point["energy.kinetic"] = mechanism.kinetic_energy(kin, float(y[1]))
        found.append(point)
    return found
