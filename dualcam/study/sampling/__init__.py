"""How the values of the runs are drawn: distributions, correlation, arrangements, formulas."""
