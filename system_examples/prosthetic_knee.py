"""A prosthetic knee in swing with and without the dual cam: what spring and damper take off the motor.

From toe-off (65 % of the gait cycle) to heel strike the shank swings like a pendulum under a knee that the
thigh carries along. The knee must first stop flexion and start extension, then brake the shank before it
hits full extension; all in all it takes energy out. A powered prosthesis pays for that with current in a
motor. Here a dual cam in parallel with the motor does most of it: flexion loads its spring, which helps
extension to start, and its damper brakes the way back. Both grooves start steep at full extension and
flatten, so the damper bites where the shank must be stopped and hardly before.

    (I + J_rotor) theta'' = drive + tau_motor - T_cam
    drive = I psi'' + m d [a_x cos chi + (a_y + g) sin chi],  chi = psi - theta + lead

theta is knee flexion from full extension, psi the thigh's inclination, (a_x, a_y) the knee's acceleration,
chi the inclination of the shank's centre of mass, all in the sagittal plane. The FMU (`DualCamForward`)
owns the shank's inertia; `drive` and the motor's torque are its input. Without the cam it is the same FMU
with neither spring nor damper nor friction: what is left is an inertia.

Motion. Thigh inclination, knee flexion and the knee's path are Fourier series with 7 harmonics (5.9 Hz; the
source filters at 6 Hz), fitted by least squares to measured markers; derivatives are those of the series.
As a check, the knee moment that the equation above asks for along the measured motion is compared with the
moment that the sources publish (the table's first block). They differ by 4 N.m RMS: the filters differ, and
the first source's force plate reads 2 N while the foot is in the air. Other cadences: the same curves over
the phase of the stride, in a shorter or longer time, as if the walker took the same steps faster. Then
inertial torques grow with the square of the cadence, gravity's do not.

Shank and foot. Winter's segment masses, the foot rigid on the shank: a prosthesis as heavy as the leg it
replaces, which is what makes the measured moments its own. Lighter ones ask for less.

Cam. Design step: with the motor off its torque should equal what the measured motion asks for. Spring,
damper and the groove's shape are fitted to that by least squares over the self-selected swing, which
minimises the square of the torque left to the motor and with it the motor's heat. The damper's valve is
then opened in inverse proportion to the cadence, damping in proportion: the least-squares optimum at the
other two, as the table shows. Friction is the default 0.14, sliding and greased: rolling (0.05) changes
little, because most of the time the cam brakes anyhow, and there friction helps.

Control. The motor follows the measured motion through an impedance, a spring and a damper between the joint
and its reference at 1 kHz; it is told neither the load nor the cam. What the cam leaves over shows as error
and as torque. Drive and its two time derivatives go to the FMU as a polynomial, the motor's torque as its
mean.

Full extension, with a stop, is the smallest knee angle of the measured swing: the wearer's own. Whoever
arrives there late in braking hits it: the terminal impact.

Left out, in all cases alike: the second transmission stage's and gear's friction, the drive's losses, the
follower's mass, the ankle, and what the prosthesis does to hip and thigh, whose motion is prescribed.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from blocks import LEDGER, CurrentLoop, EllipseCam, HingedPendulum, HingeMotion, Impedance, Periodic
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from robot_joint import AK80_6, CURRENT_BANDWIDTH, CURRENT_RATE, TICK
from scipy.optimize import least_squares, minimize_scalar
from story import bullets, command_line

from dualcam import Fmu

SWING = (0.65, 1.0)  # toe-off to heel strike, in strides
CADENCES = (0.8, 1.0, 1.2)  # of the self-selected one
NATURAL_FREQUENCY = 3.0  # Hz, of the shank on the impedance's spring: 2.6 N.m/deg for the first subject
OTHER_FREQUENCIES = (2.0, 5.0, 8.0)  # Hz, what a softer and stiffer impedance makes of it
DAMPING_RATIO = 0.7
RANGE = math.radians(80.0)  # between the stops; the measured swings take 60 and 71 deg

AK80_6_BELT = AK80_6.behind(2.0)  # the motor of the robot's elbow: a 2:1 belt follows its 6:1 gear

# Segment fractions from D. A. Winter, Biomechanics and Motor Control of Human Movement, the table of
# anthropometric data: mass over body mass; centre and radius of gyration over the segment's length.
SHANK_MASS, SHANK_CENTRE, SHANK_GYRATION = 0.0465, 0.433, 0.302
FOOT_MASS, FOOT_GYRATION = 0.0145, 0.475
# The foot's length (heel to fifth metatarsal) and its centre (halfway), along the shank's axis and ahead of
# it, over the shank's length: means of the first subject's markers over the swing.
FOOT_LENGTH, FOOT_ALONG, FOOT_AHEAD = 0.394, 1.090, 0.094


@dataclass(frozen=True)
class Walker:
    """A measured walker. Fourier coefficients over one stride from heel strike: mean, then cosine and sine of
    each harmonic. The knee's path is the one seen from beside the walker, at constant speed."""

    name: str
    mass: float  # kg
    shank: float  # m, knee to ankle
    stride: float  # s, self-selected
    thigh: tuple[float, ...]  # rad, inclination, + knee ahead of the hip
    knee: tuple[float, ...]  # rad, flexion
    forward: tuple[float, ...]  # m, the knee's path
    upward: tuple[float, ...]  # m
    # Published: percent of the stride, knee flexion [deg], knee extension moment [N.m per kg of body mass].
    published: tuple[tuple[float, float, float], ...]

    @property
    def pendulum(self) -> HingedPendulum:
        """Shank and foot about the knee."""
        shank, foot, length = SHANK_MASS * self.mass, FOOT_MASS * self.mass, self.shank
        along = length * (shank * SHANK_CENTRE + foot * FOOT_ALONG)
        ahead = length * foot * FOOT_AHEAD
        radii = shank * (SHANK_CENTRE**2 + SHANK_GYRATION**2) + foot * (
            FOOT_ALONG**2 + FOOT_AHEAD**2 + (FOOT_GYRATION * FOOT_LENGTH) ** 2
        )
        return HingedPendulum(radii * length**2, math.hypot(along, ahead), math.atan2(ahead, along))


# Source: csu-hmc/GaitAnalysisToolKit, gaitanalysis/octave/2d_inverse_dynamics/test/rawdata.txt (treadmill,
# markers at 100 Hz, two and a half strides), Apache-2.0. Coefficients fitted for this example; RMS of the
# fit 0.9 deg (knee; strides differ) and 0.6 deg (thigh). Published: mean of two strides through the
# authors' leg2d.m.
# fmt: off
DESIGN_WALKER = Walker(
    name="first subject",
    mass=67.2,
    shank=0.4416,
    stride=1.195,
    thigh=(0.17487, 0.26883, -0.06238, -0.06527, -0.00508, -0.00154, 0.03453, -0.00018, 0.00201, -0.00010,
        0.00703, 0.00348, 0.00478, 0.00265, -0.00057),
    knee=(0.49658, -0.08187, -0.29967, -0.23949, 0.12868, -0.00312, 0.09298, -0.00535, 0.01892, 0.00091,
        0.02322, 0.00833, 0.01305, 0.00833, 0.00171),
    forward=(0.0, 0.11229, -0.02136, -0.03388, 0.00752, -0.00136, 0.01384, -0.00215, 0.00109, -0.00016,
        0.00389, 0.00066, 0.00129, 0.00062, 0.00002),
    upward=(0.0, 0.01527, -0.00178, -0.00882, -0.00863, -0.00680, 0.00421, -0.00030, 0.00345, -0.00006,
        0.00078, -0.00017, 0.00081, 0.00056, 0.00027),
    published=((65, 54.9, 0.177), (70, 63.7, 0.090), (75, 62.8, 0.061), (80, 53.2, 0.032), (85, 37.4,
        -0.004), (90, 18.6, -0.093), (95, 7.3, -0.195), (100, 10.3, -0.139)),
)
# fmt: on

# Source: opensim-org/opensim-core, OpenSim/Examples/Moco/example3DWalking, Apache-2.0: coordinates.sto
# (right leg, overground at 1.24 m/s) with the lengths of subject_walk_scaled.osim; inclination is pelvis
# tilt plus hip flexion, list and rotation of the pelvis left out. Coefficients fitted for this example; RMS
# of the fit 0.3 deg. Published: id_walk.sto there.
# fmt: off
CHECK_WALKER = Walker(
    name="second subject",
    mass=85.27,
    shank=0.4652,
    stride=1.145,
    thigh=(0.17964, 0.38041, -0.05155, -0.10061, -0.02117, -0.01552, 0.02983, 0.00507, -0.00307, -0.00067,
        0.00266, 0.00382, 0.00257, -0.00087, 0.00084),
    knee=(0.44873, -0.01828, -0.39966, -0.34581, 0.09373, -0.03275, 0.08435, -0.00662, 0.00742, -0.00941,
        0.01771, 0.00588, 0.01244, -0.00039, 0.00314),
    forward=(0.0, 0.14363, -0.02259, -0.05411, 0.00466, -0.00469, 0.01140, -0.00028, -0.00094, -0.00078,
        0.00100, 0.00105, 0.00074, -0.00017, 0.00016),
    upward=(0.0, 0.02191, -0.00157, -0.00670, -0.01837, -0.00802, 0.00167, -0.00123, 0.00377, 0.00083,
        -0.00063, -0.00019, 0.00027, 0.00040, 0.00021),
    published=((65, 53.7, 0.175), (70, 69.0, 0.134), (75, 71.7, 0.065), (80, 63.5, -0.001), (85, 47.1,
        -0.009), (90, 24.0, -0.195), (95, 5.1, -0.395), (100, 2.4, -0.322)),
)
# fmt: on

NO_CAM = {
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
    "cam1.friction": 0.0,
    "cam2.friction": 0.0,
}
BARE, CAM, PASSIVE = "no cam", "cam", "cam, motor off"
JOINTS = (BARE, CAM, PASSIVE)


@dataclass(frozen=True)
class Swing:
    """One swing of a walker at a cadence, sampled at these times [s from toe-off]."""

    walker: Walker
    cadence: float  # of the self-selected one
    time: np.ndarray  # s
    extension: float  # rad, knee angle at the stop
    angle: np.ndarray  # rad, measured, from the stop
    speed: np.ndarray  # rad/s
    acceleration: np.ndarray  # rad/s2
    hinge: list[HingeMotion]

    @property
    def demand(self) -> np.ndarray:
        """Torque against flexion [N.m] that makes joint and rotor follow the measured motion."""
        pendulum = self.walker.pendulum
        return self._drive - (pendulum.inertia + AK80_6_BELT.inertia) * self.acceleration

    @property
    def moment(self) -> np.ndarray:
        """Knee extension moment [N.m] of the leg without any rotor: inverse dynamics."""
        return self._drive - self.walker.pendulum.inertia * self.acceleration

    @property
    def _drive(self) -> np.ndarray:
        angles = (self.angle + self.extension).tolist()
        pairs = zip(self.hinge, angles, strict=True)
        return np.array([self.walker.pendulum.drive(hinge, angle)[0] for hinge, angle in pairs])


def swing(walker: Walker, cadence: float) -> Swing:
    """The measured swing at `cadence`, one sample per tick."""
    period = walker.stride / cadence
    ticks = round((SWING[1] - SWING[0]) * period / TICK)
    time = TICK * np.arange(ticks + 1)
    since = SWING[0] * period + time  # heel strike
    knee, thigh, forward, upward = (
        Periodic(curve, period) for curve in (walker.knee, walker.thigh, walker.forward, walker.upward)
    )
    tilt = np.column_stack([thigh.sample(since, order) for order in range(5)])
    ahead = np.column_stack([forward.sample(since, order) for order in (2, 3, 4)])
    above = np.column_stack([upward.sample(since, order) for order in (2, 3, 4)])
    rows = zip(tilt.tolist(), ahead.tolist(), above.tolist(), strict=True)
    hinge = [HingeMotion(*row) for row in rows]
    extension = full_extension(walker)
    return Swing(
        walker,
        cadence,
        time,
        extension,
        knee.sample(since) - extension,
        knee.sample(since, 1),
        knee.sample(since, 2),
        hinge,
    )


def full_extension(walker: Walker) -> float:
    """Smallest knee angle of the measured swing [rad]."""
    knee = Periodic(walker.knee, 1.0)

    def angle(phase: float) -> float:
        return float(knee.sample(np.array([phase]))[0])

    return float(minimize_scalar(angle, bounds=(0.9, 1.0), method="bounded", options={"xatol": 1e-10}).fun)


GROOVE_RADIUS = 0.02  # m
FRICTION = 0.14
START_SINE = 0.995  # S at full extension: the arc starts near the ellipse's steepest point, S = 1


def ellipse_cam(slope: float, end: float, spring: float, damping: float, friction: float) -> EllipseCam:
    """A cam from its slope at full extension and the sine S of the arc at the end of the range."""
    a = 0.5 * GROOVE_RADIUS * RANGE / (START_SINE - end)
    b = a * slope * math.sqrt(1.0 - START_SINE**2) / START_SINE
    return EllipseCam(GROOVE_RADIUS, math.atan(slope), a, b, friction, spring, damping)


def left_over(cam: EllipseCam, motion: Swing) -> np.ndarray:
    """Torque [N.m] that the motor must add for the joint to follow the measured motion."""
    return cam.torque(motion.angle, motion.speed) - motion.demand


def share(cam: EllipseCam, motion: Swing) -> float:
    """Mean square of the torque left to the motor, over the same without the cam."""
    return float(np.mean(left_over(cam, motion) ** 2) / np.mean(motion.demand**2))


def design_cam(friction: float = FRICTION) -> EllipseCam:
    """Slope and flattening of the groove, spring and damper: least squares over the first subject's swing."""
    motion = swing(DESIGN_WALKER, 1.0)

    def cam(unknown: np.ndarray) -> EllipseCam:
        slope, end, spring, damping = unknown.tolist()
        return ellipse_cam(2.0 * slope, 0.8 * end, 2e4 * spring, 1e4 * damping, friction)

    bounds = (np.array([0.5, 0.5, 0.0, 0.0]), np.array([2.0, 1.2, 5.0, 5.0]))
    tight = {"xtol": 1e-12, "ftol": 1e-12, "gtol": 1e-12}
    found = least_squares(lambda unknown: left_over(cam(unknown), motion), np.ones(4), bounds=bounds, **tight)
    return cam(found.x)


def valve(cam: EllipseCam, cadence: float) -> EllipseCam:
    """The cam with its damping set for a cadence."""
    return replace(cam, release_damping=cam.release_damping * cadence)


def best_valve(cam: EllipseCam, motion: Swing) -> float:
    """The damping, over that of `cam`, that leaves least to the motor."""

    def cost(factor: float) -> float:
        return share(valve(cam, factor), motion)

    return float(minimize_scalar(cost, bounds=(0.2, 5.0), method="bounded").x)


@dataclass(frozen=True)
class Result:
    """One swing. States are at the ticks' ends, motor values over each tick."""

    swing: Swing
    joint: str
    inertia: float  # kg.m2, shank, foot and rotor
    theta: np.ndarray  # rad
    omega: np.ndarray  # rad/s
    motor_torque: np.ndarray  # N.m at the output, mean of the tick
    peak_torque: np.ndarray  # N.m at the output, largest magnitude within the tick
    motor_heat: np.ndarray  # J
    supply_energy: np.ndarray  # J
    ledger: dict[str, np.ndarray]  # J, the FMU's own accounts since toe-off
    wall_time: float  # s that the loop took

    @property
    def error(self) -> np.ndarray:
        """rad."""
        return self.theta - self.swing.angle[1:]

    @property
    def rms_error(self) -> float:
        """deg."""
        return math.degrees(math.sqrt(float(np.mean(self.error**2))))

    @property
    def heat(self) -> float:
        """J in the winding."""
        return float(np.sum(self.motor_heat))

    @property
    def drawn(self) -> float:
        """J from the supply, what the motor gives back not counted."""
        return float(np.sum(np.maximum(self.supply_energy, 0.0)))

    @property
    def returned(self) -> float:
        """J that the motor gives back."""
        return float(np.sum(np.maximum(-self.supply_energy, 0.0)))

    @property
    def net(self) -> float:
        """J from the supply if it could take everything back."""
        return self.drawn - self.returned

    @property
    def power(self) -> np.ndarray:
        """W from the supply, mean of each tick."""
        return self.supply_energy / TICK

    @property
    def peak_power(self) -> float:
        """W from the supply, mean of a tick."""
        return float(np.max(self.power))

    @property
    def largest_torque(self) -> float:
        """N.m of the motor at the output."""
        return float(np.max(self.peak_torque))

    @property
    def cam_heat(self) -> float:
        """J in contacts and damper."""
        return sum(float(self.ledger[name][-1]) for name in ("heat_cam1", "heat_cam2", "heat_damper"))

    @property
    def impact_speed(self) -> float:
        """deg/s at which the shank hits full extension, the hardest of all hits: I omega^2/2 becomes heat."""
        heat = np.max(
            np.diff(self.ledger["heat_stop"], prepend=0.0), where=self.theta < 0.5 * RANGE, initial=0.0
        )
        return math.degrees(math.sqrt(2.0 * float(heat) / self.inertia))

    @property
    def swinging(self) -> slice:
        """The ticks before the first hit."""
        hits = np.flatnonzero(self.ledger["heat_stop"] > 0.0)
        return slice(0, int(hits[0]) if len(hits) else None)


def impedance(inertia: float, frequency: float = NATURAL_FREQUENCY) -> Impedance:
    """The controller of all joints, of this natural frequency [Hz]."""
    rate = 2.0 * math.pi * frequency
    return Impedance(rate**2 * inertia, 2.0 * DAMPING_RATIO * rate * inertia)


def simulate(
    slave: Fmu, motion: Swing, joint: str, cam: EllipseCam, frequency: float = NATURAL_FREQUENCY
) -> Result:
    """Run one swing with `joint` BARE, CAM or PASSIVE, `cam` as designed at the self-selected cadence, and an
    impedance of this natural frequency [Hz]."""
    motor, pendulum = AK80_6_BELT, motion.walker.pendulum
    inertia = pendulum.inertia + motor.inertia
    controller = impedance(inertia, frequency)
    current_loop = CurrentLoop(motor, CURRENT_BANDWIDTH, CURRENT_RATE, TICK)
    ticks = len(motion.time) - 1
    plan = list(zip(motion.angle.tolist(), motion.speed.tolist(), strict=True))
    motor_values = np.zeros((ticks, 4))  # torque, peak, heat, supply energy
    states = np.empty((ticks, 2))
    ledger = np.empty((ticks, len(LEDGER)))

    drive, sensors, accounts = slave.reals("tau"), slave.reals("theta", "omega"), slave.reals(*LEDGER)
    acceleration = slave.reals("alpha")
    slave.start(
        {
            **(NO_CAM if joint == BARE else valve(cam, motion.cadence).parameters()),
            "inertia.shaft": inertia,
            "stop.lower": 0.0,
            "stop.upper": RANGE,
            "initial.theta": plan[0][0],
            "initial.omega": plan[0][1],
        }
    )
    begin = clock.perf_counter()
    theta, omega = sensors.read()
    for k in range(ticks):
        torque = 0.0
        if joint != PASSIVE:
            wanted = controller.torque(theta - plan[k][0], omega - plan[k][1])
            if theta <= 0.0:  # pushing into the stop would only cost current
                wanted = max(wanted, 0.0)
            done = current_loop.run(wanted, omega)
            motor_values[k] = torque, *_ = done.torque, done.peak_torque, done.heat, done.energy
        knee = theta + motion.extension
        drive.values[0] = torque + pendulum.drive(motion.hinge[k], knee)[0]
        drive.write()
        (alpha,) = acceleration.read()
        _, first, second = pendulum.drive(motion.hinge[k], knee, omega, alpha)
        drive.write_derivatives(1, [first])
        drive.write_derivatives(2, [second])
        slave.step(TICK)
        theta, omega = states[k] = sensors.read()
        accounts.read()
        ledger[k] = accounts.values
    wall_time = clock.perf_counter() - begin

    return Result(
        swing=motion,
        joint=joint,
        inertia=inertia,
        theta=states[:, 0],
        omega=states[:, 1],
        motor_torque=motor_values[:, 0],
        peak_torque=motor_values[:, 1],
        motor_heat=motor_values[:, 2],
        supply_energy=motor_values[:, 3],
        ledger={name.removeprefix("energy."): ledger[:, i] for i, name in enumerate(LEDGER)},
        wall_time=wall_time,
    )


Results = dict[tuple[str, float, str], Result]


def run(fmu: str | Path) -> Results:
    """All swings, by walker, cadence and joint."""
    cam = design_cam()
    with Fmu(fmu) as slave:
        return {
            (walker.name, cadence, joint): simulate(slave, swing(walker, cadence), joint, cam)
            for walker in (DESIGN_WALKER, CHECK_WALKER)
            for cadence in CADENCES
            for joint in JOINTS
        }


def run_stiffness(fmu: str | Path) -> dict[tuple[float, str], Result]:
    """The first subject's self-selected swing by natural frequency of the impedance [Hz] and joint."""
    cam, motion = design_cam(), swing(DESIGN_WALKER, 1.0)
    with Fmu(fmu) as slave:
        return {
            (frequency, joint): simulate(slave, motion, joint, cam, frequency)
            for frequency in OTHER_FREQUENCIES
            for joint in (BARE, CAM)
        }


def moment_check(walker: Walker) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Percent of the stride, published moment and that of inverse dynamics [N.m], from 70 % on: before, the
    sources' filters still carry stance into the swing."""
    motion = swing(walker, 1.0)
    percent, _, moment = np.array(walker.published).T
    late = percent >= 70.0
    own = np.interp(percent[late], percent_of_stride(motion), motion.moment)
    return percent[late], moment[late] * walker.mass, own


def percent_of_stride(motion: Swing) -> np.ndarray:
    """Gait cycle at the swing's samples."""
    return 100.0 * (SWING[0] + motion.time * motion.cadence / motion.walker.stride)


def exact_heat(torque: np.ndarray) -> float:
    """J in the winding while the motor gives this torque [N.m], one sample per tick."""
    return AK80_6_BELT.resistance * TICK * float(np.sum((torque / AK80_6_BELT.output_constant) ** 2))


def check_table() -> list[str]:
    """Published moments against the pendulum's."""
    lines = ["Knee extension moment along the measured motion [N.m], published / from the equation of motion"]
    for walker in (DESIGN_WALKER, CHECK_WALKER):
        percent, given, own = moment_check(walker)
        pairs = [
            f"{p:.0f} %: {a:.1f}/{b:.1f}" for p, a, b in zip(percent, given, own, strict=True) if p % 10 == 0
        ]
        rms = float(np.sqrt(np.mean((given - own) ** 2)))
        lines.append(f"  {walker.name:14s}  {'  '.join(pairs)}; RMS difference {rms:.1f}")
    return lines


def design_table() -> list[str]:
    """The cam, and what it leaves to the motor on every measured swing."""
    cam, rolling = design_cam(), design_cam(0.05)
    deepest = float(swing(DESIGN_WALKER, 1.0).angle.max())
    slopes, lifts = cam.slope_and_lift(np.array([0.0, deepest]))
    steep, flat = np.degrees(np.arctan(slopes))
    controller = impedance(DESIGN_WALKER.pendulum.inertia + AK80_6_BELT.inertia)
    lines = [
        f"Cam: radius {1e3 * cam.radius:.0f} mm, ellipses {1e3 * cam.ellipse_a:.1f} x"
        f" {1e3 * cam.ellipse_b:.1f} mm, lead angle {steep:.1f} deg at full extension,"
        f" {flat:.1f} deg at {math.degrees(deepest):.0f} deg",
        f"     spring {cam.stiffness / 1e3:.1f} kN/m over {1e3 * lifts[1]:.1f} mm, no preload;"
        f" damper {cam.release_damping / 1e3:.1f} kN.s/m on the way back; friction {cam.friction}",
        f"Impedance: {math.radians(controller.stiffness):.2f} N.m/deg,"
        f" {math.radians(controller.damping):.3f} N.m.s/deg",
        "",
        "If the motor made the joint follow the measured motion exactly: mean square of its torque with the",
        "cam over that without (valve in proportion to cadence, fixed, at its best), heat, largest torque",
        "                           share of the mean square            heat [J]      torque [N.m]",
        "walker         cadence  prop. fixed  best (setting) rolling   no cam   cam   no cam   cam",
    ]
    for walker in (DESIGN_WALKER, CHECK_WALKER):
        for cadence in CADENCES:
            motion = swing(walker, cadence)
            best, ours = best_valve(cam, motion), valve(cam, cadence)
            rest, slippery = left_over(ours, motion), share(valve(rolling, cadence), motion)
            lines.append(
                f"{walker.name:14s} {cadence:7.1f} {share(ours, motion):6.2f} {share(cam, motion):5.2f}"
                f" {share(valve(cam, best), motion):5.2f}   ({best:.2f}) {slippery:9.2f}"
                f" {exact_heat(motion.demand):8.2f} {exact_heat(rest):5.2f}"
                f" {np.abs(motion.demand).max():8.1f} {np.abs(rest).max():5.1f}"
            )
    return lines


def swing_table(results: Results) -> list[str]:
    """What the simulated swings did."""
    lines = [
        "                                  RMS  motor  supply [J]             peak    peak   impact   cam",
        "walker, strides                 error   heat  drawn   re-    net    power  torque           heat",
        "per minute     joint            [deg]    [J]       turned             [W]   [N.m]  [deg/s]   [J]",
    ]
    for result in results.values():
        walker = result.swing.walker
        rate = f"{walker.name}, {60.0 * result.swing.cadence / walker.stride:.0f}"
        motor = ""
        if result.joint != PASSIVE:
            motor = (
                f"{result.heat:7.2f} {result.drawn:6.2f} {result.returned:6.2f} {result.net:6.2f}"
                f" {result.peak_power:7.0f} {result.largest_torque:7.1f}"
            )
        impact = f"{result.impact_speed:.0f}" if result.impact_speed > 0.0 else "none"
        error, heat = result.rms_error, result.cam_heat
        lines.append(f"{rate:18s} {result.joint:14s} {error:6.2f}{motor:44s}{impact:>8s} {heat:6.2f}")
    return lines


def stiffness_table(stiffness: dict[tuple[float, str], Result]) -> list[str]:
    """What a softer and a stiffer impedance make of the first subject's self-selected swing."""
    lines = ["First subject, self-selected, under softer and stiffer impedances: no cam / cam"]
    for frequency in OTHER_FREQUENCIES:
        bare, cam = stiffness[frequency, BARE], stiffness[frequency, CAM]
        stiff = math.radians(impedance(cam.inertia, frequency).stiffness)
        lines.append(
            f"  {frequency:.0f} Hz, {stiff:5.2f} N.m/deg:"
            f" error {bare.rms_error:.2f} / {cam.rms_error:.2f} deg,"
            f" heat {bare.heat:.2f} / {cam.heat:.2f} J, drawn {bare.drawn:.2f} / {cam.drawn:.2f} J,"
            f" impact {bare.impact_speed:.0f} / {cam.impact_speed:.0f} deg/s"
        )
    return lines


def table(results: Results, stiffness: dict[tuple[float, str], Result]) -> str:
    """Check, design and results as plain text."""
    title = "Swing of a prosthetic knee, toe-off to heel strike; T-Motor AK80-6 with a 2:1 belt"
    blocks = check_table(), design_table(), swing_table(results), stiffness_table(stiffness)
    return "\n\n".join([title, *("\n".join(block) for block in blocks)])


def findings(results: Results) -> str:
    """What the table says, with its numbers, for and against the cam."""
    first, second = DESIGN_WALKER.name, CHECK_WALKER.name
    slow, own, fast = CADENCES
    bare, cam, passive = (results[first, own, joint] for joint in JOINTS)
    other_bare, other_cam = results[second, own, BARE], results[second, own, CAM]
    fast_bare, fast_cam = results[first, fast, BARE], results[first, fast, CAM]
    slow_passive, fast_passive = results[first, slow, PASSIVE], results[first, fast, PASSIVE]
    motion = swing(DESIGN_WALKER, own)
    rest = left_over(design_cam(), motion)

    late = math.degrees(float(fast_passive.theta[-1] - fast_passive.swing.angle[-1]))
    free = bare.swinging  # ticks before the impact
    helps = [
        f"At the self-selected cadence it takes {100 * (1 - cam.heat / bare.heat):.0f} % off the motor's heat"
        f" ({bare.heat:.2f} to {cam.heat:.2f} J) and {100 * (1 - cam.drawn / bare.drawn):.0f} % off what the"
        f" motor draws ({bare.drawn:.2f} to {cam.drawn:.2f} J). Peak power falls from {bare.peak_power:.0f}"
        f" to {cam.peak_power:.0f} W, peak torque from {bare.largest_torque:.1f} to"
        f" {cam.largest_torque:.1f} N.m.",
        f"The shank meets the stop with {cam.impact_speed:.0f} deg/s instead of {bare.impact_speed:.0f}, and"
        f" follows the measured angle with {cam.rms_error:.2f} deg RMS instead of {bare.rms_error:.2f}.",
        f"With the motor off, the cam alone swings the shank through to {passive.rms_error:.1f} deg RMS and"
        " without hitting the stop: a dead battery leaves a hydraulic knee.",
        f"For the second subject, whom the design never saw, heat falls from {other_bare.heat:.1f} to"
        f" {other_cam.heat:.1f} J and impact from {other_bare.impact_speed:.0f} to"
        f" {other_cam.impact_speed:.0f} deg/s. That heavier leg would want the valve further closed.",
    ]
    hurts = [
        "Swing is braking, and a motor can give braking energy back. If drive and battery took all of it, the"
        f" motor without the cam would gain {-bare.net:.2f} J per swing; with the cam it costs"
        f" {cam.net:.2f} J, because {cam.cam_heat:.1f} J become heat in damper and grooves.",
        "Without the cam the peaks are the motor's answer to the impact: until then it needs"
        f" {np.max(bare.power[free]):.0f} W and {np.max(bare.peak_torque[free]):.1f} N.m. With the cam the"
        " peak comes after full extension, where the measured knee bends again: a way the cam cannot push.",
        "A stiffer impedance makes the impact without the cam softer and the saving in drawn energy smaller;"
        " heat falls all the same.",
        "A controller that knew the swing beforehand would save little peak torque with the cam:"
        f" {np.abs(motion.demand).max():.0f} N.m without, {np.abs(rest).max():.0f} N.m with it. Its heat"
        f" would still fall, from {exact_heat(motion.demand):.1f} to {exact_heat(rest):.1f} J.",
        f"At the fast cadence the motor draws more with the cam ({fast_cam.drawn:.1f} against"
        f" {fast_bare.drawn:.1f} J), though it stays cooler: most is drawn to start extension, for which the"
        " spring is then too weak. The second subject shows the same.",
        f"The motor can be off at one cadence only: at the slow one the shank hits the stop with"
        f" {slow_passive.impact_speed:.0f} deg/s, at the fast one it is still bent {late:.0f} deg too far at"
        " heel strike.",
    ]
    return bullets({"Where the cam helps": helps, "Where it does not": hurts})


def real_time(results: Results) -> str:
    """What the loop of all runs together cost on this machine."""
    seconds = sum(result.wall_time for result in results.values())
    ticks = sum(len(result.theta) for result in results.values())
    scaled = seconds / (ticks * TICK)
    return (
        f"10 s of the loop at {1 / TICK:.0f} Hz took {10.0 * scaled:.2f} s: {1 / scaled:.0f} times real time"
    )


COLOURS = {BARE: "tab:orange", CAM: "tab:blue", PASSIVE: "0.6"}


def picture(results: Results, output: Path) -> None:
    """Save the comparison as an image."""
    shown = {joint: results[DESIGN_WALKER.name, 1.0, joint] for joint in JOINTS}
    bare, cam = shown[BARE], shown[CAM]
    figure = Figure(figsize=(13.0, 12.0), layout="constrained")
    axes = figure.subplots(3, 2)
    figure.suptitle(
        f"Prosthetic knee in swing: motor heat {bare.heat:.1f} J without the cam, {cam.heat:.1f} J with it,\n"
        f"peak power {bare.peak_power:.0f} and {cam.peak_power:.0f} W, terminal impact"
        f" {bare.impact_speed:.0f} and {cam.impact_speed:.0f} deg/s",
        fontsize=14,
    )
    _draw_angle(axes[0, 0], shown)
    _draw_torque_angle(axes[0, 1], cam.swing)
    _draw_torque(axes[1, 0], shown)
    _draw_energy(axes[1, 1], cam)
    _draw_bars(axes[2, 0], results, "heat", "Motor heat per swing [J]", (BARE, CAM))
    _draw_bars(axes[2, 1], results, "impact_speed", "Terminal impact [deg/s] (no bar: no hit)", JOINTS)
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def _draw_angle(axes: Axes, shown: dict[str, Result]) -> None:
    motion = shown[CAM].swing
    percent = percent_of_stride(motion)
    styles: dict[str, dict[str, Any]] = {
        BARE: {"lw": 5, "alpha": 0.6},
        CAM: {"lw": 2},
        PASSIVE: {"lw": 2, "ls": "--"},
    }
    for joint, result in shown.items():
        angle = np.degrees(result.theta + motion.extension)
        axes.plot(percent[1:], angle, color=COLOURS[joint], label=joint, **styles[joint])
    axes.plot(
        percent, np.degrees(motion.angle + motion.extension), "k:", lw=1.5, label="measured (markers, fitted)"
    )
    given = np.array(motion.walker.published)
    axes.plot(given[:, 0], given[:, 1], "ko", ms=5, mfc="w", label="published mean of two strides")
    axes.axhline(math.degrees(motion.extension), color="tab:red", ls="--", lw=0.9)
    axes.text(66, math.degrees(motion.extension) - 4.0, "stop", fontsize=9, color="tab:red")
    axes.set_title("Knee flexion, first subject, self-selected cadence")
    axes.set_ylabel("knee flexion [deg]")
    axes.set_ylim(0.0, 70.0)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 0.1), fontsize=9)
    _label_cycle(axes)


def _label_cycle(axes: Axes) -> None:
    axes.set_xlim(65.0, 100.0)
    axes.set_xlabel("gait cycle [%] (65: toe-off, 100: heel strike)")


def _draw_torque_angle(axes: Axes, motion: Swing) -> None:
    cam = design_cam()
    degrees = np.degrees(motion.angle + motion.extension)
    carried = cam.torque(motion.angle, motion.speed)
    axes.plot(degrees, motion.demand, "k", lw=2, label="what the measured motion asks for")
    axes.plot(degrees, carried, color=COLOURS[CAM], lw=2, label="the cam along it")
    backwards = motion.speed < 0.0
    axes.fill_between(
        degrees[backwards],
        motion.demand[backwards],
        carried[backwards],
        color=COLOURS[BARE],
        alpha=0.3,
        lw=0,
        label="left to the motor while extending",
    )
    for percent, offset in (
        (65, (-30, 4)),
        (70, (6, 3)),
        (75, (8, -3)),
        (85, (6, 6)),
        (90, (6, -12)),
        (100, (6, 6)),
    ):
        k = int(np.argmin(np.abs(percent_of_stride(motion) - percent)))
        place = (degrees[k], motion.demand[k])
        axes.annotate(f"{percent} %", place, textcoords="offset points", xytext=offset, fontsize=9)
        axes.plot(*place, "k.", ms=7)
    axes.axhline(0.0, color="k", lw=0.6)
    axes.set_title("Design: the cam's torque against what the motion asks for")
    axes.set_xlim(0.0, 72.0)
    axes.set_xlabel("knee flexion [deg]")
    axes.set_ylabel("torque against flexion [N.m]")
    axes.legend(loc="lower right", fontsize=9)


def _draw_torque(axes: Axes, shown: dict[str, Result]) -> None:
    percent = percent_of_stride(shown[CAM].swing)[1:]
    for joint in (BARE, CAM):
        axes.plot(percent, shown[joint].motor_torque, color=COLOURS[joint], label=joint)
    peak = AK80_6_BELT.peak_torque
    axes.axhline(peak, color="tab:red", ls="--", lw=0.9)
    axes.text(66, peak - 2.3, "motor's peak", fontsize=9, color="tab:red")
    axes.axhline(0.0, color="k", lw=0.6)
    axes.set_title("Motor torque (+ bends the knee)")
    axes.set_ylabel("torque at the output [N.m]")
    axes.legend(loc="lower left", fontsize=9)
    _label_cycle(axes)


def _draw_energy(axes: Axes, cam: Result) -> None:
    percent = percent_of_stride(cam.swing)[1:]
    parts = ("kinetic", "spring", "heat_damper", "heat_cam1", "heat_cam2", "heat_stop")
    axes.stackplot(
        percent,
        *(cam.ledger[name] for name in parts),
        labels=[
            "kinetic (against the thigh)",
            "spring",
            "heat, damper",
            "heat, contact 1",
            "heat, contact 2",
            "heat, stop",
        ],
        colors=["gold", "tab:green", "tab:purple", "tab:red", "salmon", "k"],
        alpha=0.75,
        lw=0,
    )
    axes.set_title("Where the energy is, with the cam")
    axes.set_ylabel("energy [J]")
    axes.legend(loc="upper left", fontsize=9)
    _label_cycle(axes)


def _draw_bars(axes: Axes, results: Results, what: str, title: str, joints: Sequence[str]) -> None:
    width = 0.8 / len(joints)
    labels = []
    for i, (walker, cadence) in enumerate((w, c) for w in (DESIGN_WALKER, CHECK_WALKER) for c in CADENCES):
        labels.append(f"{60 * cadence / walker.stride:.0f}/min")
        for j, joint in enumerate(joints):
            value = getattr(results[walker.name, cadence, joint], what)
            place = i + (i >= len(CADENCES)) * 0.4 + (j - 0.5 * (len(joints) - 1)) * width
            axes.bar(place, value, 0.92 * width, color=COLOURS[joint], label=joint if i == 0 else None)
            text = f"{value:.1f}" if what == "heat" else f"{value:.0f}" if value > 0.0 else ""
            axes.text(place, value, text, ha="center", va="bottom", fontsize=8)
    places = [i + (i >= len(CADENCES)) * 0.4 for i in range(len(labels))]
    axes.set_xticks(places, labels)
    axes.set_xlabel(
        f"strides per minute; left: {DESIGN_WALKER.name}, right: {CHECK_WALKER.name}, not used in the design"
    )
    axes.set_title(title)
    axes.margins(y=0.12)
    axes.legend(loc="upper left", fontsize=9)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    fmu, output = command_line(__doc__, "prosthetic_knee.png", arguments)
    results = run(fmu)
    print(table(results, run_stiffness(fmu)))
    print()
    print(findings(results))
    print()
    print(real_time(results))
    picture(results, output)
    print(f"\nPicture: {output}")


if __name__ == "__main__":
    main()
