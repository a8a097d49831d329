#include "contact/contact.h"

#include <math.h>

#include "contact/contact_factors.h"
#include "platform/attributes.h"

Transfer contact_transfer(const Geometry *g, int direction, const int flank[2]) {
    ContactFactors f;
    for (int i = 0; i < 2; i++)
        contact_factors_set(&f, i, g->radius[i], direction * flank[i] * g->friction[i], g->slope[i]);
    contact_factors_multiply(&f);
    const bool regular = f.delta != 0.0;
    const double inverse = regular ? 1.0 / f.delta : 0.0;
    return (Transfer){
        .regular = regular,
        .settles = f.delta > 0.0,
        .rho = f.p * inverse,
        .rho_rate = f.p * inverse,
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
    band.load = band.load_rate = edge_of(g, 1, flank, &t) ? t.rho : INFINITY;
    /* both lead angles equal the friction angle: n_1 = n_2 = 0, the torque is 0 at any load */
    if (g->slope[0] == g->friction[0] * g->radius[0] && g->slope[1] == g->friction[1] * g->radius[1]) return band;
    band.release = band.release_rate = edge_of(g, -1, flank, &t) ? t.rho : -INFINITY;
    return band;
}
