"""The general mechanism at its limits: the varied quantities, their ranges, and the outcome.

    ./build.sh run stress                                 all rows: tests/verification/results/stress.csv
    python -m verification.stress                       the same, with the FMU as it was built last
    python -m verification.stress --rows stiffness,dwell --fuzz 100 --output /tmp/stress.csv

Every run goes through the FMU's C functions in a process of its own, so that a crash or a step that never
ends is a result too. The judges share nothing with the C core but the equations:

reference   that of tests/: `simulate` (DOP853, all events), and for helices `simulate_exact` (closed form at
            60 digits, never stiff); the FMU is then compiled without its closed forms, or gets the helix as a
            table
Radau       one stiff smooth stretch by scipy's Radau method, from the pointwise equations of the reference;
            its own error is the change from a run at a 30 times coarser tolerance
limit       the reference of the mechanism without the small quantity (inertia, ...), to within its size
laws        no NaN, theta between its stops, energy conserved, heat never given back, the same answer however
            an interval is cut, a doStep below 2 s. All runs are held to these laws. Energy: to ten times the
            tolerance, once for every 1000 mode changes, because each swing to and fro adds an error of its
            own

Errors are relative to the scene's largest angle, speed and energy. A run is right if its errors stay below
ten times the tolerance. Where they do not, the reference itself is run with data changed by a tolerance, and
the change that this makes is allowed too.
"""
