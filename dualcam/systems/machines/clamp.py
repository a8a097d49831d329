"""A spring clamp with the dual cam in a cold hall: its cam, its servo, its grease, its thermal network.

Friction turns a part of each cycle's work into heat, which warms the grease and changes the friction. The
loop over the temperature is closed outside the FMU, once per cycle, while the clamp rests: the heat of both
contacts goes into the thermal network, and the temperature of the contact zone gives
`cam1.stribeck_velocity` and `cam1.friction_viscous` (likewise cam2), which are tuned.

The viscosity of the grease is that of a data sheet. The coefficients of friction and the thermal network are
plausible for greased steel and a housing of 1 kg, not measured.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from dualcam.design.statics import Array
from dualcam.fmi.fmu import Fmu
from dualcam.systems.blocks.grease import CELSIUS, BaseOil, GreasedContact
from dualcam.systems.blocks.helical_cam import HelicalCam
from dualcam.systems.blocks.motions import PickAndPlace
from dualcam.systems.blocks.thermal_network import ThermalState, TwoMassNetwork

RADIUS = (0.025, 0.025)  # m
LEAD_ANGLE = (np.pi / 4.0, np.pi / 4.0)  # rad
PRELOAD, STIFFNESS = 500.0, 80e3  # N, N/m: 500 to 1700 N over the stroke of 15 mm
INERTIA = 0.05  # kg.m2, with the servo's rotor behind its gear
STOPS = (-0.1, 1.3)  # rad, beyond both ends of the motion

HALL = CELSIUS + 5.0  # K, a winter morning
# Base oil: 110 mm2/s at 40 degC, 11 mm2/s at 100 degC (data sheet of SKF LGMT 2, lithium soap, NLGI 2).
# Static friction 0.12, kinetic 0.08. At 40 degC the film adds 0.016 at the largest sliding speed, 66 mm/s.
GREASE = GreasedContact(
    BaseOil(viscosity_40=110.0, viscosity_100=11.0),
    kinetic=0.08,
    peak=1.5,
    stribeck_velocity=0.02,
    viscous=0.25,
)
# Contact zone: pins and followers, 0.1 kg of steel. Housing and cams: 1 kg of steel, surface 0.02 m2.
NETWORK = TwoMassNetwork(
    contact_capacity=50.0,
    housing_capacity=460.0,
    contact_conductance=0.35,
    air_conductance=0.18,
    air=HALL,
)

MOTION = PickAndPlace(start=0.0, end=1.2, move=0.6, dwell=0.9)  # begins with a rest
SAMPLE = 5e-3  # s, of the servo
SETTLING = 0.1  # s, for which the servo goes on after a move; then it keeps its torque
BANDWIDTH = 60.0  # rad/s, both poles of the servo
SERVO_FRICTION = 0.1  # the one coefficient that the servo knows
SAMPLES_PER_CYCLE = round(MOTION.period / SAMPLE)
SAMPLES_TO_MIDDLE = round(0.5 * MOTION.move / SAMPLE)
TUNED = ("stribeck_velocity", "friction_viscous")  # of each cam


def cam(temperature: float, speed: float = 0.0) -> HelicalCam:
    """The cam with the friction at one sliding speed of both contacts.

    `temperature` of the contact zone [K]. `speed`: sliding speed [m/s]; 0: at rest.
    """
    mu = GREASE.coefficient(speed, temperature)
    return HelicalCam(RADIUS, LEAD_ANGLE, (mu, mu), PRELOAD, STIFFNESS)


def sliding_speed(omega: float) -> float:
    """Sliding speed of each contact [m/s]: each groove takes half of `omega` of the shaft [rad/s]."""
    return 0.5 * abs(omega) * RADIUS[0] / float(np.cos(LEAD_ANGLE[0]))


def steady_torque(theta: float, omega: float, temperature: float) -> float:
    """The torque of a motion without acceleration, in closed form [N.m].

    `theta`: angle [rad]. `omega`: speed [rad/s], not 0; > 0 loads. `temperature` of the contact zone [K].
    """
    return cam(temperature, sliding_speed(omega)).torque(theta, omega)


def plant_parameters(temperature: float) -> dict[str, float]:
    """Start values of the forward FMU at a `temperature` of the contact zone [K]."""
    return {
        **cam(temperature).parameters(),
        **GREASE.parameters(temperature),
        "inertia.shaft": INERTIA,
        "stop.lower": STOPS[0],
        "stop.upper": STOPS[1],
    }


class ServoSample(NamedTuple):
    """What the servo plans for one of its samples.

    `torque`: feed-forward in the middle of the sample: inertia and the known friction [N.m]. `angle`,
    `speed`: reference at the time of the measurement, one sample earlier [rad, rad/s].
    """

    torque: float
    angle: float
    speed: float


@dataclass(frozen=True)
class Servo:
    """Position control with feed-forward, for an axis whose friction the servo knows at one temperature only.

    The command that acts in a sample is computed from the measurement one sample earlier. After a move and
    SETTLING the servo keeps its torque until the next move: the stick band holds the clamp.

    `friction`: Coulomb coefficient that the servo knows [1]. `bandwidth`: both poles of the error without
    friction [rad/s].
    """

    friction: float = SERVO_FRICTION
    bandwidth: float = BANDWIDTH

    @property
    def cam(self) -> HelicalCam:
        """The cam that the servo knows."""
        return HelicalCam(RADIUS, LEAD_ANGLE, (self.friction, self.friction), PRELOAD, STIFFNESS)

    def plan(self) -> list[list[ServoSample]]:
        """The samples of one cycle in which the servo is active, of loading and of releasing."""
        half, active = SAMPLES_PER_CYCLE // 2, round((MOTION.move + SETTLING) / SAMPLE)
        times = MOTION.dwell + SAMPLE * np.arange(-1, SAMPLES_PER_CYCLE + 1)
        angle, speed = MOTION.sample(times)
        middle, mean = MOTION.sample(times + 0.5 * SAMPLE)
        plans = []
        for first in (0, half):
            plans.append(
                [
                    ServoSample(
                        self._feed_forward(
                            middle[k + 1], mean[k + 1], (speed[k + 2] - speed[k + 1]) / SAMPLE
                        ),
                        float(angle[k]),
                        float(speed[k]),
                    )
                    for k in range(first, first + active)
                ]
            )
        return plans

    def _feed_forward(self, angle: float, speed: float, acceleration: float) -> float:
        release, load = self.cam.band(angle)
        friction = load if speed > 0.0 else release if speed < 0.0 else 0.5 * (release + load)
        return float(INERTIA * acceleration + friction)

    def command(self, sample: ServoSample, angle: float, speed: float) -> float:
        """The torque [N.m] for a `sample` of the plan.

        `angle`, `speed`: the measurement, one sample earlier [rad, rad/s].
        """
        damping, stiffness = 2.0 * self.bandwidth * INERTIA, self.bandwidth**2 * INERTIA
        return sample.torque + damping * (sample.speed - speed) + stiffness * (sample.angle - angle)


class MidStroke(NamedTuple):
    """The middle of a move, where the planned acceleration is zero.

    `torque` of the servo [N.m]. `theta`, `omega`, `alpha`: motion of the shaft [rad, rad/s, rad/s2].
    `friction_coefficient`: friction coefficient of the contacts with cam 1 [1].
    """

    torque: float
    theta: float
    omega: float
    alpha: float
    friction_coefficient: float


@dataclass
class WarmUp:
    """A run of many cycles; one entry per cycle.

    Attributes
    ----------
    thermal : Temperatures and heat accounts at the beginning of each cycle, and at the end of the last one.
    friction_heat : Heat of both contacts over the cycle [J], from the FMU's ledger.
    loading, releasing : The middle of both moves.
    largest_torque : Largest torque of the servo [N.m].
    largest_error : Largest distance of the angle from the reference [rad].
    ledger_heat : Heat of both contacts at the end of the run [J], from the FMU's ledger.
    ledger_residual : What the FMU's energy balance leaves over at the end of the run [J].
    """

    thermal: list[ThermalState] = field(default_factory=list)
    friction_heat: list[float] = field(default_factory=list)
    loading: list[MidStroke] = field(default_factory=list)
    releasing: list[MidStroke] = field(default_factory=list)
    largest_torque: list[float] = field(default_factory=list)
    largest_error: list[float] = field(default_factory=list)
    ledger_heat: float = 0.0
    ledger_residual: float = 0.0

    @property
    def time(self) -> Array:
        """Beginning of each cycle [s]."""
        return np.arange(len(self.friction_heat), dtype=np.float64) * MOTION.period

    def column(self, name: str) -> Array:
        """A temperature at the beginning of each cycle [degC], shape (n,). `name`: "contact" or "housing"."""
        return np.array([getattr(state, name) - CELSIUS for state in self.thermal[:-1]], dtype=np.float64)


class Clamp:
    """The forward FMU as the clamp, driven by the servo.

    `fmu`: the forward FMU. `temperature` of the contact zone at the start [K]. `servo`: the servo. FmuError:
    `fmu` is not the forward FMU.
    """

    def __init__(self, fmu: Fmu, temperature: float, servo: Servo) -> None:
        self._fmu, self._servo, self._plan = fmu, servo, servo.plan()
        self._tau, self._state = fmu.reals("tau"), fmu.reals("theta", "omega")
        self._middle = fmu.reals("theta", "omega", "alpha", "cam1.friction_coefficient")
        self._heats = fmu.reals("energy.heat_cam1", "energy.heat_cam2")
        self._tuned = fmu.reals(*(f"cam{i}.{name}" for i in (1, 2) for name in TUNED))
        fmu.start(plant_parameters(temperature))

    @property
    def heat(self) -> float:
        """Heat of both contacts since the start [J]."""
        return float(sum(self._heats.read()))

    def warm_to(self, temperature: float) -> None:
        """Tune the friction to a `temperature` of the contact zone [K]."""
        self._tuned.values = [*GREASE.law(temperature)] * 2
        self._tuned.write()

    def cycle(self, record: WarmUp) -> None:
        """One cycle, added to the `record`, whose thermal state stays as it is."""
        begin = self.heat
        largest_torque = largest_error = 0.0
        for plan, middles in zip(self._plan, (record.loading, record.releasing), strict=True):
            before = now = tuple(self._state.read())
            for k, sample in enumerate(plan, start=1):
                torque = self._servo.command(sample, *before)
                largest_torque = max(largest_torque, abs(torque))
                largest_error = max(largest_error, abs(sample.angle - before[0]))
                before = now
                self._tau.values[0] = torque
                self._tau.write()
                self._fmu.step(SAMPLE)
                now = tuple(self._state.read())
                if k == SAMPLES_TO_MIDDLE:
                    middles.append(MidStroke(torque, *self._middle.read()))
            self._fmu.step(MOTION.dwell - SETTLING)
        record.largest_torque.append(largest_torque)
        record.largest_error.append(largest_error)
        record.friction_heat.append(self.heat - begin)


def run(fmu: Fmu, cycles: int, *, warming: bool = True, servo: Servo | None = None) -> WarmUp:
    """Clamp and release many times, from a cold start.

    `fmu`: the forward FMU. `cycles`: number of cycles. `warming`: whether the friction follows the
    temperature; else it stays that of the cold start. `servo`: default `Servo()`. FmuError: `fmu` is not the
    forward FMU. DesignError: the contact zone gets hotter than the viscosity law allows.

    Examples
    --------
    >>> from dualcam import Fmu
    >>> from dualcam.systems.machines import clamp
    >>> with Fmu("forward") as fmu:
    ...     record = clamp.run(fmu, cycles=30)  # one minute
    >>> round(record.thermal[-1].contact - 273.15)  # degC
    11
    """
    state, record = NETWORK.start(), WarmUp()
    clamp = Clamp(fmu, state.contact, servo or Servo())
    for _ in range(cycles):
        record.thermal.append(state)
        clamp.cycle(record)
        state = NETWORK.advance(state, record.friction_heat[-1] / MOTION.period, MOTION.period)
        if warming:
            clamp.warm_to(state.contact)
    record.thermal.append(state)
    record.ledger_heat, record.ledger_residual = clamp.heat, fmu.real("energy.residual")
    return record


def steady_middle(middle: MidStroke, temperature: float) -> tuple[float, float]:
    """The torque of the servo less that of the inertia in a measured middle of a move, and `steady_torque` at
    the same angle and speed [N.m].

    `middle`: the measurement. `temperature` of the contact zone in that cycle [K].
    """
    return middle.torque - INERTIA * middle.alpha, steady_torque(middle.theta, middle.omega, temperature)
