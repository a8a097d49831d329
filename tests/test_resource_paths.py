"""The folder that fmi/resources.c finds in a URI or a path, against RFC 8089, on Windows, which has shares
("//server/share"), and elsewhere. Both forms run on any system."""

import ctypes

import build_fmu
import pytest

# The file is compiled twice under other names: as on Windows, and as elsewhere.
CODE = """\
#include "platform/platform.h"
#define PLATFORM_HAS_SHARES {shares}
#define resources_directory {name}_directory
#define resources_from_path {name}_from_path
#include "fmi/resources.c"
"""


def compiled(folder, name, shares):
    shim, product = folder / f"{name}.c", folder / f"lib{name}.so"
    shim.write_text(CODE.format(name=name, shares=shares))
    flags = ["-O1", "-fPIC", "-shared", *build_fmu.TARGET, str(shim)]
    build_fmu.compile_c(build_fmu.ZIG, flags, [], product)
    library = ctypes.CDLL(str(product))

    def folder_of(text, kind="directory"):
        found = ctypes.c_char_p()
        function = getattr(library, f"{name}_{kind}")
        function.restype = ctypes.c_bool
        assert function(text if text is None else text.encode(), ctypes.byref(found))
        return None if found.value is None else found.value.decode()

    return folder_of


@pytest.fixture(scope="module")
def windows(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("windows"), "windows", 1)


@pytest.fixture(scope="module")
def posix(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("posix"), "posix", 0)


@pytest.mark.parametrize(
    ("uri", "path"),
    [
        ("file:///C:/fmu/resources", "C:/fmu/resources"),
        ("file:/C:/fmu/resources", "C:/fmu/resources"),
        ("file://localhost/C:/fmu", "C:/fmu"),
        ("file://C:/fmu", "C:/fmu"),  # no URI of RFC 8089; some masters make it
        ("file://server/share/fmu", "//server/share/fmu"),
        ("file:////server/share/fmu", "//server/share/fmu"),
        ("file:///C:/my%20fmu/", "C:/my fmu"),
        ("file://", None),
        ("http://server/fmu", None),
    ],
)
def test_folder_of_a_uri_on_windows(windows, uri, path):
    assert windows(uri) == path


@pytest.mark.parametrize(
    ("uri", "path"),
    [
        ("file:///tmp/fmu", "/tmp/fmu"),
        ("file://localhost/tmp/fmu/", "/tmp/fmu"),
        ("file://server/share/fmu", None),
        ("file:tmp", None),
    ],
)
def test_folder_of_a_uri_elsewhere(posix, uri, path):
    assert posix(uri) == path


@pytest.mark.parametrize(
    ("path", "folder"), [(None, None), ("", None), ("/tmp/fmu/", "/tmp/fmu"), ("file:///tmp", "/tmp")]
)
def test_folder_of_a_path(posix, path, folder):
    """FMI 3.0 gives a path. An empty one is no folder, not the root of all files."""
    assert posix(path, "from_path") == folder
