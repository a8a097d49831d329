"""dualcam.gradient: the gradient of a loss through 1000 steps of stick and slip against differences, in
NumPy, JAX and PyTorch."""

import math

import numpy as np
import pytest

from dualcam import Fleet
from dualcam.errors import DualcamError, FmuError, UnknownVariableError
from dualcam.gradient import DifferentiableFleet, jax_rollout, torch_rollout

COUNT, STEPS, H = 6, 1000, 2e-3
PARAMETERS = ("cam1.friction", "cam2.friction", "spring.stiffness", "damper.c_load")
NOMINAL = np.array([0.14, 0.12, 5e4, 20.0])
SCALE = np.array([1e-2, 1e-2, 1e3, 5.0])  # of changes
START = np.array([0.4, 0.0])
STRIBECK = {"cam1.friction_peak": 1.4, "cam1.stribeck_velocity": 0.05, "cam2.friction_viscous": 0.2}
ELLIPSES = {"cam1.profile": 2, "cam2.profile": 2, "cam2.radius": 0.025, "cam2.lead_angle": 0.7}
SCENES = {
    "helices": {},
    "helices that bounce": {"stop.restitution": 0.6, "stop.upper": 0.75, "stop.lower": 0.1},
    "Stribeck": STRIBECK,
    "ellipses": ELLIPSES | {"inertia.follower_mass": 0.3, "stop.restitution": 0.5, "stop.upper": 0.7},
    "without inertia, damped": {"inertia.shaft": 0.0, "damper.c_release": 30.0},
    "play": {"inertia.shaft": 0.0, "damper.c_load": 0.0},
}


def arguments(seed: int = 3, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Slow torques of several waves each: every instance sticks and slips in both directions."""
    random = np.random.default_rng(seed)
    time = H * np.arange(STEPS)
    waves = random.uniform(0.5, 1.5, (COUNT, 3, 1)) * np.sin(
        2.0 * math.pi * random.uniform(0.5, 4.0, (COUNT, 3, 1)) * time + random.uniform(0, 6, (COUNT, 3, 1))
    )
    u = (3.0 + waves.sum(axis=1) + noise * random.normal(size=(COUNT, STEPS)))[:, :, None]
    return np.tile(START, (COUNT, 1)), u, np.tile(NOMINAL, (COUNT, 1))


def loss_and_slope(states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A loss of each instance, of the angles and speeds all along; and its derivative by the states."""
    weight = np.cos(0.01 * np.arange(states.shape[1]))[:, None] * [1.0, 0.02]
    return (weight * states**2).sum(axis=(1, 2)), 2.0 * weight * states


def directions(seed: int, by_damping: bool) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Random changes of start, inputs and parameters."""
    random = np.random.default_rng(seed)
    none = np.zeros((COUNT, 2)), np.zeros((COUNT, STEPS, 1)), np.zeros((COUNT, 4))
    parameters = random.normal(size=(COUNT, 4)) * SCALE * [1.0, 1.0, 1.0, by_damping]
    return {
        "start": (random.normal(size=(COUNT, 2)) * [1e-2, 0.0], *none[1:]),
        "inputs": (none[0], 0.1 * random.normal(size=(COUNT, STEPS, 1)), none[2]),
        "parameters": (*none[:2], parameters),
    }


class Losses:
    """The losses of a scene by runs without derivatives."""

    def __init__(self, values: dict) -> None:
        self.fleet = Fleet("forward", COUNT, parameters=values | {"initial.theta": 0.4}, tolerance=1e-11)

    def __call__(self, start: np.ndarray, u: np.ndarray, p: np.ndarray) -> np.ndarray:
        first = dict(zip(("initial.theta", "initial.omega"), start.T, strict=True))
        self.fleet.reset(parameters=first | dict(zip(PARAMETERS, p.T, strict=True)))
        return loss_and_slope(self.fleet.rollout(u, H))[0]

    def slopes(self, at: tuple, direction: tuple) -> np.ndarray:
        """Differences of order 6, one row for each size of the change."""
        weights = {1: 0.75, 2: -0.15, 3: 1 / 60}

        def shifted(size: float) -> np.ndarray:
            return self(*(a + size * d for a, d in zip(at, direction, strict=True)))

        sizes = [0.1 * 0.25**n for n in range(8)]
        return np.array(
            [sum(w * (shifted(k * e) - shifted(-k * e)) for k, w in weights.items()) / e for e in sizes]
        )


@pytest.mark.parametrize("name", SCENES)
def test_through_1000_steps_of_stick_and_slip(name):
    values = {known: value for known, value in SCENES[name].items() if known not in PARAMETERS}
    # without inertia and damping the largest torque counts; smooth torques have two that are nearly equal
    start, u, p = arguments(noise=0.3 if name == "play" else 0.0)
    damped = SCENES[name].get("damper.c_load") != 0.0
    p[:, 3] *= damped
    losses = Losses(values)
    with DifferentiableFleet(
        "forward", COUNT, H, parameters=PARAMETERS, values=values, tolerance=1e-11
    ) as fleet:
        run = fleet.rollout(start, u, p)
    loss, slope = loss_and_slope(run.states)
    assert loss.tolist() == losses(start, u, p).tolist()  # the motion is that of a plain fleet
    rests = (np.diff(run.states[:, :, 0], axis=1) == 0.0).mean(axis=1)
    assert rests.min() > 0.2 and rests.max() < 0.9
    assert losses.fleet.get("events").min() > 8
    found = run.gradient(slope)
    for direction in directions(7, damped).values():
        parts = zip((found.start, found.inputs, found.parameters), direction, strict=True)
        exact = sum((part * change).reshape(COUNT, -1).sum(axis=1) for part, change in parts)
        differences = losses.slopes((start, u, p), direction)
        error = np.abs(differences - exact).min(axis=0)
        assert (error <= 1e-6 * np.abs(exact) + 1e-11).all(), (error, exact)


# ---- JAX and PyTorch ----


@pytest.fixture
def jax():
    jax = pytest.importorskip("jax")
    before = jax.config.read("jax_enable_x64")
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


@pytest.fixture
def fleet():
    with DifferentiableFleet("forward", COUNT, H, parameters=PARAMETERS) as fleet:
        yield fleet


def expected_of(fleet: DifferentiableFleet) -> tuple[np.ndarray, list[np.ndarray]]:
    run = fleet.rollout(*arguments())
    loss, slope = loss_and_slope(run.states)
    found = run.gradient(slope)
    return loss.sum(), [found.start, found.inputs, found.parameters]


@pytest.mark.parametrize("compiled", [False, True])
def test_jax_has_the_same_gradient(jax, fleet, compiled):
    run = jax_rollout(fleet)
    weight = np.cos(0.01 * np.arange(STEPS))[:, None] * [1.0, 0.02]

    def loss(start, u, p):
        return (weight * run(start, u, p) ** 2).sum()

    value_and_gradient = jax.value_and_grad(loss, argnums=(0, 1, 2))
    value, found = (jax.jit(value_and_gradient) if compiled else value_and_gradient)(*arguments())
    expected, gradient = expected_of(fleet)
    assert value == pytest.approx(expected, rel=1e-12)
    for part, known in zip(found, gradient, strict=True):
        np.testing.assert_allclose(part, known, rtol=1e-9, atol=1e-12 * np.abs(known).max())


def test_a_loop_of_jax_around_single_steps(jax, fleet):
    """A controller in JAX sets the torque of each step from the state: runs of one step in jax.lax.scan."""
    run = jax_rollout(fleet)
    start, _, p = arguments()

    def loss(gain):
        def step(state, target):
            torque = 3.0 + gain * (target - state[:, :1]) - 0.05 * state[:, 1:]
            after = run(state, torque[:, None, :], p)[:, 0]
            return after, (after[:, 0] - target) ** 2

        targets = 0.4 + 0.2 * np.sin(0.1 * np.arange(60))
        return jax.lax.scan(step, start, targets)[1].sum()

    found, size = jax.grad(loss)(20.0), 1e-4
    weights = {1: 0.75, 2: -0.15, 3: 1 / 60}
    expected = sum(w * (loss(20.0 + k * size) - loss(20.0 - k * size)) for k, w in weights.items()) / size
    assert abs(expected) > 1e-4
    assert found == pytest.approx(float(expected), rel=1e-6)


def test_jax_in_32_bits_is_refused(jax, fleet):
    run = jax_rollout(fleet)
    jax.config.update("jax_enable_x64", False)
    for use in (lambda: jax_rollout(fleet), lambda: run(*arguments())):
        with pytest.raises(DualcamError, match=r'jax\.config\.update\("jax_enable_x64", True\)'):
            use()


def test_torch_has_the_same_gradient(fleet):
    torch = pytest.importorskip("torch", reason="pip install torch")
    given = [torch.tensor(argument, requires_grad=True) for argument in arguments()]
    weight = torch.tensor(np.cos(0.01 * np.arange(STEPS))[:, None] * [1.0, 0.02])
    value = (weight * torch_rollout(fleet)(*given) ** 2).sum()
    value.backward()
    expected, gradient = expected_of(fleet)
    assert value.item() == pytest.approx(expected, rel=1e-12)
    with torch.no_grad():
        assert (weight * torch_rollout(fleet)(*given) ** 2).sum() == value
    for tensor, known in zip(given, gradient, strict=True):
        np.testing.assert_allclose(tensor.grad, known, rtol=1e-9, atol=1e-12 * np.abs(known).max())


# ---- where no derivative exists, and wrong use ----


def test_at_rest_and_on_the_edge_the_torque_moves_nothing():
    with Fleet("forward", 1, parameters={"initial.theta": 0.4}) as plain:
        edge = float(plain.get("torque_load")[0])
    with DifferentiableFleet("forward", 2, 1e-2) as fleet:
        run = fleet.rollout([[0.4, 0.0]] * 2, [[[0.9 * edge]], [[edge]]])
    assert run.states[:, 0].tolist() == [[0.4, 0.0]] * 2
    assert run.jacobians[:, 0].tolist() == [[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]] * 2


def test_states_without_jacobians_are_the_same(fleet):
    assert fleet.states(*arguments()).tobytes() == fleet.rollout(*arguments()).states.tobytes()


def test_jax_reads_jacobians_only_for_a_gradient(jax, fleet, monkeypatch):
    run = jax_rollout(fleet)
    expected = fleet.rollout(*arguments()).states
    monkeypatch.delattr(DifferentiableFleet, "rollout")
    assert np.asarray(run(*arguments())).tobytes() == expected.tobytes()


def test_a_closed_fleet_makes_no_run():
    fleet = DifferentiableFleet("forward", 1, H)
    fleet.close()
    for run in (fleet.rollout, fleet.states):
        with pytest.raises(FmuError, match="this fleet is closed"):
            run([[0.4, 0.0]], [[[0.0]]])


def test_every_run_begins_anew(fleet):
    first = fleet.rollout(*arguments())
    fleet.rollout(*arguments(seed=4))
    again = fleet.rollout(*arguments())
    assert again.jacobians.tobytes() == first.jacobians.tobytes()
    assert again.states.tobytes() == first.states.tobytes()


def test_the_gradient_by_u_is_named_inputs(fleet):
    run = fleet.rollout(*arguments())
    with pytest.raises(AttributeError, match="inputs is the gradient by u"):
        _ = run.gradient(np.ones_like(run.states)).u


@pytest.mark.parametrize(
    ("options", "mentions"),
    [
        (
            {"parameters": ["cam1.radius"]},
            r"'cam1.radius': allowed here are cam1.friction, cam1",
        ),
        ({"inputs": ["theta"]}, "by 'theta': allowed here are tau, F_ext"),
        ({"fmu": "inverse"}, "by 'tau': allowed here are none"),
        ({"values": {"initial.theta": 0.3}}, "values has initial.theta"),
        ({"values": {"cam1.friction": 0.3}, "parameters": ["cam1.friction"]}, "values has cam1.friction"),
        (
            {"parameters": {"cam1.friction": 0.3}},
            r"allowed is a list of names.*values=\{\.\.\.\} sets those of other parameters",
        ),
        ({"step": 0.0}, "step = 0.0: allowed is a finite number > 0, in s"),
    ],
)
def test_wrong_use_is_refused(options, mentions):
    with pytest.raises((FmuError, UnknownVariableError), match=mentions):
        DifferentiableFleet(**{"fmu": "forward", "count": 1, "step": 1e-3} | options)


def test_wrong_shapes_are_refused(fleet):
    start, u, p = arguments()
    for wrong in ((start[:, :1], u, p), (start, u[0], p), (start, u, p[:, :2])):
        with pytest.raises(FmuError, match="has shape"):
            fleet.rollout(*wrong)
