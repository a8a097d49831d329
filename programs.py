"""The programs of the repository. `./build.sh run` shows them, `./build.sh run NAME [arguments]` runs one.

build.sh installs the extras that a program needs. A program of the system that is missing is named here.
"""

from __future__ import annotations

import difflib
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent
LONG = (
    "tests/test_properties.py tests/test_reader_mutations.py tests/test_extreme_values.py "
    "--hypothesis-profile long -o faulthandler_timeout=0"
)
STUDIES = (
    "system_examples/study/efficiency_map.toml system_examples/study/load_release.toml "
    "--out build/study --figure docs/study.png"
)
# A program of the system: the names that it may have, and its package in Debian and Ubuntu.
TOOLS = {
    "Chromium": (("chromium", "chromium-browser", "google-chrome"), "chromium"),
    "Node.js": (("node",), "nodejs"),
    "valgrind": (("valgrind",), "valgrind"),
}


@dataclass(frozen=True)
class Program:
    name: str
    question: str  # or what it writes
    minutes: float  # on two cores, without installation
    command: str  # words for Python, to which the user's arguments are added
    extras: str = "build"  # of pyproject.toml
    tools: tuple[str, ...] = ()  # keys of TOOLS that it cannot do without
    build: str | None = ""  # arguments of the build of the FMUs before the command; None: needs no FMU
    before: tuple[str, ...] = ()  # other commands before
    arguments: str = ""  # where the user gives none

    @property
    def needs(self) -> str:
        """Packages beside those of a build, and programs of the system."""
        return ", ".join([*(extra for extra in self.extras.split(",") if extra != "build"), *self.tools])


BUILD = "fmu_src/tools/build_fmu.py"
EXAMPLES = (
    Program(
        *("joint", "What does the cam save a robot joint that carries a payload?", 0.1),
        "system_examples/robot_joint.py",
    ),
    Program("knee", "What does the cam save a knee in swing?", 0.1, "system_examples/prosthetic_knee.py"),
    Program(
        *("door", "Can a door stay at every angle with its motor off?", 0.1), "system_examples/car_door.py"
    ),
    Program(
        *("clamp", "How far does the torque drift while the grease warms up?", 0.1),
        "system_examples/spring_clamp.py",
    ),
    Program("design", "Which groove makes a wanted torque?", 0.1, "system_examples/designed_groove.py"),
    Program(
        *("plan", "Which motor torque raises the elbow with the least heat? (optimal control)", 0.2),
        *("system_examples/planned_elbow.py", "build,casadi"),
    ),
    Program(
        *("elbow", "The same in two strokes, through stick and slip, by gradients", 0.5),
        *("system_examples/elbow_torque.py", "build,jax"),
    ),
    Program(
        *("mujoco", "Does the elbow stay with the motor off, beside MuJoCo's own friction?", 0.2),
        *("system_examples/mujoco_elbow.py", "build,mujoco"),
    ),
    Program(
        *("gains", "Which gains suit the elbow if payload and friction are not known?", 5),
        "system_examples/controller_gains.py",
    ),
    Program(
        *("sampling", "What does planning by trial runs save, if payload and friction are unknown?", 10),
        "system_examples/sampling_elbow.py",
    ),
    Program("study", "Which parameters matter?", 0.5, "-m dualcam study", "build,study", arguments=STUDIES),
    Program("ssp", "How do the examples run in other masters? docs/use-ssp.md", 3, "-m system_examples.ssp"),
)
REPORTS = (
    Program("report-joint", "What else can be said about the joint?", 0.1, "-m case_studies.robot_joint"),
    Program("report-knee", "What else about the knee?", 0.1, "-m case_studies.prosthetic_knee"),
    Program("report-door", "What else about the door?", 0.1, "-m case_studies.car_door"),
    Program(
        *("paper", "Which claims of the paper can be reproduced? Writes docs/paper.md", 0.1),
        "-m case_studies.paper",
    ),
)
PAGES = (
    Program(
        *("figures", "Draws figures of docs/ and writes its generated pages", 0.3),
        "docs/tools/variables_page.py",
        build=None,
        before=(
            *("docs/figures/mechanism.py", "docs/figures/architecture.py"),
            *("docs/figures/groove_laws.py", "docs/figures/design_quantities.py", "docs/tools/trust_page.py"),
            *("docs/tools/design_file_page.py", "docs/tools/study_plan_page.py"),
            "-m benchmarks.harness.old_figures",
        ),
    ),
    Program(
        *("refresh", "Makes all published figures anew, and goes on where one fails", 46),
        "programs.py --refresh",
        "bench,strength",
        build="all",
    ),
    Program(
        *("cad", "Draws docs/cut_grooves.png with solids of cams, tests STEP files", 1),
        *("-m pytest tests/test_cam_solid.py", "test,cad"),
        before=("docs/figures/groove_cut.py",),
    ),
)
BENCHMARKS = (
    Program(
        *("bench", "Runs cost, loop, skipping, worst, growth, precision: docs/performance.md", 7),
        *("-m benchmarks.bench", "bench"),
    ),
    Program("cost", "What does one step cost, and what is the limit?", 0.5, "-m benchmarks.step_cost"),
    Program("skipping", "What is saved by leaving something out?", 0.2, "-m benchmarks.skipping"),
    Program("worst", "What is the worst of a million steps?", 2, "-m benchmarks.worst_step"),
    Program(
        *("growth", "How does the time grow with steps, instances, table points, threads?", 1),
        "-m benchmarks.growth",
    ),
    Program(
        *("precision", "Which run time does which error take, beside other solvers?", 4),
        *("-m benchmarks.work_precision", "bench"),
    ),
    Program(
        *("friction", "What does friction that depends on the speed cost?", 0.5),
        "-m benchmarks.friction_cost",
        tools=("valgrind",),
    ),
    Program(
        *("platforms", "What does a step cost on Windows (wine) and aarch64 (qemu)?", 6),
        *("-m benchmarks.platform_cost", "test"),
        build="all",
    ),
    Program("loop", "What does a control loop in Python cost?", 0.2, "-m benchmarks.rates loop"),
    Program("fleet", "What does a step cost in a fleet, beside loops?", 2, "-m benchmarks.rates fleet"),
    Program("gym", "What does a step in gymnasium cost?", 1, "-m benchmarks.rates gym", "build,gym"),
    Program(
        *("creep", "How fast does a joint held in MuJoCo creep, and what does a step cost?", 0.5),
        *("-m benchmarks.rates creep", "build,mujoco"),
    ),
    Program(
        *("web", "What does a step cost in the page of `dualcam view`?", 0.2),
        "-m benchmarks.rates web",
        tools=("Node.js",),
    ),
    Program(
        *("view", "How fast does the page of `dualcam view` open and draw?", 1),
        *("-m benchmarks.rates view", "test", ("Chromium",)),
    ),
    Program(
        *("rate", "How many runs a second does a parameter study make?", 1),
        *("-m benchmarks.study_rate", "build,study"),
    ),
    Program(
        *("studygrowth", "How does a study grow with its workers, and where does that end?", 4),
        *("-m benchmarks.study_growth", "build,study"),
    ),
    Program(
        *("firstuse", "What does a new user of the wheel in dist/ wait for?", 2),
        "-m benchmarks.first_use",
    ),
    Program("coupling", "What do derivatives gain in a coupling?", 0.2, "-m benchmarks.coupling"),
    Program("ownplant", "Which coupling with a motor is stable?", 0.2, "-m benchmarks.coupling.own_plant"),
    Program("stickslip", "How exact are limit cycles of stick-slip?", 0.3, "-m benchmarks.stick_slip"),
)
VERIFICATION = (
    Program("hunting", "Is it predicted where a PI position loop hunts?", 1, "-m verification.hunting"),
    Program("all", "Do the FMUs build for all platforms?", 2, f"{BUILD} all", build=None),
    Program(
        *("stress", "How far can each parameter be taken?", 15),
        *("-m verification.stress", "test"),
    ),
    Program(
        *("fuzz", "Which mechanism breaks a law, which text breaks a reader?", 60),
        *(f"-m pytest {LONG}", "test"),
    ),
    Program(
        *("fuzz-record", "The same from a given --seed N, with a row of results", 60),
        *(f"-m verification.fuzz_runs {LONG}", "test"),
    ),
    Program(
        *("fuzz-calls", "Which calls in any order break the C code? (libFuzzer)", 8),
        *("tests/native/fuzz/run.py", "test,fuzz"),
    ),
    Program(
        *("hash", "Do all platforms and compilers compute the same bits?", 5),
        *("-m verification.trajectory_hash", "test"),
        build="all",
    ),
    Program(
        *("elementary", "How exact and fast are exp, sin and the like, beside the C library's?", 6),
        *("-m verification.elementary", "bench"),
    ),
    Program(
        *("compare", "Do the FMUs compute the same bits as those of another build? DIRECTORY", 2),
        "-m verification.compare_builds",
    ),
    Program(
        *("endurance", "Does memory grow over 10^6 lives, or an error over 10^8 steps?", 2),
        *("-m verification.endurance", "bench"),
    ),
    Program(
        *("masters", "Do other masters agree with FMPy? Writes docs/masters.md", 5),
        "-m verification.masters.run",
    ),
    Program(
        *("mutants", "Which of 400 small mistakes in the C code do the tests notice?", 20),
        *("-m verification.strength.mutants", "strength"),
    ),
    Program(
        *("coverage", "Which branches of the C code do the tests take?", 30),
        *("-m verification.strength.coverage", "strength"),
    ),
)
# What makes the published figures anew: name, arguments, minutes. Cheap ones first, the pages last.
REFRESH = (
    ("paper", "", 0.1),
    ("coupling", "", 0.2),
    ("ownplant", "", 0.2),
    ("web", "", 0.2),
    ("stickslip", "", 0.3),
    ("creep", "", 0.5),
    ("friction", "", 0.5),
    ("gym", "--rounds 3", 0.5),
    ("study", "", 0.5),
    ("rate", "--rounds 9", 0.5),
    ("hunting", "", 1),
    ("view", "", 1),
    ("fleet", "", 2),
    ("firstuse", "", 2),
    ("endurance", "", 2),
    ("studygrowth", "--rounds 3", 2),
    ("elementary", "--rounds 11", 2),
    ("ssp", "", 3),
    ("platforms", "--rounds 3", 3),
    ("hash", "", 5),
    ("masters", "", 5),
    ("bench", "", 7),
    ("stress", "--fuzz 1000", 7),
    ("figures", "", 0.3),
)
# These judge the tests, or take long for other reasons: `./build.sh run refresh --long` runs them too.
LONG_REFRESH = (
    ("sampling", "--table benchmarks/results/sampling_elbow.csv --picture docs/sampling_elbow.png", 10),
    ("mutants", "", 20),
    ("coverage", "", 30),
    ("fuzz-record", "--seed 1", 60),
    ("figures", "", 0.3),
)
TABLE = {
    "Examples": EXAMPLES,
    "Reports": REPORTS,
    "Pages": PAGES,
    "Benchmarks": BENCHMARKS,
    "Verification": VERIFICATION,
}
PROGRAMS = {program.name: program for programs in TABLE.values() for program in programs}


def row(name: str, question: str, minutes: str, needs: str) -> str:
    return f"  {name:13} {question:75} {minutes:>7}  {needs}".rstrip()


def table() -> str:
    head = row("name", "question or work", "minutes", "extra packages")
    lines = ["./build.sh run NAME [arguments]", "", head]
    for title, programs in TABLE.items():
        lines += ["", title, *(row(p.name, p.question, f"{p.minutes:g}", p.needs) for p in programs)]
    return "\n".join(lines)


def find(name: str) -> Program:
    """SystemExit with the nearest name if there is no such program."""
    if name in PROGRAMS:
        return PROGRAMS[name]
    near = difflib.get_close_matches(name, PROGRAMS, 1, 0.0)[0]
    raise SystemExit(f"build.sh run: no program {name!r}; the nearest is {near}. `./build.sh run` lists all.")


def missing_tools(program: Program) -> list[str]:
    """A sentence for each program of the system that is not installed."""
    return [
        f"build.sh run {program.name}: {tool} is missing: install package {TOOLS[tool][1]} (Debian, Ubuntu)"
        for tool in program.tools
        if not any(shutil.which(name) for name in TOOLS[tool][0])
    ]


def commands_of(program: Program, arguments: Sequence[str]) -> list[list[str]]:
    """Words for Python: the build, what comes before, the command itself."""
    build = [] if program.build is None else [f"{BUILD} {program.build}"]
    command = [*program.command.split(), *(arguments or program.arguments.split())]
    return [*(words.split() for words in (*build, *program.before)), command]


def run(program: Program, arguments: Sequence[str]) -> int:
    """The exit code of the first command that fails, or of the last one."""
    if missing := missing_tools(program):
        raise SystemExit("\n".join(missing))
    for words in commands_of(program, arguments):
        print(f"== python {' '.join(words)}", flush=True)
        if code := subprocess.run([sys.executable, *words], cwd=ROOT).returncode:
            return code
    return 0


def run_or_say(name: str, arguments: Sequence[str]) -> int:
    """As run(). What keeps a program from running is printed."""
    try:
        return run(PROGRAMS[name], arguments)
    except SystemExit as problem:
        print(problem)
        return 1


def refresh(steps: Sequence[tuple[str, str, float]]) -> int:
    """Runs all steps, also after one that fails. The last lines are those that failed."""
    failed, begun = [], time.monotonic()
    print(f"{len(steps)} programs, about {sum(minutes for *_, minutes in steps):.0f} minutes on two cores")
    for number, (name, arguments, minutes) in enumerate(steps, 1):
        since = time.monotonic()
        print(f"[{number}/{len(steps)}] {name} {arguments}: about {minutes:g} min", flush=True)
        code = run_or_say(name, arguments.split())
        now = time.monotonic()
        outcome = f"FAILED with exit code {code}" if code else "done"
        times = f"{(now - since) / 60:.1f} min, {(now - begun) / 60:.1f} min since the start"
        print(f"[{number}/{len(steps)}] {name}: {outcome}, {times}", flush=True)
        failed += [f"  {name}: exit code {code}"] if code else []
    print("\n".join(["These failed:", *failed]) if failed else "All figures are new.")
    return int(bool(failed))


def main(words: Sequence[str]) -> int:
    """No words: prints the table. `--extras NAME`: prints the extras of a program. `--refresh`: the program
    refresh. Else runs a program."""
    if not words:
        print(table())
        return 0
    if words[0] == "--extras":
        print(find(words[1]).extras)
        return 0
    if words[0] == "--refresh":
        unknown = set(words) - {"--refresh", "--long"}
        if unknown:
            print(f"refresh: {', '.join(sorted(unknown))}: allowed is --long")
            return 2
        return refresh((*REFRESH[:-1], *LONG_REFRESH) if "--long" in words else REFRESH)
    return run(find(words[0]), words[1:])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
