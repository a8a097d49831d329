"""The cost of one communication step, against one exp and one sincos, and against an FMU that does nothing.

    ./build.sh run cost

One step is fmi2SetReal(tau), fmi2DoStep(1 ms), fmi2GetReal(theta, omega). All quantities are measured in one
process and in turns: every round runs a block of each quantity, in an order that is shuffled anew, so that a
slow moment of the machine hits all alike. The results are ratios of blocks of the same round: the median over
the rounds, with quartiles. Before each block the FMU is restored, untimed, to the state that was saved after
set-up. Therefore all rounds do the same work, and the mode of motion is verified by reading `mode` and
`events` before and after. tau differs from step to step in every scene. Scenes that move far in little time
have short blocks. The scenes "events" are single steps, each from its own saved state: all steps of a scene
in which the mode changes.

The unit is the plain loop of harness/unit.h: exp(-x) and sincos(x) of the machine's own libm, called through
pointers. x in [0, 2 pi] comes from memory and the results are summed, so that consecutive calls may overlap.
A second loop, in which each call waits for the one before, is reported as well. It is the slower of the two
and no ratio uses it. The target of a scene is for its step less a step of the FMU that does nothing.

Instructions per step are counted by callgrind over the same blocks (harness/instructions.py). The limit of a
scene is the time of the work that cannot be left out: the three calls of an FMU that does nothing, and the
exponentials or the evaluations of the acceleration that its step needs at least (scenes.Least). Each part
counts with the price that it has by itself. The price of an evaluation is that of acceleration.c,
whose code has nothing in common with the FMU's.
"""
