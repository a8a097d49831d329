"""How much work does a dual cam take off the motor of a prosthetic knee in swing?

From toe-off (65 % of the gait cycle) to heel strike the shank swings like a pendulum under a knee that the
thigh carries along. The knee must first stop flexion and start extension, then brake the shank before full
extension. In sum the knee takes energy out. A powered prosthesis pays for that with current in a motor.
Here a dual cam in parallel with the motor does most of that work. Flexion loads its spring, which helps
extension to start. Its damper brakes the way back. Both grooves start steep at full extension and flatten, so
the damper brakes most where the shank must stop.

    (I + J_rotor) theta'' = drive + tau_motor - T_cam
    drive = I psi'' + m d [a_x cos chi + (a_y + g) sin chi],  chi = psi - theta + lead

theta is knee flexion from full extension, psi the thigh's inclination, (a_x, a_y) the knee's acceleration,
chi the inclination of the shank's centre of mass, all in the sagittal plane. The FMU (`DualCamForward`) owns
the shank's inertia; `drive` and the motor's torque are its input. Without the cam it is the same FMU with
neither spring nor damper nor friction: an inertia.

Cam       the squared torque left to the motor is minimal over the first subject's self-selected swing, by
          groove, spring and damper (dualcam.systems.machines.knee.design_cam). At other cadences the damper's
          valve is set in proportion to the cadence
Control   the motor follows the measured motion through an impedance, a spring and a damper at 1 kHz, which
          knows neither the load nor the cam
Stop      full extension, with a stop, is the smallest knee angle of the measured swing. A shank that is too
          fast there hits the stop: the terminal impact

Left out, in all cases alike: friction of gear and belt, losses of the drive, the follower's mass, the ankle,
and the effect of the prosthesis on hip and thigh, whose motion is prescribed.

Copy this file for an own system. Checks of the equation of motion, other impedances and a list of findings:
case_studies/prosthetic_knee.py.
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
from dualcam.systems.blocks.elliptical_cam import NO_CAM
from dualcam.systems.machines import knee
from dualcam.systems.machines.gait import CHECK_WALKER, DESIGN_WALKER
from dualcam.systems.machines.knee import KneeSwing

BUILD = Path(__file__).resolve().parent.parent / "build"
WALKERS = (DESIGN_WALKER, CHECK_WALKER)  # the design never saw the second one
CADENCES = (0.8, 1.0, 1.2)  # of the self-selected one
BARE, CAM, PASSIVE = "no cam", "cam", "cam, motor off"
JOINTS = (BARE, CAM, PASSIVE)
COLOURS = {BARE: "tab:orange", CAM: "tab:blue", PASSIVE: "0.6"}
Results = dict[tuple[str, float, str], KneeSwing]  # by walker, cadence and joint


# ---- plant, controller, run ----


def run(path: str | Path) -> Results:
    """All swings with the FMU at that path."""
    cam, results = knee.design_cam(), {}
    with Fmu(path) as fmu:
        for walker in WALKERS:
            impedance = knee.impedance(knee.inertia(walker))
            for cadence in CADENCES:
                motion = knee.swing(walker, cadence)
                mechanism = cam.with_damping_scaled(cadence).parameters()
                for joint in JOINTS:
                    parameters = NO_CAM if joint == BARE else mechanism
                    controller = None if joint == PASSIVE else impedance
                    results[walker.name, cadence, joint] = knee.simulate(fmu, motion, parameters, controller)
    return results


# ---- results ----


def design_table() -> list[str]:
    """The cam and the impedance."""
    cam, impedance = knee.design_cam(), knee.impedance(knee.inertia(DESIGN_WALKER))
    deepest = float(knee.swing(DESIGN_WALKER, 1.0).angle.max())
    slopes, heights = cam.slope_and_height(np.array([0.0, deepest]))
    steep, flat = np.degrees(np.arctan(slopes))
    return [
        f"Cam: radius {1e3 * cam.radius:.0f} mm, ellipses {1e3 * cam.ellipse_a:.1f} x"
        f" {1e3 * cam.ellipse_b:.1f} mm, lead angle {steep:.1f} deg at full extension,"
        f" {flat:.1f} deg at {math.degrees(deepest):.0f} deg",
        f"     spring {cam.stiffness / 1e3:.1f} kN/m over {1e3 * heights[1]:.1f} mm, no preload;"
        f" damper {cam.release_damping / 1e3:.1f} kN.s/m on the way back; friction {cam.friction}",
        f"Impedance: {math.radians(impedance.stiffness):.2f} N.m/deg,"
        f" {math.radians(impedance.damping):.3f} N.m.s/deg",
    ]


def result_table(results: Results) -> list[str]:
    """All swings."""
    lines = [
        "                                  RMS  motor  supply [J]             peak    peak   impact   cam",
        "walker, strides                 error   heat  drawn   re-    net    power  torque           heat",
        "per minute     joint            [deg]    [J]       turned             [W]   [N.m]  [deg/s]   [J]",
    ]
    for (name, cadence, joint), swing in results.items():
        rate = f"{name}, {60.0 * cadence / swing.motion.walker.stride:.0f}"
        motor = ""
        if joint != PASSIVE:
            motor = (
                f"{swing.heat:7.2f} {swing.energy_drawn:6.2f} {swing.energy_returned:6.2f}"
                f" {swing.net_energy:6.2f}"
                f" {swing.peak_power:7.0f} {swing.largest_torque:7.1f}"
            )
        impact = f"{swing.impact_speed:.0f}" if swing.impact_speed > 0.0 else "none"
        lines.append(
            f"{rate:18s} {joint:14s} {swing.rms_error:6.2f}{motor:44s}{impact:>8s} {swing.cam_heat:6.2f}"
        )
    return lines


# ---- picture ----


def picture(results: Results, output: Path) -> None:
    """Save the first subject's self-selected swing as an image."""
    swings = {joint: results[DESIGN_WALKER.name, 1.0, joint] for joint in JOINTS}
    figure = Figure(figsize=(13.0, 4.5), layout="constrained")
    angle, torque, heat = figure.subplots(1, 3)
    draw_angle(angle, swings)
    draw_torque(torque, swings)
    draw_heat(heat, results)
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def draw_angle(axes: Axes, swings: dict[str, KneeSwing]) -> None:
    """Knee flexion over the gait cycle."""
    motion = swings[CAM].motion
    flexion = np.degrees(motion.angle + motion.extension)
    axes.plot(motion.percent_of_stride, flexion, "k:", label="measured")
    for joint, swing in swings.items():
        flexion = np.degrees(swing.record.angle + motion.extension)
        axes.plot(motion.percent_of_stride[1:], flexion, color=COLOURS[joint], label=joint)
    axes.axhline(math.degrees(motion.extension), color="tab:red", ls="--", lw=0.9, label="stop")
    axes.set(title="Knee flexion, first subject", xlabel="gait cycle [%]", ylabel="knee flexion [deg]")
    axes.set(xlim=(65.0, 100.0), ylim=(0.0, 70.0))
    axes.legend(loc="lower left", fontsize=9)


def draw_torque(axes: Axes, swings: dict[str, KneeSwing]) -> None:
    """The motor's torque over the gait cycle."""
    for joint in (BARE, CAM):
        swing = swings[joint]
        percent = swing.motion.percent_of_stride[1:]
        axes.plot(percent, swing.record.motor_torque, color=COLOURS[joint], label=joint)
    axes.set(title="Motor torque (+ bends the knee)", xlabel="gait cycle [%]", xlim=(65.0, 100.0))
    axes.set(ylabel="torque at the output [N.m]")
    axes.legend(loc="lower left", fontsize=9)


def draw_heat(axes: Axes, results: Results) -> None:
    """The motor's heat per swing, all walkers and cadences."""
    cases = [(walker, cadence) for walker in WALKERS for cadence in CADENCES]
    for joint, shift in ((BARE, -0.2), (CAM, 0.2)):
        heat = [results[walker.name, cadence, joint].heat for walker, cadence in cases]
        axes.bar(np.arange(len(cases)) + shift, heat, 0.36, color=COLOURS[joint], label=joint)
    labels = [f"{60 * cadence / walker.stride:.0f}/min" for walker, cadence in cases]
    axes.set_xticks(range(len(cases)), labels)
    axes.set(title="Motor heat per swing", ylabel="heat [J]")
    axes.set_xlabel("strides per minute; first subject, second subject")
    axes.legend(loc="upper left", fontsize=9)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--fmu", type=Path, default=BUILD / "DualCamForward.fmu")
    parser.add_argument("--output", type=Path, default=BUILD / "prosthetic_knee.png", help="picture to write")
    options = parser.parse_args(arguments)
    results = run(options.fmu)
    print("Swing of a prosthetic knee, toe-off to heel strike; T-Motor AK80-6 with a 2:1 belt\n")
    print("\n".join([*design_table(), "", *result_table(results)]))
    picture(results, options.output)
    print(f"\nPicture: {options.output}")


if __name__ == "__main__":
    main()
