"""The oracle of the accuracy tests, checked by other means than its own."""

import itertools
import math

import mpmath
import numpy as np
import pytest
import reference
import scipy
from reference import DOUBLE, MP, SIXTY_DIGITS, Interval, Mechanism, Refused, Slip, random_scene
from statics_cases import STATICS

# A mixture of the three regimes and of all events; chosen for speed in double precision too.
SLOW = {4, 9, 13, 15, 16, 21, 25, 27, 28, 31, 35, 37}
SEEDS = [seed for seed in range(40) if seed not in SLOW]
COMPARED = ("theta", "omega", *(f"energy.{name}" for name in reference.ENERGIES))


def some(seeds):
    """Each second seed takes part only in the long tests."""
    return [pytest.param(s, marks=[pytest.mark.long] * (i % 2)) for i, s in enumerate(seeds)]


def scene(seed):
    return random_scene(np.random.default_rng(seed))


def geometry(r1, r2, lambda1, lambda2, mu1, mu2):
    names = ("radius", "lead_angle", "friction")
    first = {f"cam1.{n}": v for n, v in zip(names, (r1, lambda1, mu1), strict=True)}
    return first | {f"cam2.{n}": v for n, v in zip(names, (r2, lambda2, mu2), strict=True)}


def natural_scales(points):
    """By what an error is divided: the largest angle, speed and account of the scene."""
    energy = max(abs(value) for p in points for value in p.energy.values())
    scales = {f"energy.{name}": energy for name in reference.ENERGIES}
    scales["theta"] = max(abs(p.theta) for p in points)
    scales["omega"] = points[-1].peak["omega"]
    return {name: float(value) or 1.0 for name, value in scales.items()}


@pytest.mark.parametrize("name", STATICS)
def test_statics_of_the_table(name):
    *shape, force, loading, releasing = STATICS[name]
    mech = Mechanism(geometry(*shape), SIXTY_DIGITS)
    kin = mech.groove.at(MP.mpf(0))
    for sigma, expected in ((+1, loading), (-1, releasing)):
        ratio = mech.static_ratio(kin, sigma)
        q = mech.balance(kin, Slip(sigma, (1, 1)))
        x1, x2 = force * mech.r2 * q.n2 / q.delta, force * mech.r1 * q.n1 / q.delta
        if expected is None:
            assert x1 < 0 or x2 < 0
            # on other flanks it takes a pull, or no torque at all moves it
            assert ratio is None or (sigma < 0 and ratio < 0)
            continue
        found = (x1 * MP.hypot(mech.r1, kin.a1), x2 * MP.hypot(mech.r2, kin.a2), force * ratio)
        assert [float(v) for v in found] == pytest.approx(expected, rel=1e-12)


def test_self_locking_on_mixed_flanks_takes_a_pull():
    # lambda_1 < phi_1 < lambda_2: x_1 > 0 and x_2 < 0, so contact 2 rubs on its other flank
    shape = STATICS["one contact locks"][:6]
    mech = Mechanism(geometry(*shape), DOUBLE)
    r1, r2, l1, l2, mu1, mu2 = shape
    a1, a2 = r1 * math.tan(l1), r2 * math.tan(l2)
    # torque = r1 (a1 - mu1 r1) x1 = r2 (a2 + mu2 r2) x2;  1 = (r1 + mu1 a1) x1 + (r2 - mu2 a2) x2
    matrix = [[r1 * (a1 - mu1 * r1), -r2 * (a2 + mu2 * r2)], [r1 + mu1 * a1, r2 - mu2 * a2]]
    x1, x2 = np.linalg.solve(matrix, [0, 1])
    assert x1 > 0 > x2
    ratio = mech.static_ratio(mech.groove.at(0.0), -1)
    assert ratio == pytest.approx(r1 * (a1 - mu1 * r1) * x1, rel=1e-13)
    assert ratio < 0


def test_loading_jam_is_refused():
    with pytest.raises(Refused):
        reference.simulate(geometry(*STATICS["loading jams"][:6]), [Interval(0.1, 1.0)])


@pytest.mark.parametrize("seed", range(40))
def test_contact_loads_satisfy_the_three_balances(seed):
    """Each with friction written as mu |x|, not with flank coefficients."""
    params, _ = scene(seed)
    m = Mechanism(params, SIXTY_DIGITS)
    rng = np.random.default_rng(seed)
    kin = m.groove.at(MP.mpf(rng.uniform(-1, 1)))
    tau, f_ext, omega0 = (MP.mpf(rng.normal()) for _ in range(3))
    for sigma, e1, e2 in itertools.product((1, -1), repeat=3):
        if not m.inertial and not m.viscous(sigma):
            continue
        omega, alpha, x1, x2 = m.load(kin, Slip(sigma, (e1, e2)), omega0, tau, f_ext)
        size1, size2 = e1 * x1, e2 * x2  # |x_i| on these flanks
        axial = m.r1 * x1 - sigma * m.mu1 * kin.a1 * size1 + m.r2 * x2 - sigma * m.mu2 * kin.a2 * size2
        torque1 = m.r1 * (kin.a1 * x1 + sigma * m.mu1 * m.r1 * size1)
        torque2 = m.r2 * (kin.a2 * x2 + sigma * m.mu2 * m.r2 * size2)
        force = m.spring_force(kin.z) + f_ext + m.damper[sigma][0] * kin.dz * omega
        for left, right in (
            (axial, force + m.m * kin.dz * alpha),
            (torque2, tau - m.b * omega - m.J * alpha),
            (torque1, torque2 - m.I * kin.dgamma * alpha),
        ):
            assert abs(left - right) <= MP.mpf("1e-45") * (abs(left) + abs(right) + 1)


def test_half_swing_worked_out_by_hand():
    # r = 20 mm, lambda = pi/4: z' = 10 mm, rho = (r/2)(1 + mu)/(1 - mu), and
    # J theta'' = tau - rho (F0 + k z' theta) until it turns at twice the centre, and sticks there
    rho, tau = 0.01 * 1.14 / 0.86, 1.5
    rate = math.sqrt(rho * 50e3 * 0.01 / 0.002)
    centre = (tau / rho - 50.0) / (50e3 * 0.01)
    for solve in (reference.simulate, reference.simulate_exact):
        moving, stopped = solve({}, [Interval(1e-2, tau), Interval(math.pi / rate, tau)])
        assert moving.theta == pytest.approx(centre * (1 - math.cos(rate * 1e-2)), rel=1e-13)
        assert moving.omega == pytest.approx(centre * rate * math.sin(rate * 1e-2), rel=1e-13)
        assert stopped.theta == pytest.approx(2 * centre, rel=1e-13)
        assert (moving.mode, stopped.mode, stopped.omega, stopped.events) == (2, 1, 0.0, 1)
        assert stopped.energy["work_in"] == pytest.approx(tau * 2 * centre, rel=1e-13)


@pytest.mark.parametrize("solve", [reference.simulate, reference.simulate_exact])
def test_one_segment_against_a_matrix_exponential(solve):
    """theta'' by section 6, with rho and kappa as printed there; torque and pull rise linearly."""
    params = geometry(0.03, 0.02, 0.6, 0.9, 0.1, 0.2) | {
        "inertia.follower_mass": 0.7,
        "inertia.follower": 3e-4,
        "shaft.damping": 0.02,
        "damper.c_load": 400.0,
        "stop.upper": 5.0,
    }
    kappa = [
        (1 - mu * math.tan(lead)) / (r * (math.tan(lead) + mu))
        for r, lead, mu in ((0.03, 0.6, 0.1), (0.02, 0.9, 0.2))
    ]
    rho = 1 / sum(kappa)
    a1, a2 = 0.03 * math.tan(0.6), 0.02 * math.tan(0.9)
    dz, dgamma = a1 * a2 / (a1 + a2), a2 / (a1 + a2)
    inertia = 0.002 + rho * 0.7 * dz + rho * kappa[0] * 3e-4 * dgamma
    tau, tau_rate, pull, pull_rate, h = 4.0, 900.0, 20.0, -500.0, 0.01
    matrix = mpmath.matrix(4, 4)  # of (theta, omega, 1, t)
    matrix[0, 1] = matrix[3, 2] = 1
    matrix[1, 0] = -rho * 50e3 * dz / inertia
    matrix[1, 1] = -(0.02 + rho * 400.0 * dz) / inertia
    matrix[1, 2] = (tau - rho * (50.0 + pull)) / inertia
    matrix[1, 3] = (tau_rate - rho * pull_rate) / inertia
    expected = mpmath.expm(matrix * h) * mpmath.matrix([0, 0, 1, 0])
    (point,) = solve(params, [Interval(h, tau, tau_rate, pull, pull_rate)])
    assert point.mode == 2
    assert point.theta == pytest.approx(float(expected[0]), rel=3e-13)
    assert point.omega == pytest.approx(float(expected[1]), rel=3e-13)


@pytest.mark.parametrize("seed", some(SEEDS))
def test_integration_and_closed_form_agree(seed):
    params, intervals = scene(seed)
    exact = reference.simulate_exact(params, intervals)
    points = reference.simulate(params, intervals)
    scales = natural_scales(exact)
    doubtful = False
    for point, other in zip(points, exact, strict=True):
        for name in COMPARED:
            assert abs(point.value(name) - other.value(name)) <= 6e-13 * scales[name], name
        # the number of bounces before rest is a matter of rounding
        doubtful = doubtful or bool(point.doubts or other.doubts)
        assert doubtful or (point.mode, point.events) == (other.mode, other.events)


@pytest.mark.parametrize("seed", some(range(40, 70)))
def test_accounts_close(seed):
    params, intervals = scene(seed)
    points = reference.simulate_exact(params, intervals)
    scale = natural_scales(points)["energy.residual"]
    for point in points:
        assert abs(point.energy["residual"]) <= 1e-40 * scale
        assert all(point.energy[name] >= 0 for name in reference.HEATS)


def step_through(params, intervals, steps):
    """Implicit Euler on the inclusion itself: of all directions and flanks (and rest), the one whose solution
    has the signs it assumes. First order (the grooves' bends and the quadratic damper are taken from the step
    before), and knows no events. theta at the end of each interval."""
    m = Mechanism(params, DOUBLE)
    theta, omega, found = m.theta0, m.omega0, []
    ways = list(itertools.product((1, -1), (1, -1), (1, -1)))
    for interval in intervals:
        h = interval.duration / steps
        for i in range(steps):
            kin = m.groove.at(theta)
            g, dz, k = kin.dgamma, kin.dz, m.spring_slope(kin.z)
            tau, f_ext = (interval.at(name, h * (i + 1))[0] for name in ("tau", "F_ext"))
            f0 = m.spring_force(kin.z) + f_ext
            bent = m.m * kin.ddz * omega**2, m.I * kin.ddgamma * omega**2
            matrices, sides = [], []
            for sigma, e1, e2 in ways:
                n1, n2 = kin.a1 + sigma * e1 * m.mu1 * m.r1, kin.a2 + sigma * e2 * m.mu2 * m.r2
                d1, d2 = m.r1 - sigma * e1 * m.mu1 * kin.a1, m.r2 - sigma * e2 * m.mu2 * kin.a2
                c = m.damper[sigma][0] + m.damper[sigma][1] * abs(dz * omega)
                matrices.append(  # of (x1, x2, omega at the end)
                    [
                        [d1, d2, -(k * h + c) * dz - m.m * dz / h],
                        [m.r1 * n1, -m.r2 * n2, m.I * g / h],
                        [0.0, m.r2 * n2, m.b + m.J / h],
                    ]
                )
                axial = f0 - m.m * dz * omega / h + bent[0]
                sides.append([[axial], [m.I * g * omega / h - bent[1]], [tau + m.J * omega / h]])
            solutions = np.linalg.solve(np.array(matrices), np.array(sides))[:, :, 0]
            zero = -1e-12 * np.abs(f0 / m.r1)  # without torque both loads vanish, up to rounding
            new = 0.0
            for (sigma, e1, e2), (x1, x2, speed) in zip(ways, solutions, strict=True):
                if sigma * speed > 0 and (e1 * x1 >= zero or m.mu1 == 0) and (e2 * x2 >= zero or m.mu2 == 0):
                    new = speed
                    break
            omega = new
            theta += h * omega
            if not m.lower <= theta <= m.upper:
                theta = min(max(theta, m.lower), m.upper)
                omega = -m.restitution * omega
        found.append(theta)
    return found


@pytest.mark.parametrize("seed", [0, 8, 15, 17, 20, 24, 32, 34, 36, 40])
def test_events_against_stepping_through_the_inclusion(seed):
    params, intervals = scene(seed)
    intervals = intervals[:6]
    exact = np.array([point.theta for point in reference.simulate_exact(params, intervals)])
    span = exact.max() - exact.min()
    coarse, fine = (np.abs(step_through(params, intervals, steps) - exact) for steps in (250, 1000))
    assert np.all(fine <= 5e-3 * span)
    assert np.all(fine <= 0.5 * coarse + 1e-4 * span)


# ---- any grooves, springs, dampers, inputs ------------------------------------------------------


def general(params, folder, name="straight"):
    """The same helices, as tables with uneven knots: now every step goes the general way."""
    rng = np.random.default_rng(7)
    low, high = params["stop.lower"] - 0.1, params["stop.upper"] + 0.1
    found = dict(params)
    for i in (1, 2):
        slope = params[f"cam{i}.radius"] * math.tan(params[f"cam{i}.lead_angle"])
        psi = np.sort(np.concatenate([[low, high], rng.uniform(low, high, 8)]))
        path = folder / f"{name}{i}.csv"
        reference.write_table(path, psi, slope * psi)
        found |= {f"cam{i}.profile": reference.TABLE, f"cam{i}.table": str(path)}
    return found


def ellipse(i, lead, a, b, kappa):
    names = ("profile", "lead_angle", "ellipse_a", "ellipse_b", "ellipse_curvature")
    return {f"cam{i}.{n}": v for n, v in zip(names, (reference.ELLIPSE, lead, a, b, kappa), strict=True)}


ELLIPSES = ellipse(1, 0.6, 0.08, 0.06, 1) | ellipse(2, 0.9, 0.09, 0.05, -1)
MASSES = {"inertia.follower_mass": 0.8, "inertia.follower": 2e-4, "shaft.damping": 0.01}


def test_grooves_are_related_as_their_names_say(tmp_path):
    """gamma solves g1(gamma) = g2(theta - gamma); each derivative against differences of the one below."""
    psi = np.linspace(-0.5, 2.0, 12)
    reference.write_table(tmp_path / "a.csv", psi, 0.02 * (psi + 0.2 * np.sin(2 * psi)))
    table = {"cam2.profile": reference.TABLE, "cam2.table": str(tmp_path / "a.csv")}
    for second in ({}, table):
        grooves = Mechanism(ELLIPSES | second | {"stop.lower": -0.3}, DOUBLE).groove
        h = 1e-4
        for theta in np.linspace(-0.29, 1.39, 50):
            piece = grooves.ahead(float(theta), 1)[0]
            k = grooves.at(float(theta), piece)
            near = [grooves.at(float(theta + j * h), piece) for j in (-2, -1, 1, 2)]
            i, j = grooves.pieces[piece]
            other = grooves.second.derivatives(theta - k.gamma, j)[0]
            assert abs(grooves.first.derivatives(k.gamma, i)[0] - other) <= 1e-17
            pairs = (("gamma", "dgamma"), ("dgamma", "ddgamma"), ("z", "dz"), ("dz", "ddz"))
            for name, rate in (*pairs, ("a1", "da1"), ("a2", "da2")):
                f = [getattr(n, name) for n in near]
                slope = (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h)
                size = max(abs(v) for v in f)
                assert abs(slope - getattr(k, rate)) <= 1e-9 * size + 1e-10 * abs(slope), (theta, rate)


def test_ellipse_is_an_ellipse():
    """(x, z) on the arc, from its centre, and the lead angle at the start."""
    for kappa, lead in ((1, 0.3), (-1, 0.9)):
        r, a, b = 0.03, 0.07, 0.05
        groove = reference.Ellipse(r, lead, a, b, kappa)
        assert groove.derivatives(0.0, 0)[1] == pytest.approx(r * math.tan(lead), rel=1e-15)
        steep = math.atan(a / b * math.tan(lead))  # parameter of the ellipse at the start
        x0, z0 = kappa * a * math.sin(steep), -kappa * b * math.cos(steep)
        for psi in np.linspace(-0.2, 0.8, 11):
            z = groove.derivatives(float(psi), 0)[0]
            assert ((x0 + r * psi) / a) ** 2 + ((z0 + z) / b) ** 2 == pytest.approx(1, rel=1e-14)


@pytest.mark.parametrize("seed", range(30))
def test_table_follows_its_rule(seed):
    """Through its points, twice continuously differentiable, monotone."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 30))
    psi = np.cumsum(rng.uniform(0.05, 0.2, count))
    psi -= psi[count // 3]
    steps = rng.uniform(0.2, 1.0, count - 1) ** rng.choice([0.2, 3.0])
    if seed % 3 == 0:
        steps[rng.integers(count - 1)] = 0.0
    z = np.concatenate([[0.0], np.cumsum(0.01 * steps)])
    table = reference.Table(psi, z)
    zero = np.interp(0.0, psi, z)  # psi = 0 is a knot
    for k in range(count - 1):
        for j in (k, k + 1):
            value, slope, second = table.derivatives(psi[j], k)
            assert value == pytest.approx(z[j] - zero, abs=1e-16)
            assert slope == pytest.approx(table.slopes[j], abs=1e-13)
            assert second == pytest.approx(table.seconds[j], abs=1e-11)
        slopes = [table.derivatives(p, k)[1] for p in np.linspace(psi[k], psi[k + 1], 41)]
        assert min(slopes) >= -1e-15


def test_table_derivatives_at_knots_where_nothing_is_limited():
    """Those of the quartic (the cubic, if there are but four points) through the nearest points, by numpy."""
    rng = np.random.default_rng(1)
    for count in (4, 5, 6, 9, 20):
        psi = np.cumsum(rng.uniform(0.1, 0.14, count))
        psi -= psi[count // 3]
        z = 0.01 * (psi + 0.1 * np.sin(psi) + 0.05 * psi**2)
        table = reference.Table(psi, z)
        size = min(5, count)
        for j in range(count):
            start = min(max(j - 2, 0), count - size)
            nodes = slice(start, start + size)
            fit = np.polynomial.Polynomial.fit(psi[nodes], z[nodes], size - 1)
            assert table.slopes[j] == pytest.approx(fit.deriv(1)(psi[j]), rel=1e-12)
            assert table.seconds[j] == pytest.approx(fit.deriv(2)(psi[j]), rel=1e-10, abs=1e-13)


def test_table_of_a_dwell():
    table = reference.Table([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6], [0, 1e-3, 2e-3, 2e-3, 2e-3, 3e-3, 5e-3])
    assert all(table.derivatives(p, 2 + (p > 0.3)) == (2e-3, 0.0, 0.0) for p in (0.2, 0.25, 0.3, 0.35, 0.4))
    assert table.derivatives(0.41, 4)[1] > 0


@pytest.mark.parametrize("seed", some([0, 2, 3, 5, 8, 12, 14, 17, 20, 24, 29, 30, 32, 34, 36, 39]))
def test_helical_scene_the_general_way(seed, tmp_path):
    params, intervals = scene(seed)
    exact = reference.simulate_exact(params, intervals)
    points = reference.simulate(general(params, tmp_path), intervals)
    scales = natural_scales(exact)
    for point, other in zip(points, exact, strict=True):
        if point.doubts or other.doubts:
            break  # rounding, and so the machine, decides how it goes on
        for name in COMPARED:
            assert abs(point.value(name) - other.value(name)) <= 2e-12 * scales[name], name
        assert (point.mode, point.events) == (other.mode, other.events)


def test_flat_ellipses_tend_to_helices():
    params = geometry(0.03, 0.02, 0.6, 0.9, 0.1, 0.2) | MASSES
    intervals = [Interval(0.02, 4.0, 50.0), Interval(0.02, 0.0)]
    exact = reference.simulate_exact(params, intervals)[-1].theta
    errors = []
    for size in (1e3, 1e4):
        arcs = ellipse(1, 0.6, size, size, 1) | ellipse(2, 0.9, size, size, -1)
        errors.append(abs(reference.simulate(params | arcs, intervals)[-1].theta - exact))
    assert errors[1] == pytest.approx(errors[0] / 10, rel=1e-2)
    assert errors[1] < 1e-5


def test_tables_tend_to_the_ellipses_they_are_sampled_from(tmp_path):
    params = ELLIPSES | MASSES
    intervals = [Interval(0.03, 3.0), Interval(0.02, -0.5)]
    exact = reference.simulate(params, intervals)[-1].theta
    errors = []
    for count in (15, 29, 57):
        sampled = dict(params)
        for i in (1, 2):
            groove = reference.groove_of(params, i)
            psi = np.linspace(0.0, 1.4, count)
            reference.write_table(tmp_path / "t.csv", psi, [groove.derivatives(p, 0)[0] for p in psi])
            (tmp_path / "t.csv").rename(tmp_path / f"{count}-{i}.csv")
            sampled |= {f"cam{i}.profile": 3, f"cam{i}.table": str(tmp_path / f"{count}-{i}.csv")}
        errors.append(abs(reference.simulate(sampled, intervals)[-1].theta - exact))
    assert errors[0] < 1e-4
    for coarse, fine in itertools.pairwise(errors):
        assert fine < coarse / 8


@pytest.mark.parametrize("seed", range(60))
def test_general_contact_loads_satisfy_the_three_balances(seed, tmp_path):
    """As above, now with the centrifugal terms and the quadratic damper."""
    params, _ = reference.random_general_scene(np.random.default_rng(seed), tmp_path)
    m = Mechanism(params, DOUBLE)
    rng = np.random.default_rng(seed)
    kin = m.groove.at(rng.uniform(m.lower, m.upper))
    tau, f_ext, omega0 = m.spring[0] * 0.02 * rng.normal(), m.spring[0] * rng.normal(), 10 * rng.normal()
    for sigma, e1, e2 in itertools.product((1, -1), repeat=3):
        if not m.inertial and not m.viscous(sigma):
            continue
        start = sigma * abs(omega0)
        omega, alpha, x1, x2 = m.load(kin, Slip(sigma, (e1, e2)), start, tau, f_ext)
        if not m.inertial and not sigma * omega > 0:
            continue  # not a motion
        size1, size2 = e1 * x1, e2 * x2
        v = kin.dz * omega
        c, q = m.damper[sigma]
        force = m.spring[0] + sum(k * kin.z**i for i, k in enumerate(m.spring) if i) + f_ext
        pull = (force, v * c, q * v * abs(v), m.m * kin.dz * alpha, m.m * kin.ddz * omega**2)
        axial = m.r1 * x1, -sigma * m.mu1 * kin.a1 * size1, m.r2 * x2, -sigma * m.mu2 * kin.a2 * size2
        torque1 = m.r1 * kin.a1 * x1, m.r1 * sigma * m.mu1 * m.r1 * size1
        torque2 = m.r2 * kin.a2 * x2, m.r2 * sigma * m.mu2 * m.r2 * size2
        turning = -m.I * kin.dgamma * alpha, -m.I * kin.ddgamma * omega**2
        driving = tau, -m.b * omega, -m.J * alpha
        for left, right in ((axial, pull), (torque2, driving), (torque1, (*driving, *turning))):
            assert abs(sum(left) - sum(right)) <= 1e-12 * sum(map(abs, (*left, *right)))


GENERAL_SEEDS = [
    *(3, 5, 8, 15, 16, 17, 18, 19, 20, 22, 24, 25, 27, 28, 30, 33, 34),
    *(35, 38, 58, 64, 68, 70, 76, 77),
]


@pytest.mark.parametrize("seed", some(GENERAL_SEEDS))
def test_general_accounts_close(seed, tmp_path):
    params, intervals = reference.random_general_scene(np.random.default_rng(seed), tmp_path)
    points = reference.simulate(params, intervals)
    scale = natural_scales(points)["energy.residual"]
    for point in points:
        assert abs(point.energy["residual"]) <= 1e-11 * scale
        assert all(point.energy[name] >= 0 for name in reference.HEATS)


@pytest.mark.parametrize("seed", [5, 8, 16, 18, 19, 20, 22, 25, 27, 33, 39, 41])
def test_general_events_against_stepping_through_the_inclusion(seed, tmp_path):
    params, intervals = reference.random_general_scene(np.random.default_rng(seed), tmp_path)
    intervals = intervals[:6]
    exact = np.array([point.theta for point in reference.simulate(params, intervals)])
    span = exact.max() - exact.min()
    coarse, fine = (np.abs(step_through(params, intervals, steps) - exact) for steps in (250, 1000))
    assert np.all(fine <= 1e-2 * span)
    assert np.all(fine <= 0.5 * coarse + 1e-4 * span)


def test_cubic_inputs_without_a_spring():
    """J theta'' = tau(t) - rho F_ext(t): polynomials."""
    tau, pull, h = (3.0, 20.0, -1.5e3, 2e5), (10.0, -30.0, 2e3, -1e5), 0.02
    params = {"spring.preload": 0.0, "spring.stiffness": 0.0, "stop.upper": 50.0}
    rho = 0.01 * 1.14 / 0.86
    u = [(a - rho * b) / 0.002 for a, b in zip(tau, pull, strict=True)]
    interval = Interval(h, *tau[:2], *pull[:2], *tau[2:], *pull[2:])
    (point,) = reference.simulate(params, [interval])
    powers = [h**k / math.factorial(k) for k in range(6)]
    assert point.omega == pytest.approx(sum(a * p for a, p in zip(u, powers[1:], strict=False)), rel=1e-13)
    assert point.theta == pytest.approx(sum(a * p for a, p in zip(u, powers[2:], strict=False)), rel=1e-13)
    assert interval.at("tau", h)[0] == pytest.approx(sum(a * p for a, p in zip(tau, powers, strict=False)))
    turn = max(np.polyval([2e5 / 6, -1.5e3 / 2, 20.0, 3.0], t) for t in np.linspace(0, h, 2001))
    assert point.peak["torque"] == pytest.approx(turn, rel=1e-6)


def test_viscous_motion_with_both_dampers_is_a_lambert_function():
    # q v^2 + c v = G = tau/rho - F_0 - k z; s = 2 q v/c: s + ln s falls by k t/c
    c, q, k, tau, h = 300.0, 4000.0, 50e3, 4.0, 0.01
    params = {"inertia.shaft": 0.0, "damper.c_load": c, "damper.q_load": q}
    rho = 0.01 * 1.14 / 0.86
    force = tau / rho - 50.0
    s0 = 2 * q * ((-c + math.sqrt(c * c + 4 * q * force)) / (2 * q)) / c
    v = c / (2 * q) * float(scipy.special.lambertw(s0 * math.exp(s0 - k * h / c)).real)
    (point,) = reference.simulate(params, [Interval(h, tau)])
    assert point.v == pytest.approx(v, rel=1e-12)
    assert point.z == pytest.approx((force - c * v - q * v * v) / k, rel=1e-12)


def test_inertial_motion_with_quadratic_damper_is_a_riccati_solution():
    # y = omega^2: y' = 2 (A - K theta - Q y), thus y = p + s theta + (y0 - p) exp(-2 Q theta)
    q, tau = 900.0, 3.0
    rho, dz, inertia = 0.01 * 1.14 / 0.86, 0.01, 0.002
    A, K, Q = (tau - rho * 50.0) / inertia, rho * 50e3 * dz / inertia, rho * q * dz**2 / inertia
    s = -K / Q
    p = (A - s / 2) / Q
    square = lambda theta: p + s * theta - p * math.exp(-2 * Q * theta)  # noqa: E731
    params = {"damper.q_load": q}
    moving, resting = reference.simulate(params, [Interval(0.02, tau), Interval(0.2, tau)])
    assert moving.omega == pytest.approx(math.sqrt(square(moving.theta)), rel=1e-12)
    top = scipy.optimize.brentq(square, moving.theta, 1.3, xtol=1e-15)
    assert (resting.mode, resting.theta) == (1, pytest.approx(top, rel=1e-13))


def test_play_is_the_limit_of_vanishing_damping(tmp_path):
    """Without damping the angle follows the band's edge, and snaps on where that falls (a dwell ahead); the
    edge torque there is checked too, and the work along it."""
    psi = np.linspace(0.0, 1.5, 31)
    slope = lambda p: 0.02 * (1 - 0.9 * np.exp(-(((p - 0.6) / 0.15) ** 2)))  # noqa: E731
    z = [scipy.integrate.quad(slope, 0, p)[0] for p in psi]
    reference.write_table(tmp_path / "soft.csv", psi, z)
    params = ELLIPSES | {"cam2.profile": 3, "cam2.table": str(tmp_path / "soft.csv"), "inertia.shaft": 0.0}
    params |= {"spring.stiffness": 8e3, "spring.stiffness2": 3e4, "stop.upper": 1.4}
    intervals = [
        Interval(0.4, 0.0, 4.0, tau_rate2=2.0),
        Interval(0.3, 1.8, -4.0, 3.0, 20.0),
        Interval(0.4, 0.6, 9.0),
    ]
    play = reference.simulate(params, intervals)
    assert any(math.isinf(p.peak["omega"]) for p in play)
    errors = []
    for b in (3e-3, 3e-4):
        slow = reference.simulate(params | {"shaft.damping": b}, intervals)
        errors.append([abs(p.theta - o.theta) for p, o in zip(slow, play, strict=True)])
        for p, o in zip(slow, play, strict=True):
            assert p.energy["heat_cam1"] == pytest.approx(o.energy["heat_cam1"], rel=10 * b)
    for coarse, fine in zip(*errors, strict=True):
        assert fine <= 0.2 * coarse + 1e-12
    m = Mechanism(params, DOUBLE)
    end = play[0]
    kin = m.groove.at(end.theta)
    tau = intervals[0].at("tau", 0.4)[0]
    if end.mode == 2:
        assert tau == pytest.approx(m.static_ratio(kin, +1) * m.spring_force(kin.z), rel=1e-12)
    assert abs(play[-1].energy["residual"]) <= 1e-13 * play[-1].energy["work_in"]
