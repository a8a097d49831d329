"""The comparison of benchmarks/work_precision is fair: all peers simulate the same. No time is tested."""

import dataclasses

import numpy as np
import pytest
import reference

from benchmarks.harness import core
from benchmarks.harness.fmu import LOADING, RELEASING, STICK
from benchmarks.work_precision.fmus import CFmu, build_python_fmu, hand_written, python_fmu
from benchmarks.work_precision.plain_cam import PlainCam, scipy_advance
from benchmarks.work_precision.scenes import SCENES, columns, of_reference
from benchmarks.work_precision.sundials import Exchange, sundae_advance
from verification.endurance import oscillation, stick_slip

STRAIGHT, CURVED, STIFF, HOLD = SCENES
# Its first 10 ms: DOP853 takes steps of 1e-5 s.
SHORT = dataclasses.replace(STIFF, pieces=((0.005, 8.0), (0.005, 3.0)))
MOVE = ((0.02, 14.0),)
CHECKED = [STRAIGHT, CURVED, SHORT, HOLD]
each_scene = pytest.mark.parametrize("scene", CHECKED, ids=lambda scene: scene.name)


@pytest.mark.parametrize("scene", [STRAIGHT, HOLD], ids=lambda scene: scene.name)
def test_two_references_agree(scene):
    assert scene.exact
    assert max(scene.errors(of_reference(reference.simulate(scene.parameters, scene.intervals)))) < 1e-12


@each_scene
def test_the_fmu_agrees_with_the_reference(scene):
    for ledger in (True, False):
        settings = {**scene.parameters, "ledger": ledger}
        _, found = CFmu(scene, "DualCamForward", settings, 1e-12, 1).run()
        assert max(scene.errors(found)) < 1e-11


@each_scene
def test_the_equations_of_the_peers_agree_with_the_reference(scene):
    method = "Radau" if scene is SHORT else "DOP853"
    found = scene.result(PlainCam(scene.parameters).run(scene.pieces, scipy_advance(method, 1e-12)))
    assert max(scene.errors(found)) < 1e-10


@pytest.mark.parametrize("scene", [STRAIGHT, CURVED], ids=lambda scene: scene.name)
def test_smooth_friction_tends_to_coulombs(scene):
    """In proportion to its width, while it moves."""
    short = dataclasses.replace(scene, pieces=MOVE)
    cam, widths = PlainCam(scene.parameters), (1e-2, 1e-3)
    found = [cam.run_regularised(MOVE, "LSODA", 1e-9, width) for width in widths]
    errors = [max(short.errors(short.result(points))) for points in found]
    assert errors[1] < 1e-4
    assert errors[0] == pytest.approx(10 * errors[1], rel=0.3)


@pytest.mark.parametrize("scene", [STRAIGHT, CURVED, HOLD], ids=lambda scene: scene.name)
def test_model_exchange_in_cvode_agrees_with_the_reference(scene):
    _, found = Exchange(scene, 1e-10).run()
    assert max(scene.errors(found)) < 1e-6


@pytest.mark.parametrize("scene", [STRAIGHT, CURVED], ids=lambda scene: scene.name)
def test_the_hand_written_fmu_is_of_first_order(scene):
    core.build_hand_written_fmu()
    short = dataclasses.replace(scene, pieces=MOVE)
    steps = np.array([1e-4, 1e-5, 1e-6])
    errors = [max(short.errors(hand_written(short, h, h).run()[1])) for h in steps]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("package, line", [("pythonfmu", "PythonFMU"), ("sksundae", "scikit-sundae")])
def test_optional_peers_agree_with_the_reference(package, line):
    pytest.importorskip(package, reason="pip install -e .[bench]")
    if package == "pythonfmu":
        build_python_fmu()
        _, found = python_fmu(STRAIGHT, "DOP853", 1e-11).run()
    else:
        advance = sundae_advance("BDF", 1e-11)
        found = STRAIGHT.result(PlainCam(STRAIGHT.parameters).run(STRAIGHT.pieces, advance))
    assert max(STRAIGHT.errors(found)) < 1e-6


@each_scene
def test_no_scene_meets_what_the_peers_leave_out(scene):
    """No stop, and both pins on the flank of the spring: sampled along the FMU's own motion."""
    slave = CFmu(scene, "DualCamForward", scene.parameters, 1e-9, 1).slave
    instant = 0.0
    for duration, tau in scene.pieces:
        slave.set({"tau": tau})
        for _ in range(20):
            slave.fmu.doStep(instant, duration / 20)
            instant += duration / 20
            assert slave.integer("mode") in (STICK, LOADING, RELEASING)
            assert min(slave.real("cam1.reaction"), slave.real("cam2.reaction")) > 0
    assert slave.real("energy.heat_stop") == 0


def test_errors_are_relative_to_the_largest_size():
    points, heats = STRAIGHT.truth
    shifted = ([(theta + 1e-3, omega) for theta, omega in points], heats)
    largest = np.max(np.abs(columns(STRAIGHT.truth)[0]))
    assert STRAIGHT.errors(shifted) == pytest.approx((1e-3 / largest, 0.0, 0.0))


def test_many_steps_drift_by_rounding_alone():
    """The short form of `./build.sh run endurance`: 10^5 steps."""
    last = {row["what"]: float(row["value"]) for row in oscillation(100_000)}
    assert abs(last["phase, rad"]) < 1e-11 and abs(last["energy"]) < 1e-12 and last["time, s"] == 0.0
    last = {row["what"]: float(row["value"]) for row in stick_slip(100_000)}
    assert last["theta, rad"] == 0.0 and last["mode changes"] > 500 and abs(last["ledger residual"]) < 1e-14
