"""The scenario of a design, run in the FMU: one run, variables over time.

    simulate        runs the scenario of a design
    Trajectory      the result: arrays by the names of variables, written as CSV or Parquet

May import common, fmi, scenario, design_file.
"""

from dualcam.simulation.run import Trajectory, simulate

__all__ = ["Trajectory", "simulate"]
