"""The command line: `dualcam study plan.toml`, or `python -m dualcam study plan.toml`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from rich.console import Console

from dualcam.fmu import FmuError
from dualcam.study import command

INTERRUPTED = 130  # what shells say of Ctrl-C


def main(words: Sequence[str] | None = None) -> int:
    """The command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="dualcam", description="Dual cylindrical cam: its FMUs from the command line"
    )
    commands = parser.add_subparsers(dest="command", required=True)
    command.add_arguments(
        commands.add_parser("study", help="many runs of an FMU, by a plan in TOML, and plots")
    )
    arguments = parser.parse_args(words)
    errors = Console(stderr=True)
    try:
        command.run(arguments, Console())
    except FmuError as error:
        errors.print(f"dualcam: {error}", highlight=False, markup=False, soft_wrap=True)
        return 1
    except KeyboardInterrupt:
        errors.print("dualcam: interrupted; what is written is kept: the same command goes on from there")
        return INTERRUPTED
    return 0


if __name__ == "__main__":
    sys.exit(main())
