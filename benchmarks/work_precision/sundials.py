"""SUNDIALS: our model-exchange FMU in FMPy's CVode, and the plain equations in scikit-sundae."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Model
from fmpy.sundials import CVodeSolver

from benchmarks.harness.fmu import Slave
from benchmarks.work_precision.plain_cam import Failure, Rates
from benchmarks.work_precision.scenes import Points, Result, Scene


class NoInput:
    """Torque is constant while CVode integrates."""

    def apply(self, time: float) -> None:
        pass


class Exchange:
    """Our model-exchange FMU in FMPy's CVode: no maximum step, nothing recorded."""

    def __init__(self, scene: Scene, tolerance: float) -> None:
        self.scene, self.tolerance = scene, tolerance
        self.slave = Slave()
        old = self.slave.fmu
        self.model = FMU2Model(
            guid=old.guid, unzipDirectory=old.unzipDirectory, modelIdentifier=old.modelIdentifier
        )
        self.model.instantiate()
        self.slave.fmu = self.model
        self.reads = [self.slave.references[n] for n in ("theta", "omega")]

    def event(self, tau: float | None = None) -> None:
        model = self.model
        model.enterEventMode()
        if tau is not None:
            model.setReal([self.slave.references["tau"]], [tau])
        while model.newDiscreteStates()[0]:
            pass
        model.enterContinuousTimeMode()

    def run(self) -> tuple[float, Result]:
        model, scene = self.model, self.scene
        model.reset()
        self.slave.set(scene.parameters)
        model.setupExperiment(startTime=0.0)
        model.enterInitializationMode()
        self.slave.set({"tau": scene.pieces[0][1]})
        model.exitInitializationMode()
        while model.newDiscreteStates()[0]:
            pass
        model.enterContinuousTimeMode()
        solver = CVodeSolver(
            nx=self.slave.description.numberOfContinuousStates,
            nz=self.slave.description.numberOfEventIndicators,
            get_x=model.getContinuousStates,
            set_x=model.setContinuousStates,
            get_dx=model.getDerivatives,
            get_z=model.getEventIndicators,
            get_nominals=model.getNominalsOfContinuousStates,
            set_time=model.setTime,
            input=NoInput(),
            startTime=0.0,
            relativeTolerance=self.tolerance,
            maxNumSteps=1_000_000,
        )
        points: Points = []
        instant, until = 0.0, 0.0
        start = time.perf_counter()
        for number, (duration, tau) in enumerate(scene.pieces):
            if number > 0:
                self.event(tau)
                solver.reset(instant)
            until += duration
            while until - instant > 1e-12 * until:
                state_event, _, instant = solver.step(instant, until)
                model.setTime(instant)
                step_event, _ = model.completedIntegratorStep()
                if state_event or step_event:
                    self.event()
                    solver.reset(instant)
            theta, omega = model.getReal(self.reads)
            points.append((theta, omega))
        return time.perf_counter() - start, scene.result(points)


def sundae_advance(method: str, rtol: float) -> Callable[..., tuple[float, float, float]]:
    """As scipy_advance, by scikit-sundae's CVODE."""
    from sksundae.cvode import CVODE

    rates: list[Rates] = []

    def right(t: float, y: Any, yp: Any) -> None:  # noqa: ANN401
        yp[:] = rates[0](t, y)

    solvers = {}
    for sigma in (1, -1):

        def rest(_t: float, y: Sequence[float], events: Any) -> None:  # noqa: ANN401
            events[0] = y[1]

        marked: Any = rest
        marked.terminal, marked.direction = [True], [-sigma]
        options = {"method": method, "rtol": rtol, "atol": rtol, "max_num_steps": 1_000_000}
        solvers[sigma] = CVODE(right, eventsfn=rest, num_events=1, **options)

    def advance(
        moving: Rates, sigma: int, left: float, theta: float, omega: float
    ) -> tuple[float, float, float]:
        rates[:] = [moving]
        solver = solvers[sigma]
        solver.init_step(0.0, np.array([theta, omega]))
        found = solver.step(left, tstop=left)
        if not found.success:
            raise Failure(found.message)
        t, y = float(found.t), np.ravel(found.y)
        if t < left * (1.0 - 1e-12):
            return left - t, float(y[0]), 0.0
        return 0.0, float(y[0]), float(y[1])

    return advance
