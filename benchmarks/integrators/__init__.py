"""Which integrator suits theta'' = alpha(t, theta, omega): work against error, scene by scene.

    .venv/bin/python -m benchmarks.integrators

Builds integrators.c with the compiler of the FMUs. Every candidate runs every scene at the tolerances 1e-4 to
1e-12. Its end point is compared with a reference on which two unrelated methods agree. Times are ratios to
one exp and one sincos of the machine's libm, measured in the same round and in turns: medians over the
rounds. Scenes "1 ms" restart the method at every communication point: the method keeps nothing from the step
before, and the times are those of one communication step.
"""
