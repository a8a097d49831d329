"""The machinery for any grooves, on helices: against the closed form."""

import build_fmu
import numpy as np
import pytest
from compiler import compile_library
from driver import FORWARD, Driver, load
from pin_equations import ACCOUNTS, HEATS
from random_mechanisms import run_on, step, turned_over
from reference import INTEGERS, random_scene


@pytest.fixture(scope="module")
def library_without_closed_form():
    """The forward FMU in which every scene takes the way of general grooves: fmu_src/forward/lifecycle.c is
    compiled anew, the other objects are those of the FMU."""
    fmu, platform = build_fmu.dual_cam(FORWARD.identifier, check=False), build_fmu.host_platform(2)
    library = build_fmu.BUILD / "general" / platform.library(FORWARD.identifier).name
    changed = build_fmu.CORE / "forward/lifecycle.c"
    source = library.with_name(changed.name)
    source.parent.mkdir(exist_ok=True)
    source.write_text(
        f'#define DUALCAM_NO_CLOSED_FORM\n#include "{changed.relative_to(build_fmu.CORE).as_posix()}"\n'
    )
    sources = [source if path == changed else path for path in fmu.sources]
    defines = [*fmu.defines, *build_fmu.identity(fmu)]
    with build_fmu.locked():
        compile_library(platform, build_fmu.host_target(), defines, sources, library)
    return load(library)


MOTION = ("theta", "omega")


def play_scene(fmu, params, intervals, tolerance):
    """What is read after each interval."""
    given = {name: int(value) if name in INTEGERS else float(value) for name, value in params.items()}
    fmu.start(given | {"tau": intervals[0].tau, "F_ext": intervals[0].F_ext}, tolerance=tolerance)
    read = []
    for i in intervals:
        step(fmu, i.duration, {"tau": [i.tau, i.tau_rate], "F_ext": [i.F_ext, i.F_ext_rate]})
        read.append({name: fmu.get(name) for name in (*MOTION, *ACCOUNTS, "energy.residual", "peak.omega")})
    return read


@pytest.mark.parametrize("chunk", range(3))
def test_general_machinery_on_helices(make, library_without_closed_form, chunk):
    """Both ways through the same random helical scenes, in whole intervals: angle, speed and every account
    within ten times the tolerance of the scene's largest angle, speed, energy."""
    wrong = []
    for seed in range(50):
        params, intervals = random_scene(np.random.default_rng([62, chunk, seed]))
        exact = play_scene(make(), params, intervals, None)
        energy = max(abs(read[name]) for read in exact for name in ACCOUNTS) or 1.0
        size = dict.fromkeys([*ACCOUNTS, "energy.residual"], energy)
        size |= {
            "theta": max(abs(read["theta"]) for read in exact) or 1.0,
            "omega": exact[-1]["peak.omega"] or 1.0,
        }
        for tolerance in (1e-4, 1e-9, 1e-11):
            fmu = Driver(library_without_closed_form)
            try:
                found = play_scene(fmu, params, intervals, tolerance)
            except AssertionError as refusal:
                wrong.append(f"scene {chunk}, {seed}, at {tolerance}: {refusal}")
                continue
            finally:
                fmu.free()
            errors = {
                name: max(abs(a[name] - b[name]) for a, b in zip(exact, found, strict=True)) / size[name]
                for name in size
            }
            worst = max(errors, key=errors.get)
            if not errors[worst] <= 10 * tolerance:
                wrong.append(f"scene {chunk}, {seed}, at {tolerance}: {worst} misses by {errors[worst]:.1e}")
    assert not wrong, "\n".join(wrong)


def test_general_machinery_by_a_negligible_curvature(make):
    """The shipped FMU takes the general way where tau is curved, however little: on helices that is the
    motion of the closed form. A follower of which only the inertia about the axis counts, without any axial
    load: all reactions vanish and change flanks at once when alpha does."""
    values = {
        "cam1.radius": 0.029513614203264912, "cam1.lead_angle": 0.23071016207401981,
        "cam1.friction": 0.05074597929311204, "cam2.radius": 0.013967140783131205,
        "cam2.lead_angle": 0.4867667483823339, "cam2.friction": 0.08963531572859298, "spring.stiffness": 0.0,
        "spring.preload": 0.0, "inertia.shaft": 3e-5, "inertia.follower": 0.00024354955881143806,
        "initial.theta": 1.0, "initial.omega": -23.273763108264912, "stop.restitution": 0.3,
    }  # fmt: skip
    ramp = [0.3626971619102233, -11.152021961900246]
    plain, curved = make().start(values), make().start(values)
    run_on(plain, {"tau": ramp}, 0.0, 0.1, 1)
    run_on(curved, {"tau": [*ramp, 1e-300]}, 0.0, 0.1, 1)
    for name in (*MOTION, *ACCOUNTS):
        size = turned_over(plain) if name.startswith("energy") else 1.0
        assert curved.get(name) == pytest.approx(plain.get(name), abs=1e-8 * size), name
    whole, pieces = make().start(values), make().start(values)
    run_on(whole, {"tau": [*ramp, -10.337961488405258]}, 0.0, 0.1, 1)
    run_on(pieces, {"tau": [*ramp, -10.337961488405258]}, 0.0, 0.1, 100)
    assert min(fmu.get(name) for fmu in (whole, pieces) for name in HEATS) >= 0.0
    for name in (*MOTION, *ACCOUNTS):
        size = turned_over(pieces) if name.startswith("energy") else 1.0
        assert whole.get(name) == pytest.approx(pieces.get(name), abs=1e-8 * size), name
