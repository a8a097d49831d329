/* The state of inverse dynamics, and everything that one instance holds. */
#ifndef DUALCAM_INVERSE_STATE_H
#define DUALCAM_INVERSE_STATE_H

#include <stdbool.h>
#include <stdint.h>

#include "contact/domain.h"
#include "geometry/transmission.h"
#include "inverse/imposed_motion.h"
#include "model/friction_table_load.h"
#include "model/ledger.h"
#include "model/mode.h"
#include "model/params.h"
#include "model/work.h"

/* At the latest communication point. */
typedef struct {
    double theta;           /* rad, the imposed angle */
    double omega;           /* rad/s, the imposed speed */
    double cam;             /* rad, angle of cam 2; equal to theta where the shaft is rigid */
    int64_t events;         /* number of mode changes so far */
    double F_ext_at_start;  /* N, under which the friction class was found (contact/domain.h) */
    int64_t friction_class; /* FrictionClass */
    Mode mode;              /* rigid shaft: stick (omega = 0), loading or releasing; elastic shaft: the mode of cam 2 */
    int32_t direction;      /* of the last motion, +1 or -1 */
    Ledger ledger;
} InverseState;

typedef struct {
    Params params;
    InverseInputs inputs;
    InverseState state;
    Transmission transmission; /* geometry along theta; owns memory, as the tables below do */
    FrictionTables friction;   /* that params.cam[].law.table points to */
    const char *resources;     /* directory that a table's relative path starts from, or NULL; not owned */
    Work *work;                /* of the step that is being made; else NULL */
    int64_t work_limit;        /* see work_of_call() */
    bool continuous;           /* model exchange: the direction changes in inverse_settle() only */
} Inverse;

static inline bool has_elastic_shaft(const Inverse *m) {
    return m->params.shaft.stiffness > 0.0;
}

static inline const TransmissionPiece *inverse_piece(const Inverse *m, double theta, int direction) {
    return transmission_piece(&m->transmission, theta, direction);
}

#endif
