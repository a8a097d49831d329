"""Plays one scene in libcosim; arguments: job.py."""

import job
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def insist(good: bool) -> None:
    if not good:
        raise SystemExit("libcosim refused a call")


work = job.from_arguments()
log_output_level(CosimLogLevel.WARNING)
execution = CosimExecution.from_step_size(step_size=round(work.step * 1e9))  # nanoseconds
cam = execution.add_local_slave(CosimLocalSlave(fmu_path=work.fmu, instance_name="cam"))
references = {variable.name.decode(): variable.reference for variable in execution.slave_variables(cam)}
observer, manipulator = CosimObserver.create_time_series(), CosimManipulator.create_override()
insist(execution.add_observer(observer) and execution.add_manipulator(manipulator))
for name in work.outputs:
    kind = CosimVariableType.INTEGER if name in job.INTEGERS else CosimVariableType.REAL
    insist(observer.start_time_series(cam, references[name], kind))
set_initial = {
    float: execution.real_initial_value,
    int: execution.integer_initial_value,
    str: execution.string_initial_value,
}
for name, value in work.start.items():
    insist(set_initial[type(value)](cam, references[name], value))

# Nothing can be read before the first step; a series keeps back its newest sample and gives one less than is
# asked for. So it is read at the end, after one step more.
for row in work.inputs:
    if row:
        names = [references[name] for name in row]
        insist(manipulator.slave_real_values(cam, names, list(row.values())))
    insist(execution.step())

columns = []
for name in work.outputs:
    integer = name in job.INTEGERS
    get = observer.time_series_integer_samples if integer else observer.time_series_real_samples
    columns.append(get(cam, references[name], 0, len(work.inputs) + 1)[2])
work.save(zip(*columns, strict=True))
