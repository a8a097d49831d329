/* Cam 2 at the end of an elastic shaft: where the far end of the shaft takes it.
 *
 * Friction holds cam 2 at x while the shaft's torque is inside the stick band. Otherwise cam 2 moves until the torque
 * is on the edge of the band (band_edge.h), or to an end stop. */
#ifndef DUALCAM_ELASTIC_CAM_H
#define DUALCAM_ELASTIC_CAM_H

#include "inverse/inverse_state.h"
#include "numerics/quadrature.h"

typedef struct {
    const Inverse *m;
    double x;               /* rad, angle of cam 2 */
    double F_ext;           /* N */
    double F_ext_rate;      /* N/s; 0 inside a step, where F_ext is constant over each of many intervals */
    Quadrature *quadrature; /* books work and heat of the motion, or NULL */
    Work *work;             /* counts evaluations, or NULL */
    bool moved;             /* set once cam 2 has moved */
} ElasticCam;

/* Moves cam 2 in `direction` as far as the shaft takes it while the far end goes from one angle to another.
 * False if no torque is finite on the path that is booked, or the work is spent. */
bool elastic_cam_slip(ElasticCam *cam, double theta_from, double theta_to, int direction);

/* Moves cam 2 after the load or the parameters changed while the far end stands at theta. */
bool elastic_cam_relax(ElasticCam *cam, double theta);

/* Both: relaxes cam 2 at the first angle, then takes it along to the second. */
bool elastic_cam_follow(ElasticCam *cam, double theta_from, double theta_to);

#endif
