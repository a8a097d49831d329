/* The mechanism as it is often written by hand: an explicit FMU with a fixed step of its own, semi-implicit Euler,
 * friction by sign(omega), stick below a velocity threshold. A peer of benchmarks/work_precision. Equations of
 * docs/mechanism.md, section 6, with both grooves alike (gamma = theta/2) and pins that keep their flank, as in
 * plain_cam.py.
 */
#include <math.h>

#include "../null_fmu/bare.h"

/* z, g' and g'' at psi. */
typedef struct {
    double z, a, dda;
} Groove;

/* kept: the slope of the helix; or sine and cosine with which the ellipse starts. */
static Groove groove_at(const Values *p, double psi) {
    const double r = p->real[VR_cam1_radius];
    if (p->integer[VR_cam1_profile] == 1) {
        const double slope = p->kept[0];
        return (Groove){slope * psi, slope, 0.0};
    }
    const double b = p->real[VR_cam1_ellipse_b], kappa = p->integer[VR_cam1_ellipse_curvature];
    const double ds_dpsi = kappa * r / p->real[VR_cam1_ellipse_a], c0 = p->kept[1];
    const double s = p->kept[0] + ds_dpsi * psi, c = sqrt(1.0 - s * s), slope = kappa * ds_dpsi * b / c;
    return (Groove){kappa * b * (c0 - c), slope * s, ds_dpsi * slope / (c * c)};
}

/* Torque per axial force, sliding in direction sigma. */
static double rho(double r, double mu, double a, double sigma) {
    return r * (a + sigma * mu * r) / (2.0 * (r - sigma * mu * a));
}

static double sign(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }

/* One step of semi-implicit Euler: speed first, then the angle with the new speed. */
static void euler(Values *p, double tau, double h) {
    const double theta = p->real[VR_theta], omega = p->real[VR_omega];
    const double r = p->real[VR_cam1_radius], mu = p->real[VR_cam1_friction];
    const Groove g = groove_at(p, theta / 2.0);
    const double spring = p->real[VR_spring_preload] +
                          g.z * (p->real[VR_spring_stiffness] +
                                 g.z * (p->real[VR_spring_stiffness2] + g.z * p->real[VR_spring_stiffness3]));
    double sigma = sign(omega);
    if (fabs(omega) < p->real[VR_solver_threshold]) {
        sigma = tau > rho(r, mu, g.a, 1.0) * spring ? 1.0 : tau < rho(r, mu, g.a, -1.0) * spring ? -1.0 : 0.0;
        if (sigma == 0.0) {
            p->real[VR_omega] = 0.0;
            return;
        }
    }
    const double half = g.a / 2.0, ratio = rho(r, mu, g.a, sigma), v = half * omega;
    const double c = p->real[sigma > 0.0 ? VR_damper_c_load : VR_damper_c_release];
    const double q = p->real[sigma > 0.0 ? VR_damper_q_load : VR_damper_q_release];
    const double m = p->real[VR_inertia_follower_mass];
    const double axial = spring + v * (c + q * fabs(v)) + m * g.dda / 4.0 * omega * omega;
    const double inertia = p->real[VR_inertia_shaft] + ratio * m * half + p->real[VR_inertia_follower] / 4.0;
    double next = omega + h * (tau - p->real[VR_shaft_damping] * omega - ratio * axial) / inertia;
    if (sign(next) == -sign(omega)) next = 0.0;
    p->real[VR_omega] = next;
    p->real[VR_theta] = theta + h * next;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Values *p = c;
    const double steep = tan(p->real[VR_cam1_lead_angle]);
    const double tangent = p->real[VR_cam1_ellipse_a] / p->real[VR_cam1_ellipse_b] * steep;
    p->kept[1] = 1.0 / sqrt(1.0 + tangent * tangent);
    p->kept[0] = p->integer[VR_cam1_profile] == 1 ? p->real[VR_cam1_radius] * steep : tangent * p->kept[1];
    p->real[VR_theta] = p->real[VR_initial_theta];
    p->real[VR_omega] = p->real[VR_initial_omega];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state) {
    (void)time, (void)no_set_state;
    Values *p = c;
    const double count = ceil(step / p->real[VR_solver_step] * (1.0 - 1e-9));
    for (double k = 0.0; k < count; k++) euler(p, p->real[VR_tau], step / count);
    return isfinite(p->real[VR_theta]) ? fmi2OK : fmi2Error;
}
