"""The command line `dualcam`: one module for each command.

main        runs a command and returns its exit code: 0 done, 1 refused, 2 wrong use
options     arguments and options that commands share
output      text for people, JSON for programs

May import every other room.
"""

from dualcam.cli.commands import main

__all__ = ["main"]
