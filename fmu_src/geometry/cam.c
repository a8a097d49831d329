#include "geometry/cam.h"

#include "elementary/elementary.h"
#include "model/friction_law.h"

Geometry cam_geometry(const CamParams cam[2], const double slope[2]) {
    Geometry g = {.dz_dtheta = 0.0};
    for (int i = 0; i < 2; i++) {
        g.radius[i] = cam[i].radius;
        g.friction[i] = friction_static(&cam[i]);
        g.slope[i] = max_of(slope[i], 0.0); /* the polynomial of a level groove rounds below 0 */
    }
    const double sum = g.slope[0] + g.slope[1];
    g.dpsi_dtheta[0] = g.slope[1] / sum;
    g.dpsi_dtheta[1] = g.slope[0] / sum;
    g.dz_dtheta = g.slope[0] * g.dpsi_dtheta[0];
    return g;
}
