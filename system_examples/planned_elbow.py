"""Which motor torque raises a robot's elbow with the least heat, and does the plan hold?

The elbow of the example robot_joint, with its cam, raises 1.5 kg from horizontal to 11 deg from upright in a
given time. CasADi reads the forward FMU of FMI 2.0 by model exchange (DaeBuilder) and takes the Jacobians
from the FMU. IPOPT plans the torque by direct collocation:

    minimise   integral of R (tau_motor/K)^2 dt,   R and K of the motor's output
    subject to d(theta, omega)/dt = f(theta, omega, tau_motor + tau_gravity(theta)) by the FMU, omega <= 0,
               at rest at both ends

Radau collocation with three nodes in each of 30 intervals (L. T. Biegler, Nonlinear Programming, 2010,
chapter 10). During the plan the FMU stays in one mode, slip in the releasing direction: CasADi handles no
events. So the plan is replayed with co-simulation, which has stick and stops:

    as planned    the plan, then the motor off: the cam holds the arm
    no payload    the same torque without the payload: the arm meets the stop

The comparison is a motion of minimum jerk, a polynomial of degree 5 in time, between the same positions.

Copy this file for an own plan: load, motor, cam and grid are blocks of dualcam.systems.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi
import numpy as np
from matplotlib.figure import Figure

from dualcam import Fmu
from dualcam.design.statics import Array
from dualcam.systems.blocks.gravity import GravityLoad
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.blocks.radau_grid import RadauGrid
from dualcam.systems.machines import elbow

BUILD = Path(__file__).resolve().parent.parent / "build"
PAYLOAD = elbow.DESIGN_PAYLOAD  # kg
CAM, LOAD = elbow.design_cam(), elbow.weight(PAYLOAD)
LOW, HIGH = elbow.MOTION.end, elbow.MOTION.start  # rad: the arm is horizontal at theta = RANGE
DURATION = 0.6  # s
GRID = RadauGrid(DURATION, intervals=30, nodes=3)
MODES = {1: "stick", 2: "slip", 3: "slip", 4: "lower stop", 5: "upper stop", 6: "wedged"}
HOLD = 60.0  # s, with the motor off after the plan
IPOPT: Any = {"print_level": 0, "sb": "yes", "hessian_approximation": "limited-memory"}
START = elbow.plant_parameters(CAM, PAYLOAD) | {"initial.theta": LOW, "tau": LOAD.torque(LOW)}
HEAT = AK80_6.resistance / AK80_6.output_constant**2  # W/(N.m)^2


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned motion at the start and at all nodes."""

    theta: Array  # rad
    omega: Array  # rad/s
    torque: Array  # N.m on cam 2 at the nodes, shape (intervals, nodes)
    heat: float  # J, of the motor

    @property
    def motor_torque(self) -> Array:
        """Torque of the motor at the nodes [N.m], shape (intervals*nodes,)."""
        return self.torque.ravel() - LOAD.moment * LOAD.gravity * np.sin(LOAD.lean + self.theta[1:])


def rates(path: str | Path) -> casadi.Function:
    """d(theta, omega)/dt as a function of (theta, omega) and (tau, F_ext), by the FMU at that path.

    The mode is that of the start: slip in the releasing direction.
    """
    builder = casadi.DaeBuilder("elbow", str(path))
    for name, value in (START | {"initial.omega": -1.0}).items():
        builder.set(name, float(value))
    return builder.create("rates", ["x", "u"], ["ode"])


def plan(path: str | Path) -> Plan:
    """Plan the torque with the least heat. RuntimeError if IPOPT finds no plan."""
    problem, time = casadi.Opti(), GRID.time
    state = problem.variable(2, len(time))
    torque = problem.variable(GRID.nodes, GRID.intervals)
    heat = collocate(problem, rates(path), state, torque)
    problem.minimize(heat)
    problem.subject_to(state[:, 0] == casadi.DM([LOW, 0.0]))
    problem.subject_to(state[:, -1] == casadi.DM([HIGH, 0.0]))
    problem.subject_to(state[1, :] <= 0.0)
    problem.set_initial(state[0, :], LOW + (HIGH - LOW) * time / DURATION)
    problem.set_initial(state[1, :], (HIGH - LOW) / DURATION)
    problem.solver("ipopt", {"print_time": False}, IPOPT)
    found = problem.solve()
    theta, omega = np.asarray(found.value(state))
    return Plan(theta, omega, np.asarray(found.value(torque)).T, float(found.value(heat)))


def collocate(problem: casadi.Opti, rate: casadi.Function, state: casadi.MX, torque: casadi.MX) -> casadi.MX:
    """Add the equations of motion at all nodes. Returns the motor's heat [J]."""
    heat = casadi.MX(0.0)
    for i in range(GRID.intervals):
        states = state[:, i * GRID.nodes : (i + 1) * GRID.nodes + 1]
        slopes = casadi.mtimes(states, GRID.slopes)
        for j, weight in enumerate(GRID.weights):
            x, tau = states[:, j + 1], torque[j, i]
            problem.subject_to(slopes[:, j] == rate(x, casadi.vertcat(tau, 0.0)))
            motor = tau - LOAD.moment * LOAD.gravity * casadi.sin(LOAD.lean + x[0])
            heat += HEAT * weight * motor**2
    return heat


def heat_of_minimum_jerk() -> float:
    """Heat [J] of the motor along a polynomial of degree 5 between the same positions of rest."""
    node, weight = np.polynomial.legendre.leggauss(40)
    s = 0.5 * (1.0 + node)
    theta = LOW + (HIGH - LOW) * s**3 * (10.0 + s * (6.0 * s - 15.0))
    alpha = (HIGH - LOW) / DURATION**2 * (60.0 * s - 180.0 * s**2 + 120.0 * s**3)
    balance = [CAM.band(angle)[0] - LOAD.torque(angle) for angle in theta]
    motor = elbow.inertia(PAYLOAD) * alpha + np.array(balance)
    return float(HEAT * DURATION * np.sum(0.5 * weight * motor**2))


@dataclass(frozen=True, eq=False)
class Replay:
    """A co-simulation with the planned torque, then with the motor off."""

    time: Array  # s, communication points of the planned torque
    theta: Array  # rad
    omega: Array  # rad/s
    mode: int  # at the end
    creep: float  # rad, change of the angle in HOLD seconds


def replay_as_planned(path: str | Path, planned: Plan) -> Replay:
    """The plan's torque as a function of time, then the motor off."""
    with Fmu(path) as fmu:
        fmu.start(START)
        tau, motion = fmu.reals("tau"), fmu.reals("theta", "omega")
        rows = [motion.read()]
        for value, *derivatives in GRID.derivatives_at_start(planned.torque):
            tau.values[0] = value
            tau.write()
            for order, derivative in enumerate(derivatives, start=1):
                tau.write_derivatives(order, [derivative])
            fmu.step(GRID.interval)
            rows.append(motion.read())
        return _held(fmu, LOAD, np.array(rows), GRID.interval)


def replay_without_payload(path: str | Path, planned: Plan) -> Replay:
    """The plan's motor torque on the empty arm, then the motor off."""
    load, step = elbow.weight(0.0), 1e-3  # s
    middle = np.arange(0.5 * step, DURATION, step)
    motor = np.interp(middle, GRID.time[1:], planned.motor_torque)
    with Fmu(path) as fmu:
        fmu.start(START | {"inertia.shaft": elbow.inertia(0.0), "tau": load.torque(LOW)})
        motion = fmu.reals("theta", "omega")
        rows = [motion.read()]
        for torque in motor:
            theta, omega = rows[-1]
            fmu.set("tau", torque + load.torque(theta + 0.5 * step * omega))
            fmu.step(step)
            rows.append(motion.read())
        return _held(fmu, load, np.array(rows), step)


def _held(fmu: Fmu, load: GravityLoad, rows: Array, step: float) -> Replay:
    """The rows of a replay at multiples of step [s], and what follows with the last weight and no motor."""
    theta, omega = rows.T
    fmu.set("tau", load.torque(theta[-1]))
    fmu.step(step)
    rest = fmu.real("theta")
    fmu.step(HOLD)
    time = np.linspace(0.0, step * (len(rows) - 1), len(rows))
    return Replay(time, theta, omega, int(fmu.get("mode")), fmu.real("theta") - rest)


@dataclass(frozen=True, eq=False)
class Results:
    """What the example shows."""

    planned: Plan
    as_planned: Replay
    no_payload: Replay
    jerk_heat: float  # J, of minimum jerk


def run(path: str | Path) -> Results:
    """Plan and replay with the FMU at that path."""
    planned = plan(path)
    replays = replay_as_planned(path, planned), replay_without_payload(path, planned)
    return Results(planned, *replays, heat_of_minimum_jerk())


def report(results: Results) -> str:
    """The results in lines."""
    planned, replay, empty = results.planned, results.as_planned, results.no_payload
    apart = float(np.abs(replay.theta - planned.theta[:: GRID.nodes]).max())
    at_stop = empty.time[np.argmax(empty.theta <= 0.0)]
    saved = 1.0 - planned.heat / results.jerk_heat
    return "\n".join(
        [
            f"The elbow raises {PAYLOAD} kg from theta = {LOW:.3f} to {HIGH:.3f} rad in {DURATION} s",
            f"heat of the motor: plan {planned.heat:.3f} J, minimum jerk {results.jerk_heat:.3f} J"
            f" ({100 * saved:.0f} % less)",
            f"largest torque of the motor: {np.abs(planned.motor_torque).max():.2f} N.m",
            f"co-simulation beside the plan: angles less than 1e{math.ceil(math.log10(apart))} rad apart",
            f"motor off for {HOLD:.0f} s: {MODES[replay.mode]}, the angle changes by {replay.creep:g} rad",
            f"without the payload: at the stop (theta = 0) after {at_stop:.3f} s,"
            f" at the end {MODES[empty.mode]}",
        ]
    )


def picture(results: Results, output: Path) -> None:
    """Draw angle, speed and torque over time."""
    planned = results.planned
    figure = Figure(figsize=(7.0, 7.5), layout="constrained")
    angle, speed, torque = figure.subplots(3, 1, sharex=True)
    for label, replay in (("co-simulation", results.as_planned), ("without the payload", results.no_payload)):
        angle.plot(replay.time, replay.theta, label=label)
        speed.plot(replay.time, replay.omega)
    angle.plot(GRID.time, planned.theta, "k.", ms=4, label="plan, at the nodes")
    speed.plot(GRID.time, planned.omega, "k.", ms=4)
    angle.set(title="The elbow is raised with the least heat", ylabel="theta [rad]")
    angle.legend()
    speed.set(ylabel="omega [rad/s]")
    torque.plot(GRID.time[1:], planned.motor_torque, "k.-", ms=4, lw=0.8)
    torque.set(ylabel="motor torque [N.m]", xlabel="time [s]")
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--fmu", type=Path, default=BUILD / "DualCamForward.fmu")
    parser.add_argument("--output", type=Path, default=BUILD / "planned_elbow.png", help="picture to write")
    options = parser.parse_args(arguments)
    results = run(options.fmu)
    print(report(results))
    picture(results, options.output)
    print(f"Picture: {options.output}")


if __name__ == "__main__":
    main()
