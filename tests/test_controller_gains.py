"""The study of controller gains: its loops one by one, with one FMU and the full current loop each."""

import numpy as np
import pytest

from dualcam import Fmu
from dualcam.systems.blocks.axis import CamAxis
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD, CurrentLoop
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.machines import elbow
from system_examples import controller_gains as example

LOOPS = example.Loops(
    bandwidth=np.array([2.0, 10.9, 20.0]),
    share=np.array([0.0, 1.8, 1.9]),
    payload=np.array([2.5, 0.5, 2.5]),
    friction=np.array([0.10, 0.18, 0.10]),
)


def alone(loops):
    """RMS error [rad] and heat [J] of one loop: CamAxis, CurrentLoop with its limits, floats."""
    payload, friction = float(loops.payload[0]), float(loops.friction[0])
    start = elbow.plant_parameters(example.CAM, payload) | {f"cam{i}.friction": friction for i in (1, 2)}
    controller, motor = example.Controllers(loops), CurrentLoop(AK80_6)
    square = heat = 0.0
    with Fmu("forward") as fmu:
        axis = CamAxis(fmu)
        axis.start(start, float(example.ANGLES[0]))
        for k in range(example.PERIODS):
            period = motor.run(float(controller.torque(np.array([axis.angle]), k)[0]), axis.speed)
            axis.step(period.torque, elbow.weight(payload), CONTROL_PERIOD)
            square += (axis.angle - example.ANGLES[k + 1]) ** 2
            heat += period.heat
    return np.sqrt(square / example.PERIODS), heat


def test_each_loop_is_that_of_one_fmu_with_the_full_current_loop():
    errors, heats = example.run(LOOPS, block=3, workers=1)
    for i in range(3):
        error, heat = alone(LOOPS.part(slice(i, i + 1)))
        assert errors[i] == pytest.approx(error, rel=1e-6)
        assert heats[i] == pytest.approx(heat, rel=1e-6)


def test_blocks_and_workers_change_nothing():
    loops = example.grid(np.array([0.7, 2.1]), np.array([0.12, 0.17])).part(slice(0, 40))
    first = example.run(loops, block=40, workers=1, periods=300)
    for block, workers in ((20, 2), (8, 3)):
        second = example.run(loops, block, workers, periods=300)
        assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))


def test_the_picks_are_the_minima_of_the_maps():
    drawn = np.random.default_rng(3).uniform(1.0, 2.0, (4, 5, 30))
    drawn[2, 3] = 0.5
    result = example.Study(np.arange(20.0).reshape(4, 5) + 7.0, drawn, (1.0, 1.0))
    assert result.picks == {"nominal": (0, 0), "robust": (2, 3)}
    assert result.high[2, 3] == 0.5


def test_a_small_study_reports_and_draws(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(example, "BANDWIDTHS", np.array([3.0, 11.0]))
    monkeypatch.setattr(example, "SHARES", np.array([0.5, 1.0]))
    picture = tmp_path / "map.png"
    example.main(["--draws", "5", "--picture", str(picture)])
    assert "20 closed loops of 4000 periods" in capsys.readouterr().out
    assert picture.is_file()
