"""The worst of a million steps, for hardware in the loop: their time, instructions and events.

    ./build.sh run worst

A run has 10^6 steps of 1 ms. It goes through stick, breakaway both ways, reversals, flank changes, both stops
with bounces, a follower force that turns the load around, torque and force that jump, ramps and swings, and a
torque that alternates from step to step. Its inputs are stretches of random kind, length and level. A step
sets both inputs (and the torque's rate, where the torque is a ramp), steps, reads angle and speed. The run is
repeated from the same saved state. The least time of each step over the rounds is the step's own time, free
of interrupts, which never hit the same step twice.

Then callgrind counts the instructions of single steps (harness/instructions.py): the longest steps, the
longest of each number of mode changes and of each kind, and steps at random, which show the relation of time
and instructions. Each counted step runs from a saved state some steps before. Modes, stop heat and reactions
before and after a step, read in a run of its own, tell the events of the step. Without valgrind there are
times only.

The bound (bound.py) holds by construction: it follows from the limits of all loops and of the counter of
evaluations, as they are written in the C sources.
"""
