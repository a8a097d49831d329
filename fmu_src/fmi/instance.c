#include "fmi/instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi/resources.h"

#ifndef MODEL_GUID
#error "MODEL_GUID, the GUID in modelDescription.xml, is given by the build"
#endif

enum { MESSAGE_SIZE = 1024 };

const char *const ERROR_CATEGORY = "logStatusError";

/* ---- messages ---- */

/* Bytes that a caller passed in and that are not plain text do not get into the log. */
static void clean(char *text) {
    for (char *c = text; *c != '\0'; c++)
        if (*c < ' ' || *c > '~') *c = '?';
}

__attribute__((format(printf, 3, 0))) static void log_error(const Log *log, const char *name, const char *format,
                                                            va_list arguments) {
    char text[MESSAGE_SIZE];
    vsnprintf(text, sizeof text, format, arguments);
    clean(text);
    log->error(log, name, text);
}

bool instance_refuse(const Instance *instance, const char *format, ...) {
    if (!instance->logs_errors) return false;
    va_list arguments;
    va_start(arguments, format);
    log_error(&instance->log, instance->name, format, arguments);
    va_end(arguments);
    return false;
}

/* The same where there is no instance. */
__attribute__((format(printf, 3, 4))) static Instance *refuse_instance(const Log *log, const char *name,
                                                                       const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    log_error(log, name, format, arguments);
    va_end(arguments);
    return NULL;
}

bool instance_has_array(const Instance *instance, const char *function, size_t n, const void *array, const char *name) {
    if (n == 0 || array != NULL) return true;
    return instance_refuse(instance, "%s: %s = NULL, with %zu elements asked for: allowed is an array of that many",
                           function, name, n);
}

bool instance_has_pointer(const Instance *instance, const char *function, const void *pointer, const char *name) {
    if (pointer != NULL) return true;
    return instance_refuse(instance, "%s: %s = NULL: allowed is a valid address", function, name);
}

static bool is_log_category(const char *name) {
    static const char *const standard[] = {"logEvents",           "logSingularLinearSystems",
                                           "logNonlinearSystems", "logDynamicStateSelection",
                                           "logStatusWarning",    "logStatusDiscard",
                                           "logStatusError",      "logStatusFatal",
                                           "logStatusPending",    "logAll"};
    for (size_t i = 0; i < sizeof standard / sizeof standard[0]; i++)
        if (strcmp(name, standard[i]) == 0) return true;
    return false;
}

bool instance_set_logging(Instance *instance, const char *function, bool on, size_t count,
                          const char *const categories[]) {
    if (instance == NULL || !instance_has_array(instance, function, count, categories, "categories")) return false;
    bool errors = count == 0;
    for (size_t i = 0; i < count; i++) {
        if (!instance_has_pointer(instance, function, categories[i], "a category")) return false;
        if (!is_log_category(categories[i]))
            return instance_refuse(
                instance, "%s: unknown category \"%.100s\": allowed are the standard ones, such as logStatusError",
                function, categories[i]);
        errors = errors || strcmp(categories[i], ERROR_CATEGORY) == 0 || strcmp(categories[i], "logAll") == 0;
    }
    if (errors) instance->logs_errors = on;
    return true;
}

/* ---- life ---- */

static char *copy_of(const char *text) {
    const size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (copy != NULL) memcpy(copy, text, size);
    return copy;
}

/* Start values into zeroed ones. */
static void start(Instance *instance) {
    Machine *machine = &instance->values.machine;
    variables_start(&instance->values);
    machine->params.tolerance = TOLERANCE_DEFAULT;
    machine->resources = instance->resources;
    instance->run = (Run){.phase = PHASE_INSTANTIATED, .use = instance->run.use};
    instance_changed(instance);
}

Instance *instance_new(const Wish *wish, const Log *log) {
    if (wish->name == NULL)
        return refuse_instance(log, "", "%s: instanceName = NULL: allowed is any text", wish->function);
    if (wish->guid == NULL || strcmp(wish->guid, MODEL_GUID) != 0)
        return refuse_instance(log, wish->name, "%s: %s %s: allowed is only " MODEL_GUID, wish->function,
                               wish->guid_name, wish->guid == NULL ? "= NULL" : "is not that of this FMU");
    Instance *instance = calloc(1, sizeof *instance);
    if (instance != NULL) instance->name = copy_of(wish->name);
    if (instance == NULL || instance->name == NULL ||
        !(wish->location != NULL ? resources_directory(wish->location, &instance->resources)
                                 : resources_from_path(wish->path, &instance->resources))) {
        instance_free(instance);
        return refuse_instance(log, wish->name, "%s: no memory left", wish->function);
    }
    instance->logs_errors = true;
    instance->log = *log;
    instance->following = wish->following;
    instance->run.use = (uint16_t)wish->use;
    start(instance);
    return instance;
}

void instance_free(Instance *instance) {
    if (instance == NULL) return;
    model_free(&instance->values.machine);
    free(instance->name);
    free(instance->resources);
    free(instance);
}

void instance_reset(Instance *instance) {
    model_free(&instance->values.machine);
    memset(&instance->values, 0, sizeof instance->values);
    start(instance);
}

bool instance_setup(Instance *instance, const char *function, const double *tolerance, double start_time,
                    const double *stop_time) {
    if (!instance_is_in(instance, function, PHASE_INSTANTIATED)) return false;
    if (tolerance != NULL && !(isfinite(*tolerance) && *tolerance > 0.0))
        return instance_refuse(instance, "%s: tolerance = %.17g: allowed is any finite number > 0", function,
                               *tolerance);
    if (!isfinite(start_time))
        return instance_refuse(instance, "%s: startTime = %.17g: allowed is any finite number", function, start_time);
    if (stop_time != NULL && !(isfinite(*stop_time) && *stop_time >= start_time))
        return instance_refuse(instance, "%s: stopTime = %.17g: allowed is any finite number from startTime = %.17g",
                               function, *stop_time, start_time);
    instance->run.time = instance->run.accepted = start_time;
    instance->values.machine.params.tolerance =
        tolerance != NULL ? fmin(fmax(*tolerance, TOLERANCE_MIN), TOLERANCE_MAX) : TOLERANCE_DEFAULT;
    instance_changed(instance);
    return true;
}

bool instance_begin(Instance *instance, const char *function, Phase to) {
    if (!instance_is_in(instance, function, PHASE_INITIALIZATION)) return false;
    if (!instance_provide(instance, function, GROUP_STATE)) return false;
    instance->run.phase = to;
    return true;
}

/* ---- what is valid ---- */

bool instance_compute(Instance *instance, const char *function, unsigned groups) {
    Fault fault;
    Values *values = &instance->values;
    if ((instance->valid & GROUP_STATE) == 0) {
        if (!model_start(&values->machine, &fault)) return instance_refuse(instance, "%s: %s", function, fault.text);
        instance->valid |= GROUP_STATE;
    }
    const unsigned missing = groups & ~instance->valid;
    if (!model_outputs(&values->machine, missing, &values->outputs, &fault))
        return instance_refuse(instance, "%s: %s", function, fault.text);
    if (missing & GROUP_TIME) values->listed.time = instance->run.time;
    if (missing & GROUP_INDICATORS) model_indicators(&values->machine, values->listed.indicator);
    instance->valid |= missing;
    return true;
}

/* ---- phases ---- */

static const char *phase_name(Phase phase) {
    switch (phase) {
        case PHASE_INSTANTIATED: return "instantiated";
        case PHASE_INITIALIZATION: return "initialization mode";
        case PHASE_STEP: return "step mode";
        case PHASE_EVENT: return "event mode";
        case PHASE_CONTINUOUS: return "continuous-time mode";
        case PHASE_SAMPLING: return "inside a step, for inputs";
        case PHASE_WATCHING: return "inside a step, for outputs";
        default: return "terminated";
    }
}

bool instance_refuse_phase(const Instance *instance, const char *function, unsigned phases) {
    char allowed[192] = "";
    size_t length = 0;
    for (unsigned phase = PHASE_INSTANTIATED; phase <= PHASE_WATCHING; phase <<= 1) {
        if ((phases & phase) == 0) continue;
        const char *separator = length > 0 ? " or " : "";
        length +=
            (size_t)snprintf(allowed + length, sizeof allowed - length, "%s%s", separator, phase_name((Phase)phase));
    }
    return instance_refuse(instance, "%s is not allowed in phase \"%s\": allowed is \"%s\"", function,
                           phase_name(instance->run.phase), allowed);
}

const char *use_name(Use use) {
    static const char *const names[] = {[MODEL_EXCHANGE] = "model exchange",
                                        [CO_SIMULATION] = "co-simulation",
                                        [HYBRID_CO_SIMULATION] = "co-simulation with event mode"};
    return names[use];
}

bool instance_is_for(const Instance *instance, const char *function, Use use) {
    if (instance == NULL) return false;
    return instance->run.use == use || instance_refuse(instance, "%s is not allowed in %s: allowed is only %s",
                                                       function, use_name((Use)instance->run.use), use_name(use));
}

bool instance_go(Instance *instance, const char *function, unsigned from, Phase to) {
    if (!instance_is_in(instance, function, from)) return false;
    instance->run.phase = to;
    return true;
}
