#include "geometry/groove.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "elementary/elementary.h"
#include "model/csv_file.h"

/* ---- helix ---- */

static bool build_helix(Groove *groove, const GrooveSource *source, Fault *fault) {
    (void)fault;
    groove->parameter = "lead_angle";
    groove->size = source->cam->lead_angle;
    groove->gain = source->cam->radius * elementary_tan(groove->size);
    groove->first = -INFINITY;
    groove->last = INFINITY;
    return true;
}

static GroovePoint helix_at(const Groove *groove, double psi) {
    return (GroovePoint){groove->gain * psi, groove->gain, 0.0};
}

static double helix_angle(const Groove *groove, double z) {
    return groove->gain > 0.0 ? z / groove->gain : 0.0;
}

static const GrooveLaw HELIX = {"helical", "", build_helix, helix_at, helix_angle};

/* ---- table ---- */

static bool build_table(Groove *groove, const GrooveSource *source, Fault *fault) {
    char variable[16];
    snprintf(variable, sizeof variable, "cam%d.table", source->number);
    Samples samples;
    if (!samples_read(&samples, source->path, source->resources, variable, fault)) return false;
    const size_t size = strlen(source->path) + 1;
    groove->path = malloc(size);
    const bool good = groove->path != NULL && table_build(&groove->table, &samples);
    if (good) {
        memcpy(groove->path, source->path, size);
        groove->first = samples.sample[0].psi;
        groove->last = samples.sample[samples.count - 1].psi;
    } else {
        snprintf(fault->text, sizeof fault->text,
                 "%s = \"%.*s\": no curve through these points: they must not be so close that slopes "
                 "overflow, nor too many for the memory there is",
                 variable, csv_quoted(source->path, QUOTED_PATH), source->path);
        groove_free(groove);
    }
    samples_free(&samples);
    return good;
}

static GroovePoint sampled_at(const Groove *groove, double psi) {
    return table_at(&groove->table, psi);
}

static double sampled_angle(const Groove *groove, double z) {
    return table_angle(&groove->table, z);
}

static const GrooveLaw TABLE = {"sampled", "the samples must reach as far as the stops", build_table, sampled_at,
                                sampled_angle};

/* ---- all laws ---- */

static const GrooveLaw *const LAW[] = {
    [PROFILE_HELIX] = &HELIX,
    [PROFILE_ELLIPSE] = &GROOVE_ELLIPSE,
    [PROFILE_TABLE] = &TABLE,
    [PROFILE_CYCLOID] = &GROOVE_CYCLOID,
};

bool groove_build(Groove *groove, const Params *p, int number, const char *resources, Fault *fault) {
    const GrooveSource source = {&p->cam[number - 1], number, p->table[number - 1], resources};
    const int profile = source.cam->profile;
    if (profile < PROFILE_HELIX || profile > PROFILE_CYCLOID) {
        snprintf(fault->text, sizeof fault->text,
                 "cam%d.profile = %d: allowed are 1 (helix), 2 (ellipse), 3 (table) and 4 (cycloid)", number, profile);
        return false;
    }
    *groove = (Groove){.law = LAW[profile], .profile = profile, .radius = source.cam->radius};
    return groove->law->build(groove, &source, fault);
}

void groove_free(Groove *groove) {
    table_free(&groove->table);
    free(groove->path);
    groove->path = NULL;
}

static double clamped(double x, double low, double high) {
    if (x < low) return low;
    return x > high ? high : x;
}

GroovePoint groove_at(const Groove *groove, double psi) {
    return groove->law->at(groove, clamped(psi, groove->first, groove->last));
}

double groove_angle(const Groove *groove, double z) {
    return clamped(groove->law->angle(groove, z), groove->first, groove->last);
}

double groove_slope(const Groove *groove, double psi, double z) {
    if (groove->profile == PROFILE_ELLIPSE) {
        const double C = groove->C0 - z / groove->height;
        if (2.0 * C * C < 1.0 && C > 0.0) return groove->gain * sqrt((1.0 - C) * (1.0 + C)) / C;
    }
    return groove_at(groove, psi).slope;
}
