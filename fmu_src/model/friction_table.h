/* A friction law by samples: the friction coefficient mu over the sliding speed v, from a CSV file.
 *
 * The samples (v_j, ln mu_j) are joined by the curve of sampled_curve.h, with d = c = 0 at the last sample:
 *     mu(v) = mu_j exp(c_1 t + ... + c_5 t^5)    t = (v - v_j)/(v_{j+1} - v_j) in [0, 1)
 * and mu(v) = mu_n beyond the last speed v_n. So mu is twice continuously differentiable and never negative, and lies
 * between the samples on both sides: mu grows or falls nowhere else than the samples do. Third derivatives jump at the
 * samples; collocation steps end there. friction_table_load.h reads the file. */
#ifndef DUALCAM_FRICTION_TABLE_H
#define DUALCAM_FRICTION_TABLE_H

#include <stdbool.h>
#include <stddef.h>

#include "model/params.h"
#include "numerics/jet.h"

/* The curve from one sample to the next; 64 bytes. */
typedef struct {
    double v;         /* m/s, where it starts */
    double per_width; /* s/m */
    double mu;        /* where it starts */
    double c[5];      /* of t, ..., t^5 */
} FrictionPiece;

struct FrictionTable {
    double at_rest;       /* mu(0+) */
    double end;           /* m/s, the last speed */
    double at_end;        /* mu at the last speed and beyond */
    double falls_at;      /* m/s, the first sample with a smaller mu than the sample before; NAN: none */
    size_t count;         /* of pieces */
    FrictionPiece *piece; /* owned */
    char path[];          /* of the file */
};

typedef struct {
    double value;
    double by_speed; /* s/m, dmu/dv */
} FrictionCoefficient;

/* Below v = 0, at which an iteration may look, the first piece continues for a quarter of its width. */
FrictionCoefficient friction_table_at(const FrictionTable *table, double v);

/* mu along a motion with the sliding speed v. */
Jet friction_table_along(const FrictionTable *table, const Jet *v);

/* The share of a change of speed from v to `to` after which a step is to end, since a sample lies between both; 1: the
 * step may reach `to`. `overshoot`: share of a piece's width by which a step may pass a sample. */
double friction_table_share(const FrictionTable *table, double overshoot, double v, double to);

#endif
