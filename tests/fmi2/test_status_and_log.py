"""FMI 2.0: status functions and log messages."""

from ctypes import byref, c_char_p, c_double, c_int

import pytest
from driver import DISCARD, DO_STEP_STATUS, ERROR, LAST_SUCCESSFUL_TIME, OK, PENDING_STATUS, TERMINATED
from fmi2_inputs import last_time

# ---- status ----


def test_status(fmu):
    fmu.start().step(0.5)
    terminated = c_int(7)
    fmu.ok("fmi2GetBooleanStatus", TERMINATED, byref(terminated))
    assert terminated.value == 0
    assert last_time(fmu) == 0.5


@pytest.mark.parametrize(
    "function, kind, room",
    [
        ("fmi2GetStatus", DO_STEP_STATUS, c_int(7)),
        ("fmi2GetStringStatus", PENDING_STATUS, c_char_p()),
        ("fmi2GetIntegerStatus", LAST_SUCCESSFUL_TIME, c_int(7)),
        ("fmi2GetRealStatus", TERMINATED, c_double(7)),
        ("fmi2GetBooleanStatus", LAST_SUCCESSFUL_TIME, c_int(7)),
        ("fmi2GetBooleanStatus", 99, c_int(7)),
    ],
)
def test_status_without_an_answer(fmu, function, kind, room):
    """Section 4.2.3: fmi2Discard."""
    before, value = fmu.start().everything(), room.value
    assert fmu.call(function, kind, byref(room)) == DISCARD
    (message,) = fmu.messages
    assert (message.status, message.category) == (DISCARD, "logStatusError")
    assert function in message.text
    assert f"status kind {kind} " in message.text
    assert room.value == value
    assert fmu.everything() == before
    set_logging(fmu, 0)
    assert fmu.call(function, kind, byref(room)) == DISCARD
    assert len(fmu.messages) == 1


# ---- log ----


def set_logging(fmu, on, *categories):
    array = (c_char_p * len(categories))(*(c.encode() for c in categories))
    return fmu.call("fmi2SetDebugLogging", on, len(categories), array)


@pytest.mark.parametrize("logging", [0, 1, -1])
def test_errors_are_always_logged(make, logging):
    make(logging=logging).refused("fmi2CancelStep")


@pytest.mark.parametrize(
    "categories",
    [(), ("logStatusError",), ("logAll",), ("logEvents", "logStatusError"), ("logAll", "logStatusError")],
)
def test_errors_can_be_silenced(fmu, categories):
    assert set_logging(fmu, 0, *categories) == OK
    assert fmu.call("fmi2CancelStep") == ERROR
    assert fmu.messages == []
    assert set_logging(fmu, -1, *categories) == OK
    fmu.refused("fmi2CancelStep")


def test_other_categories_leave_errors_alone(fmu):
    assert set_logging(fmu, 0, "logEvents", "logStatusWarning") == OK
    fmu.refused("fmi2CancelStep")


def test_refuses_unknown_categories(fmu):
    categories = (c_char_p * 2)(b"logStatusError", b"logEverything")
    fmu.refused("fmi2SetDebugLogging", 0, 2, categories, mentions=("logEverything",))
    fmu.refused("fmi2CancelStep")
    fmu.refused("fmi2SetDebugLogging", 0, 1, None, mentions=("categories",))
    fmu.refused("fmi2SetDebugLogging", 0, 1, (c_char_p * 1)(None))


def test_messages_are_safe_as_formats(fmu):
    text = fmu.refused("fmi2SetDebugLogging", 1, 1, (c_char_p * 1)("%s #r1# \n ü".encode()))
    assert "%%s ##r1## ? ??" in text
