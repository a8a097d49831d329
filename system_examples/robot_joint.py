"""A robot's elbow with and without the dual cam: what the spring saves and what its friction costs.

The elbow of a UR3e, driven by a 12 N.m actuator, moves 0, 1.5 and 3 kg through a pick-and-place cycle.
Without the cam the motor carries the arm's weight, also while nothing moves. In the joint with the cam the
spring carries most of it. Both are the same FMU (`DualCamForward`) in the same loop; without the cam the
spring's preload and stiffness are zero, the contacts carry no force, and what is left is an inertia.

    M alpha = tau_motor + tau_gravity(theta) - T_cam
    T_cam = T_load while the arm drops, T_release while it rises, anything between at rest

Sign: theta = 0 is the arm raised, 10 deg off upright; theta grows as it drops, to horizontal at the end of
the cam's 80 deg. Gravity then pushes in +theta, compresses the spring and grows with theta, as the torque of
a helix under a linear spring does. (On from horizontal to hanging, gravity would fade while the spring is
compressed.) Preload and stiffness put the middle of the stick band on gravity at 1.5 kg, by least squares.

Loops, inside out:
  current   PI at 20 kHz inside the tick, as drives do. L/R is 0.34 ms: seen at 1 kHz the winding's pole is
            exp(-1 ms R/L) = 0.05. It has all but settled within a sample, and a PI at that rate has nothing
            left to shape. The winding is discretised exactly, so the fast loop costs no accuracy.
  torque    the FMU receives the mean motor torque of the tick plus gravity at the tick's middle, both held
            over 1 ms.
  position  LQI at 1 kHz plus feed-forward of inertia, gravity and cam torque along the planned motion. The
            gains act on acceleration and are multiplied by the joint's inertia: every case has the same
            bandwidth. A robot is told its payload; this one is told 0.1 kg too much, and it takes the cam's
            friction for 10 % less than it is. Without such errors feed-forward alone would be perfect.

What friction asks of the controller. T_load and T_release lie 27 % above and below their middle. While
moving, the controller adds the edge that belongs to the planned direction. At rest, any torque inside the
band holds the same angle. Integral action there only costs current: it winds through the band until the joint
breaks loose, and back again. Once the planned motion is over and the error below tolerance, the controller
therefore drops its integral and asks for the smallest torque that keeps gravity well inside the band: for
most loads none. The case `cam, friction unknown` is the same cam under a controller that believes it
frictionless.

Left out, in all cases alike: the gear's friction and backlash (0.15 deg), the encoder's resolution, the
drive's losses and computing delay, the follower's mass (0.3 kg would add 5e-5 kg.m2). So the joint without
the cam has no friction at all and is better than any real one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from blocks import (
    LEDGER,
    CurrentLoop,
    GravityLoad,
    HelixCam,
    Motor,
    PickAndPlace,
    holding_torque,
    lqi_gains,
    spring_for,
)
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from story import bullets, command_line

from dualcam import Fmu

TICK = 1e-3  # s, period of the position loop and the FMU's step
CURRENT_RATE = 20e3  # Hz, samples of the current loop
CURRENT_BANDWIDTH = 1e3  # Hz
BANDWIDTH = 8.0  # Hz, radius of the position loop's poles over 2 pi
CYCLES = 2  # the first one settles, the last one is reported
PAYLOADS = (0.0, 1.5, 3.0)  # kg; a UR3e carries 3 kg
DESIGN_PAYLOAD = 1.5  # kg
PAYLOAD_ERROR = 0.1  # kg that the controller believes beyond the truth
FRICTION_BELIEVED = 0.9  # share of the true coefficient
HOLD_TOLERANCE = 0.5e-3  # rad, 0.1 mm at the wrist; two counts of the actuator's 12-bit encoder
HOLD_SPEED = 5e-3  # rad/s
HOLD_MARGIN = 0.2  # share of the band's half width kept between a held load and the band's edge

# T-Motor AK80-6. Source: dfki-ric-underactuated-lab/torque_limited_simple_pendulum,
# hardware/testbench_description.md, BSD-3-Clause. R and L are phase to phase; with Kt they are used here as
# one equivalent winding, which scales the heat of all cases alike.
AK80_6 = Motor(
    resistance=0.170,
    inductance=57e-6,
    torque_constant=0.091,
    rotor_inertia=6.0719e-5,
    gear=6.0,
    voltage=24.0,
    peak_torque=12.0,
    rated_torque=6.0,
    peak_speed=38.2,
)

# UR3e. Source: UniversalRobots/Universal_Robots_ROS2_Description, config/ur3e (physical_parameters.yaml,
# default_kinematics.yaml, joint_limits.yaml), BSD-3-Clause.
FOREARM_MASS = 1.437  # kg
FOREARM_CENTRE = 0.1632  # m from the elbow's axis, along the forearm
FOREARM_INERTIA = 6.544570e-3  # kg.m2 about its centre, across the forearm (the source's cylinder)
WRIST_MASSES = (0.871, 0.805, 0.261)  # kg, wrists 1 to 3
WRIST_DISTANCE = 0.2132  # m from the elbow's axis to wrist 1's
ELBOW_SPEED_LIMIT = math.radians(180.0)  # rad/s

RANGE = 1.3963  # rad, the cam's
CLEARANCE = 0.02  # rad between the motion and each end stop
LEAN = math.radians(10.0)  # rad off upright at theta = 0
MOTION = PickAndPlace(start=CLEARANCE, end=RANGE - CLEARANCE, move=1.0, dwell=1.0)

# Both lead angles pi/4: the closed-form optimum of the efficiency for equal friction, ((1 - mu)/(1 + mu))^2.
HELIX = HelixCam(radius=(0.025, 0.025), lead_angle=(math.pi / 4, math.pi / 4), friction=(0.14, 0.14))
NO_CAM = replace(HELIX, friction=(0.0, 0.0))  # and no spring: no axial force, no friction, no torque

BARE, CAM, NAIVE = "no cam", "cam", "cam, friction unknown"


def arm_moment(payload: float) -> float:
    """First moment of the arm about the elbow [kg.m] with `payload` [kg].

    Wrist and payload count at wrist 1's axis. For gravity that is exact while wrist 1 keeps wrist 2's axis
    upright (the tool grips from the side): they then sit straight below it. With the tool pointing down they
    sit 0.085 m beside it, which adds the same torque at every angle, about 2 N.m at 1.5 kg.
    """
    return FOREARM_MASS * FOREARM_CENTRE + (sum(WRIST_MASSES) + payload) * WRIST_DISTANCE


def arm_inertia(payload: float) -> float:
    """Inertia of the arm about the elbow [kg.m2] with `payload` [kg], rotor excluded.

    Wrist and payload are carried along without turning, so they add no inertia of their own. The moment with
    which wrist 1 keeps them level against acceleration, at most 0.4 N.m at 1.5 kg here, is left out.
    """
    forearm = FOREARM_INERTIA + FOREARM_MASS * FOREARM_CENTRE**2
    return forearm + (sum(WRIST_MASSES) + payload) * WRIST_DISTANCE**2


def gravity(payload: float) -> GravityLoad:
    """The arm's weight on the elbow with `payload` [kg]."""
    return GravityLoad(moment=arm_moment(payload), lean=LEAN)


def design_cam() -> HelixCam:
    """The cam whose stick band has its middle on gravity at the design payload."""
    return spring_for(HELIX, gravity(DESIGN_PAYLOAD).torque, 0.0, RANGE)


def with_friction(cam: HelixCam, share: float) -> HelixCam:
    """`cam` as a controller sees it that takes its friction for `share` of the true one."""
    return replace(cam, friction=(share * cam.friction[0], share * cam.friction[1]))


class JointController:
    """LQI with feed-forward, and rest inside the stick band. All it knows of the joint is a model of it."""

    def __init__(self, inertia: float, load: GravityLoad, cam: HelixCam, limit: float) -> None:
        """`inertia` [kg.m2] of the joint, `limit` [N.m] of the motor's torque at the output."""
        self.inertia = inertia
        self.load = load
        self.cam = cam
        self.limit = limit
        self.gains = lqi_gains(BANDWIDTH, TICK)
        self.integral = 0.0  # rad.s
        self.resting = False

    def torque(
        self, theta: float, omega: float, now: tuple[float, float], then: tuple[float, float]
    ) -> float:
        """Motor torque [N.m] for the coming tick, from the joint's state [rad, rad/s] and the planned motion
        (angle, speed) at the tick's beginning and end."""
        error, rate = theta - now[0], omega - now[1]
        advance = then[0] - now[0]
        if self._may_rest(error, omega, advance, theta):
            self.integral = 0.0
            return self._rest_torque(theta)
        angle_gain, speed_gain, integral_gain = self.gains
        feedback = angle_gain * error + speed_gain * rate + integral_gain * self.integral
        acceleration = (then[1] - now[1]) / TICK - feedback
        middle = now[0] + 0.5 * advance
        direction = advance if advance != 0.0 else -error  # at rest but off target: the way back
        wanted = self.inertia * acceleration + self.cam.torque(middle, direction) - self.load.torque(middle)
        torque = min(max(wanted, -self.limit), self.limit)
        if torque == wanted:  # else the integral would wind up
            self.integral += error * TICK
        return torque

    def _may_rest(self, error: float, omega: float, advance: float, theta: float) -> bool:
        release, load = self.cam.band(theta)
        tolerance = 2.0 * HOLD_TOLERANCE if self.resting else HOLD_TOLERANCE
        self.resting = (
            advance == 0.0 and load > release and abs(error) < tolerance and abs(omega) < HOLD_SPEED
        )
        return self.resting

    def _rest_torque(self, theta: float) -> float:
        """The smallest torque that keeps gravity inside the band, with a margin for what the model misses."""
        release, load = self.cam.band(theta)
        margin = HOLD_MARGIN * 0.5 * (load - release)
        return holding_torque((release, load), self.load.torque(theta), margin)


@dataclass(frozen=True)
class Result:
    """One case. Arrays have one entry per tick: states and ledger at its end, motor values over it."""

    payload: float  # kg
    joint: str
    time: np.ndarray  # s
    reference: np.ndarray  # rad
    theta: np.ndarray  # rad
    omega: np.ndarray  # rad/s
    motor_torque: np.ndarray  # N.m at the output, mean of the tick
    peak_torque: np.ndarray  # N.m at the output, largest magnitude within the tick
    motor_heat: np.ndarray  # J
    supply_energy: np.ndarray  # J
    motor_work: np.ndarray  # J, done on the joint
    gravity_work: np.ndarray  # J, done on the joint
    ledger: dict[str, np.ndarray]  # J, the FMU's own accounts since the start
    moving: np.ndarray  # bool, the planned motion moves

    @property
    def last(self) -> slice:
        """The last cycle's ticks."""
        return slice(-round(MOTION.period / TICK), None)

    @property
    def error(self) -> np.ndarray:
        """Tracking error, rad."""
        return self.theta - self.reference

    @property
    def lifts(self) -> bool:
        """Whether the joint follows its motion at all."""
        return bool(np.max(np.abs(self.error[self.last])) < 0.1)

    @property
    def rms_current(self) -> float:
        """A, over the last cycle, from the heat: R I^2 t."""
        return math.sqrt(self.joule_heat / (AK80_6.resistance * MOTION.period))

    @property
    def joule_heat(self) -> float:
        """J per cycle."""
        return float(np.sum(self.motor_heat[self.last]))

    @property
    def joule_heat_moving(self) -> float:
        """J per cycle while the planned motion moves; the rest falls on the holds."""
        return float(np.sum(self.motor_heat[self.last][self.moving[self.last]]))

    @property
    def friction_heat(self) -> float:
        """J per cycle, both contacts."""
        total = self.ledger["heat_cam1"] + self.ledger["heat_cam2"]
        return float(total[-1] - total[self.last.start - 1])

    @property
    def electric_energy(self) -> float:
        """J per cycle drawn from the supply, energy given back deducted."""
        return float(np.sum(self.supply_energy[self.last]))

    @property
    def largest_torque(self) -> float:
        """N.m at the output."""
        return float(np.max(self.peak_torque[self.last]))

    @property
    def hold_current(self) -> float:
        """A, RMS over the second half of the hold at the bottom, where gravity is largest."""
        tail = MOTION.dwell / 2
        end = MOTION.period / 2 + MOTION.dwell
        phase = np.mod(self.time - 0.5 * TICK, MOTION.period)
        ticks = (phase > end - tail) & (phase < end)
        ticks[: self.last.start] = False
        return math.sqrt(float(np.mean(self.motor_heat[ticks])) / (AK80_6.resistance * TICK))

    @property
    def rms_error(self) -> float:
        """rad, over the last cycle."""
        return float(np.sqrt(np.mean(self.error[self.last] ** 2)))

    @property
    def max_error(self) -> float:
        """rad, over the last cycle."""
        return float(np.max(np.abs(self.error[self.last])))

    @property
    def turned_over(self) -> float:
        """J, the energy that went through cam 2 in either direction: the scale for the ledger's residual."""
        return float(np.sum(np.abs(self.motor_work)) + np.sum(np.abs(self.gravity_work)))


def simulate(slave: Fmu, payload: float, joint: str) -> Result:
    """Run one case: `payload` [kg], `joint` BARE, CAM or NAIVE."""
    cam = NO_CAM if joint == BARE else design_cam()
    friction = 0.0 if joint == NAIVE else FRICTION_BELIEVED
    load, believed_load = gravity(payload), gravity(payload + PAYLOAD_ERROR)
    inertia = AK80_6.inertia + arm_inertia(payload)
    controller = JointController(
        inertia=AK80_6.inertia + arm_inertia(payload + PAYLOAD_ERROR),
        load=believed_load,
        cam=with_friction(cam, friction),
        limit=AK80_6.peak_torque,
    )
    current_loop = CurrentLoop(AK80_6, CURRENT_BANDWIDTH, CURRENT_RATE, TICK)

    ticks = round(CYCLES * MOTION.period / TICK)
    time = TICK * np.arange(ticks + 1)
    angle, speed = MOTION.sample(time)
    plan = list(zip(angle.tolist(), speed.tolist(), strict=True))
    motor = np.empty((ticks, 4))  # torque, peak, heat, supply energy
    weight = np.empty(ticks)  # N.m
    states = np.empty((ticks + 1, 2))  # theta, omega
    ledger = np.empty((ticks, len(LEDGER)))

    drive, sensors, accounts = slave.reals("tau"), slave.reals("theta", "omega"), slave.reals(*LEDGER)
    slave.start(
        {
            **cam.parameters(),
            "inertia.shaft": inertia,
            "stop.lower": 0.0,
            "stop.upper": RANGE,
            "initial.theta": MOTION.start,
            "contacts": 2,
        }
    )
    theta, omega = states[0] = sensors.read()
    for k in range(ticks):
        command = controller.torque(theta, omega, plan[k], plan[k + 1])
        done = current_loop.run(command, omega)
        weight[k] = load.torque(theta + 0.5 * TICK * omega)
        drive.values[0] = done.torque + weight[k]
        drive.write()
        slave.step(TICK)
        theta, omega = states[k + 1] = sensors.read()
        accounts.read()
        ledger[k] = accounts.values
        motor[k] = done.torque, done.peak_torque, done.heat, done.energy

    advance = np.diff(states[:, 0])
    return Result(
        payload=payload,
        joint=joint,
        time=time[1:],
        reference=angle[1:],
        theta=states[1:, 0],
        omega=states[1:, 1],
        motor_torque=motor[:, 0],
        peak_torque=motor[:, 1],
        motor_heat=motor[:, 2],
        supply_energy=motor[:, 3],
        motor_work=motor[:, 0] * advance,
        gravity_work=weight * advance,
        ledger={name.removeprefix("energy."): ledger[:, i] for i, name in enumerate(LEDGER)},
        moving=np.diff(angle) != 0.0,
    )


def run(fmu: str | Path) -> dict[tuple[float, str], Result]:
    """All cases, by payload [kg] and joint."""
    cases = [(payload, joint) for payload in PAYLOADS for joint in (BARE, CAM)]
    cases.append((DESIGN_PAYLOAD, NAIVE))
    with Fmu(fmu) as slave:
        return {(payload, joint): simulate(slave, payload, joint) for payload, joint in cases}


def horizontal_torque(payload: float) -> float:
    """Gravity's torque about the elbow with the arm horizontal [N.m]."""
    return gravity(payload).torque(0.5 * math.pi - LEAN)


def half_band(cam: HelixCam) -> float:
    """Half width of the stick band over its middle."""
    return (1.0 - cam.efficiency) / (1.0 + cam.efficiency)


def cycle_friction(cam: HelixCam) -> float:
    """Friction heat of a slow cycle over the motion's travel [J]: the area between T_load and T_release."""
    middle = 0.5 * (MOTION.start + MOTION.end)  # the band is affine in theta, so its mean is its middle
    release, load = cam.band(middle)
    return (load - release) * (MOTION.end - MOTION.start)


def table(results: dict[tuple[float, str], Result]) -> str:
    """Design and results as plain text."""
    cam = design_cam()
    angles = np.linspace(0.0, RANGE, 200)
    middle = np.array([0.5 * sum(cam.band(angle)) for angle in angles])
    carried = np.array([gravity(DESIGN_PAYLOAD).torque(angle) for angle in angles])
    release, load = cam.band(RANGE)
    lines = [
        "Elbow of a UR3e, T-Motor AK80-6, 1 s moves and 1 s holds; per cycle, the last of two",
        "",
        f"Spring for {DESIGN_PAYLOAD} kg: preload {cam.preload:.0f} N,"
        f" stiffness {cam.stiffness / 1e3:.1f} kN/m, stroke {cam.lift * RANGE * 1e3:.1f} mm",
        f"Efficiency {cam.efficiency:.4f}; stick band +-{100 * half_band(cam):.1f} % of its middle,"
        f" {release:.1f} to {load:.1f} N.m with the arm horizontal",
        f"Gravity is concave in the angle, the middle straight: they differ by up to"
        f" {100 * np.max(np.abs(carried / middle - 1.0)):.1f} %",
        "",
        "payload  gravity, horizontal  inertia with rotor",
        "     kg                  N.m               kg.m2",
    ]
    for payload in PAYLOADS:
        lines.append(
            f"{payload:7.1f} {horizontal_torque(payload):20.2f} {arm_inertia(payload) + AK80_6.inertia:19.3f}"
        )
    lines += [
        "",
        "                                  RMS   motor heat [J]  friction supply  peak   hold  error [mrad]",
        "payload  joint                    [A]   move  hold total   [J]     [J]   [N.m]   [A]    RMS    max",
    ]
    for result in sorted(results.values(), key=lambda one: one.payload):
        head = f"{result.payload:4.1f} kg  {result.joint:21s}"
        if not result.lifts:
            lines.append(
                f"{head} does not lift: gravity is {horizontal_torque(result.payload):.1f} N.m,"
                f" the motor's peak {AK80_6.peak_torque:.1f} N.m"
            )
            continue
        moving, total = result.joule_heat_moving, result.joule_heat
        lines.append(
            f"{head} {result.rms_current:5.2f} {moving:6.1f} {total - moving:5.1f} {total:5.1f}"
            f" {result.friction_heat:6.2f} {result.electric_energy:7.1f} {result.largest_torque:7.2f}"
            f" {result.hold_current:6.2f} {1e3 * result.rms_error:6.2f} {1e3 * result.max_error:6.2f}"
        )
    return "\n".join(lines)


def findings(results: dict[tuple[float, str], Result]) -> str:
    """What the table says, with its numbers, for and against the cam."""
    bare, cam, naive = (results[DESIGN_PAYLOAD, joint] for joint in (BARE, CAM, NAIVE))
    empty_bare, empty_cam = results[0.0, BARE], results[0.0, CAM]
    spread = half_band(design_cam())
    load = gravity(DESIGN_PAYLOAD)
    fall = load.energy(MOTION.start) - load.energy(MOTION.end)
    rated = AK80_6.rated_torque / AK80_6.output_constant
    helps = [
        f"At {DESIGN_PAYLOAD} kg the motor's heat falls from {bare.joule_heat:.0f} to"
        f" {cam.joule_heat:.0f} J per cycle. Without the cam the RMS current, {bare.rms_current:.1f} A, is"
        f" above the rated {rated:.1f} A: the motor would overheat.",
        f"Holding is free at {DESIGN_PAYLOAD} kg, because gravity lies inside the stick band:"
        f" {cam.hold_current:.2f} A against {bare.hold_current:.1f} A with the arm lowered.",
        f"The motor's {AK80_6.peak_torque:.0f} N.m do not hold 3 kg ({horizontal_torque(3.0):.1f} N.m)."
        " With the cam they lift it.",
    ]
    hurts = [
        f"Friction turns {cam.friction_heat:.2f} J per cycle into heat, whatever the payload; the area of the"
        f" band over the travel is {cycle_friction(design_cam()):.2f} J. The arm's weight gives and takes"
        f" {fall:.1f} J."
        " Without the cam, in this model, only the motor loses energy.",
        f"Moving costs {100 * spread:.1f} % of the carried torque, in both directions. Moving slowly, the"
        " motor runs cooler with the cam only where gravity is above"
        f" {50 * (1 + spread**2):.0f} % of the band's middle.",
        "Empty, the arm is too light for this spring: the motor must press it down. The peak torque rises"
        f" from {empty_bare.largest_torque:.1f} to {empty_cam.largest_torque:.1f} N.m, and holding the"
        f" lowered arm takes {empty_cam.hold_current:.1f} A.",
        f"Tracking is worse, {1e3 * cam.max_error:.2f} against {1e3 * bare.max_error:.2f} mrad at most. Both"
        " are below one count of the actuator's encoder (0.26 mrad), which is not modelled: read them as a"
        " ratio.",
        "It needs its own controller. One that believes the cam frictionless starts each move late"
        f" ({1e3 * naive.max_error:.1f} mrad) and rests with {naive.hold_current:.1f} A against the stick"
        f" band for nothing: {naive.joule_heat:.0f} J instead of {cam.joule_heat:.0f} J.",
    ]
    return bullets({"Where the cam helps": helps, "Where it hurts": hurts})


COLOURS = {BARE: "tab:orange", CAM: "tab:blue", NAIVE: "0.6"}


def picture(results: dict[tuple[float, str], Result], output: Path) -> None:
    """Save the comparison as an image."""
    bare, cam, naive = (results[DESIGN_PAYLOAD, joint] for joint in (BARE, CAM, NAIVE))
    time = cam.time[: round(MOTION.period / TICK)]
    figure = Figure(figsize=(13.0, 12.0), layout="constrained")
    axes = figure.subplots(3, 2)
    figure.suptitle(
        f"Elbow of a UR3e, {DESIGN_PAYLOAD} kg: {bare.joule_heat:.0f} J of motor heat per cycle without the"
        f" cam,\n{cam.joule_heat:.0f} J with it, and {cam.friction_heat:.0f} J of friction heat on top",
        fontsize=14,
    )
    for place in (axes[0, 0], axes[1, 0], axes[2, 0], axes[1, 1]):
        _draw_holds(place)
    _draw_angle(axes[0, 0], time, bare, cam)
    _draw_error(axes[1, 0], time, bare, cam)
    _draw_torque(axes[2, 0], time, bare, cam, naive)
    _draw_statics(axes[0, 1])
    _draw_energy(axes[1, 1], time, cam)
    _draw_heats(axes[2, 1], results)
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def _draw_holds(axes: Axes) -> None:
    for start in (0.0, MOTION.move + MOTION.dwell):
        axes.axvspan(start, start + MOTION.dwell, color="0.94", zorder=0)
    axes.set_xlim(0.0, MOTION.period)
    axes.set_xlabel("time in the cycle [s] (grey: hold)")


def _draw_angle(axes: Axes, time: np.ndarray, bare: Result, cam: Result) -> None:
    axes.plot(time, np.degrees(bare.theta[bare.last]), color=COLOURS[BARE], lw=5, alpha=0.6, label=BARE)
    axes.plot(time, np.degrees(cam.theta[cam.last]), color=COLOURS[CAM], lw=2, label=CAM)
    axes.plot(time, np.degrees(cam.reference[cam.last]), "k:", lw=1.2, label="planned")
    axes.set_title("Angle (0: arm raised, 80 deg: horizontal)")
    axes.set_ylabel("angle of cam 2 [deg]")
    axes.set_ylim(-3.0, 85.0)
    axes.legend(loc="lower center")


def _draw_error(axes: Axes, time: np.ndarray, bare: Result, cam: Result) -> None:
    for result in (bare, cam):
        axes.plot(time, 1e3 * result.error[result.last], color=COLOURS[result.joint], label=result.joint)
    axes.axhline(0.0, color="k", lw=0.6)
    axes.set_title("Tracking error")
    axes.set_ylabel("error [mrad]")
    axes.legend(loc="lower right")


def _draw_torque(axes: Axes, time: np.ndarray, bare: Result, cam: Result, naive: Result) -> None:
    for result in (naive, bare, cam):
        axes.plot(time, result.motor_torque[result.last], color=COLOURS[result.joint], label=result.joint)
    for level, name in ((AK80_6.rated_torque, "rated"), (AK80_6.peak_torque, "peak")):
        axes.axhline(level, color="tab:red", ls="--", lw=0.9)
        axes.axhline(-level, color="tab:red", ls="--", lw=0.9)
        axes.text(0.06, level + 0.3, name, fontsize=9, color="tab:red")
    axes.set_title("Motor torque (+ lowers the arm)")
    axes.set_ylabel("torque at the output [N.m]")
    axes.set_ylim(-14.0, 18.0)
    axes.legend(loc="upper right", ncols=3, fontsize=9)


def _draw_statics(axes: Axes) -> None:
    cam = design_cam()
    theta = np.linspace(0.0, RANGE, 100)
    degrees = np.degrees(theta)
    release, load = np.array([cam.band(angle) for angle in theta]).T
    blue = COLOURS[CAM]
    axes.fill_between(degrees, release, load, color=blue, alpha=0.2, lw=0, label="stick band: free hold")
    axes.plot(degrees, load, color=blue, lw=1, label="$T_{load}$ and $T_{release}$")
    axes.plot(degrees, release, color=blue, lw=1)
    axes.plot(degrees, 0.5 * (load + release), color=blue, lw=1, ls=":", label="middle of the band")
    for payload, style in zip(PAYLOADS, ("--", "-", "-."), strict=True):
        weight = [gravity(payload).torque(angle) for angle in theta]
        axes.plot(degrees, weight, color="k", ls=style, lw=1.5, label=f"gravity, {payload:g} kg")
    axes.axhline(AK80_6.peak_torque, color="tab:red", ls="--", lw=0.9, label="motor's peak")
    axes.set_title("Gravity and the cam's torque")
    axes.set_xlabel("angle of cam 2 [deg]")
    axes.set_ylabel("torque about the elbow [N.m]")
    axes.set_xlim(0.0, 80.0)
    axes.set_ylim(0.0, 16.0)
    axes.legend(loc="upper left", fontsize=9)


def _draw_energy(axes: Axes, time: np.ndarray, cam: Result) -> None:
    since = {name: values[cam.last] - values[cam.last.start - 1] for name, values in cam.ledger.items()}
    axes.stackplot(
        time,
        *(since[name] for name in ("spring", "kinetic", "heat_cam1", "heat_cam2")),
        labels=["spring", "kinetic", "heat, contact 1", "heat, contact 2"],
        colors=["tab:green", "gold", "tab:red", "salmon"],
        alpha=0.75,
        lw=0,
    )
    axes.plot(time, since["work_in"], "k", lw=1.5, label="work in = sum of these")
    axes.plot(time, np.cumsum(cam.gravity_work[cam.last]), "k--", lw=1.2, label="gravity's part of it")
    axes.plot(time, np.cumsum(cam.motor_work[cam.last]), "k:", lw=1.5, label="motor's part of it")
    axes.set_title("Energy since the cycle began, with the cam")
    axes.set_ylabel("energy [J]")
    axes.set_ylim(0.0, None)
    axes.legend(loc="upper left", fontsize=9)


def _draw_heats(axes: Axes, results: dict[tuple[float, str], Result]) -> None:
    for joint in (BARE, CAM):
        axes.bar(0.0, 0.0, color=COLOURS[joint], label=f"motor, {joint}")
    axes.bar(0.0, 0.0, color="tab:red", label="friction in the cam")
    tallest = 0.0
    for i, payload in enumerate(PAYLOADS):
        for joint, place in ((BARE, i - 0.2), (CAM, i + 0.2)):
            result = results[payload, joint]
            if not result.lifts:
                axes.text(place, 2.0, f"{joint}: does not lift", rotation=90, ha="center", va="bottom")
                continue
            total = result.joule_heat + result.friction_heat
            tallest = max(tallest, total)
            axes.bar(place, result.joule_heat, 0.36, color=COLOURS[joint])
            axes.bar(place, result.friction_heat, 0.36, bottom=result.joule_heat, color="tab:red")
            axes.text(place, total + 1.5, f"{total:.0f} J", ha="center")
    axes.set_title("Heat per cycle, all payloads")
    axes.set_ylabel("heat [J]")
    axes.set_xticks(range(len(PAYLOADS)), [f"{payload:g} kg" for payload in PAYLOADS])
    axes.set_xlim(-0.6, len(PAYLOADS) - 0.4)
    axes.set_ylim(0.0, 1.12 * tallest)
    axes.legend(loc="upper right", fontsize=9)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    fmu, output = command_line(__doc__, "robot_joint.png", arguments)
    results = run(fmu)
    print(table(results))
    print()
    print(findings(results))
    picture(results, output)
    print(f"\nPicture: {output}")


if __name__ == "__main__":
    main()
