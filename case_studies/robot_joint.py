"""The robot's elbow in more detail: a picture of angle, error, torque, statics, energy and heat over a cycle.

    python -m case_studies.robot_joint

The joint is the one of dualcam.systems.machines.elbow. Equations, loops and results are those of
system_examples/robot_joint.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from case_studies.command_line import parse
from dualcam import Fmu
from dualcam.systems.blocks.axis import CamAxis, simulate_closed_loop
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD, CurrentLoop
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.machines import elbow
from dualcam.systems.machines.elbow import DESIGN_PAYLOAD, MOTION, NO_CAM, RANGE, Cycle

PAYLOADS = (0.0, 1.5, 3.0)  # kg
BARE, CAM, NAIVE = "no cam", "cam", "cam, friction unknown"
Cycles = dict[tuple[float, str], Cycle]


def run(path: str | Path) -> Cycles:
    """All cases with the FMU at that path, by payload [kg] and joint."""
    cam, believed = elbow.design_cam(), elbow.FRICTION_BELIEVED
    cases = [
        (payload, *case) for payload in PAYLOADS for case in ((BARE, NO_CAM, believed), (CAM, cam, believed))
    ]
    cycles = {}
    with Fmu(path) as fmu:
        axis = CamAxis(fmu)
        for payload, joint, helix, friction in [*cases, (DESIGN_PAYLOAD, NAIVE, cam, 0.0)]:
            axis.start(elbow.plant_parameters(helix, payload), MOTION.start)
            controller, loop = elbow.controller(helix, payload, friction), CurrentLoop(AK80_6)
            record = simulate_closed_loop(
                axis, elbow.weight(payload), controller, loop, elbow.reference_motion()
            )
            cycles[payload, joint] = Cycle(payload, joint, record)
    return cycles


COLOURS = {BARE: "tab:orange", CAM: "tab:blue", NAIVE: "0.6"}


def picture(results: Cycles, output: Path) -> None:
    """Save the comparison as an image."""
    bare, cam, naive = (results[DESIGN_PAYLOAD, joint] for joint in (BARE, CAM, NAIVE))
    time = CONTROL_PERIOD * np.arange(1, len(cam.record.time) + 1, dtype=float)
    figure = Figure(figsize=(13.0, 12.0), layout="constrained")
    axes = figure.subplots(3, 2)
    figure.suptitle(
        f"Elbow of a UR3e, {DESIGN_PAYLOAD} kg: {bare.joule_heat:.0f} J of motor heat per cycle without the"
        f" cam,\n{cam.joule_heat:.0f} J with it, and {cam.friction_heat:.0f} J of friction heat on top",
        fontsize=14,
    )
    for panel in (axes[0, 0], axes[1, 0], axes[2, 0], axes[1, 1]):
        _draw_holds(panel)
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


def _draw_angle(axes: Axes, time: np.ndarray, bare: Cycle, cam: Cycle) -> None:
    axes.plot(time, np.degrees(bare.record.angle), color=COLOURS[BARE], lw=5, alpha=0.6, label=BARE)
    axes.plot(time, np.degrees(cam.record.angle), color=COLOURS[CAM], lw=2, label=CAM)
    axes.plot(time, np.degrees(cam.record.reference), "k:", lw=1.2, label="planned")
    axes.set_title("Angle (0: arm raised, 80 deg: horizontal)")
    axes.set_ylabel("angle of cam 2 [deg]")
    axes.set_ylim(-3.0, 85.0)
    axes.legend(loc="lower center")


def _draw_error(axes: Axes, time: np.ndarray, bare: Cycle, cam: Cycle) -> None:
    for result in (bare, cam):
        axes.plot(time, 1e3 * result.record.error, color=COLOURS[result.joint], label=result.joint)
    axes.axhline(0.0, color="k", lw=0.6)
    axes.set_title("Tracking error")
    axes.set_ylabel("error [mrad]")
    axes.legend(loc="lower right")


def _draw_torque(axes: Axes, time: np.ndarray, bare: Cycle, cam: Cycle, naive: Cycle) -> None:
    for result in (naive, bare, cam):
        axes.plot(time, result.record.motor_torque, color=COLOURS[result.joint], label=result.joint)
    for level, name in ((AK80_6.rated_torque, "rated"), (AK80_6.peak_torque, "peak")):
        axes.axhline(level, color="tab:red", ls="--", lw=0.9)
        axes.axhline(-level, color="tab:red", ls="--", lw=0.9)
        axes.text(0.06, level + 0.3, name, fontsize=9, color="tab:red")
    axes.set_title("Motor torque (+ lowers the arm)")
    axes.set_ylabel("torque at the output [N.m]")
    axes.set_ylim(-14.0, 18.0)
    axes.legend(loc="upper right", ncols=3, fontsize=9)


def _draw_statics(axes: Axes) -> None:
    cam = elbow.design_cam()
    theta = np.linspace(0.0, RANGE, 100)
    degrees = np.degrees(theta)
    release, load = np.array([cam.band(angle) for angle in theta]).T
    blue = COLOURS[CAM]
    axes.fill_between(degrees, release, load, color=blue, alpha=0.2, lw=0, label="stick band: free hold")
    axes.plot(degrees, load, color=blue, lw=1, label="$T_{load}$ and $T_{release}$")
    axes.plot(degrees, release, color=blue, lw=1)
    axes.plot(degrees, 0.5 * (load + release), color=blue, lw=1, ls=":", label="middle of the band")
    for payload, style in zip(PAYLOADS, ("--", "-", "-."), strict=True):
        weight = [elbow.weight(payload).torque(angle) for angle in theta]
        axes.plot(degrees, weight, color="k", ls=style, lw=1.5, label=f"gravity, {payload:g} kg")
    axes.axhline(AK80_6.peak_torque, color="tab:red", ls="--", lw=0.9, label="motor's peak")
    axes.set_title("Gravity and the cam's torque")
    axes.set_xlabel("angle of cam 2 [deg]")
    axes.set_ylabel("torque about the elbow [N.m]")
    axes.set_xlim(0.0, 80.0)
    axes.set_ylim(0.0, 16.0)
    axes.legend(loc="upper left", fontsize=9)


def _draw_energy(axes: Axes, time: np.ndarray, cam: Cycle) -> None:
    since = cam.record.ledger
    axes.stackplot(
        time,
        *(since[name] for name in ("spring", "kinetic", "heat_cam1", "heat_cam2")),
        labels=["spring", "kinetic", "heat, contact 1", "heat, contact 2"],
        colors=["tab:green", "gold", "tab:red", "salmon"],
        alpha=0.75,
        lw=0,
    )
    axes.plot(time, since["work_in"], "k", lw=1.5, label="work in = sum of these")
    axes.plot(time, np.cumsum(cam.record.load_work), "k--", lw=1.2, label="gravity's part of it")
    axes.plot(time, np.cumsum(cam.record.motor_work), "k:", lw=1.5, label="motor's part of it")
    axes.set_title("Energy since the cycle began, with the cam")
    axes.set_ylabel("energy [J]")
    axes.set_ylim(0.0, None)
    axes.legend(loc="upper left", fontsize=9)


def _draw_heats(axes: Axes, results: Cycles) -> None:
    for joint in (BARE, CAM):
        axes.bar(0.0, 0.0, color=COLOURS[joint], label=f"motor, {joint}")
    axes.bar(0.0, 0.0, color="tab:red", label="friction in the cam")
    tallest = 0.0
    for i, payload in enumerate(PAYLOADS):
        for joint, x in ((BARE, i - 0.2), (CAM, i + 0.2)):
            result = results[payload, joint]
            if not result.lifts:
                axes.text(x, 2.0, f"{joint}: does not lift", rotation=90, ha="center", va="bottom")
                continue
            total = result.joule_heat + result.friction_heat
            tallest = max(tallest, total)
            axes.bar(x, result.joule_heat, 0.36, color=COLOURS[joint])
            axes.bar(x, result.friction_heat, 0.36, bottom=result.joule_heat, color="tab:red")
            axes.text(x, total + 1.5, f"{total:.0f} J", ha="center")
    axes.set_title("Heat per cycle, all payloads")
    axes.set_ylabel("heat [J]")
    axes.set_xticks(range(len(PAYLOADS)), [f"{payload:g} kg" for payload in PAYLOADS])
    axes.set_xlim(-0.6, len(PAYLOADS) - 0.4)
    axes.set_ylim(0.0, 1.12 * tallest)
    axes.legend(loc="upper right", fontsize=9)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    options = parse(__doc__, "robot_joint_report.png", arguments)
    picture(run(options.fmu), options.output)
    print(f"Picture: {options.output}")


if __name__ == "__main__":
    main()
