#include "geometry/groove_csv.h"

#include <stdlib.h>

#include "model/csv_file.h"
#include "platform/attributes.h"

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
