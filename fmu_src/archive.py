"""What an FMU holds besides its binaries, its description and its documentation: its own source code,
which compiles from there alone, and a reference result."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def sources(files: Iterable[Path]) -> dict[str, Path]:
    """Name in the archive -> file."""
    return {f"sources/{path.name}": path for path in files}


def identity_header(identifier: str, model: str, guid: str) -> str:
    """What the project's own build says by -D options. model.h includes it where nobody does."""
    return f"""\
/* Which FMU the files in this directory are. They need a C17 compiler and the three headers of FMI 2.0:
 *
 *     cc -std=c17 -O2 -ffp-contract=off -fPIC -shared -I<FMI headers> *.c -lm -o {identifier}.so
 *
 * -ffp-contract=off keeps the last digits those of the binaries in this FMU. The functions have no prefix; to
 * link several FMUs statically, add -DFMI2_FUNCTION_PREFIX={identifier}_ */
#ifndef DUALCAM_IDENTITY_H
#define DUALCAM_IDENTITY_H

#define MODEL_BUILT MODEL_{model.upper()}
#define MODEL_IDENTIFIER {identifier}
#define MODEL_GUID "{guid}"

#endif
"""


def reference(descriptions: Path, identifier: str) -> dict[str, Path]:
    """Name in the archive -> file, of the reference result and its input."""
    names = ("README.txt", f"{identifier}_in.csv", f"{identifier}_ref.csv")
    return {f"extra/reference/{name}": descriptions / "reference" / name for name in names}
