"""Makes the reference results that the FMUs carry under extra/reference, with the independent reference
simulator (reference/), not with the FMUs:

    python tests/support/reference_results.py       writes modelDescription/reference/*.csv

Both are of the default mechanism, so a master has nothing to set but the inputs. A test compares the files
with what this prints, and the FMUs with the files.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from reference import DOUBLE, Interval, Mechanism, Slip, simulate_exact

FOLDER = Path(__file__).resolve().parents[2] / "modelDescription/reference"
PERIOD = 0.01

Rows = list[list[float]]

# time, tau, F_ext, and straight lines between: load, hold, let go, hold
FORWARD_KNOTS = [(0.0, 0.0, 0.0), (0.4, 8.0, 0.0), (0.5, 8.0, 50.0), (0.9, 0.0, 50.0), (1.0, 0.0, 50.0)]
FORWARD_IN = ["tau", "F_ext"]
FORWARD_OUT = ["theta", "omega", "z", "v", "mode", "energy.spring", "energy.heat_cam1", "energy.heat_cam2"]
INVERSE_IN = ["theta", "omega", "alpha", "F_ext"]
INVERSE_OUT = ["tau", "z", "v", "cam1.reaction", "cam2.reaction"]


def forward() -> tuple[Rows, Rows]:
    """The motion, in closed form at 60 digits."""
    intervals, times = [], [0.0]
    for (t0, *u0), (t1, *u1) in pairwise(FORWARD_KNOTS):
        count = round((t1 - t0) / PERIOD)
        rates = [(b - a) / (t1 - t0) for a, b in zip(u0, u1, strict=True)]
        for k in range(count):
            tau, f_ext = (a + rate * k * PERIOD for a, rate in zip(u0, rates, strict=True))
            intervals.append(Interval(PERIOD, tau, rates[0], f_ext, rates[1]))
            times.append(round(times[-1] + PERIOD, 9))
    start = [0.0, 0.0, 0.0, 0.0, 4, 0.0, 0.0, 0.0]  # at rest on the lower stop
    points = [[point.value(name) for name in FORWARD_OUT] for point in simulate_exact({}, intervals)]
    return (
        [list(knot) for knot in FORWARD_KNOTS],
        [[t, *row] for t, row in zip(times, [start, *points], strict=True)],
    )


def inverse() -> tuple[Rows, Rows]:
    """The torque of a swing up and back, from the balance at each instant."""
    mechanism = Mechanism({}, DOUBLE)
    given, wanted = [], []
    for k in range(round(1 / PERIOD) + 1):
        t, angle = round(k * PERIOD, 9), 2 * math.pi * k * PERIOD
        turning = 2 * k * PERIOD % 1 != 0  # exactly at rest at both ends of the swing
        theta, omega = 0.6 * (1 - math.cos(angle)), 1.2 * math.pi * math.sin(angle) * turning
        alpha, f_ext = 2.4 * math.pi**2 * math.cos(angle), 50.0 * t
        slip = Slip(1 if t <= 0.5 else -1, (1, 1))
        kin = mechanism.groove.at(theta)
        balance = mechanism.balance(kin, slip)
        force = mechanism.spring_force(kin.z) + f_ext
        x1, x2 = (mechanism.r2 * balance.n2 * force, mechanism.r1 * balance.n1 * force)
        x1, x2 = x1 / balance.delta, x2 / balance.delta
        tau = mechanism.r2 * balance.n2 * x2 + mechanism.J * alpha
        given.append([t, theta, omega, alpha, f_ext])
        wanted.append([t, tau, kin.z, kin.dz * omega, *mechanism.reactions(kin, x1, x2)])
    return given, wanted


def table(names: Sequence[str], rows: Rows) -> str:
    lines = [",".join(["time", *names])]
    lines += [",".join(f"{value + 0.0:.15g}" for value in row) for row in rows]
    return "\n".join(lines) + "\n"


def results() -> dict[str, str]:
    """File name -> content."""
    (forward_in, forward_ref), (inverse_in, inverse_ref) = forward(), inverse()
    return {
        "DualCamForward_in.csv": table(FORWARD_IN, forward_in),
        "DualCamForward_ref.csv": table(FORWARD_OUT, forward_ref),
        "DualCamInverse_in.csv": table(INVERSE_IN, inverse_in),
        "DualCamInverse_ref.csv": table(INVERSE_OUT, inverse_ref),
    }


if __name__ == "__main__":
    for name, text in results().items():
        (FOLDER / name).write_text(text)
        print(FOLDER / name)
