/* The domain: the mechanisms for which rigid contacts with friction have an answer (docs/mechanism.md, section 3).
 *
 * The map from acceleration and reactions to the loads is continuous and piecewise linear, with determinants in proportion
 * to D(f_1, f_2) = J Delta + m z' P + I gamma' Q. Every load has exactly one answer if, and only if, D > 0 at the four
 * corners f = (+-mu_1, +-mu_2) (coherently oriented piecewise linear map, a P-matrix: R. W. Cottle, J.-S. Pang, R. E. Stone,
 * The Linear Complementarity Problem). D is bilinear in f, so the largest coefficients between the stops suffice. Without
 * inertia dampers take the place of the masses, (J, m, I) -> (b, c, 0); without both Delta > 0 is the test. */
#ifndef DUALCAM_DOMAIN_H
#define DUALCAM_DOMAIN_H

#include <stdbool.h>

#include "geometry/transmission.h"
#include "model/fault.h"
#include "model/params.h"

/* Values of the variable `friction_class`. */
typedef enum {
    FRICTION_CLASS_UNIQUE = 1,      /* one answer to every load */
    FRICTION_CLASS_SELF_LOCKING = 2 /* several answers or none in motion: the rule of forward/decide.h chooses */
} FrictionClass;

/* A torque that loads exists everywhere between the stops: Delta > 0 on the supporting flanks, which is
 * kappa_1 + kappa_2 > 0 at sigma = +1. F_ext: N. False with the reason in `fault`. */
bool domain_check_loading(const Params *params, const Transmission *transmission, double F_ext, Fault *fault);

/* The motion that the torque makes is resisted everywhere: with inertia D > 0 on the pair that loads and on the pair
 * that releases; nowhere level without a shaft that resists. Only forward dynamics needs this. False with the reason,
 * and with a value that works, in `fault`. */
bool domain_check_motion(const Params *params, const Transmission *transmission, double F_ext, Fault *fault);

FrictionClass domain_class(const Params *params, const Transmission *transmission, double F_ext);

#endif
