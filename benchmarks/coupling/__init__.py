"""A plant coupled with the forward FMU: what derivatives gain, and which coupling with a motor is stable.

    ./build.sh run coupling    a closed loop with an oscillating load, below
    ./build.sh run ownplant    a motor in Python, own_plant.py

A motor turns a flywheel; a torsion shaft (stiffness K, damping D) connects it to cam 2 of DualCamForward.fmu.
The motor's torque oscillates, the cam rises and falls:

    I phi'' = A0 + A sin(2 pi f t) - d phi' - tau        tau = K (phi - theta) + D (phi' - omega)

The flywheel is a second slave. It gets theta and omega, the FMU gets tau, and the master is explicit: one
step per slave and communication step, none repeated, with the values known when the step begins. Three
masters:

held          inputs stay as they are over the step
first order   inputs are straight lines: fmi2GetRealOutputDerivatives of order 1 goes to the flywheel, tau' to
              the FMU by fmi2SetRealInputDerivatives
second order  inputs are parabolas: orders 1 and 2 of theta and omega, tau' and tau''

each in two ways: at once (Jacobi: both slaves step from the same communication point), and in turn
(Gauss-Seidel: the flywheel steps first; torque and derivatives at the end of its step, expanded about the
start, go to the FMU).

Neither slave adds an error of its own: helical grooves and a linear spring are a closed form in the FMU, the
flywheel under polynomials and a sine is one matrix exponential. The truth is the whole system in one, written
here from the equations of two helices with friction, stick and slip, solved by DOP853 at 1e-12 with its mode
changes located. Errors are taken at the communication points. The FMU coupled every 10 us has to meet that
truth, with the same mode changes.

The errors to expect. Inputs of order n leave an error of order n + 1 where the motion is smooth. Where slip
turns into stick or into slip the other way, alpha jumps by some a inside a step, which the parabola does not
foresee. theta is then wrong by at most a h^2/2, and the impulse of K theta on the flywheel by K a h^3/6:
third order like all other errors. Through a damper in the shaft omega counts too. omega is wrong by a h, and
the impulse of D omega by D a h^2/2: second order, from these steps alone. This error goes up and down with
the place of the jumps inside their steps. The third scene shows it.
"""
