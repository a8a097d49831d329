"""What README.md shows runs, and says what it says."""

import ast
import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.fixture
def run_block(tmp_path, monkeypatch):
    """Runs the block that has this word in it; returns its text and what it leaves."""

    def run(word):
        block = next(b for b in re.findall(r"```python\n(.*?)```", README, re.DOTALL) if word in b)
        script = tmp_path / "block.py"
        script.write_text(block)
        monkeypatch.chdir(ROOT)
        return block, runpy.run_path(str(script))

    return run


def test_fmpy_block_runs(run_block):
    block, left = run_block("fmpy")
    last = left["result"][-1]
    theta, omega = map(float, re.search(r"theta = ([\d.]+) rad, omega = ([\d.]+)", block).groups())
    assert last["theta"] == pytest.approx(theta, abs=5e-5)
    assert last["omega"] == pytest.approx(omega, abs=5e-3)
    assert last["mode"] == 2


def test_python_control_block_runs(run_block, capsys):
    """Ten statements; at the end of the step the torque is the edge of the band, which would hold that angle
    after a move up: rho (F0 + k z)."""
    block, left = run_block("import dualcam")
    assert len([node for node in ast.parse(block).body if not isinstance(node, ast.Import)]) <= 10
    theta, tau = map(float, re.search(r"# ([\d.]+) rad, ([\d.]+) N\.m", block).groups())
    printed = [float(word) for word in capsys.readouterr().out.split()]
    assert printed == pytest.approx([theta, tau], abs=5e-5)
    assert left["theta"][-1] == pytest.approx(0.6, abs=1e-3)
    assert left["tau"][-1] == pytest.approx(0.01 * 1.14 / 0.86 * (50.0 + 500.0 * left["theta"][-1]), rel=1e-2)


def test_design_block_runs(run_block, capsys):
    block, _ = run_block("dualcam.design")
    said = float(re.search(r"# ([\d.]+) N\.m both", block)[1])
    assert [float(word) for word in capsys.readouterr().out.split()] == pytest.approx([said, said], abs=5e-5)


def test_table_of_the_robot_joint():
    """The table's figures are those that system_examples/robot_joint.py prints."""
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
