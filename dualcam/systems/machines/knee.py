"""A prosthetic knee with the dual cam: plant, design of the cam, and the closed loop of one swing.

    (I + J_rotor) theta'' = drive + tau_motor - T_cam

theta is knee flexion from full extension; drive is that of dualcam.systems.blocks.pendulum. The FMU owns the
shank's inertia. `drive` and the motor's torque are its input.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, minimize_scalar

from dualcam.design.statics import Array
from dualcam.fmi.fmu import Fmu
from dualcam.systems.blocks.axis import CamAxis, Recorder
from dualcam.systems.blocks.current_loop import CURRENT_BANDWIDTH, CURRENT_RATE, CurrentLoop, MotorPeriod
from dualcam.systems.blocks.elliptical_cam import EllipticalCam
from dualcam.systems.blocks.impedance import ImpedanceController
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.blocks.record import Record
from dualcam.systems.machines.gait import DESIGN_WALKER, Walker
from dualcam.systems.machines.swing import Swing, measured_swing

MOTOR = AK80_6.with_gear(2.0)  # a 2:1 belt follows the 6:1 gear
NATURAL_FREQUENCY = 3.0  # Hz, of the shank on the impedance's spring: 2.6 N.m/deg for the first subject
DAMPING_RATIO = 0.7
RANGE = math.radians(80.0)  # between the stops; the measured swings take 60 and 71 deg

GROOVE_RADIUS = 0.02  # m
FRICTION = 0.14
START_SINE = 0.995  # S at full extension: the arc starts near the ellipse's steepest point, S = 1


def inertia(walker: Walker) -> float:
    """The inertia of shank, foot and rotor about the knee of a `walker` [kg.m2]."""
    return walker.pendulum.inertia + MOTOR.inertia


def swing(walker: Walker, cadence: float) -> Swing:
    """The measured swing of a `walker`, sampled. `cadence`: share of the self-selected cadence [1]."""
    return measured_swing(walker, cadence, MOTOR.inertia)


# ---- design of the cam ----


def elliptical_cam(
    slope: float, end: float, stiffness: float, damping: float, friction: float
) -> EllipticalCam:
    """A cam from its slope at full extension and the sine S of the arc at the end of the range.

    `slope`: tangent of the lead angle at full extension [1]. `end`: S at the end of the range [1].
    `stiffness` of the spring [N/m]. `damping` while the spring is released [N.s/m]. `friction`: Coulomb
    coefficient [1].
    """
    a = 0.5 * GROOVE_RADIUS * RANGE / (START_SINE - end)
    b = a * slope * math.sqrt(1.0 - START_SINE**2) / START_SINE
    return EllipticalCam(GROOVE_RADIUS, math.atan(slope), a, b, friction, stiffness, damping)


def residual_torque(cam: EllipticalCam, motion: Swing) -> Array:
    """Torque that the motor adds to the `cam` to follow the measured `motion` [N.m], shape (n + 1,)."""
    return cam.torque(motion.angle, motion.speed) - motion.demand


def residual_share(cam: EllipticalCam, motion: Swing) -> float:
    """Mean square of the residual torque with a `cam` over that without [1], along the measured `motion`."""
    return float(np.mean(residual_torque(cam, motion) ** 2) / np.mean(motion.demand**2))


def design_cam(friction: float = FRICTION) -> EllipticalCam:
    """The cam, with spring and damper, by least squares over the first subject's self-selected swing.

    With the motor off the cam's torque should equal what the measured motion asks for. The squared torque
    left to the motor is minimal, and with it the motor's heat. `friction`: Coulomb coefficient [1].
    """
    motion = swing(DESIGN_WALKER, 1.0)

    def cam(unknown: Array) -> EllipticalCam:
        slope, end, stiffness, damping = unknown.tolist()
        return elliptical_cam(2.0 * slope, 0.8 * end, 2e4 * stiffness, 1e4 * damping, friction)

    def residuals(unknown: Array) -> Array:
        return residual_torque(cam(unknown), motion)

    bounds = (np.array([0.5, 0.5, 0.0, 0.0]), np.array([2.0, 1.2, 5.0, 5.0]))
    found = least_squares(residuals, np.ones(4), bounds=bounds, xtol=1e-12, ftol=1e-12, gtol=1e-12)
    return cam(found.x)


def best_damping_scale(cam: EllipticalCam, motion: Swing) -> float:
    """The damping, over that of the `cam` [1], with the least residual torque along the measured `motion`."""

    def cost(setting: float) -> float:
        return residual_share(cam.with_damping_scaled(setting), motion)

    return float(minimize_scalar(cost, bounds=(0.2, 5.0), method="bounded").x)


# ---- the closed loop ----


def impedance(inertia: float, frequency: float = NATURAL_FREQUENCY) -> ImpedanceController:
    """The controller of all joints, with DAMPING_RATIO.

    `inertia` of the joint [kg.m2]. `frequency`: natural frequency of the inertia on the virtual spring [Hz].
    """
    return ImpedanceController.tuned(inertia, frequency, DAMPING_RATIO)


def plant_parameters(cam: Mapping[str, float], walker: Walker) -> dict[str, float]:
    """Start values of the FMU for the knee of a `walker`, and of its `cam`, by name, in SI units."""
    return {**cam, "inertia.shaft": inertia(walker), "stop.lower": 0.0, "stop.upper": RANGE}


def simulate(
    fmu: Fmu, motion: Swing, cam: Mapping[str, float], controller: ImpedanceController | None
) -> KneeSwing:
    """Run one swing.

    The drive goes to the FMU as a polynomial of time with its first two derivatives, the motor's torque as
    the control period's mean. `fmu`: the forward FMU. `motion`: the measured motion, which is the plan.
    `cam`: start values of the cam. `controller`: without one the motor is off. FmuError: the FMU refuses a
    value or a step.
    """
    walker, pendulum, period = motion.walker, motion.walker.pendulum, motion.period
    axis = CamAxis(fmu)
    axis.start(plant_parameters(cam, walker), float(motion.angle[0]), float(motion.speed[0]))
    current_loop = CurrentLoop(MOTOR, CURRENT_BANDWIDTH, CURRENT_RATE, period)
    planned = list(zip(motion.angle.tolist(), motion.speed.tolist(), strict=True))
    recorder = Recorder(len(planned) - 1, period)
    for (wanted_angle, wanted_speed), hinge in zip(planned[:-1], motion.hinge[:-1], strict=True):
        angle, speed = axis.angle, axis.speed
        command, motor = 0.0, MotorPeriod(0.0, 0.0, 0.0, 0.0)
        if controller is not None:
            command = controller.torque(angle - wanted_angle, speed - wanted_speed)
            if angle <= 0.0:  # to push into the stop would only cost current
                command = max(command, 0.0)
            motor = current_loop.run(command, speed)
        knee = angle + motion.extension
        value = pendulum.drive(hinge, knee)[0]
        axis.set_torque(motor.torque + value)
        _, *derivatives = pendulum.drive(hinge, knee, speed, axis.acceleration())
        axis.advance(period, tuple(derivatives))
        recorder.add(axis, command, motor, value, angle)
    return KneeSwing(motion, inertia(walker), recorder.record(motion.angle[1:]))


@dataclass(frozen=True)
class KneeSwing:
    """One simulated swing and its figures.

    `motion`: the measured motion, which is the plan. `inertia` of shank, foot and rotor about the knee
    [kg.m2]. `record`: the run.
    """

    motion: Swing
    inertia: float
    record: Record

    @property
    def rms_error(self) -> float:
        """RMS tracking error [deg]."""
        return math.degrees(self.record.rms_error)

    @property
    def heat(self) -> float:
        """Heat in the motor [J]."""
        return self.record.heat

    @property
    def energy_drawn(self) -> float:
        """Energy drawn from the supply, energy that the motor gives back not deducted [J]."""
        return float(np.sum(np.maximum(self.record.supply_energy, 0.0)))

    @property
    def energy_returned(self) -> float:
        """Energy that the motor gives back to the supply [J]."""
        return float(np.sum(np.maximum(-self.record.supply_energy, 0.0)))

    @property
    def net_energy(self) -> float:
        """Energy from a supply that takes all energy back [J]."""
        return self.energy_drawn - self.energy_returned

    @property
    def power(self) -> Array:
        """Power from the supply, mean of each control period [W], shape (n,)."""
        return self.record.supply_energy / self.motion.period

    @property
    def peak_power(self) -> float:
        """Largest power from the supply, mean of a control period [W]."""
        return float(np.max(self.power))

    @property
    def largest_torque(self) -> float:
        """Largest torque of the motor at the output [N.m]."""
        return self.record.largest_torque

    @property
    def cam_heat(self) -> float:
        """Heat in contacts and damper [J]."""
        return self.record.cam_heat

    @property
    def impact_speed(self) -> float:
        """Speed of the hardest hit at full extension [deg/s], from the stop's heat I omega^2/2."""
        heat = np.max(
            np.diff(self.record.ledger["heat_stop"], prepend=0.0),
            where=self.record.angle < 0.5 * RANGE,
            initial=0.0,
        )
        return math.degrees(math.sqrt(2.0 * float(heat) / self.inertia))

    @property
    def before_impact(self) -> slice:
        """The control periods before the first hit."""
        hits = np.flatnonzero(self.record.ledger["heat_stop"] > 0.0)
        return slice(0, int(hits[0]) if len(hits) else None)
