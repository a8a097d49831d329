"""Runs of a fleet as a function of PyTorch."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from dualcam.gradient.rollout import DifferentiableFleet

if TYPE_CHECKING:
    from torch import Tensor
    from torch.autograd.function import FunctionCtx as Context

NEEDS = "torch_rollout needs PyTorch: https://pytorch.org says how to install it"


def torch_rollout(fleet: DifferentiableFleet) -> Callable[[Tensor, Tensor, Tensor], Tensor]:
    """The runs of a fleet as a function through which PyTorch differentiates (`torch.autograd.Function`).

    The function is `run(start, u, p)` with tensors of the shapes (count, 2), (count, steps, n) and (count,
    k), as for `DifferentiableFleet.rollout`. It returns a tensor of float64 with theta [rad] and omega
    [rad/s] after each step, shape (count, steps, 2). `fleet`: stays open as long as the function is used.
    ImportError: PyTorch is not installed. The fleet computes on the processor, in float64; tensors of other
    types and devices are copied. Where no derivative exists, the derivative of one side comes out, as
    `DifferentiableFleet` says.
    """
    try:
        import torch
    except ImportError:
        raise ImportError(NEEDS) from None

    class Run(torch.autograd.Function):
        """The run, and the chain rule backwards."""

        @staticmethod
        def forward(ctx: Context, start: Tensor, u: Tensor, p: Tensor) -> Tensor:
            arguments = [tensor.detach().cpu().double().numpy() for tensor in (start, u, p)]
            if not any(ctx.needs_input_grad):
                return torch.from_numpy(fleet.states(*arguments)).to(start.device)
            ctx.made, ctx.like = fleet.rollout(*arguments), (start, u, p)
            return torch.from_numpy(ctx.made.states).to(start.device)

        @staticmethod
        def backward(ctx: Context, by_states: Tensor) -> tuple[Tensor, ...]:
            found = ctx.made.gradient(by_states.detach().cpu().double().contiguous().numpy())
            parts = (found.start, found.inputs, found.parameters)
            return tuple(torch.from_numpy(part).to(like) for part, like in zip(parts, ctx.like, strict=True))

    def run(start: Tensor, u: Tensor, p: Tensor) -> Tensor:
        return Run.apply(start, u, p)

    return run
