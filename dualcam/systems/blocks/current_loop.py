"""The current loop of a motor: a PI controller that runs many times within one period of the outer loop."""

import math
from dataclasses import dataclass
from typing import Any, Generic

from dualcam.systems.blocks.elementwise import Number, extremes, limited
from dualcam.systems.blocks.motor import Motor

CONTROL_PERIOD = 1e-3  # s, period of the outer loop, which is also the FMU's communication step
CURRENT_RATE = 20e3  # Hz, samples of the current loop
CURRENT_BANDWIDTH = 1e3  # Hz


@dataclass(frozen=True)
class MotorPeriod(Generic[Number]):
    """What a motor did within one control period, or each of many motors.

    Parameters
    ----------
    torque : Torque at the output, mean [N.m], float or shape (count,).
    peak_torque : Torque at the output, largest magnitude [N.m], float or shape (count,).
    heat : Heat in the winding, the integral of R i^2 [J], float or shape (count,).
    energy : Energy from the supply, the integral of v i [J], float or shape (count,).
    """

    torque: Number
    peak_torque: Number
    heat: Number
    energy: Number


class CurrentLoop:
    """A motor under a PI current loop that runs many times within a control period.

    Between two samples of the PI the voltage is constant, so the current is an exponential in time. With
    a = exp(-R Ts/L) the samples obey i' = a i + (1 - a)/R (v - Kt gear omega). The integrals of i and i^2
    are closed forms too. Nothing is integrated numerically. The speed is constant over the control period;
    its voltage is fed forward.

    Design, on the sampled winding b/(z - a) with b = (1 - a)/R: the PI's zero cancels the winding's pole. The
    PI's gain puts the remaining pole at exp(-2 pi bandwidth Ts). A step r of the reference is answered by
    i_k = r (1 - exp(-2 pi bandwidth k Ts)), without overshoot. So a limited reference limits the current.

    The same object serves many equal motors: give `run` arrays with one entry per motor.

    Parameters
    ----------
    motor : The motor, which starts without current.
    bandwidth : Bandwidth of the current loop [Hz].
    rate : Samples of the current loop [Hz].
    control_period : Period of the outer loop [s].

    Examples
    --------
    >>> from dualcam.systems.blocks.current_loop import CurrentLoop
    >>> from dualcam.systems.blocks.motor import AK80_6
    >>> loop = CurrentLoop(AK80_6)
    >>> period = [loop.run(torque=5.0, speed=1.0) for _ in range(5)][-1]
    >>> round(period.torque, 3), round(period.heat, 4)  # N.m, J: R (5 N.m/(0.546 N.m/A))^2 times 1 ms
    (5.0, 0.0143)
    """

    def __init__(
        self,
        motor: Motor,
        bandwidth: float = CURRENT_BANDWIDTH,
        rate: float = CURRENT_RATE,
        control_period: float = CONTROL_PERIOD,
    ) -> None:
        self.motor = motor
        self.control_period = control_period
        self.samples = round(control_period * rate)
        self.sample_period = control_period / self.samples  # s
        self.pole = math.exp(-self.sample_period / motor.electrical_time_constant)  # a
        self.closed_pole = math.exp(-2.0 * math.pi * bandwidth * self.sample_period)
        self.proportional = (1.0 - self.closed_pole) * motor.resistance / (1.0 - self.pole)  # V/A
        self.integral = self.proportional * (1.0 - self.pole)  # V/A per sample
        self.current: Any = 0.0  # A; an array after `run` with arrays
        self.integral_voltage: Any = 0.0  # V, the PI's integral part

    def run(self, torque: Number, speed: Number) -> MotorPeriod[Number]:
        """Run one control period. Returns what the motor did.

        `torque` asked for at the output [N.m], float or shape (count,); larger ones than the motor's peak
        torque are cut. `speed` of the output [rad/s], float or shape (count,).
        """
        motor = self.motor
        torque = limited(torque, -motor.peak_torque, motor.peak_torque)
        reference = torque / motor.output_constant
        back_emf = motor.output_constant * speed
        highest, lowest = motor.voltage - back_emf, -motor.voltage - back_emf  # V across the winding
        pole, period, gain, resistance = self.pole, self.sample_period, self.proportional, motor.resistance
        decay = motor.electrical_time_constant * (1.0 - pole)  # s, integral of the response from 1 to 0
        decay_square = 0.5 * decay * (1.0 + pole)  # s, integral of its square
        least, most = extremes(reference)
        current, integral_voltage, peak = self.current, self.integral_voltage, abs(self.current)
        charge = square = energy = 0.0 * reference  # integrals of i, i^2 and v i
        for _ in range(self.samples):
            error = reference - current
            wanted = gain * error + integral_voltage
            voltage = least(most(wanted, lowest), highest)
            # at a voltage limit the integral part stands still, else it would wind up
            integral_voltage = integral_voltage + self.integral * error * (voltage == wanted)
            final = voltage / resistance
            start = current - final
            transient = start * decay
            area = final * period + transient
            charge = charge + area
            square = square + (final * (area + transient) + start * start * decay_square)
            energy = energy + (voltage + back_emf) * area
            current = final + start * pole
            peak = most(peak, abs(current))
        self.current, self.integral_voltage = current, integral_voltage
        duration = period * self.samples
        return MotorPeriod(
            torque=motor.output_constant * charge / duration,
            peak_torque=motor.output_constant * peak,
            heat=resistance * square,
            energy=energy,
        )
