"""`dualcam design --export`: the grooves as files for a workshop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from dualcam.cli.options import FILE
from dualcam.cli.output import refuse_to_overwrite, say
from dualcam.errors import DesignError

if TYPE_CHECKING:
    from dualcam.design import Mechanism, Pin
    from dualcam.design_file import DesignFile

Command = TypeVar("Command", bound=Callable[..., Any])
SIZES = ("depth", "outer_diameter", "bore_diameter", "length")  # of a solid
SOLID_ENDINGS = (".step", ".stp")


class Length(click.ParamType):
    """A length as a text with its unit, or a number in m."""

    name = "length"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:  # noqa: ANN401
        """The length [m]."""
        from dualcam.common.written_units import quantity

        name = param.opts[0] if param else "length"
        try:
            return float(value)
        except ValueError:
            pass
        try:
            return quantity(value, "m")
        except DesignError as error:
            raise DesignError(f'{name} "{value}": {error}') from None


def _length(name: str, what: str) -> Callable[[Command], Command]:
    return click.option(name, type=Length(), metavar="LENGTH", help=what)


OPTIONS = (
    click.option(
        "--export",
        "exports",
        type=FILE,
        multiple=True,
        metavar="FILE",
        help="Write the grooves for a workshop: .csv points in space, .dxf unwrapped drawing, .step solid."
        " With both cams the files are FILE_cam1 and FILE_cam2. May be given several times.",
    ),
    click.option(
        "--cam",
        type=click.Choice(["1", "2", "both"]),
        default="both",
        show_default=True,
        help="Which cam --export writes.",
    ),
    _length(
        "--pin-diameter",
        "Diameter of the pin, such as '6 mm'; a number alone is in m. Default: that of [pin].",
    ),
    _length(
        "--run-out",
        "Length of groove beyond both stops, such as '3 mm': straight at the lead angle of the stop, also"
        " where the groove law goes on. Default: 0.",
    ),
    click.option(
        "--loading",
        type=click.Choice(["counterclockwise", "clockwise"]),
        default="counterclockwise",
        show_default=True,
        help="How cam 2 turns while the spring is loaded, seen from +z: counterclockwise makes groove 1"
        " right-handed.",
    ),
    _length(
        "--depth",
        "Of a solid: length of the pin on the flank, with its middle at the cam's radius. Default:"
        " pin.width.",
    ),
    _length("--outer-diameter", "Of a solid. Default: twice the radius, and the depth."),
    _length("--bore-diameter", "Of a solid. Default: that of the groove's floor: the groove is a slot."),
    _length("--length", "Of a solid, along the axis. Default: the groove and two pin diameters."),
)


def export_options(command: Command) -> Command:
    """The options of --export."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@dataclass(frozen=True)
class GrooveExport:
    """What --export and its options ask for. Lengths in m."""

    files: tuple[Path, ...]
    cams: tuple[int, ...]
    pin_diameter: float | None
    run_out: float | None
    loading: str
    depth: float | None
    outer_diameter: float | None
    bore_diameter: float | None
    length: float | None

    @classmethod
    def from_options(cls, exports: tuple[Path, ...], cam: str, **lengths: Any) -> GrooveExport:  # noqa: ANN401
        """Checks that the options go together; click.UsageError if they do not."""
        asked = cls(exports, (1, 2) if cam == "both" else (int(cam),), **lengths)
        solid = any(path.suffix.lower() in SOLID_ENDINGS for path in exports)
        for name, value in lengths.items():
            option = "--" + name.replace("_", "-")
            if name in SIZES and value is not None and not solid:
                raise click.UsageError(f"{option} is the size of a solid: give --export with a .step file")
            if name in ("pin_diameter", "run_out") and value is not None and not exports:
                raise click.UsageError(f"{option} belongs to --export: give --export with the name of a file")
        return asked

    @property
    def written_files(self) -> list[Path]:
        """Of all cams and --export."""
        from dualcam.design.cut.export import groove_files

        return [file for path in self.files for file in groove_files(path, self.cams).values()]

    def prepare(self, force: bool) -> None:
        """DualcamError if a file exists or its library is not installed."""
        from dualcam.design.cut.export import require_libraries

        for k, file in enumerate(self.written_files):
            refuse_to_overwrite(file, force)
            if file in self.written_files[:k]:
                raise DesignError(f"{file} is written twice: give each --export another name")
        for path in self.files:
            try:
                require_libraries(path)
            except DesignError as error:
                raise DesignError(f"--export {path}: {error}. No file is written") from None

    def write(self, design: DesignFile, mechanism: Mechanism) -> tuple[Path, ...]:
        """Write all files. A pin and a depth that are not given are those of the design file."""
        from dualcam.design import export_groove

        self._check_pin(mechanism)
        written: dict[Path, tuple[Path, ...]] = {}
        for path in sorted(self.files, key=lambda path: path.suffix.lower() not in SOLID_ENDINGS):
            written[path] = export_groove(  # solids first: they refuse most
                mechanism,
                path,
                self._pin_radius(design),
                cams=self.cams,
                run_out=self.run_out or 0.0,
                loading=self.loading,
                depth=self._depth(design) if path.suffix.lower() in SOLID_ENDINGS else None,
                outer_radius=_half(self.outer_diameter),
                bore_radius=_half(self.bore_diameter),
                length=self.length,
            )
        return tuple(file for path in self.files for file in written[path])

    def say_written(self, design: DesignFile, mechanism: Mechanism) -> None:
        """The files, and what a workshop must know besides."""
        from dualcam.design.cut.export import groove_files

        for path in self.files:
            for cam, file in groove_files(path, self.cams).items():
                content = f": {self._points_of(cam, mechanism)}" if file.suffix.lower() == ".csv" else ""
                say(f"{file} written{content}")
        grooves = " and ".join(f"groove {cam} is {self._hand(cam)}-handed" for cam in self.cams)
        say(
            f"{grooves}: cam 2 turns {self.loading} while the spring is loaded, seen from +z. Pin of diameter"
            f" {2e3 * self._pin_radius(design):.6g} mm, run-out {1e3 * (self.run_out or 0.0):.6g} mm"
        )

    def _points_of(self, cam: int, mechanism: Mechanism) -> str:
        """Which groove a table of points has: a reader of tables knows numbers only, no such words."""
        if mechanism.contacts == 1:
            count = "the only groove"
        else:
            count = "one of 2 equal grooves, the other one is at 180 deg"
        return f"cam {cam}, {self._hand(cam)}-handed, {count}"

    def _hand(self, cam: int) -> str:
        """Of the groove of cam 1 or 2, as in GrooveCut.hand."""
        return "right" if (self.loading == "counterclockwise") == (cam == 1) else "left"

    def _check_pin(self, mechanism: Mechanism) -> None:
        """DesignError, in the words of the option, for a pin that fits into no groove."""
        if self.pin_diameter is None:
            return
        cam = min(self.cams, key=lambda cam: mechanism.radius[cam - 1])
        given, greatest = self.pin_diameter, 2.0 * mechanism.radius[cam - 1]
        if 0.0 < given < greatest:
            return
        like = f'"{given:g} mm"' if 0.0 < 1e-3 * given < greatest else '"6 mm"'
        raise DesignError(
            f"--pin-diameter = {given:g} m: allowed is more than 0 and less than the diameter of cam {cam},"
            f" {1e3 * greatest:.6g} mm. A number without unit is in m: write for example"
            f" --pin-diameter {like}"
        )

    def _pin_radius(self, design: DesignFile) -> float:
        given = _half(self.pin_diameter)
        return _pin(design, "--pin-diameter '6 mm'").radius if given is None else given

    def _depth(self, design: DesignFile) -> float:
        option = "--depth '8 mm', the length of the pin on the flank"
        return _pin(design, option).width if self.depth is None else self.depth


def _pin(design: DesignFile, option: str) -> Pin:
    if design.pin is None:
        text = f"{design.path} has no [pin]: add radius and width of the pin there, or give {option}"
        raise DesignError(text)
    return design.pin


def _half(diameter: float | None) -> float | None:
    return None if diameter is None else 0.5 * diameter
