/* Geometry and loads where cam 2 stands at one angle: what inverse dynamics is made of. */
#ifndef DUALCAM_STATION_H
#define DUALCAM_STATION_H

#include <stdbool.h>

#include "cam.h"
#include "contact.h"
#include "course.h"
#include "params.h"

typedef struct {
    Geometry geometry;
    double bend[2];   /* m/rad^2, da_i/dtheta */
    double turn_rate; /* 1/rad, gamma'' */
    double lift_rate; /* m/rad^2, z'' */
    double z;         /* m */
} Station;

Station station_at(const Params *params, const Piece *piece, double theta);

/* What the contacts do under an axial load and a twist. */
typedef struct {
    double torque;        /* N.m, T that cam 2 passes on */
    double x[2];          /* N/m, R_i / hypot(r_i, a_i), R_i total: see contact.h */
    int flank[2];         /* e_i */
    Transfer transfer;    /* per axial load and twist */
} Bearing;

typedef struct {
    double axial, twist;           /* N, N.m: A and W */
    double axial_size, twist_size; /* of what adds up to them: rounding errors are a few eps of these */
} Burden;

/* The first pair of flanks, of (s,s), (s,-s), (-s,s), (-s,-s) with s = sign(A), that agree with their own reactions
 * when the mechanism moves in `direction`. False if none does: wedged. */
bool station_bearing(const Station *station, int direction, const Burden *burden, Bearing *bearing);

/* The same at rest on the edge of the stick band, where F_0 = F_s + F_ext is all there is. */
bool station_edge(const Station *station, int direction, double F_0, Bearing *bearing);

/* Is the reaction of contact i none, to rounding? Then it agrees with either flank. */
bool station_is_idle(const Bearing *bearing, const Burden *burden, int i);

/* d rho/dtheta of that transfer, m/rad. */
double station_rho_rate(const Station *station, int direction, const Bearing *bearing);

/* J per radian that cam 2 turns: friction heat at contact i, >= 0. */
double station_heat(const Station *station, const Bearing *bearing, int i);

static inline int flank_branch(const int flank[2]) {
    return (flank[0] < 0) + 2 * (flank[1] < 0);
}

#endif
