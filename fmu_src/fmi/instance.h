/* One instance of the FMU: its values, its phase, and how it reports errors. Nothing here depends on the version of
 * FMI. */
#ifndef DUALCAM_INSTANCE_H
#define DUALCAM_INSTANCE_H

#include "fmi/variables.h"

/* The states of FMI's state machine. Each is one bit, so that a set of phases is a number. */
typedef enum {
    PHASE_INSTANTIATED = 1,
    PHASE_INITIALIZATION = 2,
    PHASE_STEP = 4, /* co-simulation, between steps */
    PHASE_EVENT = 8,
    PHASE_CONTINUOUS = 16, /* model exchange, continuous time */
    PHASE_TERMINATED = 32,
    PHASE_INTERMEDIATE_INPUTS = 64,   /* inside a step: the master sets inputs of a later instant */
    PHASE_INTERMEDIATE_OUTPUTS = 128, /* inside a step: the master reads variables */
    PHASES_INSIDE_STEP = PHASE_INTERMEDIATE_INPUTS | PHASE_INTERMEDIATE_OUTPUTS,
    PHASES_BEFORE_START = PHASE_INSTANTIATED | PHASE_INITIALIZATION,
    PHASES_RUNNING = PHASE_STEP | PHASE_EVENT | PHASE_CONTINUOUS,
    PHASES_OF_RESULTS = PHASE_INITIALIZATION | PHASES_RUNNING | PHASE_TERMINATED
} Phase;

/* Hybrid: the master handles the events of co-simulation in event mode. */
typedef enum { INTERFACE_MODEL_EXCHANGE, INTERFACE_CO_SIMULATION, INTERFACE_HYBRID_CO_SIMULATION } InterfaceType;

/* What a restored FMU state needs besides params, inputs and state of the model. */
typedef struct {
    double time;            /* s; in co-simulation the communication point that is reached */
    double completed_until; /* s, model exchange: end of the last completed integrator step */
    Phase phase;
    uint16_t interface_type; /* an InterfaceType */
    uint16_t
        derivatives_given; /* bit r: derivatives of the input with value reference r were set since the last step */
} Run;

/* What a message is. */
typedef enum { MESSAGE_ERROR, MESSAGE_WARNING, MESSAGE_KINDS } MessageKind;

/* Where messages go. */
typedef struct Log Log;
struct Log {
    /* `text` is plain and of one line. */
    void (*send)(const Log *log, const char *instance, MessageKind kind, const char *text);
    void *environment;
    void (*logger)(void); /* the master's callback; its type is that of the version of FMI */
};

enum { INPUTS_MAX = 16 }; /* bits of IntermediateAccess.sampled_inputs */

/* How a master takes part inside a co-simulation step. All zero: not at all. */
typedef struct {
    bool early_return_allowed;
    uint16_t sampled_inputs; /* bit r: the master sets the input with value reference r < INPUTS_MAX inside steps */
    void (*callback)(void);  /* the master's intermediate update, of the type of the version of FMI, or NULL */
} IntermediateAccess;

typedef struct {
    Values values;
    Run run;
    unsigned valid; /* groups of variables that are up to date with params, inputs and state */
    bool logs[MESSAGE_KINDS];
    Log log;
    IntermediateAccess intermediate;
    char *name;
    char *resources; /* the directory of the FMU's resources, or NULL */
} Instance;

/* What a master asks for when it instantiates the FMU. */
typedef struct {
    const char *function; /* the FMI function that the master calls */
    const char *name;
    const char *guid, *guid_name; /* and the name of this argument in the version of FMI */
    const char *location;         /* URI of the FMU's resources, or NULL: use `path` */
    const char *path;             /* path of the FMU's resources */
    InterfaceType interface_type;
    IntermediateAccess intermediate;
} InstanceRequest;

/* NULL, with the reason in the log, if memory is short, or if name or GUID are wrong. */
Instance *instance_new(const InstanceRequest *request, const Log *log);
void instance_free(Instance *instance);

/* Sets start values, as after instance_new(). A table file is read anew. */
void instance_reset(Instance *instance);

/* Has the run begun? Until then the state is the start state. */
/* May the master set this input inside a step? */
static inline bool instance_samples(const Instance *instance, unsigned reference) {
    return (instance->intermediate.sampled_inputs >> reference & 1u) != 0;
}

static inline bool instance_has_begun(const Instance *instance) {
    return (instance->run.phase & PHASES_BEFORE_START) == 0;
}

/* To be called when params, inputs or state changed: variables that depend on them are no longer up to date. Before the
 * run has begun, the state depends on params and inputs. */
static inline void instance_invalidate(Instance *instance) {
    instance->valid =
        instance_has_begun(instance) ? GROUP_PARAMS | GROUP_INPUTS | GROUP_STATE : GROUP_PARAMS | GROUP_INPUTS;
}

/* The rare case of instance_provide() and of instance_is_in(). */
bool instance_compute(Instance *instance, const char *function, unsigned groups);
bool instance_refuse_phase(const Instance *instance, const char *function, unsigned phases);

/* Brings these groups of variables up to date. Before the run has begun, the model starts with the present parameters.
 * False, with the reason in the log, where a variable does not exist. */
static inline bool instance_provide(Instance *instance, const char *function, unsigned groups) {
    return (groups & ~instance->valid) == 0 || instance_compute(instance, function, groups);
}

/* Is the instance in one of these phases? If not, the log says that `function` is not allowed. False also for NULL. */
static inline bool instance_is_in(const Instance *instance, const char *function, unsigned phases) {
    if (instance == NULL) return false;
    return (instance->run.phase & phases) != 0 || instance_refuse_phase(instance, function, phases);
}

/* Has the instance this interface type? If not, the log says that `function` is not allowed. False also for NULL. */
bool instance_has_interface(const Instance *instance, const char *function, InterfaceType type);

/* The same for co-simulation, with and without event mode. */
bool instance_is_co_simulation(const Instance *instance, const char *function);
const char *interface_name(InterfaceType type);

/* Changes the phase from one of `from` to `to`. */
bool instance_change_phase(Instance *instance, const char *function, unsigned from, Phase to);

/* Sets time and tolerance before the run begins. NULL: the tolerance or the stop time is not defined. A tolerance
 * outside TOLERANCE_MIN to TOLERANCE_MAX is taken as the nearest of both. Steps may go on past the stop time. */
bool instance_setup(Instance *instance, const char *function, const double *tolerance, double start_time,
                    const double *stop_time);

/* Ends initialization: to step mode, or, in model exchange and where the master handles events, to event mode. */
bool instance_exit_initialization(Instance *instance, const char *function);

/* Switches the messages of the categories on or off; no category means all. Only the categories of errors and of
 * warnings have messages. */
bool instance_set_logging(Instance *instance, const char *function, bool on, size_t count,
                          const char *const categories[]);

/* Logs the message of a refused call. Returns false. */
__attribute__((format(printf, 2, 3))) bool instance_refuse(const Instance *instance, const char *format, ...);

/* Logs a message about what is allowed, but may not be meant. */
__attribute__((format(printf, 2, 3))) void instance_warn(const Instance *instance, const char *format, ...);

/* Copies a message with each character of `doubled` written twice; what does not fit is left out. */
void escape_message(char *escaped, size_t size, const char *text, const char *doubled);

/* Checks that many functions share. Each logs what it refuses. */
bool instance_has_array(const Instance *instance, const char *function, size_t n, const void *array, const char *name);
bool instance_has_pointer(const Instance *instance, const char *function, const void *pointer, const char *name);

extern const char *const MESSAGE_CATEGORIES[MESSAGE_KINDS];

#endif
