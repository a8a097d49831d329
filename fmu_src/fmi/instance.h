/* One instance of the FMU: its values, how far it is in its life, and how it reports errors. Nothing here
 * depends on the version of FMI: fmi2.c and fmi3.c translate. */
#ifndef DUALCAM_INSTANCE_H
#define DUALCAM_INSTANCE_H

#include "fmi/variables.h"

/* As bits, so that a set of phases is a number. */
typedef enum {
    PHASE_INSTANTIATED = 1,
    PHASE_INITIALIZATION = 2,
    PHASE_STEP = 4, /* co-simulation, between steps */
    PHASE_EVENT = 8,
    PHASE_CONTINUOUS = 16, /* model exchange, continuous time */
    PHASE_TERMINATED = 32,
    PHASE_SAMPLING = 64,  /* inside a step: the master gives inputs of later instants */
    PHASE_WATCHING = 128, /* inside a step: the master reads what it has come to */
    PHASES_INSIDE_STEP = PHASE_SAMPLING | PHASE_WATCHING,
    PHASES_BEFORE_START = PHASE_INSTANTIATED | PHASE_INITIALIZATION,
    PHASES_RUNNING = PHASE_STEP | PHASE_EVENT | PHASE_CONTINUOUS
} Phase;

/* Hybrid: the master handles events in event mode. */
typedef enum { MODEL_EXCHANGE, CO_SIMULATION, HYBRID_CO_SIMULATION } Use;

/* What a restored run needs besides params, inputs and state. */
typedef struct {
    double time;     /* s, the communication point reached; in model exchange the present */
    double accepted; /* s, model exchange: end of the solver's last good step */
    Phase phase;
    uint16_t use;        /* a Use */
    uint16_t with_rates; /* bit r: derivatives of the input with value reference r were set since the last step */
} Run;

/* Where messages go. */
typedef struct Log Log;
struct Log {
    /* text: plain, one line */
    void (*error)(const Log *log, const char *instance, const char *text);
    void *environment;
    void (*logger)(void); /* the master's own function, of the type that its version of FMI has */
};

/* How a master takes part in what happens inside a co-simulation step. All zero: not at all. */
typedef struct {
    bool takes_early_return;
    uint16_t sampled;     /* bit r: it gives values of the input with value reference r for later instants */
    void (*update)(void); /* its own function, of the type that its version of FMI has, or NULL */
} Following;

typedef struct {
    Values values;
    Run run;
    unsigned valid; /* groups of variables that are what params, inputs and state imply */
    bool logs_errors;
    Log log;
    Following following;
    char *name;
    char *resources; /* the directory of the FMU's resources, or NULL */
} Instance;

/* What a master says of the instance it wants. */
typedef struct {
    const char *function; /* that it calls */
    const char *name;
    const char *guid, *guid_name; /* and what its version of FMI calls it */
    const char *location;         /* URI of the FMU's resources, or NULL: */
    const char *path;             /* where they are */
    Use use;
    Following following;
} Wish;

/* NULL, with the reason in the log, if there is no memory, or name or GUID are wrong. */
Instance *instance_new(const Wish *wish, const Log *log);
void instance_free(Instance *instance);

/* Start values, as after instance_new(). What was built from a table file is built anew. */
void instance_reset(Instance *instance);

/* The relative tolerance where the master gives none, and the range into which it brings others: below,
 * rounding is larger; above, the answer means nothing. */
#define TOLERANCE_DEFAULT 1e-9
#define TOLERANCE_MIN 1e-12
#define TOLERANCE_MAX 1e-2

/* Has the run begun? Until then the state is the start state. */
static inline bool instance_has_begun(const Instance *instance) {
    return (instance->run.phase & PHASES_BEFORE_START) == 0;
}

/* To be called when params, inputs or state changed: what is computed from them is no longer valid.
 * Before the run has begun that includes the state. */
static inline void instance_changed(Instance *instance) {
    instance->valid =
        instance_has_begun(instance) ? GROUP_PARAMS | GROUP_INPUTS | GROUP_STATE : GROUP_PARAMS | GROUP_INPUTS;
}

/* What instance_provide() and instance_is_in() do in the rare case. */
bool instance_compute(Instance *instance, const char *function, unsigned groups);
bool instance_refuse_phase(const Instance *instance, const char *function, unsigned phases);

/* Makes these groups valid. Before the run has begun that is a start with the present parameters. Logs why, if
 * it cannot be done. */
static inline bool instance_provide(Instance *instance, const char *function, unsigned groups) {
    return (groups & ~instance->valid) == 0 || instance_compute(instance, function, groups);
}

/* Is the instance in one of these phases? If not, or if there is no instance, logs that `function` is
 * not allowed. */
static inline bool instance_is_in(const Instance *instance, const char *function, unsigned phases) {
    if (instance == NULL) return false;
    return (instance->run.phase & phases) != 0 || instance_refuse_phase(instance, function, phases);
}

/* Is the instance used in this way? If not, logs that `function` is not allowed. */
bool instance_is_for(const Instance *instance, const char *function, Use use);
const char *use_name(Use use);

/* Takes the instance from one of the phases `from` to `to`. */
bool instance_go(Instance *instance, const char *function, unsigned from, Phase to);

/* Time and tolerance of the run, still before it begins; tolerance or stop time are not defined where NULL. A tolerance
 * beyond TOLERANCE_MIN and TOLERANCE_MAX is taken as the nearest of them. The mechanism can go on past the stop time. */
bool instance_setup(Instance *instance, const char *function, const double *tolerance, double start_time,
                    const double *stop_time);

/* Begins the run: `to` is the phase that follows initialization. */
bool instance_begin(Instance *instance, const char *function, Phase to);

/* Log categories that count as "errors": all, where none is named. Others are accepted and have no messages. */
bool instance_set_logging(Instance *instance, const char *function, bool on, size_t count,
                          const char *const categories[]);

/* Logs the message of a refused call; returns false. */
__attribute__((format(printf, 2, 3))) bool instance_refuse(const Instance *instance, const char *format, ...);

/* Checks common to many calls; each logs what it refuses. */
bool instance_has_array(const Instance *instance, const char *function, size_t n, const void *array, const char *name);
bool instance_has_pointer(const Instance *instance, const char *function, const void *pointer, const char *name);

extern const char *const ERROR_CATEGORY;

#endif
