"""Runs an SSP package in libcosim; arguments: package.py. The step size is the one in the package."""

import package
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver

work = package.from_arguments()
log_output_level(CosimLogLevel.WARNING)
execution = CosimExecution.from_ssp_file(ssp_path=work.package)
places: dict[int, list[tuple[int, int]]] = {}  # by component: column, value reference
for column, name in enumerate(work.watched):
    component, variable = name.split(".", 1)
    index = execution.slave_index_from_instance_name(component)
    known = {v.name.decode(): v.reference for v in execution.slave_variables(index)}
    places.setdefault(index, []).append((column, known[variable]))
observer = CosimObserver.create_last_value()
if not execution.add_observer(observer):
    raise SystemExit("libcosim refused a call")

rows = []
for _ in range(work.rows):
    if not execution.step(work.every):
        raise SystemExit("libcosim refused a step")
    row = [0.0] * len(work.watched)
    for index, watched in places.items():
        values = observer.last_real_values(index, [reference for _, reference in watched])
        for (column, _), value in zip(watched, values, strict=True):
            row[column] = value
    rows.append(row)
work.save(rows)
