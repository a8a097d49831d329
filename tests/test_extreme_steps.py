"""Steps and inputs near the end of the range of numbers: a step ends, and gives numbers or a reason."""

import subprocess
import sys

import pytest
from driver import ROOT, models

PROGRAM = ROOT / "tests" / "support" / "extreme_scenes.py"
PATIENCE = 240.0  # s, for all scenes of an FMU; each takes milliseconds


@pytest.mark.parametrize("identifier", models)
def test_extreme_steps_end(binaries, identifier):
    """In a process of its own, which is killed where a step does not end."""
    command = [sys.executable, PROGRAM, binaries[identifier], identifier]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired as late:
        lines = (late.stdout or b"").decode().splitlines()
        pytest.fail(f"no end in {PATIENCE} s: {lines[-1:]}")
    assert done.returncode == 0, (done.stdout.splitlines()[-1:], done.stderr[-2000:])
    lines = done.stdout.splitlines()
    assert not [line for line in lines if line.startswith("wrong")]
    assert int(lines[-1].removeprefix("scenes ")) > 500


@pytest.mark.parametrize(
    ("identifier", "inputs"),
    [("DualCamForward", {"tau": 3.0}), ("DualCamInverse", {"theta": 0.3, "omega": 2.0, "alpha": 50.0})],
)
def test_a_step_below_the_rounding_of_the_time_is_made_whole(make_model, identifier, inputs):
    """The time is one double and stands still. Motion and energies are those of the step, bit for bit."""
    scenes = []
    for time in (0.0, 1e150):
        fmu = make_model(models[identifier]).start(time=time)
        fmu.step(1e-3, **inputs)
        scenes.append(fmu.everything())
    assert [float.fromhex(scene.pop("time")) for scene in scenes] == [1e-3, 1e150]
    assert scenes[0] == scenes[1]
    assert float.fromhex(scenes[0]["energy.work_in"]) > 0.0


def test_a_swing_far_beyond_the_stops_keeps_the_digits_of_the_tolerance_or_is_refused(make_model):
    """The place in a step is known to 2^-52, and theta to that share of dtheta/ds = omega h. Without friction
    and inertia the work between the stops is the change of the spring's energy, whatever the motion is."""
    z_per_rad, preload, stiffness, tolerance, upper = 0.01, 50.0, 50e3, 1e-9, 1.3963
    free = {"cam1.friction": 0.0, "cam2.friction": 0.0, "inertia.shaft": 0.0}
    most = tolerance * upper / 2.0**-52  # rad per step
    z = 0.3 * z_per_rad
    energy = preload * z + 0.5 * stiffness * z * z
    torque = (preload + stiffness * upper * z_per_rad) * z_per_rad  # the largest
    for speed in (0.9 * most, -0.9 * most):
        fmu = make_model(models["DualCamInverse"]).start(free, tolerance=tolerance)
        fmu.step(1.0, theta=0.3, omega=speed)
        assert fmu.get("energy.work_in") == pytest.approx(energy, abs=tolerance * torque * upper)
    for h, omega in ((1.0, 1.1 * most), (1e150, -0.0131)):
        fmu = make_model(models["DualCamInverse"]).start(free, tolerance=tolerance)
        fmu.set({"theta": 0.3, "omega": omega})
        words = ("theta = 0.3", f"omega = {omega!r}", "rad per step", "a shorter step")
        fmu.refused("fmi2DoStep", 0.0, h, 1, mentions=words)


@pytest.mark.parametrize(("ledger", "inertia", "h"), [(True, 1.0, 1e-55), (False, 1e-5, 1e-16)])
def test_a_motion_that_leaves_the_range_of_numbers_is_refused(make_model, ledger, inertia, h):
    """By an energy above 1e288 J, or, where no account is kept, by a speed above 1e288 rad/s."""
    torque = inertia * (1e145 if ledger else 1e289) / h
    stops = {"stop.lower": -1e280, "stop.upper": 1e280}
    values = {"ledger": ledger, "inertia.shaft": inertia, "cam1.friction": 0.0, "cam2.friction": 0.0}
    fmu = make_model(models["DualCamForward"])
    fmu.set(values | stops | {"spring.preload": 0.0, "spring.stiffness": 0.0})
    fmu.start()
    fmu.set({"tau": torque})
    fmu.step(0.01 * h)
    theta, omega = fmu.get("theta"), fmu.get("omega")
    assert omega == pytest.approx(0.01 * h * torque / inertia, rel=1e-12)
    arguments = 0.01 * h, 100.0 * h, 1
    fmu.refused("fmi2DoStep", *arguments, mentions=("range of numbers",))
    assert (fmu.get("theta"), fmu.get("omega")) == (theta, omega)


@pytest.mark.parametrize("h", [1e15, 1e25, 1e100])
@pytest.mark.parametrize("curve", [(6, -4, 8), (6, 4, -30), (3, 20, -8), (3, 4, 8), (3, -4, -8), (6, 4, 0)])
def test_a_cam_that_follows_its_torque_ends_in_the_band_or_at_a_stop_or_is_refused(make_model, h, curve):
    """In such a step the inertia is below all rounding. The path is that of the edges of the stick band: the
    cam rests where the torque of the end lies between the edges, or beyond an edge at a stop. No energy is
    lost."""
    fmu = make_model(models["DualCamForward"]).start()
    tau, slope, bend = (float(c) for c in curve)
    fmu.set({"tau": tau})
    fmu.set_derivatives({"tau": [slope / h, bend / h / h]})
    if fmu.call("fmi2DoStep", 0.0, h, 1) != 0:
        return
    last, theta = tau + slope + bend / 2, fmu.get("theta")
    load, release, work = (fmu.get(name) for name in ("torque_load", "torque_release", "energy.work_in"))
    assert (theta <= 1e-9 or release <= last * (1 + 1e-9)) and (
        theta >= 1.3963 - 1e-9 or last <= load * (1 + 1e-9)
    )
    assert abs(fmu.get("energy.residual")) <= 1e-9 * abs(work)
