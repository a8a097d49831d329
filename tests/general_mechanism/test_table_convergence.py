"""A table of an ellipse converges to the ellipse."""

import math
from itertools import pairwise

import numpy as np
import pytest
from pin_equations import Pin, ellipse, helix, sampled
from random_mechanisms import run_on
from reference import LOADING


@pytest.mark.parametrize("kappa", [-1, 1])
@pytest.mark.parametrize("other", ["helix", "ellipse"])
def test_a_table_of_an_ellipse_moves_like_it(make, tmp_path, kappa, other):
    """Sampled twice as finely, a table comes closer to its ellipse by 2^4.5 or more, in angle, speed and
    work, on a swing without any switch. The slope between the points is of the fourth order, but wrong by
    nothing on the average from point to point, and the work takes the average; starting with some speed, and
    without follower, whose kinetic energy would take the slope at one place."""
    groove = ellipse(0.02, 0.5, 0.06, 0.05, kappa)
    second = helix(0.03, 0.6) if other == "helix" else ellipse(0.03, 0.6, 0.1, 0.09, 1)
    rest = {"stop.upper": 1.0, "spring.stiffness": 2e4, "spring.stiffness2": 1e5, "initial.omega": 8.0}
    rest |= {"damper.c_load": 60.0, "damper.q_load": 200.0}
    names = ("theta", "omega", "energy.work_in")

    def swing(first):
        fmu = make().start(Pin(first, second).values | rest, tolerance=1e-12)
        read = []
        for part in range(1, 6):
            run_on(fmu, {"tau": [4.0, 60.0]}, (part - 1) * 0.004, part * 0.004, 1)
            assert fmu.get("mode") == LOADING
            read.append([fmu.get(name) for name in names])
        assert 0.5 < fmu.get("theta") < 0.55
        return np.array(read)

    true, errors = swing(groove), []
    for count in (8, 16, 32, 64):
        table = sampled(groove, tmp_path / f"{count}.csv", np.linspace(0.0, 0.9, count + 1))
        errors.append(np.max(np.abs(swing(table) - true), axis=0) / np.max(np.abs(true), axis=0))
    assert np.min(np.log2(errors[0] / errors[-1]) / 3) >= 4.5, errors
    assert min(math.log2(a[0] / b[0]) for a, b in pairwise(errors)) >= 4.5, errors
    assert np.max(errors[-1]) < 1e-9
