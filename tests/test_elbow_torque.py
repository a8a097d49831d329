"""The torque trajectory of least heat: what the example promises, and the table of docs/use-gradients.md."""

import numpy as np
import pytest
from driver import ROOT
from scipy.optimize import minimize

pytest.importorskip("jax")

from system_examples import elbow_torque as example

FORWARD = ROOT / "build/DualCamForward.fmu"


@pytest.fixture(scope="module")
def best():
    return example.by_gradient(FORWARD)


def test_the_cam_holds_the_arm_in_the_wait(best):
    assert best.error < 5e-4
    waiting = example.WAITS & (np.arange(len(example.TIME)) > 260)
    assert (best.omega[waiting] == 0.0).mean() > 0.8
    middle = np.flatnonzero(example.WAITS)[example.WAITS.sum() // 2]
    assert abs(best.motor[middle]) < 0.05


def test_another_start_finds_the_same_loss(best):
    """From torques that carry the arm along two smooth strokes."""
    phase = np.clip([example.KNOTS, example.KNOTS - example.STROKE - example.WAIT], 0.0, example.STROKE)
    first, second = (s**2 * (3.0 - 2.0 * s) for s in phase / example.STROKE)
    theta = example.LOW + (example.MIDDLE - example.LOW) * first + (example.HIGH - example.MIDDLE) * second
    knots = np.array([example.CAM.band(angle)[0] for angle in theta]) - 0.5
    problem = example.Problem(FORWARD)
    for weight in example.WEIGHTS:
        knots = minimize(
            problem.value_and_gradient,
            knots,
            (weight,),
            "L-BFGS-B",
            jac=True,
            options={"maxiter": 300, "maxcor": 40},
        ).x
    assert problem.found("again", knots).loss == pytest.approx(best.loss, rel=1e-3)


def test_gradient_is_that_of_the_losses(best):
    problem, knots = example.Problem(FORWARD), example.first_guess()
    direction = np.random.default_rng(2).normal(size=len(knots))
    _, gradient = problem.value_and_gradient(knots, 100.0)
    size, weights = 1e-3, {1: 0.75, 2: -0.15, 3: 1 / 60}

    def loss(k: float) -> float:
        return problem.losses((knots + k * size * direction)[None], 100.0)[0]

    expected = sum(w * (loss(k) - loss(-k)) for k, w in weights.items()) / size
    assert gradient @ direction == pytest.approx(expected, rel=1e-6)


def test_methods_without_gradients_are_far_behind(best):
    """With as many runs."""
    for method in ("Powell", "Nelder-Mead"):
        assert example.without_gradient(FORWARD, method, best.runs).loss > 20.0 * best.loss


def test_numbers_of_the_page(best):
    rows = (ROOT / "docs/use-gradients.md").read_text().splitlines()
    (row,) = (row for row in rows if row.startswith("| L-BFGS with gradients"))
    runs, loss, heat, error = (float(cell) for cell in row.split("|")[2:-1])
    assert best.runs == pytest.approx(runs, rel=0.3)  # rounding decides when a search ends
    assert (best.loss, best.heat) == pytest.approx((loss, heat), abs=0.01)
    assert best.error == pytest.approx(error, rel=0.1)
