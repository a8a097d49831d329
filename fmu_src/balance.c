#include "balance.h"

#include <math.h>

#include "dual.h"

double input_value(const double u[INPUT_ORDER + 1], double t) {
    return u[0] + t * (u[1] + t / 2.0 * (u[2] + t / 3.0 * u[3]));
}

double input_rate(const double u[INPUT_ORDER + 1], double t) {
    return u[1] + t * (u[2] + t / 2.0 * u[3]);
}

static FlowKind kind_of_way(const Params *p, int direction) {
    if (has_inertia(p)) return FLOW_INERTIAL;
    const double c = direction > 0 ? p->damper.c_load + p->damper.q_load : p->damper.c_release + p->damper.q_release;
    return c + p->shaft.damping > 0.0 ? FLOW_VISCOUS : FLOW_QUASISTATIC;
}

Way way_of(const Params *p, const Course *course, const Inputs *inputs, double theta, int direction,
           const int flank[2]) {
    return (Way){
        .params = p,
        .course = course,
        .piece = course_piece(course, theta, direction),
        .inputs = inputs,
        .kind = kind_of_way(p, direction),
        .direction = direction,
        .flank = {flank[0], flank[1]},
    };
}

/* ---- geometry and its derivatives by theta ---- */

typedef struct {
    double z;
    Dual slope[2];  /* a_i */
    Dual turn[2];   /* gamma', phi' */
    Dual lift;      /* z' */
    Dual turn_rate; /* gamma'' */
    Dual lift_rate; /* z'' */
} Shape;

static Spot straight_spot(const Piece *piece, double theta) {
    const double x = (theta - piece->middle) * piece->scale;
    return (Spot){.slope = {piece->slope[0][0], piece->slope[1][0]}, .z = piece->z[0] + x * piece->z[1]};
}

/* gamma' = a2/(a1+a2), z' = a1 gamma'; differentiated:
 *     gamma'' = (a2' phi' - a1' gamma')/(a1+a2)          z'' = a1' gamma'^2 + a2' phi'^2
 *     gamma''' = (a2'' phi' - a1'' gamma' - 2 gamma'' (a1'+a2'))/(a1+a2)
 *     z''' = a1'' gamma'^2 + a2'' phi'^2 + 2 gamma'' (a1' gamma' - a2' phi') */
static inline Shape shape_at(const Way *w, double theta) {
    Spot s = w->course->straight ? straight_spot(w->piece, theta) : piece_at(w->piece, theta);
    for (int i = 0; i < 2; i++) s.slope[i] = fmax(s.slope[i], 0.0); /* level, but for the polynomial's rounding */
    const double inverse = 1.0 / (s.slope[0] + s.slope[1]);
    const double g = s.slope[1] * inverse, f = s.slope[0] * inverse;
    const double bend = s.bend[0] + s.bend[1];
    const double gg = (s.bend[1] * f - s.bend[0] * g) * inverse;
    const double ggg = (s.twist[1] * f - s.twist[0] * g - 2.0 * gg * bend) * inverse;
    const double zz = s.bend[0] * g * g + s.bend[1] * f * f;
    const double zzz =
        s.twist[0] * g * g + s.twist[1] * f * f + 2.0 * gg * (s.bend[0] * g - s.bend[1] * f);
    return (Shape){
        .z = s.z,
        .slope = {{s.slope[0], s.bend[0]}, {s.slope[1], s.bend[1]}},
        .turn = {{g, gg}, {f, -gg}},
        .lift = {s.slope[0] * g, zz},
        .turn_rate = {gg, ggg},
        .lift_rate = {zz, zzz},
    };
}

/* ---- friction ---- */

typedef struct {
    Dual rn[2], d[2]; /* r_i n_i, d_i */
    Dual delta;
    Dual p, q; /* P, Q */
} Grip;

static inline Grip grip_of(const Way *w, const Shape *s) {
    Grip g;
    for (int i = 0; i < 2; i++) {
        const CamParams *cam = &w->params->cam[i];
        const double mu = w->direction * w->flank[i] * cam->friction;
        g.rn[i] = dual_line(cam->radius * (mu * cam->radius), cam->radius, s->slope[i]);
        g.d[i] = dual_line(cam->radius, -mu, s->slope[i]);
    }
    g.q = dual_multiply(g.d[0], g.rn[1]);
    g.delta = dual_add(g.q, dual_multiply(g.rn[0], g.d[1]));
    g.p = dual_multiply(g.rn[0], g.rn[1]);
    return g;
}

/* ---- forces ---- */

typedef struct {
    double c, q; /* of the damper in this direction */
} Damping;

static Damping damping_of(const Way *w) {
    const DamperParams *d = &w->params->damper;
    return w->direction > 0 ? (Damping){d->c_load, d->q_load} : (Damping){d->c_release, d->q_release};
}

/* ---- the equation of motion ---- */

static inline Pace pace_of_inertial(const Way *w, const Shape *s, const Grip *g, double omega, double t) {
    const Params *p = w->params;
    const double J = p->inertia.shaft, m = p->inertia.follower_mass, I = p->inertia.follower;
    const Damping damping = damping_of(w);
    const double v = s->lift.value * omega;
    const double damper = v * (damping.c + damping.q * fabs(v));
    const double damper_rate = damping.c + 2.0 * damping.q * fabs(v);
    const double spring = spring_force(&p->spring, s->z), F_ext = input_value(w->inputs->F_ext, t);
    const Dual load = {spring + F_ext + damper,
                       spring_rate(&p->spring, s->z) * s->lift.value + damper_rate * s->lift.slope * omega};
    const double drag = p->shaft.damping * omega, torque = input_value(w->inputs->tau, t), tau = torque - drag;
    Dual mass = dual_scale(J, g->delta);
    Dual net = {g->delta.value * tau - g->p.value * load.value,
                g->delta.slope * tau - g->p.slope * load.value - g->p.value * load.slope};
    double net_by_omega = -g->delta.value * p->shaft.damping - g->p.value * damper_rate * s->lift.value;
    if (m + I > 0.0) {
        const Dual pm = dual_scale(m, g->p), qi = dual_scale(I, g->q);
        mass = dual_add(mass, dual_add(dual_multiply(pm, s->lift), dual_multiply(qi, s->turn[0])));
        const Dual swirl = dual_add(dual_multiply(pm, s->lift_rate), dual_multiply(qi, s->turn_rate));
        net.value -= swirl.value * omega * omega;
        net.slope -= swirl.slope * omega * omega;
        net_by_omega -= 2.0 * swirl.value * omega;
    }
    const double inverse = 1.0 / mass.value;
    const double alpha = net.value * inverse;
    const double force_size = fabs(spring) + fabs(F_ext) + fabs(damper);
    return (Pace){
        .value = alpha,
        .size = (fabs(g->delta.value) * (fabs(torque) + fabs(drag)) + fabs(g->p.value) * force_size) * fabs(inverse),
        .by_theta = (net.slope - alpha * mass.slope) * inverse,
        .by_omega = net_by_omega * inverse,
        .by_time = (g->delta.value * input_rate(w->inputs->tau, t) - g->p.value * input_rate(w->inputs->F_ext, t)) *
                   inverse,
        .resistance = fabs(mass.value),
        .possible = mass.value * g->delta.value > 0.0,
        .stable = true,
    };
}

/* B omega + C omega |omega| = N with B = Delta b + P c z', C = P q z'^2, N = Delta tau - P F_0. Of two roots, which a
 * locked contact (P < 0) can cause, the one nearer to zero: there more torque means more speed. It is written without
 * cancellation. Backward, where a step may look, it is continued as an odd function. */
static inline Pace pace_of_viscous(const Way *w, const Shape *s, const Grip *g, double t) {
    const Params *p = w->params;
    const Damping damping = damping_of(w);
    const double tau = input_value(w->inputs->tau, t);
    const double spring = spring_force(&p->spring, s->z), F_ext = input_value(w->inputs->F_ext, t);
    const Dual load = {spring + F_ext, spring_rate(&p->spring, s->z) * s->lift.value};
    const Dual n = {g->delta.value * tau - g->p.value * load.value,
                    g->delta.slope * tau - g->p.slope * load.value - g->p.value * load.slope};
    const Dual pz = dual_multiply(g->p, s->lift);
    const Dual b = dual_add(dual_scale(p->shaft.damping, g->delta), dual_scale(damping.c, pz));
    const Dual c = dual_scale(damping.q, dual_multiply(pz, s->lift));
    const double sign = b.value < 0.0 || (b.value == 0.0 && c.value < 0.0) ? -1.0 : 1.0;
    const bool alike = b.value * c.value >= 0.0;
    const double four_cn = alike ? fabs(c.value * n.value) : c.value * w->direction * n.value;
    const double square = b.value * b.value + 4.0 * four_cn;
    const double sum = b.value + sign * sqrt(fmax(square, 0.0));
    const double omega = sum != 0.0 ? 2.0 * n.value / sum : 0.0;
    const double steepness = b.value + 2.0 * c.value * fabs(omega); /* dN/d omega */
    const double inverse = steepness != 0.0 ? 1.0 / steepness : 0.0;
    const double n_size =
        fabs(g->delta.value * tau) + fabs(g->p.value) * (fabs(spring) + fabs(F_ext));
    return (Pace){
        .value = omega,
        .size = sum != 0.0 ? 2.0 * n_size / fabs(sum) : 0.0,
        .by_theta = (n.slope - omega * (b.slope + c.slope * fabs(omega))) * inverse,
        .by_time = (g->delta.value * input_rate(w->inputs->tau, t) - g->p.value * input_rate(w->inputs->F_ext, t)) *
                   inverse,
        .possible = sum != 0.0 && square >= 0.0 && g->delta.value != 0.0,
        .stable = sign * g->delta.value > 0.0,
    };
}

/* On the band's edge E(theta) = rho F_0 the torque fixes theta, so (tau - rho F_ext)' = dE/dtheta omega. Value: that
 * omega; by_theta holds dE/dtheta itself, N.m/rad, which a step along the edge
 * solves with. */
static inline Pace pace_of_quasistatic(const Way *w, const Shape *s, const Grip *g, double t) {
    const Params *p = w->params;
    const Dual load = {spring_force(&p->spring, s->z) + input_value(w->inputs->F_ext, t),
                       spring_rate(&p->spring, s->z) * s->lift.value};
    const double inverse = 1.0 / g->delta.value;
    const double rho = g->p.value * inverse;
    const double rho_rate = (g->p.slope - rho * g->delta.slope) * inverse;
    const double stiffness = rho_rate * load.value + rho * load.slope;
    const double rate = input_rate(w->inputs->tau, t) - rho * input_rate(w->inputs->F_ext, t);
    return (Pace){
        .value = stiffness > 0.0 ? rate / stiffness : 0.0,
        .by_theta = stiffness,
        .net = input_value(w->inputs->tau, t) - rho * load.value,
        .resistance = stiffness,
        .possible = g->delta.value != 0.0,
        .stable = stiffness > 0.0,
    };
}

static inline Pace pace_of(const Way *w, const Shape *s, const Grip *g, double omega, double t) {
    switch (w->kind) {
        case FLOW_INERTIAL: return pace_of_inertial(w, s, g, omega, t);
        case FLOW_VISCOUS: return pace_of_viscous(w, s, g, t);
        default: return pace_of_quasistatic(w, s, g, t);
    }
}

Pace balance_pace(const Way *w, double theta, double omega, double t) {
    const Shape s = shape_at(w, theta);
    const Grip g = grip_of(w, &s);
    return pace_of(w, &s, &g, omega, t);
}

void balance_at(const Way *w, double theta, double omega, double t, Balance *out) {
    const Params *p = w->params;
    const Shape s = shape_at(w, theta);
    const Grip g = grip_of(w, &s);
    const Pace pace = pace_of(w, &s, &g, omega, t);
    const bool inertial = w->kind == FLOW_INERTIAL;
    const double alpha = inertial ? pace.value : 0.0;
    if (!inertial) omega = pace.value;
    const Damping damping = damping_of(w);
    const double v = s.lift.value * omega, damper = v * (damping.c + damping.q * fabs(v));
    const double F_ext = input_value(w->inputs->F_ext, t), force = spring_force(&p->spring, s.z) + F_ext;
    const double axial = force + damper +
                         p->inertia.follower_mass * (s.lift.value * alpha + s.lift_rate.value * omega * omega);
    const double twist = p->inertia.follower * (s.turn[0].value * alpha + s.turn_rate.value * omega * omega);
    const double inverse = 1.0 / g.delta.value;
    *out = (Balance){
        .theta = theta,
        .omega = omega,
        .alpha = alpha,
        .pace = pace,
        .tau = input_value(w->inputs->tau, t),
        .F_ext = F_ext,
        .force = force,
        .damper = damper,
        .z = s.z,
        .lift = s.lift.value,
        .turn = {s.turn[0].value, s.turn[1].value},
        .axial = {g.rn[1].value * inverse, g.rn[0].value * inverse},
        .x = {(g.rn[1].value * axial - g.d[1].value * twist) * inverse,
              (g.rn[0].value * axial + g.d[0].value * twist) * inverse},
    };
    for (int i = 0; i < 2; i++)
        out->length2[i] = p->cam[i].radius * p->cam[i].radius + s.slope[i].value * s.slope[i].value;
}

/* ---- how it changes ---- */

/* Size of the terms of P, which vanishes where a contact begins to lock. */
static double grip_size(const Way *w, const Shape *s) {
    double size = 1.0;
    for (int i = 0; i < 2; i++) {
        const CamParams *cam = &w->params->cam[i];
        size *= cam->radius * (s->slope[i].value + cam->friction * cam->radius);
    }
    return size;
}

/* The share of the course's size that counts as a term of z: its rounding is some eps of that size, where other sums
 * count as zero below 1e-13 of their terms. */
static const double COURSE_SHARE = 0.01;

/* Rates of change along the motion, and what they are made of. */
typedef struct {
    double pace;                    /* d pace/dt */
    double alpha, jerk;             /* rad/s^2, rad/s^3: as far as they act on the loads */
    double axial, twist;            /* N, N.m: A and W of the balance */
    double axial_rate, twist_rate;  /* N/s, N.m/s */
    double spring_rate, damper_rate, F_rate; /* N/s, N.s/m, N/s */
} Drift;

static Drift drift_of(const Way *w, const Shape *s, const Balance *now, double t) {
    const Params *p = w->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower;
    const Damping damping = damping_of(w);
    const bool inertial = w->kind == FLOW_INERTIAL;
    const double omega = now->omega, spin2 = omega * omega, v = s->lift.value * omega;
    Drift d = {
        .pace = now->pace.by_time + (w->kind == FLOW_QUASISTATIC ? 0.0 : now->pace.by_theta * omega) +
                now->pace.by_omega * now->alpha,
        .spring_rate = spring_rate(&p->spring, s->z) * v,
        .damper_rate = damping.c + 2.0 * damping.q * fabs(v),
        .F_rate = input_rate(w->inputs->F_ext, t),
    };
    d.alpha = inertial ? now->alpha : d.pace;
    d.jerk = inertial ? d.pace : 0.0;
    const double follow = s->lift.value * d.alpha + s->lift_rate.value * spin2; /* d^2 z/dt^2 */
    d.axial = now->force + now->damper + m * (inertial ? follow : 0.0);
    d.twist = I * (s->turn[0].value * now->alpha + s->turn_rate.value * spin2);
    d.axial_rate = d.spring_rate + d.F_rate + d.damper_rate * follow +
                   m * (s->lift.value * d.jerk + 3.0 * s->lift_rate.value * omega * d.alpha +
                        s->lift_rate.slope * spin2 * omega);
    d.twist_rate = I * (s->turn[0].value * d.jerk + 3.0 * s->turn_rate.value * omega * d.alpha +
                        s->turn_rate.slope * spin2 * omega);
    return d;
}

/* The same sums without their signs: their rounding errors are a few eps of these. */
typedef struct {
    double force, torque, pace;   /* N, N.m, rad/s^2 */
    double axial, twist;          /* N, N.m */
    double axial_rate, twist_rate;
} Sizes;

static double force_size(const Way *w, const Shape *s, const Balance *now) {
    const SpringParams *spring = &w->params->spring;
    const double z = fabs(s->z) + COURSE_SHARE * w->course->z_size;
    return fabs(spring->preload) + fabs(now->F_ext) + fabs(now->damper) +
           z * (fabs(spring->stiffness) + z * (fabs(spring->stiffness2) + z * fabs(spring->stiffness3)));
}

static Sizes sizes_of(const Way *w, const Shape *s, const Grip *g, const Balance *now, const Drift *d) {
    const Params *p = w->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower;
    const double omega = fabs(now->omega), spin2 = omega * omega;
    const double lift = fabs(s->lift.value), lift_rate = fabs(s->lift_rate.value);
    const double turn = fabs(s->turn[0].value), turn_rate = fabs(s->turn_rate.value);
    const bool inertial = w->kind == FLOW_INERTIAL;
    Sizes size = {.force = force_size(w, s, now), .torque = fabs(now->tau) + p->shaft.damping * omega};
    const double swirl = (fabs(g->p.value) * m * lift_rate + fabs(g->q.value) * I * turn_rate) * spin2;
    if (inertial)
        size.pace = (fabs(g->delta.value) * size.torque + fabs(g->p.value) * size.force + swirl) / now->pace.resistance;
    const double alpha = inertial ? size.pace : fabs(d->alpha);
    const double jerk = inertial ? fabs(now->pace.by_theta) * omega + fabs(now->pace.by_omega) * size.pace +
                                       fabs(now->pace.by_time)
                                 : 0.0;
    size.axial = size.force + m * (lift * size.pace + lift_rate * spin2);
    size.twist = I * (turn * size.pace + turn_rate * spin2);
    size.axial_rate = fabs(d->spring_rate) + fabs(d->F_rate) + d->damper_rate * (lift * alpha + lift_rate * spin2) +
                      m * (lift * jerk + 3.0 * lift_rate * omega * alpha);
    size.twist_rate = I * (turn * jerk + 3.0 * turn_rate * omega * alpha);
    return size;
}

/* d x_1/dt from x_1 = (rn2 A - d2 W)/Delta, and the sizes of both; likewise x_2 = (rn1 A + d1 W)/Delta. */
static void contact_trend(const Way *w, const Grip *g, const Balance *now, const Drift *d, const Sizes *size, int i,
                          Trend *out) {
    const int other = 1 - i;
    const double omega = now->omega, inverse = 1.0 / fabs(g->delta.value);
    const Dual rn = g->rn[other], arm = dual_scale(i == 0 ? -1.0 : 1.0, g->d[other]);
    const double rn_size = fabs(rn.value) + w->params->cam[other].radius * w->course->slope_size;
    out->contact[i] = (rn.slope * omega * d->axial + rn.value * d->axial_rate + arm.slope * omega * d->twist +
                       arm.value * d->twist_rate - now->x[i] * g->delta.slope * omega) /
                      g->delta.value;
    out->size[i] = (rn_size * size->axial + fabs(arm.value) * size->twist) * inverse;
    out->rate_size[i] = (fabs(rn.slope * omega) * size->axial + fabs(rn.value) * size->axial_rate +
                         fabs(arm.slope * omega) * size->twist + fabs(arm.value) * size->twist_rate +
                         out->size[i] * fabs(g->delta.slope * omega)) *
                        inverse;
}

void balance_trend(const Way *w, const Balance *now, double t, Trend *out) {
    const Shape s = shape_at(w, now->theta);
    const Grip g = grip_of(w, &s);
    const Drift d = drift_of(w, &s, now, t);
    const Sizes size = sizes_of(w, &s, &g, now, &d);
    const double drag = w->kind == FLOW_INERTIAL ? w->params->shaft.damping * now->omega : 0.0;
    *out = (Trend){
        .pace = d.pace,
        .pace_size = size.pace,
        .net = now->tau - drag - g.p.value / g.delta.value * now->force,
        .net_size = size.torque + grip_size(w, &s) / fabs(g.delta.value) * size.force,
    };
    for (int i = 0; i < 2; i++) contact_trend(w, &g, now, &d, &size, i, out);
}

Booking balance_power(const Way *w, const Balance *now) {
    const double omega = now->omega, v = now->lift * omega;
    Booking power = {
        .work_in = now->tau * omega,
        .work_ext = now->F_ext * v,
        .heat_damper = now->damper * v,
        .heat_shaft = w->params->shaft.damping * omega * omega,
    };
    for (int i = 0; i < 2; i++)
        power.heat_cam[i] = w->direction * w->flank[i] * w->params->cam[i].friction * now->x[i] * now->length2[i] *
                            now->turn[i] * omega;
    return power;
}
