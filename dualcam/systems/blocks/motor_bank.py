"""Many equal motors under their current loops, in a few operations of NumPy per control period."""

import numpy as np
from numpy.typing import NDArray

from dualcam.design.statics import Array
from dualcam.systems.blocks.current_loop import CurrentLoop, MotorPeriod
from dualcam.systems.blocks.elementwise import limited
from dualcam.systems.blocks.motor import Motor

SETTLED = 1e-12  # of the motor's voltage: the integral part and R i differ by less
SETTLING = 40  # control periods after which a CurrentLoop has settled to rounding


class MotorBank:
    """Many equal motors, each under a `CurrentLoop`.

    While the voltage stays inside its limits a current loop is linear. Its integral part is then R i: the
    zero of the PI cancels the pole of the winding. So all samples of a control period make one map. With the
    wanted current r, the current i at the beginning and d = i - r:

        mean of i = r + m d     i at the end = r + e d     integral of i^2 = T r^2 + b r d + c d^2

    m, e, T, b and c are measured on a `CurrentLoop`. The energy from the supply is the heat, the change of
    L i^2/2 and the work against the back-EMF. The voltage runs from its first sample to R r + back-EMF
    without a turn, so two values tell whether a limit is met. Motors that meet a limit, or have not settled
    since, run sample by sample.

    Parameters
    ----------
    motor : The motor. All start without current.
    count : Number of motors.

    Attributes
    ----------
    current : Currents now [A], shape (count,).

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.blocks.motor import AK80_6
    >>> from dualcam.systems.blocks.motor_bank import MotorBank
    >>> bank = MotorBank(AK80_6, count=2)
    >>> for _ in range(5):
    ...     period = bank.run(torque=np.array([5.0, -2.0]), speed=np.array([1.0, 0.0]))
    >>> period.torque.round(3).tolist(), period.heat.round(4).tolist()  # N.m, J
    ([5.0, -2.0], [0.0143, 0.0023])
    """

    def __init__(self, motor: Motor, count: int) -> None:
        self.motor = motor
        self.current = np.zeros(count)
        self._integral_voltage = np.zeros(count)
        self._loop = loop = CurrentLoop(motor)
        one = motor.output_constant  # N.m of 1 A
        rise = loop.run(one, 0.0)  # from 0 to 1 A
        self._mean, self._end = 1.0 - rise.torque / one, 1.0 - loop.current
        for _ in range(SETTLING):
            hold = loop.run(one, 0.0)
        fall = loop.run(0.0, 0.0)
        squares = np.array([hold.heat, hold.heat + fall.heat - rise.heat, fall.heat]) / motor.resistance
        self._squares = tuple(squares.tolist())  # T, b, c [s]

    def stop(self, chosen: NDArray[np.bool_]) -> None:
        """Begin anew without current in the motors that are `chosen`: truth values, shape (count,)."""
        self.current[chosen] = self._integral_voltage[chosen] = 0.0

    def run(self, torque: Array, speed: Array) -> MotorPeriod[Array]:
        """Run one control period. Returns what the motors did, as `CurrentLoop.run` gives it.

        `torque` asked for at the output [N.m], shape (count,); larger ones than the motor's peak torque are
        cut. `speed` of the output [rad/s], constant over the period, shape (count,).
        """
        motor, before = self.motor, self.current
        wanted = limited(torque, -motor.peak_torque, motor.peak_torque) / motor.output_constant
        back_emf = motor.output_constant * speed
        start = before - wanted
        first = self._integral_voltage - self._loop.proportional * start + back_emf  # V, of the first sample
        last = motor.resistance * wanted + back_emf
        highest = np.maximum(np.abs(first), np.abs(last))
        unsettled = np.abs(self._integral_voltage - motor.resistance * before)
        by_samples = (highest > motor.voltage) | (unsettled > SETTLED * motor.voltage)
        after = wanted + self._end * start
        mean = motor.output_constant * (wanted + self._mean * start)
        whole, mixed, square = self._squares
        heat = motor.resistance * ((whole * wanted + mixed * start) * wanted + square * start * start)
        magnetic = 0.5 * motor.inductance * (after * after - before * before)
        period = MotorPeriod(
            torque=mean,
            peak_torque=motor.output_constant * np.maximum(np.abs(before), np.abs(after)),
            heat=heat,
            energy=heat + magnetic + mean * speed * self._loop.control_period,
        )
        integral_voltage = motor.resistance * after
        if by_samples.any():
            self._run_samples(np.flatnonzero(by_samples), torque, speed, period, after, integral_voltage)
        self.current, self._integral_voltage = after, integral_voltage
        return period

    def _run_samples(
        self,
        rows: NDArray[np.intp],
        torque: Array,
        speed: Array,
        period: MotorPeriod[Array],
        current: Array,
        integral_voltage: Array,
    ) -> None:
        """Put what the loop does sample by sample into some rows of the results."""
        loop = self._loop
        loop.current, loop.integral_voltage = self.current[rows], self._integral_voltage[rows]
        done = loop.run(torque[rows], speed[rows])
        for name in ("torque", "peak_torque", "heat", "energy"):
            getattr(period, name)[rows] = getattr(done, name)
        current[rows], integral_voltage[rows] = loop.current, loop.integral_voltage
