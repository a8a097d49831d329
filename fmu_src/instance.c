#include "instance.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "resources.h"

enum { MESSAGE_SIZE = 1024 };

static const char *const ERROR_CATEGORY = "logStatusError";

/* ---- life ---- */

static char *copy_of(const char *text) {
    const size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (copy != NULL) memcpy(copy, text, size);
    return copy;
}

Instance *instance_new(const char *name, const char *location, const fmi2CallbackFunctions *callbacks) {
    Instance *instance = calloc(1, sizeof *instance);
    if (instance == NULL) return NULL;
    instance->name = copy_of(name);
    if (instance->name == NULL || !resources_directory(location, &instance->resources)) {
        instance_free(instance);
        return NULL;
    }
    instance->logs_errors = true;
    if (callbacks != NULL) instance->callbacks = *callbacks;
    instance_reset(instance);
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
    Machine *machine = &instance->values.machine;
    model_free(machine);
    memset(&instance->values, 0, sizeof instance->values);
    variables_start(&instance->values);
    machine->params.tolerance = TOLERANCE_DEFAULT;
    machine->resources = instance->resources;
    instance->run = (Run){.time = 0.0, .phase = PHASE_INSTANTIATED, .with_rates = 0};
    instance_changed(instance);
}

/* ---- what is valid ---- */

static bool refuse_for(const Instance *instance, const char *function, const Fault *fault) {
    instance_refuse(instance, "%s: %s", function, fault->text);
    return false;
}

bool instance_provide(Instance *instance, const char *function, unsigned groups) {
    if ((groups & ~instance->valid) == 0) return true;
    Fault fault;
    Values *values = &instance->values;
    if ((instance->valid & GROUP_STATE) == 0) {
        if (!model_start(&values->machine, &fault)) return refuse_for(instance, function, &fault);
        instance->valid |= GROUP_STATE;
    }
    const unsigned missing = groups & ~instance->valid;
    if (!model_outputs(&values->machine, missing, &values->outputs, &fault))
        return refuse_for(instance, function, &fault);
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
