"""What an FMU holds besides its binaries, its description and its documentation: its own source code,
which compiles from there alone, and a reference result."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterable
from pathlib import Path

IDENTITY = "identity.h"
INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)


def sources(core: Path, files: Iterable[Path]) -> dict[str, str]:
    """Name in the archive -> text. In the project an include names a file from `core`; in the archive from
    the folder of the including file, so that the sources compile in tools that know no include directory."""
    paths = {path.relative_to(core).as_posix(): path for path in files}

    def text(name: str) -> str:
        def relative(include: re.Match[str]) -> str:
            included = include[1]
            if included not in paths and included != IDENTITY:
                return include[0]  # a header of FMI
            return f'#include "{posixpath.relpath(included, posixpath.dirname(name) or ".")}"'

        return INCLUDE.sub(relative, paths[name].read_text(encoding="utf-8"))

    return {f"sources/{name}": text(name) for name in paths}


def identity_header(identifier: str, model: str, guid: str, version: int) -> str:
    """What the project's own build says by -D options. model.h includes this header where there are none."""
    return f"""\
// Which FMU the files in this directory are. They need a C17 compiler and the headers of FMI {version}.0:
//
//     cc -std=c17 -O2 -ffp-contract=off -fPIC -shared -I<FMI headers> */*.c -lm -o {identifier}.so
//
// With -ffp-contract=off the results have the same bits as those of the binaries in this FMU; on 32-bit x86
// with -msse2 -mfpmath=sse too. The functions have no prefix. To link several FMUs statically, add
// -DFMI{version}_FUNCTION_PREFIX={identifier}_
#ifndef DUALCAM_IDENTITY_H
#define DUALCAM_IDENTITY_H

#define FMI_VERSION {version}
#define MODEL_BUILT MODEL_{model.upper()}
#define MODEL_IDENTIFIER {identifier}
#define MODEL_GUID "{guid}"

#endif
"""


def build_description(identifier: str, names: Iterable[str]) -> str:
    """FMI 3.0's sources/buildDescription.xml."""
    files = "\n".join(f'      <SourceFile name="{name}"/>' for name in names)
    return f"""\
<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{identifier}">
    <SourceFileSet language="C17" compilerOptions="-ffp-contract=off">
{files}
      <IncludeDirectory name="."/>
    </SourceFileSet>
    <Library name="m" external="true" description="Mathematics, where not part of the C library"/>
  </BuildConfiguration>
</fmiBuildDescription>
"""


# Member of the Modelica flange -> variable, and how it is connected. A torque on cam 2 flows into the
# mechanism; F_ext is positive against z, and so flows out of it.
SHAFT = {
    "forward": {"phi": ("theta", "signal"), "w": ("omega", "signal"), "tau": ("tau", "inflow")},
    "inverse": {
        "phi": ("theta", "signal"),
        "w": ("omega", "signal"),
        "a": ("alpha", "signal"),
        "tau": ("tau", "inflow"),
    },
}
FOLLOWER = {"s": ("z", "signal"), "v": ("v", "signal"), "f": ("F_ext", "outflow")}


def terminal(title: str, kind: str, members: dict[str, tuple[str, str]], text: str) -> str:
    lines = [
        f'      <TerminalMemberVariable variableName="{name}" memberName="{member}" variableKind="{how}"/>'
        for member, (name, how) in members.items()
    ]
    head = f'    <Terminal name="{title}" matchingRule="bus" terminalKind="{kind}" description="{text}">'
    return "\n".join([head, *lines, "    </Terminal>"])


def terminals(model: str) -> str:
    """terminalsAndIcons.xml: the flanges of shaft and follower. It is FMI 3.0's, and in the same place of an
    FMU of FMI 2.0, which has none, for tools that look there. Speeds and acceleration go beyond what the
    Modelica flanges have: by the rule `bus` a counterpart need not have them."""
    flange = "Modelica.Mechanics.{}.Interfaces.Flange_{}".format
    shaft = terminal("shaft", flange("Rotational", "a"), SHAFT[model], "Cam 2: angle and torque")
    follower = terminal("follower", flange("Translational", "b"), FOLLOWER, "Position and external force")
    return f"""\
<?xml version="1.0" encoding="UTF-8"?>
<fmiTerminalsAndIcons fmiVersion="3.0">
  <GraphicalRepresentation>
    <CoordinateSystem x1="-100" y1="-100" x2="100" y2="100" suggestedScalingFactorTo_mm="0.1"/>
    <Icon x1="-100" y1="-100" x2="100" y2="100"/>
  </GraphicalRepresentation>
  <Terminals>
{shaft}
{follower}
  </Terminals>
</fmiTerminalsAndIcons>
"""


def reference(descriptions: Path, identifier: str) -> dict[str, Path]:
    """Name in the archive -> file, of the reference result and its input."""
    names = ("README.txt", f"{identifier}_in.csv", f"{identifier}_ref.csv")
    return {f"extra/reference/{name}": descriptions / "reference" / name for name in names}
