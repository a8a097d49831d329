"""The members of an FMU besides binaries, description and documentation: its source code, which compiles
without the repository, its terminals, and a reference result."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def sources(core: Path, files: Iterable[Path]) -> dict[str, Path]:
    """Name in the archive -> file, of the C files `files` below the folder `core`."""
    return {f"sources/{path.relative_to(core).as_posix()}": path for path in files}


def identity_header(identifier: str, model: str, guid: str, version: int) -> str:
    """The header identity.h: the macros that the build of this repository defines by options. model.h
    includes the header where the options are missing."""
    return f"""\
// The FMU of the files in this directory. They need a C17 compiler and the headers of FMI {version}.0:
//
//     cc -std=c17 -O2 -ffp-contract=off -fPIC -shared -I<FMI headers> -I. */*.c -lm -o {identifier}.so
//
// With -ffp-contract=off the last digits are the same as those of the binaries in this FMU. The functions
// have no prefix. To link several FMUs statically, add -DFMI{version}_FUNCTION_PREFIX={identifier}_
#ifndef DUALCAM_IDENTITY_H
#define DUALCAM_IDENTITY_H

#define FMI_VERSION {version}
#define MODEL_BUILT MODEL_{model.upper()}
#define MODEL_IDENTIFIER {identifier}
#define MODEL_GUID "{guid}"

#endif
"""


def build_description(identifier: str, names: Iterable[str]) -> str:
    """The file sources/buildDescription.xml of FMI 3.0; `names` are the C files, relative to `sources`."""
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


# Member of the Modelica flange -> variable and its kind. A torque on cam 2 flows into the mechanism. F_ext is
# positive against z: it flows out of the mechanism.
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
    """One element of terminalsAndIcons.xml; `members` are name -> variable and its kind."""
    lines = [
        f'      <TerminalMemberVariable variableName="{name}" memberName="{member}" variableKind="{how}"/>'
        for member, (name, how) in members.items()
    ]
    head = f'    <Terminal name="{title}" matchingRule="bus" terminalKind="{kind}" description="{text}">'
    return "\n".join([head, *lines, "    </Terminal>"])


def terminals(model: str) -> str:
    """The file terminalsAndIcons.xml: the flanges of shaft and follower. FMI 3.0 defines the file. FMI 2.0
    does not; its FMUs hold the file in the same place, for tools that look for it. The Modelica flanges have
    no speeds and no acceleration: by the rule `bus` a counterpart need not have them."""
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
    """Name in the archive -> file, of the reference result and its inputs."""
    names = ("README.txt", f"{identifier}_in.csv", f"{identifier}_ref.csv")
    return {f"extra/reference/{name}": descriptions / "reference" / name for name in names}
