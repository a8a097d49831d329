"""Can a dual cam hold a car's side door wherever it is let go, on every slope, with the motor off?

A passenger's door of 36 kg hangs on a hinge that leans 2 deg. With the car parked nose up the weight pulls
the door shut with up to 36 N.m, nose down it pulls the door open with up to 28 N.m. A dual cam beside the
hinge holds the door: its stick band contains the weight at every angle in every attitude. A hydraulic damper
on the cam's follower limits the speed of closing. A small geared motor opens and closes the door. The same
door without cam and damper is the comparison: there the motor must hold the door.

    J a'' = motor + weight(a) + hand + N T_cam
    T_cam = T_load + damper while it closes, T_release < 0 while it opens, any torque between them at rest

Both doors are the same FMU (`DualCamForward`) in the same loop. Without the cam the spring, the friction and
the damper are zero, and an inertia remains. The door's angle a is 0 closed and 67 deg open. A torque about
the hinge is + if it opens the door. The cam turns N = 2 times as far as the door, and loads its spring while
the door closes.

Why closing loads the spring. First, on level ground the door falls shut, and the spring pushes against that:
the middle of the band lies near the weight on level ground. Second, the weight changes its sign with the
attitude, so the band must reach below zero. Then both contacts lock themselves (lead angle below the angle of
friction), and in a locked cam a damper on the follower brakes only while the spring is loaded.

Design: dualcam.systems.machines.car_door.design. The price: a band that holds 36 N.m on a slope also resists
the hand and the motor on level ground. The first table weighs one against the other.

Loops: current PI at 20 kHz; PI on speed at 1 kHz along a profile of minimum jerk, with feed-forward of
inertia, weight, friction and damper, the weight from a tilt sensor. When the profile has ended and the weight
lies inside the stick band, the motor is off. Else the motor adds only the missing torque.

Left out, in all cases alike: losses of gear and hinge, the latch (the motor's cycle ends 1 deg before it),
the air that the cabin must let out, the seal, wind, the drive's own consumption, the follower's mass.

Copy this file for an own system. Closing by hand, findings and more pictures: case_studies/car_door.py.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dualcam import Fmu
from dualcam.systems.blocks.axis import simulate_closed_loop
from dualcam.systems.blocks.current_loop import CurrentLoop
from dualcam.systems.machines import car_door
from dualcam.systems.machines.car_door import (
    ATTITUDES,
    ATTITUDES_NOT_DESIGNED_FOR,
    BOTH,
    LEVEL,
    MOTION,
    MOTOR,
    NOSE_UP,
    OPEN,
    MotorCycle,
)

BUILD = Path(__file__).resolve().parent.parent / "build"
BARE, CAM = "plain door", "cam"
COLOURS = {BARE: "tab:orange", CAM: "tab:blue"}
SPRING_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
Results = dict[tuple[str, str], MotorCycle]  # by attitude and door


# ---- plant, controller, run ----


def run(path: str | Path) -> Results:
    """The motor opens, holds and closes both doors in all attitudes, with the FMU at that path."""
    results = {}
    with Fmu(path) as fmu:
        axis = car_door.door_axis(fmu)
        for attitude in ATTITUDES | ATTITUDES_NOT_DESIGNED_FOR:
            for door, cam in ((BARE, car_door.plain_door()), (CAM, car_door.design())):
                axis.start(car_door.plant_parameters(cam), angle=MOTION.start)
                controller = car_door.controller(cam, attitude)
                load, loop = car_door.weight(attitude), CurrentLoop(MOTOR)
                record = simulate_closed_loop(
                    axis, load, controller, loop, car_door.reference_motion(), mean_speed=True
                )
                results[attitude, door] = MotorCycle(record)
    return results


# ---- results ----


def design_table() -> list[str]:
    """The load and the cam's design."""
    door = car_door.design()
    closing, opening = car_door.extreme_weight_torques()
    closes, opens = door.band(OPEN)
    lead, friction_angle = math.degrees(door.cam.lead_angle[0]), math.degrees(math.atan(car_door.FRICTION))
    return [
        f"Side door of {car_door.MASS:.1f} kg, {car_door.DOOR_INERTIA:.1f} kg.m2 about a hinge that leans"
        f" {car_door.hinge_tilt():.2f} deg; rotor {MOTOR.inertia:.2f} kg.m2 more",
        f"Weight about the hinge, five attitudes: {-closing:.1f} (closes) to {opening:+.1f} N.m (opens)",
        f"Stick band, fully open: {closes:.1f} to {opens:+.1f} N.m",
        f"Cam: radius {car_door.RADIUS * 1e3:.0f} mm, lead angle {lead:.2f} deg below the angle of friction"
        f" {friction_angle:.2f} deg; turns {car_door.RATIO:.0f}:1 with the door",
        f"Spring: preload {door.cam.preload:.0f} N, stiffness {door.cam.stiffness / 1e3:.0f} kN/m, stroke"
        f" {car_door.stroke(door.cam) * 1e3:.2f} mm; damper while closing {door.damping:.1f} N.m at 1 rad/s",
    ]


def trade_off_table() -> list[str]:
    """What holding costs the hand, by share of the spring's force."""
    lines = [
        "Spring   holds where let go   both slopes   largest force at the handle [N]",
        " force     (5 attitudes)       at once        level      any of the five",
    ]
    for share in SPRING_SHARES:
        door = car_door.design().with_spring_force(share)
        lines.append(
            f"{100 * share:5.0f} % {100 * car_door.share_of_angles_held(door):15.1f} %"
            f" {100 * car_door.share_of_angles_held(door, [BOTH]):14.1f} %"
            f" {car_door.handle_force(door, [LEVEL]):12.1f}"
            f" {car_door.handle_force(door, list(ATTITUDES)):15.1f}"
        )
    return lines


def result_table(results: Results) -> list[str]:
    """The motor's cycles."""
    lines = [
        f"Motor cycle: open {MOTION.move:.0f} s, hold {MOTION.dwell:.0f} s, close {MOTION.move:.0f} s;"
        " energy that the motor gives back is deducted",
        "                          from the supply       heat [J]       motor largest  error pays off",
        "                             moves   hold  motor friction damper off  torque        after a",
        "attitude          door         [J]    [W]                        [%]   [N.m] [mrad] hold of [s]",
    ]
    for (attitude, door), cycle in results.items():
        record = cycle.record
        pays_off = car_door.break_even(results[attitude, BARE], cycle) if door == CAM else None
        lines.append(
            f"{attitude:17s} {door:10s} {cycle.move_energy:6.1f} {cycle.hold_power:6.2f}"
            f" {record.heat:6.1f} {record.friction_heat:8.1f} {record.ledger['heat_damper'][-1]:6.1f}"
            f" {100 * cycle.motor_off_share:3.0f} {record.largest_torque:7.1f} {1e3 * record.max_error:6.2f}"
            + ("" if pays_off is None else f" {pays_off:7.0f}")
        )
    return lines


# ---- picture ----


def picture(results: Results, output: Path) -> None:
    """Save band, motor torque and energy as an image."""
    figure = Figure(figsize=(13.0, 4.5), layout="constrained")
    band, torque, energy = figure.subplots(1, 3)
    draw_band(band)
    draw_torque(torque, results)
    draw_energy(energy, results)
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def draw_band(axes: Axes) -> None:
    """The stick band and the weight by attitude, over the door's angle."""
    angle = np.linspace(0.0, OPEN, 100)
    closes, opens = np.array([car_door.design().band(a) for a in angle]).T
    axes.fill_between(np.degrees(angle), closes, opens, color=COLOURS[CAM], alpha=0.25, label="stick band")
    for attitude in ATTITUDES:
        axes.plot(np.degrees(angle), [car_door.weight(attitude).torque(a) for a in angle], label=attitude)
    axes.set(title="The weight inside the stick band", xlabel="opening of the door [deg]")
    axes.set(ylabel="torque about the hinge, + opens [N.m]", xlim=(0.0, 67.0), ylim=(-50.0, 75.0))
    axes.legend(loc="upper left", fontsize=9, ncols=2)


def draw_torque(axes: Axes, results: Results) -> None:
    """The motor's torque, nose up."""
    for door in (BARE, CAM):
        record = results[NOSE_UP, door].record
        axes.plot(record.time, record.motor_torque, color=COLOURS[door], label=door)
    axes.axvspan(MOTION.move, MOTION.move + MOTION.dwell, color="0.94", zorder=0)
    axes.set(title="Motor torque, nose up (grey: hold)", xlabel="time [s]", xlim=(0.0, car_door.DURATION))
    axes.set(ylabel="torque about the hinge, + opens [N.m]")
    axes.legend(loc="upper right", fontsize=9)


def draw_energy(axes: Axes, results: Results) -> None:
    """Energy from the supply by time of holding, nose up."""
    held = np.array([0.0, 30.0])
    for door in (BARE, CAM):
        cycle = results[NOSE_UP, door]
        axes.plot(held, cycle.move_energy + cycle.hold_power * held, color=COLOURS[door], label=door)
    axes.set(title="Energy from the supply, nose up", xlabel="time held open [s]", ylabel="energy [J]")
    axes.set(xlim=(0.0, 30.0), ylim=(0.0, None))
    axes.legend(loc="lower right", fontsize=9)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--fmu", type=Path, default=BUILD / "DualCamForward.fmu")
    parser.add_argument("--output", type=Path, default=BUILD / "car_door.png", help="picture to write")
    options = parser.parse_args(arguments)
    results = run(options.fmu)
    print("\n".join([*design_table(), "", *trade_off_table(), "", *result_table(results)]))
    picture(results, options.output)
    print(f"\nPicture: {options.output}")


if __name__ == "__main__":
    main()
