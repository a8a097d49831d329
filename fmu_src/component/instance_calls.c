/* Life of an instance, its modes and steps. Both resources of the draft, for co-simulation and for model exchange,
 * share these functions: the FMU itself refuses a call that is not of the instance's interface. */
#include <stdlib.h>
#include <string.h>

#include "component/component.h"
#include "component/resource_files.h"

IMPORT("log-message")
void host_log_message(const char *name, size_t name_length, uint32_t status, const char *category,
                      size_t category_length, const char *message, size_t message_length);

/* A new handle of the host for what stands behind the handle. */
IMPORT("new-co-simulation-instance") uint32_t new_co_simulation_handle(Handle *me);
IMPORT("new-model-exchange-instance") uint32_t new_model_exchange_handle(Handle *me);

/* ---- callbacks ---- */

/* Length of a text of UTF-8 without an incomplete last character. */
static size_t whole_length(const char *text) {
    const size_t length = strlen(text);
    for (size_t n = length; n > 0 && length - n < 4; n--) {
        const unsigned char byte = (unsigned char)text[n - 1];
        if (byte < 0x80) return n == length ? length : n;
        if (byte < 0xC0) continue; /* not the first byte of a character */
        const size_t size = byte < 0xE0 ? 2 : byte < 0xF0 ? 3 : 4;
        return n - 1 + size <= length ? length : n - 1;
    }
    return length;
}

void log_message(const Handle *me, fmi3Status status, const char *category, const char *message) {
    host_log_message(me->name, strlen(me->name), (uint32_t)status, category, strlen(category), message,
                     whole_length(message));
}

static void pass_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                         fmi3String message) {
    log_message(environment, status, category, message);
}

/* ---- life ---- */

/* A handle, or none where the FMU was not instantiated. */
typedef struct {
    uint8_t exists;
    uint32_t handle;
} OptionalHandle;

static Handle *new_handle(const char *name, size_t length) {
    Handle *const me = malloc(sizeof *me + length + 1);
    if (me == NULL) __builtin_trap();
    me->fmu = NULL;
    memcpy(me->name, name, length);
    me->name[length] = '\0';
    return me;
}

static OptionalHandle *optional_handle(Handle *me, uint32_t (*new)(Handle *)) {
    static OptionalHandle result;
    result = (OptionalHandle){.exists = me->fmu != NULL};
    if (result.exists) result.handle = new(me);
    else free(me);
    return &result;
}

/* There is no intermediate update: a host could not call the component from there. So a host that requires variables
 * inside steps is refused. */
EXPORT("instantiate-co-simulation")
OptionalHandle *instantiate_co_simulation(const char *name, size_t name_length, const char *token, size_t token_length,
                                          const char *path, size_t path_length, bool visible, bool logging_on,
                                          bool event_mode_used, bool early_return_allowed,
                                          const fmi3ValueReference *required, size_t required_count) {
    (void)path, (void)path_length; /* the component holds its resources */
    Handle *const me = new_handle(name, name_length);
    if (required_count == 0)
        me->fmu = fmi3InstantiateCoSimulation(me->name, hold_text(token, token_length), RESOURCES_DIRECTORY, visible,
                                              logging_on, event_mode_used, early_return_allowed, required,
                                              required_count, me, pass_message, NULL);
    else
        log_message(me, fmi3Error, "logStatusError",
                    "instantiate-co-simulation: required-intermediate-variables: allowed is the empty list, because "
                    "the WebAssembly binary has no intermediate update");
    return optional_handle(me, new_co_simulation_handle);
}

EXPORT("instantiate-model-exchange")
OptionalHandle *instantiate_model_exchange(const char *name, size_t name_length, const char *token, size_t token_length,
                                           const char *path, size_t path_length, bool visible, bool logging_on) {
    (void)path, (void)path_length; /* the component holds its resources */
    Handle *const me = new_handle(name, name_length);
    me->fmu = fmi3InstantiateModelExchange(me->name, hold_text(token, token_length), RESOURCES_DIRECTORY, visible,
                                           logging_on, me, pass_message);
    return optional_handle(me, new_model_exchange_handle);
}

/* The host has dropped its handle. */
EXPORT("drop") void drop(Handle *me) {
    fmi3FreeInstance(me->fmu);
    free(me);
}

EXPORT("get-version") Text *get_version(void) {
    static Text version;
    version = (Text){fmi3GetVersion(), strlen(fmi3GetVersion())};
    return &version;
}

EXPORT("set-debug-logging")
fmi3Status set_debug_logging(const Handle *me, bool on, const Text *categories, size_t count) {
    return fmi3SetDebugLogging(me->fmu, on, count, hold_texts(categories, count));
}

/* ---- modes ---- */

EXPORT("enter-initialization-mode")
fmi3Status enter_initialization_mode(const Handle *me, bool tolerance_defined, double tolerance, double start_time,
                                     bool stop_time_defined, double stop_time) {
    return fmi3EnterInitializationMode(me->fmu, tolerance_defined, tolerance, start_time, stop_time_defined, stop_time);
}

/* A function that needs the instance alone. */
#define MODE(name, function, fmi_function)                                                                             \
    EXPORT(name) fmi3Status function(const Handle *me) {                                                               \
        return fmi_function(me->fmu);                                                                                  \
    }

MODE("exit-initialization-mode", exit_initialization_mode, fmi3ExitInitializationMode)
MODE("enter-event-mode", enter_event_mode, fmi3EnterEventMode)
MODE("terminate", terminate, fmi3Terminate)
MODE("reset", reset, fmi3Reset)
MODE("enter-configuration-mode", enter_configuration_mode, fmi3EnterConfigurationMode)
MODE("exit-configuration-mode", exit_configuration_mode, fmi3ExitConfigurationMode)
MODE("evaluate-discrete-states", evaluate_discrete_states, fmi3EvaluateDiscreteStates)
MODE("enter-step-mode", enter_step_mode, fmi3EnterStepMode)
MODE("enter-continuous-time-mode", enter_continuous_time_mode, fmi3EnterContinuousTimeMode)

typedef struct {
    uint8_t refused;
    union {
        struct {
            bool update_needed, terminate, nominals_changed, values_changed, next_event_defined;
            double next_event;
        } states;
        uint8_t status;
    };
} DiscreteStatesResult;

EXPORT("update-discrete-states") DiscreteStatesResult *update_discrete_states(const Handle *me) {
    static DiscreteStatesResult result;
    result = (DiscreteStatesResult){0};
    const fmi3Status status = fmi3UpdateDiscreteStates(me->fmu, &result.states.update_needed, &result.states.terminate,
                                                       &result.states.nominals_changed, &result.states.values_changed,
                                                       &result.states.next_event_defined, &result.states.next_event);
    result.refused = is_refused(status);
    if (result.refused) result.status = (uint8_t)status;
    return &result;
}

/* ---- steps ---- */

typedef struct {
    uint8_t refused;
    union {
        struct {
            double last_time;
            bool event, terminate, early;
        } end;
        uint8_t status;
    };
} StepResult;

EXPORT("do-step") StepResult *do_step(const Handle *me, double time, double size, bool no_state_before) {
    static StepResult result;
    result = (StepResult){0};
    const fmi3Status status = fmi3DoStep(me->fmu, time, size, no_state_before, &result.end.event, &result.end.terminate,
                                         &result.end.early, &result.end.last_time);
    result.refused = is_refused(status);
    if (result.refused) result.status = (uint8_t)status;
    return &result;
}

typedef struct {
    uint8_t refused;
    union {
        struct {
            bool event, terminate;
        } end;
        uint8_t status;
    };
} IntegratorStepResult;

EXPORT("completed-integrator-step")
IntegratorStepResult *completed_integrator_step(const Handle *me, bool no_state_before) {
    static IntegratorStepResult result;
    result = (IntegratorStepResult){0};
    const fmi3Status status =
        fmi3CompletedIntegratorStep(me->fmu, no_state_before, &result.end.event, &result.end.terminate);
    result.refused = is_refused(status);
    if (result.refused) result.status = (uint8_t)status;
    return &result;
}

EXPORT("set-time") fmi3Status set_time(const Handle *me, double time) {
    return fmi3SetTime(me->fmu, time);
}
