"""Decisions of the C code, and a mark for each way through them.

A decision is what an `if`, a loop or `?:` asks, or an expression of && and || elsewhere. Its conditions are
the operands that hold no &&, || or ! themselves. Each evaluation marks one byte of a file that all processes
share. The byte's place is a number with one digit of base 3 for each condition: 0 not evaluated, 1 false,
2 true. A condition that can have one value only has no branches of its own (values_of()).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

from tree_sitter import Node

from verification.strength.sites import below, field, function_name, is_condition, is_constant, parse, plain

SEEN = "DUALCAM_BRANCHES"
HEADER = "platform/branch_marks.h"
SKIPPED, FALSE, TRUE = 0, 1, 2
REFUSAL = re.compile(r"(\w+_)?refuse(_\w+)?")  # functions that log a message and return false
CONSTANT = re.compile(r"[A-Z][A-Z0-9_]*")

HEADER_TEXT = """\
#ifndef DUALCAM_BRANCH_MARKS_H
#define DUALCAM_BRANCH_MARKS_H
#pragma clang diagnostic ignored "-Weverything"
#ifdef __linux__
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>
__attribute__((weak, visibility("hidden"))) unsigned char branch_nowhere[%(size)d];
__attribute__((weak, visibility("hidden"))) unsigned char *branch_seen = branch_nowhere;
#define BRANCH_MARK(place) (branch_seen[place] = 1)
#else /* the tests of other platforms compile, and show nothing */
#define BRANCH_MARK(place) ((void)(place))
#endif
static inline int branch_condition(unsigned *way, unsigned digit, int value) {
    *way += digit * (value ? 2u : 1u);
    return value;
}
static inline int branch_decision(unsigned place, int value) {
    BRANCH_MARK(place);
    return value;
}
#ifdef __linux__
__attribute__((constructor)) static void branch_share(void) {
    const char *const path = getenv("DUALCAM_BRANCHES");
    const int file = path == NULL || branch_seen != branch_nowhere ? -1 : open(path, O_RDWR);
    if (file < 0) return;
    void *const bytes = mmap(NULL, %(size)d, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (bytes != MAP_FAILED) branch_seen = bytes;
    close(file);
}
#endif
#endif
"""


@dataclass(frozen=True)
class Decision:
    """`outcome` gives the value of the decision from the digits of its conditions."""

    file: str
    function: str
    line: int
    text: str
    conditions: tuple[str, ...]
    values: tuple[tuple[int, ...], ...]  # of each condition, FALSE or TRUE
    place: int  # of its first byte
    outcome: Callable[[Sequence[int]], int]

    @property
    def size(self) -> int:
        return 3 ** len(self.conditions)

    def ways(self, marks: bytes) -> list[tuple[int, ...]]:
        """The digits of all evaluations that happened."""
        happened = [way for way in range(self.size) if marks[self.place + way]]
        return [tuple(way // 3**k % 3 for k in range(len(self.conditions))) for way in happened]

    def branches(self, marks: bytes) -> list[tuple[str, bool, bool]]:
        """Each condition, each of its values, and whether an evaluation had this value."""
        ways = self.ways(marks)
        return [
            (text, value == TRUE, any(way[k] == value for way in ways))
            for k, text in enumerate(self.conditions)
            for value in self.values[k]
        ]

    def independent(self, marks: bytes) -> list[tuple[str, bool]]:
        """Each condition, and whether two evaluations show that it alone changes the outcome (MC/DC with
        conditions that are not evaluated)."""
        ways = self.ways(marks)
        return [
            (text, any(self.shows(k, one, other) for one, other in combinations(ways, 2)))
            for k, text in enumerate(self.conditions)
            if len(self.values[k]) == 2
        ]

    def shows(self, k: int, one: Sequence[int], other: Sequence[int]) -> bool:
        if {one[k], other[k]} != {FALSE, TRUE} or self.outcome(one) == self.outcome(other):
            return False
        return all(
            a == b or SKIPPED in (a, b) for n, (a, b) in enumerate(zip(one, other, strict=True)) if n != k
        )


# ---- the parts of a decision ----


def inner(node: Node) -> Node:
    """Without parentheses around."""
    while node.type == "parenthesized_expression":
        node = node.named_children[0]
    return node


def operator_of(node: Node) -> str:
    return plain(field(node, "operator")) if node.type in ("binary_expression", "unary_expression") else ""


def is_logical(node: Node) -> bool:
    return operator_of(node) in ("&&", "||")


def conditions_of(node: Node) -> Iterator[Node]:
    node = inner(node)
    if is_logical(node):
        for name in ("left", "right"):
            if (part := field(node, name)) is not None:
                yield from conditions_of(part)
    elif operator_of(node) == "!" and (part := field(node, "argument")) is not None:
        yield from conditions_of(part)
    else:
        yield node


def values_of(condition: Node) -> tuple[int, ...]:
    """What it can be: a refusal is always false, a name in capitals is a constant of the compiler."""
    if condition.type == "call_expression" and REFUSAL.fullmatch(plain(field(condition, "function"))):
        return (FALSE,)
    return () if CONSTANT.fullmatch(plain(condition)) else (FALSE, TRUE)


def outcome_of(node: Node, number: Iterator[int]) -> Callable[[Sequence[int]], int]:
    """How the digits of the conditions make the outcome."""
    node = inner(node)
    if operator_of(node) == "!":
        part = outcome_of(field(node, "argument") or node, number)
        return lambda way: {SKIPPED: SKIPPED, FALSE: TRUE, TRUE: FALSE}[part(way)]
    if not is_logical(node):
        k = next(number)
        return lambda way: way[k]
    left = outcome_of(field(node, "left") or node, number)
    right = outcome_of(field(node, "right") or node, number)
    decides = FALSE if operator_of(node) == "&&" else TRUE
    return lambda way: decides if left(way) == decides else right(way)


def is_decision(node: Node) -> bool:
    """The outermost expression of a decision."""
    if is_condition(node):
        return True
    if not is_logical(node):
        return False
    above = node.parent
    while above is not None and (above.type == "parenthesized_expression" or operator_of(above) == "!"):
        if is_condition(above):
            return False
        above = above.parent
    return above is None or not is_logical(above)


# ---- a file with marks ----


@dataclass
class Marked:
    """A file being changed: `edits` are texts that come before a byte."""

    decisions: list[Decision]
    edits: list[tuple[int, int, str]]
    place: int

    def insert(self, before: int, depth: int, text: str) -> None:
        self.edits.append((before, depth, text))


def mark(node: Node, file: str, function: str, out: Marked) -> None:
    """The decision `node`, whose text stays where it is, between the marks."""
    parts = list(conditions_of(node))
    texts = tuple(plain(part) for part in parts)
    line = node.start_point[0] + 1
    outcome = outcome_of(node, iter(range(len(parts))))
    values = tuple(values_of(part) for part in parts)
    made = Decision(file, function, line, plain(node), texts, values, out.place, outcome)
    out.decisions.append(made)
    size = node.end_byte - node.start_byte
    out.insert(node.start_byte, -size, "(({ unsigned branch_way = 0; const int branch_value = !!(")
    out.insert(node.end_byte, size, f"); branch_decision({made.place}u + branch_way, branch_value); }}))")
    for k, part in enumerate(parts):
        size = part.end_byte - part.start_byte
        out.insert(part.start_byte, 1 - size, f"branch_condition(&branch_way, {3**k}u, !!(")
        out.insert(part.end_byte, size - 1, "))")
    out.place += made.size


def marked(path: Path, file: str, place: int) -> tuple[bytes, list[Decision], int]:
    """The file with marks, its decisions, and the first byte behind their places."""
    text, out = path.read_bytes(), Marked([], [], place)
    for definition in below(parse(text)):
        body = field(definition, "body")
        if definition.type != "function_definition" or body is None or definition.has_error:
            continue
        for node in below(body, is_constant):
            if is_decision(node):
                mark(node, file, function_name(definition), out)
    parts, position = [f'#include "{HEADER}"\n'.encode()], 0
    for before, _, inserted in sorted(out.edits, key=lambda edit: edit[:2]):
        parts += [text[position:before], inserted.encode()]
        position = before
    return b"".join([*parts, text[position:]]), out.decisions, out.place


def write(core: Path, files: Sequence[Path]) -> list[Decision]:
    """Puts the marks into these files below `core`, a copy of fmu_src."""
    decisions: list[Decision] = []
    place = 0
    for path in files:
        changed, found, place = marked(path, path.relative_to(core).as_posix(), place)
        if found:
            path.write_bytes(changed)
            decisions += found
    (core / HEADER).write_text(HEADER_TEXT % {"size": place})
    return decisions
