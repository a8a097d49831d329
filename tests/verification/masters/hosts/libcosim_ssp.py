"""Runs an SSP package in libcosim; arguments: package.py. The step size is the one in the package."""

import ctypes

import package
from libcosimpy._internal import libcosimc
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver

work = package.from_arguments()
log_output_level(CosimLogLevel.WARNING)
try:
    execution = CosimExecution.from_ssp_file(ssp_path=work.package)
except AssertionError:  # its text does not say why
    last_error_message = libcosimc().cosim_last_error_message
    last_error_message.restype = ctypes.c_char_p
    raise SystemExit(f"libcosim refused the package: {last_error_message().decode()}") from None


def place(name: str) -> tuple[int, int]:
    """Index of the component and value reference."""
    component, variable = name.split(".", 1)
    index = execution.slave_index_from_instance_name(component)
    known = {v.name.decode(): v.reference for v in execution.slave_variables(index)}
    return index, known[variable]


columns = [place(name) for name in work.watched]
passed = [(place(source), place(target)) for source, target in work.passed]
observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
if not (execution.add_observer(observer) and execution.add_manipulator(manipulator)):
    raise SystemExit("libcosim refused a call")


def values(places: list[tuple[int, int]]) -> list[float]:
    """The latest values, by one call per component."""
    found: dict[tuple[int, int], float] = {}
    for index in {index for index, _ in places}:
        references = [reference for i, reference in places if i == index]
        found |= {
            (index, reference): value
            for reference, value in zip(references, observer.last_real_values(index, references), strict=True)
        }
    return [found[one] for one in places]


rows = []
for _ in range(work.rows):
    if not execution.step(work.every):
        raise SystemExit("libcosim refused a step")
    rows.append(values(columns))
    sources = values([source for source, _ in passed])
    for (_source, target), value in zip(passed, sources, strict=True):
        if not manipulator.slave_real_values(target[0], [target[1]], [value]):
            raise SystemExit(f"libcosim refused to set the variable of value reference {target[1]}")
work.save(rows)
