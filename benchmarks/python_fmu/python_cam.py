"""The forward mechanism as users of PythonFMU write it: SciPy with events inside do_step.

The FMU holds this file and benchmarks/work_precision/plain_cam.py beside each other.
"""

import json

from plain_cam import PlainCam, scipy_advance  # type: ignore[import-not-found]
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real, String


class PythonCam(Fmi2Slave):
    def __init__(self, **kwargs: object) -> None:
        super().__init__(**kwargs)
        self.parameters, self.method = "{}", "DOP853"
        self.tolerance, self.tau, self.theta, self.omega = 1e-6, 0.0, 0.0, 0.0
        setting = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.fixed}
        for name in ("parameters", "method"):
            self.register_variable(String(name, **setting))
        self.register_variable(Real("tau", causality=Fmi2Causality.input))
        for name in ("theta", "omega"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        self.tolerance = tolerance or self.tolerance

    def exit_initialization_mode(self) -> None:
        self.cam = PlainCam(json.loads(self.parameters))
        self.theta, self.omega = self.cam.start
        self.advance = scipy_advance(self.method, self.tolerance)

    def do_step(self, current_time: float, step_size: float) -> bool:
        self.cam.start = self.theta, self.omega
        ((self.theta, self.omega),) = self.cam.run([(step_size, self.tau)], self.advance)
        return True
