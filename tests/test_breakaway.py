"""Steps that end within rounding of a mode change, under inputs that are polynomials of time.

At breakaway the torque is on the edge of the stick band and its excess grows from zero. A step may end
anywhere there. The FMU makes the step, and the motion goes on as if the step had not ended.
"""

import math

import numpy as np
import pytest
from control_cases import FORWARD

from dualcam import Fmu

INPUTS = ("tau", "F_ext")
# From some units in the last place of a time to far beyond the range in which rounding decides, s.
DISTANCES = (
    0.0,
    *(s * d for d in (1e-17, 2e-16, 3e-15, 5e-14, 6.5e-13, 8e-12, 1e-10, 2e-9) for s in (1, -1)),
)
MECHANISMS = {
    "helices": {},
    "helices, follower mass": {"inertia.follower_mass": 0.5},
    "helices, bounces": {"stop.restitution": 0.5},
    "helices, damper": {"damper.c_load": 20.0, "damper.c_release": 20.0},
    "helices, locked": {"cam1.friction": 1.2},
    "helices, rate-independent": {"inertia.shaft": 0.0},
    "ellipses": {"cam1.profile": 2, "cam2.profile": 2},
    "ellipses, cubic spring": {"cam1.profile": 2, "cam2.profile": 2, "spring.stiffness2": 1e5},
    "ellipses, viscous": {
        **{"cam1.profile": 2, "cam2.profile": 2, "inertia.shaft": 0.0},
        **{"damper.c_load": 20.0, "damper.c_release": 20.0},
    },
}


class Run:
    """One instance that returns to its start, and its inputs by their derivatives at time 0."""

    def __init__(self, fmu, derivatives):
        self.fmu = fmu
        self.inputs = fmu.reals(*INPUTS)
        self.step_derivatives = fmu.reals("step.dtheta_dtau", "step.domega_dtau")
        self.derivatives = np.array(derivatives)  # [order, input]
        self.start = fmu.save_state()

    def at(self, time):
        """Value and derivatives of the inputs at that time."""
        d = self.derivatives
        return [
            sum(d[order + k] * time**k / math.factorial(k) for k in range(4 - order)) for order in range(4)
        ]

    def step(self, size):
        values = self.at(self.fmu.time)
        self.inputs.values[:] = values[0]
        self.inputs.write()
        for order in (1, 2, 3):
            self.inputs.write_derivatives(order, values[order])
        self.fmu.step(size)

    def events_after(self, size):
        """Mode changes of one step from the start; it must not be refused."""
        self.fmu.restore_state(self.start)
        self.step(size)
        return self.fmu.get("events")

    def mode_changes(self, size, most):
        """The times of the first mode changes of the step, s, each the first double after the change."""
        times = []
        total = self.events_after(size)
        for k in range(1, min(total, most) + 1):
            before, after = times[-1] if times else 0.0, size
            if before > 0.0 and self.events_after(before) >= k:
                continue  # two changes at once
            while (middle := 0.5 * (before + after)) not in (before, after):
                if middle > 0.0 and self.events_after(middle) >= k:
                    after = middle
                else:
                    before = middle
            times.append(after)
        return times


def random_derivatives(rng):
    """Value and three derivatives of tau and F_ext, of many sizes, some of them zero."""
    tau = [rng.uniform(-8, 8), *(rng.uniform(-1, 1) * rng.choice(s) for s in ((5, 50), (50, 5e3), (50, 1e5)))]
    load = [rng.uniform(-60, 60), *(rng.uniform(-1, 1) * s for s in (1e3, 1e4, 1e5))]
    if rng.random() < 0.7:
        load = [0.0] * 4
    tau = [0.0 if rng.random() < 0.12 else value for value in tau]
    return list(zip(tau, load, strict=True))


@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_steps_may_end_within_rounding_of_a_mode_change(mechanism):
    parameters = MECHANISMS[mechanism] | {"stop.upper": 1.2}
    changes = 0
    with Fmu(FORWARD) as fmu:
        for seed in range(25):
            rng = np.random.default_rng(seed)
            fmu.start(parameters, tolerance=1e-10)
            run = Run(fmu, random_derivatives(rng))
            size = rng.uniform(0.02, 0.2)
            run.events_after(size)
            whole = fmu.get("theta")
            for time in run.mode_changes(size, most=4):
                changes += 1
                for distance in DISTANCES:
                    cut = time + distance
                    if not 0.0 < cut < size:
                        continue
                    fmu.restore_state(run.start)
                    run.step(cut)
                    assert all(map(math.isfinite, run.step_derivatives.read()))
                    run.step(size - cut)
                    assert fmu.get("theta") == pytest.approx(whole, rel=0, abs=1e-9), (seed, cut)
    assert changes > 20


def test_a_step_that_was_once_refused():
    """A step of the default mechanism that ends 6.5e-13 s after breakaway."""
    derivatives = (5.204793012928848, 2.410753348015536, -3.5484609676281345)
    with Fmu(FORWARD) as fmu:
        fmu.start()
        run = Run(fmu, [(0.1920512627236736, 0.0), *((d, 0.0) for d in derivatives)])
        assert run.events_after(0.08870064548360176) == 2  # from the lower stop into the band, and out of it
        # omega = 1/2 d alpha/dt t^2 at t = 6.5e-13 s; d alpha/dt is of the order 5.4 N.m/s over 0.002 kg.m2.
        half_jerk = 5.4 * 0.5 / 0.002  # rad/s3
        assert 0.0 < fmu.get("omega") < half_jerk * 6.5e-13**2
        assert all(map(math.isfinite, run.step_derivatives.read()))


def test_sensitivities_of_curved_steps_come_to_an_end():
    """Random cubic torques, each step cut at its last mode change, after which the sensitivities are read.

    134 torques, as many as in the search that once found ten whose sensitivities never came to an end.
    """
    with Fmu(FORWARD) as fmu:
        for seed in range(134):
            rng = np.random.default_rng(seed)
            fmu.start()
            run = Run(fmu, [(value, 0.0) for value in (rng.uniform(-1, 1), *(rng.uniform(-10, 10, 3)))])
            times = run.mode_changes(rng.uniform(0.05, 0.3), most=3)
            for time in times[-1:]:
                assert run.events_after(time) > 0
                assert all(map(math.isfinite, run.step_derivatives.read()))


def test_a_small_torque_moves_a_mechanism_with_a_steep_groove_and_a_long_travel():
    """Rounding of the slopes, of 5000 m/rad, times that of a height of 1 m is of second order: the torque is
    no tie. The motion is a vibration under the spring, over angles in which the ellipse is straight."""
    slope = 0.1 * math.tan(1.2)
    p = {
        **{f"cam{i}.friction": 0.0 for i in (1, 2)},
        **{
            "cam1.radius": 1.0,
            "cam1.lead_angle": math.pi / 2 - 2e-4,
            "cam2.radius": 0.1,
            "cam2.lead_angle": 1.2,
        },
        **{"cam2.profile": 2, "cam2.ellipse_a": 10.0, "cam2.ellipse_b": 10.0, "cam2.ellipse_curvature": -1},
        **{"spring.preload": 0.0, "spring.stiffness": 3e5, "inertia.shaft": 1.0, "stop.upper": 8.0},
        **{"damper.c_load": 0.0, "damper.c_release": 0.0, "stop.lower": -1.0},
    }
    tau, steep = 1e-6, math.tan(math.pi / 2 - 2e-4)
    lift = slope * steep / (slope + steep)
    w = lift * math.sqrt(3e5)
    with Fmu(FORWARD) as fmu:
        fmu.start({**p, "tau": tau})
        for k in range(1, 6):
            fmu.step(1e-3)
            expected = tau / w**2 * (1.0 - math.cos(w * 1e-3 * k))
            assert fmu.get("theta") == pytest.approx(expected, rel=1e-4)
