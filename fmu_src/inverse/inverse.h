/* Inverse dynamics: the torque that an imposed motion of cam 2's shaft takes (mechanism page, section 7).
 *
 * With D(v) the damper's force, sigma the direction of motion and rho, kappa_1 those of the flanks on which the
 * contacts then bear (contact.h),
 *     A = F_s(z) + F_ext + D(v) + m (z' alpha + z'' omega^2)      W = I (gamma' alpha + gamma'' omega^2)
 *     tau = rho A + rho kappa_1 W + b omega + J alpha
 * At rest the direction of the last motion counts; before any motion, loading.
 *
 * With a shaft of stiffness K the imposed angle is that of its far end, and cam 2 follows as friction lets it
 * (elastic_shaft.h); then neither inertia nor damping acts. Everything is SI. Nothing here knows of FMI. */
#ifndef DUALCAM_INVERSE_H
#define DUALCAM_INVERSE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "geometry/transmission.h"
#include "inverse/imposed.h"
#include "model/fault.h"
#include "model/known.h"
#include "model/ledger.h"
#include "model/mode.h"
#include "model/params.h"

/* At the latest communication point. */
typedef struct {
    double theta;      /* rad, the imposed angle */
    double omega;      /* rad/s */
    double cam;        /* rad, angle of cam 2; theta where the shaft is rigid */
    int64_t events;    /* mode changes so far */
    Mode mode;         /* stick (omega = 0), loading or releasing; with an elastic shaft cam 2's */
    int32_t direction; /* of the last motion, +1 or -1 */
    Ledger ledger;
} InverseState;

typedef struct {
    double z; /* m */
    double v; /* m/s */
} InverseMotion;

typedef struct {
    double theta_cam;        /* rad */
    double gamma;            /* rad */
    double spring_force;     /* N */
    double damper_force;     /* N */
    double sliding_speed[2]; /* m/s */
    double torque_load;      /* N.m, upper edge of the stick band; +inf: no torque loads */
    double torque_release;   /* N.m, lower edge of the stick band; -inf: wedged */
    double efficiency;       /* torque_release / torque_load */
    int mode;                /* Mode */
    int64_t events;
} InverseLoadOutputs;

typedef struct {
    double tau;         /* N.m */
    double reaction[2]; /* N, per contact, signed: + on the flank that supports F > 0 */
} InverseContact;

typedef struct {
    double work_in, work_ext, work_tuning;
    double spring, kinetic, shaft;
    double heat_cam[2], heat_damper, heat_shaft, heat_stop; /* J, all of them */
} InverseEnergy;

typedef struct {
    InverseMotion motion;
    InverseLoadOutputs loads;
    InverseContact contact;
    InverseEnergy energy;
    Audit audit;
} InverseOutputs;

typedef struct {
    Params params;
    InverseInputs inputs;
    InverseState state;
    Transmission transmission; /* geometry along theta; the only member that owns memory */
    const char *resources;     /* directory that a table's relative path starts from, or NULL; not owned */
    bool continuous;           /* model exchange: the direction changes in inverse_settle() only */
} Inverse;

static inline bool has_elastic_shaft(const Inverse *m) {
    return m->params.shaft.stiffness > 0.0;
}

/* All of these that return bool return false, with the reason in `fault` and nothing but the course changed, if
 * it cannot be done. */

/* Starts from m->params and m->inputs: at rest in its past, at theta and omega now. */
bool inverse_start(Inverse *m, Fault *fault);

/* Builds the course that m->params ask for; one built from the same cams and stops is kept. To be called after
 * params, inputs and state were replaced from a snapshot. */
bool inverse_rebuild(Inverse *m, Fault *fault);

/* Replaces m->params at a communication point. Only friction, spring and damper may differ. Books the spring's
 * jump in stored energy as work_tuning. */
bool inverse_retune(Inverse *m, const Params *params, Fault *fault);

/* Safe on a zeroed Inverse, and twice. */
void inverse_free(Inverse *m);

/* Moves as imposed (see imposed.h) for h > 0 seconds and leaves in m->inputs their values at the end. A repetition
 * of the angle and speed of the latest communication point is no motion. Refused are angles beyond the stops and
 * motion that no torque can bring about. */
bool inverse_advance(Inverse *m, double h, Given given, Fault *fault);

/* Takes on the direction of the present motion, where there is one: friction acts against it from now on. */
void inverse_settle(Inverse *m);

/* Where this changes its sign, that is due: rad/s, speed in the present direction. */
double inverse_indicator(const Inverse *m);

/* Is theta between the stops, to rounding? With an elastic shaft they hold cam 2, and any theta is. */
bool inverse_reaches(const Inverse *m, double theta, Fault *fault);

/* The groups of outputs, from state, params and present inputs: what they would be if the motion had gone straight
 * to the present inputs. Reading never changes anything. */
bool inverse_motion(const Inverse *m, InverseMotion *out, Fault *fault);
bool inverse_loads(const Inverse *m, InverseLoadOutputs *out, Fault *fault);
bool inverse_contact(const Inverse *m, InverseContact *out, Fault *fault);
void inverse_energy(const Inverse *m, InverseEnergy *out);
void inverse_audit(const Inverse *m, Audit *out);

/* Time derivatives, where that output can be computed, along the motion that the inputs describe now: theta' = omega,
 * omega' = alpha; alpha' and alpha'' as given for alpha, else by the higher derivatives given for omega or theta,
 * else 0; F_ext' and F_ext'' as given; after a step as its polynomials go on. Of what comes next: where omega = 0, in
 * the direction in which alpha, or the first of its derivatives that is not 0, starts it; if none does or no torque
 * can, in that of the last motion. */
typedef struct {
    double tau[2]; /* of orders 1, 2 */
    double z[3];   /* of orders 1 to 3 */
} InverseDerivatives;

void inverse_derivatives(const Inverse *m, InverseDerivatives *out);

/* Partial derivatives of tau, one-sided in the direction of motion (at rest: of the last motion), and of z (order 0) and
 * v (order 1). False, with the reason, where they do not exist: beyond the stops, wedged; v with an elastic shaft. */
bool inverse_torque_partials(const Inverse *m, Partials *out, Fault *fault);
bool inverse_axial_partials(const Inverse *m, int order, Partials *out, Fault *fault);

#endif
