"""What README.md shows runs, and says what it says."""

import re
import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_fmpy_block_runs(tmp_path, monkeypatch, capsys):
    block = next(b for b in re.findall(r"```python\n(.*?)```", README, re.DOTALL) if "fmpy" in b)
    script = tmp_path / "block.py"
    script.write_text(block)
    monkeypatch.chdir(ROOT)
    last = runpy.run_path(str(script))["result"][-1]
    theta, omega = map(float, re.search(r"theta = ([\d.]+) rad, omega = ([\d.]+)", block).groups())
    assert last["theta"] == pytest.approx(theta, abs=5e-5)
    assert last["omega"] == pytest.approx(omega, abs=5e-3)
    assert last["mode"] == 2


def test_table_of_the_robot_joint():
    """The table's figures are those that system_examples/robot_joint.py prints."""
    sys.path.insert(0, str(ROOT / "system_examples"))
    import robot_joint

    names = {
        "no cam": robot_joint.BARE,
        "cam": robot_joint.CAM,
        "cam, friction unknown to the controller": robot_joint.NAIVE,
    }
    results = robot_joint.run(ROOT / "build" / "DualCamForward.fmu")
    rows = re.findall(r"^\| ([\d.]+) kg \| ([^|]+?) \| (.*) \|$", README, re.MULTILINE)
    assert len(rows) == len(results)
    for payload, joint, cells in rows:
        result = results[float(payload), names[joint]]
        if "does not lift" in cells:
            assert not result.lifts
            continue
        shown = [float(cell.split()[0]) if cell.strip() else 0.0 for cell in cells.split("|")]
        measured = [
            (result.rms_current, 2),
            (result.joule_heat, 1),
            (result.friction_heat, 2),
            (result.largest_torque, 2),
            (result.hold_current, 2),
            (1e3 * result.max_error, 2),
        ]
        assert shown == [abs(round(value, digits)) for value, digits in measured]


def test_variables_named_exist():
    from driver import models

    named = set(
        re.findall(r"`((?:cam[12]|spring|damper|inertia|stop|shaft|initial|energy|peak)\.\w+)`", README)
    )
    assert named <= set().union(*(m.variables for m in models.values()))
