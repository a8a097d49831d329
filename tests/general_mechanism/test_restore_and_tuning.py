"""Runs with any grooves: restored, reset, without ledger, and tuned."""

import numpy as np
import pytest
from pin_equations import PAIRS, band, friction, spring_energy, spring_force
from random_mechanisms import random_inputs, random_mechanism, step, turned_over


@pytest.mark.parametrize("regime", ["inertial", "viscous", "rate-independent"])
def test_a_restored_general_scene_repeats_bit_for_bit(make, tmp_path, regime):
    """Whatever was done in between, steps of other sizes and inputs included, on the same instance, or on
    another one that got the state as bytes."""
    rng = np.random.default_rng([31, len(regime)])
    for _ in range(6):
        pin, values = random_mechanism(rng, tmp_path, regime=regime)
        plan = [(h, random_inputs(rng, values, pin, h)) for h in 10.0 ** rng.uniform(-4, -1.5, 30)]
        fmu = make().start(values)
        for h, inputs in plan[:10]:
            step(fmu, h, inputs)
        state, time = fmu.take(), fmu.time
        content = fmu.to_bytes(state)

        def rest(driver, plan=plan, time=time):
            driver.time = time
            for h, inputs in plan[10:]:
                step(driver, h, inputs)
            return driver.everything()

        once = rest(fmu)
        fmu.restore(state)
        fmu.time = time
        for h, inputs in plan[20:]:
            step(fmu, 0.37 * h, inputs)
        fmu.restore(state)
        assert rest(fmu) == once
        fmu.free_state(state)
        twin = make().start(values)
        step(twin, 0.013, {"tau": [1.0], "F_ext": [3.0]})
        status, copy = twin.try_from_bytes(content)
        assert status == 0
        twin.restore(copy)
        assert rest(twin) == once
        twin.free_state(copy)


def test_a_reset_instance_is_as_new(make, tmp_path):
    """Ellipses, then tables, then helices on one instance: after fmi2Reset each run is bit for bit that of a
    fresh one."""
    rng, worn = np.random.default_rng(32), make()
    for pair in (("ellipse", "ellipse"), ("table", "table"), ("helix", "helix"), ("table", "ellipse")):
        pin, values = random_mechanism(rng, tmp_path, pair)
        plan = [(h, random_inputs(rng, values, pin, h)) for h in 10.0 ** rng.uniform(-4, -2, 12)]
        runs = []
        for fmu in (worn, make()):
            fmu.start(values)
            for h, inputs in plan:
                step(fmu, h, inputs)
            runs.append(fmu.everything())
        assert runs[0] == runs[1]
        worn.ok("fmi2Reset")


@pytest.mark.parametrize("regime", ["inertial", "viscous", "rate-independent"])
def test_without_ledger_the_general_motion_is_the_same(make, tmp_path, regime):
    rng = np.random.default_rng([33, len(regime)])
    for _ in range(8):
        pin, values = random_mechanism(rng, tmp_path, regime=regime)
        kept, without = make().start(values), make().start(values | {"ledger": False})
        for h in 10.0 ** rng.uniform(-4, -1.5, 25):
            inputs = random_inputs(rng, values, pin, h)
            for fmu in (kept, without):
                step(fmu, h, inputs)
            for name in ("theta", "omega", "z", "v", "alpha", "cam1.reaction", "mode", "events"):
                assert kept.get(name) == without.get(name), name
        assert (
            without.get("energy.work_in")
            == without.get("energy.residual")
            == without.get("peak.omega")
            == 0.0
        )


def test_tuning_during_a_general_run(make, tmp_path):
    """Friction, spring and damper changed while it moves: energy.work_tuning is the jump of the stored
    energy, and from there on it is the run of an FMU that had these parameters from the start."""
    rng = np.random.default_rng(34)
    for pair in PAIRS[1:]:
        pin, values = random_mechanism(rng, tmp_path, pair)
        values |= {"initial.theta": 0.4 * values["stop.upper"]}
        place = pin.at(values["initial.theta"])
        tau = 1.6 * band(place, friction(values), spring_force(values, place.z))[1]
        fmu = make().start(values, tolerance=1e-11)
        fmu.step(1e-3, tau=tau)
        moving, work = fmu.get("omega"), 0.0
        new = {
            "cam1.friction": 0.11, "cam2.friction": 0.07, "spring.preload": 1.3 * values["spring.preload"],
            "spring.stiffness": 0.8 * values["spring.stiffness"], "damper.c_load": 7.0, "damper.q_load": 50.0,
            "damper.c_release": 11.0, "damper.q_release": 3.0,
            "spring.stiffness2": values["spring.stiffness2"] + 1e4, "spring.stiffness3": 1e6,
        }  # fmt: skip
        z, now = pin.at(fmu.get("theta")).z, dict(values)
        for name, value in new.items():
            before = spring_energy(now, z)
            now[name] = value
            work += spring_energy(now, z) - before
            fmu.set({name: value})
            assert fmu.get("energy.work_tuning") == pytest.approx(work, rel=1e-9, abs=1e-13)
        assert fmu.get("omega") == moving
        assert fmu.get("spring.force") == pytest.approx(spring_force(now, z), rel=1e-11)
        place = pin.at(fmu.get("theta"))
        release, load = band(place, friction(now), spring_force(now, place.z))
        assert fmu.get("torque_load") == pytest.approx(load, rel=1e-11)
        assert fmu.get("torque_release") == pytest.approx(release, rel=1e-11)
        start = {"initial.theta": fmu.get("theta"), "initial.omega": moving}
        fresh = make().start(now | start, tolerance=1e-11)
        for h in (1e-3, 4e-3, 2e-2):
            for driver in (fmu, fresh):
                driver.step(h, tau=tau)
            assert fmu.get("theta") == pytest.approx(fresh.get("theta"), abs=1e-10)
            assert fmu.get("omega") == pytest.approx(
                fresh.get("omega"), abs=1e-9 * max(1.0, fresh.get("peak.omega"))
            )
        assert abs(fmu.get("energy.residual")) <= 1e-10 * turned_over(fmu)
