"""Verdicts by hand, in equivalent.toml, and whether the code that they judge is still there.

A verdict names a place by file, function, kind of mistake, the text of the code and of the mistake, `nth`
among equal mistakes of the function, and the text of the line. An edit elsewhere changes none of them. An
edit of the function can: then the verdict holds for no place, and the run tells so.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from verification.strength.sites import Site

FILE = Path(__file__).with_name("equivalent.toml")
IDENTITY = ("file", "function", "kind", "original", "mutated", "nth")  # of a mutant's place
VERDICTS = ("killed", "equivalent", "cost only", "survives")

Identity = tuple[str, ...]


@dataclass(frozen=True)
class Judgement:
    line: str  # text of the line at which the place begins
    verdict: str
    reason: str


Judgements = Mapping[Identity, Judgement]


def listed(path: Path = FILE) -> dict[Identity, Judgement]:
    """All verdicts by hand, by the identity of the mutant's place."""
    found = {}
    for entry in tomllib.loads(path.read_text())["mutant"]:
        identity = tuple(str(entry.get(name, 1)) for name in IDENTITY)
        verdict = entry.get("verdict", "equivalent")
        found[identity] = Judgement(entry["line"], verdict, entry["reason"])
    return found


def judgement_of(site: Site, known: Judgements) -> Judgement | None:
    """The verdict on this place, as long as its line is the one that was judged."""
    found = known.get(site.identity)
    return found if found is not None and found.line == site.text else None


def without_place(known: Judgements, places: Iterable[Site]) -> list[str]:
    """Verdicts that hold for no place of the code, and why."""
    texts: dict[Identity, str] = {site.identity: site.text for site in places}
    found = []
    for identity, judgement in known.items():
        file, function, kind, original, mutated, nth = identity
        if texts.get(identity) == judgement.line:
            continue
        why = f"the line is now `{texts[identity]}`" if identity in texts else "there is no such place"
        mistake = f"`{original}` -> `{mutated}` in `{judgement.line}`"
        found.append(f"{file} {function}() {kind} {nth}: {mistake}: {why}")
    return found


def refuted(known: Judgements, rows: Sequence[Mapping[str, str]]) -> list[str]:
    """Mutants that a test kills, although a verdict by hand says that no test does."""
    found = []
    for row in rows:
        judgement = known.get(tuple(row[name] for name in IDENTITY))
        if judgement is not None and row["verdict"] == "killed":
            found.append(f"{row['mutant']}: {row['file']} {row['function']}() is judged: {judgement.verdict}")
    return found
