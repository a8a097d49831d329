"""A hinge with a weight and a dual cam behind an elastic shaft, solved by SciPy at 1e-13: the cam beside the
joint (without inertia), or a cam with inertia between a motor and the joint.

    J q'' = G sin q - T,   T = K (q - x) + D (q' - x')
    beside:    x rests while release(x) < T < load(x), else T is on that edge
    between:   I x'' = T + M - edge(x) while x slides, M the torque of the motor; x rests inside the band

The edges are those of two helices under a linear spring: arm (F0 + k z' x), one arm for each direction. Each
phase of slip or rest ends at an event.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class ElasticJoint:
    inertia: float  # J, kg.m2
    gravity: float  # G, N.m
    stiffness: float  # K, N.m/rad
    load_arm: float  # m, torque per axial force
    release_arm: float  # m
    preload: float  # F0, N
    rate: float  # k z', N/rad
    cam_inertia: float = 0.0  # I, kg.m2; 0: the cam is beside the joint
    damping: float = 0.0  # D, N.m.s/rad
    motor: float = 0.0  # M, N.m

    def edge(self, x, direction):
        arm = self.load_arm if direction > 0 else self.release_arm
        return arm * (self.preload + self.rate * x)

    def on_edge(self, q, direction):
        """x where K (q - x) is that edge."""
        arm = self.load_arm if direction > 0 else self.release_arm
        return (self.stiffness * q - arm * self.preload) / (self.stiffness + arm * self.rate)

    def begin(self, q):
        """x of a shaft that carried no torque before: the torque nearest to 0 in the band."""
        return self.on_edge(q, -1)


def solve(joint: ElasticJoint, q: float, speed: float, end: float) -> tuple[float, float, float]:
    """q, q', x at the end, from q, q'. A cam beside the joint starts as `begin` says, a cam between motor and
    joint starts at q with the joint's speed."""
    return _between(joint, q, speed, end) if joint.cam_inertia else _beside(joint, q, speed, end)


def _beside(joint, q, speed, end):
    time, state, x, direction = 0.0, np.array([q, speed]), joint.begin(q), 0
    while time < end:

        def torque(q, x=x, direction=direction):
            return (
                joint.edge(joint.on_edge(q, direction), direction) if direction else joint.stiffness * (q - x)
            )

        def excess(sign, x=x):
            return lambda t, y: joint.stiffness * (y[0] - x) - joint.edge(x, sign)

        events = [lambda t, y: y[1]] if direction else [excess(1), excess(-1)]
        time, state, hit = _phase(
            joint, torque, time, end, state, events, [-direction] if direction else [1, -1]
        )
        x = joint.on_edge(state[0], direction) if direction else x
        direction = 0 if direction or hit < 0 else (1, -1)[hit]
    return state[0], state[1], x


def _phase(joint, torque, time, end, state, events, signs):
    def rates(t, y):
        return [y[1], (joint.gravity * np.sin(y[0]) - torque(y[0])) / joint.inertia]

    return _integrate(rates, time, end, state, events, signs)


def _integrate(rates, time, end, state, events, signs):
    """End of the phase: time, state, and the number of the event, or -1."""
    for event, sign in zip(events, signs, strict=True):
        event.terminal, event.direction = True, sign
    done = solve_ivp(rates, (time, end), state, method="DOP853", rtol=1e-13, atol=1e-14, events=events)
    hits = [k for k, found in enumerate(done.t_events) if len(found)]
    return done.t[-1], done.y[:, -1], hits[0] if hits else -1


def _between(joint, q, speed, end):
    time, state = 0.0, np.array([q, speed, q, speed])  # q, q', x, x'
    direction = int(np.sign(speed))
    while time < end:

        def torque(y):
            return joint.stiffness * (y[0] - y[2]) + joint.damping * (y[1] - y[3])

        def rates(t, y, direction=direction):
            shaft = torque(y)
            joint_rate = (joint.gravity * np.sin(y[0]) - shaft) / joint.inertia
            if direction == 0:
                return [y[1], joint_rate, 0.0, 0.0]
            cam_rate = (shaft + joint.motor - joint.edge(y[2], direction)) / joint.cam_inertia
            return [y[1], joint_rate, y[3], cam_rate]

        def excess(sign):
            return lambda t, y: torque(y) + joint.motor - joint.edge(y[2], sign)

        events = [lambda t, y: y[3]] if direction else [excess(1), excess(-1)]
        signs = [-direction] if direction else [1, -1]
        time, state, hit = _integrate(rates, time, end, state, events, signs)
        if hit < 0:
            break
        if direction == 0:
            direction = (1, -1)[hit]
            continue
        state[3] = 0.0
        push = torque(state) + joint.motor
        direction = 1 if push > joint.edge(state[2], 1) else -1 if push < joint.edge(state[2], -1) else 0
    return state[0], state[1], state[2]
