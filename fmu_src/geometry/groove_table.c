#include "geometry/groove_table.h"

#include <math.h>
#include <stdlib.h>

#include "elementary/elementary.h"
#include "model/csv_file.h"
#include "model/sampled_curve.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- the file ---- */

static const char *const HEADER = "psi_rad,z_m";

static bool is_in_order(const CsvFile *csv, Sample before, Sample sample) {
    if (!(sample.psi > before.psi))
        return csv_refuse(csv, "line %zu: psi_rad = %s must be > %s, that of the line before", csv->line,
                          shortest_decimal(sample.psi).text, shortest_decimal(before.psi).text);
    if (!(sample.z >= before.z))
        return csv_refuse(csv, "line %zu: z_m = %s must be >= %s, that of the line before", csv->line,
                          shortest_decimal(sample.z).text, shortest_decimal(before.z).text);
    return true;
}

/* Reads all lines after the header. samples->sample has space for SAMPLES_MAX samples. */
static bool read_samples(CsvFile *csv, Samples *samples) {
    while (!csv_at_end(csv)) { /* at most one turn per character of the file */
        const size_t k = samples->count;
        if (k == SAMPLES_MAX)
            return csv_refuse(csv, "the table is too long: at most %d points are allowed", SAMPLES_MAX);
        double value[2];
        if (!csv_row(csv, 2, "two finite numbers \"psi_rad,z_m\", like \"0.25,0.005\"", value)) return false;
        samples->sample[k] = (Sample){value[0], value[1]};
        if (k > 0 && !is_in_order(csv, samples->sample[k - 1], samples->sample[k])) return false;
        samples->count++;
    }
    return true;
}

static bool check_whole(const CsvFile *csv, const Samples *samples) {
    if (samples->count < SAMPLES_MIN)
        return csv_refuse(csv, "%zu points, but there must be at least %d", samples->count, SAMPLES_MIN);
    const double first = samples->sample[0].psi, last = samples->sample[samples->count - 1].psi;
    if (!(first <= 0.0 && last >= 0.0))
        return csv_refuse(csv, "psi_rad goes from %s to %s, but it must include 0, from where z counts",
                          shortest_decimal(first).text, shortest_decimal(last).text);
    return true;
}

static bool parse(CsvFile *csv, Samples *samples) {
    if (csv_header(csv, &HEADER, 1) < 0) return false;
    samples->sample = malloc(SAMPLES_MAX * sizeof samples->sample[0]);
    if (!samples->sample) return csv_refuse(csv, "not enough memory for it, fewer points must do");
    return read_samples(csv, samples) && check_whole(csv, samples);
}

COLD bool samples_read(Samples *samples, const char *path, const char *resources, const char *variable, Fault *fault) {
    *samples = (Samples){.sample = NULL};
    CsvFile csv = {.variable = variable, .path = path, .fault = fault};
    if (path[0] == '\0') return csv_refuse(&csv, "a table profile must name a CSV file");
    if (!csv_open(&csv, path, resources, variable, fault)) return false;
    const bool good = parse(&csv, samples);
    csv_close(&csv);
    if (!good) samples_free(samples);
    return good;
}

void samples_free(Samples *samples) {
    free(samples->sample);
    *samples = (Samples){.sample = NULL};
}

/* ---- the curve ---- */

static CurveSamples curve_of(const Samples *s) {
    return (CurveSamples){&s->sample[0].psi, &s->sample[0].z, s->count, sizeof(Sample) / sizeof(double)};
}

static TablePiece piece_of(const Samples *s, size_t j, const CurveKnot *knot) {
    const CurveSamples curve = curve_of(s);
    const double h = curve_width(&curve, j);
    const CurveKnot a = knot[j], b = knot[j + 1];
    /* each coefficient is >= 0 by the rule; fmax removes its rounding */
    return (TablePiece){
        .psi = s->sample[j].psi,
        .width = h,
        .z = s->sample[j].z,
        .slope = {a.slope, max_of(a.slope + a.bend * h / 4.0, 0.0),
                  max_of(5.0 * curve_chord(&curve, j) - curve_end_sum(h, a, b), 0.0),
                  max_of(b.slope - b.bend * h / 4.0, 0.0), b.slope},
    };
}

static bool is_finite_piece(const TablePiece *p) {
    double sum = p->width + p->z;
    for (int k = 0; k < 5; k++) sum += p->slope[k];
    return isfinite(sum) && isfinite(4.0 * sum / p->width);
}

enum { PIECE_DOUBLES = sizeof(TablePiece) / sizeof(double) };

static const TablePiece *find(const Table *table, double psi) {
    return &table->piece[curve_interval(&table->piece->psi, PIECE_DOUBLES, table->count, psi)];
}

/* The rise since the start of the piece, and derivatives, at the share t of its width. Slope and rise are sums of terms
 * >= 0: they do not cancel, and the slope is not negative. */
static GroovePoint piece_value(const TablePiece *p, double t) {
    const double *b = p->slope;
    const double u = 1.0 - t, tt = t * t, uu = u * u, ut = u * t;
    const double slope = uu * (uu * b[0] + 4.0 * ut * b[1]) + 6.0 * ut * ut * b[2] + tt * (4.0 * ut * b[3] + tt * b[4]);
    const double dslope_dpsi = 4.0 * (uu * u * (b[1] - b[0]) + 3.0 * ut * u * (b[2] - b[1]) +
                                      3.0 * ut * t * (b[3] - b[2]) + tt * t * (b[4] - b[3]));
    const double s1 = b[0], s2 = s1 + b[1], s3 = s2 + b[2], s4 = s3 + b[3], s5 = s4 + b[4];
    const double rise =
        t * (uu * (5.0 * uu * s1 + 10.0 * ut * s2) + tt * (10.0 * uu * s3 + 5.0 * ut * s4 + tt * s5)) / 5.0;
    return (GroovePoint){rise * p->width, slope, dslope_dpsi / p->width};
}

/* Makes z exactly 0 at psi = 0. */
static void shift_to_origin(Table *table) {
    const TablePiece *home = find(table, 0.0);
    const double offset = home->z, rise = piece_value(home, -home->psi / home->width).z;
    for (size_t j = 0; j < table->count; j++) table->piece[j].z = (table->piece[j].z - offset) - rise;
}

static bool fill(Table *table, const Samples *samples, CurveKnot *knot) {
    const CurveSamples curve = curve_of(samples);
    curve_knots(&curve, false, knot);
    for (size_t j = 0; j < table->count; j++) {
        table->piece[j] = piece_of(samples, j, knot);
        if (!is_finite_piece(&table->piece[j])) return false;
    }
    shift_to_origin(table);
    return true;
}

bool table_build(Table *table, const Samples *samples) {
    CurveKnot *knot = malloc(samples->count * sizeof *knot);
    *table = (Table){.piece = malloc((samples->count - 1) * sizeof(TablePiece)), .count = samples->count - 1};
    const bool good = knot && table->piece && fill(table, samples, knot);
    free(knot);
    if (!good) table_free(table);
    return good;
}

void table_free(Table *table) {
    free(table->piece);
    *table = (Table){.piece = NULL};
}

GroovePoint table_at(const Table *table, double psi) {
    const TablePiece *p = find(table, psi);
    GroovePoint point = piece_value(p, (psi - p->psi) / p->width);
    point.z += p->z;
    return point;
}

/* Newton's method inside a bracket, with bisection where the curve is too flat for Newton's method. */
double table_angle(const Table *table, double z) {
    const TablePiece *p = &table->piece[curve_interval(&table->piece->z, PIECE_DOUBLES, table->count, z)];
    double low = 0.0, high = 1.0, t = 0.5;
    for (int i = 0; i < BRACKET_ITERATIONS; i++) {
        const GroovePoint point = piece_value(p, t);
        const double excess = p->z + point.z - z;
        if (excess == 0.0) break;
        if (excess < 0.0) low = t;
        else high = t;
        double next = t - excess / (point.slope * p->width);
        if (!(next > low && next < high)) next = low + 0.5 * (high - low);
        if (fabs(next - t) <= TABLE_ROUNDING) break;
        t = next;
    }
    return p->psi + t * p->width;
}
