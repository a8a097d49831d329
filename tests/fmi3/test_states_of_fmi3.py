"""FMI 3.0.2: each function in each state, as states.csv says.

States without a column: Configuration Mode and Reconfiguration Mode need a structural parameter, and the FMU
has none. In the standard state Terminated also follows fmi3Error: note `error`. "step of events" and "event"
are the states of co-simulation with eventModeUsed.
"""

import ctypes
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_int32, c_size_t, c_uint, c_void_p
from pathlib import Path

import driver3
import pytest
from driver3 import ARGUMENTS, FORWARD, INVERSE, OTHER, Driver
from fmi3_scenes import each_model
from state_table import StateCheck, StateTable, ValidArguments, check_every_call

TABLE = StateTable(Path(__file__).parent)
INSIDE_A_STEP = {"CS intermediate set": "inputs", "CS intermediate get": "outputs"}
PHASE = {
    "instantiated": "instantiated", "initialization": "initialization mode", "event": "event mode",
    "continuous": "continuous-time mode", "step": "step mode", "step of events": "step mode",
    "terminated": "terminated",
}  # fmt: skip
WITHOUT_INSTANCE = {"fmi3GetVersion"}
ASKED_FOR = {FORWARD: ("tau", "theta"), INVERSE: ("z",)}  # inside steps


def test_the_table_has_every_function_of_an_instance():
    functions = {f"fmi3{name}" for name in (*ARGUMENTS, "FreeInstance")}
    assert TABLE.functions == functions | WITHOUT_INSTANCE


def test_each_deviation_has_a_note():
    TABLE.check_notes()


# ---- arguments ----

OF_STATES = ("SetFMUState", "FreeFMUState", "SerializedFMUStateSize", "SerializeFMUState")


class Arguments(ValidArguments):
    MAY_BE_NULL = frozenset({("fmi3FreeFMUState", 0)})

    def __init__(self, fmu: Driver, saves: bool = True) -> None:
        super().__init__(fmu, saves)
        self.asked_for = frozenset(ASKED_FOR[fmu.model])

    def of(self, function: str) -> tuple:
        fmu, name = self.fmu, function.removeprefix("fmi3")
        if name in OF_STATES:
            return self._of_a_state(name)
        if name[:3] in ("Get", "Set") and name[3:].startswith((*OTHER, *OF_OTHER_TYPES)):
            return self._of_no_variable(name)
        if name == "DeserializeFMUState":
            content = fmu.state_bytes() if self.saves else b""
            return content, len(content), byref(self.made)
        if name.endswith("VariableDependencies"):
            return self._of_dependencies(name)
        if name in VECTORS:
            n = VECTORS[name][fmu.model is not FORWARD]
            return (c_double * n)(*[0.3, 1.0][:n]), n
        flags, time = [c_bool() for _ in range(3)], c_double()
        known, unknown = fmu.model.references(["F_ext"]), fmu.model.references(["z"])
        jacobian = (unknown, 1, known, 1, driver3.reals([1.0]), 1, driver3.reals([0.0]), 1)
        output = fmu.model.references([ASKED_FOR[fmu.model][-1]])
        return {
            "SetDebugLogging": (True, 1, (c_char_p * 1)(b"logStatusError")),
            "EnterInitializationMode": (False, 0.0, 0.0, False, 0.0),
            "GetFMUState": (byref(self.made),),
            "GetDirectionalDerivative": jacobian,
            "GetAdjointDerivative": jacobian,
            "UpdateDiscreteStates": fmu._update_arguments()[0],
            "CompletedIntegratorStep": (True, byref(flags[0]), byref(flags[1])),
            "SetTime": (0.5,),
            "GetNumberOfContinuousStates": (byref(c_size_t()),),
            "GetNumberOfEventIndicators": (byref(c_size_t()),),
            "DoStep": (fmu.time, 0.01, True, *map(byref, flags), byref(time)),
            "GetOutputDerivatives": (output, 1, (c_int32 * 1)(1), driver3.reals([0.0]), 1),
            "ActivateModelPartition": (0, 0.0),
        }.get(name, ())

    def _of_a_state(self, name: str) -> tuple:
        if not self.saves:  # inside a step no state can be made
            return {
                "SetFMUState": (None,),
                "FreeFMUState": (byref(c_void_p()),),
                "SerializedFMUStateSize": (None, byref(c_size_t())),
                "SerializeFMUState": (None, ctypes.create_string_buffer(1), 1),
            }[name]
        if not self.made:
            self.made = self.fmu.take()
        size = len(self.fmu.to_bytes(self.made))
        return {
            "SetFMUState": (self.made,),
            "FreeFMUState": (byref(self.made),),
            "SerializedFMUStateSize": (self.made, byref(c_size_t())),
            "SerializeFMUState": (self.made, ctypes.create_string_buffer(size), size),
        }[name]

    def _of_no_variable(self, name: str) -> tuple:
        one, type_ = self.fmu.model.references(["F_ext"]), name[3:]
        if type_ in OTHER:
            return one, 1, (OTHER[type_] * 1)(), 1
        if type_ == "Binary":
            return one, 1, (c_size_t * 1)(), (c_void_p * 1)(), 1
        if type_ == "Clock":
            return one, 1, (c_bool * 1)()
        numbers = [(ctypes.c_uint64 * 1)() for _ in range(2)] if "Fraction" in type_ else [(c_double * 1)()]
        return one, 1, *numbers, *([(c_int * 1)()] if name.startswith("GetInterval") else [])

    def _of_dependencies(self, name: str) -> tuple:
        output, n = self.fmu.variables["z"].reference, c_size_t()
        if name.startswith("GetNumber"):
            return output, byref(n)
        self.fmu.ok("GetNumberOfVariableDependencies", output, byref(n))
        size = n.value
        return output, (c_size_t * size)(), (c_uint * size)(), (c_size_t * size)(), (c_int * size)(), size


OF_OTHER_TYPES = ("Binary", "Clock", "Interval", "Shift")
VECTORS = {
    "SetContinuousStates": (2, 0), "GetContinuousStates": (2, 0), "GetContinuousStateDerivatives": (2, 0),
    "GetNominalsOfContinuousStates": (2, 0), "GetEventIndicators": (7, 1),
}  # fmt: skip

# ---- states ----


def enter(fmu: Driver, state: str) -> None:
    main = {"tau": 1.2} if fmu.model is FORWARD else {"theta": 0.3}
    fmu.set({"cam1.friction": 0.17})
    if state == "instantiated":
        return
    fmu.ok("EnterInitializationMode", False, 0.0, 0.0, False, 0.0)
    fmu.set(main)
    if state == "initialization":
        return
    fmu.ok("ExitInitializationMode")
    fmu.time = 0.0
    if state == "event":
        return
    if fmu.exchange:
        fmu.settle()
        fmu.ok("EnterContinuousTimeMode")
        fmu.ok("SetTime", 0.25)
    else:
        if fmu.events:
            fmu.settle()
            fmu.ok("EnterStepMode")
        fmu.step(0.01)
    if state == "terminated":
        fmu.ok("Terminate")


def makes(interface: str, state: str) -> list[dict]:
    """Options of the instances that have this state."""
    if interface == "ME":
        return [{"exchange": True}]
    if state in ("event", "step of events"):
        return [{"events": True, "early": True}]
    return [{}] if state == "step" else [{}, {"events": True}]


def test_version_needs_no_instance(libraries3):
    assert {library.fmi3GetVersion() for library in libraries3.values()} == {b"3.0"}


@each_model
@pytest.mark.parametrize("place", [state for state in TABLE.states if state not in INSIDE_A_STEP])
def test_every_call(make3, model, place):
    interface, state = place.split(" ", 1)
    cells = TABLE.of(place, WITHOUT_INSTANCE)
    asked = {"required": ASKED_FOR[model]} if interface == "CS" else {}
    for options in makes(interface, state):
        kind = "model exchange" if interface == "ME" else "co-simulation"
        words = (f'"{PHASE[state]}"', f"in {kind}")
        check_every_call(
            lambda options=options: make3(model, **options, **asked),
            lambda fmu: enter(fmu, state), cells, words, Arguments,
        )  # fmt: skip


@pytest.mark.parametrize(
    ("model", "place"),
    [(FORWARD, "CS intermediate set"), (FORWARD, "CS intermediate get"), (INVERSE, "CS intermediate get")],
)
def test_every_call_inside_a_step(make3, model, place):
    """From the first callback of this kind. The step then gives what a step without these calls gives, bit
    for bit: the calls set tau to one value and nothing else."""
    cells = TABLE.of(place, WITHOUT_INSTANCE)
    words = (f'"inside a step, for {INSIDE_A_STEP[place]}"', "in co-simulation")
    sets, done = place == "CS intermediate set", []

    def check(fmu):
        check = StateCheck(words, Arguments(fmu, saves=False))
        check.run(cells)
        done.append(check.wrong)

    def at_first(action):
        def update(fmu, _time, asks, *_):
            if asks == sets and fmu not in met:
                met.append(fmu)
                action(fmu)

        met: list[Driver] = []
        return update

    fmus = []
    for action in (check, lambda fmu: fmu.set({"tau": 0.25}) if sets else None):
        fmus.append(make3(model, update=at_first(action), required=ASKED_FOR[model]).start())
        fmus[-1].step(0.1, **({"tau": 1.2} if model is FORWARD else {"theta": 0.3}))
    assert done == [[]], "\n" + "\n".join(done[0])
    assert fmus[0].everything() == fmus[1].everything()
    assert fmus[0].state_bytes() == fmus[1].state_bytes()
