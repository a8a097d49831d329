#include "model/friction_table_load.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model/csv_file.h"
#include "model/sampled_curve.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

COMPACT_BEGIN

/* One line of the file. */
typedef struct {
    double v; /* m/s */
    double mu, log_mu;
} FrictionSample;

typedef struct {
    FrictionSample sample[FRICTION_SAMPLES_MAX];
    CurveKnot knot[FRICTION_SAMPLES_MAX];
    size_t count;
} FrictionSamples;

/* ---- the file ---- */

static bool check_sample(const CsvFile *csv, const FrictionSample *sample, size_t k) {
    if (k == 0 && sample->v != 0.0)
        return csv_refuse(csv,
                          "line %zu: v_m_s = %.17g must be 0 in the first line of numbers, which holds the static "
                          "coefficient",
                          csv->line, sample->v);
    if (k > 0 && !(sample->v > sample[-1].v))
        return csv_refuse(csv, "line %zu: v_m_s = %.17g must be > %.17g, that of the line before", csv->line, sample->v,
                          sample[-1].v);
    if (!(sample->mu > 0.0 && sample->mu <= FRICTION_MAX))
        return csv_refuse(csv,
                          "line %zu: mu = %.17g must be > 0 and <= %g; without friction leave out the table and "
                          "set the friction to 0",
                          csv->line, sample->mu, FRICTION_MAX);
    return true;
}

static bool read_samples(CsvFile *csv, FrictionSamples *samples) {
    static const char *const header = "v_m_s,mu";
    if (csv_header(csv, &header, 1) < 0) return false;
    for (samples->count = 0; !csv_at_end(csv); samples->count++) {
        const size_t k = samples->count;
        double value[2];
        if (k == FRICTION_SAMPLES_MAX)
            return csv_refuse(csv, "the table is too long: at most %d points are allowed", FRICTION_SAMPLES_MAX);
        if (!csv_row(csv, 2, "two finite numbers \"v_m_s,mu\", like \"0.01,0.12\"", value)) return false;
        samples->sample[k] = (FrictionSample){value[0], value[1], log(value[1])};
        if (!check_sample(csv, &samples->sample[k], k)) return false;
    }
    return samples->count >= FRICTION_SAMPLES_MIN ||
           csv_refuse(csv, "%zu points, but there must be at least %d", samples->count, FRICTION_SAMPLES_MIN);
}

/* ---- the curve ---- */

/* By powers of t, from value, slope d and second derivative c at both ends. */
static FrictionPiece piece_of(const FrictionSamples *s, size_t j) {
    const double h = s->sample[j + 1].v - s->sample[j].v, rise = s->sample[j + 1].log_mu - s->sample[j].log_mu;
    const double d0 = h * s->knot[j].slope, d1 = h * s->knot[j + 1].slope;
    const double c0 = 0.5 * h * h * s->knot[j].bend, c1 = 0.5 * h * h * s->knot[j + 1].bend;
    const double value = rise - d0 - c0, slope = d1 - d0 - 2.0 * c0, bend = 2.0 * (c1 - c0); /* left to t^3, t^4, t^5 */
    return (FrictionPiece){
        .v = s->sample[j].v,
        .per_width = 1.0 / h,
        .mu = s->sample[j].mu,
        .c = {d0, c0, 10.0 * value - 4.0 * slope + 0.5 * bend, -15.0 * value + 7.0 * slope - bend,
              6.0 * value - 3.0 * slope + 0.5 * bend},
    };
}

/* False if the speeds are so close that a slope overflows. */
static bool fill(FrictionTable *table, FrictionSamples *s) {
    const CurveSamples curve = {&s->sample[0].v, &s->sample[0].log_mu, s->count, sizeof *s->sample / sizeof(double)};
    curve_knots(&curve, true, s->knot);
    double sum = 0.0;
    for (size_t j = 0; j < table->count; j++) {
        table->piece[j] = piece_of(s, j);
        for (int k = 0; k < 5; k++) sum += fabs(table->piece[j].c[k]) * table->piece[j].per_width;
        if (isnan(table->falls_at) && s->sample[j + 1].mu < s->sample[j].mu) table->falls_at = s->sample[j + 1].v;
    }
    return isfinite(sum);
}

static void free_table(FrictionTable *table) {
    if (table) free(table->piece);
    free(table);
}

/* NULL with the reason in the fault of `csv`. */
static FrictionTable *build(const CsvFile *csv, FrictionSamples *s) {
    const size_t size = strlen(csv->path) + 1, last = s->count - 1;
    FrictionTable *table = malloc(sizeof *table + size);
    if (table) {
        *table = (FrictionTable){
            .at_rest = s->sample[0].mu,
            .end = s->sample[last].v,
            .at_end = s->sample[last].mu,
            .falls_at = NAN,
            .count = last,
            .piece = malloc(last * sizeof(FrictionPiece)),
        };
        memcpy(table->path, csv->path, size);
        if (table->piece && fill(table, s)) return table;
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

COMPACT bool friction_tables_load(Params *params, const FrictionTables *now, const char *resources,
                                  FrictionTables *made, Fault *fault) {
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

COMPACT_END
