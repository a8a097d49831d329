"""Runs of a fleet as a function of JAX."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from dualcam.common.arrays import Array
from dualcam.errors import DualcamError
from dualcam.gradient.rollout import DifferentiableFleet

if TYPE_CHECKING:
    from jax import Array as JaxArray

NEEDS = 'jax_rollout needs JAX: pip install "dualcam[jax]"'
DOUBLE = (
    "jax_rollout needs numbers of 64 bits, and JAX is set to 32: call "
    'jax.config.update("jax_enable_x64", True) before the first use of JAX'
)


def jax_rollout(fleet: DifferentiableFleet) -> Callable[[JaxArray, JaxArray, JaxArray], JaxArray]:
    """The runs of a fleet as a function that `jax.grad`, `jax.vjp` and `jax.jit` take.

    The function is a `jax.custom_vjp`: JAX calls the fleet (`jax.pure_callback`), and goes backwards through
    the Jacobians of the steps. The function has first derivatives in reverse mode. `jax.vmap` makes one run
    after another; give the fleet more instances instead. Where no derivative exists, the derivative of one
    side comes out, as `DifferentiableFleet` says. An error of the FMU comes as JAX's error, with the FMU's
    message in its text.

    Parameters
    ----------
    fleet : Stays open as long as the function is used.

    Returns
    -------
    callable
        `run(start, u, p)` of shapes (count, 2), (count, steps, n) and (count, k), as for
        `DifferentiableFleet.rollout`. It returns theta [rad] and omega [rad/s] after each step, shape
        (count, steps, 2).

    Raises
    ------
    ImportError : JAX is not installed.
    DualcamError : JAX is set to numbers of 32 bits.

    Examples
    --------
    >>> import jax
    >>> jax.config.update("jax_enable_x64", True)
    >>> import jax.numpy as jnp
    >>> from dualcam.gradient import DifferentiableFleet, jax_rollout
    >>> with DifferentiableFleet("forward", 1, 1e-3, parameters=["cam1.friction"]) as fleet:
    ...     run = jax_rollout(fleet)
    ...     start, u = jnp.array([[0.4, 0.0]]), jnp.full((1, 20, 1), 5.0)  # rad, rad/s; N.m
    ...     slope = jax.grad(lambda friction: run(start, u, friction)[0, -1, 0])(jnp.array([[0.14]]))
    ...     slope.round(3).tolist()  # rad per 1
    [[-0.32]]
    """
    try:
        import jax
        import jax.numpy as jnp
    except ImportError:
        raise ImportError(NEEDS) from None
    _require_double()
    knowns = 2 + len(fleet.inputs) + len(fleet.parameters)

    def states_on_host(start: JaxArray, u: JaxArray, p: JaxArray) -> Array:
        return fleet.states(np.asarray(start), np.asarray(u), np.asarray(p))

    def on_host(start: JaxArray, u: JaxArray, p: JaxArray) -> tuple[Array, Array]:
        made = fleet.rollout(np.asarray(start), np.asarray(u), np.asarray(p))
        return made.states, made.jacobians

    def with_jacobians(start: JaxArray, u: JaxArray, p: JaxArray) -> tuple[JaxArray, JaxArray]:
        _require_double()
        shape = (fleet.count, u.shape[1], 2)
        results = (
            jax.ShapeDtypeStruct(shape, np.float64),
            jax.ShapeDtypeStruct((*shape, knowns), np.float64),
        )
        found: tuple[JaxArray, JaxArray] = jax.pure_callback(
            on_host, results, start, u, p, vmap_method="sequential"
        )
        return found

    @jax.custom_vjp
    def run(start: JaxArray, u: JaxArray, p: JaxArray) -> JaxArray:
        _require_double()
        result = jax.ShapeDtypeStruct((fleet.count, u.shape[1], 2), np.float64)
        found: JaxArray = jax.pure_callback(states_on_host, result, start, u, p, vmap_method="sequential")
        return found

    def backward(jacobians: JaxArray, by_states: JaxArray) -> tuple[JaxArray, JaxArray, JaxArray]:
        def step(adjoint: JaxArray, at: tuple[JaxArray, JaxArray]) -> tuple[JaxArray, JaxArray]:
            jacobian, by_state = at
            pulled = jnp.einsum("ci,cij->cj", adjoint + by_state, jacobian)
            return pulled[:, :2], pulled[:, 2:]

        in_time = jnp.moveaxis(jacobians, 1, 0), jnp.moveaxis(by_states, 1, 0)
        start, pulled = jax.lax.scan(step, jnp.zeros((fleet.count, 2)), in_time, reverse=True)
        n = len(fleet.inputs)
        return start, jnp.moveaxis(pulled[..., :n], 0, 1), pulled[..., n:].sum(axis=0)

    run.defvjp(with_jacobians, backward)
    return run


def _require_double() -> None:
    import jax

    if not jax.config.read("jax_enable_x64"):
        raise DualcamError(DOUBLE)
