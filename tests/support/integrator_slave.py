"""A model for PythonFMU: the sum of its input over the steps, times a gain."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class IntegratorSlave(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.gain = 1.0
        self.u = 0.0
        self.y = 0.0
        tunable = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}
        self.register_variable(Real("gain", **tunable))
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.y += step_size * self.gain * self.u
        return True
