#include "geometry/transmission_build.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "elementary/elementary.h"
#include "geometry/cam.h"
#include "geometry/groove_pair.h"
#include "geometry/transmission_fit.h"
#include "platform/attributes.h"

/* Two helices: gamma, phi and z are linear in theta. */
static bool build_straight(Transmission *transmission, const Params *p, Fault *fault) {
    const double slope[2] = {transmission->groove[0].gain, transmission->groove[1].gain};
    if (!(slope[0] + slope[1] > 0.0)) return groove_pair_refuse_level(p, transmission->lower, 0.0, fault);
    transmission->piece = malloc(sizeof *transmission->piece);
    if (!transmission->piece) {
        snprintf(fault->text, sizeof fault->text, "not enough memory: %zu bytes must be available",
                 sizeof(TransmissionPiece));
        return false;
    }
    transmission->count = 1;
    *transmission->piece = (TransmissionPiece){
        .lower = transmission->lower,
        .upper = transmission->upper,
        .scale = 1.0,
        .slope = {{slope[0], slope[1]}},
        .z = {0.0, cam_dz_dtheta(slope)},
    };
    return true;
}

static bool check_stops(double lower, double upper, Fault *fault) {
    if (isfinite(lower) && isfinite(upper) && lower < upper) return true;
    snprintf(fault->text, sizeof fault->text, "stop.lower = %s must be < stop.upper = %s, and both must be finite",
             shortest_decimal(lower).text, shortest_decimal(upper).text);
    return false;
}

static bool build(Transmission *transmission, const Params *p, const char *resources, Fault *fault) {
    if (!check_stops(p->stop.lower, p->stop.upper, fault)) return false;
    for (int i = 0; i < 2; i++)
        if (!groove_build(&transmission->groove[i], p, i + 1, resources, fault)) return false;
    if (transmission->straight) return build_straight(transmission, p, fault);
    return groove_pair_check_ends(transmission->groove, p, fault) && transmission_fit(transmission, p, fault);
}

/* At the ends of the pieces z, being monotone, is largest, and so, nearly, are the slopes. */
static void measure_size(Transmission *transmission) {
    for (size_t k = 0; !transmission->straight && k < transmission->count; k++) {
        const double ends[2] = {transmission->piece[k].lower, transmission->piece[k].upper};
        for (int i = 0; i < 2; i++) {
            const TransmissionPoint point = piece_at(&transmission->piece[k], ends[i]);
            transmission->slope_size =
                max_of(transmission->slope_size, max_of(fabs(point.slope[0]), fabs(point.slope[1])));
            for (int j = 0; j < 2; j++)
                if (transmission->groove[j].profile != PROFILE_HELIX)
                    transmission->steepest[j] = max_of(transmission->steepest[j], fabs(point.slope[j]));
            transmission->z_size = max_of(transmission->z_size, fabs(point.z));
        }
    }
}

bool transmission_build(Transmission *transmission, const Params *p, const char *resources, Fault *fault) {
    *transmission = (Transmission){
        .cam = {p->cam[0], p->cam[1]},
        .lower = p->stop.lower,
        .upper = p->stop.upper,
        .straight = p->cam[0].profile == PROFILE_HELIX && p->cam[1].profile == PROFILE_HELIX,
    };
    const bool good = build(transmission, p, resources, fault);
    if (good) measure_size(transmission);
    else transmission_free(transmission);
    return good;
}
