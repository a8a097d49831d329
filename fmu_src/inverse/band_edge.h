/* One edge E(x) = rho F_0 of the stick band along the angle x of cam 2, where the shaft is elastic, and the holding
 * angle theta_h(x) = x + E(x)/K of its far end (docs/mechanism.md, section 7). A reversal is an x where theta_h changes
 * between rising and falling, or jumps down because another pair of flanks takes over. */
#ifndef DUALCAM_BAND_EDGE_H
#define DUALCAM_BAND_EDGE_H

#include "geometry/transmission.h"
#include "inverse/contact_statics.h"
#include "model/params.h"

typedef struct {
    const Params *params;
    const TransmissionPiece *piece; /* that x lies on */
    int direction;                  /* +1: upper edge, T_load; -1: lower edge, T_release */
    double F_ext;                   /* N */
    double theta;                   /* rad, angle of the far end */
    Work *work;                     /* counts evaluations, or NULL */
} BandEdge;

typedef struct {
    ContactStatics statics;
    ContactForces forces; /* filled where `finite` */
    double F_0;           /* N, F_s + F_ext */
    double torque;        /* N.m, E(x); infinite where no torque moves cam 2 in this direction */
    bool finite;
} EdgePoint;

void band_edge_at(const BandEdge *edge, double x, EdgePoint *out);

/* Which formula gives E(x): the pair of flanks that bear, or 4 where E(x) is infinite. */
int edge_point_branch(const EdgePoint *point);

/* A ScalarFunction of a BandEdge: how far the shaft's torque lies beyond the edge, N.m; > 0 moves cam 2 on. */
double band_edge_excess(const void *edge, double x);

/* Does the shaft move cam 2 on from x? A difference within rounding does not. */
bool band_edge_is_exceeded(const BandEdge *edge, double x);

/* Is the shaft's torque inside the band (-1), on the edge to rounding (0), or beyond the edge (+1)? */
int band_edge_side(const BandEdge *edge, double x, const EdgePoint *point);

/* theta_h(x) times the direction, rad: it rises along the motion unless cam 2 snaps. */
double band_edge_holding_angle(const BandEdge *edge, double x);

/* d theta_h/dx = 1 + E'(x)/K with E' = rho' F_0 + rho F_s' z'. */
double edge_point_slope(const BandEdge *edge, const EdgePoint *point);

typedef struct {
    double x;             /* rad */
    double holding_angle; /* rad, times the direction */
    double slope;         /* d theta_h/dx */
    int branch;           /* edge_point_branch() */
} EdgeSample;

EdgeSample band_edge_sample(const BandEdge *edge, double x);

/* Is there a reversal between two samples? Then *before and *after are the angles of cam 2 on both sides of it, equal
 * unless theta_h jumps. Two reversals between the samples are found if a cubic through them comes close to falling. */
bool band_edge_has_reversal(const BandEdge *edge, const EdgeSample *a, const EdgeSample *b, double *before,
                            double *after);

#endif
