/* A slip mode in grooves of any shape: one direction of slip sigma, one pair of flanks e_i, one segment of the
 * transmission; and the coefficients of its equation of motion.
 *
 * The equation of motion (docs/mechanism.md, section 6) times Delta, with the factors of contact_factors.h, reads
 *     [J Delta + P m z' + Q I gamma'] alpha
 *         = Delta (tau - b omega) - P (F_s + F_ext + D) - [P m z'' + Q I gamma''] omega^2
 * so that only the last step divides. */
#ifndef DUALCAM_SLIP_MODE_H
#define DUALCAM_SLIP_MODE_H

#include <math.h>
#include <stdbool.h>

#include "contact/contact_factors.h"
#include "geometry/transmission.h"
#include "model/friction_law.h"
#include "model/inputs.h"
#include "model/mode.h"
#include "model/params.h"
#include "model/work.h"

/* Grooves and friction at one theta and speed, with derivatives by theta at constant speed. */
typedef struct {
    Dual dz_dtheta;                    /* z' */
    Dual slope[2], dpsi_dtheta[2];     /* a_i; gamma', phi' */
    Dual d2z_dtheta2, d2gamma_dtheta2; /* z'', gamma''; their slopes only where the follower has mass or inertia */
    DualContactFactors factors;
    /* Only where friction varies: */
    double friction[2];             /* f_i */
    double dfriction_domega[2];     /* s/rad, through the sliding speed and the damper's part of F */
    double dfriction_dload[2];      /* 1/N, by F */
    ContactFactors dfactors_domega; /* derivatives of the factors by the speed */
    ContactFactors dfactors_dload;  /* and by F */
} SlipCoefficients;

typedef struct {
    const Params *params;
    const Transmission *transmission;
    const TransmissionPiece *piece;
    const Inputs *inputs; /* polynomials of the time since they were written */
    Work *work;           /* counts evaluations, or NULL */
    Regime regime;
    int direction;                 /* sigma */
    int flank[2];                  /* e_i */
    double signed_friction[2];     /* f_i = sigma e_i mu_i under Coulomb's law */
    bool friction_varies;          /* mu_i depends on the sliding speed or on the load: see slip_set_friction() */
    const FrictionConstants *law;  /* of both contacts; NULL where no step is made */
    double c, q;                   /* N.s/m, N.s^2/m^2: of the damper in this direction */
    bool follower_has_inertia;     /* the follower has mass or inertia */
    bool inputs_are_constant;      /* the inputs are constant */
    SlipCoefficients coefficients; /* set where both grooves are straight: the same at every theta */
    bool to_rounding; /* collocation steps are solved to rounding, not to a share of the tolerance: the last step
                         before an event */
} SlipMode;

/* The regime of slip in that direction. */
Regime slip_regime(const Params *p, int direction);

/* `law`: of both contacts, not used where friction does not vary; NULL where no step is to be made. */
SlipMode slip_mode_of(const Params *params, const Transmission *transmission, const FrictionConstants *law,
                      const Inputs *inputs, double theta, int direction, const int flank[2]);

/* The coefficients at theta in a groove that is not straight, without friction if friction varies; returns z, m. */
double slip_coefficients_curved(const SlipMode *slip, double theta, SlipCoefficients *out);

/* Where friction varies: sets the friction of the coefficients, and with it their factors, to that at the speed omega,
 * rad/s, the height z, m, and the external force F_ext, N. Along the edge of the stick band (rate-independent) friction
 * is that at rest. */
void slip_set_friction(const SlipMode *slip, double omega, double z, double F_ext, SlipCoefficients *coefficients);

/* The coefficients at theta and, where friction varies, at the speed omega under F_ext; in *storage unless the slip
 * mode holds them; *z is set. */
static inline const SlipCoefficients *slip_coefficients_at(const SlipMode *slip, double theta, double omega,
                                                           double F_ext, SlipCoefficients *storage, double *z) {
    const TransmissionPiece *piece = slip->piece;
    if (slip->transmission->straight) {
        *z = piece->z[0] + (theta - piece->middle) * piece->scale * piece->z[1];
        if (!slip->friction_varies) return &slip->coefficients;
        *storage = slip->coefficients;
    } else {
        *z = slip_coefficients_curved(slip, theta, storage);
    }
    if (slip->friction_varies) slip_set_friction(slip, omega, *z, F_ext, storage);
    return storage;
}

/* The change of the factors, to first order, if f_i change by `df`. */
static inline ContactFactors slip_factors_by(const SlipMode *slip, const SlipCoefficients *k, const double df[2]) {
    const CamParams *cam = slip->params->cam;
    const double radius[2] = {cam[0].radius, cam[1].radius}, slope[2] = {k->slope[0].value, k->slope[1].value};
    const ContactFactors values = dual_contact_factors_values(&k->factors);
    return contact_factors_change(&values, radius, slope, df);
}

/* 1/m: the nominal load N_i (model/friction_law.h) per axial force and per sliding distance psi_i' hypot(r_i, a_i). */
static inline double slip_load_per_sliding(const SlipMode *slip, int i) {
    return 1.0 / (slip->params->contacts * slip->params->cam[i].radius);
}

/* Counts evaluations of the balance. */
static inline void slip_count(const SlipMode *slip, int evaluations) {
    work_add(slip->work, evaluations);
}

/* f_i */
static inline double slip_friction(const SlipMode *slip, const SlipCoefficients *k, int i) {
    return slip->friction_varies ? k->friction[i] : slip->signed_friction[i];
}

/* The inputs and their rates at one instant. */
typedef struct {
    double tau, F_ext, tau_rate, F_ext_rate; /* N.m, N, N.m/s, N/s */
} InputValues;

InputValues input_values_at(const Inputs *inputs, double t);

static inline InputValues slip_inputs_at(const SlipMode *slip, double t) {
    const Inputs *in = slip->inputs;
    if (slip->inputs_are_constant) return (InputValues){.tau = in->tau[0], .F_ext = in->F_ext[0]};
    return input_values_at(in, t);
}

/* N: D(v) = v (c + q |v|) */
static inline double slip_damper_force(const SlipMode *slip, double v) {
    return v * (slip->c + slip->q * fabs(v));
}

/* N.s/m: dD/dv */
static inline double slip_damper_rate(const SlipMode *slip, double v) {
    return slip->c + 2.0 * slip->q * fabs(v);
}

/* J Delta + P m z' + Q I gamma', the factor of alpha. */
static inline Dual slip_inertia(const SlipMode *slip, const SlipCoefficients *k) {
    const InertiaParams *i = &slip->params->inertia;
    const DualContactFactors *f = &k->factors;
    const Dual shaft = dual_scale(i->shaft, f->delta);
    if (!slip->follower_has_inertia) return shaft;
    return dual_add(shaft, dual_add(dual_multiply(dual_scale(i->follower_mass, f->p), k->dz_dtheta),
                                    dual_multiply(dual_scale(i->follower, f->q), k->dpsi_dtheta[0])));
}

/* P m z'' + Q I gamma'', the factor of omega^2. */
static inline Dual slip_inertia_by_speed(const SlipMode *slip, const SlipCoefficients *k) {
    const InertiaParams *i = &slip->params->inertia;
    const DualContactFactors *f = &k->factors;
    return dual_add(dual_multiply(dual_scale(i->follower_mass, f->p), k->d2z_dtheta2),
                    dual_multiply(dual_scale(i->follower, f->q), k->d2gamma_dtheta2));
}

#endif
