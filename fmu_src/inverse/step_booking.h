/* How a step of inverse dynamics fills the ledger: work and heat are integrated along the motion. */
#ifndef DUALCAM_STEP_BOOKING_H
#define DUALCAM_STEP_BOOKING_H

#include "inverse/inverse_state.h"
#include "numerics/quadrature.h"

/* An empty quadrature at the tolerance of m->params; its peaks begin at those of `ledger`. */
Quadrature step_booking_begin(const Inverse *m, const Ledger *ledger);

/* Adds the integrals and sets the peaks. `into_shaft`: J that the elastic shaft stores in this step. */
void step_booking_finish(const Inverse *m, const Quadrature *quadrature, double into_shaft, Ledger *ledger);

#endif
