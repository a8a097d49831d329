"""What does a step, a picture or an episode cost, through each way in which a user has it?

    ./build.sh run loop | fleet | gym | creep | web | view    [--rounds N]

Each module beside this one has one measure, whose ways are timed in turns. A row has the median of the times
of a unit of work, and the median of the ratios to one way of the same round. The quartiles are those of the
ratio, or of the time where there is no ratio.
"""
