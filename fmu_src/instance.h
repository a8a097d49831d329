/* One instance of the FMU: its values, how far it is in its life, and how it reports errors. */
#ifndef DUALCAM_INSTANCE_H
#define DUALCAM_INSTANCE_H

#include "fmi2Functions.h"
#include "variables.h"

/* As bits, so that a set of phases is a number. */
typedef enum {
    PHASE_INSTANTIATED = 1,
    PHASE_INITIALIZATION = 2,
    PHASE_STEP = 4,
    PHASE_TERMINATED = 8,
    PHASES_BEFORE_START = PHASE_INSTANTIATED | PHASE_INITIALIZATION,
    PHASES_OF_SETTING = PHASES_BEFORE_START | PHASE_STEP
} Phase;

/* What a restored run needs besides params, inputs and state. */
typedef struct {
    double time; /* s, the communication point reached */
    Phase phase;
    uint32_t with_rates; /* bit r: derivatives of the input with value reference r were set since the last step */
} Run;

typedef struct {
    Values values;
    Run run;
    unsigned valid; /* groups of variables that are what params, inputs and state imply */
    bool logs_errors;
    fmi2CallbackFunctions callbacks;
    char *name;
    char *resources; /* the directory of the FMU's resources, or NULL */
} Instance;

/* NULL if there is no memory. `location` is what fmi2Instantiate got. */
Instance *instance_new(const char *name, const char *location, const fmi2CallbackFunctions *callbacks);
void instance_free(Instance *instance);

/* Start values, as after instance_new(). What was built from a table file is built anew. */
void instance_reset(Instance *instance);

/* The relative tolerance where fmi2SetupExperiment gives none, and the range into which it brings others: below,
 * rounding is larger; above, the answer means nothing. */
#define TOLERANCE_DEFAULT 1e-9
#define TOLERANCE_MIN 1e-12
#define TOLERANCE_MAX 1e-2

/* To be called when params, inputs or state changed: what is computed from them is no longer valid.
 * Before the run has begun that includes the state, which is then the start state. */
static inline void instance_changed(Instance *instance) {
    const bool begun = (instance->run.phase & PHASES_BEFORE_START) == 0;
    instance->valid = begun ? GROUP_PARAMS | GROUP_INPUTS | GROUP_STATE : GROUP_PARAMS | GROUP_INPUTS;
}

/* Makes these groups valid. Before the run has begun that is a start with the present parameters. Logs why, if
 * it cannot be done. */
bool instance_provide(Instance *instance, const char *function, unsigned groups);

/* Is the instance in one of these phases? If not, or if there is no instance, logs that `function` is
 * not allowed. */
bool instance_is_in(const Instance *instance, const char *function, unsigned phases);

/* Logs the message of a refused call; returns fmi2Error. */
__attribute__((format(printf, 2, 3))) fmi2Status instance_refuse(const Instance *instance, const char *format,
                                                                 ...);

/* The same where there is no instance (yet). */
void log_error(const fmi2CallbackFunctions *callbacks, const char *name, const char *text);

#endif
