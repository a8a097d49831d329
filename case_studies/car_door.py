"""The car door in more detail: closing by hand with and without the damper, findings, and a picture.

    python -m case_studies.car_door

The door is the one of dualcam.systems.machines.car_door. Equations and the tables of design and motor cycles
are those of system_examples/car_door.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from case_studies.command_line import bullets, parse
from dualcam import Fmu
from dualcam.design.statics import sign_of, transfer
from dualcam.systems.blocks.axis import CamAxis, simulate_closed_loop
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD as STEP
from dualcam.systems.blocks.current_loop import CurrentLoop
from dualcam.systems.blocks.record import LEDGER
from dualcam.systems.machines import car_door
from dualcam.systems.machines.car_door import (
    ATTITUDES,
    ATTITUDES_NOT_DESIGNED_FOR,
    BOTH,
    CLOSING_LIMIT,
    DURATION,
    HANDLE,
    INERTIA,
    LEVEL,
    MOTION,
    MOTOR,
    NOSE_DOWN,
    NOSE_UP,
    OPEN,
    PUSH,
    RADIUS,
    SIDE_DOWN,
    SIDE_UP,
    DoorCam,
    MotorCycle,
    break_even,
    design,
    handle_force,
    plain_door,
    share_of_angles_held,
    weight,
)

BARE, CAM, UNDAMPED = "plain door", "cam", "cam, no damper"
PUSH_TIME = 0.1  # s, duration of a push
PUSHES = (10.0, 15.0, 20.0, 25.0, 30.0, 35.0)  # N.m.s; the last one alone would give the door 3 rad/s
NUDGE, NUDGE_TIMES = 20.0, (0.5, 2.0, 3.5)  # N.m.s, s


@dataclass(frozen=True)
class Closing:
    """A person closes the door by hand, the motor is off. Arrays have shape (n,), one entry per step."""

    time: np.ndarray  # s
    angle: np.ndarray  # rad
    speed: np.ndarray  # rad/s
    latch_speed: float  # rad/s at the stop, 0 if the door did not reach the stop
    pin_load: float  # N, largest normal force at one pin


def pushes(momentum: float, begins: Sequence[float], duration: float) -> np.ndarray:
    """A hand's closing torque by step [N.m]: short pushes of this momentum [N.m.s] at these times [s]."""
    torque = np.zeros(round(duration / STEP))
    for begin in begins:
        torque[round(begin / STEP) : round((begin + PUSH_TIME) / STEP)] = momentum / PUSH_TIME
    return torque


def close_by_hand(axis: CamAxis, cam: DoorCam, attitude: str, hand: np.ndarray) -> Closing:
    """Let go where the motor's opening ends, then close the door by `hand`, a torque by step [N.m].

    The stop takes all the energy that the door has there, so the stop's heat gives the speed.
    """
    axis.start(car_door.plant_parameters(cam), MOTION.end)
    states = np.empty((len(hand), 2))
    for k, torque in enumerate(hand.tolist()):
        axis.step(-torque, weight(attitude), STEP)
        states[k] = axis.angle, axis.speed
        if axis.angle == 0.0:
            break
    states[k + 1 :] = 0.0  # the latch keeps the door
    heat = float(axis.ledger()[LEDGER.index("heat_stop")])
    return Closing(
        time=STEP * np.arange(1, len(hand) + 1),
        angle=states[:, 0],
        speed=states[:, 1],
        latch_speed=math.sqrt(2.0 * heat / INERTIA),
        pin_load=axis.largest_pin_force(),
    )


@dataclass(frozen=True)
class Results:
    """All runs."""

    cycles: dict[tuple[str, str], MotorCycle]  # by attitude and door
    slams: dict[tuple[str, str, float], Closing]  # by attitude, door and momentum [N.m.s]
    hands: dict[tuple[str, str], Closing]  # by attitude and door: a hand that keeps pushing
    let_go: dict[str, Closing]  # by door, nose up; the door with the cam is pushed three times

    @property
    def real_time_factor(self) -> float:
        """Simulated over computing time, all loops of motor cycles with their bookkeeping."""
        return DURATION * len(self.cycles) / sum(cycle.record.wall_time for cycle in self.cycles.values())


def doors() -> dict[str, DoorCam]:
    """The doors to compare."""
    return {BARE: plain_door(), CAM: design(), UNDAMPED: replace(design(), orifice=0.0)}


def motor_cycle(axis: CamAxis, cam: DoorCam, attitude: str) -> MotorCycle:
    """The motor opens, holds and closes the door."""
    axis.start(car_door.plant_parameters(cam), MOTION.start)
    controller, loop = car_door.controller(cam, attitude), CurrentLoop(MOTOR)
    return MotorCycle(
        simulate_closed_loop(
            axis, weight(attitude), controller, loop, car_door.reference_motion(), mean_speed=True
        )
    )


def run(path: str | Path) -> Results:
    """All runs with the FMU at that path."""
    kinds = doors()
    with Fmu(path) as fmu:
        axis = car_door.door_axis(fmu)
        cycles = {
            (attitude, name): motor_cycle(axis, kinds[name], attitude)
            for attitude in ATTITUDES | ATTITUDES_NOT_DESIGNED_FOR
            for name in (BARE, CAM)
        }
        slams = {
            (attitude, name, push): close_by_hand(axis, kinds[name], attitude, pushes(push, [0.0], 3.0))
            for attitude in (LEVEL, NOSE_UP)
            for name in kinds
            for push in PUSHES
        }
        hands = {
            (attitude, name): close_by_hand(axis, kinds[name], attitude, np.full(round(8.0 / STEP), PUSH))
            for attitude in ATTITUDES
            for name in kinds
        }
        let_go = {
            BARE: close_by_hand(axis, kinds[BARE], NOSE_UP, np.zeros(round(5.0 / STEP))),
            CAM: close_by_hand(axis, kinds[CAM], NOSE_UP, pushes(NUDGE, NUDGE_TIMES, 5.0)),
        }
    return Results(cycles, slams, hands, let_go)


def pays_off(results: Results, attitude: str) -> float:
    """Seconds of holding after which the cam has saved what its moves cost."""
    return break_even(results.cycles[attitude, BARE], results.cycles[attitude, CAM])


def hand_table(results: Results) -> str:
    """Speed at the latch of doors that are closed by hand."""
    lines = [
        f"Closed by hand from {math.degrees(MOTION.end):.0f} deg: speed at the latch [rad/s]"
        " (-: stops on the way and stays there)",
        f"                           a push of {PUSH_TIME} s, N.m.s                        kept up,"
        f" {PUSH / HANDLE:.0f} N at",
        "attitude  door            " + " ".join(f"{push:6.0f}" for push in PUSHES) + "        the handle",
    ]
    for attitude in (LEVEL, NOSE_UP):
        for name in (BARE, UNDAMPED, CAM):
            runs = [results.slams[attitude, name, push] for push in PUSHES] + [results.hands[attitude, name]]
            *cells, last = (f"{run.latch_speed:6.2f}" if run.latch_speed else "     -" for run in runs)
            lines.append(f"{attitude:9s} {name:15s} {' '.join(cells)} {last:>12s}")
    return "\n".join(lines)


def findings(results: Results) -> str:
    """What the tables say, with their numbers, for and against the cam."""
    hold = design()
    bare, cam = results.cycles[NOSE_UP, BARE], results.cycles[NOSE_UP, CAM]
    level, beyond = results.cycles[LEVEL, CAM], results.cycles[BOTH, CAM]
    end = f"{math.degrees(MOTION.end):.0f} deg"
    hardest = PUSHES[-1]
    kept_up = max(results.hands[attitude, CAM].latch_speed for attitude in ATTITUDES)
    fastest = max(float(np.max(-results.hands[attitude, CAM].speed)) for attitude in ATTITUDES)
    greasy = replace(hold, cam=hold.cam.with_friction_scaled(0.9))
    slam = results.slams[NOSE_UP, CAM, hardest]
    helps = [
        f"Let go anywhere in the five attitudes the door stays ({100 * share_of_angles_held(hold):.0f} % of"
        f" all angles), with the motor off. The plain door, let go nose up at {end}, hits the latch with"
        f" {results.let_go[BARE].latch_speed:.2f} rad/s.",
        f"Held open nose up the plain door takes {bare.hold_power:.1f} W without end, the cam's"
        f" {cam.hold_power:.1f} W. After {pays_off(results, NOSE_UP):.0f} s of holding the cam has saved"
        " more than its moves cost.",
        f"A hand that keeps pushing with {PUSH / HANDLE:.0f} N gets at most {fastest:.2f} rad/s out of the"
        f" door on any of the slopes, {kept_up:.2f} at the latch (designed for: {CLOSING_LIMIT} rad/s);"
        f" nose up without the damper {results.hands[NOSE_UP, UNDAMPED].latch_speed:.2f} rad/s. A slam of"
        f" {hardest:.0f} N.m.s nose up does not reach the latch; without the damper it arrives with"
        f" {results.slams[NOSE_UP, UNDAMPED, hardest].latch_speed:.2f} rad/s.",
    ]
    hurts = [
        f"Friction is what holds, and every move pays for it: {level.record.friction_heat:.0f} J per cycle."
        f" On level ground the motor takes {level.move_energy:.0f} J to open and close the door,"
        f" {results.cycles[LEVEL, BARE].move_energy:.1f} J without the cam, made up for only after"
        f" {pays_off(results, LEVEL) / 60:.0f} min of holding. To save energy on short stops, leave the cam"
        " out.",
        f"Holding on every slope makes the door heavy on level ground: {handle_force(hold, [LEVEL]):.0f} N at"
        f" the handle instead of {handle_force(hold.with_spring_force(0.0), [LEVEL]):.0f} N, and up to"
        f" {handle_force(hold, list(ATTITUDES)):.0f} N on a slope instead of"
        f" {handle_force(hold.with_spring_force(0.0), list(ATTITUDES)):.0f} N. Half the spring's force takes"
        f" {handle_force(hold.with_spring_force(0.5), [LEVEL]):.0f} N and holds at"
        f" {100 * share_of_angles_held(hold.with_spring_force(0.5)):.0f} % of the angles.",
        "The weight changes its sign with the slope, so the spring can carry little of it: the middle of the"
        f" band is {0.5 * sum(hold.band(OPEN)):.1f} N.m, the weight on level ground"
        f" {weight(LEVEL).torque(OPEN):.1f} to {weight(LEVEL).torque(0.0):.1f} N.m. The cam is a brake first"
        " and a spring second.",
        f"The design lives on its friction: with 10 % less, {100 * share_of_angles_held(greasy):.1f} % of the"
        " angles hold. Nose and door side up at once, it is"
        f" {100 * share_of_angles_held(hold, [BOTH]):.0f} %; at {end} the"
        f" motor then adds what is missing, {beyond.hold_power:.2f} W instead of"
        f" {results.cycles[BOTH, BARE].hold_power:.1f} W.",
        f"The slam puts {slam.pin_load / 1e3:.1f} kN on each pin, slow closing"
        f" {slow_pin_load(hold) / 1e3:.1f} kN. The stroke is a millimetre: play in the grooves, not modelled,"
        " would eat into it.",
    ]
    return bullets({"Where the cam helps": helps, "Where it hurts": hurts})


def slow_pin_load(hold: DoorCam) -> float:
    """Normal force at one of two pins [N], nearly shut and closing slowly."""
    cam = hold.cam
    force = cam.preload + cam.stiffness * car_door.stroke(cam)  # N, of the spring
    slope = RADIUS * math.tan(cam.lead_angle[0])
    reaction = transfer((slope, slope), cam.friction, cam.radius, sign_of("loading")).reaction[0]
    return 0.5 * force * float(reaction)


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
    held = [share_of_angles_held(hold.with_spring_force(share), points=200) for share in shares]
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
        forces = [handle_force(hold.with_spring_force(share), attitudes) for share in shares]
        force.plot(100 * shares, forces, color="tab:red", ls=style, label=f"force at the handle, {name}")
    force.set_ylabel("largest force at the handle [N]", color="tab:red")
    force.set_ylim(0.0, 115.0)
    force.legend(loc="lower right", fontsize=9)


def _draw_let_go(axes: Axes, results: Results) -> None:
    for name, label in ((BARE, "plain door, let go"), (CAM, "cam, pushed three times")):
        closing = results.let_go[name]
        axes.plot(closing.time, np.degrees(closing.angle), color=COLOURS[name], lw=2, label=label)
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
        for closing, style in ((slam, "-"), (hand, "--")):
            moving = closing.speed < 0.0
            axes.plot(
                np.degrees(closing.angle[moving]), -closing.speed[moving], color=COLOURS[name], ls=style
            )
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


def _draw_motor(axes: Axes, bare: MotorCycle, cam: MotorCycle) -> None:
    axes.axvspan(MOTION.move, MOTION.move + MOTION.dwell, color="0.94", zorder=0)
    for door, cycle in ((BARE, bare), (CAM, cam)):
        torque = cycle.record.motor_torque
        axes.plot(cycle.record.time, torque, color=COLOURS[door], label=f"motor, {door}")
    for sign in (-1.0, 1.0):
        axes.axhline(sign * MOTOR.peak_torque, color="tab:red", ls="--", lw=0.9)
        axes.axhline(sign * MOTOR.rated_torque, color="tab:red", ls=":", lw=0.9)
    axes.text(9.9, MOTOR.peak_torque - 1.0, "motor's peak", color="tab:red", fontsize=9, ha="right", va="top")
    axes.text(9.9, MOTOR.rated_torque + 1.0, "motor's rating", color="tab:red", fontsize=9, ha="right")
    axes.text(MOTION.move + 0.5 * MOTION.dwell, 3.0, "cam: motor off", color=COLOURS[CAM], ha="center")
    axes.plot(cam.record.time, np.degrees(cam.record.angle), "k:", lw=1.2, label="opening of the door [deg]")
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
        if (pays := pays_off(results, attitude)) < held[1]:
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
    options = parse(__doc__, "car_door_report.png", arguments)
    results = run(options.fmu)
    print(hand_table(results))
    print()
    print(findings(results))
    print(f"\nReal-time factor of the 1 kHz loop: {results.real_time_factor:.0f}")
    picture(results, options.output)
    print(f"Picture: {options.output}")


if __name__ == "__main__":
    main()
