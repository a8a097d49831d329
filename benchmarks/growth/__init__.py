"""Growth of the cost with instances, steps, table points and threads; and the cost of starting up.

    ./build.sh run growth

Everything runs through loops in C: instances.c, and start_up.c in a process for each start-up. A step sets
tau, steps 1 ms, reads theta and omega. tau goes to and fro, so that the cam slips, reverses and sticks. Times
are medians over rounds in which all sizes take their turn. Memory is the resident memory that the process
gained. A cost that does not rise per unit grows linearly.
"""
