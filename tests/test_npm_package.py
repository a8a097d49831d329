"""Packages of the npm registry: what is downloaded, checked, kept, and said without a network."""

import base64
import hashlib
import io
import json
import socket
import subprocess
import sys
import tarfile
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import ClassVar

import build_fmu
import npm_package
import pytest
from driver import ROOT
from npm_package import Package

FILES = {"LICENSE": b"a licence", "build/code.min.js": b"export const x = 1;"}


def packed(files):
    """An archive as the registry has them."""
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w:gz") as archive:
        for name, text in files.items():
            member = tarfile.TarInfo(f"package/{name}")
            member.size = len(text)
            archive.addfile(member, io.BytesIO(text))
    return content.getvalue()


ARCHIVE = packed(FILES | {"src/large.js": b"not used"})
INTEGRITY = "sha512-" + base64.b64encode(hashlib.sha512(ARCHIVE).digest()).decode()


@pytest.fixture
def package(monkeypatch, tmp_path):
    """A pinned package, with folders of its own for downloads."""
    pinned = Package("thing", "1.2.3", INTEGRITY, tuple(FILES))
    monkeypatch.setattr(npm_package, "pinned", lambda name: pinned)
    monkeypatch.setattr(npm_package, "ROOT", tmp_path)
    monkeypatch.setattr(npm_package, "DOWNLOADS", tmp_path / "npm")
    monkeypatch.setattr(npm_package, "relative", str)
    return pinned


@pytest.fixture
def registry(monkeypatch):
    """A registry on this machine: the list of the paths that were asked for, and what it answers."""

    class Registry(BaseHTTPRequestHandler):
        asked: ClassVar[list[str]] = []
        archive = ARCHIVE
        missing = 0  # bytes that are announced and do not come

        def do_GET(self):
            self.asked.append(self.path)
            self.send_response(200 if self.path.endswith("/thing-1.2.3.tgz") else 404)
            self.send_header("Content-Length", str(len(self.archive) + self.missing))
            self.end_headers()
            self.wfile.write(self.archive)

        def log_message(self, *_):
            pass

    Registry.asked = []
    server = ThreadingHTTPServer(("127.0.0.1", 0), Registry)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    for name in ("http_proxy", "HTTP_PROXY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("npm_config_registry", f"http://127.0.0.1:{server.server_port}/npm/")
    yield Registry
    server.shutdown()
    server.server_close()


@pytest.fixture
def no_network(monkeypatch):
    """A registry that nobody serves."""
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        address = f"http://127.0.0.1:{closed.getsockname()[1]}"
    for name in ("http_proxy", "HTTP_PROXY", "npm_config_registry"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("NPM_CONFIG_REGISTRY", address)  # npm takes any case
    return address


def test_the_files_are_written_and_the_archive_is_kept(package, registry, tmp_path):
    folder = npm_package.install("thing", tmp_path / "web")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == {
        "LICENSE": FILES["LICENSE"],
        "code.min.js": FILES["build/code.min.js"],
    }
    assert folder == tmp_path / "web/thing" and registry.asked == ["/npm/thing/-/thing-1.2.3.tgz"]
    for _ in range(2):
        npm_package.install("thing", tmp_path / "web")
    (folder / "code.min.js").unlink()
    npm_package.install("thing", tmp_path / "web")
    assert (folder / "code.min.js").is_file() and len(registry.asked) == 1


def test_another_version_replaces_the_files(package, registry, tmp_path, monkeypatch):
    npm_package.install("thing", tmp_path / "web")
    fewer = Package("thing", "1.2.3", INTEGRITY, ("LICENSE",))
    monkeypatch.setattr(npm_package, "pinned", lambda name: fewer)
    folder = npm_package.install("thing", tmp_path / "web")
    assert [path.name for path in folder.iterdir()] == ["LICENSE"]


def test_a_changed_archive_is_refused(package, registry, tmp_path):
    registry.archive = packed({"LICENSE": b"other"})
    with pytest.raises(build_fmu.BuildError, match="is not the archive that pyproject"):
        npm_package.install("thing", tmp_path / "web")
    assert not package.archive.exists() and not (tmp_path / "web/thing/LICENSE").exists()


def test_a_download_that_is_cut_is_refused(package, registry, tmp_path):
    registry.missing = 10
    with pytest.raises(build_fmu.BuildError, match="was not downloaded"):
        npm_package.install("thing", tmp_path / "web")
    assert not package.archive.exists()


def test_a_damaged_download_is_fetched_again(package, registry, tmp_path):
    package.archive.parent.mkdir()
    package.archive.write_bytes(ARCHIVE[:-1])
    npm_package.install("thing", tmp_path / "web")
    assert package.archive.read_bytes() == ARCHIVE and len(registry.asked) == 1


def test_a_missing_file_is_named(package, registry, tmp_path, monkeypatch):
    wanted = Package("thing", "1.2.3", INTEGRITY, ("LICENSE", "build/none.js"))
    monkeypatch.setattr(npm_package, "pinned", lambda name: wanted)
    with pytest.raises(build_fmu.BuildError, match=r"thing-1\.2\.3\.tgz has no file build/none\.js"):
        npm_package.install("thing", tmp_path / "web")


def test_without_a_network_the_message_says_what_to_do(package, no_network, tmp_path):
    with pytest.raises(build_fmu.BuildError) as found:
        npm_package.install("thing", tmp_path / "web")
    text = str(found.value)
    assert text.startswith(f"{no_network}/thing/-/thing-1.2.3.tgz was not downloaded: ")
    for words in ("npm_config_registry", "HTTPS_PROXY", f"thing-1.2.3.tgz into {tmp_path / 'npm'}"):
        assert words in text


def test_a_wrong_address_of_the_registry(package, monkeypatch, tmp_path):
    monkeypatch.setenv("npm_config_registry", "no address")
    with pytest.raises(build_fmu.BuildError, match="was not downloaded"):
        npm_package.install("thing", tmp_path / "web")


def test_an_archive_that_somebody_put_there_is_enough(package, no_network, tmp_path):
    package.archive.parent.mkdir()
    package.archive.write_bytes(ARCHIVE)
    assert (npm_package.install("thing", tmp_path / "web") / "LICENSE").is_file()


WITHOUT_THREE = """
import sys
import build_fmu
from workspace import BuildError

def refuse():
    raise BuildError("three is not there")

build_fmu.build_three = refuse
sys.exit(build_fmu.main([]))
"""


def test_a_build_goes_on_without_three():
    """The FMUs do not need it."""
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_THREE], cwd=ROOT, capture_output=True, text=True, timeout=280
    )
    assert done.returncode == 0, done.stderr
    assert "build_fmu: warning: three is not there" in done.stderr


def test_three_is_pinned_with_its_integrity():
    three = npm_package.pinned("three")
    assert three.files[0] == "LICENSE" and three.url.endswith(f"/three/-/three-{three.version}.tgz")
    assert len(base64.b64decode(three.integrity.removeprefix("sha512-"))) == 64
    assert json.dumps(three.version) in (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    for file in three.files:
        assert (build_fmu.BUILD / "web/three" / file.rpartition("/")[2]).is_file()
