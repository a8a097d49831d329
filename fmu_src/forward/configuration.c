#include "forward/configuration.h"

#include "platform/attributes.h"

NOINLINE void update_curved_configuration(Mechanism *m) {
    const Transmission *transmission = &m->model.transmission;
    const double theta = m->state.theta.hi;
    const TransmissionPoint point = piece_point(transmission_piece(transmission, theta, 0), theta, TRANSMISSION_SLOPES);
    m->configuration.geometry = cam_geometry(m->params.cam, point.slope);
    m->configuration.z = point.z;
}

double kinetic_energy(const Mechanism *m) {
    const Geometry *g = &m->configuration.geometry;
    return kinetic_energy_of(&m->params.inertia, g->dz_dtheta, g->dpsi_dtheta[0], m->state.omega.hi);
}

double stored_energy(const Mechanism *m) {
    return spring_energy(&m->params.spring, m->configuration.z) + kinetic_energy(m);
}
