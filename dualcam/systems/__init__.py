"""Systems with the dual cam, and the blocks of which they are made.

    dualcam.systems.blocks        motor, loads, motions, controllers, the cam in their closed loop
    dualcam.systems.machines      a robot's elbow, a prosthetic knee, a car's door, a spring clamp

SI units throughout. Figures of real machines stand with their source and licence in the module that has them.

May import no other room.
"""
