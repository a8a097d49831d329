"""Scenes at the border of what happens every day, in one table.

Each is played whole and cut into steps. The reference of verification/domain decides by docs/mechanism.md,
sections 3, 6 and 9, alone: angle, speed, mode and events agree with it, the energy closes, and no heat falls.
Where a groove is sampled, a closed form takes the place of the reference. What has no answer is refused, and
the message names what would work.
"""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from reference import LOADING, RELEASING, STICK, WEDGED, write_table

from verification.domain.domain import REFUSED, UNIQUE, classify
from verification.domain.mechanics import Mechanism
from verification.domain.play import cut, falling_heats, play, residual
from verification.domain.reference import Interval, solve

TOLERANCE, LIMIT = 1e-9, 10.0  # of the FMU; allowed errors, in tolerances
HALVES, MANY = (0.5,), tuple(np.arange(1, 20) / 20)
# s: from less than a unit in the last place of a time to far beyond the range in which rounding decides
DISTANCES = [0.0, *(s * d for d in (1e-17, 3e-16, 5e-15, 1e-12, 1e-9, 1e-5) for s in (1, -1))]


class Scene(NamedTuple):
    params: dict
    intervals: list[Interval]
    cuts: tuple[tuple[float, ...], ...] = (HALVES, MANY)  # shares of each interval
    counts: bool = True  # rounding does not make events of no duration


def both(**values):
    return {f"cam{i}.{name}": value for i in (1, 2) for name, value in values.items()}


def scales(scene, points):
    """rad and rad/s in which errors are measured."""
    p, path = scene.params, [scene.params.get("initial.theta", 0.0), *(point.theta for point in points)]
    mean = [abs(b - a) / i.duration for (a, b), i in zip(pairwise(path), scene.intervals, strict=True)]
    span = p.get("stop.upper", 1.3963) - p.get("stop.lower", 0.0)
    return span, max(1e-6, abs(p.get("initial.omega", 0.0)), *mean, *(abs(point.omega) for point in points))


def check(library, scene):
    verdict = classify(scene.params, scene.intervals[0].f_ext[0])
    assert verdict.kind != REFUSED and not verdict.border
    points = solve(scene.params, scene.intervals, verdict.kind == UNIQUE)
    span, fastest = scales(scene, points)
    follows_band = not (Mechanism(scene.params).inertial or Mechanism(scene.params).damped)
    for cuts in [(), *scene.cuts]:
        parts = [cut(i, [share * i.duration for share in cuts]) for i in scene.intervals]
        rows = play(library, scene.params, parts, TOLERANCE)
        assert falling_heats(rows) == [], cuts
        for row, point in zip(rows, points, strict=True):
            assert row["theta"] == pytest.approx(point.theta, rel=0, abs=LIMIT * TOLERANCE * span), cuts
            if not follows_band:
                assert row["omega"] == pytest.approx(point.omega, rel=0, abs=LIMIT * TOLERANCE * fastest), (
                    cuts
                )
            assert row["mode"] == point.mode, cuts
            assert point.doubtful or not scene.counts or row["events"] == point.events, cuts
            assert residual(row) <= TOLERANCE, cuts


# ---- a torque on the edge of the stick band ----

START, UPPER = 0.5, 1.2  # rad
STRIBECK = both(friction_peak=1.5, stribeck_velocity=0.02, friction_viscous=0.02)
LOADED = both(friction_load_exponent=-0.2, friction_load=80.0)
ELLIPSES = both(profile=2, lead_angle=0.8, ellipse_a=0.06, ellipse_b=0.05)
DAMPED = {"damper.c_load": 20.0, "damper.c_release": 20.0}
MASSLESS = {"inertia.shaft": 0.0}
# A contact that locks under F > 0 when releasing, the other one not: the edge that releases is below zero.
LOCKED = {"cam1.friction": 0.4, "cam1.lead_angle": 0.2, "cam2.friction": 0.1, "cam2.lead_angle": 0.6}
# Releasing under F > 0 no torque moves it: the edge is infinite.
HELD = {
    **{"cam1.radius": 0.0382, "cam1.friction": 0.4, "cam1.lead_angle": 0.131},
    **{"cam2.radius": 0.0278, "cam2.friction": 0.051, "cam2.lead_angle": 0.1645},
}
MECHANISMS = {
    "helices": {},
    "follower mass": {"inertia.follower_mass": 0.5},
    "all inertias": {"inertia.follower_mass": 0.5, "inertia.follower": 1e-4},
    "damper": DAMPED,
    "self-locking": LOCKED,
    "ellipses": ELLIPSES,
    "ellipses, curved spring": ELLIPSES | {"spring.stiffness2": 1e5},
    "friction by speed": STRIBECK,
    "friction by load": LOADED,
    "play": MASSLESS,
    "play, ellipses": MASSLESS | ELLIPSES,
    "play, friction by load": MASSLESS | LOADED,
    "viscous": MASSLESS | DAMPED,
    "viscous, ellipses": MASSLESS | DAMPED | ELLIPSES,
}


def edge(params, theta, sigma=1):
    mech = Mechanism(params)
    place = mech.at(theta)
    return mech.edge_pair(place, sigma, mech.spring_force(place.z))[1]


def past_edge(params, order, size, theta=START):
    """tau = edge + size ((t - t_0)/h)^order, cut about t_0 = h/2. At the upper stop the edge is that of
    releasing, and `size` is negative."""
    h = 0.02
    sigma = -1 if theta == UPPER else 1
    tau = edge(params, theta, sigma) + sigma * size * Polynomial([-0.5, 1.0 / h]) ** order
    at = {"initial.theta": theta, "stop.upper": UPPER}
    near = [(0.5 + d / h,) for d in DISTANCES]
    return Scene(params | at, [Interval(h, tuple(tau.coef))], (HALVES, *near), counts=order < 3)


EXCESSES = (("leaves", 1, 0.2), ("touches", 2, -0.05), ("leaves like t^3", 3, 0.5))
EDGES = {
    f"{name}, {word}": past_edge(params, order, size)
    for name, params in MECHANISMS.items()
    for word, order, size in EXCESSES
} | {
    f"{name} at {theta:g} rad, {word}": past_edge(MECHANISMS[name], order, size, theta)
    for name in ("follower mass", "ellipses", "play", "viscous")
    for theta in (0.0, UPPER)
    for word, order, size in EXCESSES
}

# ---- loads that are zero, or pass zero ----

NO_SPRING = {"spring.preload": 0.0, "spring.stiffness": 0.0}
PINS = {
    "helices": both(lead_angle=0.7) | {"cam2.radius": 0.03},
    "ellipses": ELLIPSES,
    "follower mass": {"inertia.follower_mass": 0.5},
    "self-locking": LOCKED,
    "held": HELD | {"cam1.lead_angle": 0.14},
}


def coasting(params, way, order, force):
    """Without load at the start; then F_ext = force (t/h)^order."""
    h = 0.05
    at = {"initial.theta": START, "initial.omega": way * 2.0}
    return Scene(NO_SPRING | params | at, [Interval(h, (0.0,), (*[0.0] * order, force / h**order))])


LOADS = {
    f"{name}, {'loading' if way > 0 else 'releasing'}, F_ext like {force:g} t^{order}": coasting(
        params, way, order, force
    )
    for name, params in PINS.items()
    for way in (1, -1)
    for order in (1, 2, 3)
    for force in (0.5, -0.5)
}


def moving(params, omega, *intervals):
    return Scene(params | {"initial.theta": START, "initial.omega": omega}, list(intervals))


WAYS = {"stop.lower": -1.0}
OTHERS = {
    # from rest on the free length of the spring
    "square spring, loading": Scene(WAYS | NO_SPRING | {"spring.stiffness2": 1e6}, [Interval(0.05, (0.1,))]),
    "square spring, releasing": Scene(
        WAYS | NO_SPRING | {"spring.stiffness2": 1e6}, [Interval(0.05, (-0.1,))]
    ),
    # the jump passes the place where the spring is free: its rounding turns no flank once more
    "play, jump through the free length": Scene(
        {
            "stop.upper": 0.8987848170605885,
            "stop.lower": -0.5646769240224787,
            "cam1.radius": 0.0488719697595094,
            "cam1.lead_angle": 0.8847549745145801,
            "cam1.friction": 0.3682601459338656,
            "cam2.radius": 0.03507730685182462,
            "cam2.lead_angle": 1.0996276306328643,
            "cam2.friction": 0.211584710298803,
            "contacts": 1,
            "initial.theta": 0.392770338027044,
            "spring.preload": 0.0,
            "spring.stiffness": 13367.736769064151,
            "inertia.shaft": 0.0,
        },
        [
            Interval(0.02, (tau,))
            for tau in (26.625538676006546, -0.7357005995288498, -16.188136684742453, 41.36945911492267)
        ],
        counts=False,
    ),
    "cubic spring, releasing": Scene(
        WAYS | NO_SPRING | {"spring.stiffness3": 1e9}, [Interval(0.05, (-0.1,))]
    ),
    "spring loads either way": Scene(
        WAYS | LOCKED | {"spring.preload": 0.0}, [Interval(0.03, (0.5,)), Interval(0.08, (-0.8,))]
    ),
    # the axial load passes zero in motion: both flanks turn at once, or one after the other
    "load passes zero": moving({}, 8.0, Interval(0.03, (1.0,), (0.0, -4e4))),
    "load passes zero and returns": moving(
        {}, 8.0, Interval(0.04, (1.0,), (0.0, -6e4, 1.5e6)), Interval(0.05, (4.0,))
    ),
    "load passes zero, all inertias": moving(
        MECHANISMS["all inertias"], 8.0, Interval(0.03, (1.0,), (0.0, -4e4)), Interval(0.03, (3.0,))
    ),
    "load passes zero, curved": moving(ELLIPSES | STRIBECK, 8.0, Interval(0.03, (1.0,), (0.0, -6e4))),
    "load passes zero, self-locking": moving(LOCKED, 8.0, Interval(0.03, (1.0,), (0.0, -4e4))),
    "load passes zero, releasing": moving(LOCKED, -8.0, Interval(0.03, (-9.0,), (0.0, -8e4))),
    "load passes zero, viscous": moving(MASSLESS | DAMPED, 0.0, Interval(0.02, (9.0,), (0.0, -1e5))),
    # loading is locked under F < 0
    "contacts wedge as the load turns": moving(
        HELD | {"spring.stiffness": 0.0},
        4.0,
        Interval(0.05, (0.05,), (0.0, -2e3)),
        Interval(0.02, (0.5,), (-60.0,)),
    ),
    "a flattening groove locks": Scene(
        both(radius=0.03, profile=2, ellipse_a=0.06, ellipse_b=0.06, ellipse_curvature=1, lead_angle=0.09)
        | {"cam1.friction": 0.4, "cam2.profile": 1, "cam2.friction": 0.05, "cam2.lead_angle": 0.22}
        | {"spring.preload": 1.0, "spring.stiffness": 0.0, "initial.theta": START, "initial.omega": -3.0},
        [Interval(0.05, (0.0,)), Interval(0.2, (0.0,))],
    ),
    # stops
    "bounces that come to rest": Scene(
        {"stop.restitution": 0.4, "initial.theta": START},
        [Interval(0.05, (0.0,)), Interval(1.0, (0.0,))],
        (MANY,),
    ),
    "a torque that holds at the stop before it takes away": Scene(
        ELLIPSES | {"initial.theta": 1.3963}, [Interval(0.2, (9.0, 60.0, -900.0)), Interval(0.1, (0.0,))]
    ),
    **{
        f"without forces a motion would turn {beyond:g} rad beyond the stop": Scene(
            NO_SPRING
            | both(friction=0.0)
            | {"stop.upper": 1.0, "stop.restitution": 0.3}
            | {"initial.theta": 0.4, "initial.omega": math.sqrt(2.0 * 0.5 / 0.002 * (0.6 + beyond))},
            [Interval(0.06, (-0.5, 0.0, 0.0, 1e-9))],
        )
        for beyond in (-3e-6, 3e-6, 3e-5, 3e-3)
    },
    # extreme lead angles, stiffness, step sizes
    "steep grooves": moving(
        both(lead_angle=1.3, friction=0.05), -3.0, Interval(0.02, (40.0,)), Interval(0.02, (90.0, 300.0))
    ),
    "flat grooves": moving(both(lead_angle=0.09, friction=0.05), -3.0, Interval(0.5, (0.3, 1.0))),
    "a damper that stops at once": moving(
        {"inertia.shaft": 1e-6, "damper.c_load": 400.0, "damper.c_release": 100.0},
        300.0,
        Interval(0.1, (4.0, 10.0)),
    ),
    "a microsecond": moving(STRIBECK, 5.0, Interval(1e-6, (3.0,)), Interval(1e-6, (3.0, 1e6))),
    "ten seconds": Scene(
        {"inertia.follower_mass": 0.1} | DAMPED, [Interval(10.0, (0.0, 1.2)), Interval(10.0, (0.0,))]
    ),
}

# ---- motions that begin slowly against a damper, or under torques that a step hardly resolves ----

SLOWLY = {
    f"damper alone, torque like {way:g} t^{order}": Scene(
        NO_SPRING | DAMPED | {"initial.theta": START},
        [Interval(0.1, (*[0.0] * order, way * 2.0 / 0.1**order)), Interval(0.1, (0.1,))],
    )
    for way in (1, -1)
    for order in (2, 3)
}
CREEPING = {
    **{"cam1.radius": 0.016, "cam1.lead_angle": 0.416, "cam1.friction": 0.13, "cam2.radius": 0.035},
    **{"cam2.profile": 2, "cam2.lead_angle": 0.456, "cam2.ellipse_a": 0.17, "cam2.ellipse_b": 0.15},
    **{
        "cam2.ellipse_curvature": 1,
        "cam2.friction": 0.25,
        "spring.preload": 28.0,
        "spring.stiffness": 4200.0,
    },
    **{"spring.stiffness2": 1.07e6, "spring.stiffness3": 1.05e8, "damper.c_load": 200.0},
    **{"damper.q_load": 3000.0, "shaft.damping": 3e-4, "inertia.shaft": 0.0, "initial.theta": -0.08},
    **{"stop.lower": -0.43, "stop.upper": 1.13},
}
# s; the torque and its derivatives
STEEP = [
    (0.00058219, 0.41263, 513.05, 6.19398e6, -3.60246e10),
    (0.00060314, 1.31055, 4150.73, 8.50652e6, -1.06475e11),
    (0.00098122, 1.60422, 976.022, 7.31251e6, -2.83610e10),
    (0.00234551, 0.80296, -658.175, 3.66386e5, 0.0),
    (0.00109872, 1.34683, 1677.34, 3.23210e6, -1.60816e10),
]
STEPS = {
    f"viscous under a steep torque, {number}": Scene(CREEPING, [Interval(h, (u, v, w / 2.0, x / 6.0))])
    for number, (h, u, v, w, x) in enumerate(STEEP)
}

# ---- friction that changes steeply with the speed ----


def pairs(**values):
    return {f"cam{i}.{name}": pair[i - 1] for name, pair in values.items() for i in (1, 2)}


SPEEDS = {
    "a fall of friction over 0.6 mm/s": Scene(
        pairs(lead_angle=(0.94, 0.73), friction=(0.18, 0.12), friction_peak=(2.3, 2.3))
        | pairs(stribeck_velocity=(6e-4, 5e-4), stribeck_exponent=(2, 2), friction_viscous=(0.1, 0.1))
        | {"inertia.shaft": 1e-3, "shaft.damping": 5e-3, "initial.theta": 0.25, "initial.omega": -0.29},
        [Interval(0.003, (4.6,))],
    ),
    "friction by speed and load beside a heavy follower": Scene(
        pairs(lead_angle=(0.955, 0.798), friction=(0.1095, 0.1836), friction_peak=(1.745, 2.168))
        | pairs(stribeck_velocity=(1.78e-3, 0.012), friction_viscous=(0.1, 0.1))
        | pairs(friction_load_exponent=(-0.271, -0.287), friction_load=(1000.0, 1700.0))
        | {"inertia.shaft": 1e-4, "inertia.follower_mass": 1.0, "spring.stiffness": 667.5}
        | {"initial.theta": 0.434, "initial.omega": 0.0366},
        [Interval(2.7e-3, (0.5,)), Interval(0.02, (3.0,))],
    ),
}
TABLE = EDGES | LOADS | OTHERS | SLOWLY | STEPS | SPEEDS


@pytest.mark.parametrize("name", TABLE)
def test_scene(library, name):
    check(library, TABLE[name])


def test_steps_that_end_at_breakaway_have_sensitivities(make):
    """dtheta/dtau is finite however close to the beginning of the motion a step ends."""
    for params in MECHANISMS.values():
        scene = past_edge(params, 1, 0.2)
        h, (first, rate) = scene.intervals[0].duration, scene.intervals[0].tau
        for distance in DISTANCES:
            fmu = make().start(scene.params | {"tau": first})
            fmu.set_derivatives({"tau": [rate]})
            fmu.step(h / 2 + distance)
            assert math.isfinite(fmu.get("step.dtheta_dtau")) and math.isfinite(fmu.get("step.domega_dtau"))
            fmu.free()


# ---- dwells of sampled grooves: closed forms ----

KNOT, RISE_END = 0.1, 0.3  # rad of psi, between which the groove of cam 2 rises
# A contact of cam 1 that locks, and a groove of cam 2 without friction: on the dwell the axial load makes no
# torque.
DWELL = {
    **{
        "cam1.lead_angle": 0.3,
        "cam1.friction": 0.4,
        "cam2.profile": 3,
        "cam2.friction": 0.0,
        "stop.upper": 0.25,
    },
    **{"spring.preload": 0.0, "spring.stiffness": 0.0, "inertia.shaft": 0.003},
}
SHAFT, SLOW = DWELL["inertia.shaft"], {"inertia.shaft": 0.0, "shaft.damping": 0.7}


class Dwell(NamedTuple):
    params: dict
    interval: Interval
    mode: int
    theta: float | None = None
    omega: float | None = None


DWELLS = {
    "the shaft alone resists": Dwell(
        {"initial.theta": -0.2, "stop.lower": -0.4}, Interval(0.1, (0.0, 0.05), (-30.0,)), LOADING,
        -0.2 + 0.05 * 0.1**3 / (6 * SHAFT), 0.05 * 0.1**2 / (2 * SHAFT),
    ),
    "the damping of the shaft alone resists": Dwell(
        SLOW | {"damper.c_load": 10.0, "stop.lower": -0.4}, Interval(0.1, (0.0, 5.0), (-1000.0,)), LOADING,
        5.0 * 0.1**2 / (2 * 0.7),
    ),
    "a load that grows moves nothing": Dwell({}, Interval(0.01, (0.0,), (100.0, 9e5)), STICK, 0.0, 0.0),
    # Past the dwell a pull bears on cam 2. Loading, no flank of contact 1 takes the torque that it passes on.
    "the contacts jam where the groove begins to rise": Dwell(
        {"initial.omega": 1.6}, Interval(0.1, (0.05,), (-26.0,)), WEDGED, KNOT, 0.0
    ),
    "the contacts hold a torque at the end of the dwell": Dwell(
        {"initial.theta": KNOT}, Interval(1e-3, (0.0, 0.0, 4e5), (-26.0,)), WEDGED, KNOT, 0.0
    ),
    "the load falls to zero as the dwell begins": Dwell(
        {"initial.theta": KNOT + 1e-9, "initial.omega": -5.0}, Interval(0.01, (0.05,), (-26.0,)), RELEASING,
        None, -5.0 + 0.05 * 0.01 / SHAFT,
    ),
    "a torque pulls back from the end of the dwell": Dwell(
        {"initial.theta": KNOT}, Interval(0.01, (-0.05,), (26.0,)), RELEASING, None, -0.05 * 0.01 / SHAFT
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def groove(tmp_path_factory):
    path = tmp_path_factory.mktemp("dwell") / "groove.csv"
    write_table(path, [-0.5, -0.3, -0.1, 0.0, KNOT, 0.2, RISE_END], [0.0, 0.0, 0.0, 0.0, 0.0, 2e-4, 6e-4])
    return str(path)


@pytest.mark.parametrize("cuts", [(), HALVES, MANY], ids=len)
@pytest.mark.parametrize("name", DWELLS)
def test_dwell(library, groove, name, cuts):
    scene = DWELLS[name]
    parts = [cut(scene.interval, [share * scene.interval.duration for share in cuts])]
    (row,) = rows = play(library, DWELL | {"cam2.table": groove} | scene.params, parts, TOLERANCE)
    assert row["mode"] == scene.mode
    # Beside KNOT the slope of cam 2, and with it the load of contact 1, is rounding within sqrt(1e-14) rad.
    assert scene.theta is None or row["theta"] == pytest.approx(scene.theta, rel=TOLERANCE, abs=1e-7)
    assert scene.omega is None or row["omega"] == pytest.approx(scene.omega, rel=TOLERANCE)
    assert residual(row) <= TOLERANCE and falling_heats(rows) == []


@pytest.mark.parametrize("tau", [0.2, 5.0])
def test_the_play_ends_where_the_contacts_lock(library, tau):
    """A spring that weakens: F_0 = 0 at theta = 0.9, and beyond no torque loads."""
    lift, end, preload = Mechanism(HELD).at(0.0).dz, 0.9, 10.0
    spring = {"spring.preload": preload, "spring.stiffness": 0.0}
    spring |= {"spring.stiffness2": -preload / (lift * end) ** 2}
    (row,) = play(library, HELD | MASSLESS | spring, [[Interval(0.1, (tau,))]], TOLERANCE)
    assert row["theta"] == pytest.approx(end, rel=TOLERANCE)
    assert row["mode"] == WEDGED
    friction = edge(HELD | spring, 0.0) / preload - lift  # N.m per N
    heat = row["energy.heat_cam1"] + row["energy.heat_cam2"]
    assert heat == pytest.approx(friction * preload * end * 2.0 / 3.0, rel=TOLERANCE)


# ---- refusals ----

STARTS = {
    "no pair loads": (
        both(lead_angle=1.4, friction=0.2),
        ["jam when loading", "cam1.lead_angle = 1.4", "smaller lead angles"],
    ),
    "no pair loads at rest": (
        both(lead_angle=1.2, friction=0.3, friction_peak=2.0),
        ["jam when loading", "cam2.friction = 0.3 times cam2.friction_peak = 2", "less friction"],
    ),
    "no pair loads under load": (
        both(lead_angle=1.2, friction=0.3, friction_load_exponent=0.5, friction_load=10.0),
        ["jam when loading", "under load up to mu", "less friction"],
    ),
    "no pair loads at the upper stop": (
        both(profile=2, lead_angle=1.1, ellipse_a=0.2, ellipse_b=0.2, ellipse_curvature=1, friction=0.4),
        ["jam when loading at theta = ", "smaller lead angles"],
    ),
    "a follower that outweighs the shaft": (
        LOCKED | {"cam2.friction": 0.02, "inertia.shaft": 1e-6, "inertia.follower_mass": 2.0},
        ["nothing resists releasing", "inertia.shaft must exceed"],
    ),
    "a peak without inertia": (
        MASSLESS | {"cam1.friction_peak": 1.2},
        ["cam1.friction_peak = 1.2", "needs an inertia"],
    ),
    "a branch without inertia": (
        MASSLESS | DAMPED | {"cam2.friction_viscous": 0.1},
        ["cam2.friction_viscous = 0.1", "needs an inertia", "inertia.shaft"],
    ),
    "friction by load beside a damper alone": (
        MASSLESS | DAMPED | LOADED,
        ["cam1.friction_load_exponent = -0.2", "damper", "inertia.shaft > 0"],
    ),
    "two level grooves": (both(lead_angle=0.0), ["cam1.lead_angle = 0", "cam2.lead_angle = 0"]),
    "a groove that ends before the stop": (
        both(profile=2, ellipse_a=0.015, ellipse_b=0.015),
        ["ellips", "stop.upper"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", STARTS)
def test_refused_start(make, name):
    params, words = STARTS[name]
    text = make().refused_start(params)
    for word in words:
        assert word in text


def test_a_table_of_speeds_asks_for_an_inertia(make, tmp_path):
    (tmp_path / "law.csv").write_text("v_m_s,mu\n0,0.2\n0.1,0.21\n0.2,0.22\n")
    text = make().refused_start(MASSLESS | {"cam2.friction_table": str(tmp_path / "law.csv")})
    assert "cam2.friction_table" in text and "inertia.shaft" in text


def test_a_refusal_names_an_inertia_that_works(make):
    params = STARTS["a follower that outweighs the shaft"][0]
    named = float(make().refused_start(params).rpartition("must exceed ")[2])
    assert make().refused_start(params | {"inertia.shaft": named * (1 - 1e-6)})
    fmu = make().start(params | {"inertia.shaft": named * (1 + 1e-6)})
    assert fmu.get("friction_class") == 2


def test_a_tuned_value_is_refused_as_at_the_start(make):
    fmu = make().start({"tau": 2.0})
    before = fmu.everything()
    fmu.refused_set(
        {"cam1.friction": 1.2, "cam2.friction": 1.2}, mentions=("jam when loading", "less friction")
    )
    assert fmu.everything() == before


def test_a_motion_that_leaves_the_range_of_numbers_is_refused(make):
    fmu = make().start()
    fmu.set({"tau": 1e300})
    fmu.refused("fmi2DoStep", 0.0, 1.0, 1, mentions=("tau = 1e+300", "range of numbers"))
