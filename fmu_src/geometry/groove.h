/* Groove laws: the rise z = g(psi) of the pin when it turns by psi relative to its cam, g(0) = 0, g' >= 0. The laws are
 * those of docs/mechanism.md, section 2, of an ellipse with a, b and kappa for h_x, h_z and chi. Each law is one entry
 * of groove.c's list. */
#ifndef DUALCAM_GROOVE_H
#define DUALCAM_GROOVE_H

#include <stdbool.h>

#include "geometry/groove_table.h"
#include "model/fault.h"
#include "model/params.h"

typedef struct GrooveLaw GrooveLaw;

typedef struct {
    const GrooveLaw *law;
    int profile;           /* PROFILE_* */
    double radius;         /* m */
    double gain;           /* m/rad: of a helix g'; of an ellipse r b/a, so that g' = gain S/sqrt(1 - S^2) */
    double height;         /* m, kappa b of an ellipse; H of a cycloid */
    double rate;           /* 1/rad, dS/dpsi = kappa r/a of an ellipse */
    double S0, C0;         /* S and sqrt(1 - S^2) of an ellipse at psi = 0 */
    Table table;           /* owned; empty for the other laws */
    char *path;            /* of the table's file, owned; else NULL */
    double first, last;    /* rad: the law holds in [first, last]; infinite for a helix */
    const char *parameter; /* that decides the shape, as "ellipse_a"; not of a table */
    double size;           /* its value */
} Groove;

/* What a law is built from. */
typedef struct {
    const CamParams *cam;
    int number;            /* of the cam, 1 or 2 */
    const char *path;      /* of a table's file */
    const char *resources; /* directory from which a relative path counts; NULL: there is none */
} GrooveSource;

struct GrooveLaw {
    const char *adjective; /* of the groove, in messages */
    const char *reach;     /* what must hold for a law that ends before a stop to reach the stop */
    bool (*build)(Groove *groove, const GrooveSource *source, Fault *fault);
    GroovePoint (*at)(const Groove *groove, double psi); /* in [first, last] */
    double (*angle)(const Groove *groove, double z);     /* the inverse */
};

extern const GrooveLaw GROOVE_ELLIPSE, GROOVE_CYCLOID;

/* Fills `groove` with the law of cam `number` (1 or 2). A table's relative path counts from the directory `resources`
 * (NULL: there is none). On failure returns false with the reason in `fault`; `groove` then owns nothing. */
bool groove_build(Groove *groove, const Params *params, int number, const char *resources, Fault *fault);

/* Safe on a zeroed Groove, and twice. */
void groove_free(Groove *groove);

/* The law at psi in [first, last]; beyond, its value at that end. */
GroovePoint groove_at(const Groove *groove, double psi);

/* The inverse: an angle in [first, last] where g is z or nearest to z. In a dwell the angle is not unique. */
double groove_angle(const Groove *groove, double z);

/* g' at the angle psi and the height z, both known to rounding. Close to vertical the slope of an ellipse is taken from
 * the height, by C = C0 - z/(kappa b): 1 - S^2, from the angle, would cancel. */
double groove_slope(const Groove *groove, double psi, double z);

#endif
