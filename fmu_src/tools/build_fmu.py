"""Builds the FMUs: variables.def -> modelDescription.xml -> shared library -> .fmu.

    python fmu_src/tools/build_fmu.py [all] [--check] [--sanitize]

    (none)      the FMUs for the machine on which the build runs: build/DualCamForward.fmu and
                DualCamInverse.fmu (FMI 2.0), the same in build/fmi3 (FMI 3.0), and NullFmu.fmu
    all         the same FMUs, except NullFmu.fmu for every platform: Linux (x86-64, aarch64), Windows (64 and
                32 bits), macOS (x86-64, arm64); --all is the same word
                in both cases also build/web, for a browser: both models as WebAssembly, three.js
    --check     a committed modelDescription.xml that is out of date is an error; else it is rewritten
    --sanitize  the native test programs instead, with sanitizers; `--sanitize plain`: those for valgrind

The compiler is the one in the `ziglang` wheel. Every machine with Python builds the same binaries from the
same files, for all platforms. Products that are up to date are not made again.

The steps are in modules beside this file. Other programs of this repository import the functions from
here. workspace: folders and stamps. platforms: targets and compiler options. compiler: compiling and
linking. fmus: the files and members of each FMU. members, document: texts in the archive. archive: the
zip file. products: the order in which all of this makes an FMU. native_programs: programs of the tests.
web_build: the products for a browser. npm_package: files from the npm registry.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from archive import validate, write_archive
from compiler import ZIG, compile_c, fmi_headers
from fmus import (
    MODELS,
    Fmu,
    core_sources,
    dual_cam,
    emit_description,
    hand_written_fmu,
    identity,
    names_of,
    null_fmu,
)
from native_programs import build_fuzz_target, build_lifecycle, plain, sanitized
from platforms import ALL, PLATFORMS, SHARED, TARGET, host_platform, host_target
from products import build, build_fleets, build_library
from web_build import build_three, build_wasm
from workspace import (
    BARE,
    BUILD,
    CORE,
    ROOT,
    BuildError,
    fingerprint,
    headers,
    is_fresh,
    locked,
    place,
    relative,
    set_stamp,
)

__all__ = [
    "ALL",
    "BARE",
    "BUILD",
    "CORE",
    "MODELS",
    "PLATFORMS",
    "ROOT",
    "SHARED",
    "TARGET",
    "ZIG",
    "BuildError",
    "Fmu",
    "build",
    "build_fleets",
    "build_library",
    "build_three",
    "build_wasm",
    "compile_c",
    "core_sources",
    "dual_cam",
    "emit_description",
    "fingerprint",
    "fmi_headers",
    "hand_written_fmu",
    "headers",
    "host_platform",
    "host_target",
    "identity",
    "is_fresh",
    "locked",
    "names_of",
    "null_fmu",
    "place",
    "relative",
    "set_stamp",
    "validate",
    "write_archive",
]


def warn_without_three() -> None:
    """Fetches three.js. The FMUs do not need it, so a build without a network goes on."""
    try:
        build_three()
    except BuildError as error:
        print(f"build_fmu: warning: {error}", file=sys.stderr)


def build_sanitized(fmus: Sequence[Fmu]) -> None:
    toolchain = sanitized()
    for fmu in fmus:
        if fmu.version == 2:
            build_lifecycle(fmu, toolchain, "-sanitized")
        build_fuzz_target(fmu, toolchain, "replay", "replay")


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("platforms", nargs="?", choices=["all"], help="for every platform, not this one only")
    parser.add_argument("--all", action="store_true", help="the same as the word `all`")
    parser.add_argument("--check", action="store_true", help="fail if the committed XML is not up to date")
    parser.add_argument(
        "--sanitize",
        nargs="?",
        choices=["sanitized", "plain"],
        const="sanitized",
        help="build the native test programs instead",
    )
    arguments = parser.parse_args(words)
    for_all = arguments.all or arguments.platforms == "all"
    try:
        with locked():
            fmus = [dual_cam(name, arguments.check, version) for version in ALL for name in MODELS]
            if arguments.sanitize == "sanitized":
                build_sanitized(fmus)
            elif arguments.sanitize == "plain":
                for fmu in fmus:
                    if fmu.version == 2:
                        build_lifecycle(fmu, plain())
            else:
                for fmu in fmus:
                    build(fmu, for_all)
                if for_all or host_target() is not None:
                    build_fleets(for_all)
                if host_target() is not None:
                    build(null_fmu(fmus[0]))
                for fmu in fmus:
                    if fmu.version == 2:
                        build_wasm(fmu)
                warn_without_three()
    except BuildError as error:
        print(f"build_fmu: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
