/* The factors of the contact equations: the one place that holds the formulas of n_i, d_i and Delta.
 *
 * docs/mechanism.md, section 3, with the signed friction coefficients f_i = sigma e_i mu_i (e_i: flank sign). Per unit
 * of x_i = R_i/hypot(r_i, a_i), R_i the total normal reaction, contact i passes on
 *     the torque r_i n_i with n_i = a_i + f_i r_i    and the axial force d_i = r_i - f_i a_i
 * The axial balance d_1 x_1 + d_2 x_2 = A and the moment balance r_2 n_2 x_2 - r_1 n_1 x_1 = W have the determinant
 *     Delta = Q + r_1 n_1 d_2    Q = d_1 r_2 n_2    and with P = r_1 n_1 r_2 n_2 the solution
 *     x_1 = (r_2 n_2 A - d_2 W)/Delta    x_2 = (r_1 n_1 A + d_1 W)/Delta    T = r_2 n_2 x_2 = (P A + Q W)/Delta
 * so that rho = P/Delta and rho kappa_1 = Q/Delta.
 *
 * The same two functions stand here for each arithmetic: `set` writes r_i n_i and d_i of one contact, then `multiply`
 * writes Q, Delta and P. Numbers and vectors compute r (a + f r); arithmetic with derivatives, and vectors with an f of
 * their own at each angle, compute r a + f r^2, in which a derivative of a needs no further operation. */
#ifndef DUALCAM_CONTACT_FACTORS_H
#define DUALCAM_CONTACT_FACTORS_H

#include "elementary/vector2.h"
#include "numerics/dual.h"
#include "numerics/jet.h"

/* ---- numbers ---- */

typedef struct {
    double rn[2];       /* m^2, r_i n_i */
    double d[2];        /* m */
    double delta, p, q; /* m^3, m^4, m^3: Delta, P, Q */
} ContactFactors;

static inline void contact_factors_set(ContactFactors *f, int i, double r, double signed_friction, double a) {
    f->rn[i] = r * (a + signed_friction * r);
    f->d[i] = r - signed_friction * a;
}

static inline void contact_factors_multiply(ContactFactors *f) {
    f->q = f->d[0] * f->rn[1];
    f->delta = f->q + f->rn[0] * f->d[1];
    f->p = f->rn[0] * f->rn[1];
}

/* The change of the factors, to first order, if the signed friction coefficients change by `df`. r, a: radii and
 * slopes. */
static inline ContactFactors contact_factors_change(const ContactFactors *f, const double r[2], const double a[2],
                                                    const double df[2]) {
    ContactFactors change;
    for (int i = 0; i < 2; i++) {
        change.rn[i] = r[i] * r[i] * df[i];
        change.d[i] = -a[i] * df[i];
    }
    change.q = change.d[0] * f->rn[1] + f->d[0] * change.rn[1];
    change.delta = change.q + (change.rn[0] * f->d[1] + f->rn[0] * change.d[1]);
    change.p = change.rn[0] * f->rn[1] + f->rn[0] * change.rn[1];
    return change;
}

/* ---- vectors of two: the factors at two angles ---- */

typedef struct {
    Vector2 rn[2], d[2], delta, p, q;
} VectorContactFactors;

static inline void vector_contact_factors_set(VectorContactFactors *f, int i, double r, double signed_friction,
                                              Vector2 a) {
    f->rn[i] = r * (a + signed_friction * r);
    f->d[i] = r - signed_friction * a;
}

/* With signed friction coefficients f of both angles; r2: r^2. */
static inline void vector_contact_factors_set_varying(VectorContactFactors *factors, int i, Vector2 r, Vector2 r2,
                                                      Vector2 f, Vector2 a) {
    factors->rn[i] = r * a + f * r2;
    factors->d[i] = r - f * a;
}

static inline void vector_contact_factors_multiply(VectorContactFactors *f) {
    f->q = f->d[0] * f->rn[1];
    f->delta = f->q + f->rn[0] * f->d[1];
    f->p = f->rn[0] * f->rn[1];
}

/* ---- dual numbers: the factors and their derivative by one variable ---- */

typedef struct {
    Dual rn[2], d[2], delta, p, q;
} DualContactFactors;

static inline void dual_contact_factors_set(DualContactFactors *f, int i, double r, double signed_friction, Dual a) {
    f->rn[i] = dual_line(r * (signed_friction * r), r, a);
    f->d[i] = dual_line(r, -signed_friction, a);
}

static inline void dual_contact_factors_multiply(DualContactFactors *f) {
    f->q = dual_multiply(f->d[0], f->rn[1]);
    f->delta = dual_add(f->q, dual_multiply(f->rn[0], f->d[1]));
    f->p = dual_multiply(f->rn[0], f->rn[1]);
}

/* rho = P/Delta */
static inline Dual dual_contact_factors_rho(const DualContactFactors *f) {
    const double inverse = 1.0 / f->delta.value, rho = f->p.value * inverse;
    return (Dual){rho, (f->p.slope - rho * f->delta.slope) * inverse};
}

/* With a signed friction coefficient f that depends on theta. */
static inline void dual_contact_factors_set_varying(DualContactFactors *factors, int i, double r, Dual f, Dual a) {
    factors->rn[i] = (Dual){r * (a.value + f.value * r), r * (a.slope + f.slope * r)};
    factors->d[i] = (Dual){r - f.value * a.value, -f.slope * a.value - f.value * a.slope};
}

static inline ContactFactors dual_contact_factors_values(const DualContactFactors *f) {
    return (ContactFactors){
        .rn = {f->rn[0].value, f->rn[1].value},
        .d = {f->d[0].value, f->d[1].value},
        .delta = f->delta.value,
        .p = f->p.value,
        .q = f->q.value,
    };
}

/* ---- jets: the factors as Taylor polynomials in time ---- */

typedef struct {
    Jet rn[2], d[2], delta, p, q;
} JetContactFactors;

static inline void jet_contact_factors_set(JetContactFactors *factors, int i, double r, const Jet *f, const Jet *a) {
    factors->rn[i] = jet_line((Dual){0.0, 0.0}, (Dual){r, 0.0}, a);
    jet_add_scaled(&factors->rn[i], r * r, f);
    factors->d[i] = (Jet){.c = {{r, 0.0}}};
    jet_add_product(&factors->d[i], -1.0, f, a);
}

static inline void jet_contact_factors_multiply(JetContactFactors *f) {
    f->q = jet_multiply(&f->d[0], &f->rn[1]);
    f->delta = f->q;
    jet_add_product(&f->delta, 1.0, &f->rn[0], &f->d[1]);
    f->p = jet_multiply(&f->rn[0], &f->rn[1]);
}

#endif
