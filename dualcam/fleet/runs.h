/* The runs of a parameter study: the FMI calls of one run, made for one row of values after another, in one instance
 * of FMI 2.0 or FMI 3.0. dualcam/study/batch.py lays the calls out. */
#ifndef DUALCAM_RUNS_H
#define DUALCAM_RUNS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fleet.h"

/* What a call does. The numbers are those of KINDS in dualcam/study/batch.py. */
typedef enum {
    RUNS_PLAIN,   /* a function of the instance alone: reset, enter (FMI 2.0) or leave initialization mode */
    RUNS_STATE,   /* restore the state `values` */
    RUNS_SET_UP2, /* fmi2SetupExperiment */
    RUNS_ENTER3,  /* fmi3EnterInitializationMode */
    RUNS_ACCESS2, /* get or set variables of one type */
    RUNS_ACCESS3, /* the same of FMI 3.0 */
    RUNS_RATES2,  /* fmi2SetRealInputDerivatives */
    RUNS_STEP2,   /* fmi2DoStep */
    RUNS_STEP3,   /* fmi3DoStep; an FMU that ends the simulation is an fmi3Discard */
    RUNS_COPY     /* no FMI call: `count` bytes of the row go to `target` */
} RunsKind;

/* The FMU's functions, with `void *` for values of any type. All return a status, which is a number of the same
 * meaning in both versions of FMI. */
typedef union {
    int (*plain)(void *component);
    int (*state)(void *component, void *state);
    int (*set_up2)(void *component, int has_tolerance, double tolerance, double start, int has_stop, double stop);
    int (*enter3)(void *component, bool has_tolerance, double tolerance, double start, bool has_stop, double stop);
    int (*access2)(void *component, const uint32_t references[], size_t count, void *values);
    int (*access3)(void *component, const uint32_t references[], size_t count, void *values, size_t value_count);
    int (*rates2)(void *component, const uint32_t references[], size_t count, const int orders[], void *values);
    int (*step2)(void *component, double time, double size, int keeps_no_state);
    int (*step3)(void *component, double time, double size, bool keeps_no_state, bool *needs_event, bool *ends,
                 bool *is_early, double *reached);
} RunsFunction;

typedef struct {
    int kind; /* RunsKind */
    int has_tolerance;
    RunsFunction function;
    const uint32_t *references;
    const int *orders;
    size_t count;          /* of references; of bytes */
    const double *numbers; /* of a step: time and size, s; of set up and enter: tolerance, start time */
    void *target;
    char *values;     /* of run 0 */
    size_t line_size; /* bytes from the values of one run to those of the next one; 0: the same for all runs */
} RunsCall;

/* Where and why runs_make has ended: the run and the call, and the status of that call. */
typedef struct {
    size_t run;
    size_t call;
    int status;
} RunsEnd;

/* Makes the runs `first` to `last` - 1. Ends early at the call that fails, and after a run that gave a warning, whose
 * messages the caller may drop: then `end` has the run after that one, and the status fmi2Warning. */
FLEET_EXPORT void runs_make(const RunsCall calls[], size_t call_count, void *component, size_t first, size_t last,
                            RunsEnd *end);

#endif
