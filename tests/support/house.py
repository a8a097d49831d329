"""The structure that the source tree must have, as tables, and the checks that find where a tree differs.

Each check takes the root of a tree and returns one message per violation, which names the file.
tests/test_house.py runs every check on this repository and on small trees with one violation each.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

# The rooms below forward and inverse dynamics.
BELOW_DYNAMICS = (
    *("platform", "elementary", "numerics", "model", "geometry", "contact"),
    *("closed_form", "collocation"),
)
# Rooms of fmu_src, bottom up, and the rooms from which each one may include besides itself.
MAY_INCLUDE: dict[str, tuple[str, ...]] = {
    "platform": (),
    "elementary": ("platform",),
    "numerics": ("platform", "elementary"),
    "model": ("platform", "elementary", "numerics"),
    "geometry": ("platform", "elementary", "numerics", "model"),
    "contact": ("platform", "elementary", "numerics", "model", "geometry"),
    "closed_form": ("elementary", "numerics", "model", "contact"),
    "collocation": ("platform", "elementary", "numerics", "model", "geometry", "contact"),
    "forward": BELOW_DYNAMICS,
    "inverse": BELOW_DYNAMICS,
    "outputs": (*BELOW_DYNAMICS, "forward"),
    "sensitivity": (*BELOW_DYNAMICS, "forward", "inverse", "outputs"),
    "fmi": (*BELOW_DYNAMICS, "forward", "inverse", "outputs", "sensitivity"),
    "web": (),
    "tools": ("fmi",),
}
# Files that an #include names without a room: the list of variables, the standards' headers, and the header
# that the archive of an FMU adds to its sources.
WITHOUT_ROOM = (
    *("variables.def", "dependencies.def", "unit_guards.def", "identity.h"),
    *("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi3Functions.h"),
)
# A loop that counts to a limit, and the words that give the bound of another loop.
COUNTED = re.compile(
    r"for \((?:[\w ]+ )?(\w+) = [^;]*; (?:[^;]*\b)?\1 (?:<|<=|>|>=) [^;]*; "
    r"(?:\1\+\+|\1--|\1 [+-]= \d+|\1\+\+, .*)\)"
)
BOUND = re.compile(r"[Aa]t most (?:.* turns\b|one turn per )")
WITHOUT_BOUNDS = ("tools", "web")  # rooms that no call of a native FMU enters
MOST_PAIRS = 16  # of one room; a pair is the .c and .h of one stem
MOST_LINES = {"tests": 800, "system_examples": 800, "case_studies": 800}
MOST_LINES_ELSEWHERE = 500

INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
COMMENT_OR_TEXT = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.DOTALL)

Graph = Mapping[str, Iterable[str]]


def source_files(root: Path) -> list[Path]:
    """C files of fmu_src."""
    return sorted(path for path in (root / "fmu_src").rglob("*.[ch]") if path.is_file())


def python_files(root: Path) -> list[Path]:
    folders = ("dualcam", "system_examples", "case_studies", "benchmarks", "tests", "fmu_src")
    return sorted(path for folder in folders for path in (root / folder).rglob("*.py"))


def includes(root: Path, path: Path) -> list[str]:
    """Operands of the `#include "..."` lines of a file, in order; those in comments are left out."""
    text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    return INCLUDE.findall(text)


def room_of(root: Path, path: Path) -> str:
    """Name of the room of a C file, or "" outside any room."""
    parts = path.relative_to(root / "fmu_src").parts
    return parts[0] if len(parts) == 2 and parts[0] in MAY_INCLUDE else ""


def circle(graph: Graph) -> list[str]:
    """The nodes of one circle of a directed graph, the first one repeated at the end; [] without a circle."""
    state: dict[str, int] = {}  # 1: on the present path, 2: no circle from here
    path: list[str] = []

    def visit(node: str) -> list[str]:
        state[node] = 1
        path.append(node)
        for follower in sorted(graph.get(node, ())):
            if state.get(follower) == 1:
                return [*path[path.index(follower) :], follower]
            if follower not in state and (found := visit(follower)):
                return found
        state[node] = 2
        path.pop()
        return []

    for node in sorted(graph):
        if node not in state and (found := visit(node)):
            return found
    return []


# ---- rooms of fmu_src ----


def check_rooms(root: Path) -> list[str]:
    """C files outside the rooms, and rooms without files."""
    found = [
        f"{path.relative_to(root)} is in no room" for path in source_files(root) if not room_of(root, path)
    ]
    used = {room_of(root, path) for path in source_files(root)}
    return found + [f"fmu_src/{room} has no C file" for room in MAY_INCLUDE if room not in used]


def check_includes(root: Path) -> list[str]:
    """Includes that name no room, no file, or a room from which the including room may not include."""
    found = []
    for path in source_files(root):
        room = room_of(root, path)
        for name in includes(root, path):
            line = f'{path.relative_to(root)} includes "{name}"'
            if name in WITHOUT_ROOM:
                continue
            target = name.split("/")[0]
            if "/" not in name or target not in MAY_INCLUDE:
                found.append(f"{line}, which names no room")
            elif not (root / "fmu_src" / name).is_file():
                found.append(f"{line}, which does not exist")
            elif room and target != room and target not in MAY_INCLUDE[room]:
                found.append(f"{line}: room {room} may not include room {target}")
    return found


def check_circles(root: Path) -> list[str]:
    """One circle between rooms, one between pairs. A pair depends on the pairs whose headers it includes."""
    rooms, pairs = defaultdict(set), defaultdict(set)
    for path in source_files(root):
        pair = str(path.relative_to(root / "fmu_src").with_suffix(""))
        for name in includes(root, path):
            if "/" not in name:
                continue
            other = str(Path(name).with_suffix(""))
            if other != pair:
                pairs[pair].add(other)
            if room_of(root, path) != name.split("/")[0]:
                rooms[room_of(root, path)].add(name.split("/")[0])
    return [f"circle: {' -> '.join(nodes)}" for nodes in (circle(rooms), circle(pairs)) if nodes]


def check_room_sizes(root: Path) -> list[str]:
    """Rooms of too many pairs."""
    pairs = defaultdict(set)
    for path in source_files(root):
        pairs[room_of(root, path)].add(path.stem)
    return [
        f"fmu_src/{room} has {len(stems)} pairs of files, more than {MOST_PAIRS}"
        for room, stems in sorted(pairs.items())
        if room and len(stems) > MOST_PAIRS
    ]


# ---- lengths and loops ----


def check_lengths(root: Path) -> list[str]:
    """C and Python files of too many lines."""
    found = []
    folders = [root / name for name in ("benchmarks", "dualcam", "tests")]
    c_files = [path for folder in folders for path in folder.rglob("*.[ch]")]
    for path in [*source_files(root), *sorted(c_files), *python_files(root)]:
        most = MOST_LINES.get(path.relative_to(root).parts[0], MOST_LINES_ELSEWHERE)
        lines = len(path.read_text(encoding="utf-8").splitlines())
        if lines > most:
            found.append(f"{path.relative_to(root)} has {lines} lines, more than {most}")
    return found


def loops(text: str) -> Iterator[tuple[int, str]]:
    """Line, from 1, and head of each loop in C code."""
    lines = text.splitlines()
    for number, line in enumerate(lines, start=1):
        begun = re.search(r"\b(?:for|while) \(|\bdo \{", re.sub(r"/\*.*", "", line))
        if begun is None or line.lstrip().startswith("*"):
            continue
        head = line[begun.start() :]
        for more in lines[number:]:
            if head.count("(") <= head.count(")"):
                break
            head += " " + more.strip()
        yield number, head


def check_loops(root: Path) -> list[str]:
    """Loops of the FMUs that neither count to a limit nor say their bound: a comment "at most ... turns", or
    "at most one turn per ...", beside the loop or in the line above."""
    found = []
    for path in source_files(root):
        if room_of(root, path) in WITHOUT_BOUNDS:
            continue
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines()
        for number, head in loops(text):
            ends_do = re.match(r"\s*\} while", lines[number - 1]) is not None
            said = any(BOUND.search(line) for line in lines[max(number - 2, 0) : number])
            if not (ends_do or said or COUNTED.match(head)):
                found.append(f"{path.relative_to(root)}:{number}: a loop without a bound: {head}")
    return found


CHECKS: dict[str, Callable[[Path], list[str]]] = {
    "rooms": check_rooms,
    "includes": check_includes,
    "circles": check_circles,
    "room sizes": check_room_sizes,
    "lengths": check_lengths,
    "loops": check_loops,
}
