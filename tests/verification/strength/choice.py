"""Which mutants are made: a seeded choice among all places, the same number of each kind."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from itertools import chain, zip_longest
from pathlib import Path

from verification.strength.sites import Site, parse, signatures_of, sites_of

# Physics and the calls of FMI. Left out are `platform` and the rooms outside of the FMUs.
ROOMS = (
    *("numerics", "model", "geometry", "contact", "closed_form", "collocation", "forward", "inverse"),
    *("outputs", "sensitivity", "fmi"),
)
GENERATED = ("radau_table.h", "lobatto_table.h")


def all_sites(core: Path) -> list[Site]:
    """Every place in the rooms of `core`, a folder fmu_src."""
    listed = (path for room in ROOMS for path in sorted((core / room).glob("*.[ch]")))
    files = [path for path in listed if path.name not in GENERATED]
    signatures: dict[str, list[str]] = {}
    for path in files:
        signatures |= signatures_of(parse(path.read_bytes()))
    return [site for path in files for site in sites_of(path, path.relative_to(core).as_posix(), signatures)]


def rank(site: Site, seed: int) -> bytes:
    """A pseudo-random number of the place, which an edit elsewhere does not change."""
    return hashlib.sha256("\0".join((str(seed), *site.identity)).encode()).digest()


def ordered(sites: Iterable[Site], seed: int) -> list[Site]:
    """All places in the order in which they are chosen: by turns one of each kind."""
    kinds: dict[str, list[Site]] = {}
    for site in sorted(sites, key=lambda site: rank(site, seed)):
        kinds.setdefault(site.kind, []).append(site)
    turns = zip_longest(*(kinds[kind] for kind in sorted(kinds)))
    return [site for site in chain.from_iterable(turns) if site is not None]


def chosen(order: Sequence[Site], count: int, refused: set[Site]) -> dict[int, Site]:
    """The first `count` places that are not refused, by numbers from 1 in the order of files and lines."""
    taken = [site for site in order if site not in refused][:count]
    taken.sort(key=lambda site: (site.file, site.start, -site.end, site.mutated))
    return dict(enumerate(taken, 1))
