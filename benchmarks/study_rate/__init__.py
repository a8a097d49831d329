"""Runs per second and core of a parameter study: load-and-release of 0.4 s with nine parameters that vary.

    ./build.sh run rate

One core, one process. Timed in turns by the time of the processor, reported as the median over the rounds
with quartiles, all by dualcam.study unless the name says otherwise:

cam             the forward FMU, begun with a saved state, as a user has it
cam, reset      the same, begun with fmi2Reset
cam, from Python  the same calls, each made from Python: as where a controller is called between them
cam, fleet      the same values in a dualcam.Fleet: Fleet.reset with 1000 rows, Fleet.step twice, Fleet.get
null            an FMU that does nothing, whose runs begin with fmi2Reset: what a study itself costs
cam, ramps      torque that rises and falls along ramps: driven oscillations instead of free ones
cam, smooth     torque along a smooth curve, whose peak and times vary from run to run
cam, in C       the calls of "cam" on the same values from a C loop (study_runs.c): the time of the FMU itself
null, in C      the calls of "null", likewise
naive           fmpy.simulate_fmu for each run

Further results: the FMU's share of a run; the time of every call of a run of the cam, as Python sees it; and
whether the memory of a whole study with its results on disk grows.
"""
