"""Pictures of a design, of its simulation, and of what lasts. Each function returns a matplotlib Figure.

    plot_band, plot_strength, plot_simulation      torque band, strength, a run
    plot_contact, plot_wear, plot_goodman          pressure, wear, fatigue of the spring
    save                                           writes a picture

May import common, design, simulation.
"""

from dualcam.plots.design import (
    plot_band,
    plot_contact,
    plot_goodman,
    plot_simulation,
    plot_strength,
    plot_wear,
    save,
)

__all__ = [
    "plot_band", "plot_contact", "plot_goodman", "plot_simulation", "plot_strength", "plot_wear", "save",
]  # fmt: skip
