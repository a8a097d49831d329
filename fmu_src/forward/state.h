/* The room forward/ holds forward dynamics: torque in, motion out.
 * May include: platform, elementary, numerics, model, geometry, contact, closed_form, collocation.
 *
 * The mechanism: two coaxial cylindrical cams share one follower pin, which a spring and a damper load along the axis.
 * Cam 1 is fixed. The torque tau acts on cam 2, which rotates by theta and moves the follower by z.
 *
 * Source of the model: M. Monfrini, R. Pagani, A. Borboni, "Optimisation of a Dual Cylindrical Cam Mechanism for Energy
 * Storage and Torque Efficiency", Reports in Mechanical Engineering, 2026, with the corrections of docs/mechanism.md,
 * section 8. All values are in SI units. Nothing here knows of FMI.
 *
 * Four kinds of data are kept apart:
 *   Params   the user's choice; constant while the mechanism moves
 *   Inputs   torque and axial force, polynomials of time over the coming step
 *   State    all that a restored run needs; one assignment saves the state
 *   Outputs  computed from the other three, on request only: in the room outputs
 * Model holds what Params imply. Configuration holds what theta implies. Cache holds values that a step can compute
 * again bit for bit, so the cache is never saved.
 *
 * Files, in the order in which a step uses them:
 *   step               the step as an outline: decide the mode, propose a segment, apply it, handle its event
 *   decide, candidate  which mode comes next (friction inclusion), and the motion along one slip mode
 *   stick              the stick band, and the time for which rest lasts
 *   segment            one part of a step in one mode, and the one function that applies it
 *   rest, closed_form_slip, collocation_slip, jump    the methods that propose segments
 *   play               the play operator: the angle by which theta moves along the edge of the stick band
 *   impact             end stops and wedges
 *   configuration, lifecycle                          what theta implies; start and tuning */
#ifndef DUALCAM_STATE_H
#define DUALCAM_STATE_H

#include <stdbool.h>
#include <stdint.h>

#include "closed_form/linear_slip.h"
#include "collocation/radau_step.h"
#include "contact/contact.h"
#include "contact/domain.h"
#include "geometry/cam.h"
#include "geometry/transmission.h"
#include "model/friction_table_load.h"
#include "model/ledger.h"
#include "model/mode.h"
#include "model/params.h"
#include "model/work.h"
#include "numerics/sum.h"

/* The start of the latest step. With these values the step can be repeated. */
typedef struct {
    Sum theta, omega; /* rad, rad/s */
    Inputs inputs;
    double energy_gained; /* J, see State */
    double h;             /* s; 0: no step has been made */
    Mode mode;
    int flank[2];
    int retuned; /* 1: parameters have been tuned since the step, see State.tunables; else 0 */
} Step;

typedef struct {
    Sum theta;             /* rad */
    Sum omega;             /* rad/s */
    double energy_gained;  /* J, by the errors of integration since the last impact: collocation/step_energy.h */
    int64_t events;        /* mode changes so far */
    double F_ext_at_start; /* N, under which the friction class was found (contact/domain.h) */
    Mode mode;
    int flank[2];       /* e_i while slipping: +1 supporting flank of cam i's groove, -1 the other flank */
    int friction_class; /* FrictionClass */
    Ledger ledger;
    Step step;
    Tunables tunables; /* those of the latest step if step.retuned, else 0 */
} State;

/* What Params imply. */
typedef struct {
    Transmission transmission; /* geometry along theta; owns memory, as the tables below do */
    FrictionTables friction;   /* that params.cam[].law.table points to */
    FrictionConstants law[2];  /* only where friction varies */
    bool friction_is_loaded;   /* a friction coefficient depends on the load */
    bool closed_form;          /* helices and linear forces: slip is known at any time (linear_slip.h) */
    LinearSlipMode linear_slip[SLIP_MODE_COUNT]; /* by slip_index(); coefficients of the closed form */
    unsigned linear_slips;                       /* bit k: linear_slip[k] has been built; most slip modes never occur */
} Model;

/* What theta implies. */
typedef struct {
    Geometry geometry;
    double z;         /* m */
    BandFactors band; /* T_load/F_0 and T_release/F_0; for helices only, see stick_band() */
} Configuration;

/* The interval of torque in which a mechanism at rest stays at rest. */
typedef struct {
    double lower, upper; /* N.m */
    double F_ext;        /* N, the axial force for which the interval holds */
    bool valid;
} RestInterval;

typedef struct {
    RestInterval rest;
    Kernel kernel[SLIP_MODE_COUNT]; /* propagation over the latest quiet step, by slip_index() */
    StepProposal proposal;          /* for the next collocation step of this communication step */
    Inputs decided;                 /* the inputs that the present mode was decided with */
    bool is_decided;
} Cache;

typedef struct {
    Params params;
    Inputs inputs;
    State state;
    Model model;
    Configuration configuration; /* belongs to state.theta */
    Cache cache;
    Work *work;         /* of the step that is being made; else NULL */
    int64_t work_limit; /* see work_of_call() */
    bool crossed[2];    /* in a step: the latest segment has ended as x_i passes zero */
    unsigned
        ended_slips; /* in a step: bit k: slip k has ended here as a reaction passed zero; it does not begin again */
    const char *resources; /* directory from which a table's relative path starts, or NULL; not owned */
    bool continuous;       /* model exchange (ode.h): modes change in mechanism_settle() only */
} Mechanism;

static inline bool is_slip(Mode mode) {
    return mode == MODE_LOADING || mode == MODE_RELEASING;
}

/* sigma of a mode of slip: +1 loading, -1 releasing. */
static inline int direction_of(Mode mode) {
    return mode == MODE_LOADING ? 1 : -1;
}

/* The slip mode of an index, see slip_index(). */
static inline int slip_direction(int index) {
    return index < FLANK_PAIR_COUNT ? 1 : -1;
}

static inline void slip_flanks(int index, int flank[2]) {
    flank[0] = index & 2 ? -1 : 1;
    flank[1] = index & 1 ? -1 : 1;
}

/* Index of the present slip mode; m->state.mode is a mode of slip. */
static inline int present_slip_index(const Mechanism *m) {
    return slip_index(direction_of(m->state.mode), m->state.flank);
}

#endif
