/* Contact statics: kinematics at one theta, and the torque and reactions of given loads. Inverse dynamics is built on
 * them. */
#ifndef DUALCAM_CONTACT_STATICS_H
#define DUALCAM_CONTACT_STATICS_H

#include <stdbool.h>

#include "contact/contact.h"
#include "geometry/cam.h"
#include "geometry/transmission.h"
#include "model/friction_law.h"
#include "model/params.h"
#include "model/work.h"

typedef struct {
    const Params *params;
    double omega; /* rad/s, the speed that the friction coefficients belong to */
    Geometry geometry;
    double dslope_dtheta[2]; /* m/rad^2, da_i/dtheta */
    double d2gamma_dtheta2;  /* 1/rad, gamma'' */
    double d2z_dtheta2;      /* m/rad^2, z'' */
    double z;                /* m */
} ContactStatics;

/* With the friction coefficients at rest. */
ContactStatics contact_statics_at(const Params *params, const TransmissionPiece *piece, double theta);

/* Sets the friction coefficients to those at the speed `omega` of cam 2 under the axial force F = F_s + F_ext + D. */
void contact_statics_set_motion(const Params *params, double omega, double F, ContactStatics *statics);

/* Torque and reactions under an axial load and a moment. */
typedef struct {
    double torque;     /* N.m, T of cam 2 */
    double x[2];       /* N/m, see contact.h */
    int flank[2];      /* e_i */
    Transfer transfer; /* per axial load and moment */
} ContactForces;

typedef struct {
    double axial, moment; /* N, N.m: A and W */
    double axial_size,
        moment_size; /* sums of the magnitudes of their terms: A and W round by a few eps of these sums */
} Load;

/* The sign of the axial load; 0: the load is rounding. */
int contact_statics_side(const Load *load);

/* Torque and reactions of motion in `direction`, on the first pair of flanks (see flank_pair()) that agrees with its
 * own reactions. False if no pair agrees: wedged. */
bool contact_statics_forces(const ContactStatics *statics, int direction, const Load *load, ContactForces *forces);

/* The same at rest on the edge of the stick band, where A = F_0 = F_s + F_ext and W = 0. Where friction depends on the
 * load, the statics receive the coefficients under F_0. */
bool contact_statics_on_edge(ContactStatics *statics, int direction, double F_0, ContactForces *forces);

/* Is the reaction of contact i zero, to rounding? Then either flank agrees. */
bool contact_statics_carries_nothing(const ContactForces *forces, const Load *load, int i);

/* N.m/rad: the derivative by theta of the torque rho F_0 on the edge that `forces` describes, under a constant F_0. */
double contact_statics_edge_rise(const ContactStatics *statics, int direction, double F_0, const ContactForces *forces);

/* J/rad, >= 0: friction heat at contact i per angle of cam 2. */
double contact_statics_heat(const ContactStatics *statics, const ContactForces *forces, int i);

/* N.m/rad, >= 0: reaction times sliding distance at contact i per angle of cam 2. */
double contact_statics_sliding(const ContactStatics *statics, const ContactForces *forces, int i);

/* A number from 0 to 3 for each pair of flanks. */
static inline int flank_branch(const int flank[2]) {
    return (flank[0] < 0) + 2 * (flank[1] < 0);
}

#endif
