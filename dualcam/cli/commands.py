"""The group of all commands. A command's module is imported when that command is asked for."""

import difflib
import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from io import TextIOWrapper

import click

from dualcam.errors import DualcamError

DONE, REFUSED, WRONG_USE, INTERRUPTED = 0, 1, 2, 130

# Command -> what it does, in the words of `dualcam --help`. The module has the command's name.
COMMANDS = {
    "new": "Write a commented design file to start from.",
    "check": "Say whether a design works, and what to change.",
    "info": "List the variables of an FMU.",
    "band": "Show the torque band over the angle, and the efficiency.",
    "simulate": "Run the scenario of a design file.",
    "export": "Make an FMU with an own name and own start values.",
    "report": "Write one HTML page about a design.",
    "view": "Write one HTML page in which the mechanism moves.",
    "identify": "Fit friction, spring and losses to a recording.",
    "study": "Make many runs by a plan, and draw the results.",
    "design": "Find the groove that makes a wanted torque; cut grooves (CSV, DXF, STEP).",
    "ssp": "Make an SSP package with the FMU of a design.",
}


class CommandGroup(click.Group):
    """Knows all commands by name and imports none of them for `--help`."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        found: click.Command = import_module(f"dualcam.cli.{cmd_name}").command
        return found

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            near = difflib.get_close_matches(args[0], COMMANDS, n=1)
            guess = f" Did you mean {near[0]!r}?" if near else ""
            ctx.fail(f"No such command {args[0]!r}.{guess} Commands: {', '.join(COMMANDS)}.")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(
    cls=CommandGroup,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Begin: dualcam new my.toml --from robot, then dualcam check my.toml. "
    "`dualcam COMMAND --help` shows options and an example.",
)
@click.version_option(package_name="dualcam", prog_name="dualcam")
def group() -> None:
    """Dual cylindrical cam: from a design file to a simulation, a report and an FMU."""


def main(words: Sequence[str] | None = None) -> int:
    """Run a command; `words` None: those of the process. The result is the exit code: 0 done, and for `check`
    the design works; 1 the design or the data are refused; 2 wrong use; 130 interrupted."""
    given = list(sys.argv[1:] if words is None else words)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # a name that the terminal cannot show is no reason to stop
            stream.reconfigure(errors="backslashreplace")
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        try:
            code = group.main(args=given, prog_name="dualcam", standalone_mode=False)
        except click.ClickException as error:
            error.show()
            return error.exit_code
        except (click.Abort, KeyboardInterrupt):
            click.echo("dualcam: interrupted; finished files are kept", err=True)
            return INTERRUPTED
        except (ValueError, OSError) as error:
            return _refuse(error, "--json" in given)
    return code if isinstance(code, int) else DONE


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    from dualcam.cli.output import warn  # here, because --help needs no JSON

    warn(str(message))


def _refuse(error: Exception, as_json: bool) -> int:
    """The message of an error of this package, or of the system. Any other error is a fault: it is raised."""
    if not isinstance(error, DualcamError | OSError):
        raise error
    text = str(error) if isinstance(error, DualcamError) else _of_the_system(error)
    if as_json:
        from dualcam.cli.output import print_json, refusal_for_json

        print_json(refusal_for_json(error) | {"error": text})
    else:
        click.echo(f"dualcam: {text}", err=True)
    return REFUSED


def _of_the_system(error: OSError) -> str:
    """The file that the system refuses, and the system's reason."""
    if error.filename is None:
        return str(error)
    return (
        f"{error.filename} cannot be opened: {error.strerror}. Give another folder, or check the rights of"
        " this one"
    )
