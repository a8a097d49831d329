"""The structure that the source tree must have, as tables, and the checks that find where a tree differs.

Each check takes the root of a tree and returns one message per violation, which names the file.
tests/test_house.py runs every check on this repository and on small trees with one violation each.
"""

from __future__ import annotations

import ast
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
# The file of each room whose first comment says what the room is for, and from which rooms it may include.
MAIN_HEADER = {room: f"{room}/{room}.h" for room in MAY_INCLUDE if room != "tools"} | {
    "numerics": "numerics/root.h",
    "model": "model/params.h",
    "geometry": "geometry/transmission.h",
    "closed_form": "closed_form/linear_slip.h",
    "collocation": "collocation/event_location.h",
    "forward": "forward/state.h",
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
# Words that the field's terms have replaced, in names of files and in C identifiers.
ABANDONED = (
    *("leap", "glide", "passage", "walk", "stride", "launch", "launchpad", "knob", "bearing", "burden"),
    *("survey", "course", "twist"),
)
WITHOUT_SYS_PATH = ("dualcam", "system_examples", "case_studies", "benchmarks", "tests")
PYTHON = (*WITHOUT_SYS_PATH, "fmu_src")
TESTS_OF_BENCHMARKS = tuple(
    f"test_{name}.py"
    for name in (
        "benchmark_harness",
        "benchmark_layout",
        "benchmarks",
        "coupling",
        "own_plant",
        "performance",
        "stick_slip",
    )
)
EXAMPLES = "system_examples"

INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
COMMENT_OR_TEXT = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.DOTALL)

Graph = Mapping[str, Iterable[str]]


def source_files(root: Path) -> list[Path]:
    """C files of fmu_src."""
    return sorted(path for path in (root / "fmu_src").rglob("*.[ch]") if path.is_file())


def python_files(root: Path) -> list[Path]:
    """Python files of the folders PYTHON."""
    return sorted(path for folder in PYTHON for path in (root / folder).rglob("*.py"))


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


def first_comment(text: str) -> str:
    """The C comment at the very start of a text, without its marks; "" if the text starts with code."""
    match = re.match(r"\s*/\*(.*?)\*/", text, re.DOTALL)
    return " ".join(match[1].replace("*", " ").split()) if match else ""


def to_name(room: str, comment: str) -> list[str]:
    """Rooms that a comment on the includes of a room must name: the rooms that may be included, or, after the
    words "every room below", the exceptions."""
    allowed = MAY_INCLUDE[room]
    if "every room below" not in comment:
        return list(allowed)
    rooms = list(MAY_INCLUDE)
    return [other for other in rooms[: rooms.index(room)] if other not in allowed]


def check_main_headers(root: Path) -> list[str]:
    """Main headers that are missing, or whose first comment does not describe the room."""
    found = []
    for room, name in MAIN_HEADER.items():
        path = root / "fmu_src" / name
        if not path.is_file():
            found.append(f"fmu_src/{name} is missing: the main header of room {room}")
            continue
        comment = first_comment(path.read_text(encoding="utf-8"))
        if len(comment.split()) < 8:
            found.append(f"fmu_src/{name} does not start with a comment that says what room {room} is for")
        missing = [other for other in to_name(room, comment) if not re.search(rf"\b{other}\b", comment)]
        if missing:
            found.append(
                f"fmu_src/{name}: the first comment, on what may be included, lacks {', '.join(missing)}"
            )
    return found


# ---- words and lengths ----


def words_of(identifier: str) -> list[str]:
    """Lower-case words of a snake_case, CamelCase or UPPER_CASE identifier."""
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", identifier)]


def is_abandoned(identifier: str) -> bool:
    """Is a word of the identifier, or the singular of one, abandoned?"""
    return any(word in ABANDONED or word.removesuffix("s") in ABANDONED for word in words_of(identifier))


def check_words(root: Path) -> list[str]:
    """Abandoned words in names of files and in identifiers of C files."""
    found = []
    for path in sorted((root / "fmu_src").rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts and is_abandoned(path.stem):
            found.append(f"{path.relative_to(root)}: abandoned word in the file's name")
    for path in [*source_files(root), *(root / "fmu_src").glob("*.def")]:
        code = COMMENT_OR_TEXT.sub(" ", path.read_text(encoding="utf-8"))
        identifiers = sorted({name for name in re.findall(r"[A-Za-z_]\w*", code) if is_abandoned(name)})
        if identifiers:
            found.append(f"{path.relative_to(root)}: abandoned words in {', '.join(identifiers)}")
    return found


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


# ---- Python ----


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


def names_sys_path(node: ast.AST) -> bool:
    if isinstance(node, ast.Attribute):
        return node.attr == "path" and isinstance(node.value, ast.Name) and node.value.id == "sys"
    return (
        isinstance(node, ast.ImportFrom) and node.module == "sys" and "path" in [a.name for a in node.names]
    )


def check_sys_path(root: Path) -> list[str]:
    """Python files that read or change sys.path."""
    return [
        f"{path.relative_to(root)} uses sys.path"
        for path in python_files(root)
        if path.relative_to(root).parts[0] in WITHOUT_SYS_PATH
        and any(map(names_sys_path, ast.walk(parse(path))))
    ]


def entries(folder: Path) -> set[str]:
    """Names under which files and folders of `folder` can be imported if `folder` is on the module path."""
    if not folder.is_dir():
        return set()
    holds_python = (path for path in folder.iterdir() if path.is_dir() and any(path.rglob("*.py")))
    return {path.stem for path in folder.glob("*.py")} | {path.name for path in holds_python} - {
        "__pycache__"
    }


def check_benchmarks_apart(root: Path) -> list[str]:
    """Files outside benchmarks that import benchmarks; the tests of benchmarks and the verification may.

    A name without "benchmarks." counts as a module of benchmarks unless a file elsewhere has the same name.
    """
    inside = [root / "benchmarks", root / "tests" / "verification"]
    outside = [path for path in python_files(root) if not any(map(path.is_relative_to, inside))]
    modules = entries(root / "benchmarks") - {path.stem for path in outside} | {"benchmarks"}
    found = []
    for path in outside:
        if path.name not in TESTS_OF_BENCHMARKS:
            seen = {first: name for name in imported(parse(path)) if (first := name.split(".")[0]) in modules}
            found += [
                f"{path.relative_to(root)} imports {name}, part of benchmarks" for name in seen.values()
            ]
    return found


def check_examples_apart(root: Path) -> list[str]:
    """Examples that import one another. An example is a file or a folder of system_examples."""
    found, folder = [], root / EXAMPLES
    names = entries(folder)
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(folder).parts
        others = names - {Path(parts[0]).stem}
        inner = entries(path.parent) if len(parts) > 1 else set()
        seen = {}
        for name in imported(parse(path)):
            level = len(name) - len(name.lstrip("."))
            first, *rest = name.lstrip(".").split(".")
            if first == EXAMPLES and rest:
                first = rest[0]
            elif first in inner or level not in (0, len(parts)):  # within the example's own folder
                continue
            if first in others:
                seen[first] = name
        found += [f"{path.relative_to(root)} imports {name}, another example" for name in seen.values()]
    return found


CHECKS: dict[str, Callable[[Path], list[str]]] = {
    "rooms": check_rooms,
    "includes": check_includes,
    "circles": check_circles,
    "room sizes": check_room_sizes,
    "main headers": check_main_headers,
    "words": check_words,
    "lengths": check_lengths,
    "loops": check_loops,
    "sys.path": check_sys_path,
    "benchmarks apart": check_benchmarks_apart,
    "examples apart": check_examples_apart,
}
