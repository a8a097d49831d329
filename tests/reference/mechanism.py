"""Balance of forces and moments at one instant."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .arithmetic import DOUBLE, Arithmetic, Number
from .friction import FrictionLaw
from .grooves import HELIX, groove_of
from .kinematics import Grooves, Helices, Kinematics
from .parameters import DEFAULTS, Params, Refused

Flanks = tuple[int, int]


class Balance(NamedTuple):
    """Coefficients of the contact balance for one direction and one pair of flanks."""

    n1: Number
    n2: Number
    d1: Number
    d2: Number
    delta: Number  # r2 d1 n2 + r1 d2 n1
    product: Number  # r1 r2 n1 n2


class Load(NamedTuple):
    """Solution of the balance at one instant."""

    omega: Number
    alpha: Number  # 0 without inertia
    x1: Number
    x2: Number


class Slip(NamedTuple):
    """Direction and flanks of sliding."""

    sigma: int
    e: Flanks


class Mechanism:
    """Parameters in the chosen number type, and the pointwise equations."""

    def __init__(self, params: Params, arithmetic: Arithmetic) -> None:
        unknown = set(params) - set(DEFAULTS)
        if unknown:
            raise KeyError(f"no such parameter: {sorted(unknown)}")
        given = {**DEFAULTS, **params}
        p: dict[str, Any] = {
            name: value if isinstance(value, str) else arithmetic.number(value)
            for name, value in given.items()
        }
        self.arithmetic = arithmetic
        self.r1, self.r2 = p["cam1.radius"], p["cam2.radius"]
        self.laws = FrictionLaw.of_cam(p, 1), FrictionLaw.of_cam(p, 2)
        self.friction_varies = any(law.varies for law in self.laws)
        self.mu1, self.mu2 = (law.static for law in self.laws)  # at rest, without the factor of the load
        self.is_loaded = any(law.is_loaded for law in self.laws)
        self.spring = [p["spring.preload"]] + [p[f"spring.stiffness{i}"] for i in ("", "2", "3")]
        self.damper = {
            +1: (p["damper.c_load"], p["damper.q_load"]),
            -1: (p["damper.c_release"], p["damper.q_release"]),
        }
        self.J, self.m, self.I = (p[f"inertia.{part}"] for part in ("shaft", "follower_mass", "follower"))
        self.b = p["shaft.damping"]
        self.lower, self.upper = p["stop.lower"], p["stop.upper"]
        self.groove = self._grooves(p)
        ends = [abs(self.groove.at(theta).z) for theta in (self.lower, self.upper)]
        self.reach = max(ends)  # m, largest |z| of the follower
        self.restitution = p["stop.restitution"]
        self.theta0, self.omega0 = p["initial.theta"], p["initial.omega"]
        self.contacts = p["contacts"]
        self.inertial = bool(self.J + self.m + self.I > 0)
        self._balances: dict[Slip, tuple[Number, Number, Balance]] = {}
        self.linear = not any(self.spring[2:]) and not any(q for _, q in self.damper.values())
        self.linear = self.linear and isinstance(self.groove, Helices)
        self.linear = self.linear and not self.friction_varies and not self.is_loaded
        if not self.inertial and self.friction_varies:
            raise Refused("friction that varies with the speed needs an inertia")
        if not self.inertial and self.is_loaded and any(map(any, self.damper.values())):
            raise Refused("friction that depends on the load of a damper needs an inertia")

    def _grooves(self, p: Params) -> Helices | Grooves:
        """Two plain helices in closed form; anything else in double precision."""
        profiles = [int(p[f"cam{i}.profile"]) for i in (1, 2)]
        if profiles == [HELIX, HELIX]:
            slopes = [p[f"cam{i}.radius"] * self.arithmetic.tan(p[f"cam{i}.lead_angle"]) for i in (1, 2)]
            return Helices(*slopes)
        if self.arithmetic is not DOUBLE:
            raise NotImplementedError("60 digits need helical grooves")
        return Grooves(groove_of(p, 1), groove_of(p, 2), self.lower, self.upper)

    def force_scale(self, kin: Kinematics, f_ext: Number) -> Number:
        """Size of the terms whose sum is F_0."""
        return sum(abs(c) * self.reach**i for i, c in enumerate(self.spring)) + abs(f_ext)

    def viscous(self, sigma: int) -> bool:
        """Without inertia: does any damper act in this direction?"""
        return bool(self.b + sum(self.damper[sigma]) > 0)

    def spring_force(self, z: Number) -> Number:
        force, k, k2, k3 = self.spring
        return force + z * (k + z * (k2 + z * k3))

    def spring_slope(self, z: Number) -> Number:
        _, k, k2, k3 = self.spring
        return k + z * (2 * k2 + z * 3 * k3)

    def spring_energy(self, z: Number) -> Number:
        force, k, k2, k3 = self.spring
        return z * (force + z * (k / 2 + z * (k2 / 3 + z * k3 / 4)))

    def damper_force(self, sigma: int, v: Number) -> Number:
        c, q = self.damper[sigma]
        return v * (c + q * abs(v))

    def kinetic_energy(self, kin: Kinematics, omega: Number) -> Number:
        return (self.J + self.m * kin.dz**2 + self.I * kin.dgamma**2) * omega**2 / 2

    def sliding(self, kin: Kinematics) -> tuple[Number, Number]:
        """m/rad: sliding distance at each contact per angle of cam 2."""
        half = self.arithmetic.number(0.5)
        return (
            kin.dgamma * (self.r1**2 + kin.a1**2) ** half,
            (1 - kin.dgamma) * (self.r2**2 + kin.a2**2) ** half,
        )

    def nominal_loads(self, kin: Kinematics, axial: Number) -> tuple[Number, Number]:
        """N_i: the reactions of one contact under the axial load, without friction and inertia."""
        return self.reactions(kin, *self.shared(kin, axial))

    def friction(
        self, kin: Kinematics, slip: Slip, omega: Number = 0, axial: Number | None = None
    ) -> tuple[Number, Number]:
        """mu of both contacts at the speed omega, under the nominal loads of F = `axial`; None: without the
        factor of the load."""
        if not self.friction_varies and not self.is_loaded:
            return self.mu1, self.mu2
        loads = (None, None) if axial is None else self.nominal_loads(kin, axial)
        first, second = self.sliding(kin)
        v = slip.sigma * omega
        return self.laws[0].at(v * first, loads[0]), self.laws[1].at(v * second, loads[1])

    def balance(self, kin: Kinematics, slip: Slip, omega: Number = 0, axial: Number | None = None) -> Balance:
        if (self.friction_varies and omega != 0) or (self.is_loaded and axial is not None):
            return self._balance(kin, slip, self.friction(kin, slip, omega, axial))
        known = self._balances.get(slip)
        if known is None or known[0] is not kin.a1 or known[1] is not kin.a2:
            known = self._balances[slip] = (kin.a1, kin.a2, self._balance(kin, slip, (self.mu1, self.mu2)))
        return known[2]

    def _balance(self, kin: Kinematics, slip: Slip, mu: tuple[Number, Number]) -> Balance:
        f1, f2 = slip.sigma * slip.e[0] * mu[0], slip.sigma * slip.e[1] * mu[1]
        n1, n2 = kin.a1 + f1 * self.r1, kin.a2 + f2 * self.r2
        d1, d2 = self.r1 - f1 * kin.a1, self.r2 - f2 * kin.a2
        delta = self.r2 * d1 * n2 + self.r1 * d2 * n1
        return Balance(n1, n2, d1, d2, delta, self.r1 * self.r2 * n1 * n2)

    def static_ratio(self, kin: Kinematics, direction: int, f0: Number | None = None) -> Number | None:
        """Edge of the stick band per unit of F_0 > 0 for motion in `direction`; None if no torque starts it.
        F_0 < 0 mirrors: the ratio for (sigma, F_0) is that for direction sigma * sign(F_0). Where friction
        depends on the load, the ratio is that under f0."""
        pair = self.static_pair(kin, direction, f0)
        if pair is None:
            return None
        q = self.balance(kin, pair, 0, f0)
        return q.product / q.delta

    def static_pair(self, kin: Kinematics, direction: int, f0: Number | None = None) -> Slip | None:
        """The flanks on that edge: the first pair that agrees with its own reactions."""
        for e in [(1, 1), (1, -1), (-1, 1), (-1, -1)] if direction < 0 else [(1, 1)]:
            q = self.balance(kin, Slip(direction, e), 0, f0)
            if q.delta == 0 or (direction > 0 and q.delta < 0):
                continue
            x1, x2 = self.r2 * q.n2 / q.delta, self.r1 * q.n1 / q.delta
            if (e[0] * x1 >= 0 or self.mu1 == 0) and (e[1] * x2 >= 0 or self.mu2 == 0):
                return Slip(direction, e)
        return None

    def felt_inertia(self, kin: Kinematics, slip: Slip, f0: Number) -> Number:
        """kg.m2: D/Delta of docs/mechanism.md, section 3, at rest."""
        q = self.balance(kin, slip, 0, f0)
        carried = q.d1 * self.r2 * q.n2 * self.I * kin.dgamma
        return self.J + (carried + q.product * self.m * kin.dz) / q.delta

    def load(self, kin: Kinematics, slip: Slip, omega: Number, tau: Number, f_ext: Number) -> Load:
        """Acceleration (with inertia) or speed (without) and the contact loads, by elimination."""
        f0 = self.spring_force(kin.z) + f_ext
        if self.inertial:
            force = f0 + self.damper_force(slip.sigma, kin.dz * omega)
            q = self.balance(kin, slip, omega, force)
            carried = q.d1 * self.r2 * q.n2 * self.I  # factor of gamma_ddot
            mass = q.delta * self.J + carried * kin.dgamma + q.product * self.m * kin.dz
            if mass == 0:
                raise Refused("no effective inertia")
            centrifugal = q.product * self.m * kin.ddz + carried * kin.ddgamma
            drive = q.delta * (tau - self.b * omega) - q.product * force - centrifugal * omega**2
            alpha = drive / mass
        else:
            alpha = omega * 0
            q = self.balance(kin, slip, 0, f0)
            omega = self._damped_speed(kin, q, slip.sigma, tau, f0)
            force = f0 + self.damper_force(slip.sigma, kin.dz * omega)
        axial = force + self.m * (kin.dz * alpha + kin.ddz * omega**2)
        moment = self.I * (kin.dgamma * alpha + kin.ddgamma * omega**2)
        x1 = (self.r2 * q.n2 * axial - q.d2 * moment) / q.delta
        x2 = (self.r1 * q.n1 * axial + q.d1 * moment) / q.delta
        return Load(omega, alpha, x1, x2)

    def _damped_speed(self, kin: Kinematics, q: Balance, sigma: int, tau: Number, f0: Number) -> Number:
        """Without inertia: omega from delta (tau - b omega) = product (f0 + D(z' omega)).
        w = sigma omega >= 0 is the root of A w^2 + B w = C that vanishes with C; if C < 0 this is the
        continuation through w = 0, odd in C, so that the zero of omega can be located."""
        c, quadratic = self.damper[sigma]
        first = q.delta * self.b + q.product * c * kin.dz
        drive = q.delta * tau - q.product * f0
        if quadratic == 0 or kin.dz == 0:
            return drive / first
        if q.delta < 0:
            first, drive = -first, -drive
        second = abs(q.product) * quadratic * kin.dz**2
        if (q.product < 0) != (q.delta < 0):
            second = -second
        under = first * first + 4 * second * abs(drive)
        if under < 0:
            return math.nan
        return 2 * drive / (first + under**0.5) if drive != 0 else drive

    def scales(self, kin: Kinematics, slip: Slip, omega: Number, tau: Number, f_ext: Number) -> Load:
        """Sizes of the terms whose sums make up a Load: a sum far below the size of its terms counts as
        zero."""
        q, (drag, mass) = self.balance(kin, slip), self.inertia_and_drag(kin, slip)
        axial, torque, turning = self.force_scale(kin, f_ext), abs(tau), 0 * omega
        span = max(abs(self.lower), abs(self.upper))
        if self.inertial:
            # second derivatives are sums of terms of at least the size of their mean between the stops
            centrifugal = self.m * (abs(kin.ddz) + self.reach / span**2) * omega**2
            turning = self.I * (abs(kin.ddgamma) + 1 / span) * omega**2
            axial += abs(self.damper_force(slip.sigma, kin.dz * omega)) + centrifugal
            torque += self.b * abs(omega) + turning
        drive = abs(q.delta) * torque + abs(q.product) * axial
        c, quadratic = self.damper[slip.sigma]
        if self.inertial:
            start = drive / abs(mass)
            axial += self.m * kin.dz * start
        else:
            second = abs(q.product) * quadratic * kin.dz**2
            start = 2 * drive / (abs(drag) + (drag * drag + 4 * second * drive) ** 0.5)
            axial += (c + quadratic * kin.dz * start) * kin.dz * start
        moment = self.I * kin.dgamma * start + turning
        least = self.reach / span / 1000  # m/rad, a lower bound for dwells, whose slope is zero
        return Load(
            start * (not self.inertial),
            start * self.inertial,
            (self.r2 * (kin.a2 + self.mu2 * self.r2 + least) * axial + abs(q.d2) * moment) / abs(q.delta),
            (self.r1 * (kin.a1 + self.mu1 * self.r1 + least) * axial + abs(q.d1) * moment) / abs(q.delta),
        )

    def rate(self, kin: Kinematics, slip: Slip, omega: Number = 0) -> Number:
        """Estimate of the fastest rate of change, 1/s. It limits look-aheads and steps and enters no
        result."""
        drag, mass = self.inertia_and_drag(kin, slip, omega)
        stiffness = abs(self.balance(kin, slip).product * self.spring_slope(kin.z) * kin.dz)
        if self.inertial:
            return abs(drag / mass) + (stiffness / abs(mass)) ** 0.5 + self._rubbing_rate(kin, slip)
        return stiffness / abs(drag) if drag else stiffness * 0

    def _rubbing_rate(self, kin: Kinematics, slip: Slip) -> Number:
        """1/s: an estimate of the rate at which friction changes the speed."""
        if not self.friction_varies:
            return 0
        _, mass = self.inertia_and_drag(kin, slip)
        force, rate = abs(self.spring_force(kin.z)) + self.spring_slope(kin.z) * self.reach, 0.0
        for law, length in zip(self.laws, self.sliding(kin), strict=True):
            rate += law.kinetic * (law.peak - 1) * length / law.stribeck_velocity + law.viscous * length
        q = self.balance(kin, slip)
        return rate * force * abs(q.delta) * max(self.r1, self.r2) / abs(mass)

    def inertia_and_drag(self, kin: Kinematics, slip: Slip, omega: Number = 0) -> tuple[Number, Number]:
        """Coefficients of omega and alpha in the balance multiplied through by delta; the damper counts with
        its slope at the speed omega."""
        q = self.balance(kin, slip)
        c, quadratic = self.damper[slip.sigma]
        drag = q.delta * self.b + q.product * (c + 2 * quadratic * abs(kin.dz * omega)) * kin.dz
        carried = q.d1 * self.r2 * q.n2 * self.I * kin.dgamma
        return drag, q.delta * self.J + carried + q.product * self.m * kin.dz

    def powers(self, kin: Kinematics, slip: Slip, load: Load, tau: Number, f_ext: Number) -> list[Number]:
        """Rates of the accounts FLOWS."""
        omega, v = load.omega, kin.dz * load.omega
        axial = self.spring_force(kin.z) + f_ext + self.damper_force(slip.sigma, v)
        mu1, mu2 = self.friction(kin, slip, omega, axial)
        return [
            tau * omega,
            f_ext * v,
            mu1 * abs(load.x1) * (self.r1**2 + kin.a1**2) * kin.dgamma * abs(omega),
            mu2 * abs(load.x2) * (self.r2**2 + kin.a2**2) * (1 - kin.dgamma) * abs(omega),
            self.damper_force(slip.sigma, v) * v,
            self.b * omega**2,
        ]

    def reactions(self, kin: Kinematics, x1: Number, x2: Number) -> tuple[Number, Number]:
        """R_i = |x_i| hypot(r_i, a_i), per contact."""
        half = self.arithmetic.number(0.5)
        return (
            abs(x1) * (self.r1**2 + kin.a1**2) ** half / self.contacts,
            abs(x2) * (self.r2**2 + kin.a2**2) ** half / self.contacts,
        )

    def shared(self, kin: Kinematics, f0: Number) -> tuple[Number, Number]:
        """x_1, x_2 at rest: frictionless sharing of the axial load."""
        return f0 * kin.dgamma / self.r1, f0 * (1 - kin.dgamma) / self.r2
