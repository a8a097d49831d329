"""FMI 3.0: FMU states, saved, restored, and as bytes."""

import ctypes
import math
import struct
from ctypes import byref, c_double, c_int, c_void_p

import driver as fmi2
import pytest
from driver import ERROR
from driver3 import FORWARD, INVERSE
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


class Step(ctypes.Structure):
    """forward/state.h"""

    _fields_ = (
        *((name, c_double * 2) for name in ("theta", "omega")),
        ("inputs", c_double * 8),
        *((name, c_double) for name in ("energy_gained", "h")),
        *((name, c_int) for name in ("mode", "flank1", "flank2", "retuned")),
    )


class State(ctypes.Structure):
    """forward/state.h"""

    _fields_ = (
        *((name, c_double * 2) for name in ("theta", "omega")),
        ("energy_gained", c_double),
        ("events", ctypes.c_int64),
        ("F_ext_at_start", c_double),
        *((name, c_int) for name in ("mode", "flank1", "flank2", "friction_class")),
        ("ledger", c_double * 25),
        ("step", Step),
        ("tunables", c_double * 24),
    )


class InverseState(ctypes.Structure):
    """inverse/inverse_state.h"""

    _fields_ = (
        *((name, c_double) for name in ("theta", "omega", "cam")),
        ("events", ctypes.c_int64),
        ("F_ext_at_start", c_double),
        ("friction_class", ctypes.c_int64),
        *((name, c_int) for name in ("mode", "direction")),
        ("ledger", c_double * 25),
    )


class Run(ctypes.Structure):
    """fmi/instance.h"""

    _fields_ = (
        *((name, c_double) for name in ("time", "completed_until")),
        ("phase", c_int),
        *((name, ctypes.c_uint16) for name in ("interface_type", "derivatives_given")),
    )


HEADER, CHECKSUM = 4 * 8 + 64, 3 * 8  # bytes before the snapshot; place of the checksum
RADIUS, TOLERANCE = HEADER + 8, HEADER + 8 + 50 * 8  # of cam 1, of the run: places in the snapshot
STATE = {FORWARD: State, INVERSE: InverseState}
BAD_RUN = [
    ("interface_type", 70),
    ("phase", 3),  # two phases at once
    ("phase", 16),  # continuous time, in co-simulation
    ("time", math.nan),
    ("completed_until", math.inf),
]
BAD_STATE = {
    FORWARD: [
        *((name, value) for name in ("mode", "step.mode") for value in (-1, 7, 99)),
        ("mode", 0),  # that of a step is 0 before the first step
        *((f"{place}flank{i}", value) for place in ("", "step.") for i in (1, 2) for value in (2, -2)),
        ("F_ext_at_start", math.nan),
        *(
            (name, value)
            for name in ("theta", "omega", "step.theta", "step.omega")
            for value in (math.nan, math.inf)
        ),
        *(("step.h", value) for value in (-1e-3, math.nan, math.inf)),
    ],
    INVERSE: [
        *(("mode", value) for value in (0, 7)),
        *(("direction", value) for value in (0, 2)),
        ("F_ext_at_start", math.nan),
        *((name, value) for name in ("theta", "omega", "cam") for value in (math.nan, -math.inf)),
    ],
}


def put(part, name, value):
    """Sets a member, of a sum of two doubles the first one."""
    *parts, last = name.split(".")
    for name in parts:
        part = getattr(part, name)
    if isinstance(getattr(part, last), ctypes.Array):
        getattr(part, last)[0] = value
    else:
        setattr(part, last, value)


def refuse_forged(fmu, content):
    struct.pack_into("Q", content, CHECKSUM, checksum(content[HEADER:]))
    fmu.refused("DeserializeFMUState", bytes(content), len(content), byref(c_void_p()), mentions=("values",))


@pytest.fixture(params=STATE, ids=repr)
def saved(make3, request):
    """An instance and the bytes of its state after a step."""
    model = request.param
    fmu = make3(model).start({FORWARD: {"tau": 2.0}, INVERSE: {"theta": 0.2, "omega": 0.5}}[model])
    fmu.step(0.1, **({"theta": 0.25} if model is INVERSE else {}))
    state = fmu.take()
    content = fmu.to_bytes(state)
    fmu.free_state(state)
    assert struct.unpack_from("Q", content, CHECKSUM)[0] == checksum(content[HEADER:])
    return fmu, content


def test_a_forged_state_with_a_right_checksum_is_refused(saved):
    """Anybody can compute the checksum: impossible values must not reach tables and decisions."""
    fmu, content = saved
    run = len(content) - ctypes.sizeof(Run)
    of_state = STATE[fmu.model], run - ctypes.sizeof(STATE[fmu.model])
    members = [*((of_state, *bad) for bad in BAD_STATE[fmu.model]), *(((Run, run), *bad) for bad in BAD_RUN)]
    for (kind, place), name, value in members:
        forged = bytearray(content)
        part = kind.from_buffer(forged, place)
        if "." not in name and name == "theta":
            first = part.theta if fmu.model is INVERSE else part.theta[0]
            assert first == fmu.get("theta")  # else the members are not where these structures have them
        put(part, name, value)
        refuse_forged(fmu, forged)


@pytest.mark.parametrize(
    ("place", "value"),
    [(RADIUS, -1.0), (RADIUS + 8, math.inf), (TOLERANCE, 1e-20), (TOLERANCE, 0.5), (TOLERANCE, math.nan)],
)
def test_a_forged_parameter_is_refused(saved, place, value):
    fmu, content = saved
    forged = bytearray(content)
    struct.pack_into("d", forged, place, value)
    refuse_forged(fmu, forged)


def test_more_events_than_an_integer_counts_are_the_most_that_it_counts(saved):
    fmu, content = saved
    forged, kind = bytearray(content), STATE[fmu.model]
    kind.from_buffer(forged, len(content) - ctypes.sizeof(Run) - ctypes.sizeof(kind)).events = 2**40
    struct.pack_into("Q", forged, CHECKSUM, checksum(forged[HEADER:]))
    state = c_void_p()
    fmu.ok("DeserializeFMUState", bytes(forged), len(forged), byref(state))
    fmu.restore(state)
    fmu.free_state(state)
    assert fmu.get("events") == 2**31 - 1
