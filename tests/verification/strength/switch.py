"""All mutants in one program: a switch at each place, which an environment variable sets.

An expression `a + b` becomes `(mutant_is(7) ? (a - b) : (a + b))`, a statement `f(x);` becomes
`{ if (!mutant_is(8)) f(x); }`. A place may lie within another one. With DUALCAM_MUTANT=7 in the environment,
or with 7 in the exported integer `mutant_active`, a library computes with mutant 7. With -1 no mutant is in
force, and the libraries mark each place that they reach, in the file that DUALCAM_REACHED names. Where the
mistake can be computed beside the right value (a comparison, a logical operator), the mark also tells whether
the two ever differ: `a <= b` in place of `a < b` changes nothing until a equals b.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from verification.strength.sites import Site

ACTIVE, REACHED = "DUALCAM_MUTANT", "DUALCAM_REACHED"
SYMBOL, MARKS = "mutant_active", "mutant_reached"
HEADER = "platform/mutant_switch.h"
LINES_BEFORE = 1  # of the #include in each changed file
REACHED_BIT, DIFFERS_BIT = 1, 2  # of a mark
# What must not be computed twice, or not where the right code does not compute it.
EFFECT = re.compile(r"\+\+|--|(?<![<>=!])=(?!=)|\b(?!fabs|max_of|min_of|sqrt|isfinite)\w+ ?\(")
ACCESS = re.compile(r"->|\[|[(,&|] ?\*")

HEADER_TEXT = """\
#ifndef DUALCAM_MUTANT_SWITCH_H
#define DUALCAM_MUTANT_SWITCH_H
#pragma clang diagnostic ignored "-Weverything"
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>
__attribute__((weak, visibility("default"))) int mutant_active;
__attribute__((weak, visibility("default"))) unsigned char *mutant_reached;
static inline int mutant_mark(int number, int differs) {
    mutant_reached[number] |= differs ? 3 : 1;
    return 0;
}
static inline int mutant_is(int number) {
    return mutant_active < 0 ? mutant_mark(number, 1) : mutant_active == number;
}
__attribute__((constructor)) static void mutant_choose(void) {
    const char *const text = getenv("DUALCAM_MUTANT"), *const path = getenv("DUALCAM_REACHED");
    if (text == NULL || mutant_active != 0) return;
    const int number = atoi(text);
    if (number < 0) {
        const int file = path == NULL ? -1 : open(path, O_RDWR);
        void *bytes = MAP_FAILED;
        if (file >= 0) bytes = mmap(NULL, %d, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
        if (bytes == MAP_FAILED) return;
        close(file);
        mutant_reached = bytes;
    }
    mutant_active = number;
}
#endif
"""


def header_text(count: int) -> str:
    """`count`: bytes of the file of marks, one for each number of a mutant and one for 0."""
    return HEADER_TEXT % count


def can_be_compared(site: Site) -> bool:
    """May the right value and the mistake both be computed, without an effect of the second one?"""
    if site.kind not in ("comparison", "logic") or EFFECT.search(site.original):
        return False
    return site.kind == "comparison" or not ACCESS.search(site.original)


def choice_at(number: int, site: Site) -> str:
    """Is the mistake in force?"""
    if not can_be_compared(site):
        return f"mutant_is({number})"
    differs = f"!({site.mutated}) != !({site.original})"
    return f"(mutant_active < 0 ? mutant_mark({number}, {differs}) : mutant_active == {number})"


def switched(text: bytes, places: Mapping[int, Site]) -> bytes:
    """The text of a file with a switch at each place, by the number of the mutant."""
    order = sorted(places.items(), key=lambda item: (item[1].start, -item[1].end, item[1].statement is False))
    rendered, end = render(text, order, 0, len(text))
    assert not end
    return f'#include "{HEADER}"\n'.encode() + rendered


Order = Sequence[tuple[int, Site]]


def render(text: bytes, order: Order, start: int, end: int) -> tuple[bytes, Order]:
    """The text from `start` to `end`, and the places that lie behind."""
    parts, position = [], start
    while order and order[0][1].end <= end:
        (number, site), order = order[0], order[1:]
        parts.append(text[position : site.start])
        inside, order = render(text, order, site.start, site.end)
        if site.statement:
            parts.append(f"{{ if (!mutant_is({number})) ".encode() + inside + b" }")
        else:
            parts.append(f"({choice_at(number, site)} ? ({site.mutated}) : (".encode() + inside + b"))")
        position = site.end
    parts.append(text[position:end])
    return b"".join(parts), order


def write(core: Path, chosen: Mapping[int, Site]) -> None:
    """Puts the switches into the files below `core`, a copy of fmu_src."""
    (core / HEADER).write_text(header_text(max(chosen) + 1))
    files: dict[str, dict[int, Site]] = {}
    for number, site in chosen.items():
        files.setdefault(site.file, {})[number] = site
    for name, places in files.items():
        path = core / name
        path.write_bytes(switched(path.read_bytes(), places))
