#include "fmi/instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "elementary/elementary.h"
#include "fmi/resources.h"
#include "numerics/tolerances.h"
#include "platform/arithmetic.h"
#include "platform/attributes.h"
#include "platform/memory.h"

enum { MESSAGE_SIZE = 1024 };

const char *const MESSAGE_CATEGORIES[] = {[MESSAGE_ERROR] = "logStatusError", [MESSAGE_WARNING] = "logStatusWarning"};

/* ---- messages ---- */

/* Replaces bytes of the caller's texts that are not plain text. */
static void clean(char *text) {
    for (char *c = text; *c != '\0'; c++) /* at most one turn per character */
        if (*c < ' ' || *c > '~') *c = '?';
}

__attribute__((format(printf, 4, 0))) static void send_message(const Log *log, const char *name, MessageKind kind,
                                                               const char *format, va_list arguments) {
    char text[MESSAGE_SIZE];
    vsnprintf(text, sizeof text, format, arguments);
    clean(text);
    log->send(log, name, kind, text);
}

bool instance_refuse(const Instance *instance, const char *format, ...) {
    if (!instance->logs[MESSAGE_ERROR]) return false;
    va_list arguments;
    va_start(arguments, format);
    send_message(&instance->log, instance->name, MESSAGE_ERROR, format, arguments);
    va_end(arguments);
    return false;
}

void instance_warn(const Instance *instance, const char *format, ...) {
    if (!instance->logs[MESSAGE_WARNING]) return;
    va_list arguments;
    va_start(arguments, format);
    send_message(&instance->log, instance->name, MESSAGE_WARNING, format, arguments);
    va_end(arguments);
}

/* instance_refuse() where there is no instance yet. */
__attribute__((format(printf, 3, 4))) static Instance *refuse_instance(const Log *log, const char *name,
                                                                       const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    send_message(log, name, MESSAGE_ERROR, format, arguments);
    va_end(arguments);
    return NULL;
}

void escape_message(char *escaped, size_t size, const char *text, const char *doubled) {
    size_t length = 0;
    for (const char *c = text; *c != '\0' && length + 3 <= size; c++) { /* at most one turn per character */
        if (strchr(doubled, *c) != NULL) escaped[length++] = *c;
        escaped[length++] = *c;
    }
    escaped[length] = '\0';
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

COLD bool instance_set_logging(Instance *instance, const char *function, bool on, size_t count,
                               const char *const categories[]) {
    if (!instance_is_in(instance, function, ~(unsigned)PHASES_INSIDE_STEP) ||
        !instance_has_array(instance, function, count, categories, "categories"))
        return false;
    bool named[MESSAGE_KINDS] = {count == 0, count == 0};
    for (size_t i = 0; i < count; i++) {
        if (!instance_has_pointer(instance, function, categories[i], "a category")) return false;
        if (!is_log_category(categories[i]))
            return instance_refuse(
                instance, "%s: unknown category \"%.100s\": allowed are the standard ones, such as logStatusError",
                function, categories[i]);
        for (int kind = 0; kind < MESSAGE_KINDS; kind++)
            named[kind] = named[kind] || strcmp(categories[i], MESSAGE_CATEGORIES[kind]) == 0 ||
                          strcmp(categories[i], "logAll") == 0;
    }
    for (int kind = 0; kind < MESSAGE_KINDS; kind++)
        if (named[kind]) instance->logs[kind] = on;
    return true;
}

/* ---- life ---- */

static char *copy_of(const char *text) {
    const size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (copy != NULL) memcpy(copy, text, size);
    return copy;
}

/* Sets start values; all values are zero before. */
static void set_start_values(Instance *instance) {
    FmuModel *model = &instance->values.model;
    variables_start(&instance->values);
    model->params.tolerance = TOLERANCE_DEFAULT;
    model->resources = instance->resources;
    instance->run = (Run){.phase = PHASE_INSTANTIATED, .interface_type = instance->run.interface_type};
    instance_invalidate(instance);
}

Instance *instance_new(const InstanceRequest *request, const Log *log) {
    if (request->name == NULL)
        return refuse_instance(log, "", "%s: instanceName = NULL: allowed is any text", request->function);
    const Guid guid = model_guid();
    if (request->guid == NULL || strcmp(request->guid, guid.text) != 0)
        return refuse_instance(log, request->name, "%s: %s %s: allowed is only %s", request->function,
                               request->guid_name, request->guid == NULL ? "= NULL" : "is not that of this FMU",
                               guid.text);
    Instance *instance = memory_new(sizeof *instance);
    if (instance != NULL) instance->name = copy_of(request->name);
    if (instance == NULL || instance->name == NULL ||
        !(request->location != NULL ? resources_directory(request->location, &instance->resources)
                                    : resources_from_path(request->path, &instance->resources))) {
        instance_free(instance);
        return refuse_instance(log, request->name, "%s: no memory left", request->function);
    }
    instance->logs[MESSAGE_ERROR] = instance->logs[MESSAGE_WARNING] = true;
    instance->log = *log;
    instance->intermediate = request->intermediate;
    instance->run.interface_type = (uint16_t)request->interface_type;
    set_start_values(instance);
    return instance;
}

void instance_free(Instance *instance) {
    if (instance == NULL) return;
    model_free(&instance->values.model);
    free(instance->name);
    free(instance->resources);
    memory_free(instance);
}

void instance_reset(Instance *instance) {
    model_free(&instance->values.model);
    memset(&instance->values, 0, sizeof instance->values);
    set_start_values(instance);
}

bool instance_setup(Instance *instance, const char *function, const double *tolerance, double start_time,
                    const double *stop_time) {
    if (!instance_is_in(instance, function, PHASE_INSTANTIATED)) return false;
    if (tolerance != NULL && !(isfinite(*tolerance) && *tolerance > 0.0))
        return instance_refuse(instance, "%s: tolerance = %s: allowed is any finite number > 0", function,
                               shortest_decimal(*tolerance).text);
    if (!isfinite(start_time))
        return instance_refuse(instance, "%s: startTime = %s: allowed is any finite number", function,
                               shortest_decimal(start_time).text);
    if (stop_time != NULL && !(isfinite(*stop_time) && *stop_time >= start_time))
        return instance_refuse(instance, "%s: stopTime = %s: allowed is any finite number from startTime = %s",
                               function, shortest_decimal(*stop_time).text, shortest_decimal(start_time).text);
    instance->run.time = instance->run.completed_until = start_time;
    instance->values.model.params.tolerance =
        tolerance != NULL ? min_of(max_of(*tolerance, TOLERANCE_MIN), TOLERANCE_MAX) : TOLERANCE_DEFAULT;
    instance_invalidate(instance);
    return true;
}

static bool begin_model_exchange(Instance *instance, Fault *fault) {
    const HostArithmetic host = arithmetic_begin();
    const bool good = model_begin_model_exchange(&instance->values.model, fault);
    arithmetic_end(host);
    return good;
}

/* One warning for each parameter that looks as if it were in another unit. */
static void warn_of_units(const Instance *instance) {
    double value;
    const UnitGuard *guard = NULL;
    while ((guard = variables_strange(&instance->values, guard, &value)) != NULL) { /* at most one turn per guard */
        const Variable *variable = &VARIABLES[guard->variable];
        const bool is_plain = variable->unit == UNIT_ONE;
        const char *space = is_plain ? "" : " ", *unit = is_plain ? "" : UNITS[variable->unit].name;
        const ShortestDecimal given = shortest_decimal(value), meant = shortest_decimal(value / guard->per_unit);
        instance_warn(instance, "%s = %s%s%s: this looks like %s; %s %s is %s%s%s", variable->name, given.text, space,
                      unit, guard->likely, given.text, guard->other_unit, meant.text, space, unit);
    }
}

bool instance_exit_initialization(Instance *instance, const char *function) {
    if (!instance_is_in(instance, function, PHASE_INITIALIZATION)) return false;
    if (!instance_provide(instance, function, GROUP_STATE)) return false;
    Run *run = &instance->run;
    Fault fault;
    if (run->interface_type == INTERFACE_MODEL_EXCHANGE && !begin_model_exchange(instance, &fault))
        return instance_refuse(instance, "%s: %s", function, fault.text);
    run->phase = run->interface_type == INTERFACE_CO_SIMULATION ? PHASE_STEP : PHASE_EVENT;
    warn_of_units(instance);
    return true;
}

/* ---- variables that are computed ---- */

static bool compute(Instance *instance, unsigned groups, Fault *fault) {
    Values *values = &instance->values;
    if ((instance->valid & GROUP_STATE) == 0) {
        if (!model_start(&values->model, fault)) return false;
        instance->valid |= GROUP_STATE;
    }
    const unsigned missing = groups & ~instance->valid;
    if (!model_outputs(&values->model, missing, &values->outputs, fault)) return false;
    if (missing & GROUP_TIME) values->listed.time = instance->run.time;
    if (missing & GROUP_INDICATORS) model_indicators(&values->model, values->listed.indicator);
    instance->valid |= missing;
    return true;
}

bool instance_compute(Instance *instance, const char *function, unsigned groups) {
    Fault fault;
    const HostArithmetic host = arithmetic_begin();
    const bool good = compute(instance, groups, &fault);
    arithmetic_end(host);
    return good || instance_refuse(instance, "%s: %s", function, fault.text);
}

/* ---- phases ---- */

static const char *phase_name(Phase phase) {
    switch (phase) {
        case PHASE_INSTANTIATED: return "instantiated";
        case PHASE_INITIALIZATION: return "initialization mode";
        case PHASE_STEP: return "step mode";
        case PHASE_EVENT: return "event mode";
        case PHASE_CONTINUOUS: return "continuous-time mode";
        case PHASE_INTERMEDIATE_INPUTS: return "inside a step, for inputs";
        case PHASE_INTERMEDIATE_OUTPUTS: return "inside a step, for outputs";
        default: return "terminated";
    }
}

/* The call by which an instance leaves its phase towards one of these phases, without "fmi2" or "fmi3". NULL: the end
 * of the intermediate update. */
static const char *next_call(Phase now, unsigned phases) {
    switch (now) {
        case PHASE_INSTANTIATED: return "EnterInitializationMode";
        case PHASE_INITIALIZATION: return phases & ~(unsigned)PHASES_BEFORE_START ? "ExitInitializationMode" : "Reset";
        case PHASE_INTERMEDIATE_INPUTS:
        case PHASE_INTERMEDIATE_OUTPUTS: return NULL;
        case PHASE_TERMINATED: return "Reset";
        default: break;
    }
    if (phases & PHASE_EVENT) return "EnterEventMode";
    if (phases & PHASE_CONTINUOUS) return "EnterContinuousTimeMode";
    if (phases & PHASE_STEP) return "EnterStepMode";
    return phases & PHASE_TERMINATED ? "Terminate" : "Reset";
}

COLD bool instance_refuse_phase(const Instance *instance, const char *function, unsigned phases) {
    char allowed[192] = "";
    size_t length = 0;
    /* At most one turn per phase. */
    for (unsigned phase = PHASE_INSTANTIATED; phase <= PHASE_INTERMEDIATE_OUTPUTS; phase <<= 1) {
        if ((phases & phase) == 0) continue;
        const char *separator = length > 0 ? " or " : "";
        length +=
            (size_t)snprintf(allowed + length, sizeof allowed - length, "%s%s", separator, phase_name((Phase)phase));
    }
    const char *call = next_call(instance->run.phase, phases);
    if (call == NULL)
        return instance_refuse(instance,
                               "%s is not allowed in phase \"%s\": allowed is \"%s\"; return from the "
                               "intermediate update first",
                               function, phase_name(instance->run.phase), allowed);
    return instance_refuse(instance, "%s is not allowed in phase \"%s\": allowed is \"%s\"; call %.4s%s first",
                           function, phase_name(instance->run.phase), allowed, function, call);
}

const char *interface_name(InterfaceType type) {
    static const char *const names[] = {[INTERFACE_MODEL_EXCHANGE] = "model exchange",
                                        [INTERFACE_CO_SIMULATION] = "co-simulation",
                                        [INTERFACE_HYBRID_CO_SIMULATION] = "co-simulation with event mode"};
    return names[type];
}

COLD static bool refuse_interface(const Instance *instance, const char *function, InterfaceType allowed) {
    return instance_refuse(instance, "%s is not allowed in %s: allowed is only %s", function,
                           interface_name((InterfaceType)instance->run.interface_type), interface_name(allowed));
}

bool instance_has_interface(const Instance *instance, const char *function, InterfaceType type) {
    if (instance == NULL) return false;
    return instance->run.interface_type == type || refuse_interface(instance, function, type);
}

bool instance_is_co_simulation(const Instance *instance, const char *function) {
    if (instance == NULL) return false;
    return instance->run.interface_type != INTERFACE_MODEL_EXCHANGE ||
           refuse_interface(instance, function, INTERFACE_CO_SIMULATION);
}

bool instance_change_phase(Instance *instance, const char *function, unsigned from, Phase to) {
    if (!instance_is_in(instance, function, from)) return false;
    instance->run.phase = to;
    return true;
}
