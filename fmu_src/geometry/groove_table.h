/* Samples of a groove from a CSV file, header `psi_rad,z_m`, then two numbers per line; and the curve through them,
 * that of sampled_curve.h. Monotone samples give a monotone curve. z is measured from the curve's value at psi = 0. */
#ifndef DUALCAM_GROOVE_TABLE_H
#define DUALCAM_GROOVE_TABLE_H

#include <stdbool.h>
#include <stddef.h>

#include "model/fault.h"

typedef struct {
    double psi; /* rad */
    double z;   /* m */
} Sample;

/* psi strictly increases and includes 0; z does not decrease. */
typedef struct {
    Sample *sample; /* owned */
    size_t count;
} Samples;

/* Reads the file `path`, which is absolute or relative to the directory `resources` (NULL: there is none).
 * `variable` is the name of the parameter that holds the path, for messages. On failure returns false with the
 * reason in `fault`; `samples` is then empty. */
bool samples_read(Samples *samples, const char *path, const char *resources, const char *variable, Fault *fault);

/* Safe on zeroed Samples, and twice. */
void samples_free(Samples *samples);

/* A groove law at one angle: g, g', g'' in m, m/rad, m/rad^2. */
typedef struct {
    double z, slope, dslope_dpsi;
} GroovePoint;

/* The curve from one sample to the next; 64 bytes. */
typedef struct {
    double psi;      /* rad, where it starts */
    double width;    /* rad */
    double z;        /* m, where it starts */
    double slope[5]; /* m/rad, Bernstein coefficients of the derivative: none is negative */
} TablePiece;

typedef struct {
    TablePiece *piece; /* owned */
    size_t count;      /* of pieces */
} Table;

/* Builds the curve through samples that samples_read() has accepted. Returns false, with an empty table, if memory is
 * short or if the samples are so close that a coefficient overflows. */
bool table_build(Table *table, const Samples *samples);

/* Safe on a zeroed Table, and twice. */
void table_free(Table *table);

/* The curve at psi within the samples' range. */
GroovePoint table_at(const Table *table, double psi);

/* An angle where the height of the curve is z or nearest to z. */
double table_angle(const Table *table, double z);

#endif
