#!/usr/bin/env bash
# The one entry: sets up .venv, builds the FMU, then does what it was asked. See `./build.sh help`.
set -euo pipefail

usage() {
    cat <<'TEXT'
usage: ./build.sh [command] [arguments]

  (none)  build the FMUs for FMI 2.0 and FMI 3.0 and run the first example, a robot's elbow
  test    build, then run the tests of the default tier, tests/default_tier.txt: three minutes
          test all    all tests, with FMUs for all platforms; what continuous integration runs
          test long   the tests that take minutes each
          test ...    arguments of pytest, such as tests/test_design.py or -k groove
  check   format, lint and types; static analysis of the C code (ten minutes); sanitizers and valgrind
  wheel   build for all platforms, then pack the Python package and all FMUs into one wheel in dist/
  docs    build the documentation site in build/docs and check its links; `docs links`: also those to other sites
  run     list all programs: examples, reports, figures, benchmarks, verification
          run NAME [arguments]   build, then run one of them
  help    this text

"build" makes the FMUs for this machine, unless they are up to date. On a machine without bash:
python -m pip install -e ".[build]" and python fmu_src/tools/build_fmu.py; for a wheel: python -m pip wheel --no-deps
--wheel-dir dist .

Needs bash, Python >= 3.11 with venv (or virtualenv), access to PyPI and, for three.js in the page of `dualcam view`,
to the npm registry. The first command makes the virtual environment .venv and installs there the packages that
pyproject.toml names, the C compiler among them (about 1 GB). Commands that need more packages add them there.
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

# run_tests [PYTEST ARGUMENTS]: builds for this machine, and becomes pytest in as many processes as processors.
run_tests() {
    install_dependencies '.[test,study,docs]'
    build
    # Else all processes, and each program that a test starts, would translate the sources again.
    unset PYTHONDONTWRITEBYTECODE
    exec .venv/bin/python -m pytest -n auto --dist worksteal "$@"
}

run_checks() {
    install_dependencies '.[check]'
    say "clang-format"
    find fmu_src dualcam -name '*.[ch]' -print0 | xargs -0 .venv/bin/clang-format --dry-run -Werror
    say "ruff"
    .venv/bin/python -m ruff check .
    say "mypy"
    .venv/bin/python -m mypy
    say "static analysis of the C code"
    .venv/bin/python fmu_src/tools/static_analysis.py
    build
    say "sanitizers and valgrind"
    exec .venv/bin/python -m pytest tests/test_native.py -m "long or not long" -v -rs "$@"
}

make_wheel() {
    install_dependencies '.[build]'
    build all # pip would be silent for these minutes
    rm -f dist/dualcam-*.whl
    .venv/bin/python -m pip wheel --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir dist .
    say "dist: $(cd dist && ls dualcam-*.whl)"
}

# run_program [NAME [ARGUMENTS]]: installs what the program needs and becomes programs.py, which has the table.
run_program() {
    local extras
    .venv/bin/python -c '' >/dev/null 2>&1 || make_venv
    if [ $# -gt 0 ]; then
        extras=$(.venv/bin/python programs.py --extras "$1")
        install_dependencies ".[$extras]"
    fi
    exec .venv/bin/python programs.py "$@"
}

command=${1-}
[ $# -eq 0 ] || shift
cd "$(repository)"
export ZIG_GLOBAL_CACHE_DIR="${ZIG_GLOBAL_CACHE_DIR:-$PWD/build/zig-cache}"
export ZIG_LOCAL_CACHE_DIR="${ZIG_LOCAL_CACHE_DIR:-$PWD/build/zig-cache}"

case $command in
    '') run_program joint ;;
    test)
        case ${1-} in
            '') run_tests -m "not long and not platforms" @tests/default_tier.txt ;;
            all)
                install_dependencies '.[test,study,docs]'
                build all
                run_tests "${@:2}"
                ;;
            long) run_tests -m long "${@:2}" ;;
            *) run_tests "$@" ;;
        esac
        ;;
    check) run_checks "$@" ;;
    wheel) make_wheel ;;
    docs)
        install_dependencies '.[docs]'
        build
        exec .venv/bin/python docs/tools/build_site.py "$@"
        ;;
    run) run_program "$@" ;;
    help | -h | --help) usage ;;
    *)
        printf 'build.sh: unknown command: %s\n\n' "$command" >&2
        usage >&2
        exit 2
        ;;
esac
