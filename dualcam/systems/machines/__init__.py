"""Complete systems of the blocks, which system_examples/ run.

    robot_arm, elbow, elbow_controllers       a robot's elbow
    payload_filter                            payload and friction of the elbow from its encoder
    gait, swing, knee                         a prosthetic knee
    car_door                                  a car's side door
    clamp                                     a spring clamp that warms up

May import fmi, design, systems.blocks.
"""
