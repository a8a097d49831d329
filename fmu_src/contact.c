#include "contact.h"

#include <math.h>

Transfer contact_transfer(const Geometry *g, int direction, const int flank[2]) {
    double n[2], d[2];
    for (int i = 0; i < 2; i++) {
        const double mu = direction * flank[i] * g->friction[i];
        n[i] = g->slope[i] + mu * g->radius[i];
        d[i] = g->radius[i] - mu * g->slope[i];
    }
    const double rn[2] = {g->radius[0] * n[0], g->radius[1] * n[1]};
    const double delta = rn[1] * d[0] + rn[0] * d[1];
    const bool regular = delta != 0.0;
    const double inverse = regular ? 1.0 / delta : 0.0;
    return (Transfer){
        .regular = regular,
        .rho = rn[0] * rn[1] * inverse,
        .rho_kappa1 = d[0] * rn[1] * inverse,
        .axial = {rn[1] * inverse, rn[0] * inverse},
        .twist = {-d[1] * inverse, d[0] * inverse},
    };
}

/* A pair of flanks carries F > 0 at rest or at constant speed if both reactions have its signs. */
static bool carries(const Transfer *t, const int flank[2]) {
    return t->regular && flank[0] * t->axial[0] >= 0.0 && flank[1] * t->axial[1] >= 0.0;
}

static double load_factor(const Geometry *g) {
    static const int supporting[2] = {1, 1};
    const Transfer t = contact_transfer(g, 1, supporting);
    return carries(&t, supporting) ? t.rho : INFINITY;
}

/* Releasing against F > 0. Both supporting flanks, unless one contact locks and the other does not:
 * then the unlocked pin bears on its other flank. */
static double release_factor(const Geometry *g) {
    /* both lead angles exactly at the friction angle: n_1 = n_2 = 0, no torque at any load */
    if (g->slope[0] == g->friction[0] * g->radius[0] && g->slope[1] == g->friction[1] * g->radius[1]) return 0.0;
    static const int candidate[3][2] = {{1, 1}, {1, -1}, {-1, 1}};
    for (int k = 0; k < 3; k++) {
        const Transfer t = contact_transfer(g, -1, candidate[k]);
        if (carries(&t, candidate[k])) return t.rho;
    }
    return -INFINITY;
}

BandFactors contact_band(const Geometry *g) {
    return (BandFactors){.load = load_factor(g), .release = release_factor(g)};
}
