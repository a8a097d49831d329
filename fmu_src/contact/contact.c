#include "contact/contact.h"

#include <math.h>

#include "contact/contact_factors.h"
#include "platform/attributes.h"

/* dT/dA less rho, where the load changes the signed friction coefficients by df per ln F_0. */
static double rho_by_load(const Geometry *g, const ContactFactors *f, double rho, const double df[2]) {
    const ContactFactors change = contact_factors_change(f, g->radius, g->slope, df);
    return (change.p - rho * change.delta) / f->delta;
}

Transfer contact_transfer(const Geometry *g, int direction, const int flank[2]) {
    ContactFactors f;
    double df[2];
    for (int i = 0; i < 2; i++) {
        const int sign = direction * flank[i];
        contact_factors_set(&f, i, g->radius[i], sign * g->friction[i], g->slope[i]);
        df[i] = sign * g->friction_by_log_load[i];
    }
    contact_factors_multiply(&f);
    const bool regular = f.delta != 0.0, loaded = df[0] != 0.0 || df[1] != 0.0;
    const double inverse = regular ? 1.0 / f.delta : 0.0, rho = f.p * inverse;
    return (Transfer){
        .regular = regular,
        .delta = f.delta,
        .rho = rho,
        .rho_rate = regular && loaded ? rho + rho_by_load(g, &f, rho, df) : rho,
        .rho_kappa1 = f.q * inverse,
        .axial = {f.rn[1] * inverse, f.rn[0] * inverse},
        .moment = {-f.d[1] * inverse, f.d[0] * inverse},
    };
}

/* A pair of flanks carries F > 0 at rest or at constant speed if the reactions have the signs of the flanks. */
static bool carries(const Transfer *t, const int flank[2]) {
    return t->regular && flank[0] * t->axial[0] >= 0.0 && flank[1] * t->axial[1] >= 0.0;
}

/* Loading: both supporting flanks. Releasing: the same, unless only one contact is locked; then the pin bears on the
 * other flank of the contact that is not locked. Both other flanks carry F > 0 only where loading jams. */
static inline bool edge_of(const Geometry *g, int direction, int flank[2], Transfer *transfer) {
    const int candidates = direction > 0 ? 1 : FLANK_PAIR_COUNT - 1;
    for (int k = 0; k < candidates; k++) {
        flank_pair(k, 1, flank);
        *transfer = contact_transfer(g, direction, flank);
        if (carries(transfer, flank)) return true;
    }
    return false;
}

NOINLINE bool contact_edge(const Geometry *g, int direction, int flank[2], Transfer *transfer) {
    return edge_of(g, direction, flank, transfer);
}

NOINLINE BandFactors contact_band(const Geometry *g) {
    int flank[2];
    Transfer t;
    BandFactors band = {.release = 0.0};
    const bool loads = edge_of(g, 1, flank, &t);
    band.load = loads ? t.rho : INFINITY;
    band.load_rate = loads ? t.rho_rate : INFINITY;
    /* both lead angles equal the friction angle: n_1 = n_2 = 0, the torque is 0 at any load */
    if (g->slope[0] == g->friction[0] * g->radius[0] && g->slope[1] == g->friction[1] * g->radius[1]) return band;
    const bool releases = edge_of(g, -1, flank, &t);
    band.release = releases ? t.rho : -INFINITY;
    band.release_rate = releases ? t.rho_rate : -INFINITY;
    return band;
}
