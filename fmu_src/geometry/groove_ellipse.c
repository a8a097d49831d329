/* The arc of an ellipse. */
#include <math.h>
#include <stdio.h>

#include "elementary/elementary.h"
#include "geometry/groove.h"
#include "numerics/tolerances.h"

static bool build(Groove *groove, const GrooveSource *source, Fault *fault) {
    /* S0 = sin(atan(t)), C0 = cos(atan(t)) */
    const CamParams *cam = source->cam;
    const double t = cam->ellipse_a / cam->ellipse_b * elementary_tan(cam->lead_angle), kappa = cam->ellipse_curvature;
    groove->parameter = "ellipse_a";
    groove->size = cam->ellipse_a;
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
                 source->number, shortest_decimal(cam->lead_angle).text, source->number);
        return false;
    }
    const double level = -groove->S0 / groove->rate, vertical = margin / groove->rate; /* psi where S is 0, 1 */
    groove->first = kappa > 0.0 ? level : vertical;
    groove->last = kappa > 0.0 ? vertical : level;
    return true;
}

/* With u = S - S0: C^2 = C0^2 - u (S0 + S) and C0 - C = (C0^2 - C^2)/(C0 + C). In this form nothing cancels close to
 * psi = 0. */
static GroovePoint at(const Groove *g, double psi) {
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

/* From C = C0 - z/(kappa b): S - S0 = (C0^2 - C^2)/(S0 + S) */
static double angle(const Groove *g, double z) {
    const double drop = z / g->height, C = g->C0 - drop;
    const double S = sqrt(max_of((1.0 - C) * (1.0 + C), 0.0)), sum = g->S0 + S;
    return sum > 0.0 ? drop * (g->C0 + C) / (sum * g->rate) : 0.0;
}

const GrooveLaw GROOVE_ELLIPSE = {"elliptical", "S = S0 + kappa r psi/a must stay in [0, 1)", build, at, angle};
