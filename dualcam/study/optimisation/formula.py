"""Formulas over results and varied values, such as `energy.heat_cam1 + energy.heat_cam2`."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import CodeType
from typing import Any

import numpy as np

from dualcam.reals import Array
from dualcam.study.problem import StudyError

NAME = r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*|\[\d+\])*(?:@\d+\.?\d*(?:[eE][+-]?\d+)?)?"
NUMBER = r"(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
TOKEN = re.compile(rf"`(?P<quoted>[^`]+)`|(?P<number>{NUMBER})|(?P<name>{NAME})")
FUNCTIONS: dict[str, Any] = {
    "abs": np.abs,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "atan": np.arctan,
    "min": lambda *values: np.minimum.reduce(np.broadcast_arrays(*values)),
    "max": lambda *values: np.maximum.reduce(np.broadcast_arrays(*values)),
}
NODES = (
    ast.Expression, ast.BinOp, ast.UnaryOp, ast.Call, ast.Name, ast.Constant, ast.Load,
    ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.USub, ast.UAdd,
)  # fmt: skip
ALLOWED = f"allowed are names, numbers, + - * / ^ ( ), pi, and {', '.join(FUNCTIONS)}"


@dataclass(frozen=True)
class Formula:
    """A formula whose names are results or varied variables.

    Parameters
    ----------
    text : str
        Such as `2 * theta@0.2 + sqrt(cam1.radius)`. A name that a formula could misread stands between
        backticks.

    Raises
    ------
    StudyError
        The text is no formula.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.study.optimisation import Formula
    >>> heat = Formula("energy.heat_cam1 + 2 * theta@0.2")
    >>> heat.names
    ('energy.heat_cam1', 'theta@0.2')
    >>> heat.value({"energy.heat_cam1": np.array([1.0, 2.0]), "theta@0.2": np.array([0.5, 0.5])}).tolist()
    [2.0, 3.0]
    """

    text: str
    names: tuple[str, ...] = field(init=False)
    _code: CodeType = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        names: list[str] = []

        def placeholder(match: re.Match[str]) -> str:
            name = match["quoted"] or match["name"]
            if name is None or (not match["quoted"] and (name in FUNCTIONS or name == "pi")):
                return match[0]
            if name not in names:
                names.append(name)
            return f"_{names.index(name)}"

        text = TOKEN.sub(placeholder, self.text).replace("^", "**").strip()
        try:
            tree = ast.parse(text, mode="eval")
        except (SyntaxError, ValueError):
            raise StudyError(f"{self.text!r} is no formula: {ALLOWED}") from None
        for node in ast.walk(tree):
            _check(node, self.text)
        object.__setattr__(self, "names", tuple(names))
        object.__setattr__(self, "_code", compile(tree, "<formula>", "eval"))

    def value(self, values: Mapping[str, Array]) -> Array:
        """The formula's value.

        Parameters
        ----------
        values : mapping of str to ndarray
            Values of all `names`, arrays of one shape.

        Returns
        -------
        ndarray
            Of that shape; NaN or infinite where the formula has no value.
        """
        known = {f"_{k}": np.asarray(values[name], float) for k, name in enumerate(self.names)}
        with np.errstate(all="ignore"):
            return np.asarray(eval(self._code, {"__builtins__": {}, "pi": np.pi, **FUNCTIONS}, known), float)


def _check(node: ast.AST, text: str) -> None:
    """StudyError for what no formula has."""
    fit = isinstance(node, NODES)
    if isinstance(node, ast.Constant):
        fit = isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.Call):
        fit = isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS and not node.keywords
    if not fit:
        raise StudyError(f"{text!r} is no formula: {ALLOWED}")
