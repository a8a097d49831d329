/* The dual cylindrical cam: parameters, inputs, state, outputs and the step.
 *
 * Two coaxial cylindrical cams share one follower pin that a spring and a damper load along the
 * axis. Cam 1 is fixed; torque tau acts on cam 2, which turns by theta and lifts the follower by z.
 *
 * Source of the model: M. Monfrini, R. Pagani, A. Borboni, "Optimisation of a Dual Cylindrical Cam
 * Mechanism for Energy Storage and Torque Efficiency", Reports in Mechanical Engineering, 2026,
 * with the corrections listed in README.md. Everything is SI. Nothing here knows of FMI.
 *
 * Four kinds of data, kept apart:
 *   Params   what the user chose                      (constant while the mechanism moves)
 *   Inputs   torque and axial force, polynomials in time over the coming step
 *   State    all that a restored run needs: one assignment saves it
 *   Outputs  computed from the other three, and only when somebody asks
 * Model holds what Params imply (geometry, the coefficients of every way to slip); Cache holds
 * values that are recomputed bit for bit when they are missing, so it is never saved.
 */
#ifndef DUALCAM_MECHANISM_H
#define DUALCAM_MECHANISM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "closed_form/linear_slip.h"
#include "collocation/radau_step.h"
#include "contact/contact.h"
#include "geometry/cam.h"
#include "geometry/transmission.h"
#include "model/fault.h"
#include "model/ledger.h"
#include "model/mode.h"
#include "model/params.h"
#include "model/watcher.h"
#include "numerics/sum.h"

/* What the latest step started from: enough to go through it again. */
typedef struct {
    Sum theta, omega; /* rad, rad/s */
    Inputs inputs;
    double h; /* s; 0: there is none */
    Mode mode;
    int flank[2];
    int retuned; /* 1: the parameters have been tuned since, see State.tunables; else 0 */
} Step;

typedef struct {
    Sum theta;      /* rad */
    Sum omega;      /* rad/s */
    int64_t events; /* mode changes so far */
    Mode mode;
    int flank[2]; /* e_i while slipping: +1 supporting flank of cam i's groove, -1 the other one */
    Ledger ledger;
    Step step;
    Tunables tunables; /* those of the latest step if step.retuned, else 0 */
} State;

typedef struct {
    double z; /* m */
    double v; /* m/s */
} Motion;

typedef struct {
    double alpha;            /* rad/s^2 */
    double gamma;            /* rad */
    double spring_force;     /* N */
    double damper_force;     /* N */
    double reaction[2];      /* N, per contact, signed: + on the flank that supports F > 0 */
    double sliding_speed[2]; /* m/s */
    double torque_load;      /* N.m, upper edge of the stick band; +inf: jammed */
    double torque_release;   /* N.m, lower edge of the stick band; -inf: wedged */
    double efficiency;       /* torque_release / torque_load */
    int mode;                /* Mode, decided with the present inputs */
    int64_t events;
} LoadOutputs;

typedef struct {
    double work_in, work_ext, work_tuning;
    double spring, kinetic;
    double heat_cam[2], heat_damper, heat_shaft, heat_stop; /* J, all of them */
} Energy;

/* Of the latest step, whose whole torque is shifted by a constant: see step_sensitivity.h. */
typedef struct {
    double dtheta_dtau; /* rad/(N.m) */
    double domega_dtau; /* rad/s/(N.m) */
} StepSensitivity;

typedef struct {
    Motion motion;
    LoadOutputs loads;
    Energy energy;
    Audit audit;
    StepSensitivity step;
} Outputs;

/* What Params imply. */
typedef struct {
    Transmission transmission; /* geometry along theta; the only member that owns memory */
    bool
        closed_form; /* straight grooves, linear forces: slip is known at any time (linear_slip.h), else see radau_step.h */
    LinearSlipMode linear_slip
        [SLIP_MODE_COUNT]; /* if so, the ways to slip: direction x flank of cam 1 x flank of cam 2, see slip_index() */
    unsigned linear_slips; /* bit k: slip[k] has been built. Most are never needed, see linear_slip_of() */
} Model;

/* What theta implies. */
typedef struct {
    Geometry geometry;
    double z;         /* m */
    BandFactors band; /* T_load / F_0 and T_release / F_0; in straight grooves only, see stick_band() */
} Configuration;

/* A hold is the interval of torque in which a mechanism at rest stays as it is. */
typedef struct {
    double lower, upper; /* N.m */
    double F_ext;        /* N, the force it holds for */
    bool valid;
} RestInterval;

typedef struct {
    RestInterval hold;
    Kernel kernel[SLIP_MODE_COUNT]; /* propagation over the latest full step, by way to slip */
    StepProposal radau;             /* to try for the next leap of this communication step */
} Cache;

typedef struct {
    Params params;
    Inputs inputs;
    State state;
    Model model;
    Configuration configuration; /* belongs to state.theta */
    Cache cache;
    const char *resources; /* directory that a table's relative path starts from, or NULL; not owned */
    bool continuous;       /* somebody else integrates (ode.h): modes change in mechanism_settle() only */
} Mechanism;

/* Starts from m->params and m->inputs: builds the model and sets the state to its start values, in the mode that
 * the present inputs ask for. Returns false and fills `fault` if the parameters cannot work: stops out of order,
 * start not between them, a groove that ends too early or that friction jams, a table that cannot be read. Then
 * nothing but m->model has changed. */
bool mechanism_start(Mechanism *m, Fault *fault);

/* Builds the model anew from m->params and forgets cached values; the state stays. To be called after params, state
 * and inputs were replaced from a snapshot. A course built from the same cams and stops is kept. Returns false and
 * fills `fault` if the parameters cannot work. */
bool mechanism_rebuild(Mechanism *m, Fault *fault);

/* Replaces m->params while the mechanism stands at a communication point. Only friction, spring and damper may
 * differ. Books the spring's jump in stored energy as work_tuning. Returns false, with nothing changed, and fills
 * `fault` if they cannot work. */
bool mechanism_retune(Mechanism *m, const Params *params, Fault *fault);

/* Frees what the model owns. Safe on a zeroed Mechanism, and twice. */
void mechanism_free(Mechanism *m);

/* Advances by h > 0 seconds with m->inputs and leaves in m->inputs their values at the end of the
 * step. Returns false, with the mechanism as before, if mode changes do not end (see
 * MAX_EVENTS_PER_STEP) or a value is no longer finite; `fault` says which. */
bool mechanism_advance(Mechanism *m, double h, Fault *fault);

/* The same, but `watcher`, with mode and cut zero, is told of each instant after the start at which the mode is another
 * one. It sees the mechanism as it is then, and the step ends when it says: `cut` seconds early. The motion is that of
 * one step, however often it is told. */
bool mechanism_advance_watched(Mechanism *m, double h, Watcher *watcher, Fault *fault);

/* Puts it to theta (rad) and omega (rad/s) in its present mode. */
void mechanism_set_motion(Mechanism *m, double theta, double omega);

/* Carries out the mode changes that are due now, with a mechanism placed on or beyond an end stop or velocity zero
 * included. Where somebody else integrates the accounts stay as they are. Returns false, with the mechanism as before, if they do not end. */
bool mechanism_settle(Mechanism *m, Fault *fault);

/* Brings state, inputs and tunable parameters back to where the latest step began; the ledger stays. */
void mechanism_rewind(Mechanism *m);

/* Groups of outputs, from state, params and present inputs. The mode is decided with the
 * present inputs, on a copy: reading never changes the mechanism. */
void mechanism_motion(const Mechanism *m, Motion *out);
void mechanism_loads(const Mechanism *m, LoadOutputs *out);
void mechanism_energy(const Mechanism *m, Energy *out);
void mechanism_audit(const Mechanism *m, Audit *out);

#endif
