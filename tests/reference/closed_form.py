"""Segments in closed form at 60 digits."""

from __future__ import annotations

from collections.abc import Iterable

from .arithmetic import MP, SIXTY_DIGITS, Number, sign
from .mechanism import Mechanism
from .segment import Outcome, Segment


class ExactFlow:
    """Closed form of a linear segment: functions of time are coefficients over a basis t^p exp(lambda t)."""

    arithmetic = SIXTY_DIGITS
    zero = MP.mpf("1e-40")

    def advance(self, mechanism: Mechanism, segment: Segment) -> Outcome:
        if not mechanism.linear or max(len(segment.tau), len(segment.f_ext)) > 2:
            raise NotImplementedError("closed form needs helices, a linear spring and dampers, linear inputs")
        slip, k = segment.slip, mechanism.spring[1]
        kin = mechanism.groove.at(segment.theta)
        q = mechanism.balance(kin, slip)
        c = mechanism.damper[slip.sigma][0]
        drag = q.delta * mechanism.b + q.product * c * kin.dz
        force = mechanism.spring[0] + segment.f_ext[0]
        drive = [
            q.delta * segment.tau[0] - q.product * force,
            q.delta * segment.tau[1] - q.product * segment.f_ext[1],
        ]
        stiffness = q.product * k * kin.dz
        carried = q.d1 * mechanism.r2 * q.n2 * mechanism.I * kin.dgamma
        mass = q.delta * mechanism.J + carried + q.product * mechanism.m * kin.dz
        if mechanism.inertial:
            theta = self._second_order(
                stiffness / mass, drag / mass, drive[0] / mass, drive[1] / mass, segment.theta, segment.omega
            )
        else:
            theta = self._first_order(stiffness / drag, drive[0] / drag, drive[1] / drag, segment.theta)
        omega = self._derivative(theta)
        alpha = self._derivative(omega) if mechanism.inertial else [MP.mpf(0)] * len(theta)
        tau, f_ext = self._line(*segment.tau), self._line(*segment.f_ext)
        f0 = self._sum((1, self._line(mechanism.spring[0], 0)), (k * kin.dz, theta), (1, f_ext))
        axial = self._sum((1, f0), (c * kin.dz, omega), (mechanism.m * kin.dz, alpha))
        moment = mechanism.I * kin.dgamma
        x1 = self._sum((mechanism.r2 * q.n2 / q.delta, axial), (-q.d2 * moment / q.delta, alpha))
        x2 = self._sum((mechanism.r1 * q.n1 / q.delta, axial), (q.d1 * moment / q.delta, alpha))

        watched: dict[str, list[Number]] = {}
        if mechanism.inertial:
            watched["rest"] = omega
        else:
            edge = mechanism.static_ratio(kin, slip.sigma * segment.load_sign)
            assert edge is not None
            watched["rest"] = self._sum((1, tau), (-edge, f0))
            watched["kink"] = f0
        watched["stop"] = self._sum((1, theta), (-1, self._line(segment.stop, 0)))
        if mechanism.mu1 > 0:
            watched["cross1"] = x1
        if mechanism.mu2 > 0:
            watched["cross2"] = x2
        length, found = segment.length, {}
        for name, function in watched.items():
            root = self._first_zero(function, length)
            if root is not None:
                found[name] = root
                length = min(length, root * (1 + self.zero))
        length = min(found.values(), default=segment.length)
        causes = {name for name, t in found.items() if t <= length * (1 + self.zero)} or {"end"}

        table = self._product_integrals(length)
        f1 = slip.sigma * slip.e[0] * mechanism.mu1 * (mechanism.r1**2 + kin.a1**2) * kin.dgamma
        f2 = slip.sigma * slip.e[1] * mechanism.mu2 * (mechanism.r2**2 + kin.a2**2) * (1 - kin.dgamma)
        flows = [
            self._integral(tau, omega, table),
            kin.dz * self._integral(f_ext, omega, table),
            f1 * self._integral(x1, omega, table),
            f2 * self._integral(x2, omega, table),
            c * kin.dz**2 * self._integral(omega, omega, table),
            mechanism.b * self._integral(omega, omega, table),
        ]
        return Outcome(
            length,
            self._value(theta, length),
            self._value(omega, length),
            flows,
            causes,
            self._largest(omega, length),
            mechanism.reactions(kin, self._largest(x1, length), self._largest(x2, length)),
        )

    def _second_order(
        self, K: Number, C: Number, c0: Number, c1: Number, theta: Number, omega: Number
    ) -> list[Number]:
        """theta'' = c0 + c1 t - K theta - C theta'."""
        if K == 0 and C == 0:
            self._set_basis([(0, 0), (1, 0), (2, 0), (3, 0)])
            return [theta, omega, c0 / 2, c1 / 6]
        if K == 0:
            self._set_basis([(0, 0), (1, 0), (2, 0), (0, -C)])
            p2 = c1 / (2 * C)
            p1 = (c0 - 2 * p2) / C
            decay = (p1 - omega) / C
            return [theta - decay, p1, p2, decay]
        p1 = c1 / K
        p0 = (c0 - C * p1) / K
        x, y = theta - p0, omega - p1
        discriminant = C * C - 4 * K
        if discriminant == 0:
            self._set_basis([(0, 0), (1, 0), (0, -C / 2), (1, -C / 2)])
            return [p0, p1, x, y + C / 2 * x]
        root = MP.sqrt(discriminant)  # imaginary for an underdamped motion
        first, second = (-C + root) / 2, (-C - root) / 2
        self._set_basis([(0, 0), (1, 0), (0, first), (0, second)])
        share = (y - second * x) / root
        return [p0, p1, share, x - share]

    def _first_order(self, K: Number, w0: Number, w1: Number, theta: Number) -> list[Number]:
        """theta' = w0 + w1 t - K theta."""
        if K == 0:
            self._set_basis([(0, 0), (1, 0), (2, 0)])
            return [theta, w0, w1 / 2]
        p1 = w1 / K
        p0 = (w0 - p1) / K
        self._set_basis([(0, 0), (1, 0), (0, -K)])
        return [p0, p1, theta - p0]

    def _set_basis(self, basis: list[tuple[int, Number]]) -> None:
        self.basis = basis
        self._latest: tuple[Number, dict[Number, Number]] = (None, {})
        self.exponents = [rate for _, rate in basis]

    def _line(self, value: Number, slope: Number) -> list[Number]:
        return [value, slope] + [MP.mpf(0)] * (len(self.basis) - 2)

    def _sum(self, *terms: tuple[Number, list[Number]]) -> list[Number]:
        return [MP.fsum(factor * u[j] for factor, u in terms) for j in range(len(self.basis))]

    def _derivative(self, u: list[Number]) -> list[Number]:
        du = [MP.mpf(0)] * len(u)
        for j, (power, rate) in enumerate(self.basis):
            du[j] += rate * u[j]
            if power:
                du[self.basis.index((power - 1, rate))] += power * u[j]
        return du

    def _value(self, u: list[Number], t: Number) -> Number:
        total = MP.mpf(0)
        for c, (power, rate) in zip(u, self.basis, strict=True):
            if c:
                term = c * t**power if power else c
                total += term * self._exp(rate, t) if rate else term
        return MP.re(total)

    def _exp(self, rate: Number, t: Number) -> Number:
        """exp(rate t). The value is stored for the conjugate rate and for further functions at the same t."""
        if self._latest[0] is not t:
            self._latest = (t, {})
        known = self._latest[1]
        if rate not in known:
            known[rate] = MP.exp(rate * t)
            known[MP.conj(rate)] = MP.conj(known[rate])
        return known[rate]

    def _first_zero(self, u: list[Number], end: Number) -> Number | None:
        """First zero in (0, end], or None. Two periods are searched first, since most swings end within
        one."""
        frequency = max(abs(MP.im(rate)) for rate in self.exponents)
        window = min(end, 4 * MP.pi / frequency) if frequency > 0 else end
        while True:
            roots = self._zeros(u, window)
            if roots or window == end:
                return roots[0] if roots else None
            window = min(end, 4 * window)

    def _zeros(self, u: list[Number], end: Number) -> list[Number]:
        """All sign changes in (0, end]. Between two zeros of the derivative the function is monotone."""
        terms = [(c, power, rate) for c, (power, rate) in zip(u, self.basis, strict=True) if c != 0]
        tail = [term for term in terms if term[2] != 0]
        if len(tail) == len(terms):
            return [t for t in self._zeros_of_tail(tail, end) if self.zero * end < t <= end]
        du = self._derivative(u)
        knots = [MP.mpf(0), *(t for t in self._zeros(du, end) if t < end), end]
        nothing = self.zero * MP.fsum(abs(c) for c in u)
        values = [self._value(u, t) for t in knots]
        values = [MP.mpf(0) if abs(value) <= nothing else value for value in values]
        roots = []
        for a, b, fa, fb in zip(knots, knots[1:], values, values[1:], strict=False):
            if fb == 0:
                roots.append(b)
            elif sign(fa) * sign(fb) < 0:
                roots.append(self._root(u, du, a, b, sign(fb)))
        return roots

    def _zeros_of_tail(self, tail: list[tuple[Number, int, Number]], end: Number) -> Iterable[Number]:
        if len(tail) < 2:
            return []
        (c1, _, rate1), (c2, _, rate2) = tail
        if rate1 == rate2:  # (c1 + c2 t) exp(rate t)
            return [-c1 / c2]
        if MP.im(rate1) == 0:
            ratio = -MP.re(c2) / MP.re(c1)
            return [MP.log(ratio) / MP.re(rate1 - rate2)] if ratio > 0 else []
        frequency = MP.im(rate1)  # 2 |c1| exp(-a t) cos(frequency t + phase)
        first = (MP.pi / 2 - MP.arg(c1)) / frequency
        period = MP.pi / frequency
        start = MP.ceil(-first / period)
        return [first + (start + j) * period for j in range(int(end / period) + 2)]

    def _root(self, u: list[Number], du: list[Number], a: Number, b: Number, rising: int) -> Number:
        """Newton inside a bracket of a monotone function; bisection where Newton does not halve its steps."""
        t, step = (a + b) / 2, b - a
        for _ in range(1000):
            f = self._value(u, t)
            if f == 0:
                return t
            a, b = (a, t) if sign(f) == rising else (t, b)
            slope = self._value(du, t)
            before, step = step, (-f / slope if slope != 0 else b - a)
            if not a < t + step < b or abs(2 * step) > abs(before):
                step = (a + b) / 2 - t
            t += step
            if abs(step) <= MP.mpf("1e-52") * abs(t):
                return t
        raise ArithmeticError("root finding did not end")

    def _largest(self, u: list[Number], end: Number) -> Number:
        times = [MP.mpf(0), end, *self._zeros(self._derivative(u), end)]
        return max(abs(self._value(u, t)) for t in times)

    def _product_integrals(self, end: Number) -> dict[tuple[int, int], Number]:
        """Integral over (0, end) of basis_i basis_j, for i <= j."""
        size = max((abs(rate) for rate in self.exponents), default=MP.mpf(0))
        table = {}
        for i, (p, first) in enumerate(self.basis):
            for j, (q, second) in enumerate(self.basis[i:], start=i):
                rate = first + second
                if abs(rate) <= self.zero * size:
                    table[i, j] = end ** (p + q + 1) / (p + q + 1)
                    continue
                grown = MP.exp(rate * end)
                integral = (grown - 1) / rate
                for power in range(1, p + q + 1):
                    integral = (end**power * grown - power * integral) / rate
                table[i, j] = integral
        return table

    def _integral(self, u: list[Number], w: list[Number], table: dict[tuple[int, int], Number]) -> Number:
        terms = [(j, b) for j, b in enumerate(w) if b]
        total = MP.mpf(0)
        for i, a in enumerate(u):
            if a:
                total += a * sum(b * table[min(i, j), max(i, j)] for j, b in terms)
        return MP.re(total)
