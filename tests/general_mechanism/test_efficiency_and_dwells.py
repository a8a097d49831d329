"""Section 8 of docs/mechanism.md: efficiency along a groove, and dwells."""

import math

import numpy as np
import pytest
from pin_equations import HEATS, HELIX, TABLE, Pin, ellipse, write_table
from reference import STICK
from scipy.optimize import brentq


@pytest.mark.parametrize(
    ("mu", "r", "best"),
    [
        ((0.14, 0.14), (0.02, 0.02), 0.5690981841),
        ((0.14, 0.14), (0.03, 0.018), 0.5690981841),
        ((0.19, 0.19), (0.02, 0.025), 0.4633147377),
        ((0.1, 0.2), (0.03, 0.02), None),
        ((0.25, 0.05), (0.02, 0.03), None),
    ],
)
def test_section_8_optimum_passed_on_ellipses(make, mu, r, best):
    """Two flattening ellipses, made so that both grooves have tan lambda_i = mu_i/mu_e at one theta: the
    efficiency there is ((1 - mu_e)/(1 + mu_e))^2, and is smaller everywhere else on the way. For mu1 = mu2
    that is pi/4, and the page's number."""
    mu_e = math.sqrt((mu[0] / r[0] + mu[1] / r[1]) / (1 / (mu[0] * r[0]) + 1 / (mu[1] * r[1])))
    target = [math.atan(m / mu_e) for m in mu]
    if best is None:
        best = ((1 - mu_e) / (1 + mu_e)) ** 2
    else:
        assert mu_e == pytest.approx(mu[0], rel=1e-15) and target == pytest.approx(
            [math.pi / 4] * 2, rel=1e-15
        )

    def rise(lead, radius, a, b, end):
        """Angle and z at which an ellipse that starts at `lead` has flattened to `end`."""
        S0, S1 = (math.sin(math.atan(a / b * math.tan(x))) for x in (lead, end))
        return (S0 - S1) * a / radius, b * (math.sqrt(1 - S1**2) - math.sqrt(1 - S0**2))

    a, b = 0.06, 0.05
    first = target[0] + 0.15
    psi1, z = rise(first, r[0], a, b, target[0])
    second = brentq(
        lambda x: rise(x, r[1], a, b, target[1])[1] - z, target[1], min(target[1] + 0.5, 1.5), xtol=1e-15
    )
    psi2, _ = rise(second, r[1], a, b, target[1])
    at = psi1 + psi2
    pin = Pin(ellipse(r[0], first, a, b, -1), ellipse(r[1], second, a, b, -1))
    values = pin.values | {"cam1.friction": mu[0], "cam2.friction": mu[1], "stop.upper": 1.5 * at}

    def efficiency(theta):
        return make().start(values | {"initial.theta": theta}).get("efficiency")

    assert [math.atan(a / r) for a, r in zip(pin.at(at).a, pin.at(at).r, strict=True)] == pytest.approx(
        target, rel=1e-12
    )
    assert efficiency(at) == pytest.approx(best, abs=1e-10)
    assert best == pytest.approx(((1 - mu_e) / (1 + mu_e)) ** 2, abs=1e-10)
    scan = [efficiency(x) for x in np.linspace(0.0, 1.5 * at, 16) if abs(x - at) > 1e-6]
    assert max(scan) < best
    assert max(efficiency(at - 1e-3), efficiency(at + 1e-3)) < best


DWELL = (0.5, 0.9)  # rad in the groove


def dwelling(folder, cam):
    """A table that rises, stands still over DWELL, rises; beside it a helix. On the dwell of cam 1 the pin
    stands still in cam 2, and goes along the groove of cam 1; on that of cam 2 it stands still altogether.
    theta at which the dwell begins and ends."""
    radius, slope, other = 0.02, 0.02, 0.02 * math.tan(0.7)
    psi = np.arange(0, 29) * 0.05
    z = slope * (np.minimum(psi, DWELL[0]) + np.maximum(psi - DWELL[1], 0.0))
    z[(psi >= DWELL[0] - 1e-9) & (psi <= DWELL[1] + 1e-9)] = slope * DWELL[0]
    table = {"profile": TABLE, "table": write_table(folder / "dwell.csv", psi, z), "radius": radius}
    plain = {"profile": HELIX, "lead_angle": 0.7, "radius": 0.02}
    values = {f"cam{cam}.{name}": value for name, value in table.items()}
    values |= {f"cam{3 - cam}.{name}": value for name, value in plain.items()}
    begin = DWELL[0] + slope * DWELL[0] / other
    return values | {"stop.upper": 1.8}, (begin, begin + DWELL[1] - DWELL[0]), slope * DWELL[0], other


@pytest.mark.parametrize("cam", [1, 2])
def test_section_8_dwell_without_friction_in_it(make, tmp_path, cam):
    """On the dwell of one cam, with friction only in the other, in which the pin does not move: both edges
    are 0, and cam 2 goes on at a constant speed however hard the spring presses."""
    values, (begin, end), height, _ = dwelling(tmp_path, cam)
    values |= {f"cam{cam}.friction": 0.0, f"cam{3 - cam}.friction": 0.3, "inertia.follower_mass": 3.0}
    fmu = make().start(values | {"initial.theta": begin + 0.01, "initial.omega": 2.0})
    for _ in range(5):
        fmu.step(0.03)
        assert fmu.get("omega") == pytest.approx(2.0, rel=1e-12)
        assert (fmu.get("v"), fmu.get("alpha")) == pytest.approx((0.0, 0.0), abs=1e-9)
        assert fmu.get("z") == pytest.approx(height, rel=1e-12)
        assert (fmu.get("torque_load"), fmu.get("torque_release")) == pytest.approx((0.0, 0.0), abs=1e-14)
        assert fmu.get(f"cam{3 - cam}.sliding_speed") == pytest.approx(0.0, abs=1e-15)
        assert fmu.get(f"cam{cam}.sliding_speed") == pytest.approx(2.0 * 0.02, rel=1e-12)
    assert fmu.get("theta") == pytest.approx(begin + 0.31, rel=1e-12)
    assert [fmu.get(name) for name in HEATS] == pytest.approx([0.0] * 5, abs=1e-12)
    fmu.step(0.02, tau=1.0)  # alpha = tau/J, as if nothing else were there
    assert fmu.get("omega") == pytest.approx(2.0 + 1.0 / 0.002 * 0.02, rel=1e-9) or fmu.get("theta") > end


@pytest.mark.parametrize("cam", [1, 2])
@pytest.mark.parametrize("other", [0.0, 0.2])
def test_section_8_dwell_brakes_the_mechanism(make, tmp_path, cam, other):
    """z stands still, yet friction on the dwell takes torque: with a = 0 in that groove
    T = F r1 r2 n1 n2/Delta, n = sigma e mu r of the dwelling cam. Both ways the mechanism is self-locking
    there; thrown in, it comes to rest after omega^2 J/(2 T), and stays."""
    values, (begin, end), height, slope = dwelling(tmp_path, cam)
    mu = 0.25
    values |= {f"cam{cam}.friction": mu, f"cam{3 - cam}.friction": other}
    force = 50.0 + 5e4 * height
    r = 0.02
    d = r - other * slope
    n = slope + other * r
    load = force * r * r * mu * r * n / (r * r * n + r * d * mu * r)
    # sigma = -1: the dwelling contact stays on its flank (n = -mu r), so the other one has to change its own
    release = -force * r * r * mu * r * n / (r * r * n - r * d * mu * r)
    fmu = make().start(values | {"initial.theta": begin + 0.02})
    assert fmu.get("torque_load") == pytest.approx(load, rel=1e-11)
    assert fmu.get("torque_release") == pytest.approx(release, rel=1e-11)
    for torque, mode in ((0.99 * load, STICK), (0.99 * release, STICK), (0.0, STICK)):
        fmu.step(0.01, tau=torque)
        assert (fmu.get("mode"), fmu.get("theta")) == (mode, begin + 0.02)
    omega = math.sqrt(2 * load * 0.3 / 0.002)
    fmu = make().start(values | {"initial.theta": begin + 0.02, "initial.omega": omega})
    assert fmu.get("alpha") == pytest.approx(-load / 0.002, rel=1e-10)
    fmu.step(0.5)
    assert (fmu.get("mode"), fmu.get("omega")) == (STICK, 0.0)
    assert fmu.get("theta") == pytest.approx(begin + 0.32, rel=1e-10)
    assert fmu.get("z") == pytest.approx(height, rel=1e-12)
    assert fmu.get(f"energy.heat_cam{cam}") == pytest.approx(load * 0.3, rel=1e-10)
    assert fmu.get(f"energy.heat_cam{3 - cam}") == pytest.approx(0.0, abs=1e-12)
    fmu = make().start(
        values | {"initial.theta": end - 0.02, "initial.omega": -math.sqrt(-2 * release * 0.3 / 0.002)}
    )
    fmu.step(0.5)
    assert (fmu.get("mode"), fmu.get("omega")) == (STICK, 0.0)
    assert fmu.get("theta") == pytest.approx(end - 0.32, rel=1e-10)
