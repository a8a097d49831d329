"""The binary of an FMU with one instance in it: what FMI 2.0 and FMI 3.0 have in common.

`dualcam.fmi.fmi2` and `dualcam.fmi.fmi3` have the calls of each version. The handles of `dualcam.fmi.fmu` use
the methods of Instance alone.
"""

import ctypes
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from ctypes import c_double, c_int, c_size_t, c_uint, c_void_p
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Literal, NoReturn

from dualcam.errors import FmuError
from dualcam.fmi.binary import Unpacked, Use, interface_of, library_file, load, unload
from dualcam.fmi.model_description import ModelDescription, Scalar, Variable

OK_OR_WARNING = 1  # FMI's status up to this is success
MESSAGES_KEPT = 8  # an FMU may log warnings without end

CALL_START = "no run has begun: call start() first"
START_FAILED = "the last start() failed: call start() with values that the FMU accepts"
CLOSED = "this FMU is closed: open a new one"

References = ctypes.Array[c_uint]
Reals = ctypes.Array[c_double]
Function = Callable[..., int]
Orders = Sequence[int]
Calls = list[tuple[str, tuple[object, ...]]]  # names and arguments of FMI functions


class Instance(ABC):
    """A loaded binary with one instance, freed once. It has no reference to its handle: a dropped handle can
    free it. While calls are not allowed, `get_real`, `set_real` and `do_step` say why."""

    VERSION: ClassVar[int]  # of FMI
    GET_REAL = SET_REAL = DO_STEP = RESET = EXIT_INITIALIZATION = SET_STATE = ""  # names of FMI functions
    ENUMERATION: ClassVar[str]  # the type as which enumerations are read and written
    CTYPES: ClassVar[dict[str, Any]]  # type of a variable -> type in C

    get_real: Function
    set_real: Function
    do_step: Function
    step_end: tuple[object, ...] = ()  # the last arguments of do_step

    def __init__(self, path: Path, description: ModelDescription, use: Use) -> None:
        """FmuError if the FMU has no such use or no binary for this platform, or gives no instance."""
        self.messages: deque[str] = deque(maxlen=MESSAGES_KEPT)  # logged since the last error
        self.states: set[int] = set()  # addresses of FMU states not yet freed
        self.is_open = False
        self.refusal = CALL_START
        self._refuse_fast_calls()
        interface = interface_of(path, description, use)
        self._unpacked = Unpacked(path, description.fmi_major)
        self.directory = self._unpacked.folder
        try:
            file = library_file(path, self.directory, interface, description.fmi_major)
            self.library = load(ctypes.CDLL, path, file)
            # Calls through it keep Python's lock: giving it away and taking it back takes longer than a call
            # that only copies values.
            self.brief = load(ctypes.PyDLL, path, file)
            try:
                self.component = self._made(path, description, use)
            except BaseException:
                self._unload()
                raise
        except BaseException:
            self._unpacked.delete()
            raise
        self.is_open = True

    def _made(self, path: Path, description: ModelDescription, use: Use) -> c_void_p:
        try:
            address = self._instantiate(description, use)
        except AttributeError as error:
            raise FmuError(f"{path}: the library lacks an FMI function: {error}") from error
        if address is None:
            reasons = "; ".join(self.messages) or "the FMU gave no reason"
            raise FmuError(f"{path}: the FMU made no instance: {reasons}")
        return c_void_p(address)

    @abstractmethod
    def _instantiate(self, description: ModelDescription, use: Use) -> int | None:
        """The address of a new instance of the loaded library."""

    @abstractmethod
    def _loop_functions(self) -> tuple[Function, Function, Function]:
        """get_real, set_real and do_step."""

    def allow_calls(self) -> None:
        """Values can be read and written, and steps be made."""
        self.refusal = ""
        self.get_real, self.set_real, self.do_step = self._loop_functions()

    def refuse_calls(self, reason: str) -> None:
        """Until `allow_calls`, reading, writing and stepping is an FmuError that says the reason."""
        self.refusal = reason if self.is_open else CLOSED
        self._refuse_fast_calls()

    def _refuse_fast_calls(self) -> None:
        self.get_real = self.set_real = self.do_step = self._refuse

    def _refuse(self, *_: object) -> NoReturn:
        raise FmuError(self.refusal)

    def require_calls_allowed(self) -> None:
        """FmuError while calls are refused."""
        if self.refusal:
            raise FmuError(self.refusal)

    def require_open(self) -> None:
        """FmuError where the FMU is closed."""
        if not self.is_open:
            raise FmuError(CLOSED)

    def named(self, two: str, three: str = "") -> str:
        """The name of an FMI function by its end in FMI 2.0, and its end in FMI 3.0 where that differs."""
        return f"fmi3{three or two}" if self.VERSION == 3 else f"fmi2{two}"

    def function(self, name: str) -> Function:
        """The FMI function `name`, which returns FMI's status. Its arguments are values of ctypes."""
        return self.library[name]  # a new object, which shares no argument types

    def brief_function(self, name: str) -> Function:
        """As `function`, for calls that only copy values."""
        return self.brief[name]

    def step_function(self) -> Function:
        """As `function`, for the step."""
        return self.function(self.DO_STEP)

    def call(self, name: str, *arguments: object) -> None:
        """Call the FMI function `name`; FmuError with the FMU's message if the call fails."""
        self.require_open()
        self.check(getattr(self.library, name)(self.component, *arguments), name)

    def check(self, status: int, name: str) -> None:
        """FmuError with the messages of the FMU if `status` of function `name` is no success."""
        if status > OK_OR_WARNING:
            text = "; ".join(self.messages) or f"{name} returned status {status}, without a message"
            self.messages.clear()
            raise FmuError(text)

    def free(self) -> None:
        """Free the instance and the files, once. A forked child lacks the FMU's threads and forgets both."""
        if not self._unpacked.is_own:
            self.abandon()
        if not self.is_open:
            return
        for address in list(self.states):
            self.free_state(address)
        self._close()
        free = getattr(self.library, self.named("FreeInstance"))
        free.restype = None
        free(self.component)
        self._unload()
        self._unpacked.delete()

    def abandon(self) -> None:
        """After FMI's status Fatal no function may be called, not even to free the instance."""
        if self.is_open:
            self.states.clear()
            self._close()
            self._unpacked.delete()

    def _close(self) -> None:
        self.is_open = False
        self.refuse_calls(CLOSED)

    def _unload(self) -> None:
        for library in (self.brief, self.library):
            unload(library._handle)

    def initialization_calls(self, tolerance: float | None, time: float = 0.0) -> Calls:
        """The calls that enter initialization mode at `time` [s]."""
        truth, enter = self.CTYPES["Boolean"], self.named("EnterInitializationMode")
        given = truth(tolerance is not None), c_double(tolerance or 0.0)
        setup = (*given, c_double(time), truth(False), c_double(0.0))  # without a stop time
        return [(enter, setup)] if self.VERSION == 3 else [("fmi2SetupExperiment", setup), (enter, ())]

    def sized(self, values: object, count: c_size_t) -> tuple[object, ...]:
        """`values` as arguments: FMI 3.0 wants their number again."""
        return (values, count) if self.VERSION == 3 else (values,)

    def real_arguments(self, references: References, values: Reals) -> tuple[object, ...]:
        """The arguments of get_real and set_real for a group of variables."""
        return (self.component, *self.access_arguments(references, values))

    def access(self, action: Literal["Get", "Set"], type_name: str) -> str:
        """Name of the FMI function that gets or sets variables of that type."""
        return self.named(f"{action}{self.ENUMERATION if type_name == 'Enumeration' else type_name}")

    def access_arguments(self, references: References, values: object) -> tuple[object, ...]:
        """The arguments of an access function after the instance; `values` points to the values in C."""
        count = c_size_t(len(references))
        return (references, count, *self.sized(values, count))

    def get(self, variable: Variable) -> Scalar:
        """The value of a variable."""
        content = self.CTYPES[_scalar(variable).type]()
        self._access("Get", variable, content)
        value = content.value
        if variable.kind == "string":
            return (value or b"").decode(errors="replace")
        return bool(value) if variable.kind == "boolean" else value

    def set(self, variable: Variable, value: Scalar) -> None:
        """Set a variable to a value of its kind."""
        content = self.CTYPES[_scalar(variable).type](value.encode() if isinstance(value, str) else value)
        if variable.kind == "integer" and content.value != value:  # C has no such number of this type
            text = f"{variable.name} = {value}: allowed are whole numbers of the type {variable.type}"
            raise FmuError(text)
        self._access("Set", variable, content)

    def _access(self, action: Literal["Get", "Set"], variable: Variable, content: object) -> None:
        references = (c_uint * 1)(variable.value_reference)
        arguments = self.access_arguments(references, ctypes.byref(content))  # type: ignore[arg-type]
        self.call(self.access(action, variable.type), *arguments)

    def output_derivatives(self, references: References, order: int, values: Reals) -> None:
        """Fill `values` with the time derivatives of outputs."""
        count, orders = c_size_t(len(references)), (c_int * len(references))(*[order] * len(references))
        name = self.named("GetRealOutputDerivatives", "GetOutputDerivatives")
        self.call(name, references, count, orders, *self.sized(values, count))

    @abstractmethod
    def input_derivatives_call(self, references: References, orders: Orders, values: Reals) -> partial[int]:
        """A call that sets time derivatives of inputs; FmuError where FMI has none."""

    def directional_derivative(
        self, unknowns: References, knowns: References, seed: Reals, product: Reals
    ) -> None:
        """Fill `product` with the partial derivatives of `unknowns` by `knowns` times `seed`."""
        rows, columns = c_size_t(len(unknowns)), c_size_t(len(knowns))
        values = (*self.sized(seed, columns), *self.sized(product, rows))
        self.call(self.named("GetDirectionalDerivative"), unknowns, rows, knowns, columns, *values)

    def save_state(self) -> int:
        """The address of a copy of the whole state."""
        address, name = c_void_p(), self.named("GetFMUstate", "GetFMUState")
        self.call(name, ctypes.byref(address))
        if address.value is None:
            raise FmuError(f"{name} gave no state")
        self.states.add(address.value)
        return address.value

    def free_state(self, address: int) -> None:
        """Free a saved state, once."""
        if address in self.states:
            self.states.remove(address)
            self.call(self.named("FreeFMUstate", "FreeFMUState"), ctypes.byref(c_void_p(address)))

    @abstractmethod
    def update_discrete_states(self) -> bool:
        """One event iteration; whether another one is needed. FmuError if the FMU ends the simulation."""

    def call_on_vector(self, name: str, values: Reals) -> None:
        """An FMI function that reads or writes states, their derivatives or event indicators."""
        self.call(name, values, c_size_t(len(values)))


def _scalar(variable: Variable) -> Variable:
    if variable.is_array or variable.kind in ("binary", "clock"):
        kind = "an array" if variable.is_array else f"of the type {variable.type}"
        raise FmuError(f"{variable.name} is {kind}: allowed are scalar numbers, booleans and texts")
    return variable
