"""Packages of systems: start values reach every master, and a system that cannot be is refused."""

import warnings
import zipfile
from dataclasses import replace

import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.validation import validate_fmu
from pythonfmu.builder import FmuBuilder

from dualcam import Fmu, export_fmu, fmu_path
from dualcam.cli import main
from dualcam.coupling import Impedance, largest_stable_step
from dualcam.errors import DesignError, DualcamError, DualcamWarning
from dualcam.ssp import Component, System

FORWARD, INVERSE = fmu_path("forward"), fmu_path("inverse")
CAM = Component("cam", FORWARD, {"inertia.shaft": 0.05, "spring.preload": 10.0})
OTHER = Component("other", INVERSE, {})
SYSTEM = System("one", "One cam", (CAM,), (), 1e-3, 0.1, ("cam.tau", "cam.theta"))
MISTAKES = {
    "step": ({"step": 0}, "step = 0: allowed is a finite number > 0, in s"),
    "duration": ({"duration": -1.0}, "duration = -1.0: allowed is a finite number > 0, in s"),
    "step above duration": ({"step": 5, "duration": 1.8}, "step = 5 s: allowed is up to the duration, 1.8 s"),
    "no component": ({"components": ()}, "allowed is one component or more"),
    "one name": ({"components": (CAM, CAM)}, "component 'cam' is given twice"),
    "name with a point": ({"components": (Component("c.m", FORWARD, {}),)}, "letters, digits, _ and -"),
    "no file": ({"components": (Component("cam", "no.fmu", {}),)}, "component 'cam': there is no file"),
    "FMI 3": (
        {"components": (Component("cam", fmu_path("forward", fmi=3), {}),)},
        "is FMI 3.0: SSP 1.0 holds FMUs of FMI 2.0",
    ),
    "misspelt parameter": (
        {"components": (replace(CAM, values={"inertia.shat": 0.1}),)},
        "has no parameter inertia.shat: did you mean inertia.shaft?",
    ),
    "out of range": (
        {"components": (replace(CAM, values={"cam1.radius": -1.0}),)},
        "cam.cam1.radius = -1.0: allowed is a finite number >= 1e-06",
    ),
    "degrees": (
        {"components": (replace(CAM, values={"cam1.lead_angle": 45}),)},
        "allowed is a finite number >= 0 <= 1.5708; this looks like degrees; 45 deg is 0.785398 rad",
    ),
    "stops": (
        {"components": (replace(CAM, values={"stop.upper": -1.0}),)},
        "component 'cam': stop.upper = -1 rad (-57.3 deg): allowed is more than stop.lower",
    ),
    "jam": (
        {"components": (replace(CAM, values={"cam1.friction": 0.99, "cam2.friction": 1.1}),)},
        "component 'cam': jam: friction is too high for the lead angles",
    ),
    "spring that pulls": (
        {"components": (CAM, replace(OTHER, values={"spring.preload": -80}))},
        "component 'other': spring force at theta = 0 deg is -80 N: allowed is > 0",
    ),
    "a flat pair": (
        {"connections": ("cam.tau", "cam.theta")},
        'allowed is a list of pairs, such as [("motor.tau", "cam.tau")]',
    ),
    "a text as ports": ({"ports": "cam.theta"}, "ports = 'cam.theta': allowed is a list of"),
    "one component alone": ({"components": CAM}, "allowed is a list of Component"),
    "values without names": (
        {"components": (replace(CAM, values=[0.05]),)},
        "the values of a component: allowed is a dict",
    ),
    "output to output": (
        {"connections": (("cam.theta", "cam.omega"),)},
        "cam.omega is an output, allowed is an input or a tunable parameter",
    ),
    "from an input": (
        {"connections": (("cam.tau", "cam.F_ext"),)},
        "cam.tau is an input, allowed is an output",
    ),
    "to a fixed parameter": (
        {"connections": (("cam.theta", "cam.stop.upper"),)},
        "cam.stop.upper is a fixed parameter, allowed is an input or a tunable parameter",
    ),
    "units": ({"connections": (("cam.theta", "cam.F_ext"),)}, "the unit rad is not N"),
    "misspelt variable": ({"connections": (("cam.thet", "cam.F_ext"),)}, "did you mean theta?"),
    "no such component": (
        {"connections": (("cm.theta", "cam.F_ext"),)},
        "no component cm: did you mean cam?",
    ),
    "two sources": (
        {"components": (CAM, OTHER), "connections": (("other.tau", "cam.tau"),)},
        "cam.tau has two sources, other.tau and the system",
    ),
    "port": ({"ports": ("cam.inertia.shaft",)}, "port cam.inertia.shaft is a fixed parameter"),
    "two ports of one name": (
        {"components": (CAM, OTHER), "ports": ("cam.z", "other.z")},
        "ports cam.z and other.z have one name",
    ),
}


@pytest.mark.parametrize("change, words", MISTAKES.values(), ids=MISTAKES)
def test_a_system_that_cannot_be_is_refused(tmp_path, change, words):
    with pytest.raises(DesignError) as refusal:
        replace(SYSTEM, **change).save(tmp_path / "bad.ssp")
    assert words in str(refusal.value)
    assert not (tmp_path / "bad.ssp").exists()


def test_all_mistakes_of_a_system_are_named_at_once(tmp_path):
    wrong = replace(SYSTEM, connections=(("cam.thet", "cam.tau"),), ports=("cam.nothing",))
    with pytest.raises(DesignError, match=r"(?s)cam\.thet: .*cam\.nothing: "):
        wrong.save(tmp_path / "bad.ssp")


def test_a_master_that_reads_no_parameter_set_runs_with_the_start_values(tmp_path):
    """FMPy's `simulate_ssp` alone, beside the FMU with these parameters. The input of the system reaches the
    FMU one step late. The FMU's other input, F_ext, is 0: FMPy would give an open connector another value."""
    package = SYSTEM.save(tmp_path / "one.ssp")
    result = simulate_ssp(str(package), stop_time=0.0995, step_size=1e-3, input={"tau": lambda time: 5.0})
    assert len(result) == 100
    with Fmu("forward") as fmu:
        fmu.start(CAM.values)
        fmu.step(1e-3)
        tau = fmu.reals("tau")
        tau.values[0] = 5.0
        tau.write()
        for _ in range(99):
            fmu.step(1e-3)
        assert fmu.real("theta") > 0.1
        assert result["theta"][-1] == fmu.real("theta")


def test_an_fmu_with_start_values_is_valid_and_starts_from_them(tmp_path):
    """Also the same FMU twice, each component with values of its own; a component without values keeps the
    file as it is."""
    second = Component("second", FORWARD, {"inertia.shaft": 0.02, "contacts": 1})
    package = replace(SYSTEM, components=(CAM, second, OTHER)).save(tmp_path / "s.ssp")
    with zipfile.ZipFile(package) as archive:
        archive.extractall(tmp_path)
    assert (tmp_path / "resources" / INVERSE.name).read_bytes() == INVERSE.read_bytes()
    for component in (CAM, second):
        fmu_file = tmp_path / "resources" / f"{component.name}.fmu"
        assert validate_fmu(str(fmu_file)) == []
        with Fmu(fmu_file) as fmu:
            fmu.start()
            assert {name: fmu.get(name) for name in component.values} == component.values


def test_two_files_of_one_name_are_refused(tmp_path):
    (tmp_path / "own").mkdir()
    copy = tmp_path / "own" / FORWARD.name
    copy.write_bytes(FORWARD.read_bytes())
    pair = (Component("a", FORWARD, {}), Component("b", copy, {}))
    with pytest.raises(DesignError, match="have one name in the package"):
        replace(SYSTEM, components=pair, ports=()).save(tmp_path / "two.ssp")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("valve.toml", r"valve\.toml: allowed are names that end in \.ssp"),
        ("Controller.fmu", r"Controller\.fmu: allowed are names that end in \.ssp"),
        ("cam.ssp", r"cam\.ssp is the FMU of a component"),
        ("missing/new.ssp", "the folder does not exist: make the folder"),
    ],
)
def test_a_package_replaces_no_other_file_and_makes_no_folder(tmp_path, name, words):
    """The FMU of the second component has the ending of a package."""
    for other in ("valve.toml", "Controller.fmu", "cam.ssp"):
        (tmp_path / other).write_bytes(INVERSE.read_bytes())
    second = Component("second", tmp_path / "cam.ssp", {})
    with pytest.raises(DesignError, match=words):
        replace(SYSTEM, components=(CAM, second)).save(tmp_path / name)
    assert {path.name for path in tmp_path.iterdir()} == {"valve.toml", "Controller.fmu", "cam.ssp"}
    assert all(path.read_bytes() == INVERSE.read_bytes() for path in tmp_path.iterdir())


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: SYSTEM.save(None), "allowed is the path of a file"),
        (lambda: Component("cam", 5, {}), "allowed are 'forward', 'inverse', or the path of an FMU"),
    ],
)
def test_what_is_no_path(call, words):
    with pytest.raises(DualcamError, match=words):
        call()


@pytest.mark.parametrize("name", ["forward", "inverse"])
def test_a_component_is_an_fmu_of_the_package_by_its_name(tmp_path, name):
    named, given = Component("cam", name, {}), Component("cam", fmu_path(name), {})
    files = [
        replace(SYSTEM, components=(component,)).save(tmp_path / f"{k}.ssp").read_bytes()
        for k, component in enumerate((named, given))
    ]
    assert files[0] == files[1]


def test_a_cam_that_locks_itself_is_packed_without_a_word(tmp_path):
    """An exported FMU runs such a design, too: whether locking is meant only a design file can say."""
    locks = replace(CAM, values={"cam1.lead_angle": 0.02})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert replace(SYSTEM, components=(locks,)).save(tmp_path / "s.ssp").is_file()


def test_start_values_that_look_like_another_unit_are_warned_of(tmp_path):
    strange = replace(CAM, values={"cam1.radius": 18.0})
    with pytest.warns(DualcamWarning, match="component 'cam': .*looks like millimetres; 18 mm is 0.018 m"):
        replace(SYSTEM, components=(strange,)).save(tmp_path / "s.ssp")


def test_tables_of_an_exported_fmu_are_judged_with_the_start_values(tmp_path):
    """A cam that locks itself, by its table, is what a component may be; a spring that pulls is an error."""
    (tmp_path / "flat.csv").write_text(
        "psi_rad,z_m\n0,0\n0.5,0.00114\n1,0.00228\n1.5,0.00342\n", encoding="utf-8"
    )
    (tmp_path / "my.toml").write_text(
        'cam1.profile = "table"\ncam1.table = "flat.csv"\nlimits.self_locking = true\n', encoding="utf-8"
    )
    assert main(["check", str(tmp_path / "my.toml")]) == 0
    cam = Component("cam", export_fmu(tmp_path / "my.toml", tmp_path / "Locks.fmu"), {"inertia.shaft": 0.05})
    replace(SYSTEM, components=(cam,)).save(tmp_path / "s.ssp")
    pulls = replace(cam, values={"spring.preload": -80.0})
    with pytest.raises(DesignError, match="component 'cam': spring force") as refusal:
        replace(SYSTEM, components=(pulls,)).save(tmp_path / "s.ssp")
    assert "self-locking" not in str(refusal.value)


MOTOR = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

class Motor(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.omega, self.tau = 0.0, 0.0
        self.register_variable(Real("omega", causality=Fmi2Causality.input))
        self.register_variable(Real("tau", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.tau = -1.25 * (self.omega - 3.0)
        return True
"""


def test_a_motor_as_an_fmu_is_stable_up_to_half_of_the_step_of_a_function(tmp_path):
    """D = 1.25 N.m.s/rad and J = 0.003022 kg.m2: D h/J < 1 in FMPy's master. Without friction and spring the
    speed goes to 3 rad/s, or swings beyond any limit."""
    inertia, impedance = 0.003022, Impedance(damping=1.25)
    bound = largest_stable_step(inertia, impedance, plant_is_fmu=True)
    assert bound == pytest.approx(0.5 * largest_stable_step(inertia, impedance), rel=1e-6)
    (tmp_path / "motor.py").write_text(MOTOR, encoding="utf-8")
    motor = Component("motor", FmuBuilder.build_FMU(tmp_path / "motor.py", dest=tmp_path), {})
    free = {"cam1.friction": 0.0, "cam2.friction": 0.0, "spring.preload": 1e-9, "spring.stiffness": 0.0}
    cam = replace(CAM, values=free | {"inertia.shaft": inertia, "stop.lower": -60.0, "stop.upper": 60.0})
    connections = (("motor.tau", "cam.tau"), ("cam.omega", "motor.omega"))
    system = System("one", "", (motor, cam), connections, 1e-3, 1.0, ("cam.theta",))
    with pytest.warns(DualcamWarning, match="stop.upper = 60 rad: this looks like degrees"):
        package = str(system.save(tmp_path / "s.ssp"))
    for share, swings in ((0.9, False), (1.1, True)):
        step = share * bound
        omega = simulate_ssp(package, stop_time=150.5 * step, step_size=step)["cam.omega"]
        assert bool(abs(omega[-20:] - 3.0).max() > 30.0) is swings
        assert swings or abs(omega[-1] - 3.0) < 1e-2
