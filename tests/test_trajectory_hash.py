"""The same bits on every platform: one hash of all outputs of both FMUs over all scenes.

Here with what PyPI gives; `./build.sh run hash` adds other compilers, processors and systems.
"""

import pytest
import trajectory_hash
from trajectory_hash import QUICK, Missing, hashes, write_tables


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables")
    write_tables(folder)
    return folder


def hashes_or_skip(build, tables):
    try:
        return hashes(build, tables)
    except Missing as reason:
        pytest.skip(str(reason))


@pytest.fixture(scope="module")
def here(tables):
    """Of the binaries that the build has made for this machine."""
    return hashes_or_skip(QUICK[0], tables)


@pytest.mark.parametrize("build", QUICK[1:], ids=lambda build: build.name)
def test_all_bits_of_all_outputs_are_equal(here, build, tables):
    there = hashes_or_skip(build, tables)
    assert {scene: value for scene, value in there.items() if here.get(scene) != value} == {}
    assert len(there) == len(here) > 30


@pytest.mark.long
@pytest.mark.parametrize("build", trajectory_hash.all_builds(), ids=lambda build: build.name)
def test_all_bits_with_other_compilers_and_on_other_platforms(here, build, tables):
    assert hashes_or_skip(build, tables) == here


def test_one_last_digit_of_a_table_changes_the_hash(here, tables, tmp_path):
    write_tables(tmp_path)
    sample = "0.12\n"
    text = (tmp_path / "speed.csv").read_text()
    assert sample in text
    (tmp_path / "speed.csv").write_text(text.replace(sample, "0.12000000000000001\n"))
    differing = {scene for scene, value in hashes(QUICK[0], tmp_path).items() if here[scene] != value}
    assert differing == {scene for scene in here if scene.endswith(": friction tables")}
