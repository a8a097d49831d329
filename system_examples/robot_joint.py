"""How much motor heat does the dual cam save in a robot's elbow, and what does its friction cost?

The elbow of a UR3e, driven by a 12 N.m actuator, moves 0, 1.5 and 3 kg through a pick-and-place cycle.
Without the cam the motor carries the arm's weight, also while nothing moves. With the cam a spring carries
most of it.

    M alpha = tau_motor + tau_gravity(theta) - T_cam
    T_cam = T_load while the arm drops, T_release while it rises, any torque between them at rest

Both joints are the same FMU (`DualCamForward`) in the same loop. Without the cam the spring's force is zero,
so the contacts carry no force, and an inertia remains.

Loops, from the inside:
  current    PI at 20 kHz. L/R is 0.34 ms, so at 1 kHz the current would settle within one sample
  torque     the FMU receives the motor's mean torque plus gravity at the middle of the control period of 1 ms
  position   LQI at 1 kHz with feed-forward of inertia, gravity and cam torque. The controller believes
             0.1 kg too much payload and 10 % too little friction. Without such errors feed-forward alone
             would be perfect. The case "cam, friction unknown" takes the cam for frictionless

Left out, in all cases alike: friction and backlash of the gear, the encoder's resolution, losses and delay of
the drive, the follower's mass. So the joint without the cam has no friction at all.

Copy this file for an own system: the load, the motion, the motor and the controller are blocks of
dualcam.systems (here put together in dualcam.systems.machines.elbow).
"""

from __future__ import annotations

import argparse
import math
import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dualcam import Fmu
from dualcam.systems.blocks.axis import CamAxis, simulate_closed_loop
from dualcam.systems.blocks.current_loop import CurrentLoop
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.machines import elbow
from dualcam.systems.machines.elbow import DESIGN_PAYLOAD, MOTION, NO_CAM, RANGE, Cycle

BUILD = Path(__file__).resolve().parent.parent / "build"
PAYLOADS = (0.0, 1.5, 3.0)  # kg; a UR3e carries 3 kg
BARE, CAM, NAIVE = "no cam", "cam", "cam, friction unknown"
COLOURS = {BARE: "tab:orange", CAM: "tab:blue", NAIVE: "0.6"}


# ---- plant, controller, run ----


def simulate(fmu: Fmu, payload: float, joint: str) -> Cycle:
    """Run `joint` (BARE, CAM or NAIVE) with `payload` [kg] through the motion."""
    cam = NO_CAM if joint == BARE else elbow.design_cam()
    friction = 0.0 if joint == NAIVE else elbow.FRICTION_BELIEVED
    axis = CamAxis(fmu)
    axis.start(elbow.plant_parameters(cam, payload), angle=MOTION.start)
    controller = elbow.controller(cam, payload, friction)
    record = simulate_closed_loop(
        axis, elbow.weight(payload), controller, CurrentLoop(AK80_6), elbow.reference_motion()
    )
    return Cycle(payload, joint, record)


def run(path: str | Path) -> dict[tuple[float, str], Cycle]:
    """All cases with the FMU at that path, by payload [kg] and joint."""
    cases = [(payload, joint) for payload in PAYLOADS for joint in (BARE, CAM)]
    with Fmu(path) as fmu:
        return {case: simulate(fmu, *case) for case in [*cases, (DESIGN_PAYLOAD, NAIVE)]}


# ---- results ----


def design_table() -> list[str]:
    """The cam's design, and the load by payload."""
    cam = elbow.design_cam()
    angles = np.linspace(0.0, RANGE, 200)
    middle = np.array([0.5 * sum(cam.band(angle)) for angle in angles])
    carried = np.array([elbow.weight(DESIGN_PAYLOAD).torque(angle) for angle in angles])
    release, load = cam.band(RANGE)
    lines = [
        f"Spring for {DESIGN_PAYLOAD} kg: preload {cam.preload:.0f} N,"
        f" stiffness {cam.stiffness / 1e3:.1f} kN/m, stroke {cam.dz_dtheta * RANGE * 1e3:.1f} mm",
        f"Efficiency {cam.efficiency:.4f}; stick band +-{100 * cam.relative_half_band:.1f} % of its middle,"
        f" {release:.1f} to {load:.1f} N.m with the arm horizontal",
        "Gravity is concave in the angle, the middle straight: they differ by up to"
        f" {100 * np.max(np.abs(carried / middle - 1.0)):.1f} %",
        "",
        "payload  gravity, horizontal  inertia with rotor",
        "     kg                  N.m               kg.m2",
    ]
    for payload in PAYLOADS:
        torque, inertia = elbow.horizontal_torque(payload), elbow.inertia(payload)
        lines.append(f"{payload:7.1f} {torque:20.2f} {inertia:19.3f}")
    return lines


def result_table(results: dict[tuple[float, str], Cycle]) -> list[str]:
    """The last cycle of every case."""
    lines = [
        "                                  RMS   motor heat [J]  friction supply  peak   hold  error [mrad]",
        "payload  joint                    [A]   move  hold total   [J]     [J]   [N.m]   [A]    RMS    max",
    ]
    for cycle in sorted(results.values(), key=lambda cycle: cycle.payload):
        head = f"{cycle.payload:4.1f} kg  {cycle.joint:21s}"
        if not cycle.lifts:
            lines.append(
                f"{head} does not lift: gravity is {elbow.horizontal_torque(cycle.payload):.1f} N.m,"
                f" the motor's peak {AK80_6.peak_torque:.1f} N.m"
            )
            continue
        moving, total = cycle.joule_heat_moving, cycle.joule_heat
        lines.append(
            f"{head} {cycle.rms_current:5.2f} {moving:6.1f} {total - moving:5.1f} {total:5.1f}"
            f" {cycle.friction_heat:6.2f} {cycle.electric_energy:7.1f} {cycle.largest_torque:7.2f}"
            f" {cycle.hold_current:6.2f} {1e3 * cycle.rms_error:6.2f} {1e3 * cycle.max_error:6.2f}"
        )
    return lines


def findings(results: dict[tuple[float, str], Cycle]) -> list[str]:
    """The tables in words, for and against the cam."""
    bare, cam, naive = (results[DESIGN_PAYLOAD, joint] for joint in (BARE, CAM, NAIVE))
    empty_bare, empty_cam = results[0.0, BARE], results[0.0, CAM]
    helix, load = elbow.design_cam(), elbow.weight(DESIGN_PAYLOAD)
    rated = AK80_6.rated_torque / AK80_6.output_constant
    helps = [
        f"At {DESIGN_PAYLOAD} kg the motor's heat falls from {bare.joule_heat:.0f} to"
        f" {cam.joule_heat:.0f} J per cycle. Without the cam the RMS current, {bare.rms_current:.1f} A, is"
        f" above the rated {rated:.1f} A: the motor would overheat.",
        f"Holding is free at {DESIGN_PAYLOAD} kg, because gravity lies inside the stick band:"
        f" {cam.hold_current:.2f} A against {bare.hold_current:.1f} A with the arm horizontal.",
        f"The motor's {AK80_6.peak_torque:.0f} N.m do not hold 3 kg ({elbow.horizontal_torque(3.0):.1f} N.m)."
        " With the cam they lift it.",
    ]
    hurts = [
        f"Friction turns {cam.friction_heat:.2f} J per cycle into heat, whatever the payload; the area of the"
        f" band over the travel is {elbow.friction_heat_of_slow_cycle(helix):.2f} J."
        " The arm's weight gives and takes"
        f" {load.energy(MOTION.start) - load.energy(MOTION.end):.1f} J."
        " Without the cam, in this model, only the motor loses energy.",
        f"Moving costs {100 * helix.relative_half_band:.1f} % of the carried torque, in both directions."
        " Moving slowly, the motor runs cooler with the cam only where gravity is above"
        f" {50 * (1 + helix.relative_half_band**2):.0f} % of the band's middle.",
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
    wrapper = textwrap.TextWrapper(105, initial_indent="- ", subsequent_indent="  ")
    points = {"Where the cam helps": helps, "Where it hurts": hurts}
    return [line for title in points for line in (title, *map(wrapper.fill, points[title]))]


# ---- picture ----


def picture(results: dict[tuple[float, str], Cycle], output: Path) -> None:
    """Save the comparison as an image."""
    figure = Figure(figsize=(13.0, 4.5), layout="constrained")
    statics, torque, heat = figure.subplots(1, 3)
    draw_statics(statics)
    draw_torque(torque, results)
    draw_heat(heat, results)
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def draw_statics(axes: Axes) -> None:
    """The stick band, and gravity by payload."""
    theta = np.linspace(0.0, RANGE, 100)
    release, load = np.array([elbow.design_cam().band(angle) for angle in theta]).T
    axes.fill_between(np.degrees(theta), release, load, color=COLOURS[CAM], alpha=0.25, label="stick band")
    for payload, style in zip(PAYLOADS, ("--", "-", "-."), strict=True):
        gravity = [elbow.weight(payload).torque(angle) for angle in theta]
        axes.plot(np.degrees(theta), gravity, "k", ls=style, label=f"gravity, {payload:g} kg")
    axes.set(title="Gravity and the cam's stick band", xlabel="angle of cam 2 [deg]", ylabel="torque [N.m]")
    axes.set(xlim=(0.0, math.degrees(RANGE)), ylim=(0.0, 16.0))
    axes.legend(loc="upper left", fontsize=9)


def draw_torque(axes: Axes, results: dict[tuple[float, str], Cycle]) -> None:
    """The motor's torque over the last cycle at the design payload."""
    for joint in (NAIVE, BARE, CAM):
        record = results[DESIGN_PAYLOAD, joint].record
        axes.plot(record.time - MOTION.period, record.motor_torque, color=COLOURS[joint], label=joint)
    for begin in (0.0, 0.5 * MOTION.period):
        axes.axvspan(begin, begin + MOTION.dwell, color="0.94", zorder=0)
    axes.set(title=f"Motor torque, {DESIGN_PAYLOAD:g} kg (grey: hold)", xlabel="time in the cycle [s]")
    axes.set(ylabel="torque at the output [N.m]", xlim=(0.0, MOTION.period), ylim=(-14.0, 14.0))
    axes.legend(loc="upper right", fontsize=9)


def draw_heat(axes: Axes, results: dict[tuple[float, str], Cycle]) -> None:
    """Heat per cycle in motor and cam, all payloads."""
    for i, payload in enumerate(PAYLOADS):
        for joint, x in ((BARE, i - 0.2), (CAM, i + 0.2)):
            cycle = results[payload, joint]
            if not cycle.lifts:
                axes.text(x, 3.0, "does not lift", rotation=90, ha="center")
                continue
            motor, cam = cycle.joule_heat, cycle.friction_heat
            axes.bar(x, motor, 0.36, color=COLOURS[joint], label=f"motor, {joint}" if i == 0 else None)
            label = "friction in the cam" if (i, joint) == (0, CAM) else None
            axes.bar(x, cam, 0.36, bottom=motor, color="tab:red", label=label)
    tallest = max(cycle.joule_heat for cycle in results.values() if cycle.lifts)
    axes.set(title="Heat per cycle", ylabel="heat [J]", xlabel="payload", ylim=(0.0, 1.1 * tallest))
    axes.set_xticks(range(len(PAYLOADS)), [f"{payload:g} kg" for payload in PAYLOADS])
    axes.legend(loc="upper right", fontsize=9)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--fmu", type=Path, default=BUILD / "DualCamForward.fmu")
    parser.add_argument("--output", type=Path, default=BUILD / "robot_joint.png", help="picture to write")
    options = parser.parse_args(arguments)
    results = run(options.fmu)
    print("Elbow of a UR3e, T-Motor AK80-6, 1 s moves and 1 s holds; per cycle, the last of two\n")
    print("\n".join([*design_table(), "", *result_table(results), "", *findings(results)]))
    picture(results, options.output)
    print(f"\nPicture: {options.output}")


if __name__ == "__main__":
    main()
