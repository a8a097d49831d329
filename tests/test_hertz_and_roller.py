"""Line contact by Hertz and the roller, against elasticity and a balance of moments that know no formula of
dualcam.design."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, minimize

from dualcam.design import Pin, Roller, hertz_pressure, line_contact, relative_radius, shear_below
from dualcam.errors import DesignError, UnitWarning

BRONZE = Pin(radius=0.004, width=0.009, cam_modulus=110e9, cam_poisson=0.34)


@pytest.fixture(params=[0.0, 35.0, -60.0], ids=["straight", "hollow", "bulging"])
def bend(request):
    return request.param


def test_the_pressure_carries_the_load(bend):
    """The integral of the half ellipse of pressure over the width of the contact is the load per length."""
    contact = line_contact(730.0, BRONZE, bend)
    a, top = float(contact.half_width), float(contact.pressure)
    total, _ = quad(lambda x: top * math.sqrt(1.0 - (x / a) ** 2), -a, a)
    assert total == pytest.approx(730.0 / BRONZE.width, rel=1e-9)


@pytest.mark.parametrize("place", [-0.9, -0.4, 0.1, 0.6])
def test_the_surfaces_touch_everywhere_inside(bend, place):
    """Slope of the pressed half-space, by Cauchy's principal value of the pressure (Johnson, section 2.7),
    is that of the two round bodies: x over their relative radius."""
    contact = line_contact(730.0, BRONZE, bend)
    a, top = float(contact.half_width), float(contact.pressure)
    x = place * a

    def pressure(t):
        return top * math.sqrt(1.0 - t**2)

    value, _ = quad(pressure, -1.0, 1.0, weight="cauchy", wvar=place)  # of p/(s - x)
    slope = 2.0 / (math.pi * BRONZE.contact_modulus) * value
    assert slope == pytest.approx(-x / float(relative_radius(BRONZE, bend)), rel=1e-6)


def test_relative_radius_is_that_of_pin_and_flank():
    """A path that is a circle of radius 50 mm, bent upwards: the flank below has the radius 50 mm + r."""
    pin = Pin(radius=0.005, width=0.01)
    below = 1.0 / (1.0 / 0.005 - 1.0 / 0.055)  # the pin inside the hollow flank
    above = 1.0 / (1.0 / 0.005 + 1.0 / 0.045)  # the pin on the bulging flank
    assert float(relative_radius(pin, 20.0)) == pytest.approx(below, rel=1e-12)
    assert float(relative_radius(pin, -20.0)) == pytest.approx(above, rel=1e-12)


# ---- stress below the surface, by integrating line loads over the half-space ----


def stress_below(x, z, a, top):
    """Stresses below an elliptical pressure, from Flamant's line load (Johnson, section 2.3)."""
    angle = np.linspace(0.0, math.pi, 4001)
    s = a * np.cos(angle)
    weight = top * a * np.sin(angle) ** 2  # p ds
    square = (x - s) ** 2 + z**2

    def total(kernel):
        return np.trapezoid(weight * kernel / square**2, angle)

    along = -2.0 / math.pi * total(z * (x - s) ** 2)
    down = -2.0 / math.pi * total(z**3 + 0.0 * s)
    across = -2.0 / math.pi * total(z**2 * (x - s))
    return along, down, across


def largest_shear(x, z, a=1.0, top=1.0):
    along, down, across = stress_below(x, z, a, top)
    return math.hypot(0.5 * (along - down), across)


@pytest.mark.parametrize("depth", [0.1, 0.5, 0.786, 1.3, 4.0])
def test_shear_below_is_that_of_the_half_space(depth):
    expected = largest_shear(0.0, depth * 2e-4, 2e-4, 900e6)
    assert float(shear_below(depth * 2e-4, 2e-4, 900e6)) == pytest.approx(expected, rel=1e-6)


def test_largest_shear_is_at_0_786_a_on_the_axis():
    """The largest one in the whole half-plane, found by a search."""
    found = minimize(lambda place: -largest_shear(*place), x0=[0.3, 0.5], method="Nelder-Mead", tol=1e-9)
    assert found.x == pytest.approx([0.0, 0.786], abs=5e-4)
    assert -found.fun == pytest.approx(0.300, abs=5e-4)
    contact = line_contact(500.0, BRONZE)
    a, top = float(contact.half_width), float(contact.pressure)
    assert [float(contact.depth) / a, float(contact.shear) / top] == pytest.approx(
        [*found.x[1:], -found.fun], 1e-5
    )
    assert float(shear_below(contact.depth, a, top)) == pytest.approx(float(contact.shear), rel=1e-12)


def test_contact_of_arrays_and_of_no_load():
    contact = line_contact([0.0, 100.0, 400.0], BRONZE)
    assert contact.pressure[0] == contact.half_width[0] == contact.shear[0] == 0.0
    assert contact.pressure[2] / contact.pressure[1] == pytest.approx(2.0)  # the root of the load
    assert np.array_equal(contact.pressure, hertz_pressure([0.0, 100.0, 400.0], BRONZE))


def test_an_undercut_flank_has_infinite_pressure_and_no_width():
    contact = line_contact(100.0, BRONZE, -1.0 / BRONZE.radius)
    assert math.isinf(contact.pressure) and math.isinf(contact.shear) and contact.half_width == 0.0


@pytest.mark.parametrize("load", [-1.0, math.nan, math.inf])
def test_a_load_that_presses_not(load):
    with pytest.raises(DesignError, match=r"load = .*: allowed are finite forces >= 0 in N"):
        line_contact(load, BRONZE)


# ---- roller ----


def moment(roller, tangential, normal=1000.0):
    """What accelerates the roller in its rolling direction [N.m]: drive at the flank, less both brakes."""
    drive = tangential * roller.radius
    return drive - roller.bearing_friction * normal * roller.bearing_radius - normal * roller.lever_arm


@pytest.mark.parametrize("bearing_friction, lever_arm", [(0.08, 0.0), (0.15, 2e-5), (0.002, 5e-5)])
def test_rolling_friction_balances_the_moments(bearing_friction, lever_arm):
    roller = Roller(0.006, bearing_friction, 0.0025, lever_arm)
    needed = brentq(lambda tangential: moment(roller, tangential), 0.0, 1000.0, xtol=1e-12)
    assert roller.rolling_friction == pytest.approx(needed / 1000.0, rel=1e-9)
    assert roller.rolls and roller.friction == roller.rolling_friction


def test_the_roller_slides_where_rolling_is_harder():
    roller = Roller(0.004, 0.2, 0.003, sliding_friction=0.1)
    assert not roller.rolls and roller.friction == 0.1
    assert moment(roller, 0.1 * 1000.0) < 0.0  # friction of sliding cannot turn the roller
    edge = Roller(0.004, roller.largest_bearing_friction, 0.003, sliding_friction=0.1)
    assert edge.rolling_friction == pytest.approx(0.1, rel=1e-12)


@pytest.mark.parametrize(
    "values, words",
    [
        ({"radius": -0.005}, "radius = -0.005: allowed is a finite number > 0 in m"),
        ({"bearing_friction": -0.1}, "bearing_friction = -0.1: allowed is a finite number >= 0"),
        ({"bearing_friction": math.nan}, "bearing_friction = nan: allowed"),
        (
            {"bearing_radius": 0.005},
            "bearing_radius = 0.005 m: allowed is more than 0 and less than the radius",
        ),
        ({"lever_arm": 0.01}, "lever_arm = 0.01 m: allowed is 0 to less than the radius of the roller"),
        ({"sliding_friction": math.inf}, "sliding_friction = inf: allowed"),
    ],
)
def test_refused_rollers(values, words):
    given = {"radius": 0.005, "bearing_friction": 0.1, "bearing_radius": 0.002} | values
    with pytest.raises(DesignError, match=words.replace("(", r"\(")):
        Roller(**given)


def test_millimetres_for_metres_are_guessed():
    with pytest.warns(UnitWarning, match="bearing_radius = 2 m: this looks like millimetres"):
        Roller(5.0, 0.1, 2.0)


def test_wear_rate_of_the_pin():
    with pytest.raises(DesignError, match=r"wear = -1.0: allowed is a number from 0 to 1 in m3/\(N.m\)"):
        Pin(radius=0.003, width=0.008, wear=-1.0)
    with pytest.warns(UnitWarning, match=r"wear = 1e-07 m3/\(N.m\): this looks like mm3/\(N.m\)"):
        Pin(radius=0.003, width=0.008, wear=1e-7)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: Pin(radius="3 mm", width=0.008), "radius = '3 mm': allowed is a number in the SI unit"),
        (lambda: Roller(0.005, 0.1, "2 mm"), "bearing_radius = '2 mm': allowed is a number in the SI unit"),
        (lambda: line_contact("400 N", Pin(0.003, 0.008)), "type text, such as '400 N': allowed are real"),
        (lambda: line_contact(None, Pin(0.003, 0.008)), "load [N] has elements of type object, such as None"),
    ],
)
def test_text_is_refused_by_name(call, words):
    with pytest.raises(DesignError) as error:
        call()
    assert words in str(error.value)
