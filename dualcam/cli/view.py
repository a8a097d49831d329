"""`dualcam view`: the page in which a design lives."""

from pathlib import Path

import click

from dualcam.cli.options import FILE, anyway, as_json, example, open_design, output_file
from dualcam.cli.output import print_json, require_folder_of, say


@click.command(epilog=example("dualcam view my.toml -o my.html", "dualcam view -o cam.html"))
@click.argument("design_file", type=FILE, metavar="[DESIGN.toml]", required=False)
@output_file("Name of the page (.html).")
@anyway
@as_json
def command(design_file: Path | None, output: Path, anyway: bool, as_json: bool) -> None:
    """Write one HTML page in which the mechanism moves: 3D, sliders, torque, forces, energy.

    The page runs the FMU's C code as WebAssembly. It opens from disk and needs no network. Without a design
    file the page shows the default mechanism.
    """
    from dualcam.view import write_view
    from dualcam.view.page import INVERSE

    require_folder_of(output)
    design = None if design_file is None else open_design(design_file, anyway, as_json)
    written = write_view(design, output)
    size = written.stat().st_size
    if as_json:
        print_json({"view": written, "bytes": size})
        return
    say(f"{written} written, {size / 1e6:.1f} MB: open the file in a browser")
    if design is not None and design.model == "inverse":
        say(INVERSE)
