"""dualcam.mujoco. The oracles are SciPy at 1e-13 on the equations, the matrix of the backward Euler method,
the energies of MuJoCo and of the FMU, the FMU with one handle, closed forms, and the law of the shafts."""

import math
import re
import subprocess
import sys
import warnings
from dataclasses import replace
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from driver import ROOT
from reference.elastic_joint import ElasticJoint, solve

from dualcam import Fmu
from dualcam.errors import (
    DualcamError,
    DualcamWarning,
    FleetError,
    FmuError,
    MujocoError,
    UnstableCouplingWarning,
)
from dualcam.mujoco import CamJoint, CamSimulation, DriveTrain
from dualcam.mujoco.torques import CamLaw, shaft_torques
from dualcam.mujoco.ur3e_elbow import elbow_mjcf
from dualcam.systems.blocks.helical_cam import HelicalCam
from dualcam.systems.machines import elbow, robot_arm
from system_examples import mujoco_elbow as example

PAGE = (ROOT / "docs/use-mujoco.md").read_text(encoding="utf-8")
CAM = HelicalCam((0.02, 0.02), (math.pi / 4, math.pi / 4), (0.14, 0.14), 50.0, 5e4)  # the FMU's defaults
MASS, CENTRE, OWN_INERTIA = 6.0, 0.15, 0.05  # kg, m, kg.m2
INERTIA = OWN_INERTIA + MASS * CENTRE**2
GRAVITY = 9.81 * MASS * CENTRE  # N.m
RATE = CAM.stiffness * CAM.dz_dtheta  # N/rad
RANGE = 'limited="true" range="0 79"'


def pendulum(step=2e-3, joint="", option="", limits=RANGE):
    """An inverted pendulum on one hinge, in degrees."""
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" {option}/><worldbody><body>'
        f'<joint name="elbow" axis="0 1 0" {limits} {joint}/>'
        f'<inertial pos="0 0 {CENTRE}" mass="{MASS}" diaginertia="{OWN_INERTIA} {OWN_INERTIA} 0.01"/>'
        "</body></worldbody></mujoco>"
    )


TWO_LINKS = """<mujoco><option timestep="0.002"/><worldbody>
<geom type="plane" pos="0 0 0.18" size="3 3 .1"/>
<body><joint name="a" axis="0 1 0" limited="true" range="0 79"/>
<geom type="capsule" fromto="0 0 0 0 0 .3" size=".02" mass="3"/>
<body pos="0 0 .3"><joint name="b" axis="0 1 0" limited="true" range="0 79"/>
<geom type="capsule" fromto="0 0 0 0 0 .3" size=".02" mass="1.5"/></body></body></worldbody></mujoco>"""


def data_at(model, angle, speed=0.0):
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = angle, speed
    return data


def after(cam, angle, speed, end, step=2e-3, **options):
    """Angle, speed and the torque of the shaft."""
    model = pendulum(step, **options)
    data = data_at(model, angle, speed)
    with CamSimulation(model, data, cam) as simulation:
        for _ in range(round(end / step)):
            simulation.step()
        return data.qpos[0], data.qvel[0], simulation.torque[0, 0]


def joint_of(stiffness, **values):
    arms = (CAM.load_arm, CAM.release_arm)
    return ElasticJoint(INERTIA, GRAVITY, stiffness, *arms, CAM.preload, RATE, **values)


# ---- the step against SciPy and closed forms ----


@pytest.mark.parametrize(
    "angle, speed, end, phases",
    [(0.3, 2.0, 0.2, "slip"), (0.8, -1.5, 0.1, "slip back"), (0.6, 0.6, 0.6, "to rest")],
)
@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast"])
def test_error_is_of_first_order(angle, speed, end, phases, integrator):
    """Beside the joint. The pendulum slips, or comes to rest and swings on the shaft."""
    truth = solve(joint_of(400.0), angle, speed, end)
    errors = []
    for step in (2e-4, 1e-4, 5e-5):
        found = after(CamJoint("elbow", 400.0), angle, speed, end, step, option=f'integrator="{integrator}"')
        errors.append(math.hypot(found[0] - truth[0], 0.1 * (found[1] - truth[1])))
    assert errors[-1] < 4.0 * 5e-5
    assert all(1.6 < coarse / fine < 2.4 for coarse, fine in pairwise(errors)), errors


@pytest.mark.parametrize("damping, motor", [(0.0, 0.0), (1.0, 1.5)])
def test_error_of_a_drive_train_is_of_first_order(damping, motor):
    inertia, stiffness = 0.05, 400.0
    truth = solve(joint_of(stiffness, cam_inertia=inertia, damping=damping, motor=motor), 0.3, 2.0, 0.15)
    cam = DriveTrain("elbow", stiffness, parameters={"inertia.shaft": inertia}, damping=damping)
    errors = []
    for step in (2e-4, 1e-4, 5e-5):
        model = pendulum(step)
        data = data_at(model, 0.3, 2.0)
        with CamSimulation(model, data, cam) as simulation:
            simulation.set_motor("elbow", motor)
            for _ in range(round(0.15 / step)):
                simulation.step()
        errors.append(math.hypot(data.qpos[0] - truth[0], 0.1 * (data.qvel[0] - truth[1])))
    assert errors[-1] < 6.0 * 5e-5
    assert all(1.6 < coarse / fine < 2.4 for coarse, fine in pairwise(errors)), errors


@pytest.mark.parametrize("stiffness", [10.0, 1e3, 1e5, 1e8])
def test_a_resting_cam_is_a_spring_by_backward_euler(stiffness):
    """At rest the step maps (dq, h dq') to [[1 - r, 1 - r], [-r, 1 - r]] (dq, h dq') with r = k/(1 + k) and
    k = K h^2/J. The magnitude of both eigenvalues is (1 + k)^(-1/2), so that no stiffness is unstable."""
    step = 2e-3
    model = pendulum(step, option='gravity="0 0 0"')
    data = data_at(model, 0.0)
    ratio = stiffness * step**2 / INERTIA
    shift = min(1e-3, 1e-3 / stiffness)  # rad: 1 mN.m, inside the stick band
    columns = []
    with CamSimulation(model, data, CamJoint("elbow", stiffness)) as simulation:
        start = simulation.save()
        for angle, speed in ((shift, 0.0), (0.0, shift / step)):
            simulation.restore(start)
            data.qpos[0], data.qvel[0] = angle, speed
            simulation.step()
            columns.append([data.qpos[0] / shift, step * data.qvel[0] / shift])
    share = ratio / (1.0 + ratio)
    expected = np.array([[1.0 - share, 1.0 - share], [-share, 1.0 - share]])
    assert pytest.approx(expected, abs=1e-9) == np.array(columns).T
    assert np.abs(np.linalg.eigvals(expected)).max() == pytest.approx((1.0 + ratio) ** -0.5)


@pytest.mark.parametrize("cam", [CamJoint("elbow", 400.0), DriveTrain("elbow", 400.0, damping=0.5)])
def test_energy_balance_closes_with_the_step(cam):
    """The energy that MuJoCo's pendulum loses is the work on the cam, to first order. The FMU's own balance
    closes to rounding. The FMU of a cam beside the joint counts the energy of the shaft; for a drive train
    that energy is K twist^2/2."""
    missing = []
    for step in (4e-4, 2e-4, 1e-4):
        model = pendulum(step)
        data = data_at(model, 0.3, 2.0)
        with CamSimulation(model, data, cam) as simulation:
            work, before = 0.0, data.qpos[0]
            for _ in range(round(0.2 / step)):
                simulation.step()
                work += simulation.torque[0, 0] * (data.qpos[0] - before)
                before = data.qpos[0]
            fleet = simulation.fleet("elbow")
            assert abs(fleet.get("energy.residual")[0]) < 1e-12
            taken = fleet.get("energy.work_in")[0]
            if isinstance(cam, DriveTrain):
                twist = data.qpos[0] - fleet.get("theta")[0]
                taken += 0.5 * cam.stiffness * twist**2
        gained = GRAVITY * (math.cos(0.3) - math.cos(data.qpos[0]))
        lost = gained + 0.5 * INERTIA * (2.0**2 - data.qvel[0] ** 2)
        assert work == pytest.approx(lost, rel=20.0 * step)
        missing.append(abs(lost - taken))
    if isinstance(cam, CamJoint) and not isinstance(cam, DriveTrain):
        assert missing[-1] < 1e-3 * work
        assert all(1.6 < coarse / fine < 2.4 for coarse, fine in pairwise(missing)), missing
    else:
        assert missing[-1] < 0.02 * work  # the damper of the shaft takes the rest


def test_the_fmu_follows_the_joint_as_a_single_handle_does():
    """The cam's angle and the torque are those of one Fmu that gets MuJoCo's angles."""
    model = pendulum()
    data = data_at(model, 0.3, 2.0)
    with CamSimulation(model, data, CamJoint("elbow", 400.0)) as simulation, Fmu("inverse") as fmu:
        fmu.start({"shaft.stiffness": 400.0, "theta": 0.3})
        angle = fmu.reals("theta")
        for _ in range(300):
            simulation.step()
            angle.values[0] = data.qpos[0]
            angle.write()
            fmu.step(2e-3)
            assert simulation.fleet("elbow").get("theta_cam")[0] == fmu.real("theta_cam")
        assert fmu.real("energy.heat_cam1") == simulation.fleet("elbow").get("energy.heat_cam1")[0] > 0.0


# ---- holding ----


@pytest.fixture(scope="module")
def runs():
    return example.run_all()


def test_the_cam_holds_the_elbow_for_a_minute(runs):
    held = runs[example.CAM]
    assert abs(held.drift) < 1e-11 and abs(held.creep) < 1e-13
    assert math.degrees(held.angle[-1]) == pytest.approx(60.0, abs=1.0)


def test_frictionloss_creeps_as_its_regularisation_says(runs):
    """MuJoCo's manual, Computation: a friction constraint of impedance d and damping b gives way to a load f
    at v = R f/b, with R = (1 - d)/d A, b = 2/(d_max t), A the joint's dof_invweight0. As it comes d = 0.9,
    d_max = 0.95 and t = 0.02 s."""
    angle = runs[example.PLAIN].angle
    first = round((example.MOVE + 0.5) / example.STEP)
    rate = (angle[first + 50] - angle[first]) / (50 * example.STEP)
    model = example.arm(example.as_frictionloss())
    spring = model.jnt_stiffness[0] * (model.qpos_spring[0] - angle[first])
    load = elbow.weight(example.PAYLOAD).torque(angle[first] - elbow.LEAN) + spring
    assert rate == pytest.approx(0.1 / 0.9 * model.dof_invweight0[0] * load * 0.95 * 0.02 / 2.0, rel=0.02)


def test_the_best_settings_of_mujoco_are_shown(runs):
    """Nothing is held against MuJoCo that a setting cures."""
    assert runs[example.PLAIN].creep > 1e-4
    assert 1e-9 < runs[example.STIFFEST].creep < 1e-5
    assert abs(runs[example.NO_SLIP].drift) < 1e-12


@pytest.mark.parametrize("stiffness", [4e3, 1e6])
@pytest.mark.parametrize("option", ["", 'integrator="implicitfast"'])
def test_at_rest_nothing_moves_but_rounding(stiffness, option):
    """On one hinge without constraints the cam's angle stays bit for bit."""
    model = pendulum(option=option)
    data = data_at(model, 1.1)
    with CamSimulation(model, data, CamJoint("elbow", stiffness)) as simulation:
        for _ in range(2000):
            simulation.step()
        fleet = simulation.fleet("elbow")
        cam, angle = fleet.get("theta_cam")[0], data.qpos[0]
        for _ in range(5000):
            simulation.step()
        assert fleet.get("theta_cam")[0] == cam
        assert data.qpos[0] == pytest.approx(angle, abs=1e-14)
        held = GRAVITY * math.sin(angle)
        assert simulation.torque[0, 0] == pytest.approx(held, rel=1e-9)
        assert angle - cam == pytest.approx(held / stiffness, rel=1e-6)


def test_the_table_of_the_page_is_that_of_the_example(runs):
    shown = dict(re.findall(r"^\| ([\w ]+) \| ([-+.e\d]+ \| [-+.e\d]+) \|$", PAGE, re.MULTILINE))
    assert set(shown) == set(runs)
    for name, found in runs.items():
        creep, drift = (float(number) for number in shown[name].split(" | "))
        rounding = 1e-11 if name == example.CAM else 1e-15  # of MuJoCo's solver, which differs by processor
        assert creep == pytest.approx(found.creep, rel=0.05, abs=rounding)
        assert drift == pytest.approx(found.drift, rel=0.05, abs=rounding)


def test_arms_hold_where_statics_say_so():
    arms = example.let_go(12)
    held = np.array([example.is_held(friction) for friction in arms.friction])
    assert held.any() and not held.all()
    assert (np.degrees(arms.sag[held]) < 1.2).all() and (np.degrees(arms.sag[~held]) > 1.2).all()


def test_a_stop_of_the_cam_carries_the_joint():
    """Beyond the stop the shaft twists by the load over its stiffness."""
    model = pendulum(limits="", joint='damping="1"')
    data = data_at(model, 1.2)
    weak = {"spring.stiffness": 1e4}
    with CamSimulation(model, data, CamJoint("elbow", 400.0, parameters=weak, cam_stops=True)) as simulation:
        for _ in range(4000):
            simulation.step()
        assert simulation.fleet("elbow").get("theta_cam")[0] == pytest.approx(1.3963)
    held = GRAVITY * math.sin(data.qpos[0])
    assert 400.0 * (data.qpos[0] - 1.3963) == pytest.approx(held, rel=1e-6)


def test_a_joint_at_its_limit_leaves_the_shaft_its_torque():
    """The limit carries what the motor adds: T = K (theta - theta_cam), not a share of the motor's torque."""
    model = pendulum(limits='limited="true" range="0 50"')
    data = data_at(model, 0.8)
    with CamSimulation(model, data, CamJoint("elbow", 4e3)) as simulation:
        data.qfrc_applied[0] = 30.0
        for _ in range(2000):
            simulation.step()
        assert data.qfrc_applied[0] == 30.0
        twist = data.qpos[0] - simulation.fleet("elbow").get("theta_cam")[0]
        assert simulation.torque[0, 0] == pytest.approx(4e3 * twist, rel=1e-6)
        assert abs(data.qvel[0]) < 1e-9


# ---- several cams, several data ----


def test_the_torques_satisfy_all_laws():
    random = np.random.default_rng(3)
    factors = random.normal(size=(50, 3, 3))
    mobility = 10.0 * factors @ factors.transpose(0, 2, 1) + 0.1 * np.eye(3)
    step = 2e-3
    stiffness = 10.0 ** random.uniform(2.0, 6.0, 3)
    sources = random.normal(size=(50, 3)) * 5.0 * (1.0 + stiffness * step**2)
    laws = [
        CamLaw(sources[:, i], stiffness[i] * step**2, np.full(50, -1.0), np.full(50, 2.0)) for i in range(3)
    ]
    torques = shaft_torques(laws, mobility, np.zeros((50, 3)))
    twist = sources - stiffness * step**2 * np.einsum("nij,nj->ni", mobility, torques)
    excess = torques - np.clip(twist, -1.0, 2.0)
    assert np.abs(excess).max() < 1e-9 * np.abs(sources).max()
    assert (torques == -1.0).any() and (torques == 2.0).any() and (np.abs(torques - 0.5) < 1.4).any()


def two_cams():
    return [
        CamJoint("a", 4e3, parameters={"spring.stiffness": 7e4}),
        DriveTrain("b", 2e3, parameters={"spring.stiffness": 3e4, "inertia.shaft": 0.01}, damping=0.2),
    ]


def test_many_data_move_bit_for_bit_as_one():
    """With contacts, since the arm falls onto a table, and with different cams."""
    model = mujoco.MjModel.from_xml_string(TWO_LINKS)
    starts = [(0.5, 0.3), (0.9, 0.4), (0.7, 0.2)]
    friction = np.array([0.05, 0.1, 0.14])
    cams = [replace(cam, parameters=cam.parameters | {"cam1.friction": friction}) for cam in two_cams()]
    data = [data_at(model, start) for start in starts]
    with CamSimulation(model, data, cams) as many:
        for _ in range(400):
            many.step()
        for i, start in enumerate(starts):
            own = [
                replace(cam, parameters=cam.parameters | {"cam1.friction": friction[i]}) for cam in two_cams()
            ]
            alone = data_at(model, start)
            with CamSimulation(model, alone, own) as single:
                for _ in range(400):
                    single.step()
                assert np.array_equal(alone.qpos, data[i].qpos) and np.array_equal(alone.qvel, data[i].qvel)
                assert np.array_equal(single.torque[0], many.torque[i])
    assert data[1].ncon > 0


def test_a_restored_run_repeats_bit_for_bit():
    model = mujoco.MjModel.from_xml_string(TWO_LINKS)
    data = [data_at(model, start) for start in ((0.9, 0.4), (0.7, 0.2))]

    def run(simulation, steps):
        simulation.set_motor("b", [0.3, -0.2])
        for _ in range(steps):
            simulation.step()
        return [array.copy() for one in data for array in (one.qpos, one.qvel)], simulation.torque.copy()

    with CamSimulation(model, data, two_cams()) as simulation:
        run(simulation, 120)
        state = simulation.save()
        mujoco.mj_forward(model, data[0])  # as before a picture is drawn: changes nothing in the run
        first, torque = run(simulation, 200)
        run(simulation, 50)
        simulation.restore(state)
        second, again = run(simulation, 200)
    assert all(map(np.array_equal, first, second)) and np.array_equal(torque, again)


def test_reset_begins_anew():
    """Of all, and of one."""
    model = mujoco.MjModel.from_xml_string(TWO_LINKS)
    data = [data_at(model, (0.9, 0.4)) for _ in range(2)]
    with CamSimulation(model, data, two_cams()) as simulation:
        for _ in range(100):
            simulation.step()
        first = [one.qpos.copy() for one in data]
        for _ in range(70):
            simulation.step()
        for one in data[:1]:
            mujoco.mj_resetData(model, one)
            one.qpos[:] = 0.9, 0.4
        with pytest.raises(
            MujocoError, match=r"time of mjData 0 = 0 s, but its cams are at 0.34 s.*and reset after"
        ):
            simulation.step()
        simulation.reset([0])
        for _ in range(100):
            simulation.step()
        assert np.array_equal(data[0].qpos, first[0]) and np.array_equal(first[0], first[1])
        assert data[1].time == pytest.approx(0.54)


def test_a_cam_that_turns_against_the_joint():
    """The mirrored joint moves as the joint, and half the angle of the cam needs half its torque's arm."""
    plain = after(CamJoint("elbow", 400.0), 0.3, 2.0, 0.2)
    model = pendulum(limits='limited="true" range="-79 0"')
    data = data_at(model, -0.3, -2.0)
    with CamSimulation(model, data, CamJoint("elbow", 400.0, ratio=-1.0)) as simulation:
        for _ in range(100):
            simulation.step()
    assert -data.qpos[0] == pytest.approx(plain[0], abs=1e-13)
    model = pendulum(limits='limited="true" range="40 79"')
    data = data_at(model, 1.2)
    cam = CamJoint("elbow", 1e3, ratio=2.0, offset=math.radians(40.0))
    with CamSimulation(model, data, cam) as simulation:
        for _ in range(2000):
            simulation.step()
        assert 2.0 * simulation.torque[0, 0] == pytest.approx(GRAVITY * math.sin(data.qpos[0]), rel=1e-6)


# ---- what is refused, and warnings ----


def refused(message, model=None, data=None, cams=None):
    model = model or pendulum()
    with pytest.raises(MujocoError, match=message):
        CamSimulation(model, mujoco.MjData(model) if data is None else data, cams or CamJoint("elbow", 1e3))


def test_joints_that_do_not_suit():
    refused(r"no hinge joint 'elbo': did you mean elbow\?", cams=CamJoint("elbo", 1e3))
    for kind in ("slide", "ball", "free"):
        body = f'<body><joint name="elbow" type="{kind}"/><geom size="1"/></body>'
        model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
        refused(f'joint \'elbow\' is of type "{kind}": allowed is "hinge"', model)
    refused(r"joint 'elbow' has no limits.*range=\"0 1.3963\".*cam_stops=True", pendulum(limits=""))
    wide = pendulum(limits='limited="true" range="-10 70"')
    refused(r"has the range -0.17\d* to 1.22\d* rad.*0 and 1.3963 rad, allow range=\"0 1.3963\"", wide)
    refused(r"range=\"-0.5 0.8963\"", pendulum(), cams=CamJoint("elbow", 1e3, offset=-0.5))
    refused("joint 'elbow' has 2 cams: allowed is one", cams=[CamJoint("elbow", 1e3)] * 2)
    refused(r"cams = \['elbow'\]: allowed are one or more CamJoint", cams=["elbow"])


def test_models_and_data_that_do_not_suit():
    refused("integrator is RK4.*allowed are Euler, implicit", pendulum(option='integrator="RK4"'))
    refused("model = 'arm.xml': allowed is a mujoco.MjModel", "arm.xml", data=[])
    refused("of another model", data=mujoco.MjData(pendulum()))
    refused("data = 3: allowed is a mujoco.MjData", data=3)
    refused("0 mjData: allowed are one or more", data=[])
    model = pendulum()
    data = mujoco.MjData(model)
    refused("2 mjData: allowed are one or more, each only once", model, data=[data, data])


@pytest.mark.parametrize(
    "values, message",
    [
        ({"stiffness": 0.0}, r"joint 'elbow': stiffness = 0.0: allowed is a finite number > 0, in N.m/rad"),
        ({"stiffness": math.inf}, "stiffness = inf"),
        ({"stiffness": "stiff"}, "stiffness = 'stiff'"),
        ({"ratio": 0.0}, "ratio = 0.0: allowed is a finite number, not 0"),
        ({"offset": math.nan}, "offset = nan"),
        ({"joint": 3}, "joint = 3: allowed is the name"),
        ({"parameters": [1]}, r"parameters = \[1\]: allowed is a dict"),
    ],
)
def test_numbers_that_cannot_be(values, message):
    with pytest.raises(MujocoError, match=message):
        CamJoint(**({"joint": "elbow", "stiffness": 1e3} | values))
    assert issubclass(MujocoError, DualcamError)


def test_messages_of_drive_trains():
    with pytest.raises(MujocoError, match=r"damping = -1.0: allowed is a finite number >= 0"):
        DriveTrain("elbow", 1e3, damping=-1.0)
    still = DriveTrain("elbow", 1e3, parameters={"inertia.shaft": 0.0})
    refused(r"inertia.shaft = 0.0 kg.m2: allowed is a number > 0, the inertia of the cam", cams=still)
    model = pendulum()
    with CamSimulation(model, mujoco.MjData(model), DriveTrain("elbow", 400.0)) as simulation:
        for torque in (math.nan, [1.0, 2.0]):
            with pytest.raises(MujocoError, match=r"torque of joint 'elbow'.*allowed is a finite number"):
                simulation.set_motor("elbow", torque)
        with pytest.raises(MujocoError, match="joint 'knee' has no cam: allowed are 'elbow'"):
            simulation.fleet("knee")
    simulation = CamSimulation(model, mujoco.MjData(model), CamJoint("elbow", 1e3))
    with simulation, pytest.raises(MujocoError, match="has a CamJoint, which has no motor"):
        simulation.set_motor("elbow", 1.0)


def test_the_fmus_own_refusals_come_through():
    refused_by_fmu = CamJoint("elbow", 1e3, parameters={"cam1.friction_peak": 1.5})
    model = pendulum()
    with pytest.raises(FleetError, match=r"friction_peak.*shaft.stiffness = 0"):
        CamSimulation(model, mujoco.MjData(model), refused_by_fmu)
    data = data_at(model, 0.5)
    with CamSimulation(model, data, CamJoint("elbow", 1e3)) as simulation:
        pass
    with pytest.raises(FmuError, match="closed"):
        simulation.step()


@pytest.mark.parametrize("cam", [CamJoint("elbow", 1e3), DriveTrain("elbow", 400.0)])
def test_a_state_that_is_not_finite_is_no_step(cam, tmp_path, monkeypatch):
    """MuJoCo resets such data with a warning. Nothing that is not finite gets into the cams."""
    monkeypatch.chdir(tmp_path)  # MuJoCo writes the warning into a file
    model = pendulum()
    data = data_at(model, 0.5)
    with CamSimulation(model, data, cam) as simulation:
        for _ in range(10):
            simulation.step()
        state = simulation.save()
        data.qvel[0] = math.nan
        with pytest.raises(MujocoError, match=r"time of mjData 0 = 0 s, but its cams are at 0.02 s"):
            simulation.step()
        simulation.restore(state)
        data.qfrc_applied[0] = math.nan
        with pytest.raises(MujocoError, match=r"mjData 0 was reset by MuJoCo.*not finite"):
            simulation.step()
        with pytest.raises(MujocoError, match="the last step failed: allowed are restore"):
            simulation.step()
        simulation.restore(state)
        simulation.step()
        assert math.isfinite(data.qpos[0]) and np.isfinite(simulation.torque).all()


def test_what_has_no_effect_is_named():
    model = pendulum()
    cam = CamJoint("elbow", 1e3, parameters={"damper.c_load": 10.0, "inertia.follower_mass": 0.2})
    with pytest.warns(
        DualcamWarning, match=r"damper.c_load, inertia.follower_mass of the cam do not act"
    ) as caught:
        CamSimulation(model, mujoco.MjData(model), cam).close()
    assert caught[0].filename == __file__


def test_a_step_that_is_too_long_for_a_drive_train_is_named():
    """The bound is K h^2 = J."""
    model = pendulum()
    long, short = (DriveTrain("elbow", k, parameters={"inertia.shaft": 0.002}) for k in (4e3, 499.0))
    with pytest.warns(UnstableCouplingWarning, match=r"0.016 kg.m2.*0.000707 s.*500 N.m/rad") as caught:
        CamSimulation(model, mujoco.MjData(model), long).close()
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        CamSimulation(model, mujoco.MjData(model), short).close()


@pytest.mark.parametrize("peak, stiffness", [(1.0, 400.0), (1.0, 2500.0), (1.5, 2500.0)])
def test_a_drive_train_comes_to_rest_without_gaining_energy(peak, stiffness):
    """From a fall to rest in the stick band: the energies of pendulum, shaft and cam never grow by more than
    the error of a step."""
    inertia, step = 0.01, 2e-3
    model = pendulum(step)
    data = data_at(model, 0.5, 1.0)
    values = {"inertia.shaft": inertia, "cam1.friction_peak": peak, "cam2.friction_peak": peak}
    with CamSimulation(model, data, DriveTrain("elbow", stiffness, parameters=values)) as simulation:
        fleet, energies = simulation.fleet("elbow"), []
        for _ in range(1500):
            simulation.step()
            theta, omega, spring = (fleet.get(name)[0] for name in ("theta", "omega", "energy.spring"))
            moving = 0.5 * INERTIA * data.qvel[0] ** 2 + 0.5 * inertia * omega**2
            height = GRAVITY * math.cos(data.qpos[0])
            energies.append(moving + height + spring + 0.5 * stiffness * (data.qpos[0] - theta) ** 2)
    assert np.diff(energies).max() < 0.02
    assert energies[-1] < energies[0] and abs(data.qvel[0]) < 1e-6


def test_the_extra_is_named_where_mujoco_is_absent():
    code = "import sys; sys.modules['mujoco'] = None; import dualcam.mujoco"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert 'pip install "dualcam[mujoco]"' in run.stderr


# ---- the model of the elbow ----


@pytest.mark.parametrize("payload", [0.5, 1.5, 3.0])
@pytest.mark.parametrize("angle", [0.3, 1.0, 1.5])
def test_the_mjcf_has_the_gravity_and_inertia_of_the_elbow(payload, angle):
    """Gravity and inertia are those of dualcam.systems.machines.robot_arm, whose wrist stays level."""
    model = mujoco.MjModel.from_xml_string(elbow_mjcf(payload, (0.0, 1.6)))
    data = data_at(model, (angle, -angle))
    mujoco.mj_forward(model, data)
    expected = robot_arm.arm_weight(payload, 0.0).torque(angle)
    assert -data.qfrc_bias[0] == pytest.approx(expected, rel=1e-12)
    level, momentum = np.array([1.0, -1.0]), np.zeros(2)  # the speeds of a level wrist
    mujoco.mj_mulM(model, data, momentum, level)
    found = level @ momentum - model.dof_armature[0]
    assert found == pytest.approx(robot_arm.arm_inertia(payload), abs=1e-9)  # its figures have 7 digits
