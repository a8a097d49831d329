"""FMUs and fleets in a forked child, which neither hangs on its copies nor takes files from its parent."""

import multiprocessing
import os
import signal
import threading
import time
import traceback

import numpy as np
import pytest
from study_cases import every_run_once, study

import dualcam
from dualcam import Fleet, Fmu
from dualcam.errors import FmuError, StudyError
from dualcam.gradient import DifferentiableFleet
from dualcam.study.optimisation.models import FunctionModel

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork"),
    pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning"),
]

STEP = 1e-3  # s
COUNT = 300  # enough for threads to take part
LIMIT = 20.0  # s, after which a child counts as hanging


def in_child(function):
    """Call a function in a forked child. Fails if the function fails there, or hangs."""
    child = os.fork()
    if child == 0:
        try:
            function()
            os._exit(0)
        except BaseException:
            traceback.print_exc()
        os._exit(1)
    end = time.monotonic() + LIMIT
    while (found := os.waitpid(child, os.WNOHANG)) == (0, 0):
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            pytest.fail("the child hangs")
        time.sleep(0.005)
    assert os.waitstatus_to_exitcode(found[1]) == 0


@pytest.fixture
def groove(tmp_path):
    """An FMU that reads a table among its resources at each start."""
    psi = np.linspace(0.0, 0.8, 40)
    table = tmp_path / "groove.csv"
    table.write_text("psi_rad,z_m\n" + "".join(f"{a!r},{0.02 * a + 0.002 * a * a!r}\n" for a in psi.tolist()))
    design = tmp_path / "grooved.toml"
    design.write_text(
        '[cam1]\nprofile = "table"\ntable = "groove.csv"\n[cam2]\nprofile = "table"\ntable = "groove.csv"\n'
    )
    fmu = tmp_path / "Grooved.fmu"
    dualcam.export_fmu(design, fmu)
    return fmu


def test_a_child_that_closes_an_fmu_leaves_the_files_to_its_parent(groove):
    fmu = Fmu(groove)
    fmu.start({"tau": 8.0})
    fmu.step(0.02)
    expected = fmu.real("theta")

    def reopen():
        nonlocal fmu
        fmu = Fmu(groove)  # as a worker that makes its global FMU anew
        fmu.start({"tau": 8.0})
        fmu.step(0.02)
        assert fmu.real("theta") == expected
        fmu.close()

    in_child(reopen)
    fmu.start({"tau": 8.0})  # reads the table again
    fmu.step(0.02)
    assert fmu.real("theta") == expected
    fmu.close()


def test_a_child_goes_on_with_its_copy_of_an_fmu():
    with Fmu("forward") as fmu:
        fmu.start({"tau": 6.0})
        state = fmu.save_state()
        fmu.step(0.01)
        expected = fmu.real("theta")

        def repeat():
            fmu.restore_state(state)
            fmu.step(0.01)
            assert fmu.real("theta") == expected

        in_child(repeat)
        fmu.restore_state(state)


@pytest.mark.parametrize("end", ["close", "drop"])
def test_a_fleet_with_threads_in_a_child(groove, end):
    u = 6.0 * np.sin(np.linspace(1.0, 9.0, COUNT * 30)).reshape(COUNT, 30, 1)  # N.m
    fleet = Fleet(groove, COUNT, threads=4)
    expected = fleet.rollout(u, STEP)
    fleet.reset()
    time.sleep(0.01)  # its threads sleep

    def use():
        nonlocal fleet
        assert np.array_equal(fleet.rollout(u, STEP), expected)
        if end == "close":
            fleet.close()
            with pytest.raises(FmuError, match="this fleet is closed"):
                fleet.reset()
        fleet = None

    in_child(use)
    fleet.reset()  # reads the table again
    assert np.array_equal(fleet.rollout(u, STEP), expected)
    fleet.close()


def test_a_fork_while_a_fleet_is_at_work_in_another_thread():
    fleet, steps = Fleet("forward", COUNT, threads=2), 8000
    worker = threading.Thread(target=fleet.rollout, args=(np.full((COUNT, steps, 1), 6.0), STEP))

    def use():
        with pytest.raises(FmuError, match="when this process was forked: open a new one"):
            fleet.reset()
        fleet.close()

    worker.start()
    while not fleet._core._lock.locked():
        time.sleep(1e-3)
    in_child(use)
    worker.join()
    assert np.allclose(fleet.times, steps * STEP)
    fleet.close()


def test_a_fork_while_another_thread_has_the_lock_of_a_differentiable_fleet():
    arguments = [[0.4, 2.0]], np.full((1, 20, 1), 3.0)
    with DifferentiableFleet("forward", 1, STEP) as fleet:
        expected = fleet.states(*arguments)

        def use():
            assert np.array_equal(fleet.states(*arguments), expected)

        with fleet._lock:
            in_child(use)
        use()


def test_a_study_in_a_worker_of_a_pool(tmp_path):
    """Such a process may start no others."""
    one = study()
    with multiprocessing.get_context("fork").Pool(1) as pool:
        for call, arguments in ((one.run, (tmp_path, 2)), (FunctionModel, (abs, None, [], 2))):
            with pytest.raises(StudyError, match="may start no processes: use workers = 0"):
                pool.apply(call, arguments)
        pool.apply(one.run_to_files, (tmp_path,))
    every_run_once(tmp_path, one)
