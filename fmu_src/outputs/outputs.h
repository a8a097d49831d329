/* The room outputs/ holds what is read from the mechanism at one instant: outputs, energies, time derivatives, and for
 * model exchange rates and indicators (ode.h). The mode is decided with the present inputs. Reading an output never
 * changes the mechanism.
 *
 * May include: platform, elementary, numerics, model, geometry, contact, closed_form, collocation, forward. */
#ifndef DUALCAM_OUTPUTS_H
#define DUALCAM_OUTPUTS_H

#include "forward/state.h"
#include "model/known.h"
#include "outputs/taylor.h"

typedef struct {
    double z; /* m */
    double v; /* m/s */
} Motion;

typedef struct {
    double alpha;                   /* rad/s^2 */
    double gamma;                   /* rad */
    double spring_force;            /* N */
    double damper_force;            /* N */
    double reaction[2];             /* N, per pin end; positive on the flank that supports F > 0 */
    double sliding_speed[2];        /* m/s */
    double friction_coefficient[2]; /* in effect; at rest the static coefficient */
    double friction_power[2];       /* W, total of all pin ends */
    double total_friction_power;    /* W */
    double torque_load;             /* N.m, upper edge of the stick band; +inf: jammed */
    double torque_release;          /* N.m, lower edge of the stick band; -inf: wedged */
    double efficiency;              /* torque_release / torque_load */
    int mode;                       /* Mode, decided with the present inputs */
    int friction_class;             /* FrictionClass */
    int64_t events;
} LoadOutputs;

typedef struct {
    double work_in, work_ext, work_tuning;
    double spring, kinetic;
    double heat_cam[2], heat_damper, heat_shaft, heat_stop; /* all in J */
} Energy;

/* Derivatives of theta and omega at the end of the latest step: step_sensitivity.h. */
typedef struct {
    double dtheta[KNOWN_COUNT], domega[KNOWN_COUNT]; /* rad and rad/s per unit of the known; none by alpha */
} StepSensitivity;

typedef struct {
    Motion motion;
    LoadOutputs loads;
    Energy energy;
    Audit audit;
    StepSensitivity step;
} Outputs;

void mechanism_motion(const Mechanism *m, Motion *out);
void mechanism_loads(const Mechanism *m, LoadOutputs *out);
void mechanism_energy(const Mechanism *m, Energy *out);
void mechanism_audit(const Mechanism *m, Audit *out);

/* Time derivatives at the present instant; at a mode change those of the mode that follows with the present inputs. */
typedef struct {
    double theta[3], z[3]; /* orders 1 to 3; rad/s^k, m/s^k */
} MotionDerivatives;

void motion_derivatives(const Mechanism *m, MotionDerivatives *out);

/* The motion in one slip mode as Taylor polynomials, up to the coefficient `last` of omega, with their derivatives by
 * `known`. KNOWN_COUNT: without derivatives. */
void taylor_of_motion(const Mechanism *m, const SlipMode *slip, Known known, int last, Taylor *out);

#endif
