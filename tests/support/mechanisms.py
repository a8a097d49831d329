"""Parameters of mechanisms that several tests drive, and numbers of the default mechanism, worked out by
hand."""

ELLIPSES = {"cam1.profile": 2, "cam2.profile": 2, "cam2.radius": 0.025, "cam2.lead_angle": 0.7}
GROOVES = {
    "helices": {"cam1.lead_angle": 0.6, "cam2.lead_angle": 0.9},
    "ellipses": ELLIPSES,
    "mixed": ELLIPSES | {"cam1.profile": 1, "cam1.ellipse_curvature": 1},
}
FORCES = {
    "spring.stiffness2": 1e5,
    "spring.stiffness3": 1e6,
    "damper.c_load": 20.0,
    "damper.q_load": 50.0,
    "damper.c_release": 30.0,
    "damper.q_release": 40.0,
}
FOLLOWER = {"inertia.follower_mass": 0.3, "inertia.follower": 3e-5, "shaft.damping": 0.01}

# The start values: two equal helices of 45 deg, r = 0.02 m, so z = r theta/2, and with s = tan(45 deg) = 1
# kappa = (1 - sigma mu s)/(r (s + sigma mu)), rho = 1/(2 kappa): torque per axial force.
MU, LIFT, PRELOAD, STIFFNESS, INERTIA = 0.14, 0.01, 50.0, 50e3, 0.002
RHO = {sigma: LIFT * (1 + sigma * MU) / (1 - sigma * MU) for sigma in (1, -1)}
