"""FMI 2.0: FMU states, saved, restored, and as bytes."""

import ctypes
import os
import subprocess
import sys
from ctypes import byref, c_size_t, c_void_p

import pytest
from driver import END, ERROR, INITIALIZATION, INSTANTIATED, OK, PHASES, ROOT, STEP
from fmi2_inputs import FREE, INPUT_SEQUENCE, drive, for_forward, run

# ---- states ----


def test_a_restored_run_repeats_bit_for_bit(fmu):
    fmu.start()
    run(fmu, 5)
    state, time = fmu.take(), fmu.time
    first = run(fmu)
    fmu.restore(state)
    fmu.time = time
    assert run(fmu) == first
    fmu.free_state(state)


def test_any_number_of_states_in_any_order(fmu):
    fmu.start()
    states, records = [], []
    for inputs in INPUT_SEQUENCE[fmu.model]:
        fmu.step(0.013, **inputs)
        states.append(fmu.take())
        records.append(fmu.everything())
    for i in [3, 0, 11, 7, 7, 1]:
        fmu.restore(states[i])
        assert fmu.everything() == records[i]
    for state in states:
        fmu.free_state(state)
        assert not state


@pytest.mark.parametrize("phase", PHASES)
def test_a_state_holds_the_phase(fmu, phase):
    fmu.enter(phase)
    before = fmu.everything()
    state = fmu.take()
    fmu.ok("fmi2Reset")
    fmu.enter(END)
    fmu.restore(state)
    assert fmu.everything() == before
    allowed = {INSTANTIATED: "fmi2EnterInitializationMode", INITIALIZATION: "fmi2ExitInitializationMode"}
    if phase in allowed:
        fmu.ok(allowed[phase])
    elif phase == STEP:
        fmu.ok("fmi2DoStep", 0.0, 0.1, 1)
    else:
        fmu.refused("fmi2DoStep", 0.0, 0.1, 1)
    fmu.free_state(state)


def test_a_state_holds_impossible_parameters(fmu):
    fmu.set({"stop.upper": -1.0})
    state = fmu.take()
    fmu.ok("fmi2Reset")
    fmu.restore(state)
    assert fmu.get("stop.upper") == -1.0
    fmu.set({"stop.upper": 1.0})
    fmu.start().step(0.1, **drive(fmu, 0.9))
    fmu.free_state(state)


def test_a_state_holds_tuned_parameters(fmu):
    fmu.start().step(0.01, **drive(fmu, 1.2))
    fmu.set({"cam1.friction": 0.3, "spring.preload": 77.0})
    state, time = fmu.take(), fmu.time
    first = run(fmu)
    fmu.set({"cam1.friction": 0.1, "spring.preload": 11.0})
    fmu.restore(state)
    fmu.time = time
    assert fmu.get("cam1.friction") == 0.3
    assert run(fmu) == first
    fmu.free_state(state)


@for_forward
@pytest.mark.parametrize("fresh", [True, False])
def test_a_state_holds_rates(fmu, fresh):
    fmu.start(FREE)
    fmu.set_rates(tau=2.0)
    if not fresh:
        fmu.step(1.0)
    state, time = fmu.take(), fmu.time
    fmu.step(1.0)
    expected = fmu.everything()
    fmu.step(1.0, tau=-5.0)
    fmu.restore(state)
    fmu.time = time
    fmu.step(1.0)
    assert fmu.everything() == expected
    fmu.free_state(state)


def test_a_state_is_used_again(fmu):
    fmu.start()
    state = fmu.take()
    address = state.value
    fmu.step(0.1, **drive(fmu, 1.2))
    before = fmu.everything()
    fmu.ok("fmi2GetFMUstate", byref(state))
    assert state.value == address
    fmu.step(0.1)
    fmu.restore(state)
    assert fmu.everything() == before
    fmu.free_state(state)


def test_a_state_is_for_all_instances_of_the_fmu(make):
    one, two = make(), make()
    one.start()
    run(one)
    state = one.take()
    two.restore(state)
    assert two.everything() == one.everything()
    two.free_state(state)


def test_freeing_nothing(fmu):
    fmu.ok("fmi2FreeFMUstate", None)
    fmu.ok("fmi2FreeFMUstate", byref(c_void_p()))


def test_refuses_what_is_no_state(fmu):
    fmu.start().step(0.1, **drive(fmu, 1.2))
    other = ctypes.create_string_buffer(8192)
    size = c_size_t()
    pointer, word = c_void_p(ctypes.addressof(other)), "not of this FMU"
    fmu.refused("fmi2SetFMUstate", pointer, mentions=(word,))
    fmu.refused("fmi2SerializedFMUstateSize", pointer, byref(size), mentions=(word,))
    fmu.refused("fmi2SerializeFMUstate", pointer, other, 8192, mentions=(word,))
    fmu.refused("fmi2GetFMUstate", byref(c_void_p(ctypes.addressof(other))))
    fmu.refused("fmi2FreeFMUstate", byref(c_void_p(ctypes.addressof(other))))


# ---- states as bytes ----


@pytest.fixture
def midway(fmu):
    """In the middle of a run, with the state as bytes."""
    fmu.start({"cam1.friction": 0.17})
    run(fmu, 5)
    return fmu, fmu.state_bytes()


def test_bytes_restore_the_state(midway, make):
    fmu, content = midway
    other = make()
    status, state = other.try_from_bytes(content)
    assert status == OK
    other.restore(state)
    other.free_state(state)
    other.time = fmu.time
    assert run(other) == run(fmu)


def test_bytes_come_back(midway):
    fmu, content = midway
    _, state = fmu.try_from_bytes(content)
    assert fmu.to_bytes(state) == content
    fmu.free_state(state)


def test_equal_runs_have_equal_bytes(midway, make):
    _, content = midway
    other = make()
    other.everything()
    other.start({"cam1.friction": 0.17})
    run(other, 5)
    assert other.state_bytes() == content


ELSEWHERE = """
import ast, sys
from driver import Driver, load, models
from pathlib import Path
fmu = Driver(load(Path(sys.argv[1])), model=models[sys.argv[3]])
status, state = fmu.try_from_bytes(sys.stdin.buffer.read())
assert status == 0, fmu.messages
fmu.restore(state)
fmu.time = float.fromhex(sys.argv[2])
for inputs in ast.literal_eval(sys.argv[4]):
    fmu.step(0.013, **inputs)
print(sorted(fmu.everything().items()))
"""


def test_bytes_load_in_another_process(midway, binary):
    fmu, content = midway
    sequence = str(INPUT_SEQUENCE[fmu.model])
    arguments = [str(binary), fmu.time.hex(), fmu.model.identifier, sequence]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "tests/support")}
    command = [sys.executable, "-c", ELSEWHERE, *arguments]
    done = subprocess.run(command, input=content, capture_output=True, env=environment)
    assert done.returncode == 0, done.stderr.decode()
    run(fmu)
    assert done.stdout.decode().strip() == str(sorted(fmu.everything().items()))


def damaged(content):
    """One bit of every byte of the header and of every 37th byte after it, and of the last."""
    places = [*range(96), *range(96, len(content), 37), len(content) - 1]
    for place in places:
        copy = bytearray(content)
        copy[place] ^= 1 << place % 8
        yield bytes(copy)


def test_damaged_bytes_are_refused(midway):
    fmu, content = midway
    before = fmu.everything()
    for bad in damaged(content):
        count = len(fmu.messages)
        status, state = fmu.try_from_bytes(bad)
        assert status == ERROR
        assert not state
        assert len(fmu.messages) == count + 1
        assert "fmi2DeSerializeFMUstate" in fmu.messages[-1].text
    assert fmu.everything() == before


@pytest.mark.parametrize(
    "change", [lambda b: b"", lambda b: b[:-1], lambda b: b + b"\0", lambda b: b[8:], lambda b: 2 * b]
)
def test_bytes_of_another_length_are_refused(midway, change):
    fmu, content = midway
    bad = change(content)
    fmu.refused("fmi2DeSerializeFMUstate", bad, len(bad), byref(c_void_p()), mentions=(str(len(content)),))


def test_bytes_of_another_fmu_are_refused(midway):
    fmu, content = midway
    bad = content.replace(fmu.model.guid.encode(), b"{00000000-0000-0000-0000-000000000000}")
    assert bad != content
    fmu.refused("fmi2DeSerializeFMUstate", bad, len(bad), byref(c_void_p()), mentions=("GUID",))


def test_refuses_a_room_that_is_too_small(midway):
    fmu, content = midway
    state = fmu.take()
    room = ctypes.create_string_buffer(len(content))
    fmu.refused("fmi2SerializeFMUstate", state, room, len(content) - 1, mentions=(str(len(content)),))
    fmu.free_state(state)


@pytest.mark.parametrize("phase", [INSTANTIATED, INITIALIZATION])
def test_reading_before_the_start_leaves_the_bytes(fmu, phase):
    """The start state follows from parameters and inputs, whether a value was read before or not."""
    fmu.enter(phase)
    before = fmu.state_bytes()
    fmu.everything()
    assert fmu.state_bytes() == before
