"""Parts of systems with the dual cam.

    motor, current_loop                       a geared brushless motor under a PI current loop
    motor_bank                                many of them
    gravity, pendulum                         loads: a mass on an arm, a body on a hinge, a hanging segment
    motions                                   reference motions: pick and place, Fourier series
    helical_cam, elliptical_cam               the cam as designers and controllers use it, by dualcam.design
    position_controller, speed_controller, impedance    controllers
    path_integral                             a plan improved by the costs of random plans around it (MPPI)
    radau_grid                                the grid of a plan by direct collocation
    elementwise                               formulas for one float and for arrays
    slow_motion                               the torque of slow motion from the inverse FMU
    grease, thermal_network                   friction that follows the temperature of the grease
    axis, record                              the forward FMU in a closed loop of all of these, and its record
    axis_bank                                 many axes by one fleet, begun at any state

May import common, fmi, fleet, design, coupling.
"""
