/* Candidates: what each slip mode would do from the present state on. decide.c chooses one of them. */
#ifndef DUALCAM_CANDIDATE_H
#define DUALCAM_CANDIDATE_H

#include "closed_form/linear_event.h"
#include "contact/balance.h"
#include "forward/state.h"

typedef struct {
    bool possible;
    /* Without inertia: more torque means more speed. With inertia: between slightly elastic flanks the reactions settle. */
    bool stable;
    bool single;  /* with inertia: see RightHandSide; without: true */
    bool recedes; /* with inertia: more torque gives less acceleration */
    Regime regime;
    double net, net_size;   /* N.m: torque beyond the torque that holds the load, and the size of its terms */
    double tie;             /* share of net_size below which net counts as zero */
    double omega, alpha;    /* rad/s, rad/s^2 */
    double jerk;            /* rad/s^3 */
    double stiffness;       /* N.m/rad: how the torque that holds the load grows with theta */
    double axial[2];        /* N/m^2, x_i per z: through the spring */
    ContactLoad contact[2]; /* x_i and its time derivatives, only with friction */
    ContactLoad size[2];    /* sizes of the terms in them */
    double rounding[2];     /* N/m, of x_i, as a size: at most that in size[i] */
    bool unseen[2];         /* x_i is rounding, now and a little later */
    double ahead[2]; /* has the sign of x_i just after now, if Mechanism.load_ahead or .crossed tells it; else 0 */
} Candidate;

/* The candidate of one slip mode; index: see slip_index(). */
Candidate candidate_of(const Mechanism *m, int index);

/* The candidate of one slip mode. If the model lacks the coefficients of the closed form, *built receives them; else
 * *built stays unchanged. */
Candidate candidate_building(const Mechanism *m, int index, LinearSlipMode *built);

/* With inertia and friction that varies with the speed alone: is alpha = N/D, or are both x_i = (r n A -+ d W)/Delta, the
 * quotient of two zeros where no step goes on along this slip mode? Where D = 0, N vanishes to rounding: contacts that hold
 * the speed at the limit of a jam come there as the load vanishes that holds them (collocation/step_indicator.h). With a
 * follower's mass D can stay above zero where Delta = 0. Alpha is finite there, and the reactions vanish to rounding. */
bool is_quotient_of_zeros(const Mechanism *m, int index);

/* Do the reactions of a motion go on along this slip mode, which searches, although Newton's method loses them? A search then
 * finds nearly the same reactions a little later. Where two answers of the balance meet, the search finds none or others. */
bool search_goes_on(const Mechanism *m, int index);

/* Is the motion known in closed form under the present inputs? */
bool is_closed_form(const Mechanism *m);

/* The coefficients of the closed form of one slip mode: the model's, or, if the model has none, built in *storage. */
const LinearSlipMode *linear_slip_of(const Mechanism *m, int index, LinearSlipMode *storage);

/* The start of closed-form slip from the present state. */
SlipStart slip_start_of(const Mechanism *m, const LinearSlipMode *linear);

/* One slip mode from the present angle on, for grooves of any shape. */
SlipMode slip_mode_from_here(const Mechanism *m, int index);

/* The balance of forces now, in that slip mode. Where slip begins, speed and acceleration keep to its direction:
 * rounding at the edge of the stick band does not start the motion backwards. */
Balance balance_from_here(const Mechanism *m, const SlipMode *slip);

#endif
