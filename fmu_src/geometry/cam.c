#include "geometry/cam.h"

#include "elementary/elementary.h"
#include "model/friction_law.h"

Geometry cam_geometry(const CamParams cam[2], const double slope[2]) {
    Geometry g = {.dz_dtheta = 0.0};
    for (int i = 0; i < 2; i++) {
        g.radius[i] = cam[i].radius;
        g.friction[i] = cam[i].law.table ? cam[i].law.table->at_rest : cam[i].friction * cam[i].law.peak;
        g.slope[i] = max_of(slope[i], 0.0); /* the polynomial of a level groove rounds below 0 */
    }
    const double sum = g.slope[0] + g.slope[1];
    g.dpsi_dtheta[0] = g.slope[1] / sum;
    g.dpsi_dtheta[1] = g.slope[0] / sum;
    g.dz_dtheta = g.slope[0] * g.dpsi_dtheta[0];
    return g;
}

void cam_set_load(const Params *params, double F_0, Geometry *g) {
    if (!any_friction_depends_on_load(params)) return;
    for (int i = 0; i < 2; i++) {
        const double N = cam_nominal_load(g, i, F_0, params->contacts);
        const FrictionCoefficient mu = friction_at(&params->cam[i], 0.0, N);
        g->friction[i] = mu.value;
        g->friction_by_log_load[i] = mu.by_load * N;
    }
}
