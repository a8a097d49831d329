"""A car's side door that stays where it is let go, on every slope it was designed for, its motor off.

A passenger's door of 36 kg hangs on a hinge that leans 2 deg. With the car parked nose up its weight pulls
it shut with up to 36 N.m, nose down it pulls it open with up to 28 N.m. A dual cam beside the hinge holds it:
its stick band contains the weight at every angle in every attitude. A hydraulic damper on the cam's follower
limits the speed of closing, and a small geared motor opens and closes the door. The same door without cam and
damper is the comparison: there the motor must hold it. Both are the same FMU (`DualCamForward`) in the same
loop; without the cam the spring, the friction and the damper are zero, and what is left is an inertia.

    J a'' = motor + weight(a) + hand + N T_cam
    T_cam = T_load + damper while it closes, T_release < 0 while it opens, anything between at rest

Signs: the door's angle a is 0 closed and 67 deg fully open; a torque about the hinge is + if it opens. The
cam turns with the door, N = 2 times as far, and loads its spring while the door closes:
theta = N (67 deg - a), tau = -torque/N.

Why closing loads the spring. First, on level ground the door falls shut, and the spring then pushes against
that: the middle of the band lies near the weight on level ground. Second, the weight changes its sign with
the attitude. So the band must reach below zero, both contacts must lock themselves (lead angle below the
angle of friction), and in a locked cam a damper on the follower brakes only while the spring is loaded. There
friction multiplies what the damper does. While the spring is released the damper would take load off the
contacts that brake, and make the door faster. A damper against slamming belongs on the side that loads.

Design, by the statics of two equal helices: rho = (r/2) tan(lambda +- phi), phi = atan(mu). Largest closing
torque of the weight: C, largest opening torque: O, both with the door fully open.
  lead angle   T_load : -T_release = C : O, so sin(2 lambda) = sin(2 phi) (C - O)/(C + O)
  preload      N T_load = 1.1 C at theta = 0, where the spring is weakest. The 10 % pay for a friction that is
               5 % less and a door that is 3 % heavier than believed
  damper       one-way orifice, D = q v^2: with a hand that keeps pushing with 60 N on the worst slope, the
               door settles at 1.2 rad/s
There is a price: what holds 36 N.m on a slope is in the hand's and the motor's way on level ground. The first
table says how much of one costs how much of the other.

Loops: current PI at 20 kHz inside the tick; PI on speed at 1 kHz along a minimum-jerk profile of speed, its
integral part being the distance to the profile; feed-forward of inertia, weight, friction and damper, the
weight from a tilt sensor. When the profile has ended and the weight lies inside the stick band, the motor is
switched off. Where it does not (both slopes at once), the motor adds only what is missing.

Left out, in all cases alike: losses of gear and hinge (a real gear's friction would help to hold the plain
door), the latch (the motor's cycle ends 1 deg before it), the air that the cabin must let out, the seal,
wind, the drive's own consumption, the follower's mass. Nothing but friction slows the door while it opens.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path

import numpy as np
from blocks import (
    LEDGER,
    CurrentLoop,
    GravityLoad,
    HelixCam,
    PickAndPlace,
    hinged_load,
    holding_torque,
    up_in_car,
)
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from robot_joint import AK80_6, CURRENT_BANDWIDTH, CURRENT_RATE, TICK, with_friction
from story import bullets, command_line

from dualcam import Fmu

# Passenger's side door. Source: jandaa/door-model, door_model.py ("Parameters from OEM"), MIT licence.
# Car axes: x to the rear, y to the right, z to the roof; door closed.
MASS = 36.1736  # kg
HINGE = (np.array([0.749783, 0.910696, 0.10185]), np.array([0.753367, 0.896342, 0.51262]))  # m, lower, upper
CENTRE = np.array([1.252737, 0.845036, 0.400716])  # m
OPEN = math.radians(67.0)  # rad, fully open
# The source has no inertia. m r^2 = 9.2 kg.m2 about the hinge is the least it can be; the radius of gyration
# about the centre is taken as that of a uniform panel 0.87 m long, 0.87/sqrt(12) = 0.25 m.
ARM = 0.50334  # m, of the centre of mass from the hinge's axis (a test computes it from the points)
GYRATION = 0.25  # m
DOOR_INERTIA = MASS * (ARM**2 + GYRATION**2)  # kg.m2, 11.4
HANDLE = 0.85  # m from the axis, assumed: the door is about 1 m long

PITCH, ROLL = math.radians(11.8), math.radians(6.27)  # the source's slopes
LEVEL, NOSE_UP, NOSE_DOWN = "level", "nose up", "nose down"
SIDE_UP, SIDE_DOWN, BOTH = "door side up", "door side down", "nose and side up"
ATTITUDES = {
    LEVEL: (0.0, 0.0),
    NOSE_UP: (PITCH, 0.0),
    NOSE_DOWN: (-PITCH, 0.0),
    SIDE_UP: (0.0, ROLL),
    SIDE_DOWN: (0.0, -ROLL),
}
BEYOND = {BOTH: (PITCH, ROLL)}  # not designed for

RATIO = 2.0  # cam's angle per door's angle: 134 deg, less than the 180 deg between the two pins
RADIUS = 0.04  # m, both cams
FRICTION = 0.19  # both contacts; "grease 2" of the paper in the README
HOLD_MARGIN = 1.1  # band over weight
SPRING_RISE = 0.05  # of the preload over the stroke: a soft stack of disc springs
CLOSING_LIMIT = 1.2  # rad/s, 1.2 m/s at the door's edge
PUSH = 60.0 * HANDLE  # N.m, a hand that keeps pushing

# The actuator of the robot's elbow behind another 8:1, of which the last 2:1 is the cam's: 48:1 in all.
GEAR_AFTER = 8.0
MOTOR = AK80_6.behind(GEAR_AFTER)
INERTIA = DOOR_INERTIA + MOTOR.inertia  # kg.m2 about the hinge, rotor included
# The cycle: open in 3 s, hold 4 s, close in 3 s. The latch pulls the door in over the last degree.
MOTION = PickAndPlace(start=math.radians(1.0), end=math.radians(65.0), move=3.0, dwell=4.0)
DURATION = 2.0 * MOTION.move + MOTION.dwell  # s
BANDWIDTH = 2.0  # Hz, both poles of the speed loop, critically damped
MASS_BELIEVED, FRICTION_BELIEVED = 1.03, 0.95  # shares of the truth that the controller believes
HOLD_SPEED = 5e-3  # rad/s
REST_MARGIN = 0.01  # share of the band kept between a held weight and the band's edge

PUSH_TIME = 0.1  # s, duration of a push
PUSHES = (10.0, 15.0, 20.0, 25.0, 30.0, 35.0)  # N.m.s; the last one alone would give the door 3 rad/s
NUDGE, NUDGE_TIMES = 20.0, (0.5, 2.0, 3.5)  # N.m.s, s

BARE, CAM, UNDAMPED = "plain door", "cam", "cam, no damper"


@cache
def weight(attitude: str, mass: float = MASS) -> GravityLoad:
    """The door's weight about its hinge with the car parked like this."""
    return hinged_load(mass, HINGE, CENTRE, up_in_car(*(ATTITUDES | BEYOND)[attitude]))


@dataclass(frozen=True)
class HoldOpen:
    """The cam as the door feels it: by the door's angle [rad], as torque about the hinge, + opens."""

    cam: HelixCam
    orifice: float = 0.0  # N.s2/m2, damper on the follower while the door closes

    def band(self, angle: float) -> tuple[float, float]:
        """The torques [N.m] that just close and just open the door; any between leaves it at rest."""
        release, load = self.cam.band(RATIO * (OPEN - angle))
        return -RATIO * load, -RATIO * release

    @cached_property
    def drag(self) -> float:
        """Torque of the damper over the square of the door's speed while it closes, N.m.s2: N rho_+ q v^2."""
        return RATIO * self.cam.load_arm * self.orifice * (RATIO * self.cam.lift) ** 2

    def torque(self, angle: float, speed: float) -> float:
        """Torque [N.m] that keeps the door moving at `speed` [rad/s]; none at rest."""
        closes, opens = self.band(angle)
        if speed < 0.0:
            return closes - self.drag * speed**2
        return opens if speed > 0.0 else 0.0

    def scaled(self, share: float) -> HoldOpen:
        """With `share` of the spring's force."""
        spring = replace(self.cam, preload=share * self.cam.preload, stiffness=share * self.cam.stiffness)
        return replace(self, cam=spring)

    def parameters(self) -> dict[str, float]:
        """The same as start values of the FMU."""
        return {**self.cam.parameters(), "damper.q_load": self.orifice}


@cache
def extremes() -> tuple[float, float]:
    """Largest closing and largest opening torque of the weight [N.m] over all angles and design attitudes."""
    angles = np.linspace(0.0, OPEN, 200)
    torques = [weight(attitude).torque(angle) for attitude in ATTITUDES for angle in angles]
    return -min(torques), max(torques)


@cache
def design() -> HoldOpen:
    """Lead angle, preload, stiffness and damper by the formulas at the head of this file."""
    closing, opening = extremes()
    sine = math.sin(2.0 * math.atan(FRICTION)) * (closing - opening) / (closing + opening)
    lead = 0.5 * math.asin(sine)
    cam = HelixCam(radius=(RADIUS, RADIUS), lead_angle=(lead, lead), friction=(FRICTION, FRICTION))
    preload = HOLD_MARGIN * closing / (RATIO * cam.load_arm)
    cam = replace(cam, preload=preload, stiffness=SPRING_RISE * preload / stroke(cam))
    excess = PUSH + closing - RATIO * cam.load_arm * preload  # N.m, with the door fully open
    force = excess / (RATIO * cam.load_arm)  # N, of the damper at the limit
    return HoldOpen(cam, orifice=force / (RATIO * cam.lift * CLOSING_LIMIT) ** 2)


def stroke(cam: HelixCam) -> float:
    """Travel of the follower over the door's range, m."""
    return cam.lift * RATIO * OPEN


def doors() -> dict[str, HoldOpen]:
    """What is compared."""
    full = design()
    nothing = replace(full.cam, friction=(0.0, 0.0), preload=0.0, stiffness=0.0)
    return {BARE: HoldOpen(nothing), CAM: full, UNDAMPED: replace(full, orifice=0.0)}


def held_share(hold: HoldOpen, attitudes: Sequence[str] = tuple(ATTITUDES), points: int = 1000) -> float:
    """Share of all angles in these attitudes at which the door stays where it is let go."""
    held = 0
    for attitude in attitudes:
        load = weight(attitude)
        for angle in np.linspace(0.0, OPEN, points):
            closes, opens = hold.band(angle)
            held += closes < load.torque(angle) < opens
    return held / (points * len(attitudes))


def handle_force(hold: HoldOpen, attitudes: Sequence[str]) -> float:
    """Largest force [N] at the handle that moves the door slowly, either way, over all its angles."""
    largest = 0.0
    for attitude in attitudes:
        load = weight(attitude)
        for angle in np.linspace(0.0, OPEN, 100):
            closes, opens = hold.band(angle)
            largest = max(largest, opens - load.torque(angle), load.torque(angle) - closes)
    return largest / HANDLE


class Door:
    """The FMU as a door: its angle and speed, stepped under the torque of motor and hand."""

    def __init__(self, slave: Fmu) -> None:
        self._slave = slave
        self._drive = slave.reals("tau")
        self._sensors = slave.reals("theta", "omega")
        self._accounts = slave.reals(*LEDGER)
        self._reaction = slave.reals("peak.reaction1")
        self.angle = self.speed = 0.0

    def start(self, hold: HoldOpen, load: GravityLoad, angle: float) -> None:
        """At rest at `angle` [rad]."""
        self._load = load
        self._slave.start(
            {
                **hold.parameters(),
                "inertia.shaft": INERTIA / RATIO**2,
                "stop.lower": 0.0,
                "stop.upper": RATIO * OPEN,
                "initial.theta": RATIO * (OPEN - angle),
            }
        )
        self._read()

    def step(self, torque: float, size: float = TICK) -> float:
        """Advance by `size` [s] under this torque [N.m] and the weight; returns the weight's torque.

        Both are held over the step, the weight at the angle that the door reaches at half of it.
        """
        pull = self._load.torque(self.angle + 0.5 * size * self.speed)
        self._drive.values[0] = -(torque + pull) / RATIO
        self._drive.write()
        self._slave.step(size)
        self._read()
        return pull

    def ledger(self) -> np.ndarray:
        """The FMU's accounts since the start, J, in the order of LEDGER; good until the next call."""
        self._accounts.read()
        return self._accounts.values

    def pin_load(self) -> float:
        """Largest normal force at one pin since the start, N."""
        return self._reaction.read()[0]

    def _read(self) -> None:
        theta, omega = self._sensors.read()
        self.angle, self.speed = OPEN - theta / RATIO, -omega / RATIO


class SpeedController:
    """PI on speed with feed-forward; off where the cam holds. All it knows of the door is a model of it."""

    def __init__(self, load: GravityLoad, hold: HoldOpen) -> None:
        self.load = load
        self.hold = hold
        w = 2.0 * math.pi * BANDWIDTH
        self.proportional, self.integral = 2.0 * w, w**2  # 1/s, 1/s2: the poles of s^2 + Kp s + Ki
        self.distance = 0.0  # rad, integral of the error of speed

    def torque(self, angle: float, speed: float, planned: float, then: float) -> float:
        """Motor torque [N.m] for the coming tick; `planned` and `then`: the profile's speed [rad/s] at its
        beginning and end."""
        pull = self.load.torque(angle)
        closes, opens = self.hold.band(angle)
        if planned == then == 0.0 and abs(speed) < HOLD_SPEED and opens > closes:
            self.distance = 0.0
            return holding_torque((closes, opens), pull, REST_MARGIN * (opens - closes))
        mean = 0.5 * (planned + then)
        acceleration = (then - planned) / TICK
        acceleration += self.proportional * (planned - speed) + self.integral * self.distance
        wanted = INERTIA * acceleration + self.hold.torque(angle, mean) - pull
        torque = min(max(wanted, -MOTOR.peak_torque), MOTOR.peak_torque)
        if torque == wanted:  # else the integral would wind up
            self.distance += (mean - speed) * TICK
        return torque


@dataclass(frozen=True)
class Cycle:
    """The motor opens, holds and closes the door. One entry per tick: states at its end, the rest over it."""

    attitude: str
    door: str
    time: np.ndarray  # s
    reference: np.ndarray  # rad
    angle: np.ndarray  # rad
    speed: np.ndarray  # rad/s
    off: np.ndarray  # bool, the motor is switched off
    motor_torque: np.ndarray  # N.m about the hinge, mean of the tick
    peak_torque: np.ndarray  # N.m, largest magnitude within the tick
    motor_heat: np.ndarray  # J
    supply_energy: np.ndarray  # J
    motor_work: np.ndarray  # J, done on the door
    weight_work: np.ndarray  # J, done on the door
    ledger: dict[str, np.ndarray]  # J, since the start
    wall_time: float  # s of the computer's time for all ticks

    @property
    def holding(self) -> slice:
        """The ticks of the second half of the hold."""
        end = MOTION.move + MOTION.dwell
        return slice(round((end - 0.5 * MOTION.dwell) / TICK), round(end / TICK))

    @property
    def hold_power(self) -> float:
        """W from the supply while the door is held open."""
        return float(np.mean(self.supply_energy[self.holding])) / TICK

    @property
    def move_energy(self) -> float:
        """J from the supply for opening and closing, energy given back deducted: the cycle less its hold."""
        return float(np.sum(self.supply_energy)) - self.hold_power * MOTION.dwell

    @property
    def friction_heat(self) -> float:
        """J, both contacts."""
        return float(self.ledger["heat_cam1"][-1] + self.ledger["heat_cam2"][-1])

    @property
    def off_share(self) -> float:
        """Share of the cycle with the motor switched off."""
        return float(np.mean(self.off))

    @property
    def max_error(self) -> float:
        """rad, largest distance from the profile."""
        return float(np.max(np.abs(self.angle - self.reference)))


def drive(door: Door, attitude: str, name: str, hold: HoldOpen) -> Cycle:
    """One cycle of the motor."""
    believed = replace(hold, cam=with_friction(hold.cam, FRICTION_BELIEVED))
    controller = SpeedController(weight(attitude, MASS_BELIEVED * MASS), believed)
    current_loop = CurrentLoop(MOTOR, CURRENT_BANDWIDTH, CURRENT_RATE, TICK)
    ticks = round(DURATION / TICK)
    time = TICK * np.arange(ticks + 1)
    reference, profile = MOTION.sample(MOTION.dwell + time)
    plan = profile.tolist()
    states = np.empty((ticks, 2))
    motor = np.empty((ticks, 5))  # torque, peak, heat, supply energy, command
    work = np.empty((ticks, 2))  # motor, weight
    ledger = np.empty((ticks, len(LEDGER)))

    door.start(hold, weight(attitude), MOTION.start)
    begin = clock.perf_counter()
    for k in range(ticks):
        before = door.angle
        command = controller.torque(before, door.speed, plan[k], plan[k + 1])
        # The winding feels the tick's mean speed; with the first one the energies would differ by O(tick).
        done = current_loop.run(command, door.speed + 0.5 * (plan[k + 1] - plan[k]))
        pull = door.step(done.torque)
        states[k] = door.angle, door.speed
        motor[k] = done.torque, done.peak_torque, done.heat, done.energy, command
        work[k] = done.torque * (door.angle - before), pull * (door.angle - before)
        ledger[k] = door.ledger()
    wall_time = clock.perf_counter() - begin
    return Cycle(
        attitude=attitude,
        door=name,
        time=time[1:],
        reference=reference[1:],
        angle=states[:, 0],
        speed=states[:, 1],
        off=motor[:, 4] == 0.0,
        motor_torque=motor[:, 0],
        peak_torque=motor[:, 1],
        motor_heat=motor[:, 2],
        supply_energy=motor[:, 3],
        motor_work=work[:, 0],
        weight_work=work[:, 1],
        ledger={key.removeprefix("energy."): ledger[:, i] for i, key in enumerate(LEDGER)},
        wall_time=wall_time,
    )


@dataclass(frozen=True)
class Swing:
    """A person closes the door by hand, the motor is off."""

    time: np.ndarray  # s
    angle: np.ndarray  # rad
    speed: np.ndarray  # rad/s
    latch_speed: float  # rad/s with which it reached the stop, 0 if it did not
    pin_load: float  # N, largest normal force at one pin


def pushes(momentum: float, begins: Sequence[float], duration: float) -> np.ndarray:
    """A hand's closing torque by tick [N.m]: short pushes of this momentum [N.m.s] at these times [s]."""
    torque = np.zeros(round(duration / TICK))
    for begin in begins:
        torque[round(begin / TICK) : round((begin + PUSH_TIME) / TICK)] = momentum / PUSH_TIME
    return torque


def swing(door: Door, hold: HoldOpen, attitude: str, hand: np.ndarray) -> Swing:
    """Let go where the motor's opening ends, then close the door by `hand`: torque by tick [N.m].

    The stop takes all the energy that the door has when it gets there: its heat tells the speed.
    """
    door.start(hold, weight(attitude), MOTION.end)
    states = np.empty((len(hand), 2))
    for k, torque in enumerate(hand.tolist()):
        door.step(-torque)
        states[k] = door.angle, door.speed
        if door.angle == 0.0:
            break
    states[k + 1 :] = 0.0  # the latch keeps it
    heat = float(door.ledger()[LEDGER.index("energy.heat_stop")])
    return Swing(
        time=TICK * np.arange(1, len(hand) + 1),
        angle=states[:, 0],
        speed=states[:, 1],
        latch_speed=math.sqrt(2.0 * heat / INERTIA),
        pin_load=door.pin_load(),
    )


@dataclass(frozen=True)
class Results:
    """All runs."""

    cycles: dict[tuple[str, str], Cycle]  # by attitude and door
    slams: dict[tuple[str, str, float], Swing]  # by attitude, door and momentum [N.m.s]
    hands: dict[tuple[str, str], Swing]  # by attitude and door: a hand that keeps pushing
    let_go: dict[str, Swing]  # by door, nose up; the cam's is pushed three times

    @property
    def real_time_factor(self) -> float:
        """Simulated over computing time, all loops of motor cycles, bookkeeping included."""
        return DURATION * len(self.cycles) / sum(cycle.wall_time for cycle in self.cycles.values())


def run(fmu: str | Path) -> Results:
    """All runs."""
    kinds = doors()
    with Fmu(fmu) as slave:
        door = Door(slave)
        cycles = {
            (attitude, name): drive(door, attitude, name, kinds[name])
            for attitude in ATTITUDES | BEYOND
            for name in (BARE, CAM)
        }
        slams = {
            (attitude, name, push): swing(door, kinds[name], attitude, pushes(push, [0.0], 3.0))
            for attitude in (LEVEL, NOSE_UP)
            for name in kinds
            for push in PUSHES
        }
        hands = {
            (attitude, name): swing(door, kinds[name], attitude, np.full(round(8.0 / TICK), PUSH))
            for attitude in ATTITUDES
            for name in kinds
        }
        let_go = {
            BARE: swing(door, kinds[BARE], NOSE_UP, np.zeros(round(5.0 / TICK))),
            CAM: swing(door, kinds[CAM], NOSE_UP, pushes(NUDGE, NUDGE_TIMES, 5.0)),
        }
    return Results(cycles, slams, hands, let_go)


def break_even(results: Results, attitude: str) -> float:
    """Seconds of holding after which the cam's cycle has taken less from the supply than the plain door's."""
    bare, cam = results.cycles[attitude, BARE], results.cycles[attitude, CAM]
    return (cam.move_energy - bare.move_energy) / (bare.hold_power - cam.hold_power)


TRADE_OFF = (0.0, 0.25, 0.5, 0.75, 1.0)  # shares of the spring's force


def table(results: Results) -> str:
    """Design and results as plain text."""
    hold = design()
    cam = hold.cam
    closing, opening = extremes()
    closes, opens = hold.band(OPEN)
    lines = [
        f"Side door of {MASS:.1f} kg, {DOOR_INERTIA:.1f} kg.m2 about a hinge that leans"
        f" {hinge_tilt():.2f} deg; rotor {MOTOR.inertia:.2f} kg.m2 more",
        f"Weight about the hinge, five attitudes: {-closing:.1f} (closes) to {opening:+.1f} N.m (opens)",
        f"Stick band, fully open: {closes:.1f} to {opens:+.1f} N.m",
        f"Cam: radius {RADIUS * 1e3:.0f} mm, lead angle {math.degrees(cam.lead_angle[0]):.2f} deg below the"
        f" angle of friction {math.degrees(math.atan(FRICTION)):.2f} deg; turns {RATIO:.0f}:1 with the door",
        f"Spring: preload {cam.preload:.0f} N, stiffness {cam.stiffness / 1e3:.0f} kN/m, stroke"
        f" {stroke(cam) * 1e3:.2f} mm; damper while closing {hold.drag:.1f} N.m at 1 rad/s",
        "",
        "Spring   holds where let go   both slopes   largest force at the handle [N]",
        " force     (5 attitudes)       at once        level      any of the five",
    ]
    for share in TRADE_OFF:
        less = hold.scaled(share)
        lines.append(
            f"{100 * share:5.0f} % {100 * held_share(less):15.1f} % {100 * held_share(less, [BOTH]):14.1f} %"
            f" {handle_force(less, [LEVEL]):12.1f} {handle_force(less, list(ATTITUDES)):15.1f}"
        )
    lines += [
        "",
        f"Motor cycle: open {MOTION.move:.0f} s, hold {MOTION.dwell:.0f} s, close {MOTION.move:.0f} s;"
        " energy that the motor gives back is deducted",
        "                          from the supply       heat [J]       motor largest  error pays off",
        "                             moves   hold  motor friction damper off  torque        after a",
        "attitude          door         [J]    [W]                        [%]   [N.m] [mrad] hold of [s]",
    ]
    for (attitude, name), cycle in results.cycles.items():
        lines.append(
            f"{attitude:17s} {name:10s} {cycle.move_energy:6.1f} {cycle.hold_power:6.2f}"
            f" {np.sum(cycle.motor_heat):6.1f} {cycle.friction_heat:8.1f}"
            f" {cycle.ledger['heat_damper'][-1]:6.1f} {100 * cycle.off_share:3.0f}"
            f" {np.max(cycle.peak_torque):7.1f} {1e3 * cycle.max_error:6.2f}"
            + (f" {break_even(results, attitude):7.0f}" if name == CAM else "")
        )
    lines += [
        "",
        f"Closed by hand from {math.degrees(MOTION.end):.0f} deg: speed at the latch [rad/s]"
        " (-: stops on the way and stays there)",
        f"                           a push of {PUSH_TIME} s, N.m.s                        kept up,"
        f" {PUSH / HANDLE:.0f} N at",
        "attitude  door            " + " ".join(f"{push:6.0f}" for push in PUSHES) + "        the handle",
    ]
    for attitude in (LEVEL, NOSE_UP):
        for name in (BARE, UNDAMPED, CAM):
            ways = [results.slams[attitude, name, push] for push in PUSHES] + [results.hands[attitude, name]]
            *cells, last = (f"{way.latch_speed:6.2f}" if way.latch_speed else "     -" for way in ways)
            lines.append(f"{attitude:9s} {name:15s} {' '.join(cells)} {last:>12s}")
    return "\n".join(lines)


def hinge_tilt() -> float:
    """Angle between the hinge and the vertical on level ground, deg."""
    axis = HINGE[1] - HINGE[0]
    return math.degrees(math.acos(axis[2] / float(np.linalg.norm(axis))))


def findings(results: Results) -> str:
    """What the tables say, with their numbers, for and against the cam."""
    hold = design()
    bare, cam = results.cycles[NOSE_UP, BARE], results.cycles[NOSE_UP, CAM]
    level, beyond = results.cycles[LEVEL, CAM], results.cycles[BOTH, CAM]
    end = f"{math.degrees(MOTION.end):.0f} deg"
    hardest = PUSHES[-1]
    kept_up = max(results.hands[attitude, CAM].latch_speed for attitude in ATTITUDES)
    fastest = max(float(np.max(-results.hands[attitude, CAM].speed)) for attitude in ATTITUDES)
    greasy = replace(hold, cam=with_friction(hold.cam, 0.9))
    slam = results.slams[NOSE_UP, CAM, hardest]
    helps = [
        f"Let go anywhere in the five attitudes the door stays ({100 * held_share(hold):.0f} % of all"
        f" angles), with the motor off. The plain door, let go nose up at {end}, hits the latch with"
        f" {results.let_go[BARE].latch_speed:.2f} rad/s.",
        f"Held open nose up the plain door takes {bare.hold_power:.1f} W without end, the cam's"
        f" {cam.hold_power:.1f} W. After {break_even(results, NOSE_UP):.0f} s of holding the cam has saved"
        " more than its moves cost.",
        f"A hand that keeps pushing with {PUSH / HANDLE:.0f} N gets at most {fastest:.2f} rad/s out of the"
        f" door on any of the slopes, {kept_up:.2f} at the latch (designed for: {CLOSING_LIMIT} rad/s);"
        f" nose up without the damper {results.hands[NOSE_UP, UNDAMPED].latch_speed:.2f} rad/s. A slam of"
        f" {hardest:.0f} N.m.s nose up does not reach the latch; without the damper it arrives with"
        f" {results.slams[NOSE_UP, UNDAMPED, hardest].latch_speed:.2f} rad/s.",
    ]
    hurts = [
        f"Friction is what holds, and every move pays for it: {level.friction_heat:.0f} J per cycle. On level"
        f" ground the motor takes {level.move_energy:.0f} J to open and close the door,"
        f" {results.cycles[LEVEL, BARE].move_energy:.1f} J without the cam, made up for only after"
        f" {break_even(results, LEVEL) / 60:.0f} min of holding. To save energy on short stops, leave the cam"
        " out.",
        f"Holding on every slope makes the door heavy on level ground: {handle_force(hold, [LEVEL]):.0f} N at"
        f" the handle instead of {handle_force(hold.scaled(0.0), [LEVEL]):.0f} N, and up to"
        f" {handle_force(hold, list(ATTITUDES)):.0f} N on a slope instead of"
        f" {handle_force(hold.scaled(0.0), list(ATTITUDES)):.0f} N. Half the spring's force takes"
        f" {handle_force(hold.scaled(0.5), [LEVEL]):.0f} N and holds at"
        f" {100 * held_share(hold.scaled(0.5)):.0f} % of the angles.",
        "The weight changes its sign with the slope, so the spring can carry little of it: the middle of the"
        f" band is {0.5 * sum(hold.band(OPEN)):.1f} N.m, the weight on level ground"
        f" {weight(LEVEL).torque(OPEN):.1f} to {weight(LEVEL).torque(0.0):.1f} N.m. The cam is a brake first"
        " and a spring second.",
        f"The design lives on its friction: with 10 % less, {100 * held_share(greasy):.1f} % of the angles"
        f" hold. Nose and door side up at once, it is {100 * held_share(hold, [BOTH]):.0f} %; at {end} the"
        f" motor then adds what is missing, {beyond.hold_power:.2f} W instead of"
        f" {results.cycles[BOTH, BARE].hold_power:.1f} W.",
        f"The slam puts {slam.pin_load / 1e3:.1f} kN on each pin, slow closing"
        f" {slow_pin_load(hold) / 1e3:.1f} kN. The stroke is a millimetre: play in the grooves, not modelled,"
        " would eat into it.",
    ]
    return bullets({"Where the cam helps": helps, "Where it hurts": hurts})


def slow_pin_load(hold: HoldOpen) -> float:
    """Normal force at one pin [N], nearly shut and closing slowly: T sqrt(1 + s^2)/(r (s + mu))/2."""
    _, load = hold.cam.band(RATIO * OPEN)
    slope = math.tan(hold.cam.lead_angle[0])
    return 0.5 * load * math.hypot(1.0, slope) / (RADIUS * (slope + FRICTION))


COLOURS = {BARE: "tab:orange", CAM: "tab:blue", UNDAMPED: "tab:green"}
SHADES = {
    LEVEL: "k",
    NOSE_UP: "tab:red",
    NOSE_DOWN: "tab:purple",
    SIDE_UP: "tab:brown",
    SIDE_DOWN: "tab:olive",
}


def picture(results: Results, output: Path) -> None:
    """Save the story as an image."""
    bare, cam = results.cycles[NOSE_UP, BARE], results.cycles[NOSE_UP, CAM]
    figure = Figure(figsize=(13.0, 13.0), layout="constrained")
    axes = figure.subplots(3, 2)
    figure.suptitle(
        f"A car door that stays where it is let go in {len(ATTITUDES)} attitudes, motor off\n"
        f"nose up: {bare.hold_power:.1f} W of holding saved, for"
        f" {cam.move_energy - bare.move_energy:.0f} J more per opening and closing",
        fontsize=14,
    )
    _draw_band(axes[0, 0])
    _draw_trade_off(axes[0, 1])
    _draw_let_go(axes[1, 0], results)
    _draw_closing(axes[1, 1], results)
    _draw_motor(axes[2, 0], bare, cam)
    _draw_energy(axes[2, 1], results)
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def _draw_band(axes: Axes) -> None:
    hold = design()
    angle = np.linspace(0.0, OPEN, 100)
    degrees = np.degrees(angle)
    closes, opens = np.array([hold.band(a) for a in angle]).T
    axes.fill_between(degrees, closes, opens, color=COLOURS[CAM], alpha=0.18, lw=0, label="stick band: stays")
    axes.plot(degrees, closes, color=COLOURS[CAM], lw=1)
    axes.plot(degrees, opens, color=COLOURS[CAM], lw=1)
    for attitude, colour in SHADES.items():
        torque = [weight(attitude).torque(a) for a in angle]
        axes.plot(degrees, torque, color=colour, lw=1.5, label=f"weight, {attitude}")
    torque = [weight(BOTH).torque(a) for a in angle]
    axes.plot(degrees, torque, color="tab:red", ls=":", lw=1.5, label=f"weight, {BOTH} (not designed for)")
    axes.set_title("The weight about the hinge and the cam's stick band")
    axes.set_xlabel("opening of the door [deg]")
    axes.set_ylabel("torque about the hinge, + opens [N.m]")
    axes.set_xlim(0.0, 67.0)
    axes.set_ylim(-50.0, 82.0)
    axes.legend(loc="upper center", fontsize=9, ncols=2)


def _draw_trade_off(axes: Axes) -> None:
    hold = design()
    shares = np.linspace(0.0, 1.3, 27)
    held = [held_share(hold.scaled(share), points=200) for share in shares]
    axes.plot(
        100 * shares, 100 * np.array(held), color="k", lw=2, label="holds, share of angles in 5 attitudes"
    )
    axes.set_title("What holding costs the hand")
    axes.set_xlabel("spring's force [% of the design]")
    axes.set_ylabel("holds where let go [% of the angles]")
    axes.set_xlim(0.0, 130.0)
    axes.set_ylim(0.0, 115.0)
    axes.axvline(100.0, color="0.6", lw=0.8)
    force = axes.twinx()
    force.plot([], [], color="k", lw=2, label="holds, share of angles in 5 attitudes")
    for attitudes, style, name in (([LEVEL], "-", "level"), (list(ATTITUDES), "--", "worst of 5 attitudes")):
        forces = [handle_force(hold.scaled(share), attitudes) for share in shares]
        force.plot(100 * shares, forces, color="tab:red", ls=style, label=f"force at the handle, {name}")
    force.set_ylabel("largest force at the handle [N]", color="tab:red")
    force.set_ylim(0.0, 115.0)
    force.legend(loc="lower right", fontsize=9)


def _draw_let_go(axes: Axes, results: Results) -> None:
    for name, label in ((BARE, "plain door, let go"), (CAM, "cam, pushed three times")):
        way = results.let_go[name]
        axes.plot(way.time, np.degrees(way.angle), color=COLOURS[name], lw=2, label=label)
    for begin in NUDGE_TIMES:
        axes.axvspan(begin, begin + PUSH_TIME, color="0.8", zorder=0)
    axes.set_title(f"Nose up, by hand (grey: push of {NUDGE:.0f} N.m.s)")
    axes.set_xlabel("time [s]")
    axes.set_ylabel("opening of the door [deg]")
    axes.set_xlim(0.0, 5.0)
    axes.set_ylim(-2.0, 75.0)
    axes.legend(loc="upper right", fontsize=9)


def _draw_closing(axes: Axes, results: Results) -> None:
    for name in (BARE, UNDAMPED, CAM):
        slam, hand = results.slams[NOSE_UP, name, PUSHES[-1]], results.hands[NOSE_UP, name]
        for way, style in ((slam, "-"), (hand, "--")):
            moving = way.speed < 0.0
            axes.plot(np.degrees(way.angle[moving]), -way.speed[moving], color=COLOURS[name], ls=style)
        axes.plot([], [], color=COLOURS[name], label=name)
    axes.plot([], [], "k-", label=f"a push of {PUSHES[-1]:.0f} N.m.s")
    axes.plot([], [], "k--", label=f"{PUSH / HANDLE:.0f} N all the way")
    axes.axhline(CLOSING_LIMIT, color="tab:red", ls=":", label="limit of the design")
    axes.set_title("Nose up: speed of closing")
    axes.set_xlabel("opening of the door [deg]")
    axes.set_ylabel("speed of closing [rad/s]")
    axes.set_xlim(67.0, 0.0)
    axes.set_ylim(0.0, 4.6)
    axes.legend(loc="upper left", fontsize=9, ncols=2)


def _draw_motor(axes: Axes, bare: Cycle, cam: Cycle) -> None:
    axes.axvspan(MOTION.move, MOTION.move + MOTION.dwell, color="0.94", zorder=0)
    for cycle in (bare, cam):
        axes.plot(cycle.time, cycle.motor_torque, color=COLOURS[cycle.door], label=f"motor, {cycle.door}")
    for sign in (-1.0, 1.0):
        axes.axhline(sign * MOTOR.peak_torque, color="tab:red", ls="--", lw=0.9)
        axes.axhline(sign * MOTOR.rated_torque, color="tab:red", ls=":", lw=0.9)
    axes.text(9.9, MOTOR.peak_torque - 1.0, "motor's peak", color="tab:red", fontsize=9, ha="right", va="top")
    axes.text(9.9, MOTOR.rated_torque + 1.0, "motor's rating", color="tab:red", fontsize=9, ha="right")
    axes.text(MOTION.move + 0.5 * MOTION.dwell, 3.0, "cam: motor off", color=COLOURS[CAM], ha="center")
    axes.plot(cam.time, np.degrees(cam.angle), "k:", lw=1.2, label="opening of the door [deg]")
    axes.set_title("Nose up: opened, held and closed by the motor")
    axes.set_xlabel("time [s] (grey: hold)")
    axes.set_ylabel("torque about the hinge, + opens [N.m]")
    axes.set_xlim(0.0, DURATION)
    axes.set_ylim(-110.0, 150.0)
    axes.legend(loc="upper right", fontsize=9, ncols=3)


def _draw_energy(axes: Axes, results: Results) -> None:
    held = np.array([0.0, 100.0])
    for attitude in (LEVEL, NOSE_UP, NOSE_DOWN, SIDE_UP):
        for name, style in ((BARE, "--"), (CAM, "-")):
            cycle = results.cycles[attitude, name]
            axes.plot(held, cycle.move_energy + cycle.hold_power * held, ls=style, color=SHADES[attitude])
        axes.plot([], [], color=SHADES[attitude], label=attitude)
        if (pays := break_even(results, attitude)) < held[1]:
            axes.plot(pays, results.cycles[attitude, CAM].move_energy, "o", color=SHADES[attitude])
    axes.plot([], [], "k--", label="plain door")
    axes.plot([], [], "k-", label="cam (dot: pays off)")
    axes.set_title("Energy from the supply per opening and closing")
    axes.set_xlabel("time for which the door is held open [s]")
    axes.set_ylabel("energy [J]")
    axes.set_xlim(0.0, held[1])
    axes.set_ylim(0.0, 350.0)
    axes.legend(loc=(0.44, 0.09), fontsize=9, ncols=2)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    fmu, output = command_line(__doc__, "car_door.png", arguments)
    results = run(fmu)
    print(table(results))
    print()
    print(findings(results))
    print(f"\nReal-time factor of the 1 kHz loop: {results.real_time_factor:.0f}")
    picture(results, output)
    print(f"Picture: {output}")


if __name__ == "__main__":
    main()
