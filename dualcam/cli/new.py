"""`dualcam new`: a design file to start from."""

from pathlib import Path

import click

from dualcam.cli.options import FILE, as_json, example
from dualcam.cli.output import print_json, refuse_to_overwrite, say

TEMPLATES = {
    "robot": "elbow of a robot: the spring carries a payload",
    "knee": "prosthetic knee: the spring takes the load of walking",
    "door": "door of a car: the spring opens the door, friction holds the door",
    "minimal": "the fewest lines: two helices and a linear spring",
}


@click.command(epilog=example("dualcam new my.toml --from robot", "dualcam check my.toml"))
@click.argument("path", type=FILE, metavar="DESIGN.toml")
@click.option(
    "--from",
    "template",
    type=click.Choice(list(TEMPLATES)),
    default="minimal",
    show_default=True,
    help="Which design to start from.",
)
@click.option("--force", is_flag=True, help="Replace an existing file.")
@as_json
def command(path: Path, template: str, force: bool, as_json: bool) -> None:
    """Write a commented design file.

    Each key of the file is a parameter of the FMU, with its unit in a comment.
    """
    from dualcam.design_file import write_template

    refuse_to_overwrite(path, force)
    written = write_template(template, path, overwrite=force)
    if as_json:
        print_json({"written": written})
        return
    say(f"{written} written: {TEMPLATES[template]}.")
    say(f"Change the numbers, then:\n  dualcam check {path}")
    say(f"  dualcam simulate {path} -o out.csv --plot out.png")
