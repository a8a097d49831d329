"""Gradients of runs of the forward FMU through stick, slip, mode changes and bounces.

    DifferentiableFleet      runs of a fleet with the Jacobian of every step
    Rollout, Gradient        such a run, and the gradient of a loss of it
    jax_rollout              the runs as a function that jax.grad and jax.jit take
    torch_rollout            the runs as a function through which torch differentiates

The first three need NumPy alone. `jax_rollout` needs JAX: pip install "dualcam[jax]". `torch_rollout` needs
PyTorch.

May import common, fmi, fleet.
"""

from dualcam.gradient.rollout import DifferentiableFleet, Gradient, Rollout
from dualcam.gradient.with_jax import jax_rollout
from dualcam.gradient.with_torch import torch_rollout

__all__ = ["DifferentiableFleet", "Gradient", "Rollout", "jax_rollout", "torch_rollout"]
