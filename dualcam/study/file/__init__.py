"""Studies described by TOML files.

The stages of a file, each with all of its mistakes at once:

1. `schema_check`: keys, and the kinds of their values.
2. `plan_table` and `scenario_table`: numbers, units, files and formulas.
3. `dualcam.study.run.fmu_check`: names, types and ranges of the FMU's variables."""
