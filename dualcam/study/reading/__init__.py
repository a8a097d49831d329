"""Reads plans and sections [study]: one pass with all mistakes.

The way from a file to a study:

1. `tables` takes away what the schema refuses: unknown keys and values of another kind.
2. `plan_table` and `scenario_table` make a plan and a scenario of the rest, which may still be wrong.
3. `parts` checks these with the FMU: names, ranges, formulas, results and pictures.

Each step notes what it finds with its place in the file (`dualcam.study.problem.Findings`), and goes on with
what is sound. What depends on a mistake is left out, so that one mistake gives one message."""
