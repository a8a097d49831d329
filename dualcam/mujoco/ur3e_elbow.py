"""The elbow of a UR3e as MJCF text.

The forearm stands upright on its elbow at the angle 0, with wrist and payload. The upper arm stands still.
Axes: y is the axis of the elbow, z points along the forearm, x to where the arm falls as the angle grows. A
constraint keeps the wrist level, as dualcam.systems.machines.robot_arm assumes.

Source of all masses, centres, inertias and distances: UniversalRobots/Universal_Robots_ROS2_Description,
config/ur3e (physical_parameters.yaml, default_kinematics.yaml), BSD-3-Clause. The motor is that of
dualcam.systems.blocks.motor.AK80_6: its rotor behind the gear is the armature of the joint.
"""

from dualcam.systems.blocks.motor import AK80_6

MJCF = """
<mujoco model="elbow of a UR3e">
  <compiler angle="radian"/>
  <option timestep="{step}" {option}/>
  <worldbody>
    <body name="forearm">
      <joint name="elbow" axis="0 1 0" limited="true" range="{low} {high}" armature="{armature}" {joint}/>
      <inertial pos="0 0.0238 0.1632" mass="1.437" diaginertia="0.0065445702 0.0065445702 0.00354375"/>
      <body name="wrist_1" pos="0 0.13105 0.2132">
        <joint name="wrist_1" axis="0 1 0"/>
        <inertial pos="0 0 -0.01" mass="0.871" diaginertia="0.002085 0.00225 0.002085"/>
        <body name="wrist_2" pos="0 0 -0.08535">
          <inertial pos="0 0.01 0" mass="0.805" diaginertia="0.002085 0.002085 0.00225"/>
          <body name="wrist_3" pos="0 0.0921 0">
            <inertial pos="0 -0.02 0" mass="0.261" diaginertia="0.00013626667 0.0001792 0.00013626667"/>
            <body><geom type="sphere" size="0.03" mass="{payload}" contype="0" conaffinity="0"/></body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="wrist_1" joint2="elbow" polycoef="0 -1 0 0 0"/></equality>
  <actuator><motor joint="elbow" ctrlrange="-{peak} {peak}" ctrllimited="true"/></actuator>
</mujoco>
"""


def elbow_mjcf(
    payload: float, limits: tuple[float, float], step: float = 2e-3, joint: str = "", option: str = ""
) -> str:
    """The model as MJCF for `mujoco.MjModel.from_xml_string`. Its joints are `elbow` and `wrist_1`.

    `payload`: mass of the payload [kg], > 0. `limits`: least and largest angle of the elbow from upright
    [rad]. `step`: time step [s]. `joint`: further attributes of the elbow's joint, such as
    `frictionloss="1"`. `option`: further attributes of the options, such as `integrator="implicitfast"`.
    """
    low, high = limits
    return MJCF.format(
        payload=payload,
        low=low,
        high=high,
        step=step,
        joint=joint,
        option=option,
        armature=AK80_6.inertia,
        peak=AK80_6.peak_torque,
    )
