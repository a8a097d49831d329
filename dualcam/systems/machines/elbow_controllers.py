"""Controllers of the robot's elbow behind an encoder, which do not know payload and friction.

Mppi    plans by trial runs of the FMU (model predictive path integral control), every 10 ms
Lqi     the controller of the example robot_joint, every 1 ms

Both answer one period of their own late. The encoder has 12 bits on the motor's rotor.
"""

import math
from dataclasses import replace

import numpy as np

from dualcam.design.statics import Array
from dualcam.systems.blocks.axis_bank import AxisBank
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.blocks.path_integral import Noise, PathIntegralPlanner, shaped_basis, spline_basis
from dualcam.systems.blocks.position_controller import lqi_gains
from dualcam.systems.machines import elbow
from dualcam.systems.machines.payload_filter import Belief, PayloadFilter

CAM = elbow.design_cam()
PAYLOADS, FRICTIONS = (0.5, 2.5), (0.10, 0.18)  # kg, 1: what a filter holds for possible
COUNT = 2.0 * math.pi / 4096 / AK80_6.gear  # rad at the output, of the encoder
FILTER = 1.0 - math.exp(-2.0 * math.pi * 100.0 * CONTROL_PERIOD)  # low-pass filter of the LQI's speed, 100 Hz
RATIO = 10  # control periods per period of planning and of estimating
PERIOD = RATIO * CONTROL_PERIOD  # s
HORIZON = 30  # periods of a plan
KNOTS = 5  # of the splines that are added to a plan
EFFECTIVE = 3.0  # plans in the mean
ERROR_COST = 1e6  # J/(rad^2.s)
HEAT_FACTOR = AK80_6.resistance / AK80_6.output_constant**2  # W/(N.m)^2
NEGLIGIBLE = 1e-3  # J: a saving for which a motor that is off stays off
STEPS = round(elbow.MOTION.period / CONTROL_PERIOD) + RATIO * (HORIZON + 2)
ANGLES, SPEEDS = elbow.MOTION.sample(CONTROL_PERIOD * np.arange(STEPS + 1))  # one cycle, and what a plan sees
GOALS = ANGLES[::RATIO]


def estimator(random: np.random.Generator, count: int = 64) -> PayloadFilter:
    """A filter that knows the ranges of payload and friction alone, at the beginning of the cycle.

    `random`: where the random numbers come from. `count`: number of particles.
    """
    return PayloadFilter(CAM, PAYLOADS, FRICTIONS, float(ANGLES[0]), count, PERIOD, COUNT, random)


def informed(payload: float, friction: float) -> PayloadFilter:
    """A filter of one particle that is told payload and friction, and estimates the state alone.

    `payload` [kg]. `friction`: Coulomb coefficient of both contacts [1].
    """
    ranges, random = ((payload, payload), (friction, friction)), np.random.default_rng(0)
    return PayloadFilter(CAM, *ranges, float(ANGLES[0]), 1, PERIOD, COUNT, random)


def plan_noises(plans: int) -> list[Noise]:
    """Deviations of plans: one half for ways out of stick, the other for following the motion closely.

    They are splines of 0.02 to 3 N.m, and splines shaped by the curvature of the cost of an arm without
    friction. A torque of 0.1 N.m over the whole horizon would lead such an arm 20 mrad astray, a short one
    hardly. `plans`: number of random plans; each deviation serves two.
    """
    i = np.arange(HORIZON)
    inertia = elbow.inertia(elbow.DESIGN_PAYLOAD)
    response = PERIOD**2 / inertia * np.tril(i[:, None] - i + 0.5)  # rad/(N.m), of a free arm
    curvature = 2.0 * PERIOD * (ERROR_COST * response.T @ response + HEAT_FACTOR * np.eye(HORIZON))
    splines = spline_basis(HORIZON, KNOTS)
    return [
        Noise(splines, np.geomspace(0.02, 3.0, plans // 4)),
        Noise(shaped_basis(splines, curvature), np.geomspace(0.02, 2.0, plans // 4)),
    ]


class Mppi:
    """Model predictive path integral control: the mean of random plans, weighted by their costs.

    In each period of 10 ms random plans of the motor's torque over 0.3 s run on instances of the forward FMU,
    through stick, slip and end stops. The cost of a plan is

        heat of the motor + 1 J/mrad^2.s times the integral of the squared error

    The first torque of the weighted mean acts in the next period. Where the arm rests, and the plan without
    its first torque costs no more, the motor stays off.

    Parameters
    ----------
    belief : What the controller believes of payload, friction and state.
    random : Where the random numbers come from.
    plans : Random plans per period.
    hypotheses
        0: plans run on the mean of the belief. Else each plan runs on that many particles of the filter, and
        its cost is their mean.

    Attributes
    ----------
    planner : The present plan.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.machines.elbow_controllers import Mppi, informed
    >>> controller = Mppi(informed(1.5, 0.14), np.random.default_rng(1), plans=16)
    >>> [controller.torque(0.0199, k) for k in range(20)] == [0.0] * 20  # at rest the motor is off
    True
    """

    def __init__(
        self, belief: PayloadFilter, random: np.random.Generator, plans: int = 192, hypotheses: int = 0
    ) -> None:
        self.belief, self.hypotheses = belief, hypotheses
        self.planner = PathIntegralPlanner(plan_noises(plans), AK80_6.peak_torque, EFFECTIVE, random)
        parameters = elbow.plant_parameters(CAM, elbow.DESIGN_PAYLOAD)
        per_plan = max(hypotheses, 1)
        self._banks = {n: AxisBank(n * per_plan, parameters) for n in (2, self.planner.count)}
        self._now = self._due = 0.0  # N.m, of the present and of the coming period of 10 ms

    def torque(self, angle: float, k: int) -> float:
        """The motor's torque [N.m] in control period `k`; `angle`: the encoder's at its beginning [rad]."""
        if k % RATIO == 0:
            before, self._now = self._now, self._due
            if k > 0:
                self.belief.update(before, angle)
            start = self.belief.draw(self.hypotheses) if self.hypotheses else self.belief.mean()
            self._due = self._planned(start, k // RATIO)
        return self._now

    def _planned(self, start: Belief, period: int) -> float:
        """Improve the plan, and give its torque for the coming period."""
        self.planner.shift()
        plans = self.planner.candidates()
        self.planner.update(plans, self.costs(start, period, plans))
        plan = self.planner.plan
        if np.any(start.speed != 0.0):
            return float(plan[0])
        both = np.array([plan, plan])
        both[1, 0] = 0.0
        kept, let_go = self.costs(start, period, both)
        return 0.0 if let_go <= kept + NEGLIGIBLE else float(plan[0])

    def costs(self, start: Belief, period: int, plans: Array) -> Array:
        """What plans cost, as the mean of the hypotheses [J], shape (count,).

        `start`: hypotheses at the beginning of `period`. The torque of that period is already decided.
        `period`: number of the period of 10 ms; the plans begin with the next one. `plans`: torques [N.m],
        shape (count, horizon); 2 plans or as many as the planner's candidates.
        """
        error = self.rollouts(start, plans) - GOALS[period + 2 : period + 2 + HORIZON]
        squared = np.einsum("ijk,ijk->i", error, error) / error.shape[1]
        return PERIOD * (ERROR_COST * squared + HEAT_FACTOR * np.einsum("ij,ij->i", plans, plans))

    def rollouts(self, start: Belief, plans: Array) -> Array:
        """Angles [rad] at the periods' ends of every plan on every hypothesis, shape (count, hypotheses,
        horizon).

        A period under the torque that is already decided comes first. `start`: the hypotheses. `plans`:
        torques [N.m], shape (count, horizon).
        """
        bank, count = self._banks[len(plans)], len(plans)
        each = Belief(*(np.tile(values, count) for values in start))
        weight, torques = elbow.weight(each.payload), np.repeat(plans, start.angle.size, axis=0)
        bank.start(np.clip(each.angle, 0.0, elbow.RANGE), each.speed, each.start_values())
        bank.step(np.full(each.angle.size, self._now), weight, PERIOD)
        angles = np.empty((HORIZON, each.angle.size))
        for i in range(HORIZON):
            bank.step(torques[:, i], weight, PERIOD)
            angles[i] = bank.angle
        return angles.T.reshape(count, -1, HORIZON)


class Lqi:
    """The LQI of the example robot_joint, with the design's payload and friction or with better knowledge.

    `payload`, `friction`: payload [kg] and Coulomb coefficient [1] that the controller believes. Default:
    those of the cam's design. `belief`: gives payload and friction anew every 10 ms. `bandwidth`: of the
    position loop [Hz].
    """

    def __init__(
        self,
        payload: float = elbow.DESIGN_PAYLOAD,
        friction: float = CAM.friction[0],
        belief: PayloadFilter | None = None,
        bandwidth: float = elbow.BANDWIDTH,
    ) -> None:
        self.controller = elbow.controller(CAM, payload)
        self.controller.gains = lqi_gains(bandwidth, CONTROL_PERIOD)
        self.belief = belief
        self._measured, self._speed = float(ANGLES[0]), 0.0
        self._due = self._sum = 0.0  # N.m, of the coming period, and since the last estimate
        self._believe(payload, friction)

    def _believe(self, payload: float, friction: float) -> None:
        self.controller.inertia, self.controller.load = elbow.inertia(payload), elbow.weight(payload)
        self.controller.cam = replace(CAM, friction=(friction, friction))

    def torque(self, angle: float, k: int) -> float:
        """The motor's torque [N.m] in control period `k`; `angle`: the encoder's at its beginning [rad]."""
        if self.belief is not None and k > 0 and k % RATIO == 0:
            self.belief.update(self._sum / RATIO, angle)
            mean = self.belief.mean()
            self._believe(float(mean.payload[0]), float(mean.friction[0]))
            self._sum = 0.0
        self._speed += FILTER * ((angle - self._measured) / CONTROL_PERIOD - self._speed)
        self._measured, torque = angle, self._due
        now, then = ((float(ANGLES[i]), float(SPEEDS[i])) for i in (k, k + 1))
        self._due = self.controller.torque(angle, self._speed, now, then)
        self._sum += torque
        return torque
