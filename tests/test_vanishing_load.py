"""Without inertia and damping: motion along F_0 = 0, where a contact locks for F_0 of the other sign.

A torque loads the mechanism, and F_0 falls along the way (`spring.stiffness2` < 0). The mechanism moves to
F_0 = 0 and no farther: beyond, no torque loads it. If F_ext then grows, the place of F_0 = 0 moves on, and
the mechanism follows. If F_ext falls, the mechanism waits. Oracle: the root of F_s(z(theta)) + max F_ext = 0
(docs/mechanism.md, section 6).
"""

import pytest
from driver import FORWARD, OK
from pin_equations import Pin, ellipse, helix, polynomial
from reference import LOADING, LOWER_STOP, RELEASING, UPPER_STOP
from scipy.optimize import brentq

WEDGED, NEAR = 6, 1e-12
PRELOAD, BENT = 0.01, 1e5  # N, N/m2
PINS = {
    "helices": Pin(helix(0.02, 0.15), helix(0.03, 0.24)),
    "ellipse": Pin(helix(0.02, 0.15), ellipse(0.03, 0.24, 0.3, 0.1, 1)),
}
LOCKING = {
    "cam1.friction": 0.1,
    "cam2.friction": 0.8,
    "spring.stiffness": 0.0,
    "inertia.shaft": 0.0,
    "shaft.damping": 0.0,
    "damper.c_load": 0.0,
    "damper.c_release": 0.0,
    "stop.lower": -3.0,
    "stop.upper": 3.0,
}
RISING = [1e-3, 1.0]
TURNING = [1e-3, 1.0, -3.0, 4.0]  # derivatives at t = 0


def parameters(pin, way):
    """`way`: the direction of the motion; both signs of F_0 change with it."""
    return pin.values | LOCKING | {"spring.preload": way * PRELOAD, "spring.stiffness2": -way * BENT}


def angle(pin, way, push):
    """Where F_0 = 0 under F_ext = way push."""
    return brentq(lambda x: PRELOAD + push - BENT * pin.at(x).z ** 2, 0.0, way * 2.9, xtol=1e-15)


def speed(pin, theta, force_rate):
    """dF_ext/dt + dF_s/dz z' omega = 0, divided by the direction."""
    place = pin.at(theta)
    return force_rate / (2.0 * BENT * place.z * place.lift)


def play(fmu, way, pushes, t_end, parts, torques=(1.0,)):
    """F_ext and tau are polynomials of the time in the direction `way`. Yields the ends of the parts."""
    h = t_end / parts
    for k in range(parts):
        now = {
            name: [way * polynomial(u[order:], k * h) for order in range(len(u))]
            for name, u in (("F_ext", pushes), ("tau", torques))
        }
        fmu.set({name: u[0] for name, u in now.items()})
        fmu.set_derivatives({name: u[1:] for name, u in now.items() if u[1:]})
        assert fmu.call("fmi2DoStep", k * h, h, 1) == OK, fmu.messages[-1].text
        yield (k + 1) * h


@pytest.fixture(params=list(PINS))
def pin(request):
    return PINS[request.param]


@pytest.fixture(params=[1, -1], ids=["loading", "releasing"])
def way(request):
    return request.param


@pytest.mark.parametrize("parts", [1, 3, 40])
def test_the_mechanism_follows_the_place_where_the_load_vanishes(make_model, pin, way, parts):
    fmu = make_model(FORWARD).start(parameters(pin, way))
    for t in play(fmu, way, RISING, 0.5, parts):
        theta = angle(pin, way, polynomial(RISING, t))
        assert fmu.get("theta") == pytest.approx(theta, rel=NEAR)
        assert fmu.get("omega") == pytest.approx(speed(pin, theta, RISING[1]), rel=1e-10)
        assert fmu.get("mode") == (LOADING if way > 0 else RELEASING)
        assert abs(fmu.get("energy.residual")) < 1e-15


@pytest.mark.parametrize("parts", [1, 3, 40])
def test_the_mechanism_waits_while_the_load_holds_the_contacts(make_model, pin, way, parts):
    """F_ext rises to 0.5 s, falls, and from 1.25 s on rises above its first height. A start at F_0 = 0."""
    highest, start = polynomial(TURNING, 0.5), angle(pin, way, TURNING[0])
    fmu = make_model(FORWARD).start(parameters(pin, way) | {"initial.theta": start})
    for t in play(fmu, way, TURNING, 1.5, parts):
        reached = max(polynomial(TURNING, t), highest if t > 0.5 else 0.0)
        assert fmu.get("theta") == pytest.approx(angle(pin, way, reached), rel=NEAR)
        rises = t < 0.5 or polynomial(TURNING, t) > highest
        assert fmu.get("mode") == ((LOADING if way > 0 else RELEASING) if rises else WEDGED)


@pytest.mark.parametrize("parts", [1, 3, 40])
def test_a_stop_ends_the_way(make_model, pin, way, parts):
    """The mechanism reaches the stop at 0.25 s."""
    stop = angle(pin, way, polynomial(RISING, 0.25))
    limit = {"stop.upper" if way > 0 else "stop.lower": stop}
    fmu = make_model(FORWARD).start(parameters(pin, way) | limit)
    for t in play(fmu, way, RISING, 0.5, parts):
        theta = stop if t > 0.25 else angle(pin, way, polynomial(RISING, t))
        assert fmu.get("theta") == pytest.approx(theta, rel=NEAR)
    assert fmu.get("theta") == stop
    assert fmu.get("mode") == (UPPER_STOP if way > 0 else LOWER_STOP)


def test_a_step_too_short_for_the_digits_of_the_load_moves_by_rounding(make_model, pin, way):
    start = angle(pin, way, RISING[0])
    fmu = make_model(FORWARD).start(parameters(pin, way) | {"initial.theta": start})
    assert list(play(fmu, way, RISING, 1e-25, 1))
    assert fmu.get("theta") == pytest.approx(start, rel=1e-15)


@pytest.mark.parametrize("parts", [1, 3])
def test_the_motion_ends_where_the_torque_vanishes(make_model, pin, way, parts):
    """The torque falls to zero at 0.25 s. Then it pulls back, less than the edge of the band."""
    fmu = make_model(FORWARD).start(parameters(pin, way))
    for t in play(fmu, way, RISING, 0.3, parts, (1e-3, -4e-3)):
        assert fmu.get("theta") == pytest.approx(angle(pin, way, polynomial(RISING, min(t, 0.25))), rel=NEAR)


@pytest.mark.parametrize("parts", [1, 3])
def test_derivatives_along_the_place_where_the_load_vanishes(make_model, pin, way, parts):
    """dF_ext + dF_s/dz z' dtheta = 0. Of the speed: by a central difference of its closed form. The angle
    at the start of the step does not count."""
    fmu, small = make_model(FORWARD).start(parameters(pin, way)), 1e-5
    for t in play(fmu, way, RISING, 0.5, parts):
        push = polynomial(RISING, t)
        theta, force = angle(pin, way, push), RISING[1]
        speeds = [speed(pin, angle(pin, way, push + d), force) for d in (-small, small)]
        assert fmu.get("step.dtheta_dF_ext") == pytest.approx(way * speed(pin, theta, 1.0), rel=1e-9)
        assert fmu.get("step.domega_dF_ext") == pytest.approx(
            way * (speeds[1] - speeds[0]) / (2 * small), rel=1e-6
        )
        assert fmu.get("step.dtheta_dtau") == fmu.get("step.dtheta_dtheta") == 0.0
