"""FMI 3.0: FMU states, saved, restored, and as bytes."""

import ctypes
import math
import struct
from ctypes import byref, c_void_p

import driver as fmi2
import pytest
from driver import ERROR
from driver3 import INVERSE
from fmi3_scenes import GENERAL, wave


@pytest.mark.parametrize("options", [{}, {"events": True, "early": True}], ids=["plain", "events"])
def test_a_restored_run_repeats_bit_for_bit(make3, options):
    fmu = make3(**options).start(GENERAL)
    fmu.step(0.01, tau=4.0)
    state = fmu.take()
    content, origin = fmu.to_bytes(state), fmu.time
    other = make3(**options)
    opened = c_void_p()
    other.ok("DeserializeFMUState", content, len(content), byref(opened))
    runs = []
    for one, start in ((fmu, state), (fmu, state), (other, opened)):
        one.restore(start)
        one.time = origin
        trace = []
        for k in range(40):
            one.step(0.02, tau=wave(0.02 * k))
            trace.append((one.time, one.everything()))
        runs.append(trace)
    assert runs[0] == runs[1] == runs[2]
    fmu.free_state(state)
    other.free_state(opened)
    fmu.free_state(c_void_p())


def test_bytes_that_are_no_state_of_this_fmu_are_refused(make_model, make3):
    fmu = make3().start()
    fmu.step(0.1, tau=2.0)
    state = fmu.take()
    content = fmu.to_bytes(state)
    old = make_model(fmi2.FORWARD).start()
    old_state = old.take()
    inverse = make3(INVERSE).start()
    inverse_state = inverse.take()
    foreign = {"FMI 2.0": old.to_bytes(old_state), "inverse": inverse.to_bytes(inverse_state)}
    altered = {k: content[:k] + bytes([content[k] ^ 1]) + content[k + 1 :] for k in range(0, len(content), 7)}
    for wrong in (b"", content[:-1], content + b"\0", *foreign.values(), *altered.values()):
        opened = c_void_p()
        assert fmu.call("DeserializeFMUState", wrong, len(wrong), byref(opened)) == ERROR
        assert opened.value is None and "allowed" in fmu.messages[-1].text
    room = ctypes.create_string_buffer(len(content))
    fmu.refused("SerializeFMUState", state, room, len(content) - 1, mentions=("size",))
    for owner, one in ((fmu, state), (inverse, inverse_state)):
        owner.free_state(one)
    old.free_state(old_state)


def test_a_state_of_another_use_is_refused(make3):
    makers = [{}, {"events": True}, {"exchange": True}]
    fmus = [make3(**options) for options in makers]
    states = [fmu.initialize().take() for fmu in fmus]
    for i, fmu in enumerate(fmus):
        for j, state in enumerate(states):
            if i == j:
                fmu.restore(state)
            else:
                fmu.refused("SetFMUState", state, mentions=("FMU state of",))
    for fmu, state in zip(fmus, states, strict=True):
        fmu.free_state(state)


def checksum(content: bytes) -> int:
    """FNV-1a, 64 bits (G. Fowler, L. Noll, P. Vo)."""
    value = 0xCBF29CE484222325
    for byte in content:
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return value


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (-4, b"\x46"),  # type of the interface
        (-8, b"\x03"),  # two phases at once
        (-8, b"\x10"),  # continuous time, in co-simulation
        (-24, struct.pack("d", math.nan)),  # time
        (104, struct.pack("d", -1.0)),  # cam1.radius
        (104 + 8, struct.pack("d", math.inf)),  # cam1.lead_angle
        (-24 - 568 + 40, b"\x63"),  # mode
    ],
)
def test_a_forged_state_with_a_right_checksum_is_refused(make3, place, value):
    """Anybody can compute the checksum: impossible values must not reach tables and decisions."""
    header, first = 4 * 8 + 64, 3 * 8  # bytes before the snapshot; place of the checksum
    fmu = make3().start()
    fmu.step(0.1, tau=2.0)
    state = fmu.take()
    content = bytearray(fmu.to_bytes(state))
    assert struct.unpack_from("Q", content, first)[0] == checksum(content[header:])
    start = place % len(content)
    content[start : start + len(value)] = value
    struct.pack_into("Q", content, first, checksum(content[header:]))
    fmu.refused("DeserializeFMUState", bytes(content), len(content), byref(c_void_p()), mentions=("values",))
    fmu.free_state(state)
