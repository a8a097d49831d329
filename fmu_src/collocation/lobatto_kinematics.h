/* The grooves and the kinematics at two nodes of a Lobatto step. */
#ifndef DUALCAM_LOBATTO_KINEMATICS_H
#define DUALCAM_LOBATTO_KINEMATICS_H

#include "collocation/lobatto_nodes.h"
#include "platform/attributes.h"

typedef struct {
    Vector2 slope[2], dslope_dtheta[2], z;
} PointPair;

static inline PointPair point_pair(const TransmissionPiece *piece, Vector2 theta, TransmissionDepth depth) {
    const TransmissionPoint a = piece_point(piece, theta[0], depth), b = piece_point(piece, theta[1], depth);
    PointPair points = {.z = {a.z, b.z}};
    for (int i = 0; i < 2; i++) {
        points.slope[i] = (Vector2){a.slope[i], b.slope[i]};
        points.dslope_dtheta[i] = (Vector2){a.dslope_dtheta[i], b.dslope_dtheta[i]};
    }
    return points;
}

NOINLINE static void find_slopes(const TransmissionPiece *piece, Vector2 theta, PointPair *out) {
    *out = point_pair(piece, theta, TRANSMISSION_SLOPES);
}

NOINLINE static void find_slopes_and_derivatives(const TransmissionPiece *piece, Vector2 theta, PointPair *out) {
    *out = point_pair(piece, theta, TRANSMISSION_FIRST_DERIVATIVES);
}

static inline PointPair points_at(const SlipMode *slip, Vector2 theta) {
    const TransmissionPiece *piece = slip->piece;
    PointPair points;
    if (slip->transmission->straight) {
        const Vector2 none = {0.0, 0.0};
        points = (PointPair){.slope = {none + piece->slope[0][0], none + piece->slope[0][1]}};
        points.z = piece->z[0] + theta * piece->z[1];
    } else if (slip->follower_has_inertia) {
        find_slopes_and_derivatives(piece, theta, &points);
    } else {
        find_slopes(piece, theta, &points);
    }
    return points;
}

/* A negative slope is rounding of the polynomial of a level groove. */
static inline Vector2 not_negative(Vector2 v) {
    return (Vector2){v[0] > 0.0 ? v[0] : 0.0, v[1] > 0.0 ? v[1] : 0.0};
}

/* The kinematics of docs/mechanism.md, section 2. */
static inline void find_kinematics(const SlipMode *slip, Vector2 theta, NodePair *n) {
    const PointPair points = points_at(slip, theta);
    for (int i = 0; i < 2; i++) n->slope[i] = not_negative(points.slope[i]);
    const Vector2 inverse = 1.0 / (n->slope[0] + n->slope[1]);
    n->z = points.z;
    n->dpsi_dtheta[0] = n->slope[1] * inverse;
    n->dpsi_dtheta[1] = n->slope[0] * inverse;
    n->dz_dtheta = n->slope[0] * n->dpsi_dtheta[0];
    if (!slip->follower_has_inertia) return;
    n->d2gamma_dtheta2 =
        (points.dslope_dtheta[1] * n->dpsi_dtheta[1] - points.dslope_dtheta[0] * n->dpsi_dtheta[0]) * inverse;
    n->d2z_dtheta2 = points.dslope_dtheta[0] * n->dpsi_dtheta[0] * n->dpsi_dtheta[0] +
                     points.dslope_dtheta[1] * n->dpsi_dtheta[1] * n->dpsi_dtheta[1];
}

#endif
