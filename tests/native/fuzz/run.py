"""Fuzzing of the C code with coverage: libFuzzer calls the FMUs of both standards and gives them tables and
saved states. It starts from the inputs in tests/fuzz_corpus.

    ./build.sh run fuzz-calls [--minutes N] [--only NAME] [--keep] [--coverage] [--sanitizer memory]

    --minutes N   for each of the four programs (2)
    --only NAME   one program, for example DualCamForward-fmi3
    --keep        then replace the inputs in tests/fuzz_corpus by the fewest that reach the same code
    --coverage    no fuzzing: the shares of lines and branches that the inputs reach, by room of fmu_src, into
                  tests/fuzz_corpus/coverage.csv; needs clang
    --sanitizer memory    reads of memory that was not written, instead of addresses; needs clang

clang has libFuzzer and AddressSanitizer. Without clang, zig compiles the target and libFuzzer comes from the
Python package atheris (extra `fuzz`); then AddressSanitizer is left out.
A finding is a file in build/native/findings; `build/native/NAME-replay FILE` repeats the finding.
"""

from __future__ import annotations

import argparse
import csv
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from build_fmu import ALL, MODELS, ROOT, ZIG, dual_cam, locked
from fuzz_corpus import CORPUS, inputs_of, write_archive
from native_programs import FOLDER, Toolchain, build_fuzz_target, fuzz_name

PROGRAMS = [fuzz_name(dual_cam(name, False, version)) for version in ALL for name in MODELS]
FINDINGS, GROWN = FOLDER / "findings", FOLDER / "grown"
SANITIZERS = {"address": "address,undefined", "memory": "memory,undefined"}
LARGEST = 400  # bytes of an input
# A step may take two seconds, and more than ten times as long under sanitizers.
OPTIONS = [f"-max_len={LARGEST}", "-len_control=0", "-timeout=120", "-print_final_stats=1", "-verbosity=1"]


class NoFuzzer(Exception):
    """No fuzzer on this machine."""


# ---- compilers ----


def find_clang() -> str | None:
    """The newest clang."""
    names = ["clang", *(f"clang-{version}" for version in range(25, 12, -1))]
    return next((name for name in names if shutil.which(name)), None)


def beside(clang: str, tool: str) -> str:
    """llvm-cov of clang-14 is llvm-cov-14."""
    return tool + clang.removeprefix("clang")


def of_clang(clang: str, sanitizer: str) -> Toolchain:
    checks = SANITIZERS[sanitizer]
    flags = (f"-fsanitize={checks}", "-fno-sanitize-recover=all")
    fuzzer = f"-fsanitize=fuzzer,{checks}"
    return Toolchain(f"{clang} {checks}", (clang,), (fuzzer, flags[1]), flags, (fuzzer, flags[1]))


def standard_library() -> str:
    """The path of libstdc++, which the libFuzzer of atheris needs."""
    import ctypes

    ctypes.CDLL("libstdc++.so.6")
    lines = Path("/proc/self/maps").read_text(encoding="utf-8").split("\n")
    return next(line.split()[-1] for line in lines if "libstdc++.so" in line)


def of_zig() -> Toolchain:
    found = importlib.util.find_spec("atheris")
    library = None if found is None or found.origin is None else Path(found.origin).parent.parent
    archive = None if library is None else library / "libclang_rt.fuzzer_no_main.a"
    if archive is None or not archive.exists():
        raise NoFuzzer("neither clang nor the Python package atheris is installed: no fuzzing with coverage")
    flags = ("-fsanitize=undefined", "-fno-sanitize-recover=all")
    linked = (*flags, str(archive), standard_library())
    return Toolchain("zig undefined", tuple(ZIG), ("-fsanitize=fuzzer-no-link", *flags), flags, linked)


def fuzzing_toolchain(sanitizer: str) -> Toolchain:
    clang = find_clang()
    if clang is not None:
        return of_clang(clang, sanitizer)
    if sanitizer != "address":
        raise NoFuzzer(f"clang is not installed: no sanitizer of {sanitizer}")
    print("-- clang is not installed: zig with UBSan instead, AddressSanitizer is left out", flush=True)
    return of_zig()


# ---- fuzzing ----


@contextmanager
def surroundings() -> Iterator[dict[str, str]]:
    """The environment of a program, with a folder for its tables: in memory, if there is one."""
    memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as folder:
        yield {**os.environ, "FUZZ_DIRECTORY": folder}


@contextmanager
def seeds(names: Iterable[str] = PROGRAMS) -> Iterator[Path]:
    """A folder with the inputs of some programs, from which a run starts."""
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            inputs_of(name, Path(folder))
        yield Path(folder)


def fuzz(program: Path, name: str, minutes: float) -> bool:
    """Has the program found nothing?"""
    grown, findings = GROWN / name, FINDINGS / name
    for folder in (grown, findings):
        folder.mkdir(parents=True, exist_ok=True)
    words = [f"-max_total_time={round(60 * minutes)}", f"-artifact_prefix={findings}/", str(grown)]
    with tempfile.TemporaryFile("w+", errors="replace") as log, surroundings() as env, seeds() as kept:
        done = subprocess.run([program, *OPTIONS, *words, kept], stderr=log, env=env)
        log.seek(0)
        lines = log.read().split("\n")
    shown = [
        line
        for line in lines
        if line.startswith(("stat::number", "SUMMARY", "tests/native")) or "DONE" in line
    ]
    print(f"-- {name}: exit {done.returncode}", *shown, sep="\n   ", flush=True)
    if done.returncode != 0:
        print("\n".join(lines[-60:]))
    return done.returncode == 0


def keep_the_fewest(program: Path, name: str) -> None:
    with tempfile.TemporaryDirectory() as folder, surroundings() as env, seeds([name]) as kept:
        command = [program, "-merge=1", "-use_counters=0", *OPTIONS, folder, kept, GROWN / name]
        subprocess.run(command, check=True, stderr=subprocess.DEVNULL, env=env)
        write_archive(name, {path.name: path.read_bytes() for path in Path(folder).iterdir()})


# ---- coverage ----


def rooms_of(export: Mapping[str, Any]) -> dict[str, Counter[str]]:
    """Counts of lines and branches of each room."""
    rooms: dict[str, Counter[str]] = {}
    for file in export["data"][0]["files"]:
        path = Path(file["filename"])
        if ROOT / "fmu_src" not in path.parents:
            continue
        room = rooms.setdefault(path.parent.name, Counter())
        for kind in ("lines", "branches"):
            room[kind] += file["summary"][kind]["count"]
            room[f"{kind} reached"] += file["summary"][kind]["covered"]
    return rooms


def measure(clang: str, programs: Mapping[str, Path]) -> dict[str, Counter[str]]:
    with tempfile.TemporaryDirectory() as folder, surroundings() as env:
        profiles = []
        for name, program in programs.items():
            profile = Path(folder) / f"{name}.profraw"
            (place := Path(folder) / name).mkdir()
            inputs = sorted(str(path) for path in inputs_of(name, place))
            env["LLVM_PROFILE_FILE"] = str(profile)
            subprocess.run([program, *inputs], check=True, stdout=subprocess.DEVNULL, env=env)
            profiles.append(str(profile))
        merged = f"{folder}/all.profdata"
        subprocess.run(
            [beside(clang, "llvm-profdata"), "merge", "-sparse", *profiles, "-o", merged], check=True
        )
        first, *others = map(str, programs.values())
        objects = [word for other in others for word in ("-object", other)]
        command = [
            beside(clang, "llvm-cov"),
            "export",
            "-summary-only",
            f"-instr-profile={merged}",
            first,
            *objects,
        ]
        return rooms_of(json.loads(subprocess.run(command, check=True, capture_output=True).stdout))


def report_coverage(only: str | None) -> None:
    clang = find_clang()
    if clang is None:
        raise NoFuzzer("clang is not installed: no coverage")
    flags = ("-fprofile-instr-generate", "-fcoverage-mapping")
    programs = build_all(
        Toolchain(f"{clang} coverage", (clang,), flags, (), flags), "coverage", "replay", only
    )
    rooms = measure(clang, programs)
    rooms["all"] = sum(rooms.values(), Counter())
    rows = [["room", "lines", "lines reached", "branches", "branches reached"]]
    for room, counts in rooms.items():
        rows.append([room, *(str(counts[column]) for column in rows[0][1:])])
        shares = [100 * counts[f"{kind} reached"] / max(1, counts[kind]) for kind in ("lines", "branches")]
        print(
            f"{room:13} lines {shares[0]:5.1f} % of {counts['lines']:5}   branches {shares[1]:5.1f} % of",
            end="",
        )
        print(f" {counts['branches']:5}")
    if only is None:
        with (CORPUS / "coverage.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)


# ---- all programs ----


def build_all(toolchain: Toolchain, suffix: str, main: str | None, only: str | None) -> dict[str, Path]:
    with locked():
        fmus = [dual_cam(name, False, version) for version in ALL for name in MODELS]
        return {
            fuzz_name(fmu): build_fuzz_target(fmu, toolchain, suffix, main)
            for fmu in fmus
            if only in (None, fuzz_name(fmu))
        }


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--minutes", type=float, default=2.0, help="for each of the four programs")
    parser.add_argument("--only", help="one program, for example DualCamForward-fmi3")
    parser.add_argument("--keep", action="store_true", help="replace the corpus by the fewest inputs")
    parser.add_argument("--coverage", action="store_true", help="measure coverage instead")
    parser.add_argument("--sanitizer", choices=SANITIZERS, default="address")
    arguments = parser.parse_args()
    try:
        if arguments.coverage:
            report_coverage(arguments.only)
            return 0
        toolchain = fuzzing_toolchain(arguments.sanitizer)
        own_main = "driver" if toolchain.name.startswith("zig") else None
        programs = build_all(toolchain, f"fuzz-{arguments.sanitizer}", own_main, arguments.only)
    except NoFuzzer as reason:
        print(f"left out: {reason}", file=sys.stderr)
        return 1
    good = [fuzz(program, name, arguments.minutes) for name, program in programs.items()]
    if arguments.keep and all(good):
        for name, program in programs.items():
            keep_the_fewest(program, name)
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
