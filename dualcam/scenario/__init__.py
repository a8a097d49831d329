"""What is done in each run: formulas, inputs over time, and the steps of a run.

May import common, fmi.
"""
