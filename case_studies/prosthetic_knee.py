"""The prosthetic knee in more detail: the equation of motion against published moments, the design against a
motor that follows exactly, softer and stiffer impedances, findings, and a picture.

    python -m case_studies.prosthetic_knee

The knee is the one of dualcam.systems.machines.knee. Equations and the table of all swings are those of
system_examples/prosthetic_knee.py.

Check. The knee moment that the equation of motion asks for along the measured motion is compared with the
moment that the sources publish. They differ by 4 N.m RMS: the filters differ, and the first source's force
plate reads 2 N while the foot is in the air.

Design. The damper's valve is opened in inverse proportion to the cadence, damping in proportion. The table
shows that this is the least-squares optimum at the other two cadences. Friction is 0.14, sliding and greased.
Rolling (0.05) changes little: most of the time the cam brakes, and there friction helps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from case_studies.command_line import bullets, parse
from dualcam import Fmu
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD
from dualcam.systems.blocks.elliptical_cam import NO_CAM
from dualcam.systems.machines import knee
from dualcam.systems.machines.gait import CHECK_WALKER, DESIGN_WALKER, Walker
from dualcam.systems.machines.knee import KneeSwing
from dualcam.systems.machines.swing import Swing

CADENCES = (0.8, 1.0, 1.2)  # of the self-selected one
FREQUENCIES = (2.0, 5.0, 8.0)  # Hz, of softer and stiffer impedances
BARE, CAM, PASSIVE = "no cam", "cam", "cam, motor off"
JOINTS = (BARE, CAM, PASSIVE)
Results = dict[tuple[str, float, str], KneeSwing]  # by walker, cadence and joint


def run(path: str | Path) -> Results:
    """All swings with the FMU at that path, by walker, cadence and joint."""
    cam, results = knee.design_cam(), {}
    with Fmu(path) as fmu:
        for walker, cadence in product((DESIGN_WALKER, CHECK_WALKER), CADENCES):
            motion, impedance = knee.swing(walker, cadence), knee.impedance(knee.inertia(walker))
            mechanism = cam.with_damping_scaled(cadence).parameters()
            results[walker.name, cadence, BARE] = knee.simulate(fmu, motion, NO_CAM, impedance)
            results[walker.name, cadence, CAM] = knee.simulate(fmu, motion, mechanism, impedance)
            results[walker.name, cadence, PASSIVE] = knee.simulate(fmu, motion, mechanism, None)
    return results


def run_stiffness(path: str | Path) -> dict[tuple[float, str], KneeSwing]:
    """The first subject's self-selected swing by natural frequency of the impedance [Hz] and joint."""
    motion, mechanism = knee.swing(DESIGN_WALKER, 1.0), knee.design_cam().parameters()
    inertia, results = knee.inertia(DESIGN_WALKER), {}
    with Fmu(path) as fmu:
        for frequency in FREQUENCIES:
            impedance = knee.impedance(inertia, frequency)
            for joint, parameters in ((BARE, NO_CAM), (CAM, mechanism)):
                results[frequency, joint] = knee.simulate(fmu, motion, parameters, impedance)
    return results


def moment_check(walker: Walker) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Percent of the stride, published moment and that of inverse dynamics [N.m], from 70 % on: before, the
    sources' filters still carry stance into the swing."""
    motion = knee.swing(walker, 1.0)
    percent, _, moment = np.array(walker.published).T
    late = percent >= 70.0
    own = np.interp(percent[late], motion.percent_of_stride, motion.moment)
    return percent[late], moment[late] * walker.mass, own


def exact_heat(torque: np.ndarray) -> float:
    """Heat in the winding [J] while the motor gives this torque [N.m], one sample per control period."""
    return knee.MOTOR.resistance * CONTROL_PERIOD * float(np.sum((torque / knee.MOTOR.output_constant) ** 2))


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


def exact_table() -> list[str]:
    """What the cam leaves to a motor that makes the joint follow every measured swing exactly."""
    cam, rolling = knee.design_cam(), knee.design_cam(0.05)
    lines = [
        "If the motor made the joint follow the measured motion exactly: mean square of its torque with the",
        "cam over that without (valve in proportion to cadence, fixed, at its best), heat, largest torque",
        "                           share of the mean square            heat [J]      torque [N.m]",
        "walker         cadence  prop. fixed  best (setting) rolling   no cam   cam   no cam   cam",
    ]
    for walker in (DESIGN_WALKER, CHECK_WALKER):
        for cadence in CADENCES:
            motion = knee.swing(walker, cadence)
            best, damped = knee.best_damping_scale(cam, motion), cam.with_damping_scaled(cadence)
            rest = knee.residual_torque(damped, motion)
            cams = (damped, cam, cam.with_damping_scaled(best), rolling.with_damping_scaled(cadence))
            proportional, fixed, optimal, slippery = (knee.residual_share(one, motion) for one in cams)
            lines.append(
                f"{walker.name:14s} {cadence:7.1f} {proportional:6.2f} {fixed:5.2f}"
                f" {optimal:5.2f}   ({best:.2f}) {slippery:9.2f}"
                f" {exact_heat(motion.demand):8.2f} {exact_heat(rest):5.2f}"
                f" {np.abs(motion.demand).max():8.1f} {np.abs(rest).max():5.1f}"
            )
    return lines


def stiffness_table(stiffness: dict[tuple[float, str], KneeSwing]) -> list[str]:
    """What a softer and a stiffer impedance make of the first subject's self-selected swing."""
    lines = ["First subject, self-selected, under softer and stiffer impedances: no cam / cam"]
    for frequency in FREQUENCIES:
        bare, cam = stiffness[frequency, BARE], stiffness[frequency, CAM]
        stiff = math.radians(knee.impedance(cam.inertia, frequency).stiffness)
        lines.append(
            f"  {frequency:.0f} Hz, {stiff:5.2f} N.m/deg:"
            f" error {bare.rms_error:.2f} / {cam.rms_error:.2f} deg,"
            f" heat {bare.heat:.2f} / {cam.heat:.2f} J,"
            f" drawn {bare.energy_drawn:.2f} / {cam.energy_drawn:.2f} J,"
            f" impact {bare.impact_speed:.0f} / {cam.impact_speed:.0f} deg/s"
        )
    return lines


def findings(results: Results) -> str:
    """What the table says, with its numbers, for and against the cam."""
    first, second = DESIGN_WALKER.name, CHECK_WALKER.name
    slow, own, fast = CADENCES
    bare, cam, passive = (results[first, own, joint] for joint in JOINTS)
    other_bare, other_cam = results[second, own, BARE], results[second, own, CAM]
    fast_bare, fast_cam = results[first, fast, BARE], results[first, fast, CAM]
    slow_passive, fast_passive = results[first, slow, PASSIVE], results[first, fast, PASSIVE]
    motion = knee.swing(DESIGN_WALKER, own)
    rest = knee.residual_torque(knee.design_cam(), motion)

    late = math.degrees(float(fast_passive.record.angle[-1] - fast_passive.motion.angle[-1]))
    free = bare.before_impact  # ticks before the impact
    helps = [
        f"At the self-selected cadence it takes {100 * (1 - cam.heat / bare.heat):.0f} % off the motor's heat"
        f" ({bare.heat:.2f} to {cam.heat:.2f} J) and"
        f" {100 * (1 - cam.energy_drawn / bare.energy_drawn):.0f} % off what the"
        f" motor draws ({bare.energy_drawn:.2f} to {cam.energy_drawn:.2f} J)."
        f" Peak power falls from {bare.peak_power:.0f} to {cam.peak_power:.0f} W,"
        f" peak torque from {bare.largest_torque:.1f} to {cam.largest_torque:.1f} N.m.",
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
        f" motor without the cam would gain {-bare.net_energy:.2f} J per swing; with the cam it costs"
        f" {cam.net_energy:.2f} J, because {cam.cam_heat:.1f} J become heat in damper and grooves.",
        "Without the cam the peaks are the motor's answer to the impact: until then it needs"
        f" {np.max(bare.power[free]):.0f} W and {np.max(bare.record.peak_torque[free]):.1f} N.m. With"
        " the cam the peak comes after full extension, where the measured knee bends again: a way the cam"
        " cannot push.",
        "A stiffer impedance makes the impact without the cam softer and the saving in drawn energy smaller;"
        " heat falls all the same.",
        "A controller that knew the swing beforehand would save little peak torque with the cam:"
        f" {np.abs(motion.demand).max():.0f} N.m without, {np.abs(rest).max():.0f} N.m with it. Its heat"
        f" would still fall, from {exact_heat(motion.demand):.1f} to {exact_heat(rest):.1f} J.",
        f"At the fast cadence the motor draws more with the cam ({fast_cam.energy_drawn:.1f} against"
        f" {fast_bare.energy_drawn:.1f} J), though it stays cooler: most is drawn to start extension, for"
        " which the spring is then too weak. The second subject shows the same.",
        f"The motor can be off at one cadence only: at the slow one the shank hits the stop with"
        f" {slow_passive.impact_speed:.0f} deg/s, at the fast one it is still bent {late:.0f} deg too far at"
        " heel strike.",
    ]
    return bullets({"Where the cam helps": helps, "Where it does not": hurts})


def real_time(results: Results) -> str:
    """What the loop of all runs together cost on this machine."""
    seconds = sum(result.record.wall_time for result in results.values())
    ticks = sum(len(result.record.time) for result in results.values())
    scaled = seconds / (ticks * CONTROL_PERIOD)
    took = f"{10.0 * scaled:.2f} s: {1 / scaled:.0f} times real time"
    return f"10 s of the loop at {1 / CONTROL_PERIOD:.0f} Hz took {took}"


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
    _draw_torque_angle(axes[0, 1], cam.motion)
    _draw_torque(axes[1, 0], shown)
    _draw_energy(axes[1, 1], cam)
    _draw_bars(axes[2, 0], results, "heat", "Motor heat per swing [J]", (BARE, CAM))
    _draw_bars(axes[2, 1], results, "impact_speed", "Terminal impact [deg/s] (no bar: no hit)", JOINTS)
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def _draw_angle(axes: Axes, shown: dict[str, KneeSwing]) -> None:
    motion = shown[CAM].motion
    percent = motion.percent_of_stride
    styles: dict[str, dict[str, Any]] = {
        BARE: {"lw": 5, "alpha": 0.6},
        CAM: {"lw": 2},
        PASSIVE: {"lw": 2, "ls": "--"},
    }
    for joint, result in shown.items():
        angle = np.degrees(result.record.angle + motion.extension)
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
    cam = knee.design_cam()
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
        k = int(np.argmin(np.abs(motion.percent_of_stride - percent)))
        point = (degrees[k], motion.demand[k])
        axes.annotate(f"{percent} %", point, textcoords="offset points", xytext=offset, fontsize=9)
        axes.plot(*point, "k.", ms=7)
    axes.axhline(0.0, color="k", lw=0.6)
    axes.set_title("Design: the cam's torque against what the motion asks for")
    axes.set_xlim(0.0, 72.0)
    axes.set_xlabel("knee flexion [deg]")
    axes.set_ylabel("torque against flexion [N.m]")
    axes.legend(loc="lower right", fontsize=9)


def _draw_torque(axes: Axes, shown: dict[str, KneeSwing]) -> None:
    percent = shown[CAM].motion.percent_of_stride[1:]
    for joint in (BARE, CAM):
        axes.plot(percent, shown[joint].record.motor_torque, color=COLOURS[joint], label=joint)
    peak = knee.MOTOR.peak_torque
    axes.axhline(peak, color="tab:red", ls="--", lw=0.9)
    axes.text(66, peak - 2.3, "motor's peak", fontsize=9, color="tab:red")
    axes.axhline(0.0, color="k", lw=0.6)
    axes.set_title("Motor torque (+ bends the knee)")
    axes.set_ylabel("torque at the output [N.m]")
    axes.legend(loc="lower left", fontsize=9)
    _label_cycle(axes)


def _draw_energy(axes: Axes, cam: KneeSwing) -> None:
    percent = cam.motion.percent_of_stride[1:]
    parts = ("kinetic", "spring", "heat_damper", "heat_cam1", "heat_cam2", "heat_stop")
    axes.stackplot(
        percent,
        *(cam.record.ledger[name] for name in parts),
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
            x = i + (i >= len(CADENCES)) * 0.4 + (j - 0.5 * (len(joints) - 1)) * width
            axes.bar(x, value, 0.92 * width, color=COLOURS[joint], label=joint if i == 0 else None)
            text = f"{value:.1f}" if what == "heat" else f"{value:.0f}" if value > 0.0 else ""
            axes.text(x, value, text, ha="center", va="bottom", fontsize=8)
    positions = [i + (i >= len(CADENCES)) * 0.4 for i in range(len(labels))]
    axes.set_xticks(positions, labels)
    axes.set_xlabel(
        f"strides per minute; left: {DESIGN_WALKER.name}, right: {CHECK_WALKER.name}, not used in the design"
    )
    axes.set_title(title)
    axes.margins(y=0.12)
    axes.legend(loc="upper left", fontsize=9)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    options = parse(__doc__, "prosthetic_knee_report.png", arguments)
    results = run(options.fmu)
    blocks = check_table(), exact_table(), stiffness_table(run_stiffness(options.fmu))
    print("\n\n".join("\n".join(block) for block in blocks))
    print()
    print(findings(results))
    print()
    print(real_time(results))
    picture(results, options.output)
    print(f"\nPicture: {options.output}")


if __name__ == "__main__":
    main()
