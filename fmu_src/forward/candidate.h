/* Candidates: the motion along one slip mode from the present state on, in closed form or by the balance of forces.
 * decide.c chooses one of them. */
#ifndef DUALCAM_CANDIDATE_H
#define DUALCAM_CANDIDATE_H

#include "contact/balance.h"
#include "forward/state.h"

typedef struct {
    bool possible; /* D/Delta > 0, and all values are finite */
    Regime regime;
    double motion;        /* the rate that the balance gives: alpha, rad/s^2; without inertia omega, rad/s */
    double net;           /* rate-independent only: N.m, torque beyond the edge of the band */
    double rounding;      /* of `motion`, or of `net` if rate-independent */
    double stiffness;     /* rate-independent only: N.m/rad, how the edge rises with theta */
    double axial[2];      /* 1/m: x_i per axial load A */
    double x[2], size[2]; /* N/m: x_i, and the size of its terms; only with friction */
} Candidate;

/* `index`: see slip_index(). */
Candidate candidate_of(const Mechanism *m, int index);

/* Is the motion known in closed form under the present inputs? */
bool is_closed_form(const Mechanism *m);

/* The coefficients of the closed form of one slip mode: the model's, or, if the model has none, built in *storage. */
const LinearSlipMode *linear_slip_of(const Mechanism *m, int index, LinearSlipMode *storage);

/* Builds them and keeps them in the model. */
void keep_linear_slip(Mechanism *m, int index);

/* The same, built at their first use and kept in the model. */
static inline const LinearSlipMode *kept_linear_slip(Mechanism *m, int index) {
    if ((m->model.linear_slips >> index & 1u) == 0) keep_linear_slip(m, index);
    return &m->model.linear_slip[index];
}

/* The start of closed-form slip from the present state. */
SlipStart slip_start_of(const Mechanism *m, const LinearSlipMode *linear);

/* One slip mode from the present angle on, for grooves of any shape. */
SlipMode slip_mode_from_here(const Mechanism *m, int index);

/* The balance of forces now, in that slip mode. Where slip begins, speed and acceleration keep to its direction:
 * rounding at the edge of the stick band does not start the motion backwards. */
Balance balance_from_here(const Mechanism *m, const SlipMode *slip);

#endif
