/* Outputs of inverse dynamics, from state, parameters and present inputs: their values if the motion has gone straight
 * from the state to the present inputs. Reading never changes anything.
 *
 * Functions that return bool return false, with the reason in `fault`, where an output does not exist. */
#ifndef DUALCAM_INVERSE_OUTPUTS_H
#define DUALCAM_INVERSE_OUTPUTS_H

#include "inverse/inverse_state.h"
#include "model/fault.h"

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

/* All in J. */
typedef struct {
    double work_in, work_ext, work_tuning;
    double spring, kinetic, shaft;
    double heat_cam[2], heat_damper, heat_shaft, heat_stop;
} InverseEnergy;

typedef struct {
    InverseMotion motion;
    InverseLoadOutputs loads;
    InverseContact contact;
    InverseEnergy energy;
    Audit audit;
} InverseOutputs;

bool inverse_motion(const Inverse *m, InverseMotion *out, Fault *fault);
bool inverse_loads(const Inverse *m, InverseLoadOutputs *out, Fault *fault);
bool inverse_contact(const Inverse *m, InverseContact *out, Fault *fault);
void inverse_energy(const Inverse *m, InverseEnergy *out);
void inverse_audit(const Inverse *m, Audit *out);

/* J, energy of spring, motion and shaft at the latest communication point. */
double inverse_stored_energy(const Inverse *m);

/* Is theta between the stops, to rounding? With an elastic shaft every theta is: the stops hold cam 2. */
bool inverse_reaches(const Inverse *m, double theta, Fault *fault);

#endif
