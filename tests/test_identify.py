"""`dualcam identify`: recordings with known values and noise, made by tests/reference/bench.py, and what the
fit says about them."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from equal_radii import write_equal_radii
from reference.bench import Bench, record, sines, triangle
from scipy.stats import binom

import dualcam
from dualcam import Fmu, identify
from dualcam.__main__ import main
from dualcam.design_file import read_design
from dualcam.errors import DualcamError, IdentificationError
from dualcam.identification import Recording, fitted_names, read_recording
from dualcam.identification.least_squares import Problem
from dualcam.identification.motion import motion_of
from dualcam.identification.smoothing import noise_of, smooth
from dualcam.identification.torque_model import TorqueModel
from dualcam.identification.unknowns import unknowns_of

TORQUE_NOISE, ANGLE_NOISE = 0.05, 1e-3  # N.m, rad
SPRING = ["friction", "spring.preload", "spring.stiffness"]
SLOW = Bench(friction=(0.17, 0.17), preload=62.0, stiffness=47e3)
STRIBECK = Bench(
    (0.02, 0.02), friction=(0.12, 0.12), peak=1.4, stribeck_velocity=0.008, viscous=0.8, shaft=0.02
)
LOADED = Bench(friction=(0.17, 0.17), load_exponent=-0.3)
LOSSES = replace(SLOW, shaft=0.02, shaft_damping=0.05)
TRUE = {
    "friction": lambda b: b.friction[0],
    "friction_peak": lambda b: b.peak,
    "stribeck_velocity": lambda b: b.stribeck_velocity,
    "friction_viscous": lambda b: b.viscous,
    "friction_load_exponent": lambda b: b.load_exponent,
    "spring.preload": lambda b: b.preload,
    "spring.stiffness": lambda b: b.stiffness,
    "inertia.shaft": lambda b: b.shaft,
    "shaft.damping": lambda b: b.shaft_damping,
}


@pytest.fixture(scope="module")
def design(tmp_path_factory):
    """Grooves of the bench, with other friction and spring."""
    return read_design(write_equal_radii(tmp_path_factory.mktemp("design") / "my.toml"))


def recording(bench, time, motion, seed=1, torque_noise=TORQUE_NOISE, angle_noise=ANGLE_NOISE):
    return Recording.from_arrays(*record(bench, time, motion, torque_noise, angle_noise, seed))


def slow_recording(seed=1, count=401):
    time = np.linspace(0.0, 10.0, count)
    return recording(SLOW, time, sines(time), seed)


def fast_motion(count=1601):
    time = np.linspace(0.0, 20.0, count)
    return time, sines(time, 0.7, (0.4, 0.1, 0.05), (0.11, 0.53, 1.37))


# ---- the reference ----


def test_the_bench_is_the_mechanism(design):
    """The closed form of the tests and the inverse FMU, in both directions, with inertia and losses."""
    friction = ((0.1, 0.2), 1.5, 0.02, 0.4, 0.3, 150.0)
    bench = Bench((0.025, 0.018), (0.7, 0.9), *friction, 60.0, 40e3, 30.0, 0.2, 0.01, 0.5)
    names = [f"cam{i}.{name}" for i in (1, 2) for name in ("radius", "lead_angle", "friction")]
    values = dict(zip(names, (0.025, 0.7, 0.1, 0.018, 0.9, 0.2), strict=True))
    for i in (1, 2):
        law = {"friction_peak": 1.5, "stribeck_velocity": 0.02, "friction_viscous": 0.4}
        law |= {"friction_load_exponent": 0.3, "friction_load": 150.0}
        values |= {f"cam{i}.{name}": value for name, value in law.items()}
    values |= {
        "spring.preload": 60.0,
        "spring.stiffness": 40e3,
        "damper.c_load": 30.0,
        "damper.c_release": 30.0,
    }
    values |= {"shaft.damping": 0.2, "inertia.shaft": 0.01, "inertia.follower_mass": 0.5}
    with Fmu("inverse") as fmu:
        fmu.start(values)
        inputs, torque = fmu.reals("theta", "omega", "alpha", "F_ext"), fmu.reals("tau")
        for row in np.random.default_rng(0).uniform((0, -2, -20, 0), (1.3, 2, 20, 30), (50, 4)):
            inputs.values = row
            inputs.write()
            assert torque.read()[0] == pytest.approx(bench.torque(*row[:3], force=row[3]), rel=1e-12)


# ---- known values ----

SCENES = {
    "quasi-static, both directions": (SLOW, (np.linspace(0, 20, 801), triangle), SPRING),
    "zero error of the torque": (SLOW, (np.linspace(0, 20, 801), triangle), [*SPRING, "torque_offset"]),
    "losses": (LOSSES, fast_motion(), [*SPRING, "inertia.shaft", "shaft.damping"]),
    "load": (LOADED, (np.linspace(0, 20, 801), triangle), ["friction", "friction_load_exponent"]),
    "Stribeck": (
        STRIBECK,
        fast_motion(1201),
        [*SPRING, "friction_peak", "stribeck_velocity", "friction_viscous", "inertia.shaft"],
    ),
}


@pytest.mark.parametrize("scene", SCENES)
def test_known_values_are_found(design, scene):
    """All intervals hold the true value, or nearly so, and the residual is the noise."""
    bench, (time, motion), names = SCENES[scene]
    found = identify(recording(bench, time, motion(time) if callable(motion) else motion), design, names)
    for name in names:
        one = found[name]
        truth = TRUE[name](bench) if name in TRUE else 0.0
        assert one.status == "known"
        width = one.high - one.low
        assert one.low - 0.5 * width < truth < one.high + 0.5 * width, (name, one)
    assert found.rms == pytest.approx(TORQUE_NOISE, rel=0.1)
    assert found.noise == pytest.approx(TORQUE_NOISE, rel=0.15)
    assert found.motion.theta_noise == pytest.approx(ANGLE_NOISE, rel=0.25)
    assert not found.ambiguities


def test_intervals_hold_the_true_values_as_often_as_they_say(design):
    """95 % of 100 recordings; fewer than 89 would happen once in 250 times."""
    assert binom.cdf(88, 100, 0.95) < 0.005
    held, alarms = np.zeros(3), 0
    for seed in range(100):
        found = identify(slow_recording(seed, 201), design, SPRING)
        alarms += bool(found.missing)
        held += [found[name].low <= TRUE[name](SLOW) <= found[name].high for name in SPRING]
    assert (held >= 89).all(), held
    assert alarms <= 2, alarms  # the residuals ask for nothing: nothing is missing


def test_intervals_of_losses_hold_the_true_values(design):
    time, motion = fast_motion(801)
    names = ["friction", "inertia.shaft", "shaft.damping"]
    known = replace(LOSSES, preload=50.0, stiffness=50e3)
    held = np.zeros(3)
    for seed in range(20):
        found = identify(recording(known, time, motion, seed), design, names)
        held += [found[name].low <= TRUE[name](known) <= found[name].high for name in names]
    assert binom.cdf(16, 20, 0.95) < 0.02 and (held >= 17).all(), held


def test_without_noise_the_values_are_exact(design):
    """But for the angle, which is smoothed."""
    time = np.linspace(0.0, 10.0, 401)
    exact = Recording.from_arrays(*record(SLOW, time, sines(time), 0.0, 0.0, 0), omega=sines(time)[1])
    found = identify(exact, design, SPRING)
    for name in SPRING:
        assert found[name].value == pytest.approx(TRUE[name](SLOW), rel=1e-5)


def test_each_cam_has_its_own_friction_where_the_cams_differ(design):
    """Unequal grooves tell the two coefficients apart, with little noise."""
    bench = Bench((0.02, 0.02), (0.5, 1.0), (0.1, 0.2), shaft=0.002)
    steep = replace(design, parameters=design.parameters | {"cam1.lead_angle": 0.5, "cam2.lead_angle": 1.0})
    time = np.linspace(0.0, 10.0, 801)
    found = identify(
        recording(bench, time, sines(time, 0.6, (0.5,)), 1, 1e-3, 1e-5),
        steep,
        ["cam1.friction", "cam2.friction"],
    )
    assert found["cam1.friction"].value == pytest.approx(0.1, abs=0.01)
    assert found["cam2.friction"].value == pytest.approx(0.2, abs=0.01)


def test_an_axial_force_is_taken_into_account(design):
    time = np.linspace(0.0, 10.0, 401)
    theta, omega, alpha = sines(time)
    force = 40.0 * np.sin(0.7 * time)
    tau = SLOW.torque(theta, omega, alpha, force=force)
    found = identify(Recording.from_arrays(time, theta, tau, omega, force), design, SPRING)
    assert found["spring.preload"].value == pytest.approx(62.0, rel=1e-4)


def test_a_value_at_its_limit_is_reported(design):
    """Friction that falls with speed asks for a viscous branch below zero."""
    time = np.linspace(0.0, 10.0, 801)
    bench = replace(SLOW, friction=(0.12, 0.12), peak=1.5, stribeck_velocity=0.02)
    found = identify(recording(bench, time, sines(time)), design, [*SPRING, "friction_viscous"])
    assert found["friction_viscous"].status == "at its limit"
    assert found["friction_viscous"].low == 0.0
    assert any("friction_viscous" in text and "limit" in text for text in found.warnings())


def test_long_recordings_are_thinned(design, monkeypatch):
    monkeypatch.setattr("dualcam.identification.fit.MOST_SAMPLES", 300)
    found = identify(slow_recording(count=1001), design, SPRING)
    assert len(found.time) == 251
    counts = [found.motion.count(direction) for direction in (1, -1, 0)]
    assert sum(counts) == 251
    assert "of which every 4th counts, 251 samples: " in found.summary()[0]
    assert found["friction"].value == pytest.approx(0.17, abs=0.002)


# ---- at rest ----


def test_torque_at_rest_counts_only_outside_of_the_band(design, tmp_path):
    """Torque that loads, falls through the band and releases, from the forward FMU: most samples are at
    rest."""
    text = design.path.read_text().partition("[scenario]")[0].replace("friction = 0.14", "friction = 0.17")
    times, torques = [0, 1, 2, 3, 4, 5, 6], [0, 9, 0, 7, 2, 8, 1]
    text += f"[scenario]\nstop = 6\noutput_interval = 0.005\n[scenario.inputs.tau]\ntime = {times}\n"
    path = tmp_path / "bench.toml"
    path.write_text(text + f"value = {torques}\n")
    run = dualcam.simulate(path)
    noise = np.random.default_rng(3).standard_normal((2, len(run["time"])))
    theta, tau = run["theta"] + 5e-4 * noise[0], run["tau"] + 0.03 * noise[1]
    found = identify(Recording.from_arrays(run["time"], theta, tau), design, SPRING)
    assert found.motion.count(0) > 0.5 * len(theta)
    for name, truth in zip(SPRING, (0.17, 50.0, 50e3), strict=True):
        assert abs(found[name].value - truth) < found[name].high - found[name].low, name
    at_rest = ~found.slips
    assert np.mean(found.residual[at_rest] == 0.0) > 0.9
    # True slip is found: the model's mode at the samples that count as slip.
    stands = run["mode"] == 1
    assert np.mean(stands[found.slips]) < 0.02


def test_at_rest_alone_nothing_is_known(design):
    time = np.linspace(0.0, 1.0, 200)
    theta = 0.5 + 1e-3 * np.random.default_rng(0).standard_normal(200)
    with pytest.raises(IdentificationError, match=r"the cam slips in .* record motion"):
        identify(Recording.from_arrays(time, theta, 3.0 + 0.0 * time), design, SPRING)


# ---- what cannot be told apart ----


def one_way(direction=1, speed=0.3, count=401):
    time = np.linspace(0.0, 4.0, count)
    start = 0.1 if direction > 0 else 1.3
    return time, (start + direction * speed * time, np.full(count, direction * speed), np.zeros(count))


@pytest.mark.parametrize("direction, absent", [(1, "releasing"), (-1, "loading")])
def test_one_direction_does_not_tell_friction_from_spring(design, direction, absent):
    time, motion = one_way(direction)
    found = identify(recording(SLOW, time, motion), design, SPRING)
    (ambiguity,) = found.ambiguities
    assert set(ambiguity.names) == set(SPRING)
    assert "cannot be told apart" in ambiguity.text and "does not change the torque" in ambiguity.text
    assert f"record {absent} too" in ambiguity.advice
    assert {one.interval for one in found.parameters} == {"not determined"}
    assert found.rms == pytest.approx(TORQUE_NOISE, rel=0.1)  # the torque is explained all the same


def test_the_named_change_leaves_the_torque(design):
    """The changes that the sentence names, put into the closed form of the bench."""
    time, motion = one_way()
    found = identify(recording(SLOW, time, motion), design, SPRING)
    words = found.ambiguities[0].text.partition("a change of ")[2]
    values = {one.name: one.value for one in found.parameters}
    moved = dict(values)
    for part in words.replace(" and ", ", ").partition(" together")[0].split(", "):
        name, _, amount = part.partition(" by ")
        moved[name] += 0.1 * float(amount.split()[0])
    assert moved != values

    def torque(x):
        bench = Bench(
            friction=(x["friction"],) * 2, preload=x["spring.preload"], stiffness=x["spring.stiffness"]
        )
        return bench.torque(*motion)

    alone = torque(values | {"friction": moved["friction"]}) - torque(values)
    assert np.abs(torque(moved) - torque(values)).max() < 0.01 * np.abs(alone).max()


def test_equal_cams_have_one_friction(design):
    found = identify(slow_recording(), design, ["cam1.friction", "cam2.friction", *SPRING[1:]])
    (ambiguity,) = found.ambiguities
    assert set(ambiguity.names) == {"cam1.friction", "cam2.friction"}
    assert "Fit friction, one value for both cams" in ambiguity.advice
    assert found["spring.stiffness"].status == "known"


def test_slow_motion_does_not_tell_inertia(design):
    time = np.linspace(0.0, 20.0, 801)
    found = identify(recording(SLOW, time, triangle(time)), design, [*SPRING, "inertia.shaft"])
    assert found.motion.kind == "quasi-static"
    (ambiguity,) = found.ambiguities
    assert ambiguity.names == ("inertia.shaft",)
    assert "quasi-static" in ambiguity.advice and "does not change the torque" in ambiguity.text
    assert found["inertia.shaft"].value == 0.002
    assert found["friction"].status == "known"


def test_one_speed_does_not_tell_the_stribeck_curve(design):
    time = np.linspace(0.0, 20.0, 801)
    names = [*SPRING, "friction_peak", "stribeck_velocity", "friction_viscous"]
    found = identify(recording(SLOW, time, triangle(time)), design, names)
    unknown = {name for ambiguity in found.ambiguities for name in ambiguity.names}
    assert {"friction", "friction_peak", "friction_viscous"} <= unknown
    assert any("record speeds that differ more" in ambiguity.advice for ambiguity in found.ambiguities)
    assert {found[name].status for name in SPRING[1:]} == {"known"}


def test_a_small_range_does_not_tell_preload_from_stiffness(design):
    time = np.linspace(0.0, 10.0, 401)
    found = identify(recording(SLOW, time, sines(time, 0.7, (0.01,))), design, SPRING)
    assert {"spring.preload", "spring.stiffness"} <= set(found.ambiguities[0].names)
    assert "record a wider range" in found.ambiguities[0].advice


def test_a_wrong_model_is_reported(design):
    time, motion = fast_motion()
    found = identify(recording(STRIBECK, time, motion), design, SPRING)
    assert any("the model lacks something" in text for text in found.warnings())


def test_the_opposite_sign_is_reported(design):
    time, theta, tau = record(SLOW, np.linspace(0, 10, 401), sines(np.linspace(0, 10, 401)), 0.05, 1e-3, 1)
    found = identify(Recording.from_arrays(time, theta, -tau), design, ["friction"])
    (warning,) = found.warnings()
    assert "opposite sign" in warning
    with pytest.raises(IdentificationError, match=r"is not written.*opposite sign"):
        found.write_design(design.path.with_name("fitted.toml"))
    assert not design.path.with_name("fitted.toml").exists()


# ---- parts ----


def test_derivatives_are_those_of_the_fmu(design):
    """Differences of the fit against the FMU's analytic directional derivatives."""
    data = slow_recording()
    names = ["cam1.friction", "cam2.friction", "spring.preload", "spring.stiffness", "damper.c_load"]
    unknowns, motion = unknowns_of(design, names), motion_of(data)
    with TorqueModel(design, motion, np.zeros(len(data)), unknowns) as model, Fmu("inverse") as fmu:
        problem = Problem(model, data.tau, TORQUE_NOISE, unknowns)
        found = problem.jacobian(problem.start / problem.sizes) / problem.sizes
        fmu.start(design.parameters_for("inverse"))
        inputs = fmu.reals("theta", "omega", "alpha")
        for k in np.flatnonzero(motion.direction)[::20]:
            inputs.values = motion.theta[k], motion.omega[k], motion.alpha[k]
            inputs.write()
            assert found[k] == pytest.approx(fmu.jacobian(["tau"], names)[0], rel=1e-6, abs=1e-9)


def test_smoothing_keeps_polynomials_on_uneven_times():
    time = np.sort(np.random.default_rng(2).uniform(0.0, 3.0, 200))
    poly = np.polynomial.Polynomial([0.3, -1.0, 0.5, 0.2, -0.1])
    found = smooth(time, poly(time), 15)
    for order, values in enumerate((found.value, found.slope, found.curvature)):
        assert values == pytest.approx(poly.deriv(order)(time) if order else poly(time), abs=1e-6)


def test_smoothing_knows_its_noise():
    """Spread of slope and curvature over 200 recordings; even and uneven times."""
    random = np.random.default_rng(5)
    for time in (np.linspace(0, 1, 101), np.sort(random.uniform(0, 1, 101))):
        runs = [smooth(time, 0.01 * random.standard_normal(101), 10) for _ in range(200)]
        for name in ("slope", "curvature"):
            spread = np.std([getattr(run, name)[[20, 50, 80]] for run in runs], axis=0)
            said = np.sqrt(
                np.mean([getattr(run, f"{name}_noise")[[20, 50, 80]] ** 2 for run in runs], axis=0)
            )
            assert spread == pytest.approx(said, rel=0.2)
        jump = np.where(time > 0.5, 5.0, 0.0)
        assert noise_of(time, jump + 0.01 * random.standard_normal(101), np.arange(101)) == pytest.approx(
            0.01, rel=0.4
        )


def test_the_acceleration_of_a_sine_is_found():
    time = np.linspace(0.0, 10.0, 2001)
    theta, omega, alpha = sines(time)
    noisy = theta + ANGLE_NOISE * np.random.default_rng(0).standard_normal(2001)
    motion = motion_of(Recording.from_arrays(time, noisy, time))
    assert motion.kind == "dynamic"
    moving = motion.direction != 0
    assert np.std(motion.alpha - alpha) < 0.05 * np.std(alpha)
    assert (np.sign(omega) == motion.direction)[moving].all()
    assert moving.mean() > 0.85


def test_what_can_be_fitted():
    names = fitted_names()
    assert names["friction"] == ("cam1.friction", "cam2.friction")
    assert {"spring.stiffness3", "inertia.shaft", "torque_offset", "damper.q_release"} <= set(names)
    assert not {"stop.upper", "cam1.profile", "cam1.table", "contacts", "cam1.wear", "shaft.stiffness"} & set(
        names
    )


# ---- files ----

ROWS = [(0.01 * k, 0.1 + 0.005 * k, 2.0 + 0.02 * k) for k in range(30)]


def test_optional_and_other_columns(tmp_path):
    """tests/test_human_tables.py has the formats of files."""
    rows = "".join(f"{a},{b},{c},30,7,1e9\n" for a, b, c in ROWS)
    path = tmp_path / "bench.csv"
    path.write_text(f"time_s,theta_rad,tau_Nm,speed_rpm,F_ext_N,torque_load\n{rows}", encoding="utf-8")
    found = read_recording(path)
    assert found.omega[0] == pytest.approx(np.pi) and found.F_ext[0] == 7.0


def changed(line, text):
    """The file of a header and ROWS with one line, from 1, replaced."""
    lines = ["time_s,theta_rad,tau_Nm", *(f"{a},{b},{c}" for a, b, c in ROWS)]
    lines[line - 1] = text
    return "\n".join(lines)


FAULTS = {
    "unsorted": (
        changed(12, "0.01,0.15,2.2"),
        "line 12, column 1: time = 0.01 s: allowed is more than 0.09 s, the value of line 11",
    ),
    "few": (changed(1, "time_s,theta_rad,tau_Nm")[:188], "9 lines of numbers: allowed are 20 or more"),
    "still": (
        "time_s,theta_rad,tau_Nm\n" + "".join(f"{k},1,2\n" for k in range(30)),
        "theta is 1 rad in all",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_file_that_is_wrong_is_refused(tmp_path, fault):
    text, message = FAULTS[fault]
    path = tmp_path / "bench.csv"
    path.write_text(text)
    with pytest.raises(IdentificationError, match=message) as error:
        read_recording(path)
    assert str(path) in str(error.value)


def test_arrays_that_are_wrong_are_refused():
    time = np.arange(30.0)
    for theta, tau, message in (
        (time[:5], time, "theta has 5 samples, time has 30"),
        (np.where(time == 3, np.nan, time), time, "sample 3: theta = nan"),
        (time.reshape(5, 6), time, "shape"),
        ("angle", time, "theta has elements of type text"),
    ):
        with pytest.raises(IdentificationError, match=message):
            Recording.from_arrays(time, theta, tau)


REQUESTS = {
    "unknown": (["frictoin"], {}, "'frictoin' cannot be fitted: did you mean friction"),
    "none": ([], {}, "no parameter to fit"),
    "twice": (["friction", "cam1.friction"], {}, "friction and cam1.friction both set cam1.friction"),
    "number": ([1], {}, "fit: 1 is no name: allowed are texts"),
    "no list": (1, {}, "fit: 1 is no name"),
    "same": (["friction", "friction"], {}, "friction is given twice: give friction once"),
    "spaces": (["friction spring.preload"], {}, "separate the names by commas, friction,spring.preload"),
    "ellipse": (["cam1.ellipse_a"], {}, 'acts for cam1.profile = "ellipse" only'),
    "load": (["friction_load"], {}, "does not act with cam1.friction_load_exponent = 0"),
    "integer": (["cam1.stribeck_exponent"], {}, "cannot be fitted"),
    "motion": (SPRING, {"motion": "fast"}, "allowed are auto, quasi-static, dynamic"),
    "window": (SPRING, {"window": -1.0}, "window = -1.0 s: allowed is a time > 0"),
}


@pytest.mark.parametrize("request_", REQUESTS)
def test_a_wish_that_is_wrong_is_refused(design, request_):
    names, options, message = REQUESTS[request_]
    with pytest.raises(DualcamError, match=message):
        identify(slow_recording(), design, names, **options)


def test_a_design_that_does_not_fit_is_refused(design):
    time, theta, tau = record(SLOW, np.linspace(0, 10, 401), sines(np.linspace(0, 10, 401)), 0.05, 1e-3, 1)
    with pytest.raises(IdentificationError, match=r"in degrees.*theta_deg"):
        identify(Recording.from_arrays(time, np.degrees(theta), tau), design)
    with pytest.raises(IdentificationError, match="from the zero of the design"):
        identify(Recording.from_arrays(time, theta + 0.5, tau), design)
    elastic = replace(design, parameters=design.parameters | {"shaft.stiffness": 100.0})
    with pytest.raises(IdentificationError, match="allowed is a rigid shaft"):
        identify(Recording.from_arrays(time, theta, tau), elastic)
    jammed = replace(design, parameters=design.parameters | {"cam1.friction": 2.0, "cam2.friction": 2.0})
    with pytest.raises(DualcamError, match="jam"):
        identify(Recording.from_arrays(time, theta, tau), jammed)


# ---- command line and files ----


@pytest.fixture
def bench_folder(tmp_path, monkeypatch):
    """my.toml and bench.csv of the slow bench."""
    monkeypatch.chdir(tmp_path)
    write_equal_radii(tmp_path / "my.toml")
    data = slow_recording()
    columns = np.column_stack([data.time, np.degrees(data.theta), data.tau])
    np.savetxt("bench.csv", columns, "%.6f", ",", header="time_s,theta_deg,tau_Nm", comments="")
    return tmp_path


def test_the_command_writes_all(bench_folder, capsys):
    words = ["-o", "fitted.toml", "--report", "r.html", "--plot", "p.png"]
    assert main(["identify", "bench.csv", "my.toml", *words]) == 0
    said = capsys.readouterr().out
    assert "friction" in said and "95 % interval" in said and "residual RMS" in said
    assert Path("p.png").read_bytes().startswith(b"\x89PNG")
    page = Path("r.html").read_text(encoding="utf-8")
    assert "<svg" in page and "spring.stiffness" in page and "<script" not in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    fitted = read_design("fitted.toml")
    assert fitted.value("cam1.friction") == fitted.value("cam2.friction") == pytest.approx(0.17, abs=0.002)
    assert fitted.value("spring.stiffness") == pytest.approx(47e3, rel=0.01)
    assert not fitted.warnings
    before, after = (tomllib.loads(Path(name).read_text()) for name in ("my.toml", "fitted.toml"))
    for name in ("stop", "scenario", "pin", "inertia", "title"):
        assert before[name] == after[name]
    assert main(["check", "fitted.toml"]) == 0


def test_the_command_prints_json(bench_folder, capsys):
    assert main(["identify", "bench.csv", "my.toml", "--json", "--fit", "cam1.friction,cam2.friction"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["parameters"]) == {"cam1.friction", "cam2.friction"}
    assert found["loading"] > 0 and found["motion"] in ("quasi-static", "dynamic")


@pytest.mark.parametrize(
    "words, code, message",
    [
        (["bench.csv", "my.toml", "--fit", "mu"], 2, "'mu' cannot be fitted"),
        (["lost.csv", "my.toml"], 1, "there is no recording lost.csv"),
        (["bench.csv", "lost.toml"], 1, "there is no such file"),
        (["bench.csv", "my.toml", "-o", "my.toml"], 1, "design of the start values"),
        (["bench.csv", "my.toml", "--plot", "p.xyz"], 1, "allowed are names that end in .png"),
        (["bench.csv", "my.toml", "--report", "no/r.html"], 1, "does not exist"),
        (["bench.csv"], 2, "Missing argument"),
        (["bench.csv", "my.toml", "--motion", "fast"], 2, "Invalid value"),
    ],
)
def test_exit_codes(bench_folder, capsys, words, code, message):
    assert main(["identify", *words]) == code
    assert message in capsys.readouterr().err


def test_doubts_go_to_the_error_output(bench_folder, capsys):
    assert (
        main(["identify", "bench.csv", "my.toml", "--fit", "cam1.friction,cam2.friction,spring.preload"]) == 0
    )
    assert "dualcam: warning:" in capsys.readouterr().err


def test_keys_are_added_where_the_design_lacks_them(bench_folder):
    Path("bare.toml").write_text(
        'cam1.friction = 0.14\n[stop]\nupper = "80 deg"\n[spring]\nstiffness = 5e4\n'
    )
    found = identify("bench.csv", "bare.toml", [*SPRING, "shaft.damping"])
    fitted = read_design(found.write_design("fitted.toml"))
    for name, key in (("friction", "cam2.friction"), ("spring.preload",) * 2, ("shaft.damping",) * 2):
        assert fitted.value(key) == found[name].value


def test_a_table_in_one_line_is_refused(bench_folder):
    Path("flat.toml").write_text("cam1 = {friction = 0.14}\n")
    found = identify("bench.csv", "flat.toml", ["friction"])
    with pytest.raises(IdentificationError, match=r"line 1.*allowed is a table \[cam1\]"):
        found.write_design("fitted.toml")
    assert not Path("fitted.toml").exists()


def test_a_groove_table_that_would_be_lost_is_refused(bench_folder):
    psi = np.linspace(-0.2, 2.0, 50)
    np.savetxt(
        "groove.csv", np.column_stack([psi, 0.02 * psi]), "%.9f", ",", header="psi_rad,z_m", comments=""
    )
    text = (
        Path("my.toml").read_text().replace('profile = "helix"', 'profile = "table"\ntable = "groove.csv"', 1)
    )
    Path("table.toml").write_text(text.replace('lead_angle = "45 deg"       # slope', "# slope", 1))
    found = identify("bench.csv", "table.toml", ["friction"])
    Path("other").mkdir()
    with pytest.raises(DualcamError, match=r"groove\.csv"):
        found.write_design("other/fitted.toml")
    assert not Path("other/fitted.toml").exists()
    assert found.write_design("fitted.toml").exists()


def test_the_picture_has_four_plots(design):
    picture = identify(slow_recording(), design, SPRING).plot()
    labels = [axes.get_ylabel() for axes in picture.axes]
    assert labels[0] == "torque [N.m]" and len(labels) == 4


# ---- recordings as benches make them ----


def test_few_samples_with_a_direction_are_enough(design):
    """Thirty readings with the sign of the speed beside each."""
    time = np.linspace(0.0, 10.0, 30)
    theta, omega, _ = sines(time)
    tau = SLOW.torque(theta, omega, 0.0 * time) + 0.01 * np.random.default_rng(0).standard_normal(30)
    with pytest.raises(IdentificationError, match="add a column of the angular velocity"):
        identify(Recording.from_arrays(time, theta, tau), design)
    found = identify(Recording.from_arrays(time, theta, tau, np.sign(omega)), design, motion="quasi-static")
    for name in SPRING:
        half = 0.5 * (found[name].high - found[name].low)
        assert abs(found[name].value - TRUE[name](SLOW)) < 2.0 * half


def test_coarse_sensors(design):
    """An encoder of 4096 lines and a torque in steps of 0.1 N.m."""
    time = np.linspace(0.0, 10.0, 2001)
    theta, omega, alpha = sines(time)
    line = 2.0 * np.pi / 4096
    tau = np.round(SLOW.torque(theta, omega, alpha) / 0.1) * 0.1
    found = identify(Recording.from_arrays(time, np.round(theta / line) * line, tau), design)
    assert found.noise == pytest.approx(0.1 / np.sqrt(12.0), rel=0.01)
    for name, error in zip(SPRING, (1e-3, 1.0, 200.0), strict=True):
        assert abs(found[name].value - TRUE[name](SLOW)) < error
    assert not found.warnings()


def test_uneven_times_and_a_gap(design):
    random = np.random.default_rng(0)
    time = np.unique(random.uniform(0.0, 10.0, 900))
    time = time[(time < 3.2) | (time > 4.0)]
    found = identify(recording(SLOW, time, sines(time)), design)
    for name in SPRING:
        half = 0.5 * (found[name].high - found[name].low)
        assert abs(found[name].value - TRUE[name](SLOW)) < 2.0 * half


def test_a_fault_is_named(design):
    data = slow_recording()
    data.tau[100] = 50.0
    found = identify(data, design)
    assert any("1 sample is off" in text and f"{data.time[100]:.6g} s" in text for text in found.warnings())


def test_a_mechanism_that_locks_itself(design):
    """Releasing takes a torque below zero. Both contacts are locked."""
    lead = {"cam1.lead_angle": 0.12, "cam2.lead_angle": 0.12}
    flat = replace(design, parameters=design.parameters | lead)
    time = np.linspace(0.0, 10.0, 401)
    bench = replace(SLOW, lead=(0.12, 0.12))
    data = recording(bench, time, sines(time), torque_noise=0.005)
    assert (data.tau[sines(time)[1] < -0.1] < 0.0).all()
    found = identify(data, flat)
    for name in SPRING:
        half = 0.5 * (found[name].high - found[name].low)
        assert abs(found[name].value - TRUE[name](SLOW)) < 2.0 * half


def test_the_zero_of_the_angle_and_the_preload_are_one(design):
    found = identify(slow_recording(), design, [*SPRING, "angle_offset"])
    (ambiguity,) = found.ambiguities
    assert set(ambiguity.names) == {"angle_offset", "spring.preload"}


def test_a_torque_of_zero_is_refused():
    time = np.linspace(0.0, 1.0, 50)
    with pytest.raises(IdentificationError, match="tau is 0"):
        Recording.from_arrays(time, time, 0.0 * time)
