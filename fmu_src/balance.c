#include "balance.h"

#include <math.h>

#include "rare.h"

double input_value(const double u[INPUT_ORDER + 1], double t) {
    return u[0] + t * (u[1] + t / 2.0 * (u[2] + t / 3.0 * u[3]));
}

double input_rate(const double u[INPUT_ORDER + 1], double t) {
    return u[1] + t * (u[2] + t / 2.0 * u[3]);
}

void inputs_advance(Inputs *inputs, double t) {
    input_shift(inputs->tau, t);
    input_shift(inputs->F_ext, t);
}

/* The inputs at one instant. */
typedef struct {
    double tau, F_ext, tau_rate, F_rate; /* N.m, N, N.m/s, N/s */
} Drive;

static inline Drive drive_at(const Way *w, double t) {
    const Inputs *in = w->inputs;
    if (w->steady) return (Drive){.tau = in->tau[0], .F_ext = in->F_ext[0]};
    return (Drive){input_value(in->tau, t), input_value(in->F_ext, t), input_rate(in->tau, t), input_rate(in->F_ext, t)};
}

/* ---- geometry and friction, with derivatives by theta ---- */

/* gamma' = a2/(a1+a2), z' = a1 gamma'; differentiated:
 *     gamma'' = (a2' phi' - a1' gamma')/(a1+a2)          z'' = a1' gamma'^2 + a2' phi'^2
 *     gamma''' = (a2'' phi' - a1'' gamma' - 2 gamma'' (a1'+a2'))/(a1+a2)
 *     z''' = a1'' gamma'^2 + a2'' phi'^2 + 2 gamma'' (a1' gamma' - a2' phi') */
static inline void form_of(const Way *w, Spot s, Form *form) {
    for (int i = 0; i < 2; i++) s.slope[i] = fmax(s.slope[i], 0.0); /* level, but for the polynomial's rounding */
    const double inverse = 1.0 / (s.slope[0] + s.slope[1]);
    const double g = s.slope[1] * inverse, f = s.slope[0] * inverse;
    const double gg = (s.bend[1] * f - s.bend[0] * g) * inverse;
    const double zz = s.bend[0] * g * g + s.bend[1] * f * f;
    form->lift = (Dual){s.slope[0] * g, zz};
    form->turn[0] = (Dual){g, gg};
    form->turn[1] = (Dual){f, -gg};
    form->lift_rate = (Dual){zz, 0.0};
    form->turn_rate = (Dual){gg, 0.0};
    if (w->heavy) {
        const double bend = s.bend[0] + s.bend[1];
        form->turn_rate.slope = (s.twist[1] * f - s.twist[0] * g - 2.0 * gg * bend) * inverse;
        form->lift_rate.slope =
            s.twist[0] * g * g + s.twist[1] * f * f + 2.0 * gg * (s.bend[0] * g - s.bend[1] * f);
    }
    for (int i = 0; i < 2; i++) {
        const double r = w->params->cam[i].radius;
        form->slope[i] = (Dual){s.slope[i], s.bend[i]};
        form->rn[i] = dual_line(r * (w->mu[i] * r), r, form->slope[i]);
        form->d[i] = dual_line(r, -w->mu[i], form->slope[i]);
    }
    form->q = dual_multiply(form->d[0], form->rn[1]);
    form->delta = dual_add(form->q, dual_multiply(form->rn[0], form->d[1]));
    form->p = dual_multiply(form->rn[0], form->rn[1]);
}

static Spot straight_spot(const Piece *piece) {
    return (Spot){.slope = {piece->slope[0][0], piece->slope[0][1]}};
}

/* The form at theta, in *here unless the way has it, and z. */
static const Form *form_at(const Way *w, double theta, Form *here, double *z) {
    const Piece *piece = w->piece;
    if (w->course->straight) {
        *z = piece->z[0] + (theta - piece->middle) * piece->scale * piece->z[1];
        return &w->form;
    }
    const Spot spot = w->heavy ? piece_spot(piece, theta, SPOT_TWISTS) : piece_spot(piece, theta, SPOT_BENDS);
    *z = spot.z;
    form_of(w, spot, here);
    return here;
}

/* ---- the way ---- */

static FlowKind kind_of_way(const Way *w) {
    if (has_inertia(w->params)) return FLOW_INERTIAL;
    return w->c + w->q + w->params->shaft.damping > 0.0 ? FLOW_VISCOUS : FLOW_QUASISTATIC;
}

Way way_of(const Params *p, const Course *course, const Inputs *inputs, double theta, int direction,
           const int flank[2]) {
    const DamperParams *d = &p->damper;
    Way way; /* its form is set where it is used */
    way.params = p;
    way.course = course;
    way.piece = course_piece(course, theta, direction);
    way.inputs = inputs;
    way.direction = direction;
    for (int i = 0; i < 2; i++) {
        way.flank[i] = flank[i];
        way.mu[i] = direction * flank[i] * p->cam[i].friction;
    }
    way.c = direction > 0 ? d->c_load : d->c_release;
    way.q = direction > 0 ? d->q_load : d->q_release;
    way.heavy = p->inertia.follower_mass + p->inertia.follower > 0.0;
    way.steady = inputs_constant(inputs);
    way.to_rounding = false;
    way.kind = kind_of_way(&way);
    if (course->straight) form_of(&way, straight_spot(way.piece), &way.form);
    return way;
}

/* ---- the equation of motion ---- */

/* J Delta + P m z' + Q I gamma' */
static inline Dual mass_of(const Way *w, const Form *f) {
    const InertiaParams *i = &w->params->inertia;
    const Dual shaft = dual_scale(i->shaft, f->delta);
    if (!w->heavy) return shaft;
    return dual_add(shaft, dual_add(dual_multiply(dual_scale(i->follower_mass, f->p), f->lift),
                                    dual_multiply(dual_scale(i->follower, f->q), f->turn[0])));
}

/* P m z'' + Q I gamma'' */
static inline Dual swirl_of(const Way *w, const Form *f) {
    const InertiaParams *i = &w->params->inertia;
    return dual_add(dual_multiply(dual_scale(i->follower_mass, f->p), f->lift_rate),
                    dual_multiply(dual_scale(i->follower, f->q), f->turn_rate));
}

static inline Pace pace_of_inertial(const Way *w, const Form *f, double z, const Drive *in, double omega) {
    const Params *p = w->params;
    const double v = f->lift.value * omega;
    const double damper = v * (w->c + w->q * fabs(v));
    const double damper_rate = w->c + 2.0 * w->q * fabs(v);
    const double spring = spring_force(&p->spring, z), F_ext = in->F_ext;
    const Dual load = {spring + F_ext + damper,
                       spring_rate(&p->spring, z) * f->lift.value + damper_rate * f->lift.slope * omega};
    const double drag = p->shaft.damping * omega, torque = in->tau, tau = torque - drag;
    const Dual mass = mass_of(w, f);
    Dual net = {f->delta.value * tau - f->p.value * load.value,
                f->delta.slope * tau - f->p.slope * load.value - f->p.value * load.slope};
    double net_by_omega = -f->delta.value * p->shaft.damping - f->p.value * damper_rate * f->lift.value;
    if (w->heavy) {
        const Dual swirl = swirl_of(w, f);
        net.value -= swirl.value * omega * omega;
        net.slope -= swirl.slope * omega * omega;
        net_by_omega -= 2.0 * swirl.value * omega;
    }
    const double inverse = 1.0 / mass.value;
    const double alpha = net.value * inverse;
    const double force_size = fabs(spring) + fabs(F_ext) + fabs(damper);
    return (Pace){
        .value = alpha,
        .size = (fabs(f->delta.value) * (fabs(torque) + fabs(drag)) + fabs(f->p.value) * force_size) * fabs(inverse),
        .by_theta = (net.slope - alpha * mass.slope) * inverse,
        .by_omega = net_by_omega * inverse,
        .by_time = (f->delta.value * in->tau_rate - f->p.value * in->F_rate) * inverse,
        .resistance = fabs(mass.value),
        .possible = mass.value * f->delta.value > 0.0,
        .stable = true,
    };
}

/* B omega + C omega |omega| = N with B = Delta b + P c z', C = P q z'^2, N = Delta tau - P F_0. Of two roots, which a
 * locked contact (P < 0) can cause, the one nearer to zero: there more torque means more speed. It is written without
 * cancellation. Backward, where a step may look, it is continued as an odd function. */
static inline Pace pace_of_viscous(const Way *w, const Form *f, double z, const Drive *in) {
    const Params *p = w->params;
    const double tau = in->tau;
    const double spring = spring_force(&p->spring, z), F_ext = in->F_ext;
    const Dual load = {spring + F_ext, spring_rate(&p->spring, z) * f->lift.value};
    const Dual n = {f->delta.value * tau - f->p.value * load.value,
                    f->delta.slope * tau - f->p.slope * load.value - f->p.value * load.slope};
    const Dual pz = dual_multiply(f->p, f->lift);
    const Dual b = dual_add(dual_scale(p->shaft.damping, f->delta), dual_scale(w->c, pz));
    const Dual c = dual_scale(w->q, dual_multiply(pz, f->lift));
    const double sign = b.value < 0.0 || (b.value == 0.0 && c.value < 0.0) ? -1.0 : 1.0;
    const bool alike = b.value * c.value >= 0.0;
    const double four_cn = alike ? fabs(c.value * n.value) : c.value * w->direction * n.value;
    const double square = b.value * b.value + 4.0 * four_cn;
    const double sum = b.value + sign * sqrt(fmax(square, 0.0));
    const double omega = sum != 0.0 ? 2.0 * n.value / sum : 0.0;
    const double steepness = b.value + 2.0 * c.value * fabs(omega); /* dN/d omega */
    const double inverse = steepness != 0.0 ? 1.0 / steepness : 0.0;
    const double n_size =
        fabs(f->delta.value * tau) + fabs(f->p.value) * (fabs(spring) + fabs(F_ext));
    return (Pace){
        .value = omega,
        .size = sum != 0.0 ? 2.0 * n_size / fabs(sum) : 0.0,
        .by_theta = (n.slope - omega * (b.slope + c.slope * fabs(omega))) * inverse,
        .by_time = (f->delta.value * in->tau_rate - f->p.value * in->F_rate) * inverse,
        .possible = (sum != 0.0 || c.value != 0.0) && square >= 0.0 && f->delta.value != 0.0,
        .stable = sign * f->delta.value > 0.0,
    };
}

/* On the band's edge E(theta) = rho F_0 the torque fixes theta, so (tau - rho F_ext)' = dE/dtheta omega. Value: that
 * omega; by_theta holds dE/dtheta itself, N.m/rad, which a step along the edge
 * solves with. */
static inline Pace pace_of_quasistatic(const Way *w, const Form *f, double z, const Drive *in) {
    const Params *p = w->params;
    const Dual load = {spring_force(&p->spring, z) + in->F_ext,
                       spring_rate(&p->spring, z) * f->lift.value};
    const double inverse = 1.0 / f->delta.value;
    const double rho = f->p.value * inverse;
    const double rho_rate = (f->p.slope - rho * f->delta.slope) * inverse;
    const double stiffness = rho_rate * load.value + rho * load.slope;
    const double rate = in->tau_rate - rho * in->F_rate;
    return (Pace){
        .value = stiffness > 0.0 ? rate / stiffness : 0.0,
        .by_theta = stiffness,
        .net = in->tau - rho * load.value,
        .resistance = stiffness,
        .possible = f->delta.value != 0.0,
        .stable = stiffness > 0.0,
    };
}

APART static Pace pace_of(const Way *w, const Form *f, double z, const Drive *in, double omega) {
    switch (w->kind) {
        case FLOW_INERTIAL: return pace_of_inertial(w, f, z, in, omega);
        case FLOW_VISCOUS: return pace_of_viscous(w, f, z, in);
        default: return pace_of_quasistatic(w, f, z, in);
    }
}

Pace balance_pace(const Way *w, double theta, double omega, double t) {
    Form here;
    double z;
    const Form *f = form_at(w, theta, &here, &z);
    const Drive in = drive_at(w, t);
    return pace_of(w, f, z, &in, omega);
}

void balance_at(const Way *w, double theta, double omega, double t, Balance *out) {
    const Params *p = w->params;
    Form here;
    double z;
    const Form *f = form_at(w, theta, &here, &z);
    const Drive in = drive_at(w, t);
    const Pace pace = pace_of(w, f, z, &in, omega);
    const bool inertial = w->kind == FLOW_INERTIAL;
    const double alpha = inertial ? pace.value : 0.0;
    if (!inertial) omega = pace.value;
    const double v = f->lift.value * omega, damper = v * (w->c + w->q * fabs(v));
    const double force = spring_force(&p->spring, z) + in.F_ext;
    double axial = force + damper, twist = 0.0;
    if (w->heavy) {
        axial += p->inertia.follower_mass * (f->lift.value * alpha + f->lift_rate.value * omega * omega);
        twist = p->inertia.follower * (f->turn[0].value * alpha + f->turn_rate.value * omega * omega);
    }
    const double inverse = 1.0 / f->delta.value;
    *out = (Balance){
        .theta = theta,
        .omega = omega,
        .alpha = alpha,
        .pace = pace,
        .tau = in.tau,
        .F_ext = in.F_ext,
        .force = force,
        .damper = damper,
        .z = z,
        .lift = f->lift.value,
        .turn = {f->turn[0].value, f->turn[1].value},
        .axial = {f->rn[1].value * inverse, f->rn[0].value * inverse},
        .x = {(f->rn[1].value * axial - f->d[1].value * twist) * inverse,
              (f->rn[0].value * axial + f->d[0].value * twist) * inverse},
    };
    for (int i = 0; i < 2; i++)
        out->length2[i] = p->cam[i].radius * p->cam[i].radius + f->slope[i].value * f->slope[i].value;
}

/* ---- how it changes ---- */

/* The share of the course's size that counts as a term of z and of the slopes: their rounding is some eps of that size,
 * where other sums count as zero below 1e-13 of their terms. */
static const double COURSE_SHARE = 0.01;

/* Size of the terms of P, which vanishes on a dwell or where a contact begins to lock. */
static double grip_size(const Way *w, const Form *f) {
    double size = 1.0;
    for (int i = 0; i < 2; i++) {
        const CamParams *cam = &w->params->cam[i];
        size *= cam->radius * (f->slope[i].value + cam->friction * cam->radius + COURSE_SHARE * w->course->slope_size);
    }
    return size;
}

/* Rates of change along the motion, and what they are made of. */
typedef struct {
    double pace;                    /* d pace/dt */
    double alpha, jerk;             /* rad/s^2, rad/s^3: as far as they act on the loads */
    double axial, twist;            /* N, N.m: A and W of the balance */
    double axial_rate, twist_rate;  /* N/s, N.m/s */
    double spring_rate, damper_rate, F_rate; /* N/s, N.s/m, N/s */
} Drift;

static Drift drift_of(const Way *w, const Form *f, const Drive *in, const Balance *now) {
    const Params *p = w->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower;
    const bool inertial = w->kind == FLOW_INERTIAL;
    const double omega = now->omega, spin2 = omega * omega, v = f->lift.value * omega;
    Drift d = {
        .pace = now->pace.by_time + (w->kind == FLOW_QUASISTATIC ? 0.0 : now->pace.by_theta * omega) +
                now->pace.by_omega * now->alpha,
        .spring_rate = spring_rate(&p->spring, now->z) * v,
        .damper_rate = w->c + 2.0 * w->q * fabs(v),
        .F_rate = in->F_rate,
    };
    d.alpha = inertial ? now->alpha : d.pace;
    d.jerk = inertial ? d.pace : 0.0;
    const double follow = f->lift.value * d.alpha + f->lift_rate.value * spin2; /* d^2 z/dt^2 */
    d.axial = now->force + now->damper + m * (inertial ? follow : 0.0);
    d.twist = I * (f->turn[0].value * now->alpha + f->turn_rate.value * spin2);
    d.axial_rate = d.spring_rate + d.F_rate + d.damper_rate * follow +
                   m * (f->lift.value * d.jerk + 3.0 * f->lift_rate.value * omega * d.alpha +
                        f->lift_rate.slope * spin2 * omega);
    d.twist_rate = I * (f->turn[0].value * d.jerk + 3.0 * f->turn_rate.value * omega * d.alpha +
                        f->turn_rate.slope * spin2 * omega);
    return d;
}

/* The same sums without their signs: their rounding errors are a few eps of these. */
typedef struct {
    double force, torque, pace;   /* N, N.m, rad/s^2 */
    double axial, twist;          /* N, N.m */
    double axial_rate, twist_rate;
} Sizes;

static double force_size(const Way *w, const Balance *now) {
    const SpringParams *spring = &w->params->spring;
    const double z = fabs(now->z) + COURSE_SHARE * w->course->z_size;
    return fabs(spring->preload) + fabs(now->F_ext) + fabs(now->damper) +
           z * (fabs(spring->stiffness) + z * (fabs(spring->stiffness2) + z * fabs(spring->stiffness3)));
}

static Sizes sizes_of(const Way *w, const Form *f, const Balance *now, const Drift *d) {
    const Params *p = w->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower;
    const double omega = fabs(now->omega), spin2 = omega * omega;
    const double lift = fabs(f->lift.value), lift_rate = fabs(f->lift_rate.value);
    const double turn = fabs(f->turn[0].value), turn_rate = fabs(f->turn_rate.value);
    const bool inertial = w->kind == FLOW_INERTIAL;
    Sizes size = {.force = force_size(w, now), .torque = fabs(now->tau) + p->shaft.damping * omega};
    const double swirl = (fabs(f->p.value) * m * lift_rate + fabs(f->q.value) * I * turn_rate) * spin2;
    if (inertial)
        size.pace = (fabs(f->delta.value) * size.torque + fabs(f->p.value) * size.force + swirl) / now->pace.resistance;
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
static void contact_trend(const Way *w, const Form *f, const Balance *now, const Drift *d, const Sizes *size, int i,
                          Trend *out) {
    const int other = 1 - i;
    const double omega = now->omega, inverse = 1.0 / fabs(f->delta.value);
    const Dual rn = f->rn[other], arm = dual_scale(i == 0 ? -1.0 : 1.0, f->d[other]);
    const double rn_size = fabs(rn.value) + w->params->cam[other].radius * w->course->slope_size;
    out->contact[i] = (rn.slope * omega * d->axial + rn.value * d->axial_rate + arm.slope * omega * d->twist +
                       arm.value * d->twist_rate - now->x[i] * f->delta.slope * omega) /
                      f->delta.value;
    out->size[i] = (rn_size * size->axial + fabs(arm.value) * size->twist) * inverse;
    out->rate_size[i] = (fabs(rn.slope * omega) * size->axial + fabs(rn.value) * size->axial_rate +
                         fabs(arm.slope * omega) * size->twist + fabs(arm.value) * size->twist_rate +
                         out->size[i] * fabs(f->delta.slope * omega)) *
                        inverse;
}

void balance_trend(const Way *w, const Balance *now, double t, Trend *out) {
    Form here;
    double z;
    const Form *f = form_at(w, now->theta, &here, &z);
    const Drive in = drive_at(w, t);
    const Drift d = drift_of(w, f, &in, now);
    const Sizes size = sizes_of(w, f, now, &d);
    const double drag = w->kind == FLOW_INERTIAL ? w->params->shaft.damping * now->omega : 0.0;
    *out = (Trend){
        .pace = d.pace,
        .pace_size = size.pace,
        .net = now->tau - drag - f->p.value / f->delta.value * now->force,
        .net_size = size.torque + grip_size(w, f) / fabs(f->delta.value) * size.force,
    };
    for (int i = 0; i < 2; i++) contact_trend(w, f, now, &d, &size, i, out);
}

/* ---- what it depends on ---- */

/* The factors of the equation of motion, as far as they depend on friction at contact i: derivatives by mu_i. */
static Form form_by_friction(const Way *w, const Form *f, int i) {
    const double r = w->params->cam[i].radius, sign = w->direction * w->flank[i];
    const double rn = r * r * sign, d = -f->slope[i].value * sign;
    const double q = i == 0 ? d * f->rn[1].value : f->d[0].value * rn;
    return (Form){
        .q = {.value = q},
        .delta = {.value = q + (i == 0 ? rn * f->d[1].value : f->rn[0].value * d)},
        .p = {.value = i == 0 ? rn * f->rn[1].value : f->rn[0].value * rn},
    };
}

/* Delta (tau - b omega) - P (F_0 + D) - [P m z'' + Q I gamma''] omega^2 - [J Delta + P m z' + Q I gamma'] alpha */
void balance_partials(const Way *w, const Balance *now, Partials *out) {
    const Params *p = w->params;
    const double J = p->inertia.shaft, m = p->inertia.follower_mass, I = p->inertia.follower, b = p->shaft.damping;
    const double omega = now->omega, spin2 = omega * omega, alpha = now->alpha, torque = now->tau - b * omega;
    Form here;
    double z;
    const Form *f = form_at(w, now->theta, &here, &z);
    const double v = f->lift.value * omega, load = now->force + now->damper;
    const double resistance = w->c + 2.0 * w->q * fabs(v); /* dD/dv */
    const double load_slope = spring_rate(&p->spring, z) * f->lift.value + resistance * f->lift.slope * omega;
    const Dual swirl = swirl_of(w, f), mass = mass_of(w, f);
    double *by = out->by;
    *out = (Partials){.by = {0.0}};
    by[KNOB_THETA] = f->delta.slope * torque - f->p.slope * load - f->p.value * load_slope - swirl.slope * spin2 -
                     mass.slope * alpha;
    by[KNOB_OMEGA] = -f->delta.value * b - f->p.value * resistance * f->lift.value - 2.0 * swirl.value * omega;
    by[KNOB_ALPHA] = -mass.value;
    by[KNOB_TAU] = f->delta.value;
    by[KNOB_F_EXT] = by[KNOB_PRELOAD] = -f->p.value;
    by[KNOB_STIFFNESS] = -f->p.value * z;
    by[KNOB_STIFFNESS2] = -f->p.value * z * z;
    by[KNOB_STIFFNESS3] = -f->p.value * z * z * z;
    by[w->direction > 0 ? KNOB_C_LOAD : KNOB_C_RELEASE] = -f->p.value * v;
    by[w->direction > 0 ? KNOB_Q_LOAD : KNOB_Q_RELEASE] = -f->p.value * v * fabs(v);
    for (int i = 0; i < 2; i++) {
        const Form d = form_by_friction(w, f, i);
        const double mass_rate = J * d.delta.value + m * d.p.value * f->lift.value + I * d.q.value * f->turn[0].value;
        const double swirl_rate = m * d.p.value * f->lift_rate.value + I * d.q.value * f->turn_rate.value;
        by[KNOB_FRICTION_1 + i] =
            d.delta.value * torque - d.p.value * load - swirl_rate * spin2 - mass_rate * alpha;
    }
}

double balance_mobility(const Way *w, const Balance *now) {
    Partials p;
    balance_partials(w, now, &p);
    return -p.by[KNOB_TAU] / p.by[w->kind == FLOW_INERTIAL ? KNOB_ALPHA : KNOB_OMEGA];
}

/* How k alpha + k' omega^2 changes, with k = z' or gamma'. */
static double swing_change(const Balance *b, Dual k, Dual k_rate, double dtheta, double domega, double dalpha) {
    const double spin2 = b->omega * b->omega;
    return (k.slope * b->alpha + k_rate.slope * spin2) * dtheta + 2.0 * k_rate.value * b->omega * domega +
           k.value * dalpha;
}

/* x_i = (rn A -+ d W)/Delta, see contact_trend(). */
RARE double balance_contact_change(const Way *w, const Balance *now, int i, double dtheta, double domega,
                                   double dalpha) {
    const Params *p = w->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower, omega = now->omega, alpha = now->alpha;
    Form here;
    double z;
    const Form *f = form_at(w, now->theta, &here, &z);
    const Dual rn = f->rn[1 - i], arm = dual_scale(i == 0 ? -1.0 : 1.0, f->d[1 - i]);
    const double follow = f->lift.value * alpha + f->lift_rate.value * omega * omega;
    const double axial = now->force + now->damper + m * follow;
    const double twist = I * (f->turn[0].value * alpha + f->turn_rate.value * omega * omega);
    const double resistance = w->c + 2.0 * w->q * fabs(f->lift.value * omega); /* dD/dv */
    const double axial_change = spring_rate(&p->spring, z) * f->lift.value * dtheta +
                                resistance * (f->lift.slope * omega * dtheta + f->lift.value * domega) +
                                m * swing_change(now, f->lift, f->lift_rate, dtheta, domega, dalpha);
    const double twist_change = I * swing_change(now, f->turn[0], f->turn_rate, dtheta, domega, dalpha);
    return (rn.value * axial_change + arm.value * twist_change +
            (rn.slope * axial + arm.slope * twist - now->x[i] * f->delta.slope) * dtheta) /
           f->delta.value;
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
