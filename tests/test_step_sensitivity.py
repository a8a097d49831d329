"""step.dtheta_dtau and step.domega_dtau against differences of the FMU itself: the step is made again from a
snapshot with the torque of the whole step shifted."""

import math
from itertools import pairwise
from typing import NamedTuple

import pytest
from driver import OK, Driver, models
from mechanisms import ELLIPSES, FOLLOWER, FORCES

FORWARD = models["DualCamForward"]
NAMES = ("step.dtheta_dtau", "step.domega_dtau")
TIGHT = 1e-12  # tolerance of the integration: differences of it are divided by the shift
FLAT = {"cam1.profile": 2, "cam1.ellipse_a": 0.08, "cam1.ellipse_b": 0.05, "cam2.lead_angle": 0.5}
MASSLESS = {"inertia.shaft": 0.0}
VISCOUS = MASSLESS | {"damper.c_load": 2000.0, "damper.c_release": 3000.0}
# The spring's force rises to 118 N at theta = 0.4, falls until 0.7, is back at 118 N at 0.85, and rises on.
SNAPPING = {"spring.stiffness": 42e3, "spring.stiffness2": -8.25e6, "spring.stiffness3": 5e8}
# The spring's force falls, and the torque grows all the same: both grooves steepen.
SOFTENING = {"spring.stiffness": 0.0, "spring.stiffness2": -1e5, "stop.upper": 0.9}
STEEPENING = {"cam1.ellipse_curvature": 1, "cam2.ellipse_curvature": 1}
ROOT = MASSLESS | {"damper.q_load": 1e3, "damper.q_release": 1e3}  # its speed is a root of the torque


class Scene(NamedTuple):
    values: dict
    tau: float
    h: float = 0.02
    rates: tuple[float, ...] = ()
    mode: int = 2  # at the end
    events: int = 0  # in the step
    size: float = 1e-2  # N.m, of the shift


def shifted(fmu: Driver, state, scene: Scene, shift: float) -> tuple[float, float]:
    fmu.restore(state)
    fmu.time = 0.0
    fmu.set({"tau": scene.tau + shift})
    if scene.rates:
        fmu.set_derivatives({"tau": list(scene.rates)})
    fmu.step(scene.h)
    return fmu.get("theta"), fmu.get("omega")


def differences(fmu: Driver, state, scene: Scene) -> list[float]:
    """Central, of order 6; made at the shift at which it agrees best with one of half the size."""
    weights = {1: 45.0, 2: -9.0, 3: 1.0}

    def at(size: float) -> list[float]:
        pairs = {
            k: (shifted(fmu, state, scene, k * size), shifted(fmu, state, scene, -k * size)) for k in weights
        }
        return [
            math.fsum(w * (pairs[k][0][i] - pairs[k][1][i]) for k, w in weights.items()) / (60.0 * size)
            for i in range(2)
        ]

    found = [at(scene.size * 0.25**n) for n in range(3)]
    return [min(pairwise([f[i] for f in found]), key=lambda p: abs(p[1] - p[0]))[0] for i in range(2)]


def begin(make_model, scene: Scene):
    fmu = make_model(FORWARD).start(scene.values | {"tau": scene.tau}, tolerance=TIGHT)
    return fmu, fmu.take()


def read(fmu: Driver) -> list[float]:
    return [fmu.get(name) for name in NAMES]


def assert_close(found: list[float], expected: list[float]) -> None:
    for a, b in zip(found, expected, strict=True):
        assert abs(a - b) <= 1e-6 * abs(b) + 1e-12, (found, expected)


def check(make_model, scene: Scene) -> list[float]:
    fmu, state = begin(make_model, scene)
    before = fmu.get("events")
    expected = differences(fmu, state, scene)
    shifted(fmu, state, scene, 0.0)
    found = read(fmu)
    assert (fmu.get("mode"), fmu.get("events") - before) == (scene.mode, scene.events)
    assert_close(found, expected)
    fmu.free_state(state)
    return found


SLIP = {"initial.theta": 0.4, "initial.omega": 2.0}
FAST = {"initial.theta": 1.2, "initial.omega": 20.0}
REST = {"initial.theta": 0.4}
LOW = {"initial.theta": 0.2}
SCENES = {
    "helices": Scene(SLIP, 5.0, 0.01),
    "helices, ramp": Scene(SLIP, 5.0, 0.01, (20.0,)),
    "helices, parabola": Scene(SLIP, 5.0, 0.01, (20.0, 1e3)),
    "helices, cubic": Scene(SLIP, 5.0, 0.01, (20.0, 1e3, 1e5)),
    "helices, follower and damper": Scene(SLIP | FOLLOWER | {"damper.c_load": 100.0}, 5.0, 0.01),
    "helices, releasing": Scene({"initial.theta": 1.2, "initial.omega": -1.0}, 0.5, 0.02, mode=3),
    "helices, overdamped": Scene(SLIP | {"damper.c_load": 1e5}, 8.0, 0.2, size=1.0),
    "cubic spring": Scene(SLIP | {"spring.stiffness3": 1e6}, 5.0, 0.01),
    "ellipses": Scene(SLIP | ELLIPSES, 5.0, 0.01),
    "ellipses, all forces, cubic": Scene(SLIP | ELLIPSES | FORCES | FOLLOWER, 5.0, 0.01, (20.0, 1e3, 1e5)),
    "ellipse and helix, releasing": Scene(
        FLAT | FORCES | FOLLOWER | {"initial.theta": 1.0, "initial.omega": -1.0}, 0.2, mode=3
    ),
    # events inside the step
    "to rest": Scene(SLIP, 3.0, 0.05, mode=1, events=1),
    "to rest, ellipses": Scene(SLIP | ELLIPSES | FORCES, 2.0, 0.05, mode=1, events=1, size=1e-3),
    "reverses": Scene(SLIP | {"initial.theta": 1.0}, 1.0, 0.02, mode=3, events=1),
    "reverses, ellipses": Scene(SLIP | ELLIPSES | FORCES | FOLLOWER, 0.0, 0.02, mode=3, events=1),
    "breakaway": Scene(REST, 3.0, 0.05, (100.0,), events=1),
    "breakaway, ellipses": Scene(LOW | ELLIPSES | FORCES, 1.0, 0.035, (100.0,), events=1, size=1e-3),
    "breakaway, to rest": Scene(REST, 3.0, 0.03, (100.0, -8e3), mode=1, events=2, size=1e-3),
    "stop that bounces": Scene(FAST | {"stop.restitution": 0.5}, 12.0, events=2),
    "stop that bounces, ellipses": Scene(
        FAST | ELLIPSES | FORCES | FOLLOWER | {"stop.restitution": 0.8},
        8.0,
        0.01,
        mode=3,
        events=1,
        size=1e-3,
    ),
    "stop that does not": Scene(FAST, 32.0, mode=5, events=1),
    "stop, then lets go": Scene(FAST, 20.0, 0.03, (-900.0,), mode=3, events=3),
    # without inertia, damped
    "viscous": Scene(REST | VISCOUS, 8.0, 0.05),
    "viscous, ramp": Scene(REST | VISCOUS, 3.0, 0.05, (100.0,), events=1),
    "viscous, to rest": Scene(REST | VISCOUS, 8.0, 0.1, (-40.0,), mode=1, events=1),
    "viscous, ellipses, reverses": Scene(
        REST | VISCOUS | ELLIPSES, 8.0, 0.1, (-120.0,), mode=3, events=2, size=1e-3
    ),
    "viscous, ellipses, all forces": Scene(
        REST | ELLIPSES | FORCES | MASSLESS, 2.4, 0.003, (40.0,), events=1, size=1e-3
    ),
    "viscous, to the stop": Scene(REST | VISCOUS | {"initial.theta": 1.3}, 20.0, 0.05, mode=5, events=1),
    # without inertia and damping
    "play": Scene(LOW | MASSLESS, 5.0, mode=1, events=1),
    "play, ramp": Scene(LOW | MASSLESS, 1.5, 0.1, (20.0,), events=1),
    "play, ellipses": Scene(LOW | MASSLESS | ELLIPSES, 1.0, 0.03, (50.0,), events=1, size=1e-3),
    "play, up and back": Scene(LOW | MASSLESS | FLAT, 0.9, 0.04, (100.0, -4e3), mode=1, events=2, size=1e-3),
    "play, up and down": Scene(LOW | MASSLESS | FLAT, 0.9, 0.066, (100.0, -3e3), mode=3, events=3, size=1e-3),
    "play, the load changes its sign": Scene(
        MASSLESS | {"stop.lower": -1.0, "initial.theta": -0.3}, -1.0, 0.03, (100.0,), events=1
    ),
    "play, ellipses, the load changes its sign": Scene(
        MASSLESS | ELLIPSES | {"stop.lower": -0.4, "initial.theta": -0.3}, -1.0, 0.03, (100.0,), size=1e-3
    ),
    "play, steeper ellipses, the spring softens": Scene(
        LOW | MASSLESS | ELLIPSES | STEEPENING | SOFTENING, 0.5, 0.03, (10.0,), events=1, size=1e-3
    ),
    "play, past a fold": Scene(
        MASSLESS | SNAPPING | {"initial.theta": 0.38}, 1.55, 0.03, (10.0, 20.0), events=1
    ),
    "play, to the stop": Scene(LOW | MASSLESS, 20.0, mode=5, events=1),
    # at rest
    "stick": Scene(REST, 3.0, mode=1),
    "stick, ramp": Scene(REST, 3.0, 0.01, (20.0,), mode=1),
}


def scenes_of_law(laws: dict) -> dict[str, Scene]:
    """With friction that varies."""
    return {
        "slip": Scene(SLIP | laws, 6.0, 0.01, size=1e-3),
        "slip, ellipses": Scene(SLIP | laws | ELLIPSES, 6.0, 0.01, size=1e-3),
        "to rest": Scene(SLIP | laws, 3.0, 0.05, mode=1, events=1, size=1e-3),
        "breakaway": Scene(REST | laws, 3.0, 0.03, (100.0,), events=1, size=1e-4),
    }


STEADY = ("play, ramp", "play, the load changes its sign")  # helices: the speed depends on the ramp alone


@pytest.mark.parametrize("name", SCENES)
def test_agrees_with_differences(make_model, name):
    scene = SCENES[name]
    found = check(make_model, scene)
    if name.startswith("stick") or scene.mode == 5:
        assert found == [0.0, 0.0]
    else:
        assert found[0] != 0.0
        assert (found[1] != 0.0) == (scene.mode in (2, 3) and name not in STEADY)


@pytest.mark.parametrize("inertia", [0.002, 0.0])
def test_table(make_model, tmp_path, inertia):
    table = tmp_path / "groove.csv"
    lines = [f"{psi:.2f},{0.02 * (psi + 0.2 * psi**2)!r}" for psi in (0.05 * k for k in range(40))]
    table.write_text("psi_rad,z_m\n" + "\n".join(lines) + "\n")
    values = {"cam1.profile": 3, "cam1.table": str(table), "inertia.shaft": inertia, "damper.c_load": 500.0}
    check(make_model, Scene(REST | values, 3.0, 0.03, (80.0,), events=1, size=1e-3))


def test_a_jump_that_comes_later(make_model):
    """F_ext lets go of a mechanism that a contact locks: it jumps when F_0 changes its sign."""
    values = {
        "initial.theta": 0.6,
        "cam1.friction": 0.0,
        "cam2.friction": 0.3,
        "cam1.lead_angle": 0.37588677045705815,
        "cam2.lead_angle": 0.2964195539177492,
        "cam2.profile": 2,
        "cam2.ellipse_a": 0.08,
        "cam2.ellipse_b": 0.035,
        "spring.preload": 100.0,
        "tau": -0.02,
    }
    fmu = make_model(FORWARD).start(values | MASSLESS, tolerance=TIGHT)
    state = fmu.take()

    def end(shift: float) -> float:
        fmu.restore(state)
        fmu.time = 0.0
        fmu.set({"tau": -0.02 + shift})
        fmu.set_derivatives({"F_ext": [-2e4]})
        fmu.step(0.03)
        return fmu.get("theta")

    theta = end(0.0)
    found = read(fmu)
    size = 1e-4
    expected = (45.0 * (end(size) - end(-size)) - 9.0 * (end(2 * size) - end(-2 * size))) / 60.0 / size
    expected += (end(3 * size) - end(-3 * size)) / 60.0 / size
    assert 0.0 < theta < 1.3963
    assert abs(expected) > 0.1
    assert found == [pytest.approx(expected, rel=1e-6), 0.0]


@pytest.mark.parametrize("values", [{}, ELLIPSES])
def test_of_quadratic_damping_alone(make_model, values):
    """The speed is a root of the torque; its derivative has a pole where the motion begins: 0, as written."""
    fmu = make_model(FORWARD).start(LOW | ROOT | values)
    fmu.set({"tau": 1.0})
    fmu.set_rates(tau=50.0)
    fmu.step(0.03)
    assert fmu.get("omega") > 0.0
    assert read(fmu) == [0.0, 0.0]


@pytest.mark.parametrize("values", [{}, ELLIPSES])
def test_of_the_step_as_it_was_made(make_model, values):
    """Neither inputs nor tunable parameters that are set afterwards change it; the next step has its own."""
    start = SLIP | values | {"tau": 5.0}
    fmu = make_model(FORWARD).start(start, tolerance=TIGHT)
    assert read(fmu) == [0.0, 0.0]
    fmu.set_rates(tau=20.0)
    fmu.step(0.01)
    found = read(fmu)
    fmu.set({"tau": 1.0, "F_ext": 30.0})
    assert read(fmu) == found
    for name, value in {"cam1.friction": 0.2, "spring.stiffness3": 1e6, "damper.q_load": 30.0}.items():
        fmu.set({name: value})
        assert read(fmu) == found
    copy = make_model(FORWARD).start(start)
    content = fmu.to_bytes(fmu.take())
    status, state = copy.try_from_bytes(content)
    assert status == OK
    copy.restore(state)
    copy.time = fmu.time
    assert read(copy) == found
    for one in (fmu, copy):
        one.step(0.005)
    assert read(copy) == read(fmu) != found
    assert fmu.to_bytes(fmu.take()) == copy.to_bytes(copy.take())


def test_reading_changes_nothing(make_model):
    watched, left_alone = (
        make_model(FORWARD).start(SLIP | ELLIPSES | {"stop.restitution": 0.5}) for _ in range(2)
    )
    for k in range(40):
        tau = 8.0 * math.sin(0.4 * k)
        watched.step(0.01, tau=tau)
        left_alone.step(0.01, tau=tau)
        assert all(map(math.isfinite, read(watched)))
        assert watched.to_bytes(watched.take()) == left_alone.to_bytes(left_alone.take())


def test_the_ledger_does_not_matter(make_model):
    with_it, without = (
        make_model(FORWARD).start(SLIP | ELLIPSES | {"ledger": ledger}) for ledger in (True, False)
    )
    for fmu in (with_it, without):
        fmu.step(0.01, tau=5.0)
    assert read(with_it) == read(without)


def test_a_refused_step_leaves_that_of_the_last(make_model):
    fmu = make_model(FORWARD).start(SLIP)
    fmu.step(0.01, tau=5.0)
    found = read(fmu)
    fmu.refused("fmi2DoStep", 7.0, 0.01, 1)
    assert read(fmu) == found
