"""Files of the package on a full disk (here a limit on the size of files): a message, and no half file."""

import errno
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from dualcam.cli import main
from dualcam.common.paths import whole_file, write_text
from dualcam.design import Table
from dualcam.design_file import write_template
from dualcam.errors import FileError
from dualcam.plots.design import save
from dualcam.simulation.run import simulate

resource = pytest.importorskip("resource", reason="this system has no limit on the size of files")
BINARY = 500_000  # bytes: more than an unpacked binary of an FMU, and less than an FMU or a page with a view


@contextmanager
def room_for(size: int):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.fixture
def design(tmp_path) -> Path:
    return write_template("minimal", tmp_path / "my.toml")


@pytest.mark.parametrize("command, name", [("view", "my.html"), ("export", "My.fmu")])
def test_a_command_says_what_to_do_and_leaves_nothing(design, tmp_path, capsys, command, name):
    path = tmp_path / "out" / name
    path.parent.mkdir()
    with room_for(BINARY):
        assert main([command, str(design), "-o", str(path)]) == 1
    message = capsys.readouterr().err
    assert name in message and "cannot be written" in message and "File too large" in message
    assert not list(path.parent.iterdir())


def test_each_kind_of_file_is_whole_or_as_it_was(design, tmp_path):
    from matplotlib.figure import Figure

    samples, picture = simulate(design), Figure()
    picture.add_subplot().imshow(np.random.default_rng(0).random((50, 50)))
    psi = np.linspace(0.0, 1.0, 2000)
    table = Table(0.02, psi, 0.02 * psi)
    for name, write in {
        "samples.csv": samples.write,
        "samples.parquet": samples.write,
        "picture.png": lambda path: save(picture, path),
        "groove.csv": table.write,
    }.items():
        path = tmp_path / name
        path.write_text("of before")
        with room_for(2000), pytest.raises(FileError, match="Make room") as caught:
            write(path)
        assert path.read_text() == "of before", name
        assert caught.value.errno == errno.EFBIG
        write(path)
        assert path.stat().st_size > 2000
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_links_and_devices_stay_what_they_are(tmp_path):
    (tmp_path / "there").mkdir()
    link = tmp_path / "link.txt"
    link.symlink_to(tmp_path / "there" / "file.txt")
    write_text(link, "through the link")
    assert link.is_symlink() and (tmp_path / "there" / "file.txt").read_text() == "through the link"
    write_text(Path("/dev/null"), "nothing")
    assert Path("/dev/null").is_char_device()
    with pytest.raises(FileError, match="full"), whole_file(Path("/dev/full")) as unfinished:
        unfinished.write_text("no room")
