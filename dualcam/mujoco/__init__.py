"""The cam on hinge joints of a MuJoCo model.

    import mujoco
    from dualcam.mujoco import CamJoint, CamSimulation

    model = mujoco.MjModel.from_xml_path("arm.xml")
    data = mujoco.MjData(model)
    simulation = CamSimulation(model, data, [CamJoint("elbow", stiffness=4000.0, design="my.toml")])
    for _ in range(1000):
        data.ctrl[:] = ...
        simulation.step()                       # instead of mujoco.mj_step(model, data)

CamJoint        the cam beside the joint: the inverse FMU behind an elastic shaft
DriveTrain      the cam between a motor and the joint: the forward FMU, an elastic shaft, the joint
CamSimulation   one mjData or many, with their cams: step, reset, save, restore

Needs mujoco: pip install "dualcam[mujoco]".

May import common, fmi, fleet, design_file, systems.blocks.
"""

try:
    import mujoco as _mujoco  # noqa: F401
except ImportError:
    raise ImportError('dualcam.mujoco needs mujoco: pip install "dualcam[mujoco]"') from None

from dualcam.mujoco.cam_joint import CamJoint, DriveTrain
from dualcam.mujoco.simulation import CamSimulation, SimulationState

__all__ = ["CamJoint", "CamSimulation", "DriveTrain", "SimulationState"]
