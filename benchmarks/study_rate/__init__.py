"""Runs per second and core of a parameter study: load-and-release of 0.4 s with nine parameters that vary.

    ./build.sh rate

One core, one process. Timed in turns, reported as the median over the rounds with quartiles, all by
dualcam.study unless the name says otherwise:

cam             the forward FMU, begun with a saved state, as a user has it
cam, reset      the same, begun with fmi2Reset
null            an FMU that does nothing, whose runs begin with fmi2Reset: Python and ctypes
cam, ramps      torque that rises and falls along ramps: driven oscillations instead of free ones
cam, in C       the calls of "cam" on the same values from a C loop (study_runs.c): the time of the FMU itself
null, in C      the calls of "null", likewise
naive           fmpy.simulate_fmu for each run

Further results: the FMU's share of a run, and the best rate that this leaves to Python beside the do-nothing
FMU; the time of every call of a run of the cam, as Python sees it; and whether the memory of a whole study
with its results on disk grows.
"""
