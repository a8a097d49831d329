"""The rooms of `dualcam`: what each may import, as the docstring of its `__init__` says, and no circles.

A room is a package whose docstring ends with "May import ...". Modules at the top, the face `dualcam` and
`dualcam.errors`, belong to no room: every room may import errors, and read names of the face.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from house import circle

MAY_IMPORT = re.compile(r"^May import ([\w., ]+?)\.$", re.MULTILINE)
NONE, ALL = "no other room", "every other room"


def imported(tree: ast.Module) -> Iterator[str]:
    """Full names of the modules that a Python file imports; a leading dot for a relative import.

    `from a import b` gives "a" and "a.b": b may be a module.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = "." * node.level + (node.module or "")
            yield start
            inside = f"{start}." if node.module else start
            yield from (inside + alias.name for alias in node.names)


def parse(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


def modules(root: Path) -> dict[str, Path]:
    """Files of the package by the full names of their modules."""
    files = sorted((root / "dualcam").rglob("*.py"))
    names = [".".join(path.relative_to(root).with_suffix("").parts) for path in files]
    return {name.removesuffix(".__init__"): path for name, path in zip(names, files, strict=True)}


def rooms(root: Path) -> dict[str, str]:
    """What each room may import, in words, by its name below `dualcam`."""
    found = {}
    for name, path in modules(root).items():
        if path.name == "__init__.py" and name != "dualcam":
            allowed = MAY_IMPORT.search(re.sub(r"(?<=,)\n", " ", ast.get_docstring(parse(path)) or ""))
            if allowed:
                found[name.removeprefix("dualcam.")] = allowed[1]
    return found


def may_import(root: Path) -> dict[str, set[str]]:
    """The rooms that each room may import."""
    said = rooms(root)
    return {
        room: set() if words == NONE else {*said} - {room} if words == ALL else set(words.split(", "))
        for room, words in said.items()
    }


def room_of(module: str, known: dict[str, set[str]]) -> str:
    """The innermost room of a module, "" for the modules at the top."""
    parts = module.split(".")[1:]
    inside = [".".join(parts[:k]) for k in range(len(parts), 0, -1)]
    return next((name for name in inside if name in known), "")


def arrows(root: Path) -> dict[str, set[str]]:
    """The modules that each module imports, wherever in its file, but for the face of the package."""
    known = modules(root)
    found = {}
    for name, path in known.items():
        wanted = [
            other for other in imported(parse(path)) if other in known and other not in (name, "dualcam")
        ]
        found[name] = {one for one in wanted if not any(other.startswith(f"{one}.") for other in wanted)}
    return {name: set() if name == "dualcam" else others for name, others in found.items()}


def check_python_rooms(root: Path) -> list[str]:
    """Packages without the words, rooms that do not exist, circles of rooms, and imports of other rooms."""
    allowed = may_import(root)
    return [
        *_without_words(root, allowed),
        *(
            f"dualcam/{room} may import {other}, which is no room"
            for room, others in allowed.items()
            for other in sorted(others - set(allowed))
        ),
        *(f"circle of rooms: {' -> '.join(found)}" for found in [circle(allowed)] if found),
        *_upwards(root, allowed),
    ]


def _without_words(root: Path, allowed: dict[str, set[str]]) -> Iterator[str]:
    for path in sorted((root / "dualcam").glob("*/__init__.py")):
        if path.parent.name not in allowed:
            yield f"{path.relative_to(root)} does not say what the room may import"


def _upwards(root: Path, allowed: dict[str, set[str]]) -> Iterator[str]:
    for name, others in arrows(root).items():
        room = room_of(name, allowed)
        for other in sorted(others):
            entered = room_of(other, allowed)
            if room and entered not in ("", room, *allowed[room]):
                yield f"{name} imports {other}: room {room} may not import room {entered}"


def check_python_circles(root: Path) -> list[str]:
    """Circles of modules, whether the imports stand at the top or inside functions."""
    found = circle(arrows(root))
    return [f"circle: {' -> '.join(found)}"] if found else []


CHECKS = {"python rooms": check_python_rooms, "python circles": check_python_circles}
