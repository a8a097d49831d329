"""The oracle of the accuracy tests, checked by other means than its own."""

import itertools
import math

import mpmath
import numpy as np
import pytest
import reference
from reference import DOUBLE, MP, SIXTY_DIGITS, Interval, Mechanism, Refused, Slip, random_scene

# Section 3 of the equations solved at 60 digits, each number rounded to 17; totals, F > 0.
# r1, r2, lambda1, lambda2, mu1, mu2, F, (R1, R2, T) loading, (R1, R2, T) releasing on supporting flanks;
# None: those flanks cannot carry the load.
STATICS = [
    (0.02, 0.02, 0.7853981633974483, 0.7853981633974483, 0.14, 0.14, 100.0,
     (82.221718742621803, 82.221718742621803, 1.3255813953488372),
     (62.026910630398903, 62.026910630398903, 0.75438596491228065)),
    (0.02, 0.02, 0.7853981633974483, 0.7853981633974483, 0.19, 0.19, 100.0,
     (87.297133479820678, 87.297133479820678, 1.4691358024691357),
     (59.420737914835925, 59.420737914835925, 0.68067226890756299)),
    (0.0275, 0.0175, 0.9, 0.8203, 0.14, 0.14, 350.0,
     (237.9808184342142, 393.65437179815683, 5.6959967326383234),
     (168.18560855375208, 289.40920407613602, 3.220467081719058)),
    (0.03, 0.02, 0.5843738968484468, 0.923511478779244, 0.1, 0.2, 100.0,
     (80.71481136041947, 83.729195762671192, 1.537818257344766),
     (59.514180549309163, 61.736803814320015, 0.83606387137985378)),
    (0.02, 0.03, 0.13909694148207133, 0.7, 0.14, 0.14, 100.0,
     (87.955686752424719, 21.642451942859043, 0.48779636328858385),
     (99.034069570861164, 1.2411405424503868e-4, 1.9999978775525759e-6)),
    (0.02, 0.03, 0.1, 0.8, 0.14, 0.14, 100.0,
     (91.101181445558148, 17.822655349626075, 0.43570779808567673), None),
    (0.02, 0.03, 0.1, 0.12, 0.19, 0.19, 100.0,
     (63.21404846392025, 39.482808974770059, 0.36523080656223978),
     (52.899371729445919, 45.651430725065573, -0.09439086143885512)),
    (0.02, 0.03, 1.5, 0.6, 0.14, 0.19, 100.0,
     (166.80034218389302, 155.27332474224857, 3.3606872722867323),
     (58.275227681505512, 94.078935289712843, 1.151042714818565)),
    (0.02, 0.03, 1.5, 1.5, 0.14, 0.14, 100.0,
     None, (285.18940169279986, 190.12626779519992, 5.6330141678046557)),
    (0.025, 0.015, 0.6, 1.1, 0.0, 0.0, 250.0,
     (191.67213239297345, 202.39626931082316, 2.7056556728817302),
     (191.67213239297345, 202.39626931082316, 2.7056556728817302)),
    (0.025, 0.015, 0.6, 1.1, 0.0, 0.25, 250.0,
     (240.03069021527413, 224.85012356846291, 3.3882880653467474),
     (152.0949619061819, 184.01979039874173, 2.1469818870407558)),
    (0.02, 0.02, 0.02, 0.24, 0.14, 0.14, 100.0,
     (71.501684082224646, 30.60872350511177, 0.22876344278127149), None),
]  # fmt: skip

# A mixture of the three regimes and of all events; chosen for speed in double precision too.
SLOW = {4, 9, 13, 15, 16, 21, 25, 27, 28, 31, 35, 37}
SEEDS = [seed for seed in range(40) if seed not in SLOW]
COMPARED = ("theta", "omega", *(f"energy.{name}" for name in reference.ENERGIES))


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


@pytest.mark.parametrize("case", STATICS)
def test_statics_of_the_table(case):
    *shape, force, loading, releasing = case
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
    shape = STATICS[5][:6]
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
        reference.simulate(geometry(*STATICS[8][:6]), [Interval(0.1, 1.0)])


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


@pytest.mark.parametrize("seed", SEEDS)
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


@pytest.mark.parametrize("seed", range(40, 70))
def test_accounts_close(seed):
    params, intervals = scene(seed)
    points = reference.simulate_exact(params, intervals)
    scale = natural_scales(points)["energy.residual"]
    for point in points:
        assert abs(point.energy["residual"]) <= 1e-40 * scale
        assert all(point.energy[name] >= 0 for name in reference.HEATS)


def step_through(params, intervals, steps):
    """Implicit Euler on the inclusion itself: of all directions and flanks (and rest), the one whose solution
    has the signs it assumes. First order, and knows no events. theta at the end of each interval."""
    m = Mechanism(params, DOUBLE)
    kin = m.groove.at(0.0)
    g, dz, k = kin.dgamma, kin.dz, m.spring[1]
    theta, omega, found = m.theta0, m.omega0, []
    ways = list(itertools.product((1, -1), (1, -1), (1, -1)))
    for interval in intervals:
        h = interval.duration / steps
        for i in range(steps):
            tau = interval.tau + interval.tau_rate * h * (i + 1)
            f0 = m.spring[0] + interval.F_ext + interval.F_ext_rate * h * (i + 1) + k * dz * theta
            matrices, sides = [], []
            for sigma, e1, e2 in ways:
                n1, n2 = kin.a1 + sigma * e1 * m.mu1 * m.r1, kin.a2 + sigma * e2 * m.mu2 * m.r2
                d1, d2 = m.r1 - sigma * e1 * m.mu1 * kin.a1, m.r2 - sigma * e2 * m.mu2 * kin.a2
                c = m.damper[sigma][0]
                matrices.append(  # of (x1, x2, omega at the end)
                    [
                        [d1, d2, -(k * h + c) * dz - m.m * dz / h],
                        [m.r1 * n1, -m.r2 * n2, m.I * g / h],
                        [0.0, m.r2 * n2, m.b + m.J / h],
                    ]
                )
                sides.append([[f0 - m.m * dz * omega / h], [m.I * g * omega / h], [tau + m.J * omega / h]])
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
