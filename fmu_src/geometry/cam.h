/* The kinematics at one theta: how far pin and follower move when cam 2 turns (docs/mechanism.md, section 2). */
#ifndef DUALCAM_CAM_H
#define DUALCAM_CAM_H

#include <math.h>

#include "model/params.h"

typedef struct {
    double radius[2];   /* m, r_i */
    double friction[2]; /* mu_i; cam_geometry() sets those at rest, where they depend on the load those at N_ref */
    double friction_by_log_load[2]; /* F_0 dmu_i/dF_0; cam_geometry() sets 0 */
    double slope[2];                /* m/rad, a_i = r_i tan(lambda_i) */
    double dpsi_dtheta[2];          /* gamma' and phi', the shares of theta that the pin turns in cam 1 and in cam 2 */
    double dz_dtheta;               /* m/rad, z' */
} Geometry;

/* The kinematics where the grooves have these slopes. */
Geometry cam_geometry(const CamParams cam[2], const double slope[2]);

/* Sets the friction coefficients to those at rest under the axial load F_0, N. */
void cam_set_load(const Params *params, double F_0, Geometry *g);

/* m/rad: z' = a1 a2/(a1+a2) */
static inline double cam_dz_dtheta(const double slope[2]) {
    return slope[0] * (slope[1] / (slope[0] + slope[1]));
}

/* m^2: r_i^2 + a_i^2, the square of the groove's length per angle of cam i. */
static inline double cam_length2(const Geometry *g, int i) {
    return g->radius[i] * g->radius[i] + g->slope[i] * g->slope[i];
}

/* m^2: friction heat at contact i per |x_i| (see contact.h) and per |omega|, mu_i (r_i^2 + a_i^2) |psi_i'|
 * (docs/mechanism.md, section 4). */
static inline double cam_heat(const Geometry *g, int i) {
    return g->friction[i] * cam_length2(g, i) * g->dpsi_dtheta[i];
}

/* m: sliding distance at contact i per angle of cam 2. */
static inline double cam_sliding(const Geometry *g, int i) {
    return g->dpsi_dtheta[i] * sqrt(cam_length2(g, i));
}

/* N, N_i of one contact, `contacts` in all, under the axial load F (model/friction_law.h). */
static inline double cam_nominal_load(const Geometry *g, int i, double F, int contacts) {
    return fabs(F) * cam_sliding(g, i) / (g->radius[i] * contacts);
}

/* m: groove length per angle of cam i. The squares cannot overflow or underflow: a radius is at least 1e-6 m, a slope
 * at most 1e17 of the radius. */
static inline double cam_length(const Geometry *g, int i) {
    return sqrt(cam_length2(g, i));
}

#endif
