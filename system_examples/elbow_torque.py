"""Which motor torque raises a robot's elbow in two strokes with the least heat?

The elbow of the example robot_joint, with its cam, raises 1.5 kg from horizontal to 21 deg from upright. It
waits half way for 0.2 s: there the cam may hold the arm, so that the motor may be off. The torque is linear
between knots 20 ms apart. Looked for is the least of

    heat of the motor [J] + weight (errors of angle and speed in the wait and at the end)^2

The arm slips, sticks and slips again. The planner of the example planned_elbow knows one mode only. Here the
FMU has the derivative of each step through all mode changes, JAX makes of these the gradient of the loss, and
L-BFGS uses the gradient. Three methods without gradients get the same loss: Powell's and Nelder and Mead's
method with as many runs, and differential evolution with 50 times as many.

Copy this file for an own trajectory: load, motor and cam are blocks of dualcam.systems.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import differential_evolution, minimize

from dualcam.design.statics import Array
from dualcam.gradient import DifferentiableFleet, jax_rollout
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.machines import elbow

jax.config.update("jax_enable_x64", True)

BUILD = Path(__file__).resolve().parent.parent / "build"
PAYLOAD = elbow.DESIGN_PAYLOAD  # kg
CAM, LOAD = elbow.design_cam(), elbow.weight(PAYLOAD)
LOW, HIGH = elbow.MOTION.end, 0.2  # rad: the arm is horizontal at theta = RANGE
MIDDLE = 0.5 * (LOW + HIGH)
STROKE, WAIT, STEP, KNOT = 0.5, 0.2, 2e-3, 20e-3  # s
DURATION = 2.0 * STROKE + WAIT
TIME = np.arange(0.5 * STEP, DURATION, STEP)  # middle of each step
KNOTS = np.arange(0.0, DURATION + 0.5 * KNOT, KNOT)
BETWEEN = np.array([np.interp(TIME, KNOTS, unit) for unit in np.eye(len(KNOTS))]).T  # torques from knots
WAITS = (TIME > STROKE) & (TIME < STROKE + WAIT)
WEIGHTS = (1e2, 1e3, 1e4)  # J/rad^2, one after the other
SPEED = 0.1  # s, what an error of the speed weighs beside one of the angle
HEAT = AK80_6.resistance / AK80_6.output_constant**2  # W/(N.m)^2
SEED, GENEROUS = 1, 50


@dataclass(frozen=True, eq=False)
class Found:
    """What a method has found."""

    method: str
    runs: int
    motor: Array  # N.m, of each step
    theta: Array  # rad, after each step
    omega: Array  # rad/s
    loss: float  # J, with the largest weight

    @property
    def heat(self) -> float:
        """Heat of the motor [J]."""
        return float(HEAT * STEP * np.sum(self.motor**2))

    @property
    def error(self) -> float:
        """Largest error of the angle in the wait and at the end [rad]."""
        waiting = np.abs(self.theta[WAITS] - MIDDLE)[len(TIME[WAITS]) // 4 :].max()
        return float(max(waiting, abs(self.theta[-1] - HIGH)))


class Problem:
    """The loss as a function of the torques at the knots, for as many trajectories as the fleet has."""

    def __init__(self, fmu: str | Path, count: int = 1) -> None:
        values = elbow.plant_parameters(CAM, PAYLOAD)
        self.count, self.runs = count, 0
        self.fleet = DifferentiableFleet(fmu, count, STEP, values=values)
        self._run = jax_rollout(self.fleet)
        self._start = jnp.tile(jnp.array([LOW, 0.0]), (count, 1))
        self._losses = jax.jit(self.losses_of)
        self._gradient = jax.jit(
            jax.value_and_grad(lambda knots, weight: self.losses_of(knots, weight).sum())
        )

    def motion_of(self, knots: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Motor torques and states of each step, from torques on cam 2 at the knots, shape (count, knots)."""
        torque = knots @ BETWEEN.T
        states = self._run(self._start, torque[:, :, None], jnp.zeros((self.count, 0)))
        before = jnp.concatenate([self._start[:, None, 0], states[:, :-1, 0]], axis=1)
        middle = 0.5 * (before + states[:, :, 0])
        return torque - LOAD.moment * LOAD.gravity * jnp.sin(LOAD.lean + middle), states

    def losses_of(self, knots: jax.Array, weight: float) -> jax.Array:
        """The loss of each trajectory [J]."""
        motor, states = self.motion_of(knots)
        missed = states - jnp.array([MIDDLE, 0.0])
        last = states[:, -1] - jnp.array([HIGH, 0.0])
        square = jnp.array([1.0, SPEED**2])
        waiting = (WAITS[:, None] * square * missed**2).sum(axis=(1, 2)) / WAITS.sum()
        heat = HEAT * STEP * (motor**2).sum(axis=1)
        return heat + weight * (waiting + (square * last**2).sum(axis=1))

    def losses(self, knots: Array, weight: float) -> Array:
        """The same as numbers."""
        self.runs += self.count
        return np.asarray(self._losses(jnp.asarray(knots), weight))

    def value_and_gradient(self, knots: Array, weight: float) -> tuple[float, Array]:
        """The loss of one trajectory [J], and its gradient [J/(N.m)]."""
        self.runs += 1
        value, gradient = self._gradient(jnp.asarray(knots)[None], weight)
        return float(value), np.asarray(gradient)[0]

    def found(self, method: str, knots: Array) -> Found:
        """What belongs to these torques."""
        runs, loss = self.runs, float(self.losses(knots[None], WEIGHTS[-1])[0])
        motor, states = self.motion_of(jnp.asarray(knots)[None])
        theta, omega = np.asarray(states)[0].T
        return Found(method, runs, np.asarray(motor)[0], theta, omega, loss)


def first_guess() -> Array:
    """Torques [N.m] beyond the lower edge of the stick band by 0.5 N.m, along a line from LOW to HIGH."""
    line = LOW + (HIGH - LOW) * KNOTS / DURATION
    return np.array([CAM.band(angle)[0] for angle in line]) - 0.5


def by_gradient(fmu: str | Path) -> Found:
    """L-BFGS with the gradient."""
    problem, knots = Problem(fmu), first_guess()
    for weight in WEIGHTS:
        options = {"maxiter": 300, "maxcor": 40}
        result = minimize(
            problem.value_and_gradient, knots, args=(weight,), jac=True, method="L-BFGS-B", options=options
        )
        knots = result.x
    return problem.found("L-BFGS with gradients", knots)


def without_gradient(fmu: str | Path, method: str, runs: int) -> Found:
    """A method of scipy.optimize.minimize that takes values only."""
    problem, knots = Problem(fmu), first_guess()
    value: Callable[[Array, float], float] = lambda at, weight: float(problem.losses(at[None], weight)[0])  # noqa: E731
    for weight in WEIGHTS:
        options = {"maxfev": runs // len(WEIGHTS)}
        knots = minimize(value, knots, args=(weight,), method=method, options=options).x
    return problem.found(method, knots)


def by_evolution(fmu: str | Path, runs: int) -> Found:
    """Differential evolution, a whole population in one call of the fleet."""
    guess, size = first_guess(), 3 * len(KNOTS)
    crowd = Problem(fmu, size)

    def values(population: Array) -> Array:
        return crowd.losses(population.T, WEIGHTS[-1])

    result = differential_evolution(
        values,
        [(torque - 8.0, torque + 8.0) for torque in guess],
        x0=guess,
        popsize=3,
        maxiter=max(1, runs // size - 1),
        tol=0.0,
        polish=False,
        rng=SEED,
        vectorized=True,
        updating="deferred",
    )
    one = Problem(fmu)
    one.runs = crowd.runs
    return one.found("differential evolution", result.x)


def run(fmu: str | Path) -> list[Found]:
    """All four methods."""
    best = by_gradient(fmu)
    others = [without_gradient(fmu, method, best.runs) for method in ("Powell", "Nelder-Mead")]
    return [best, *others, by_evolution(fmu, GENEROUS * best.runs)]


def report(results: Sequence[Found]) -> str:
    """The results as a table."""
    lines = [f"{'method':<24}{'runs':>8}{'loss [J]':>14}{'heat [J]':>11}{'largest error [rad]':>21}"]
    lines += [f"{r.method:<24}{r.runs:>8}{r.loss:>14.4g}{r.heat:>11.3f}{r.error:>21.2g}" for r in results]
    best = results[0]
    resting = 100.0 * np.mean(best.omega[WAITS] == 0.0)
    middle = abs(best.motor[WAITS][WAITS.sum() // 2])
    lines.append(
        f"in the wait: at rest in {resting:.0f} % of the steps, half way with {middle:.1g} N.m of the motor"
    )
    return "\n".join(lines)


def picture(results: Sequence[Found], output: Path) -> None:
    """Draw angle and motor torque over time."""
    figure = Figure(figsize=(7.0, 5.5), layout="constrained")
    angle, torque = figure.subplots(2, 1, sharex=True)
    for result in results:
        strong = result is results[0]
        label = f"{result.method}, {result.runs} runs"
        angle.plot(TIME + 0.5 * STEP, result.theta, lw=2.0 if strong else 1.0, label=label)
        torque.plot(TIME, result.motor, lw=2.0 if strong else 0.8)
    for axes in (angle, torque):
        axes.axvspan(STROKE, STROKE + WAIT, color="0.93", zorder=0)
    angle.plot([STROKE, STROKE + WAIT, DURATION], [MIDDLE, MIDDLE, HIGH], "k.", ms=6, label="wanted")
    angle.set(title="The elbow is raised in two strokes with the least heat", ylabel="theta [rad]")
    angle.legend(loc="upper right")
    torque.set(ylabel="motor torque [N.m]", xlabel="time [s]", ylim=(-9.0, 9.0))
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--fmu", type=Path, default=BUILD / "DualCamForward.fmu")
    parser.add_argument("--output", type=Path, default=BUILD / "elbow_torque.png", help="picture to write")
    options = parser.parse_args(arguments)
    results = run(options.fmu)
    print(report(results))
    picture(results, options.output)
    print(f"Picture: {options.output}")


if __name__ == "__main__":
    main()
