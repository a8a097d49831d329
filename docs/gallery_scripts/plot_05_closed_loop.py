"""
Linear model, LQR, closed loop
==============================

python-control designs a controller for a linear model of the cam. The loop is then closed around the FMU
itself, with stick and slip.
"""

# %%
# The linear model at 0.4 rad, of slip that is about to begin in the loading direction, sampled at 1 kHz:

import control
import matplotlib.pyplot as plt
import numpy as np

import dualcam

signals = {"inputs": "tau", "outputs": ["theta", "omega"], "period": 1e-3}
plant = dualcam.linearize("forward", theta=0.4, at_rest="loading", **signals)
gain, _, poles = control.dlqr(plant, np.diag([5e3, 5.0]), [[1.0]])
hold, feed = plant.operating_point.tau, 1 / plant.dcgain()[0]
print(gain, np.abs(poles))

# %%
# The law: torque that holds the operating point, feed-forward of the reference, and feedback.

law = control.nlsys(
    None,
    lambda t, x, u, params: hold + feed * (u[0] - 0.4) - gain @ [u[1] - u[0], u[2]],
    inputs=["reference", "theta", "omega"],
    outputs="tau",
    dt=1e-3,
)
cam = dualcam.to_nonlinear_io_system("forward", **signals)
loop = control.interconnect([cam, law], inputs="reference", outputs=["theta", "tau"])

# %%
# Steps up and down. On the way up the model suits. On the way down friction acts in the other direction: the
# cam comes to rest above the reference, because the law holds with the torque of loading.

time = np.arange(0.0, 1.2, 1e-3)
reference = np.interp(time, [0.0, 0.3, 0.301, 0.6, 0.601, 0.9, 0.901], [0.4, 0.4, 0.6, 0.6, 0.8, 0.8, 0.4])
theta, tau = control.input_output_response(loop, time, reference, [0.4, 0.0]).outputs

figure, (angle, torque) = plt.subplots(2, 1, figsize=(8.0, 6.0), sharex=True, layout="constrained")
angle.plot(time, np.degrees(reference), "k--", label="reference")
angle.plot(time, np.degrees(theta), label="FMU in the loop")
angle.set(ylabel="angle of cam 2 [deg]")
angle.legend()
torque.plot(time, tau)
torque.set(xlabel="time [s]", ylabel="torque [N.m]")
plt.show()
