"""What differs between one number and an array, so that each formula of these blocks stands once.

A formula of + - * / serves one float and an array with one entry per instance alike. These functions do the
rest. One float goes through the functions of Python, which take a tenth of the time that NumPy takes for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from dualcam.design.statics import Array

Number = TypeVar("Number", float, Array)


def sine(angle: Number) -> Number:
    """The sine.

    Parameters
    ----------
    angle : float or ndarray
        Angle [rad].

    Returns
    -------
    float or ndarray
        Its sine.

    Examples
    --------
    >>> from dualcam.systems.blocks.elementwise import sine
    >>> sine(0.0)
    0.0
    """
    return np.sin(angle) if isinstance(angle, np.ndarray) else math.sin(angle)


def cosine(angle: Number) -> Number:
    """The cosine.

    Parameters
    ----------
    angle : float or ndarray
        Angle [rad].

    Returns
    -------
    float or ndarray
        Its cosine.

    Examples
    --------
    >>> from dualcam.systems.blocks.elementwise import cosine
    >>> cosine(0.0)
    1.0
    """
    return np.cos(angle) if isinstance(angle, np.ndarray) else math.cos(angle)


def extremes(kind: Number) -> tuple[Callable[..., Number], Callable[..., Number]]:
    """The functions min and max of two values.

    Parameters
    ----------
    kind : float or ndarray
        A value as they will get.

    Returns
    -------
    tuple of two callables
        min and max, of NumPy where `kind` is an array.

    Examples
    --------
    >>> from dualcam.systems.blocks.elementwise import extremes
    >>> least, most = extremes(1.0)
    >>> least(1.0, 2.0), most(1.0, 2.0)
    (1.0, 2.0)
    """
    return (np.minimum, np.maximum) if isinstance(kind, np.ndarray) else (min, max)


def limited(value: Number, lowest: Number | float, highest: Number | float) -> Number:
    """The value, cut at both limits.

    Parameters
    ----------
    value : float or ndarray
        The value.
    lowest, highest : float or ndarray
        The limits.

    Returns
    -------
    float or ndarray
        Of the shape of the value.

    Examples
    --------
    >>> from dualcam.systems.blocks.elementwise import limited
    >>> limited(3.0, -1.0, 2.0)
    2.0
    """
    least, most = extremes(value)
    return least(most(value, lowest), highest)
