"""Formulas over the values of a run, such as `spring.stiffness = 79e9 * wire^4 / (8 * coil^3 * turns)`.

A formula is parsed once into a tree of Python's grammar. Only the nodes listed here are allowed, so that a
formula of a file can compute and nothing else. Values are arrays: one call computes the formula for all runs.
No library has both names with points (`cam1.friction`) and arrays: numexpr has no points, asteval runs whole
programs."""

import ast
import operator
import re
from collections.abc import Callable, Mapping
from functools import cache, reduce
from typing import Any

import numpy as np

from dualcam.common.mistakes import StudyError
from dualcam.fmi.reals import Array

LONGEST = 1000  # characters; a longer text is no formula of a person
DEEPEST = 60  # levels of brackets
CONSTANTS = {"pi": np.pi}
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "log10": np.log10,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "hypot": np.hypot,
    "abs": np.abs,
    "sign": np.sign,
    "floor": np.floor,
    "ceil": np.ceil,
    "round": np.round,
    "min": lambda *values: reduce(np.minimum, values),
    "max": lambda *values: reduce(np.maximum, values),
    "where": np.where,
}
ARGUMENTS = {"atan2": (2, 2), "hypot": (2, 2), "min": (2, 20), "max": (2, 20), "where": (3, 3)}
BINARY: dict[type[ast.operator], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: np.true_divide,
    ast.Mod: np.mod,
    ast.FloorDiv: np.floor_divide,
    ast.Pow: np.float_power,
}
UNARY: dict[type[ast.unaryop], Callable[..., Any]] = {
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Not: np.logical_not,
}
COMPARISON: dict[type[ast.cmpop], Callable[..., Any]] = {
    ast.Lt: np.less,
    ast.LtE: np.less_equal,
    ast.Gt: np.greater,
    ast.GtE: np.greater_equal,
    ast.Eq: np.equal,
    ast.NotEq: np.not_equal,
}
BARE = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*")
TIMED = rf"{BARE.pattern}@(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
# Names that Python's grammar does not have, such as `x[1]` and theta@0.2; texts in apostrophes stay.
PARTS = re.compile(rf"`(?P<quoted>[^`]*)`|'[^']*'|(?P<timed>{TIMED})")


class Formula:
    """A formula of a text, with the `names` of the values in it, each once. StudyError, which says where and
    what is allowed, for a text that is no formula.

    `^` and `**` are powers. Names are those of values, with their points, and of results at a time, such as
    `theta@0.2`; a name with other characters stands in backquotes. Texts in apostrophes are quantities with a
    unit, such as `'79 GPa'`, in the base unit of the SI. Functions: the keys of FUNCTIONS. Comparisons,
    `and`, `or`, `not` give true and false.

    Examples
    --------
    >>> from dualcam.scenario.formula import Formula
    >>> stiffness = Formula("'79 GPa' * wire^4 / (8 * coil^3 * turns)")
    >>> stiffness.names
    ('wire', 'coil', 'turns')
    >>> float(stiffness({"wire": 0.002, "coil": 0.02, "turns": 8.0})).__round__(3)  # N/m
    2468.75
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._quoted: dict[str, str] = {}
        found: dict[str, None] = {}
        self._tree = self._parsed()
        self._check(self._tree, found, 0)
        self.names = tuple(found)

    def __repr__(self) -> str:
        return f"Formula({self.text!r})"

    def __call__(self, values: Mapping[str, Any]) -> Any:  # noqa: ANN401
        """The formula's value for numbers or arrays by name, at least those of `names`: NaN or infinite where
        the formula is not defined."""
        with np.errstate(all="ignore"):
            return self._value(self._tree, values)

    def truth(self, values: Mapping[str, Any], count: int) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Whether a comparison holds, for each of `count` runs; not where a value is NaN."""
        found = self(values)
        return np.broadcast_to(np.asarray(found == True), (count,))  # noqa: E712  NaN is not True

    def numbers(self, values: Mapping[str, Any], count: int) -> Array:
        """The formula's values as an array of shape (count,)."""
        return np.array(np.broadcast_to(np.asarray(self(values), float), (count,)))

    # ---- the text ----

    def _parsed(self) -> ast.expr:
        if not isinstance(self.text, str) or len(self.text) > LONGEST:
            raise StudyError(f"allowed is a formula of at most {LONGEST} characters")

        def stand_in(match: re.Match[str]) -> str:
            if match.lastgroup is None:
                return match[0]
            name = f"quoted{len(self._quoted)}_"
            self._quoted[name] = match[match.lastgroup]
            return name

        plain = PARTS.sub(stand_in, self.text).replace("^", "**").strip()
        try:
            return ast.parse(plain, mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            place = getattr(error, "offset", None)
            where = f", at character {place}" if place else ""
            raise StudyError(
                f"{self.text!r} is no formula{where}: {getattr(error, 'msg', error)}: allowed are numbers, "
                "names, + - * / ^ ( ), comparisons and functions such as sqrt(x)"
            ) from None

    def _check(self, node: ast.AST, found: dict[str, None], depth: int) -> None:
        """StudyError for anything but the nodes that are allowed; notes the names."""
        if depth > DEEPEST:
            raise StudyError(f"{self.text!r}: allowed are up to {DEEPEST} levels of brackets")
        for child in self._children(node, found):
            self._check(child, found, depth + 1)

    def _children(self, node: ast.AST, found: dict[str, None]) -> list[ast.expr]:
        match node:
            case ast.Constant(value=bool() | int() | float()):
                return []
            case ast.Constant(value=str() as text):
                _in_si(text)
                return []
            case ast.Name() | ast.Attribute():
                if (name := self._name(node)) is not None:
                    if name not in CONSTANTS:
                        found.setdefault(name)
                    return []
            case ast.UnaryOp(op=op, operand=operand) if type(op) in UNARY:
                return [operand]
            case ast.BinOp(left=left, op=op, right=right) if type(op) in BINARY:
                return [left, right]
            case ast.BoolOp(values=values):
                return list(values)
            case ast.Compare(left=left, ops=ops, comparators=others) if {type(o) for o in ops} <= set(
                COMPARISON
            ):
                return [left, *others]
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
                low, high = ARGUMENTS.get(name, (1, 1))
                if not low <= len(arguments) <= high:
                    number = str(low) if low == high else f"{low} to {high}"
                    raise StudyError(f"{self.text!r}: {name} has {len(arguments)} values: allowed: {number}")
                return list(arguments)
            case ast.Call(func=ast.Name(id=name)):
                raise StudyError(
                    f"{self.text!r}: {name} is no function of formulas: allowed are {', '.join(FUNCTIONS)}"
                )
        shown = ast.unparse(node) if isinstance(node, ast.expr) else type(node).__name__
        raise StudyError(
            f"{self.text!r}: {shown!r} is not allowed: allowed are numbers, names, + - * / ^ ( ), "
            "comparisons, and, or, not, and functions such as sqrt(x)"
        )

    def _name(self, node: ast.AST) -> str | None:
        """The name with its points; None for other attributes, such as those of numbers."""
        if isinstance(node, ast.Name):
            return self._quoted.get(node.id, node.id)
        if isinstance(node, ast.Attribute) and (before := self._name(node.value)) is not None:
            return f"{before}.{node.attr}"
        return None

    # ---- the value ----

    def _value(self, node: ast.AST, values: Mapping[str, Any]) -> Any:  # noqa: ANN401
        match node:
            case ast.Constant(value=str() as text):
                return _in_si(text)
            case ast.Constant(value=value):
                return float(value)  # type: ignore[arg-type]
            case ast.Name() | ast.Attribute():
                name = self._name(node)
                assert name is not None
                return values[name] if name in values else CONSTANTS[name]
            case ast.UnaryOp(op=op, operand=operand):
                return UNARY[type(op)](self._value(operand, values))
            case ast.BinOp(left=left, op=op, right=right):
                return BINARY[type(op)](self._value(left, values), self._value(right, values))
            case ast.BoolOp(op=op, values=parts):
                both = np.logical_and if isinstance(op, ast.And) else np.logical_or
                return reduce(both, [self._value(part, values) for part in parts])
            case ast.Compare(left=left, ops=ops, comparators=others):
                sides = [self._value(each, values) for each in (left, *others)]
                pairs = zip(ops, sides, sides[1:], strict=False)
                return reduce(np.logical_and, [COMPARISON[type(op)](a, b) for op, a, b in pairs])
            case ast.Call(func=ast.Name(id=name), args=arguments):
                return FUNCTIONS[name](*(self._value(each, values) for each in arguments))
        raise AssertionError(node)


@cache
def formula(text: str) -> Formula:
    """The Formula of a text, parsed once."""
    return Formula(text)


def is_formula(text: object) -> bool:
    """Whether a text can be read as a formula: a number with a unit, such as "8 N.m", cannot."""
    if not isinstance(text, str):
        return False
    try:
        formula(text)
    except StudyError:
        return False
    return True


@cache
def _in_si(text: str) -> float:
    """The number of a quantity such as "79 GPa" in the base unit of the SI."""
    from dualcam.common.written_units import si_number
    from dualcam.errors import DesignError

    try:
        return si_number(text)
    except DesignError as error:
        raise StudyError(f"'{text}' in a formula: {error}") from None
