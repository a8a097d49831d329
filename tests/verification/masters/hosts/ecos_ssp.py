"""Runs an SSP package in ecos; arguments: package.py."""

import package
from ecospy import EcosLib, EcosSimulation

work = package.from_arguments()
EcosLib.set_log_level("warn")
names = ["::".join(name.split(".", 1)) for name in work.watched]
rows = []
with EcosSimulation(ssp_path=work.package, step_size=work.step) as simulation:
    if not simulation.init(parameter_set=work.start):
        raise SystemExit(EcosLib.get_last_error())
    for _ in range(work.rows):
        simulation.step(work.every)
        rows.append([simulation.get_real(name) for name in names])
    simulation.terminate()
work.save(rows)
