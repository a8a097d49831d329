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
} InverseMotionOutputs;

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
    int friction_class;      /* FrictionClass */
    int64_t events;
} InverseLoadOutputs;

typedef struct {
    double tau;                     /* N.m */
    double reaction[2];             /* N, per pin end; positive on the flank that supports F > 0 */
    double friction_coefficient[2]; /* in effect; at rest the static coefficient */
    double friction_power[2];       /* W, total of all pin ends */
    double total_friction_power;    /* W */
} InverseTorqueOutputs;

/* All in J. */
typedef struct {
    double work_in, work_ext, work_tuning;
    double spring, kinetic, shaft;
    double heat_cam[2], heat_damper, heat_shaft, heat_stop;
} InverseEnergyOutputs;

typedef struct {
    InverseMotionOutputs motion;
    InverseLoadOutputs loads;
    InverseTorqueOutputs contact;
    InverseEnergyOutputs energy;
    Audit audit;
} InverseOutputs;

bool inverse_motion_outputs(const Inverse *m, InverseMotionOutputs *out, Fault *fault);
bool inverse_load_outputs(const Inverse *m, InverseLoadOutputs *out, Fault *fault);
bool inverse_torque_outputs(const Inverse *m, InverseTorqueOutputs *out, Fault *fault);
void inverse_energy_outputs(const Inverse *m, InverseEnergyOutputs *out);
void inverse_audit_outputs(const Inverse *m, Audit *out);

/* J, energy of spring, motion and shaft at the latest communication point. */
double inverse_stored_energy(const Inverse *m);

/* Is theta between the stops, to rounding? With an elastic shaft every theta is: the stops hold cam 2. */
bool inverse_reaches(const Inverse *m, double theta, Fault *fault);

#endif
