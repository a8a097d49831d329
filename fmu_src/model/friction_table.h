/* A friction law by samples: the friction coefficient mu over the sliding speed v, and perhaps over the reaction R of one
 * contact, from a CSV file (friction_table_load.h).
 *
 * For each load R_k the samples (v_j, ln mu_jk) are joined by the curve of sampled_curve.h, with d = c = 0 at the last
 * sample:
 *     u_k(v) = ln mu_jk + c_1 t + ... + c_5 t^5    t = (v - v_j)/(v_{j+1} - v_j) in [0, 1)
 * and u_k is constant beyond the last speed. With one load mu = exp(u_0). With more, ln mu over ln R is the natural cubic
 * spline through (ln R_k, u_k(v)), whose second derivatives are linear in u_k, and a straight line beyond the first and
 * the last load: mu continues as a power of R (C. de Boor, A Practical Guide to Splines, chapter IV). So mu is twice
 * continuously differentiable and never negative. Over the speed mu grows or falls nowhere else than the samples do.
 * Third derivatives jump at the samples; collocation steps end there. */
#ifndef DUALCAM_FRICTION_TABLE_H
#define DUALCAM_FRICTION_TABLE_H

#include <stdbool.h>
#include <stddef.h>

#include "model/params.h"
#include "numerics/jet.h"
#include "numerics/vector2.h"

enum { FRICTION_LOADS_MAX = 16 };

/* From one knot to the next: samples over the speed or over the load, in whose unit its fields are. Beyond the last knot
 * the upper knot is infinity. */
typedef struct {
    double lower, upper;
    double beside
        [2]; /* the smaller width of both cells at the lower and at the upper knot; infinity: no step ends there */
} KnotCell;

/* The curve from one sample to the next. Beyond the last sample it is constant, and per_width is 0. */
typedef struct {
    KnotCell cell;     /* m/s */
    double per_width;  /* s/m */
    double mu, log_mu; /* where it starts */
    double c[5];       /* of t, ..., t^5 */
    bool is_flat;      /* from t = -1/4 to t = 5/4 the powers of t add up to a number that vector2_exp_near_0() takes */
} FrictionPiece;

struct FrictionTable {
    size_t count, loads;                 /* of the last speed, the first being 0; number of loads */
    FrictionPiece *piece;                /* owned: count + 1 of the first load, then of the next */
    double *speed;                       /* owned: m/s, count + 1 of them */
    double load[FRICTION_LOADS_MAX + 1]; /* N: 0, then the loads */
    double log_load[FRICTION_LOADS_MAX];
    double bend[FRICTION_LOADS_MAX][FRICTION_LOADS_MAX]; /* second derivative of the spline at load k, per u_l */
    double falls_at; /* m/s, the first sample with a smaller mu than the sample before; NAN: none */
    char path[];     /* of the file */
};

typedef struct {
    double value;
    double by_speed; /* s/m, dmu/dv */
} FrictionCoefficient;

typedef struct {
    double value;
    double by_speed; /* s/m, dmu/dv */
    double by_load;  /* 1/N, dmu/dR */
} LoadedFriction;

/* The greatest index k <= last with knot[k] <= x; 0 for smaller x. */
static inline size_t friction_table_find(const double *knot, size_t last, double x) {
    size_t low = 0;                             /* the index is one of low, ..., low + count - 1 */
    for (size_t count = last + 1; count > 1;) { /* at most 64 turns: `count` halves */
        const size_t half = count / 2;
        low = x >= knot[low + half] ? low + half : low; /* without a branch: the processor cannot predict the branch */
        count -= half;
    }
    return low;
}

/* Of knot k and the next; knot 0 is 0, where no step ends. */
KnotCell friction_table_cell(const double *knot, size_t last, size_t k);

/* mu(0+), at the middle one of the loads */
static inline double friction_table_at_rest(const FrictionTable *table) {
    return table->piece[table->loads / 2 * (table->count + 1)].mu;
}

/* At the middle one of the loads. Below v = 0, at which an iteration may look, the first piece continues for a quarter
 * of its width. */
FrictionCoefficient friction_table_at(const FrictionTable *table, double v);

/* R >= 0, N, of one contact; there is more than one load. Below LEVEL_LOG_FROM of the first load mu levels off. */
LoadedFriction friction_table_under(const FrictionTable *table, double v, double R);

/* mu along a motion with the sliding speed v and the reaction R; with one load R is not used. */
Jet friction_table_along(const FrictionTable *table, const Jet *v, const Jet *R);

/* The share of a change of speed, or of the load, from `from` to `to` after which a step is to end, since a sample lies
 * between both; 1: the step may reach `to`. `overshoot`: share of a piece's width by which a step may pass a sample. */
double friction_table_share(const FrictionTable *table, double overshoot, double from, double to);
double friction_table_load_share(const FrictionTable *table, double overshoot, double from, double to);
/* The same for the load, N, below which a law without a table levels off. */
double friction_level_share(double level, double overshoot, double from, double to);

/* The piece on which a step lies, and the speeds up to which the step may use it. */
typedef struct {
    const FrictionPiece *piece;
    double low, high; /* m/s */
    double aim;       /* m/s, the change of speed at which a longer step is to end; infinity: none */
    double slack;     /* m/s, by which the step may miss the aim */
} FrictionReach;

/* The piece at the speed v; at the middle one of the loads. */
static inline void friction_table_begin(const FrictionTable *table, double v, FrictionReach *reach) {
    const size_t first = table->loads / 2 * (table->count + 1);
    reach->piece = &table->piece[first + friction_table_find(table->speed, table->count, v)];
}

/* The piece of a step from the speed v, and how far the step reaches. `up`: the speed grows. */
void friction_table_reach(double overshoot, double v, bool up, FrictionReach *reach);

#endif
