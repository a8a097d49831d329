"""Which values the runs have: distributions, correlation, arrangements, constraints, and their rows."""
