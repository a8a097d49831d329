"""Does a robot's elbow in MuJoCo stay where it is with the motor off?

The elbow of a UR3e carries 1.5 kg. A motor lowers the arm from 15 to 60 deg from upright in 2 s. Then the
motor is off for 60 s. The same spring torque and the same friction hold the arm in several ways:

    cam             the dual cam of system_examples/robot_joint.py beside the joint, by dualcam.mujoco
    frictionloss    MuJoCo's own dry friction of a joint, as it comes
    stiffest        the same with the stiffest settings that MuJoCo takes (solimp 0.9999, solref of two steps)
    no slip         as it comes, with MuJoCo's second solver for friction, noslip_iterations

MuJoCo's dry friction is a constraint that gives way a little, so that the solver has one answer. The joint
then creeps at a speed in proportion to its load. The solver without slip takes that away. MuJoCo's joint
has one number for friction. The stick band of the cam grows with the angle, and follows from grooves, spring
and coefficients.

Then 100 arms with different friction in the cams are stepped side by side: which of them hold?

Costs of a step, and all settings of MuJoCo's friction: benchmarks/rates/creep.py (`./build.sh run creep`).

Copy this file for an own robot: the model is MJCF text, the cam is one `CamJoint`.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from matplotlib.figure import Figure

from dualcam.fmi.reals import Array
from dualcam.mujoco import CamJoint, CamSimulation
from dualcam.mujoco.ur3e_elbow import elbow_mjcf
from dualcam.systems.machines import elbow

BUILD = Path(__file__).resolve().parent.parent / "build"
STEP = 2e-3  # s, MuJoCo's default
PAYLOAD = elbow.DESIGN_PAYLOAD  # kg
START, END = math.radians(15.0), math.radians(60.0)  # rad from upright
MOVE, HOLD = 2.0, 60.0  # s
SETTLE = 2.0  # s after the motor is off, from which on the drift counts
STIFFNESS = 4000.0  # N.m/rad, of a steel shaft of 15 mm and 100 mm: 79 GPa pi d^4/(32 l)
PROPORTIONAL, DERIVATIVE = 200.0, 20.0  # N.m/rad, N.m.s/rad, of the motor's controller while the arm moves
CAM, PLAIN, STIFFEST, NO_SLIP = "cam", "frictionloss", "stiffest", "no slip"
STYLES: dict[str, dict[str, Any]] = {
    CAM: {"color": "tab:blue", "lw": 1.5},
    PLAIN: {"color": "tab:red", "lw": 1.5},
    STIFFEST: {"color": "tab:orange", "lw": 1.5, "ls": "--"},
    NO_SLIP: {"color": "black", "lw": 1.5, "ls": ":"},
}
LEAST_SHOWN = 1e-16  # rad
ARMS, LET_GO = 100, 3.0  # arms side by side, s


class Run(NamedTuple):
    """One way to hold the arm."""

    time: Array  # s
    angle: Array  # rad
    creep: float  # rad/s, mean over the last 30 s
    drift: float  # rad, from SETTLE after the motor is off


# ---- the arm and its joint ----


def arm(joint: str = "", option: str = "") -> mujoco.MjModel:
    """The model, with further attributes of the elbow's joint and of the options."""
    limits = (elbow.LEAN, elbow.LEAN + elbow.RANGE)
    return mujoco.MjModel.from_xml_string(elbow_mjcf(PAYLOAD, limits, STEP, joint, option))


def elbow_cam(**parameters: Array) -> CamJoint:
    """The cam of the elbow: its angle counts from 10 deg of lean."""
    stops = {"stop.lower": 0.0, "stop.upper": elbow.RANGE}
    values: dict[str, Any] = {**elbow.design_cam().parameters(), **stops, **parameters}
    return CamJoint("elbow", stiffness=STIFFNESS, parameters=values, offset=elbow.LEAN)


def as_frictionloss() -> str:
    """The cam in MuJoCo's own elements: the middle of the stick band as a spring, half its width where the
    arm is held as frictionloss."""
    cam = elbow.design_cam()
    ends = [sum(cam.band(theta)) / 2.0 for theta in (0.0, elbow.RANGE)]
    stiffness = (ends[1] - ends[0]) / elbow.RANGE
    release, load = cam.band(END - elbow.LEAN)
    rest = elbow.LEAN - ends[0] / stiffness
    return f'stiffness="{stiffness}" springref="{rest}" frictionloss="{(load - release) / 2.0}"'


def motor_torque(data: mujoco.MjData) -> float:
    """Of the motor while the arm moves: towards the planned angle, which rises like a polynomial."""
    share = min(data.time / MOVE, 1.0)
    planned = START + (END - START) * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return PROPORTIONAL * (planned - data.qpos[0]) - DERIVATIVE * data.qvel[0]


def arm_at(angle: float, model: mujoco.MjModel) -> mujoco.MjData:
    """The arm at rest at an angle, its wrist level."""
    data = mujoco.MjData(model)
    data.qpos[:] = angle, -angle
    return data


# ---- runs ----


def run(data: mujoco.MjData, step: Callable[[], None]) -> Run:
    """Lower the arm, then hold."""
    angles = [data.qpos[0]]
    for _ in range(round(MOVE / STEP)):
        data.ctrl[0] = motor_torque(data)
        step()
        angles.append(data.qpos[0])
    data.ctrl[0] = 0.0
    for _ in range(round(HOLD / STEP)):
        step()
        angles.append(data.qpos[0])
    settled, half = round((MOVE + SETTLE) / STEP), round((MOVE + HOLD / 2.0) / STEP)
    creep = (angles[-1] - angles[half]) / (HOLD / 2.0)
    times: Array = STEP * np.arange(len(angles), dtype=np.float64)
    return Run(times, np.array(angles), creep, angles[-1] - angles[settled])


def run_all() -> dict[str, Run]:
    """All ways to hold."""
    model = arm()
    data = arm_at(START, model)
    with CamSimulation(model, data, elbow_cam()) as simulation:
        runs = {CAM: run(data, simulation.step)}
    joint = as_frictionloss()
    stiffest = f'solreffriction="{2 * STEP} 1" solimpfriction="0.9999 0.9999 0.001 0.5 2"'
    variants = {
        PLAIN: (joint, ""),
        STIFFEST: (f"{joint} {stiffest}", ""),
        NO_SLIP: (joint, 'noslip_iterations="20"'),
    }
    for name, variant in variants.items():
        model = arm(*variant)
        data = arm_at(START, model)
        runs[name] = run(data, partial(mujoco.mj_step, model, data))
    return runs


# ---- many arms ----


class Arms(NamedTuple):
    """Many arms with different cams that are let go at END."""

    friction: Array  # of both contacts
    sag: Array  # rad


def let_go(count: int = ARMS) -> Arms:
    """Arms whose cams have different friction, motor off."""
    friction = np.linspace(0.02, 0.06, count)
    model = arm()
    data = [arm_at(END, model) for _ in range(count)]
    cam = elbow_cam(**{"cam1.friction": friction, "cam2.friction": friction})
    with CamSimulation(model, data, cam) as simulation:
        for _ in range(round(LET_GO / STEP)):
            simulation.step()
    return Arms(friction, np.array([one.qpos[0] for one in data]) - END)


def is_held(friction: float) -> bool:
    """Whether gravity at END lies inside the stick band, by the statics of the cam."""
    cam = replace(elbow.design_cam(), friction=(friction, friction))
    release, load = cam.band(END - elbow.LEAN)
    return release <= elbow.weight(PAYLOAD).torque(END - elbow.LEAN) <= load


# ---- results ----


def table(runs: dict[str, Run]) -> list[str]:
    """Creep and drift of each way."""
    lines = ["way to hold       creep [rad/s]  drift in 58 s [rad]"]
    lines += [f"{name:14s} {found.creep:16.1e} {found.drift:20.1e}" for name, found in runs.items()]
    return lines


def picture(runs: dict[str, Run], arms: Arms, output: Path) -> None:
    """Save the comparison as an image."""
    figure = Figure(figsize=(13.0, 4.2), layout="constrained")
    motion, drift, many = figure.subplots(1, 3)
    for name, found in runs.items():
        motion.plot(found.time, np.degrees(found.angle), **STYLES[name], label=name)
        settled = found.time > MOVE + SETTLE
        moved = np.abs(found.angle[settled] - found.angle[settled][0])[1:]
        label = f"{name}: exactly 0" if not moved.any() else name
        drift.semilogy(found.time[settled][1:], np.maximum(moved, LEAST_SHOWN), **STYLES[name], label=label)
    motion.set(title="The arm is lowered; motor off at 2 s", ylabel="angle from upright [deg]")
    drift.set(title="Drift from 4 s on", ylabel="change of the angle [rad]", ylim=(1e-17, 10.0))
    held = np.array([is_held(friction) for friction in arms.friction])
    for which, colour, text in ((held, "tab:blue", "inside"), (~held, "tab:red", "outside")):
        label = f"gravity {text} the stick band"
        many.plot(arms.friction[which], np.degrees(arms.sag[which]), ".", color=colour, label=label)
    many.set(title=f"{len(held)} arms let go at 60 deg", xlabel="friction coefficient of the cam [1]")
    many.set(ylabel=f"change of the angle in {LET_GO:.0f} s [deg]")
    for axes, place in ((motion, "lower right"), (drift, "center right"), (many, "upper right")):
        axes.legend(loc=place, fontsize=9)
    for axes in (motion, drift):
        axes.set_xlabel("time [s]")
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=BUILD / "mujoco_elbow.png", help="picture to write")
    options = parser.parse_args(arguments)
    runs, arms = run_all(), let_go()
    print(f"Elbow of a UR3e with {PAYLOAD} kg, MuJoCo {mujoco.__version__}, steps of {1e3 * STEP:g} ms\n")
    print("\n".join(table(runs)))
    least = min(friction for friction in arms.friction if is_held(friction))
    print(
        f"\n{ARMS} arms let go at 60 deg: gravity is inside the stick band from a friction of {least:.4f} on."
    )
    print(f"These sag by at most {math.degrees(arms.sag[arms.friction >= least].max()):.2f} deg.")
    picture(runs, arms, options.output)
    print(f"\nPicture: {options.output}")


if __name__ == "__main__":
    main()
