#include "geometry/groove.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "elementary/elementary.h"
#include "model/csv_file.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

static bool build_helix(Groove *groove, const CamParams *cam) {
    groove->gain = cam->radius * elementary_tan(cam->lead_angle);
    groove->first = -INFINITY;
    groove->last = INFINITY;
    return true;
}

static bool build_ellipse(Groove *groove, const CamParams *cam, int number, Fault *fault) {
    /* S0 = sin(atan(t)), C0 = cos(atan(t)) */
    const double t = cam->ellipse_a / cam->ellipse_b * elementary_tan(cam->lead_angle), kappa = cam->ellipse_curvature;
    groove->C0 = 1.0 / sqrt(1.0 + t * t);
    groove->S0 = t * groove->C0;
    groove->gain = cam->radius * cam->ellipse_b / cam->ellipse_a;
    groove->height = kappa * cam->ellipse_b;
    groove->rate = kappa * cam->radius / cam->ellipse_a;
    const double margin =
        groove->C0 * groove->C0 / (1.0 + groove->S0) - ELLIPSE_VERTICAL; /* of S, from S0 to a vertical groove */
    if (!(margin >= 0.0)) {
        snprintf(fault->text, sizeof fault->text,
                 "cam%d.lead_angle = %s: the elliptical groove of cam %d would start vertical: "
                 "S0 = sin(atan(ellipse_a/ellipse_b tan(lead_angle))) must be < 1",
                 number, shortest_decimal(cam->lead_angle).text, number);
        return false;
    }
    const double level = -groove->S0 / groove->rate, vertical = margin / groove->rate; /* psi where S is 0, 1 */
    groove->first = kappa > 0.0 ? level : vertical;
    groove->last = kappa > 0.0 ? vertical : level;
    return true;
}

static bool build_table(Groove *groove, const char *path, int number, const char *resources, Fault *fault) {
    char variable[16];
    snprintf(variable, sizeof variable, "cam%d.table", number);
    Samples samples;
    if (!samples_read(&samples, path, resources, variable, fault)) return false;
    const size_t size = strlen(path) + 1;
    groove->path = malloc(size);
    const bool good = groove->path != NULL && table_build(&groove->table, &samples);
    if (good) {
        memcpy(groove->path, path, size);
        groove->first = samples.sample[0].psi;
        groove->last = samples.sample[samples.count - 1].psi;
    } else {
        snprintf(fault->text, sizeof fault->text,
                 "%s = \"%.*s\": no curve through these points: they must not be so close that slopes "
                 "overflow, nor too many for the memory there is",
                 variable, csv_quoted(path, QUOTED_PATH), path);
        groove_free(groove);
    }
    samples_free(&samples);
    return good;
}

bool groove_build(Groove *groove, const Params *p, int number, const char *resources, Fault *fault) {
    const CamParams *cam = &p->cam[number - 1];
    *groove = (Groove){.profile = cam->profile, .radius = cam->radius};
    switch (cam->profile) {
        case PROFILE_HELIX: return build_helix(groove, cam);
        case PROFILE_ELLIPSE: return build_ellipse(groove, cam, number, fault);
        case PROFILE_TABLE: return build_table(groove, p->table[number - 1], number, resources, fault);
        default:
            snprintf(fault->text, sizeof fault->text,
                     "cam%d.profile = %d: allowed are 1 (helix), 2 (ellipse) and 3 (table)", number, cam->profile);
            return false;
    }
}

void groove_free(Groove *groove) {
    table_free(&groove->table);
    free(groove->path);
    groove->path = NULL;
}

static double clamped(double x, double low, double high) {
    if (x < low) return low;
    return x > high ? high : x;
}

/* With u = S - S0: C^2 = C0^2 - u (S0 + S) and C0 - C = (C0^2 - C^2)/(C0 + C). In this form nothing cancels close to
 * psi = 0. */
static GroovePoint ellipse_at(const Groove *g, double psi) {
    const double u = g->rate * psi;
    const double S = max_of(g->S0 + u, 0.0), rise = u * (g->S0 + S);
    const double CC = g->C0 * g->C0 - rise, C = sqrt(CC);
    const double inverse = 1.0 / C, slope = g->gain * S * inverse;
    return (GroovePoint){
        .z = g->height * rise / (g->C0 + C),
        .slope = slope,
        .dslope_dpsi = g->gain * g->rate * inverse * inverse * inverse,
    };
}

GroovePoint groove_at(const Groove *groove, double psi) {
    if (groove->profile == PROFILE_HELIX) return (GroovePoint){groove->gain * psi, groove->gain, 0.0};
    psi = clamped(psi, groove->first, groove->last);
    return groove->profile == PROFILE_ELLIPSE ? ellipse_at(groove, psi) : table_at(&groove->table, psi);
}

/* From C = C0 - z/(kappa b): S - S0 = (C0^2 - C^2)/(S0 + S) */
static double ellipse_angle(const Groove *g, double z) {
    const double drop = z / g->height, C = g->C0 - drop;
    const double S = sqrt(max_of((1.0 - C) * (1.0 + C), 0.0)), sum = g->S0 + S;
    return sum > 0.0 ? drop * (g->C0 + C) / (sum * g->rate) : 0.0;
}

double groove_angle(const Groove *groove, double z) {
    if (groove->profile == PROFILE_HELIX) return groove->gain > 0.0 ? z / groove->gain : 0.0;
    const bool ellipse = groove->profile == PROFILE_ELLIPSE;
    const double psi = ellipse ? ellipse_angle(groove, z) : table_angle(&groove->table, z);
    return clamped(psi, groove->first, groove->last);
}

double groove_slope(const Groove *groove, double psi, double z) {
    if (groove->profile == PROFILE_ELLIPSE) {
        const double C = groove->C0 - z / groove->height;
        if (2.0 * C * C < 1.0 && C > 0.0) return groove->gain * sqrt((1.0 - C) * (1.0 + C)) / C;
    }
    return groove_at(groove, psi).slope;
}
