"""Run time against error: the FMU beside other ways to simulate such a mechanism.

    ./build.sh run precision

Four scenes under torque that is constant in pieces of 0.1 or 1 s. The error of a result is the largest of its
errors in angle, speed and dissipated energy over the ends of all pieces. Each error is relative to the
largest size of its quantity in the scene. The dissipated energy is the work done less the energy stored. It
costs no time, since theta alone gives the work while the torque is constant. The reference is that of tests/:
the closed form at 60 digits for helices, else DOP853 at 1e-13 with polished events. Every run verifies the
reference: for helices by its own DOP853, in all scenes by plain_cam.py, which is other code for the
equations, in SciPy's DOP853 or Radau, and by the FMU at the tolerance 1e-12.

Every line of the picture is one way to simulate, and every point of a line one setting that trades time for
error:

FMU from C          DualCamForward, stepped by harness/pieces.c: tolerances 1e-3 to 1e-12, steps 0.1 ms to
                    a whole piece; without its ledger, since no peer keeps one
FMU with ledger     the same with the ledger, whose heats give the dissipated energy
FMU from FMPy       as the first, by FMPy's methods
SciPy ...           plain_cam.py: one right-hand side per direction, omega = 0 as a terminal event, nothing
                    integrated while it sticks; RK45, DOP853, LSODA, Radau
tanh, ...           the same with sigma = tanh(omega/width) and no events, in the same solvers
CVode on our ME     the model-exchange FMU, FMPy's CVodeSolver, no maximum step, nothing recorded
scikit-sundae       SUNDIALS' CVODE, BDF and Adams, on plain_cam.py as for SciPy
PythonFMU           plain_cam.py and SciPy inside do_step, stepped by harness/pieces.c, one step per piece
hand-written FMU    hand_written.c, fixed steps of semi-implicit Euler, stepped by harness/pieces.c

Set-up (load, instantiate, initialise) is never timed. Every setting runs once for its error. Then it runs
once in every round, unless another setting of its line is as exact in half the time. Each round has a new
order. Ratios are those of the same round, reported as medians. At each error level the fastest setting of a
line that meets the level counts. Settings that fail or take more than --limit seconds are listed. Peers that
are not installed are left out with a message: pip install -e '.[bench]'.
"""
