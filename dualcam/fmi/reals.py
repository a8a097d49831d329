"""Groups of real variables with buffers that are laid out once: reading or writing a group costs one call
into the FMU and allocates only the returned floats."""

from collections.abc import Sequence
from ctypes import c_double

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import Array, real_array
from dualcam.common.process_bound import ProcessBound
from dualcam.errors import FmuError
from dualcam.fmi.instance import OK_OR_WARNING, Instance, References

__all__ = ["Array", "Reals"]


class Reals(ProcessBound):
    """A fixed group of n real variables with its own buffer, from `Fmu.reals`.

    Attributes
    ----------
    names : Names of the variables.
    values
        The buffer, in the order of `names` and in the FMU's units, shape (n,). `read` fills the buffer,
        `write` sends it to the FMU. Assigning to `values` copies into the buffer.

    Examples
    --------
    >>> from dualcam import Fmu
    >>> with Fmu("forward") as fmu:
    ...     inputs, outputs = fmu.reals("tau", "F_ext"), fmu.reals("theta", "z")
    ...     fmu.start()
    ...     inputs.values = [4.0, 20.0]  # N.m, N
    ...     inputs.write()
    ...     fmu.step(0.1)
    ...     theta, z = outputs.read()
    >>> round(theta, 4), round(z, 4)  # rad, m
    (0.9179, 0.0092)
    """

    _instead = "make a group of its `names` with the FMU there: fmu.reals(*names)"

    def __init__(self, instance: Instance, names: Sequence[str], references: References) -> None:
        self.names = tuple(names)
        self._values = np.zeros(len(names))
        self._instance = instance
        self._references = references
        # The same memory: ctypes passes it on as it is, and makes floats of it faster than NumPy.
        self._buffer = (c_double * len(names)).from_buffer(self._values.data)
        self._arguments = instance.real_arguments(references, self._buffer)

    def __repr__(self) -> str:
        known = ", ".join(self.names)
        return f"<Reals {known or 'of no variable'}{'' if self._instance.is_open else ', FMU closed'}>"

    @property
    def values(self) -> Array:
        """The buffer, shape (n,). FmuError where the FMU is closed."""
        self._instance.require_open()
        return self._values

    @values.setter
    def values(self, new: ArrayLike) -> None:
        self._instance.require_open()
        self._values[:] = real_array(new, "values", FmuError, self._values.shape)

    def read(self) -> list[float]:
        """Fetch the group from the FMU into `values`. The n values come back as plain floats, too, which are
        the fastest for scalar code.
        """
        instance = self._instance
        status = instance.get_real(*self._arguments)
        if status > OK_OR_WARNING:
            instance.check(status, instance.GET_REAL)
        return self._buffer[:]

    def write(self) -> None:
        """Send `values` to the FMU. FmuError where the FMU refuses a value."""
        instance = self._instance
        status = instance.set_real(*self._arguments)
        if status > OK_OR_WARNING:
            instance.check(status, instance.SET_REAL)

    def read_derivatives(self, order: int) -> list[float]:
        """The n time derivatives of `order` 1 or 2 of the group, in the variable's unit per s or per s2.
        FmuError for another order, or where a variable is no output.
        """
        self._instance.require_calls_allowed()
        derivatives = (c_double * len(self.names))()
        self._instance.output_derivatives(self._references, _order(order), derivatives)
        return derivatives[:]

    def write_derivatives(self, order: int, values: Sequence[float]) -> None:
        """Set time derivatives of the group, whose variables are all inputs, for the next step only.

        `order` of the derivatives: 1, 2 or 3. `values`: the derivatives, in the variable's unit per s, s2 or
        s3, shape (n,). FmuError for another order or shape, where a variable is no input, and in FMI 3.0,
        which has no derivatives of inputs.
        """
        self._instance.require_calls_allowed()
        given = real_array(values, "values", FmuError, self._values.shape)
        derivatives, orders = (c_double * len(self.names))(*given), [_order(order)] * len(self.names)
        call = self._instance.input_derivatives_call(self._references, orders, derivatives)
        self._instance.check(call(), "setting derivatives of inputs")


def _order(order: int) -> int:
    if type(order) is not int or order not in (1, 2, 3):
        raise FmuError(f"derivative of order {order!r}: allowed are 1, 2 and, of inputs, 3")
    return order
