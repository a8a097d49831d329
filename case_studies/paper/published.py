"""Published and assumed values of the paper, and the choices of this reproduction.

SI units. Torque and axial force are totals of the mechanism, reactions are per contact (two share the load).
"""

from __future__ import annotations

GREASES = (0.14, 0.19)  # friction with grease 1 and 2
RANGE = 1.3963  # rad
LEVER = 0.500  # m
TORQUE = 10.0  # N.m, its order
TILT = 0.0524  # rad, misalignment
LOADING, RELEASING = 1, -1  # sign of the direction of motion
CONTACTS = 2
PUBLISHED = {"A": {LOADING: 0.451, RELEASING: 0.735}, "B": {LOADING: 1.51, RELEASING: 0.69}}  # RMSE, N.m
UNCERTAINTY = 0.0029  # relative, in total and with the misalignment right

# assumed: neither radii nor arcs nor spring are published
INNER_RADIUS, OUTER_RADIUS = 0.020, 0.025  # m
PRELOAD = 0.3  # share of the spring's force at the end of the range
ARCS = {
    "A": (0.8203, 0.12, 0.08),
    "B": (0.8552, 0.12, 0.20),
}  # start angle, rad; radius of inner, outer arc, m

PAIRS = ("A", "B")
DIRECTIONS = {LOADING: "loading", RELEASING: "releasing"}
UNEQUAL, RADII = GREASES, (INNER_RADIUS, OUTER_RADIUS)
EQUAL = (0.02, 0.02)  # radii, m
OTHERS = 60  # other pairs of each kind that the published facts allow
MAP = 360  # points along each axis of the efficiency map
READINGS = 15  # angles at which a torque is read by hand, assumed
FEW = 5  # and if they are few
SPEED, QUADRATIC = 0.1, 1000.0  # m/s and N.s2/m2: example of a damper
PULL = -1500.0  # N: example of an external axial force
EXPONENTS = (1 / 3, 1 / 2)  # of the load, by which friction falls
WEAR, HARDNESS = 1e-5, 2e9  # Archard's K and H [Pa], assumed

# assumed, plausible for greased steel: static over kinetic coefficient, Stribeck velocity [m/s] and exponent,
# slope of the lubricated branch [s/m], exponents of the load
PEAK, STRIBECK_VELOCITY, STRIBECK_EXPONENT, VISCOUS = 1.3, 0.01, 2, 0.3
LOAD_EXPONENTS = (-1 / 3, 1 / 3)
SLIDING = (0.0, 0.003, 0.01, 0.03, 0.1)  # m/s: mean sliding speeds of steady turning
FACTORS = (0.3, 2.0)  # friction over the grease's, where a law that fits is sought
LOAD = 200.0  # N: nominal load at which the factor is meant
# assumed tolerances of the prototypes: standard deviation of the friction; limits of springs and arcs
# (relative), of lead angles [rad] and radii [m]; largest clearance [m]
FRICTION_SPREAD, SPRING_LIMIT, SHAPE_LIMIT = 0.01, 0.05, 0.02
LEAD_LIMIT, RADIUS_LIMIT, CLEARANCE = 0.0087, 5e-5, 1e-4
