"""Polynomial inputs against finely cut constant inputs."""

import math
from itertools import pairwise

import numpy as np
import pytest
from pin_equations import band, friction, polynomial, spring_force
from random_mechanisms import random_mechanism, run_on, step


@pytest.mark.parametrize("order, equal", [(1, False), (2, False), (3, False), (1, True)])
def test_input_derivatives_are_what_finely_cut_inputs_tend_to(make, tmp_path, order, equal):
    """One long step with derivatives of tau and F_ext; and 64, 128, 256 steps with inputs that are constant
    over each, at the middle's value: their error, of the second order in the step, is extrapolated away. With
    `equal` the rates of both inputs are the same number."""
    rng = np.random.default_rng([35, order])
    for pair in (("ellipse", "ellipse"), ("table", "helix"), ("ellipse", "table")):
        pin, values = random_mechanism(rng, tmp_path, pair)
        values |= {"initial.theta": 0.2 * values["stop.upper"], "initial.omega": 0.0, "stop.restitution": 0.0}
        place, end = pin.at(values["initial.theta"]), 8e-3
        force = spring_force(values, place.z)
        load = band(place, friction(values), force)[1]
        inputs = {
            "tau": [1.4 * load, *(0.3 * load * math.factorial(k) / end**k for k in range(1, order + 1))],
            "F_ext": [0.05 * force, *(-0.1 * force / end**k for k in range(1, order + 1))],
        }
        if equal:
            inputs["F_ext"][1:] = inputs["tau"][1:]
        smooth = make().start(values, tolerance=1e-11)
        step(smooth, end, inputs)
        found = []
        for pieces in (64, 128, 256):
            fmu = make().start(values, tolerance=1e-11)
            for a, b in pairwise(np.linspace(0.0, end, pieces + 1)):
                step(fmu, float(b - a), {name: [polynomial(u, 0.5 * (a + b))] for name, u in inputs.items()})
            found.append(np.array([fmu.get("theta"), fmu.get("omega")]))
        once = [(4 * fine - coarse) / 3 for coarse, fine in pairwise(found)]
        limit = (16 * once[1] - once[0]) / 15
        assert smooth.get("theta") > values["initial.theta"]
        assert smooth.get("theta") == pytest.approx(limit[0], abs=1e-9)
        assert smooth.get("omega") == pytest.approx(limit[1], abs=1e-8 * max(1.0, abs(limit[1])))
        # and the polynomial itself does not mind where it is cut
        cut = make().start(values, tolerance=1e-11)
        run_on(cut, inputs, 0.0, end, 7)
        assert cut.get("theta") == pytest.approx(smooth.get("theta"), abs=1e-10)
        assert cut.get("tau") == pytest.approx(smooth.get("tau"), rel=1e-12)
