/* Geometry and loads where cam 2 stands at one angle: what inverse dynamics is made of. */
#ifndef DUALCAM_CONTACT_STATICS_H
#define DUALCAM_CONTACT_STATICS_H

#include <stdbool.h>

#include "contact/contact.h"
#include "geometry/cam.h"
#include "geometry/transmission.h"
#include "model/params.h"

typedef struct {
    Geometry geometry;
    double dslope_dtheta[2]; /* m/rad^2, da_i/dtheta */
    double d2gamma_dtheta2;  /* 1/rad, gamma'' */
    double d2z_dtheta2;      /* m/rad^2, z'' */
    double z;                /* m */
} ContactStatics;

ContactStatics contact_statics_at(const Params *params, const TransmissionPiece *piece, double theta);

/* What the contacts do under an axial load and a twist. */
typedef struct {
    double torque;     /* N.m, T that cam 2 passes on */
    double x[2];       /* N/m, R_i / hypot(r_i, a_i), R_i total: see contact.h */
    int flank[2];      /* e_i */
    Transfer transfer; /* per axial load and twist */
} ContactForces;

typedef struct {
    double axial, moment;           /* N, N.m: A and W */
    double axial_size, moment_size; /* of what adds up to them: rounding errors are a few eps of these */
} Load;

/* The first pair of flanks, of (s,s), (s,-s), (-s,s), (-s,-s) with s = sign(A), that agree with their own reactions
 * when the mechanism moves in `direction`. False if none does: wedged. */
bool contact_statics_forces(const ContactStatics *statics, int direction, const Load *load, ContactForces *forces);

/* The same at rest on the edge of the stick band, where F_0 = F_s + F_ext is all there is. */
bool contact_statics_on_edge(const ContactStatics *statics, int direction, double F_0, ContactForces *forces);

/* Is the reaction of contact i none, to rounding? Then it agrees with either flank. */
bool contact_statics_is_idle(const ContactForces *forces, const Load *load, int i);

/* d rho/dtheta of that transfer, m/rad. */
double contact_statics_drho_dtheta(const ContactStatics *statics, int direction, const ContactForces *forces);

/* J per radian that cam 2 turns: friction heat at contact i, >= 0. */
double contact_statics_heat(const ContactStatics *statics, const ContactForces *forces, int i);

static inline int flank_branch(const int flank[2]) {
    return (flank[0] < 0) + 2 * (flank[1] < 0);
}

#endif
