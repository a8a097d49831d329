/* A friction law by samples: the friction coefficient mu over the sliding speed v, and perhaps over the nominal load N of
 * one contact (friction_law.h), from a CSV file (friction_table_load.h).
 *
 * For each load N_k the samples (v_j, ln mu_jk) are joined by the curve of sampled_curve.h, with d = c = 0 at the last
 * sample:
 *     u_k(v) = ln mu_jk + c_1 t + ... + c_5 t^5    t = (v - v_j)/(v_{j+1} - v_j) in [0, 1)
 * and u_k is constant beyond the last speed. With one load mu = exp(u_0). With more, ln mu over ln N is the cubic spline
 * through (ln N_k, u_k(v)) with slope zero at the first and the last load (C. de Boor, A Practical Guide to Splines, chapter
 * IV), and constant beyond. Higher derivatives jump at the samples; collocation steps end there. */
#ifndef DUALCAM_FRICTION_TABLE_H
#define DUALCAM_FRICTION_TABLE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "elementary/vector2.h"
#include "model/params.h"
#include "model/sampled_curve.h"
#include "numerics/jet.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

enum { FRICTION_LOADS_MAX = 16 };

/* From one knot to the next: samples over the speed or over the load, in whose unit its fields are. Beyond the last
 * knot the upper knot is infinity. */
typedef struct {
    double lower;
    double ahead[2]; /* where a step down or up is to end: the knots; -infinity in place of knot 0 */
    double beside
        [2]; /* the smaller width of both cells at the lower and at the upper knot; infinity: no step ends there */
} KnotCell;

/* The curve from one sample to the next. Beyond the last sample it is constant, and per_width is 0. A vector holds the
 * same number twice: no step has to spread the number. */
typedef struct {
    Vector2 c[5];             /* of t, ..., t^5 */
    Vector2 lower, per_width; /* m/s, s/m */
    Vector2 mu;               /* where the curve starts */
    KnotCell cell;            /* m/s */
    double log_mu;            /* where the curve starts */
    bool is_flat; /* from t = -1/4 to t = 5/4 the powers of t add up to a number that vector2_exp_small() takes */
} FrictionPiece;

/* ln mu on one piece of the speed from one load to the next: sum_m b^m sum_n c[m][n] t^n with b = (ln N - from) per. An
 * iteration may look at b from `low` to `high`: beyond the first and the last load b stays. */
typedef struct {
    Vector2 c[4][6];
    Vector2 from, per, low, high;
} FrictionPatch;

struct FrictionTable {
    size_t count, loads;                 /* of the last speed, the first being 0; number of loads */
    FrictionPiece *piece;                /* owned: count + 1 of the first load, then of the next */
    const FrictionPiece *middle;         /* the first one of the middle one of the loads */
    double *speed;                       /* owned: m/s, count + 1 of them */
    double load[FRICTION_LOADS_MAX + 1]; /* N: 0, then the loads */
    double log_load[FRICTION_LOADS_MAX];
    double bend[FRICTION_LOADS_MAX][FRICTION_LOADS_MAX]; /* second derivative of the spline at load k, per u_l */
    FrictionPatch *patch; /* owned; only with more than one load: loads - 1 of the first piece, then of the next */
    double at_rest;       /* mu(0+), at the middle one of the loads */
    double largest;       /* mu of a sample */
    char path[];          /* of the file */
};

typedef struct {
    double value;
    double by_speed; /* s/m, dmu/dv */
    double by_load;  /* 1/N, dmu/dN */
} FrictionCoefficient;

/* The piece at the speed v; at the middle one of the loads. */
static inline const FrictionPiece *friction_table_piece(const FrictionTable *table, double v) {
    return &table->middle[curve_interval(table->speed, 1, table->count + 1, v)];
}

/* The span of the load N, which lasts to the next load; beyond the loads the first or the last one. */
static inline size_t friction_table_span(const FrictionTable *table, double N) {
    return curve_interval(table->load + 1, 1, table->loads - 1, N);
}

static inline const FrictionPatch *friction_table_patch(const FrictionTable *table, const FrictionPiece *piece,
                                                        size_t span) {
    return &table->patch[(size_t)(piece - table->middle) * (table->loads - 1) + span];
}

/* Of knot k and the next; knot 0 is 0, where no step ends. */
KnotCell friction_table_cell(const double *knot, size_t last, size_t k);

/* N >= 0, N, of one contact. Below v = 0, at which an iteration may look, the first piece continues for a quarter of
 * its width. */
FrictionCoefficient friction_table_at(const FrictionTable *table, double v, double N);

/* mu along a motion with the sliding speed v and the square of the nominal load; with one load that is not used. */
Jet friction_table_along(const FrictionTable *table, const Jet *v, const Jet *load2);

/* The share of a change of speed, or of the load, from `from` to `to` after which a step is to end, since a sample lies
 * between both; 1: the step may reach `to`. `overshoot`: share of a piece's width by which a step may pass a sample. */
double friction_table_share(const FrictionTable *table, double overshoot, double from, double to);
double friction_table_load_share(const FrictionTable *table, double overshoot, double from, double to);

/* How far steps go from places x in two cells, both up or both down. */
typedef struct {
    Vector2 distance;      /* to the knot ahead */
    Vector2 beyond;        /* by which a step may pass that knot; infinity: no step ends there */
    Vector2 longest, back; /* the distance that a step may reach, and the other way */
} KnotSteps;

/* A step ends at the knot ahead, or halfway where the knot is far. */
ALWAYS_INLINE static inline KnotSteps knot_steps(const KnotCell *a, const KnotCell *b, double overshoot, Vector2 x,
                                                 bool up) {
    const Vector2 lower = {a->lower, b->lower}, upper = {a->ahead[1], b->ahead[1]}, down = {a->ahead[0], b->ahead[0]};
    const Vector2 ahead = {a->beside[up], b->beside[up]}, behind = {a->beside[!up], b->beside[!up]};
    const Vector2 most = FRICTION_SPAN * (upper - lower), far = FRICTION_SPAN_SLACK * most;
    const Vector2 d = up ? upper - x : x - down, other_way = up ? x - lower : upper - x;
    KnotSteps out = {d, overshoot * ahead, {0.0, 0.0}, vector2_min(most, vector2_abs(other_way) + overshoot * behind)};
    const Vector2 half = FRICTION_SPAN_SLACK * (0.5 * d), passes = d + out.beyond;
    out.longest = (Vector2){d[0] > far[0] ? half[0] : passes[0], d[1] > far[1] ? half[1] : passes[1]};
    return out;
}

/* Negative where a step starts so close to the knot ahead that a step before has reached the knot. NaN beyond the last
 * knot. */
static inline Vector2 knot_margins(const KnotSteps *step) {
    return vector2_abs(step->distance) - FRICTION_REACHED * step->beyond;
}

static inline bool knot_is_reached(const KnotSteps *step, int k) {
    return knot_margins(step)[k] < 0.0;
}

/* The distance at which a longer step is to end: at the knot, the middle of what the step may pass. */
static inline double knot_aim(const KnotSteps *step, int k) {
    const double distance = step->distance[k];
    return step->longest[k] < distance ? 0.5 * distance : distance + 0.5 * step->beyond[k];
}

#endif
