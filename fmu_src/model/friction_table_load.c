#include "model/friction_table_load.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "elementary/elementary.h"
#include "model/csv_file.h"
#include "model/sampled_curve.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"
#include "platform/memory.h"

/* One line of the file. */
typedef struct {
    double v, R; /* m/s, N; R = 0 where the file has no loads */
    double mu, log_mu;
} FrictionSample;

typedef struct {
    FrictionSample sample[FRICTION_SAMPLES_MAX]; /* all of the first load, then of the next */
    CurveKnot knot[FRICTION_SAMPLES_MAX];
    size_t count, speeds, loads;
} FrictionSamples;

/* ---- the file ---- */

/* Of sample n; line 1 is the header. */
static size_t line_of(size_t n) {
    return n + 2;
}

static bool check_mu(const CsvFile *csv, const FrictionSamples *s, size_t n) {
    const double mu = s->sample[n].mu;
    return (mu > 0.0 && mu <= FRICTION_MAX) ||
           csv_refuse(csv,
                      "line %zu: mu = %s must be > 0 and <= %g; without friction leave out the table and set the "
                      "friction to 0",
                      line_of(n), shortest_decimal(mu).text, FRICTION_MAX);
}

/* The first sample of a load. */
static bool check_load(const CsvFile *csv, const FrictionSamples *s, size_t n) {
    const FrictionSample *sample = &s->sample[n];
    if (n == 0)
        return sample->v == 0.0 || csv_refuse(csv,
                                              "line %zu: v_m_s = %s must be 0 in the first line of numbers, which "
                                              "holds the static coefficient",
                                              line_of(n), shortest_decimal(sample->v).text);
    if (sample->v != 0.0)
        return csv_refuse(csv, "line %zu: each load must have the %zu speeds of the first load", line_of(n), s->speeds);
    return sample->R > sample[-1].R ||
           csv_refuse(csv, "line %zu: R_N = %s must be > %s, the load before", line_of(n),
                      shortest_decimal(sample->R).text, shortest_decimal(sample[-1].R).text);
}

/* A later sample of a load. The first load sets the speeds. */
static bool check_speed(const CsvFile *csv, const FrictionSamples *s, size_t n) {
    const FrictionSample *sample = &s->sample[n];
    const double same = s->sample[n % s->speeds].v;
    if (sample->R != sample[-1].R)
        return csv_refuse(csv, "line %zu: R_N = %s must be %s: a load begins with v_m_s = 0 and has all speeds",
                          line_of(n), shortest_decimal(sample->R).text, shortest_decimal(sample[-1].R).text);
    if (!(sample->v > sample[-1].v))
        return csv_refuse(csv, "line %zu: v_m_s = %s must be > %s, that of the line before", line_of(n),
                          shortest_decimal(sample->v).text, shortest_decimal(sample[-1].v).text);
    return sample->v == same ||
           csv_refuse(csv, "line %zu: v_m_s = %s must be %s, the speed that the first load has there", line_of(n),
                      shortest_decimal(sample->v).text, shortest_decimal(same).text);
}

/* Finds the speeds of the first load, and the number of loads. */
static bool find_grid(const CsvFile *csv, FrictionSamples *s, bool with_loads) {
    s->speeds = with_loads && s->count > 0 ? 1 : s->count;
    while (s->speeds < s->count && s->sample[s->speeds].v != 0.0) s->speeds++; /* at most one turn per sample */
    if (s->speeds < s->count && s->speeds < FRICTION_SAMPLES_MIN)
        return csv_refuse(csv, "line %zu: R_N = %s must be %s: a load has all its speeds, at least %d, in turn",
                          line_of(s->speeds), shortest_decimal(s->sample[s->speeds].R).text,
                          shortest_decimal(s->sample[0].R).text, FRICTION_SAMPLES_MIN);
    if (s->speeds < FRICTION_SAMPLES_MIN)
        return csv_refuse(csv, "%zu points, but there must be at least %d", s->speeds, FRICTION_SAMPLES_MIN);
    s->loads = (s->count + s->speeds - 1) / s->speeds;
    if (with_loads && s->loads < 2)
        return csv_refuse(csv, "one load, but there must be at least 2; for one, leave out the column R_N");
    return s->loads <= FRICTION_LOADS_MAX ||
           csv_refuse(csv, "%zu loads: at most %d are allowed", s->loads, FRICTION_LOADS_MAX);
}

static bool check_samples(const CsvFile *csv, FrictionSamples *s, bool with_loads) {
    if (!find_grid(csv, s, with_loads)) return false;
    for (size_t n = 0; n < s->count; n++)
        if (!(n % s->speeds == 0 ? check_load(csv, s, n) : check_speed(csv, s, n)) || !check_mu(csv, s, n))
            return false;
    return s->count == s->speeds * s->loads ||
           csv_refuse(csv, "%zu points, but there must be %zu: each load must have the %zu speeds of the first load",
                      s->count, s->speeds * s->loads, s->speeds);
}

static bool read_samples(CsvFile *csv, FrictionSamples *s) {
    static const char *const header[] = {"v_m_s,mu", "v_m_s,R_N,mu"};
    static const char *const form[] = {"two finite numbers \"v_m_s,mu\", like \"0.01,0.12\"",
                                       "three finite numbers \"v_m_s,R_N,mu\", like \"0.01,100,0.12\""};
    const int with_loads = csv_header(csv, header, 2);
    if (with_loads < 0) return false;
    for (s->count = 0; !csv_at_end(csv); s->count++) { /* at most FRICTION_SAMPLES_MAX turns */
        double value[3];
        if (s->count == FRICTION_SAMPLES_MAX)
            return csv_refuse(csv, "the table is too long: at most %d points are allowed", FRICTION_SAMPLES_MAX);
        if (!csv_row(csv, 2 + with_loads, form[with_loads], value)) return false;
        const double mu = value[1 + with_loads], R = with_loads ? value[1] : 0.0;
        if (with_loads && !(R > 0.0))
            return csv_refuse(csv, "line %zu: R_N = %s must be > 0", csv->line, shortest_decimal(R).text);
        s->sample[s->count] = (FrictionSample){value[0], R, mu, elementary_log(mu)};
    }
    return check_samples(csv, s, with_loads != 0);
}

/* ---- the curve over the speed ---- */

static Vector2 both(double x) {
    return (Vector2){x, x};
}

/* By powers of t, from value, slope d and second derivative c at both ends. */
static FrictionPiece piece_of(const FrictionSamples *s, size_t j) {
    const FrictionSample *a = &s->sample[j], *b = &s->sample[j + 1];
    const double h = b->v - a->v, rise = b->log_mu - a->log_mu;
    const double d0 = h * s->knot[j].slope, d1 = h * s->knot[j + 1].slope;
    const double c0 = 0.5 * h * h * s->knot[j].bend, c1 = 0.5 * h * h * s->knot[j + 1].bend;
    const double value = rise - d0 - c0, slope = d1 - d0 - 2.0 * c0, bend = 2.0 * (c1 - c0); /* left to t^3, t^4, t^5 */
    const double c[5] = {d0, c0, 10.0 * value - 4.0 * slope + 0.5 * bend, -15.0 * value + 7.0 * slope - bend,
                         6.0 * value - 3.0 * slope + 0.5 * bend};
    FrictionPiece piece = {
        .lower = both(a->v),
        .per_width = both(1.0 / h),
        .mu = both(a->mu),
        .log_mu = a->log_mu,
    };
    double most = 0.0;
    for (int n = 4; n >= 0; n--) {
        most = 1.25 * (fabs(c[n]) + most);
        piece.c[n] = both(c[n]);
    }
    piece.is_flat = most <= OF_TWO_EXP_SMALL;
    return piece;
}

/* Of load k. False if the speeds are so close that a slope overflows. */
static bool fill_load(FrictionTable *table, FrictionSamples *s, size_t k) {
    const size_t first = k * s->speeds;
    const FrictionSample *sample = &s->sample[first];
    const CurveSamples curve = {&sample->v, &sample->log_mu, s->speeds, sizeof *sample / sizeof(double)};
    curve_knots(&curve, true, &s->knot[first]);
    double sum = 0.0;
    FrictionPiece *const pieces = &table->piece[k * (table->count + 1)];
    for (size_t j = 0; j < table->count; j++) {
        const FrictionPiece piece = pieces[j] = piece_of(s, first + j);
        pieces[j].cell = friction_table_cell(table->speed, table->count, j);
        for (int n = 0; n < 5; n++) sum += fabs(piece.c[n][0]) * piece.per_width[0];
    }
    for (size_t j = 0; j <= table->count; j++) table->largest = max_of(table->largest, sample[j].mu);
    const FrictionSample *end = &sample[table->count];
    pieces[table->count] = (FrictionPiece){.cell = friction_table_cell(table->speed, table->count, table->count),
                                           .lower = both(end->v),
                                           .mu = both(end->mu),
                                           .log_mu = end->log_mu,
                                           .is_flat = true};
    return isfinite(sum);
}

/* ---- the spline over the load ---- */

/* The second derivatives M of the cubic spline through values u at the points x are linear in u:
 *     h_{k-1} M_{k-1} + 2 (h_{k-1} + h_k) M_k + h_k M_{k+1} = 6 ((u_{k+1} - u_k)/h_k - (u_k - u_{k-1})/h_{k-1})
 * Slope zero at an end leaves out what lies beyond the end. Elimination without pivots, for the system is dominated by its
 * diagonal. */
static void fill_bends(FrictionTable *table) {
    const double *x = table->log_load;
    const size_t last = table->loads - 1;
    double diagonal[FRICTION_LOADS_MAX];
    for (size_t k = 0; k <= last; k++) { /* at most one turn per load */
        const double below = k > 0 ? x[k] - x[k - 1] : 0.0, above = k < last ? x[k + 1] - x[k] : 0.0;
        double *row = table->bend[k];
        if (k > 0) row[k - 1] = 6.0 / below;
        if (k < last) row[k + 1] = 6.0 / above;
        row[k] = (k > 0 ? -6.0 / below : 0.0) - (k < last ? 6.0 / above : 0.0);
        diagonal[k] = 2.0 * (below + above);
        if (k == 0) continue;
        const double factor = below / diagonal[k - 1];
        diagonal[k] -= factor * below;
        for (size_t l = 0; l <= last; l++) row[l] -= factor * table->bend[k - 1][l];
    }
    for (size_t k = last + 1; k-- > 0;) { /* at most one turn per load */
        const double above = k < last ? x[k + 1] - x[k] : 0.0;
        for (size_t l = 0; l <= last; l++)
            table->bend[k][l] = (table->bend[k][l] - (k < last ? above * table->bend[k + 1][l] : 0.0)) / diagonal[k];
    }
}

/* Adds `factor` times u_k, or the second derivative of the spline at load k, as powers of t. */
static void add_curve(const FrictionTable *table, size_t k, size_t j, double factor, double c[6]) {
    const FrictionPiece *p = &table->piece[k * (table->count + 1) + j];
    c[0] += factor * p->log_mu;
    for (int n = 0; n < 5; n++) c[n + 1] += factor * p->c[n][0];
}

static void add_bend(const FrictionTable *table, size_t k, size_t j, double factor, double c[6]) {
    for (size_t l = 0; l < table->loads; l++) add_curve(table, l, j, factor * table->bend[k][l], c);
}

/* From load k to load k + 1: the spline by powers of b. */
static void fill_patch(FrictionTable *table, size_t k, size_t j) {
    double c[4][6] = {{0.0}};
    const double *x = table->log_load, h = x[k + 1] - x[k], sixth = h * h / 6.0;
    add_curve(table, k, j, 1.0, c[0]);
    add_curve(table, k + 1, j, 1.0, c[1]);
    add_curve(table, k, j, -1.0, c[1]);
    add_bend(table, k, j, -2.0 * sixth, c[1]);
    add_bend(table, k + 1, j, -sixth, c[1]);
    add_bend(table, k, j, 3.0 * sixth, c[2]);
    add_bend(table, k + 1, j, sixth, c[3]);
    add_bend(table, k, j, -sixth, c[3]);
    FrictionPatch *patch = &table->patch[j * (table->loads - 1) + k];
    patch->from = both(x[k]);
    patch->per = both(1.0 / h);
    patch->low = both(k > 0 ? -0.25 : 0.0);
    patch->high = both(k + 2 < table->loads ? 1.25 : 1.0);
    for (int m = 0; m < 4; m++)
        for (int n = 0; n < 6; n++) patch->c[m][n] = both(c[m][n]);
}

static void fill_patches(FrictionTable *table) {
    const size_t intervals = table->loads - 1;
    for (size_t k = 0; k < intervals; k++)
        for (size_t j = 0; j <= table->count; j++) fill_patch(table, k, j);
}

/* The load may change mu by a power between -FRICTION_LOAD_POWER and that: as the load exponent of the analytic law. */
static bool check_powers(const CsvFile *csv, const FrictionSamples *s) {
    for (size_t n = s->speeds; n < s->count; n++) {
        const FrictionSample *a = &s->sample[n - s->speeds], *b = &s->sample[n];
        const double power = (b->log_mu - a->log_mu) / elementary_log(b->R / a->R);
        if (!(fabs(power) <= FRICTION_LOAD_POWER))
            return csv_refuse(csv,
                              "at v_m_s = %s mu goes with the power %.3g of the load from R_N = %s to %s: "
                              "allowed are powers from %g to %g",
                              shortest_decimal(a->v).text, power, shortest_decimal(a->R).text,
                              shortest_decimal(b->R).text, -FRICTION_LOAD_POWER, FRICTION_LOAD_POWER);
    }
    return true;
}

static bool fill(FrictionTable *table, FrictionSamples *s) {
    for (size_t j = 0; j < s->speeds; j++) table->speed[j] = s->sample[j].v;
    for (size_t k = 0; k < s->loads; k++) {
        if (!fill_load(table, s, k)) return false;
        table->load[k + 1] = s->sample[k * s->speeds].R;
        table->log_load[k] = s->loads > 1 ? elementary_log(table->load[k + 1]) : 0.0;
    }
    table->middle = &table->piece[s->loads / 2 * s->speeds];
    table->at_rest = table->middle->mu[0];
    if (s->loads > 1) {
        fill_bends(table);
        fill_patches(table);
    }
    return true;
}

static void free_table(FrictionTable *table) {
    if (!table) return;
    memory_free(table->piece);
    memory_free(table->patch);
    free(table->speed);
    free(table);
}

/* NULL with the reason in the fault of `csv`. */
static FrictionTable *build(const CsvFile *csv, FrictionSamples *s) {
    if (!check_powers(csv, s)) return NULL;
    const size_t size = strlen(csv->path) + 1, count = s->speeds - 1;
    FrictionTable *table = malloc(sizeof *table + size);
    if (table) {
        *table = (FrictionTable){
            .count = count,
            .loads = s->loads,
            .piece = memory_new(s->count * sizeof(FrictionPiece)),
            .patch = memory_new((s->count - s->speeds) * sizeof(FrictionPatch)),
            .speed = malloc(s->speeds * sizeof(double)),
        };
        memcpy(table->path, csv->path, size);
        if (table->piece && table->patch && table->speed && fill(table, s)) return table;
    }
    free_table(table);
    csv_refuse(csv, "no curve through these points: the speeds must not be so close that slopes overflow, nor the "
                    "memory short");
    return NULL;
}

COLD static FrictionTable *read_table(const char *path, const char *resources, int number, Fault *fault) {
    char variable[24];
    snprintf(variable, sizeof variable, "cam%d.friction_table", number);
    CsvFile csv;
    if (!csv_open(&csv, path, resources, variable, fault)) return NULL;
    FrictionSamples *samples = malloc(sizeof *samples);
    FrictionTable *table = NULL;
    if (!samples) csv_refuse(&csv, "not enough memory to read it, %zu bytes must be available", sizeof *samples);
    else if (read_samples(&csv, samples)) table = build(&csv, samples);
    free(samples);
    csv_close(&csv);
    return table;
}

/* ---- both cams ---- */

/* Frees the tables that the other ones do not hold. */
static void free_unless_in(const FrictionTables *kept, FrictionTables *tables) {
    for (int i = 0; i < 2; i++)
        if (tables->table[i] != kept->table[i]) free_table(tables->table[i]);
}

bool friction_tables_load(Params *params, const FrictionTables *now, const char *resources, FrictionTables *made,
                          Fault *fault) {
    *made = (FrictionTables){.table = {NULL, NULL}};
    for (int i = 0; i < 2; i++) {
        const char *path = params->friction_table[i];
        if (path[0] == '\0') continue;
        const bool is_known = now->table[i] && strcmp(now->table[i]->path, path) == 0;
        made->table[i] = is_known ? now->table[i] : read_table(path, resources, i + 1, fault);
        if (made->table[i]) continue;
        free_unless_in(now, made);
        return false;
    }
    for (int i = 0; i < 2; i++) params->cam[i].law.table = made->table[i];
    return true;
}

void friction_tables_settle(Params *params, FrictionTables *now, FrictionTables *made, bool accepted) {
    free_unless_in(accepted ? made : now, accepted ? now : made);
    if (accepted) *now = *made;
    for (int i = 0; i < 2; i++) params->cam[i].law.table = now->table[i];
}

void friction_tables_free(FrictionTables *tables) {
    for (int i = 0; i < 2; i++) {
        free_table(tables->table[i]);
        tables->table[i] = NULL;
    }
}
