"""Which function a standard allows in which state: tables, and the check of an FMU against them.

A table is states.csv in tests/fmi2 or tests/fmi3: a row for each function (and kind of variables), a column
for each state of an instance. The second line has the section of the standard on each state, column `section`
the section on each function. Braces stand for several functions: Get{Int8,Int16}. A cell is one of VERDICTS,
with a note of states_notes.csv behind it where the standard leaves room or the FMU is lenient.
"""

import csv
import itertools
import re
from collections.abc import Callable
from ctypes import Array, c_char_p, c_void_p
from dataclasses import dataclass
from pathlib import Path

from driver import DISCARD, ERROR, OK, Calls

# What the FMU answers to a call with valid arguments.
VERDICTS = {
    "allowed": OK,
    "lenient": OK,  # the standard does not allow the call; the note says why the FMU does
    "error": ERROR,
    "refused": ERROR,  # the standard allows the call to FMUs with a capability that this one lacks
    "discard": DISCARD,  # FMI 2.0: a status that the FMU cannot tell
}
NEED_A_NOTE = ("lenient", "refused", "discard")


@dataclass(frozen=True)
class Cell:
    function: str
    variables: str  # the kind of the variables that are read or set; "" for other functions
    state: str
    verdict: str
    note: str
    sections: tuple[str, str]  # of the state and of the function

    def __str__(self) -> str:
        of = f" ({self.variables})" if self.variables else ""
        return f"{self.function}{of} in {self.state}: {self.verdict} by {' and '.join(self.sections)}"


def _expanded(names: str) -> list[str]:
    parts = [part.split(",") for part in re.split(r"[{}]", names)]
    return ["".join(choice) for choice in itertools.product(*parts)]


class StateTable:
    """The tables in a folder."""

    def __init__(self, folder: Path) -> None:
        self.cells = _read_cells(folder / "states.csv")
        with (folder / "states_notes.csv").open(newline="", encoding="utf-8") as file:
            self.notes = {row["note"] for row in csv.DictReader(file)}
        self.states = list(dict.fromkeys(cell.state for cell in self.cells))
        self.functions = {cell.function for cell in self.cells}

    def of(self, state: str, without: set[str]) -> list[Cell]:
        """The cells of a state, without some functions."""
        return [cell for cell in self.cells if cell.state == state and cell.function not in without]

    def check_notes(self) -> None:
        """Each note is used, and each deviation from the standard has one. `error` holds in every state."""
        assert {cell.verdict for cell in self.cells} <= set(VERDICTS)
        assert {cell.note for cell in self.cells} - {""} == self.notes - {"error"}
        assert [str(cell) for cell in self.cells if cell.verdict in NEED_A_NOTE and not cell.note] == []


def _read_cells(path: Path) -> list[Cell]:
    with path.open(newline="", encoding="utf-8") as file:
        states, sections, *rows = csv.reader(file)
    cells = []
    for names, variables, section, *verdicts in rows:
        for function in _expanded(names):
            for state, place, text in zip(states[3:], sections[3:], verdicts, strict=True):
                verdict, _, note = text.partition(" ")
                cells.append(Cell(function, variables, state, verdict, note, (place, section)))
    return cells


# ---- variables of a kind ----


KINDS: dict[str, Callable] = {
    "input": lambda v: v.causality == "input",
    "output": lambda v: v.causality == "output",
    "no output": lambda v: v.causality != "output",
    "fixed parameter": lambda v: (v.causality, v.variability) == ("parameter", "fixed"),
    "tunable parameter": lambda v: (v.causality, v.variability) == ("parameter", "tunable"),
    "state": lambda v: v.causality == "output" and v.name in STATES,
    "calculated": lambda v: v.causality in ("output", "local", "independent") and v.name not in STATES,
    "": lambda v: True,
}
STATES = ("theta", "omega")


def names_of(fmu: Calls, kind: str, type_: str, asked_for: frozenset[str]) -> list[str]:
    """Variables of this kind and type. "... asked for": those that the master named at instantiation."""
    wanted, _, _ = kind.partition("not asked for")
    wanted, asked, _ = wanted.partition("asked for")
    names = [v.name for v in fmu.variables.values() if v.type == type_ and KINDS[wanted.strip()](v)]
    if "asked for" not in kind:
        return names
    return [name for name in names if (name in asked_for) == bool(asked)]


def new_value(v):
    """A value that may be set, other than the start value if only one other is always possible."""
    if v.type == "String":
        return ""
    if v.type == "Boolean":
        return False
    if v.type in ("Integer", "Int32"):
        return int(v.min) if v.variability == "tunable" else v.start or 1
    if v.causality == "input":
        return 0.25
    if v.variability == "tunable" and v.max > v.start:
        return v.start + 0.0625
    return v.start or 0.0


# ---- one state ----


class ValidArguments:
    """Arguments with which a call can only be refused for the state of the instance. `made` is an FMU state
    that a call uses or allocates. `saves`: can an FMU state be saved in this state of the instance?"""

    MAY_BE_NULL: frozenset[tuple[str, int]]  # function and number of the argument, from 0
    asked_for: frozenset[str] = frozenset()  # variables that the master sets or reads inside steps

    def __init__(self, fmu: Calls, saves: bool = True) -> None:
        self.fmu, self.saves, self.made = fmu, saves, c_void_p()

    def of(self, function: str) -> tuple:
        raise NotImplementedError

    def free_made(self) -> None:
        if self.made:
            self.fmu.free_state(self.made)


class StateCheck:
    """Makes the calls of a table in the present state of one instance, and lists each answer that differs.

    A refused call must have one message that names the function and the state (or the variable), and must
    leave the saved state as it was, bit for bit. After an allowed call the state is restored."""

    def __init__(self, words: tuple[str, ...], arguments: ValidArguments) -> None:
        """`words`: a message that refuses a call for the state has one of them."""
        self.fmu, self.words, self.arguments = arguments.fmu, words, arguments
        self.state = arguments.fmu.take() if arguments.saves else None
        self.before = self._bytes()
        self.wrong: list[str] = []

    def _bytes(self) -> bytes:
        return self.fmu.state_bytes() if self.state is not None else b""

    def _restore(self) -> None:
        if self.state is not None:
            self.fmu.restore(self.state)

    def close(self) -> None:
        if self.state is not None:
            self.fmu.free_state(self.state)

    def run(self, cells: list[Cell]) -> None:
        """The refused calls come first: the instance goes on after each of them."""
        for cell in sorted(cells, key=lambda cell: VERDICTS[cell.verdict] == OK):
            if cell.variables:
                self._access(cell)
            else:
                self._call(cell)

    def _call(self, cell: Cell) -> None:
        def call():
            return self.fmu.call(cell.function, *self.arguments.of(cell.function))

        status = VERDICTS[cell.verdict]
        if status != OK:
            self._refused(cell, status, (cell.function,) if cell.note else self.words, call)
            if status == DISCARD:
                self._no_nulls(cell)
            return
        self._allowed(cell, call)
        self.arguments.free_made()
        self._restore()
        self._no_nulls(cell)

    def _access(self, cell: Cell) -> None:
        sets, type_ = cell.function[4:7] == "Set", cell.function[7:]
        for name in names_of(self.fmu, cell.variables, type_, self.arguments.asked_for):
            value = new_value(self.fmu.variables[name])

            def call(name=name, value=value):
                return self.fmu.try_set({name: value}) if sets else self.fmu.try_get([name])[0]

            if VERDICTS[cell.verdict] != OK:
                self._refused(cell, ERROR, (*self.words, name), call)
                continue
            self._allowed(cell, call)
            if (
                sets
                and self.state is not None
                and self.fmu.try_get([name])[1] not in ([value], [str(value).encode()])
            ):
                self.wrong.append(f"{cell}: {name} is not {value} after the call")
            self._restore()

    def _refused(self, cell: Cell | str, status: int, words: tuple[str, ...], call: Callable) -> None:
        count = len(self.fmu.messages)
        found, messages = call(), self.fmu.messages[count:]
        if found not in (status, None) or len(messages) != 1:
            self.wrong.append(f"{cell}: status {found}, messages {messages}")
        else:
            text = messages[0].text
            function = str(cell).partition(" ")[0]
            good = (messages[0].status, messages[0].category) == (status, "logStatusError")
            if not good or function not in text or "allowed" not in text or not any(w in text for w in words):
                self.wrong.append(f"{cell}: none of {words} in {messages[0]}")
        if self._bytes() != self.before:
            self.wrong.append(f"{cell}: the saved state has changed")
            self._restore()

    def _allowed(self, cell: Cell, call: Callable) -> None:
        count = len(self.fmu.messages)
        found = call()
        if found != OK or len(self.fmu.messages) != count:
            self.wrong.append(f"{cell}: status {found}, messages {self.fmu.messages[count:]}")

    def _no_nulls(self, cell: Cell) -> None:
        """Each pointer in turn is NULL: an error that says so."""
        kinds = getattr(self.fmu.library, cell.function).argtypes[1:]
        arguments = self.arguments.of(cell.function)
        for k, (kind, argument) in enumerate(zip(kinds, arguments, strict=True)):
            is_pointer = kind in (c_void_p, c_char_p) or hasattr(kind, "contents")
            is_empty = argument is None or (isinstance(argument, Array) and len(argument) == 0)
            if is_pointer and not is_empty and (cell.function, k) not in self.arguments.MAY_BE_NULL:
                changed = (*arguments[:k], None, *arguments[k + 1 :])
                title = f"{cell.function} with argument {k + 1} NULL"
                self._refused(title, ERROR, ("NULL",), lambda c=changed: self.fmu.call(cell.function, *c))
        self.arguments.free_made()


def check_every_call(
    make: Callable[[], Calls], enter: Callable[[Calls], None], cells: list[Cell], words: tuple[str, ...],
    arguments: type[ValidArguments],
) -> None:  # fmt: skip
    """The cells of one state. A reset then makes the instance as a new one, and an instance in this state can
    be freed."""
    fmu, other = make(), make()
    started = fmu.state_bytes()
    enter(fmu)
    check = StateCheck(words, arguments(fmu))
    values = fmu.everything()
    check.run([cell for cell in cells if not cell.function.endswith("FreeInstance")])
    assert fmu.everything() == values
    check.close()
    assert not check.wrong, "\n" + "\n".join(check.wrong)
    fmu.ok("Reset")
    assert fmu.state_bytes() == started
    enter(fmu)
    enter(other)
    assert fmu.state_bytes() == other.state_bytes()
    fmu.free()
