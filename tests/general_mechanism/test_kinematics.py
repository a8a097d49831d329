"""Section 2 of docs/mechanism.md, kinematics, with any grooves."""

import numpy as np
import pytest
from pin_equations import KINDS, PAIRS
from random_mechanisms import random_mechanism


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_section_2_kinematics(make, tmp_path, pair):
    """gamma, z, v and both sliding speeds |psi_i'| r_i sqrt(1 + s_i^2), and z' and z'' through fmi2's output
    derivatives; against the root of g1(gamma) = g2(theta - gamma)."""
    rng = np.random.default_rng([2, *map(KINDS.index, pair)])
    for _ in range(6):
        pin, values = random_mechanism(rng, tmp_path, pair)
        for _ in range(4):
            theta = rng.uniform(values["stop.lower"], values["stop.upper"])
            omega = rng.uniform(-5.0, 5.0)
            fmu = make().start(values | {"initial.theta": theta, "initial.omega": omega})
            place, z_size = pin.at(theta), abs(pin.at(values["stop.upper"]).z)
            assert fmu.get("gamma") == pytest.approx(place.gamma, abs=2e-14)
            assert fmu.get("z") == pytest.approx(place.z, abs=2e-14 * z_size)
            assert fmu.get("v") == pytest.approx(place.lift * omega, rel=2e-12)
            assert fmu.output_derivative("z", 1) == fmu.get("v")
            speeds = [
                abs(omega * turn) * place.length(i) for i, turn in enumerate((place.turn, 1 - place.turn))
            ]
            for i in range(2):
                assert fmu.get(f"cam{i + 1}.sliding_speed") == pytest.approx(speeds[i], rel=2e-12)
            bent = place.lift * fmu.get("alpha") + place.lift_bent * omega**2
            size = abs(place.lift * fmu.get("alpha")) + abs(place.lift_bent * omega**2)
            assert fmu.output_derivative("z", 2) == pytest.approx(bent, abs=1e-10 * size)


def test_section_2_at_zero_and_both_stops(make, tmp_path):
    """z = gamma = 0 at theta = 0, whatever grooves; and the stops themselves are ordinary places."""
    rng = np.random.default_rng(22)
    for pair in PAIRS:
        pin, values = random_mechanism(rng, tmp_path, pair)
        for theta in (0.0, values["stop.lower"], values["stop.upper"]):
            fmu = make().start(values | {"initial.theta": theta, "initial.omega": 0.0})
            assert fmu.get("theta") == theta
            assert fmu.get("gamma") == pytest.approx(pin.at(theta).gamma, abs=2e-14)
            if theta == 0.0:
                assert (fmu.get("z"), fmu.get("gamma")) == pytest.approx((0.0, 0.0), abs=1e-16)
