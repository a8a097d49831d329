"""The products for a page in a browser: each model as WebAssembly, and three.js.

build/web/DualCamForward.wasm   the FMU of FMI 2.0 and the room fmu_src/web, for wasm32-wasi
build/web/DualCamInverse.wasm
build/web/three/                three.js from the npm registry (npm_package.py)
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import npm_package
from compiler import compile_library
from fmus import Fmu, identity
from platforms import LTO, OPTIMISATION, Platform
from workspace import (
    BUILD,
    TOOLS,
    WEB_ROOM,
    build_program,
    fingerprint,
    headers,
    is_fresh,
    relative,
    say,
    set_stamp,
)

WEB = BUILD / "web"
WASM = "wasm32-wasi"


@dataclass(frozen=True)
class WebAssembly(Platform):
    """A module that exports the FMI functions, and malloc and free for their arguments. It has no main():
    `reactor` is WASI's name for such a module.

    The compiler forms no fused multiply-add and no relaxed SIMD, so that all bits are those of other
    platforms."""

    @property
    def compilation(self) -> list[str]:
        return [OPTIMISATION, "-fvisibility=hidden", LTO]

    def linking(self, identifier: str) -> list[str]:
        exports = ["-rdynamic", "-Wl,--export=malloc", "-Wl,--export=free"]
        return ["-target", WASM, OPTIMISATION, "-mexec-model=reactor", "-s", LTO, *exports]


PLATFORM = WebAssembly("web", (WASM,), ".wasm")


def build_wasm(fmu: Fmu) -> Path:
    """The WebAssembly module of an FMU of FMI 2.0."""
    module = WEB / f"{fmu.identifier}.wasm"
    sources = [*fmu.sources, *sorted(WEB_ROOM.glob("*.c"))]
    defines = [*fmu.defines, *identity(fmu)]
    used = [*sources, *headers(), *build_program(), TOOLS / "web_build.py"]
    stamp = fingerprint(used, WASM, *defines)
    if not is_fresh(module, stamp):
        say(f"compile {relative(module)} ({len(sources)} files)")
        part = BUILD / "parts/web" / module.name
        compile_library(PLATFORM, WASM, defines, sources, part)
        module.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(part, module)
        set_stamp(module, stamp)
    return module


def build_three() -> Path:
    """The folder with three.js and its licence.

    Raises
    ------
    BuildError
        The registry cannot be reached, or what it gives is not what pyproject.toml pins.
    """
    return npm_package.install("three", WEB)
