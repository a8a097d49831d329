"""Places in a C file where a small mistake can be made, and the mistake.

tree-sitter parses the text. The text is not preprocessed: a macro stays a call, and definitions of macros are
left alone. A place is an expression or a statement in the body of a function, so that a switch can stand in
its place (switch.py).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import tree_sitter_c
from tree_sitter import Language, Node, Parser

# Words of platform/attributes.h and of the FMI headers: the grammar of C knows none of them.
ATTRIBUTES = re.compile(
    rb"\b(COLD|NOINLINE|COMPACT|ALWAYS_INLINE|COMPACT_BEGIN|COMPACT_END|FMI[23]_Export)\b"
    rb"|__attribute__\(\(format\([^)]*\)\)\)"
)
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*"}
COMPOUND = {"+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}
BOUNDARY = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
REVERSED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}
LOGICAL = {"&&": "||", "||": "&&"}
CONDITIONS = ("if_statement", "while_statement", "do_statement", "for_statement", "conditional_expression")
# Below these the compiler wants constants, or a switch would change types.
CONSTANTS_ONLY = (
    "ERROR",
    "array_declarator",
    "bitfield_clause",
    "enumerator",
    "preproc_def",
    "preproc_function_def",
    "sizeof_expression",
    "subscript_designator",
)
FACTOR = "1.5"  # by which a constant is multiplied


@dataclass(frozen=True)
class Site:
    """A place, and what stands there instead. `nth` counts equal mistakes within the function."""

    file: str  # within fmu_src
    function: str
    kind: str
    start: int  # bytes of the file
    end: int
    line: int
    original: str
    mutated: str
    nth: int
    statement: bool  # is a statement, not an expression
    text: str = ""  # the whole line at which the place begins

    @property
    def identity(self) -> tuple[str, str, str, str, str, str]:
        """The same as long as the function's text is the same, wherever its lines are."""
        return (self.file, self.function, self.kind, self.original, self.mutated, str(self.nth))


Signatures = Mapping[str, Sequence[str]]


def parse(text: bytes) -> Node:
    blank = ATTRIBUTES.sub(lambda found: b" " * len(found[0]), text)
    return Parser(Language(tree_sitter_c.language())).parse(blank).root_node


def below(node: Node, leave_out: Callable[[Node], bool] = lambda node: False) -> Iterator[Node]:
    """The node and all nodes below, in the order of the text, without those that are left out."""
    waiting = [node]
    while waiting:
        node = waiting.pop()
        if not leave_out(node):
            yield node
            waiting += reversed(node.children)


def plain(node: Node | None) -> str:
    return " ".join(node.text.decode().split()) if node is not None and node.text else ""


def field(node: Node, name: str) -> Node | None:
    return node.child_by_field_name(name)


# ---- types of arguments ----


def type_of(parameter: Node) -> str:
    """The type in words, without the name: `double`, `const Mechanism*`."""
    declarator = field(parameter, "declarator")
    words = [plain(child) for child in parameter.children if child != declarator]
    pointer = re.sub(r"[^*\[\]]", "", plain(declarator))
    return " ".join(words) + ("*" if "[" in pointer else pointer)


def signatures_of(root: Node) -> dict[str, list[str]]:
    """The types of the parameters of each function that is declared or defined here."""
    found = {}
    for node in below(root):
        if node.type == "function_declarator" and (parameters := field(node, "parameters")) is not None:
            named = [child for child in parameters.children if child.type == "parameter_declaration"]
            found[plain(field(node, "declarator"))] = [type_of(parameter) for parameter in named]
    return found


# ---- mistakes at one node: kind and text instead ----


def text_with(node: Node, part: Node, instead: str) -> str:
    """The text of `node` with another text for its part."""
    text, begin = node.text or b"", part.start_byte - node.start_byte
    return (text[:begin] + instead.encode() + text[begin + part.end_byte - part.start_byte :]).decode()


def swapped_operator(node: Node, table: Mapping[str, str]) -> str | None:
    operator = field(node, "operator")
    if operator is None or operator.type not in table:
        return None
    return text_with(node, operator, table[operator.type])


def other_number(text: str) -> Iterator[str]:
    if re.fullmatch(r"\d+[uU]?", text):
        yield f"({text} + 1)"
        if text.strip("uU") != "0":
            yield f"({text} - 1)"
    elif re.fullmatch(r"[\d.]+([eE][-+]?\d+)?", text):
        yield "1.0" if float(text) == 0.0 else f"({text} * {FACTOR})"


def operator_mistakes(node: Node) -> Iterator[tuple[str, str]]:
    tables = [("arithmetic", ARITHMETIC), ("comparison", BOUNDARY), ("comparison", REVERSED)]
    for kind, table in [*tables, ("logic", LOGICAL)]:
        if (text := swapped_operator(node, table)) is not None:
            yield kind, text


def swapped_arguments(node: Node, signatures: Signatures) -> Iterator[tuple[str, str]]:
    types = signatures.get(plain(field(node, "function")), [])
    listed = field(node, "arguments")
    arguments = listed.named_children if listed is not None else []
    if len(types) != len(arguments):
        return
    for k in range(len(types) - 1):
        first, second = plain(arguments[k]), plain(arguments[k + 1])
        if types[k] == types[k + 1] and first != second:
            yield "arguments", swapped(node, arguments[k], arguments[k + 1])


def swapped(node: Node, first: Node, second: Node) -> str:
    text, begin = node.text or b"", node.start_byte
    parts = [
        text[: first.start_byte - begin],
        second.text or b"",
        text[first.end_byte - begin : second.start_byte - begin],
        first.text or b"",
        text[second.end_byte - begin :],
    ]
    return b"".join(parts).decode()


def is_condition(node: Node) -> bool:
    parent = node.parent
    return parent is not None and parent.type in CONDITIONS and field(parent, "condition") == node


def expression_mistakes(node: Node, signatures: Signatures) -> Iterator[tuple[str, str]]:
    if node.type == "binary_expression":
        yield from operator_mistakes(node)
    elif node.type == "assignment_expression":
        if (text := swapped_operator(node, COMPOUND)) is not None:
            yield "sign" if plain(field(node, "operator")) in ("+=", "-=") else "arithmetic", text
    elif node.type == "unary_expression" and plain(field(node, "operator")) == "-":
        yield "sign", plain(field(node, "argument"))
    elif node.type == "number_literal":
        yield from (("constant", text) for text in other_number(plain(node)))
    elif node.type == "call_expression":
        yield from swapped_arguments(node, signatures)
    if is_condition(node):
        yield "condition", f"!({plain(node)})"


def is_deletable(node: Node) -> bool:
    """A statement for its effect, or one that leaves a function or a loop early."""
    if node.type == "expression_statement":
        return bool(node.named_children)
    early = node.type in ("return_statement", "break_statement", "continue_statement")
    return early and node.parent is not None and node.parent.type == "if_statement"


# ---- all places of a file ----


def function_name(definition: Node) -> str:
    for node in below(definition):
        if node.type == "function_declarator":
            return plain(field(node, "declarator"))
    return ""


def is_constant(node: Node) -> bool:
    """Must the compiler know the value: a static initializer, a case label, the size of an array?"""
    if node.type in CONSTANTS_ONLY:
        return True
    if node.type == "declaration":
        storage = [plain(child) for child in node.children if child.type == "storage_class_specifier"]
        return "static" in storage
    above = node.parent
    return above is not None and above.type == "case_statement" and node == field(above, "value")


def sites_of(path: Path, name: str, signatures: Signatures) -> list[Site]:
    """All places of a file, in the order of the text."""
    found: list[Site] = []
    lines = path.read_text().split("\n")
    counted: dict[tuple[str, ...], int] = {}

    def add(node: Node, function: str, kind: str, mutated: str, statement: bool) -> None:
        original, flat = plain(node), " ".join(mutated.split())
        key = (function, kind, original, flat)
        counted[key] = counted.get(key, 0) + 1
        place = (node.start_byte, node.end_byte, node.start_point[0] + 1)
        text = " ".join(lines[node.start_point[0]].split())
        found.append(Site(name, function, kind, *place, original, flat, counted[key], statement, text))

    for definition in below(parse(path.read_bytes())):
        body = field(definition, "body")
        if definition.type != "function_definition" or body is None or definition.has_error:
            continue
        function = function_name(definition)
        for node in below(body, is_constant):
            if is_deletable(node):
                add(node, function, "statement", "", True)
            for kind, mutated in expression_mistakes(node, signatures):
                add(node, function, kind, mutated, False)
    return found
