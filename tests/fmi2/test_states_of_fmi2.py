"""FMI 2.0.5: each function in each state, as states.csv says.

States without a column: stepInProgress, stepFailed and stepCanceled follow fmi2Pending and fmi2Discard of
fmi2DoStep, state fatal follows fmi2Fatal. The FMU never returns these. State error: note `error`.
"""

from ctypes import byref, c_char_p, c_double, c_int, c_size_t, create_string_buffer
from pathlib import Path

import pytest
from driver import ARGUMENTS, CO_SIMULATION, LAST_SUCCESSFUL_TIME, MODEL_EXCHANGE, TERMINATED, EventInfo, to_c
from fmi2_inputs import INVERSE, drive
from state_table import StateTable, ValidArguments, check_every_call

TABLE = StateTable(Path(__file__).parent)
PHASE = {
    "instantiated": "instantiated", "initialization": "initialization mode", "event": "event mode",
    "continuous": "continuous-time mode", "step": "step mode", "terminated": "terminated",
}  # fmt: skip
INTERFACE = {"ME": "model exchange", "CS": "co-simulation"}
WITHOUT_INSTANCE = {"fmi2GetVersion", "fmi2GetTypesPlatform"}


def test_the_table_has_every_function_of_an_instance():
    assert TABLE.functions == {*ARGUMENTS, *WITHOUT_INSTANCE, "fmi2FreeInstance"}


def test_each_deviation_has_a_note():
    TABLE.check_notes()


class Arguments(ValidArguments):
    MAY_BE_NULL = frozenset({("fmi2FreeFMUstate", 0)})

    def of(self, function: str) -> tuple:
        fmu = self.fmu
        states = 0 if fmu.model is INVERSE else 2
        indicators = 1 if fmu.model is INVERSE else 7
        flag = [c_int() for _ in range(2)]
        one, order = to_c("Real", [1.0]), (c_int * 1)(1)
        known, unknown = fmu.model.references(["F_ext"]), fmu.model.references(["z"])
        if function in STATUS:
            kind, room = STATUS[function]
            return kind, byref(room())
        if function in ("fmi2SetFMUstate", *OF_STATES, "fmi2FreeFMUstate"):
            return self._of_a_state(function)
        return {
            "fmi2SetDebugLogging": (1, 1, (c_char_p * 1)(b"logStatusError")),
            "fmi2SetupExperiment": (0, 0.0, 0.0, 0, 0.0),
            "fmi2GetDirectionalDerivative": (unknown, 1, known, 1, one, to_c("Real", [0.0])),
            "fmi2GetFMUstate": (byref(self.made),),
            "fmi2NewDiscreteStates": (byref(EventInfo()),),
            "fmi2CompletedIntegratorStep": (1, byref(flag[0]), byref(flag[1])),
            "fmi2SetTime": (0.5,),
            "fmi2SetContinuousStates": ((c_double * states)(*[0.3, 1.0][:states]), states),
            "fmi2GetEventIndicators": ((c_double * indicators)(), indicators),
            "fmi2GetContinuousStates": ((c_double * states)(), states),
            "fmi2GetDerivatives": ((c_double * states)(), states),
            "fmi2GetNominalsOfContinuousStates": ((c_double * states)(), states),
            "fmi2SetRealInputDerivatives": (known, 1, order, one),
            "fmi2GetRealOutputDerivatives": (unknown, 1, order, one),
            "fmi2DoStep": (fmu.time, 0.01, 1),
        }.get(function, ())

    def _of_a_state(self, function: str) -> tuple:
        if function == "fmi2DeSerializeFMUstate":
            content = self.fmu.state_bytes()
            return content, len(content), byref(self.made)
        if not self.made:
            self.made = self.fmu.take()
        size = len(self.fmu.to_bytes(self.made))
        return {
            "fmi2SetFMUstate": (self.made,),
            "fmi2FreeFMUstate": (byref(self.made),),
            "fmi2SerializedFMUstateSize": (self.made, byref(c_size_t())),
            "fmi2SerializeFMUstate": (self.made, create_string_buffer(size), size),
        }[function]


OF_STATES = ("fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate")
STATUS = {
    "fmi2GetStatus": (0, c_int),
    "fmi2GetRealStatus": (LAST_SUCCESSFUL_TIME, c_double),
    "fmi2GetIntegerStatus": (0, c_int),
    "fmi2GetBooleanStatus": (TERMINATED, c_int),
    "fmi2GetStringStatus": (1, c_char_p),
}


def enter(fmu, kind: int, state: str) -> None:
    fmu.set({"cam1.friction": 0.17})
    if state == "instantiated":
        return
    fmu.setup()
    fmu.ok("fmi2EnterInitializationMode")
    fmu.set(drive(fmu, 0.2))
    if state == "initialization":
        return
    fmu.ok("fmi2ExitInitializationMode")
    if state == "event":
        return
    if kind == CO_SIMULATION:
        fmu.step(0.01, **drive(fmu, 1.2))
    else:
        fmu.settle()
        fmu.ok("fmi2SetTime", 0.25)
        fmu.set(drive(fmu, 0.3))
    if state == "terminated":
        fmu.ok("fmi2Terminate")


def test_version_and_types_need_no_instance(library):
    assert (library.fmi2GetVersion(), library.fmi2GetTypesPlatform()) == (b"2.0", b"default")


@pytest.mark.parametrize("place", TABLE.states)
def test_every_call(make, place):
    interface, state = place.split()
    kind = MODEL_EXCHANGE if interface == "ME" else CO_SIMULATION
    cells = TABLE.of(place, WITHOUT_INSTANCE)
    words = (f'"{PHASE[state]}"', f"in {INTERFACE[interface]}")
    check_every_call(lambda: make(kind=kind), lambda fmu: enter(fmu, kind, state), cells, words, Arguments)
