"""What is found in a design: errors and warnings with key, value, and the nearest value that works."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

ERROR, WARNING = "error", "warning"


@dataclass(frozen=True)
class Finding:
    """One finding about a design.

    Attributes
    ----------
    severity : "error": the design does not work. "warning": what could be meant otherwise.
    key : Key of the design file, such as `cam1.radius`; empty where no single key is concerned.
    value : Its value, a number, bool or text; None where there is none.
    text : A sentence with key, value, what is allowed, and what would work.
    nearest : The nearest value of `change` that works, in the unit of that key; None where none is known.
    change : The key that would get the value `nearest`; empty where `nearest` is None.
    line : Line of the design file, from 1.
    kind : What is checked, in a word or two.
    """

    severity: str
    key: str
    value: Any
    text: str
    nearest: Any = None
    change: str = ""
    line: int | None = None
    kind: str = ""

    def __str__(self) -> str:
        place = f"line {self.line}: " if self.line else ""
        return f"{place}{self.text}"

    def at_line(self, line: int | None) -> Finding:
        """The same finding with its line in the design file."""
        return replace(self, line=line)

    def as_dict(self) -> dict[str, Any]:
        """The finding as JSON has it."""
        fields = ("severity", "kind", "key", "value", "line", "text", "change", "nearest")
        return {name: getattr(self, name) for name in fields}
