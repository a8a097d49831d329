"""The runs: their FMI calls, the batch in C, their workers, and what the FMU says before them."""
