#!/usr/bin/env bash
# The one entry: sets up .venv, builds the FMU, then does what it was asked. See `./build.sh help`.
set -euo pipefail

usage() {
    cat <<'TEXT'
usage: ./build.sh [command] [arguments]

  (none)   build the FMUs for FMI 2.0 and FMI 3.0, then run system_examples/robot_joint.py
  knee     build, then run system_examples/prosthetic_knee.py (seconds); arguments go to it
  door     build, then run system_examples/car_door.py (seconds); arguments go to it
  clamp    build, then run system_examples/spring_clamp.py (seconds); arguments go to it
  plan     build, then run system_examples/planned_elbow.py (seconds; CasADi); arguments go to it
  elbow    build, then run system_examples/elbow_torque.py (half a minute; JAX); arguments go to it
  gains    build, then run system_examples/controller_gains.py (some minutes): 10^5 closed loops over a fleet, draws
           build/controller_gains.png; arguments go to it
  mujoco   build, then run system_examples/mujoco_elbow.py (seconds; MuJoCo); arguments go to it
  sampling build, then run system_examples/sampling_elbow.py (ten minutes): a sampling controller (MPPI) beside the LQI
           over 200 payloads and frictions; draws build/sampling_elbow.png; arguments go to it
  design   build, then run system_examples/designed_groove.py (seconds); arguments go to it
  report   build, then write a long report: robot_joint, prosthetic_knee or car_door of case_studies/ (seconds);
           further arguments go to it
  all      build all FMUs for Linux (x86-64, aarch64), Windows (64 and 32 bits) and macOS (x86-64, arm64);
           those of FMI 3.0 also as WebAssembly
  cad      install the CAD kernel OpenCASCADE (400 MB), draw docs/cut_grooves.png with solids of cams, then test the
           STEP files (a minute); arguments go to pytest
  wheel    as `all`, then pack the Python package and all FMUs into one wheel in dist/, which needs no compiler
  test     build, then run the tests; arguments go to pytest; without arguments the build is for all platforms
  fuzz     build, then look for mechanisms and inputs that break a law, and for texts that break a reader (an hour);
           arguments go to pytest. `fuzz calls`: libFuzzer calls the C code of both standards in any order (eight
           minutes; --minutes N for each of four programs); `fuzz calls --coverage`: the code that its inputs reach.
           `fuzz cuts`: counts random scenes whose answer depends on how an interval is cut into steps (ten minutes;
           --minutes N), into tests/verification/results/cut_scan.csv. `fuzz record --seed N`: the first form, with a row in
           tests/verification/results/fuzz_runs.csv
  bench    build, then run cost, loop, skipping, worst, growth, precision (about seven minutes), which writes benchmarks/results/ and
           docs/performance.md; --quick: few rounds, into build/quick; names of some of them: these only
  cost     build, then run benchmarks.step_cost (half a minute): the cost of a step, and its limit
  loop     build, then run benchmarks.loop_cost (seconds): a control loop in Python
  fleet    build, then run benchmarks.fleet (two minutes): a step of a fleet beside loops in C and in Python
  gym      build, then run benchmarks.gym_rate (a minute): steps per second of the environments of dualcam.gym
  creep    build, then run benchmarks.mujoco_creep (half a minute): creep and cost of a joint held in MuJoCo, by its
           own friction and by the cam
  skipping build, then run benchmarks.skipping (seconds): the cost of each part where it is absent
  worst    build, then run benchmarks.worst_step (two minutes): the worst of a million steps
  growth   build, then run benchmarks.growth (a minute): many instances, steps, table points, threads
  precision build, then run benchmarks.work_precision (four minutes): run time against error beside other
           solvers; arguments go to it, as to each of these
  endurance build, then run verification.endurance (two minutes): memory over 10^6 instances, drift over 10^8 steps
  friction build, then run benchmarks.friction_cost (half a minute): friction that depends on the speed, against Coulomb's;
           needs valgrind
  elementary  build, then run benchmarks.elementary (six minutes): error and cost of exp, sin and the like, beside the C
           library's; needs valgrind for instructions
  hash     build for all platforms, then run the same scenes on all platforms and compilers of this machine and compare
           one hash of all bits (some minutes), tests/support/trajectory_hash.py; --quick: native and WebAssembly
  platforms  build for all platforms, then run benchmarks.platform_cost (four minutes): a step of the Windows binary (wine)
           and of the aarch64 binary (qemu) beside Linux x86-64
  compare  DIRECTORY build, then compare these FMUs with those of another build, bit for bit (two minutes; --quick:
           15 seconds), verification.builds
  stress   build, then run verification.stress (a quarter of an hour), which writes docs/stress.md; arguments go to it
  paper    build, then write docs/paper.md and its pictures (seconds), case_studies/paper
  figures  draw the figures of docs/mechanism.md, docs/architecture.md and docs/design-quantities.md, write
           docs/variables.md and the keys of docs/design-file.md and docs/study-plan.md (seconds);
           docs/figures/mechanism.py, docs/figures/architecture.py, docs/figures/design_quantities.py, docs/tools/variables_page.py,
           docs/tools/design_file_page.py, docs/tools/study_plan_page.py; arguments go to all
  coupling build, then run benchmarks.coupling (seconds), which draws docs/coupling.png; arguments go to it
  firstuse build, then run benchmarks.first_use (two minutes): a new environment with the wheel of `wheel`, times, sizes
  ownplant build, then run benchmarks.own_plant (seconds): a motor in Python on the FMU, which coupling is stable;
           draws docs/own_plant.png; arguments go to it
  stickslip build, then run benchmarks.stick_slip (seconds): limit cycles behind a soft shaft; draws
           docs/stick_slip.png; arguments go to it
  hunting  build, then run benchmarks.hunting (a minute): where a PI position loop hunts; draws docs/hunting.png;
           arguments go to it
  study    build, then run the parameter studies system_examples/study/*.toml into build/study (half a minute), which
           draws docs/study.png; arguments go to `dualcam study`
  rate     build, then run benchmarks.study_rate (a minute); arguments go to it
  studygrowth  build, then run benchmarks.study_growth (some minutes): a study over its workers; arguments go to it
  view     build, then run benchmarks.view_page (a minute): how fast the page of `dualcam view` opens and draws; needs
           Chromium
  web      build, then run benchmarks.web_step (seconds): what a step costs in the engine of the page; needs node
  masters  build, then play the same scenes in other masters (ecos, libcosim, FMI4j, Maestro, fmi-sim), which are
           installed into build/masters, and run checkers; writes docs/masters.md (some minutes the first time)
  mutants  400 small mistakes in a copy of the C code, and which of them the tests notice (20 minutes); writes
           tests/verification/results/mutants.csv; arguments go to verification.strength.mutants
  coverage the branches of the C code that the tests take, in a copy (half an hour; --again: what has changed); writes
           tests/verification/results/coverage.csv; arguments go to verification.strength.coverage
  ssp      build, then make SSP packages of the examples and run them in ecos and libcosim; writes docs/ssp.md
  docs     build, then make the documentation site in build/docs (half a minute) and check its links; `docs links`
           also checks the links to other sites
  check    format of the C code (clang-format), lint (ruff) and types (mypy) of the Python code; static analysis of the
           C code (clang-tidy, cppcheck, gcc -fanalyzer; ten minutes); then the C code under sanitizers and valgrind
  help     this text

"build" makes the FMUs for this machine, unless they are up to date. On a machine without bash:
python -m pip install -e ".[build]" and python fmu_src/tools/build_fmu.py; for a wheel: python -m pip wheel --no-deps
--wheel-dir dist .

Needs bash, Python >= 3.11 with venv (or virtualenv), access to PyPI and, for three.js in the page of `dualcam view`,
to the npm registry. The first command makes the virtual environment .venv and installs there the packages that
pyproject.toml names, the C compiler among them (about 1 GB); commands that need more packages add them there. `masters` installs other masters and their packages into
build/masters. The tests use gcc and valgrind when present, `masters` uses Java and Rust.
Nothing outside this directory is written, apart from the caches of pip and cargo.
TEXT
}

say() { printf '== %s\n' "$*"; }
die() { printf 'build.sh: %s\n' "$*" >&2; exit 1; }

repository() { # the directory of this file, also when it was called through symbolic links
    local self=${BASH_SOURCE[0]} link
    while [ -h "$self" ]; do
        link=$(readlink "$self")
        case $link in
            /*) self=$link ;;
            *) self=$(dirname "$self")/$link ;;
        esac
    done
    cd -P "$(dirname "$self")" && pwd
}

make_venv() {
    local candidate found=""
    rm -rf .venv
    for candidate in python3.14 python3.13 python3.12 python3.11 python3 python; do
        # Run it rather than look for it: a version manager's stub exists but may not work.
        "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 || continue
        found="$found $candidate"
        say "make .venv with $candidate"
        if "$candidate" -m venv .venv >/dev/null 2>&1 || "$candidate" -m virtualenv .venv >/dev/null 2>&1; then
            return
        fi
        rm -rf .venv
    done
    [ -n "$found" ] || die "no Python >= 3.11 found (tried python3.14 ... python3.11, python3, python)"
    die "found$found, but none can make a virtual environment: install its venv package (Debian and" \
        "Ubuntu: apt install python3-venv) or virtualenv"
}

# install_dependencies REQUIREMENT: pip-installs ".[build]" or ".[test]", only when pyproject.toml, the place
# of the repository or the interpreter is not what it was at the last installation.
install_dependencies() {
    local requirement=$1 name stamp
    .venv/bin/python -c '' >/dev/null 2>&1 || make_venv
    name=.venv/installed${requirement//[^a-z]/-}
    stamp="$(cksum <pyproject.toml) $PWD $(.venv/bin/python -V)"
    [ -f "$name" ] && [ "$(cat "$name")" = "$stamp" ] && return
    say "install dependencies of pyproject.toml into .venv (about 1 GB on disk, mostly the C compiler)"
    .venv/bin/python -m pip install --disable-pip-version-check -e "$requirement"
    printf '%s\n' "$stamp" >"$name"
}

build() { .venv/bin/python fmu_src/tools/build_fmu.py "$@"; }

# run_program REQUIREMENT [-m] PROGRAM [ARGUMENTS]: installs, builds, and becomes that Python program.
run_program() {
    install_dependencies "$1"
    shift
    build
    say "run $*"
    exec .venv/bin/python "$@"
}

command=${1-example}
[ $# -eq 0 ] || shift
cd "$(repository)"
export ZIG_GLOBAL_CACHE_DIR="${ZIG_GLOBAL_CACHE_DIR:-$PWD/build/zig-cache}"
export ZIG_LOCAL_CACHE_DIR="${ZIG_LOCAL_CACHE_DIR:-$PWD/build/zig-cache}"
# Modules that are no part of the package: how FMUs are built, other masters, the tests' reference solutions.
export PYTHONPATH="$PWD/fmu_src/tools:$PWD/masters:$PWD/tests:$PWD/tests/support"

case $command in
    example) run_program '.[build]' system_examples/robot_joint.py "$@" ;;
    knee) run_program '.[build]' system_examples/prosthetic_knee.py "$@" ;;
    door) run_program '.[build]' system_examples/car_door.py "$@" ;;
    clamp) run_program '.[build]' system_examples/spring_clamp.py "$@" ;;
    plan) run_program '.[build,casadi]' system_examples/planned_elbow.py "$@" ;;
    mujoco) run_program '.[build,mujoco]' system_examples/mujoco_elbow.py "$@" ;;
    elbow) run_program '.[build,jax]' system_examples/elbow_torque.py "$@" ;;
    gains) run_program '.[build]' system_examples/controller_gains.py "$@" ;;
    sampling) run_program '.[build]' system_examples/sampling_elbow.py "$@" ;;
    design) run_program '.[build]' system_examples/designed_groove.py "$@" ;;
    ssp) run_program '.[build]' -m system_examples.ssp "$@" ;;
    report)
        case ${1-} in
            robot_joint | prosthetic_knee | car_door) ;;
            *) die "report of '${1-}': allowed are robot_joint, prosthetic_knee and car_door" ;;
        esac
        run_program '.[build]' -m "case_studies.$1" "${@:2}"
        ;;
    test)
        if [ $# -eq 0 ]; then
            install_dependencies '.[test,study,docs]'
            build all
        fi
        # Else both processes, and each program that a test starts, would translate the sources again.
        unset PYTHONDONTWRITEBYTECODE
        # The order of the files is that of tests/support/longest_files.py.
        run_program '.[test,study,docs]' -m pytest -n 2 --dist loadfile --no-loadscope-reorder "$@"
        ;;
    fuzz)
        if [ "${1-}" = calls ]; then
            run_program '.[test,fuzz]' tests/native/fuzz/run.py "${@:2}"
        elif [ "${1-}" = cuts ]; then
            run_program '.[test]' -m verification.cut_scan "${@:2}"
        fi
        long=(tests/test_properties.py tests/test_reader_mutations.py tests/test_extreme_values.py
            --hypothesis-profile long -o faulthandler_timeout=0)
        if [ "${1-}" = record ]; then
            run_program '.[test]' -m verification.fuzz_runs "${long[@]}" "${@:2}"
        fi
        run_program '.[test]' -m pytest "${long[@]}" "$@"
        ;;
    bench) run_program '.[bench]' -m benchmarks.bench "$@" ;;
    cost) run_program '.[build]' -m benchmarks.step_cost "$@" ;;
    friction) run_program '.[build]' -m benchmarks.friction_cost "$@" ;;
    worst) run_program '.[build]' -m benchmarks.worst_step "$@" ;;
    precision) run_program '.[bench]' -m benchmarks.work_precision "$@" ;;
    skipping) run_program '.[build]' -m benchmarks.skipping "$@" ;;
    endurance) run_program '.[bench]' -m verification.endurance "$@" ;;
    growth) run_program '.[build]' -m benchmarks.growth "$@" ;;
    fleet) run_program '.[build]' -m benchmarks.fleet "$@" ;;
    gym) run_program '.[build,gym]' -m benchmarks.gym_rate "$@" ;;
    creep) run_program '.[build,mujoco]' -m benchmarks.mujoco_creep "$@" ;;
    loop) run_program '.[build]' -m benchmarks.loop_cost "$@" ;;
    paper) run_program '.[build]' -m case_studies.paper "$@" ;;
    coupling) run_program '.[build]' -m benchmarks.coupling "$@" ;;
    firstuse) run_program '.[build]' -m benchmarks.first_use "$@" ;;
    ownplant) run_program '.[build]' -m benchmarks.own_plant "$@" ;;
    stickslip) run_program '.[build]' -m benchmarks.stick_slip "$@" ;;
    hunting) run_program '.[build]' -m benchmarks.hunting "$@" ;;
    view) run_program '.[test]' -m benchmarks.view_page "$@" ;;
    web) run_program '.[build]' -m benchmarks.web_step "$@" ;;
    rate) run_program '.[build,study]' -m benchmarks.study_rate "$@" ;;
    studygrowth) run_program '.[build,study]' -m benchmarks.study_growth "$@" ;;
    study)
        [ $# -gt 0 ] || set -- system_examples/study/*.toml --out build/study --figure docs/study.png
        run_program '.[build,study]' -m dualcam study "$@"
        ;;
    elementary) run_program '.[bench]' -m benchmarks.elementary "$@" ;;
    hash)
        install_dependencies '.[test]'
        [ "${1-}" = --quick ] || build all
        run_program '.[test]' -m verification.trajectory_hash "$@"
        ;;
    platforms)
        install_dependencies '.[test]'
        build all
        run_program '.[test]' -m benchmarks.platform_cost "$@"
        ;;
    compare) run_program '.[build]' -m verification.builds "$@" ;;
    mutants | coverage) run_program '.[strength]' -m "verification.strength.$command" "$@" ;;
    stress) run_program '.[test]' -m verification.stress "$@" ;;
    figures)
        install_dependencies '.[build]'
        .venv/bin/python docs/figures/mechanism.py "$@"
        .venv/bin/python docs/figures/architecture.py "$@"
        .venv/bin/python docs/figures/design_quantities.py "$@"
        .venv/bin/python docs/tools/variables_page.py "$@"
        .venv/bin/python docs/tools/reliability_page.py
        .venv/bin/python docs/tools/design_file_page.py "$@"
        .venv/bin/python docs/tools/study_plan_page.py "$@"
        ;;
    cad)
        install_dependencies '.[test,cad]'
        .venv/bin/python docs/figures/groove_cut.py
        run_program '.[test,cad]' -m pytest tests/test_cam_solid.py "$@"
        ;;
    masters) run_program '.[build]' masters/run.py "$@" ;;
    docs) run_program '.[docs]' docs/tools/build_site.py "$@" ;;
    all)
        install_dependencies '.[build]'
        build all
        ;;
    wheel)
        install_dependencies '.[build]'
        build all # pip would be silent for these minutes
        rm -f dist/dualcam-*.whl
        .venv/bin/python -m pip wheel --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir dist .
        say "dist: $(cd dist && ls dualcam-*.whl)"
        ;;
    check)
        install_dependencies '.[check]'
        say "clang-format"
        find fmu_src -name '*.[ch]' -print0 | xargs -0 .venv/bin/clang-format --dry-run -Werror
        say "ruff"
        .venv/bin/python -m ruff check .
        say "mypy"
        .venv/bin/python -m mypy
        say "static analysis of the C code"
        .venv/bin/python fmu_src/tools/static_analysis.py
        build
        say "sanitizers and valgrind"
        exec .venv/bin/python -m pytest tests/test_native.py -m "long or not long" -v -rs "$@"
        ;;
    help | -h | --help)
        usage
        ;;
    *)
        printf 'build.sh: unknown command: %s\n\n' "$command" >&2
        usage >&2
        exit 2
        ;;
esac
