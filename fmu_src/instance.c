#include "instance.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE_SIZE = 1024 };

static const char *const ERROR_CATEGORY = "logStatusError";

/* ---- life ---- */

Instance *instance_new(const char *name, const fmi2CallbackFunctions *callbacks) {
    Instance *instance = calloc(1, sizeof *instance);
    const size_t size = strlen(name) + 1;
    char *copy = malloc(size);
    if (instance == NULL || copy == NULL) {
        free(instance);
        free(copy);
        return NULL;
    }
    memcpy(copy, name, size);
    instance->name = copy;
    instance->logs_errors = true;
    if (callbacks != NULL) instance->callbacks = *callbacks;
    instance_reset(instance);
    return instance;
}

void instance_free(Instance *instance) {
    if (instance == NULL) return;
    free(instance->name);
    free(instance);
}

void instance_reset(Instance *instance) {
    memset(&instance->values, 0, sizeof instance->values);
    variables_start(&instance->values);
    instance->run = (Run){.time = 0.0, .phase = PHASE_INSTANTIATED, .rates_fresh = 0};
    instance_changed(instance);
}

/* ---- what is valid ---- */

static bool start(Instance *instance, const char *function) {
    Fault fault;
    Mechanism *mechanism = &instance->values.mechanism;
    if (!mechanism_check(&mechanism->params, &fault)) {
        instance_refuse(instance, "%s: %s", function, fault.text);
        return false;
    }
    mechanism_start(mechanism);
    instance->valid |= GROUP_STATE;
    return true;
}

bool instance_provide(Instance *instance, const char *function, unsigned groups) {
    if ((groups & ~instance->valid) == 0) return true;
    if ((instance->valid & GROUP_STATE) == 0 && !start(instance, function)) return false;
    const unsigned missing = groups & ~instance->valid;
    const Mechanism *mechanism = &instance->values.mechanism;
    Outputs *outputs = &instance->values.outputs;
    if (missing & GROUP_MOTION) mechanism_motion(mechanism, &outputs->motion);
    if (missing & GROUP_LOADS) mechanism_loads(mechanism, &outputs->loads);
    if (missing & GROUP_ENERGY) mechanism_energy(mechanism, &outputs->energy);
    instance->valid |= missing;
    return true;
}

/* ---- phases ---- */

static const char *phase_name(Phase phase) {
    switch (phase) {
        case PHASE_INSTANTIATED: return "instantiated";
        case PHASE_INITIALIZATION: return "initialization mode";
        case PHASE_STEP: return "step mode";
        default: return "terminated";
    }
}

static void refuse_phase(const Instance *instance, const char *function, unsigned phases) {
    char allowed[128] = "";
    size_t length = 0;
    for (unsigned phase = PHASE_INSTANTIATED; phase <= PHASE_TERMINATED; phase <<= 1) {
        if ((phases & phase) == 0) continue;
        const char *separator = length > 0 ? " or " : "";
        length += (size_t)snprintf(allowed + length, sizeof allowed - length, "%s%s", separator,
                                   phase_name((Phase)phase));
    }
    instance_refuse(instance, "%s is not allowed in phase \"%s\": allowed is \"%s\"", function,
                    phase_name(instance->run.phase), allowed);
}

bool instance_is_in(const Instance *instance, const char *function, unsigned phases) {
    if (instance == NULL) return false;
    if ((instance->run.phase & phases) != 0) return true;
    refuse_phase(instance, function, phases);
    return false;
}

/* ---- messages ---- */

/* FMI reads a message as a printf format with #...# for variables, and masters differ in whether they
 * expand it: with % and # doubled the text is right where they do, and readable where they do not. Bytes
 * that a caller passed in and that are not plain text do not get into the log. */
static void escape(char *escaped, size_t size, const char *text) {
    size_t length = 0;
    for (const char *c = text; *c != '\0' && length + 3 <= size; c++) {
        const bool plain = *c >= ' ' && *c <= '~';
        if (*c == '%' || *c == '#') escaped[length++] = *c;
        escaped[length++] = plain ? *c : '?';
    }
    escaped[length] = '\0';
}

void log_error(const fmi2CallbackFunctions *callbacks, const char *name, const char *text) {
    if (callbacks == NULL || callbacks->logger == NULL) return;
    char message[MESSAGE_SIZE];
    escape(message, sizeof message, text);
    callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, ERROR_CATEGORY, message);
}

fmi2Status instance_refuse(const Instance *instance, const char *format, ...) {
    if (!instance->logs_errors) return fmi2Error;
    char text[MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    log_error(&instance->callbacks, instance->name, text);
    return fmi2Error;
}
