"""Plays one scene in ecos; arguments: job.py. Beside the outputs it leaves ecos' own CSV file."""

import job
from ecospy import EcosLib, EcosSimulation, EcosSimulationStructure

work = job.from_arguments()
EcosLib.set_log_level("warn")
system = EcosSimulationStructure()
system.add_model("cam", work.fmu)
system.add_parameter_set("start", {f"cam::{name}": value for name, value in work.start.items()})

with EcosSimulation(structure=system, step_size=work.step) as simulation:
    printed = work.file.with_suffix(".printed.csv")
    simulation.add_csv_writer(str(printed), identifiers=[f"cam::{name}" for name in work.outputs])

    def read() -> list[float]:
        reals, integers = simulation.get_real, simulation.get_integer
        return [(integers if name in job.INTEGERS else reals)(f"cam::{name}") for name in work.outputs]

    if not simulation.init(parameter_set="start"):
        raise SystemExit(EcosLib.get_last_error())
    rows = [read()]
    for row in work.inputs[:-1]:
        for name, value in row.items():
            simulation.set_real(f"cam::{name}", value)
        simulation.step()
        rows.append(read())
    simulation.terminate()
work.save(rows)
