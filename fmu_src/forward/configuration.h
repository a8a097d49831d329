/* The configuration, which theta implies, and the energies and angles that follow from state and parameters alone. */
#ifndef DUALCAM_CONFIGURATION_H
#define DUALCAM_CONFIGURATION_H

#include "forward/state.h"

/* In grooves that are not straight. */
void update_curved_configuration(Mechanism *m);

/* To be called whenever theta has changed. */
static inline void update_configuration(Mechanism *m) {
    Configuration *c = &m->configuration;
    if (m->model.transmission.straight) c->z = c->geometry.dz_dtheta * m->state.theta.hi;
    else update_curved_configuration(m);
}

/* theta + dtheta, rad, kept between the stops: rounding must not carry theta past a stop. */
static inline Sum theta_after(const Mechanism *m, double dtheta) {
    Sum theta = m->state.theta;
    sum_add(&theta, dtheta);
    if (theta.hi > m->params.stop.upper) theta = sum_of(m->params.stop.upper);
    if (theta.hi < m->params.stop.lower) theta = sum_of(m->params.stop.lower);
    return theta;
}

/* The angle from theta to the end stop ahead in `direction`, rad, >= 0. */
static inline double angle_to_stop(const Mechanism *m, int direction) {
    return distance_to_stop(&m->params.stop, direction, m->state.theta);
}

double kinetic_energy(const Mechanism *m); /* J */
double stored_energy(const Mechanism *m);  /* J, spring and kinetic energy */

#endif
