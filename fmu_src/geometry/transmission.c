#include "geometry/transmission.h"

#include <stdlib.h>
#include <string.h>

#include "geometry/pin_position.h"
#include "model/sampled_curve.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

void transmission_free(Transmission *transmission) {
    for (int i = 0; i < 2; i++) groove_free(&transmission->groove[i]);
    free(transmission->piece);
    *transmission = (Transmission){.piece = NULL};
}

static bool is_same_groove(const Transmission *transmission, const Params *p, int i) {
    const CamParams *a = &p->cam[i], *b = &transmission->cam[i];
    const char *path = transmission->groove[i].path;
    return a->profile == b->profile && a->radius == b->radius && a->lead_angle == b->lead_angle &&
           a->ellipse_a == b->ellipse_a && a->ellipse_b == b->ellipse_b &&
           a->ellipse_curvature == b->ellipse_curvature && a->cycloid_rise == b->cycloid_rise &&
           a->cycloid_angle == b->cycloid_angle && (path == NULL || strcmp(path, p->table[i]) == 0);
}

bool transmission_is_of(const Transmission *transmission, const Params *p) {
    return transmission->piece != NULL && transmission->lower == p->stop.lower &&
           transmission->upper == p->stop.upper && is_same_groove(transmission, p, 0) &&
           is_same_groove(transmission, p, 1);
}

/* ---- reading ---- */

const TransmissionPiece *transmission_piece(const Transmission *transmission, double theta, int direction) {
    const size_t spacing = sizeof(TransmissionPiece) / sizeof(double);
    const size_t low = curve_interval(&transmission->piece->lower, spacing, transmission->count, theta);
    const TransmissionPiece *piece = &transmission->piece[low];
    const double near = BREAKPOINT_MERGING * (piece->upper - piece->lower);
    if (direction > 0 && low + 1 < transmission->count && theta >= piece->upper - near) return piece + 1;
    if (direction < 0 && low > 0 && theta <= piece->lower + near) return piece - 1;
    return piece;
}

NOINLINE TransmissionPoint piece_at(const TransmissionPiece *piece, double theta) {
    return piece_point(piece, theta, TRANSMISSION_FIRST_DERIVATIVES);
}

/* The polynomials give z, and the steeper groove gives gamma from z: the start of Newton's method. */
static double guess_gamma(const Transmission *transmission, double theta) {
    const TransmissionPoint point = piece_at(transmission_piece(transmission, theta, 0), theta);
    if (point.slope[0] >= point.slope[1]) return groove_angle(&transmission->groove[0], point.z);
    return theta - groove_angle(&transmission->groove[1], point.z);
}

double transmission_gamma(const Transmission *transmission, double theta) {
    if (transmission->straight) {
        const double a1 = transmission->groove[0].gain, a2 = transmission->groove[1].gain;
        return a2 / (a1 + a2) * theta;
    }
    return pin_gamma(transmission->groove, theta, guess_gamma(transmission, theta));
}

double transmission_z(const Transmission *transmission, double theta) {
    if (transmission->straight) return transmission->piece->z[1] * theta;
    const double gamma = transmission_gamma(transmission, theta);
    return pin_height(groove_at(&transmission->groove[0], gamma), groove_at(&transmission->groove[1], theta - gamma));
}
