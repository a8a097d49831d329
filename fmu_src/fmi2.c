/* The functions of FMI 2.0 for co-simulation. What they promise: a call that returns fmi2Error has logged
 * one message that says what is allowed, and has changed nothing; the instance goes on as before it.
 * No physics here. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "snapshot.h"

/* A master adds up its time on its own; it may differ from ours by this share. */
static const double TIME_ROUNDING = 1e-12;

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

/* ---- checks common to many calls; each logs what it refuses ---- */

static bool has_array(const Instance *instance, const char *function, size_t n, const void *array,
                      const char *name) {
    if (n == 0 || array != NULL) return true;
    instance_refuse(instance, "%s: %s = NULL, with %zu elements asked for: allowed is an array of that many",
                    function, name, n);
    return false;
}

static bool has_arrays(const Instance *instance, const char *function, size_t n,
                       const fmi2ValueReference references[], const void *values) {
    return has_array(instance, function, n, references, "vr") &&
           has_array(instance, function, n, values, "value");
}

static bool has_pointer(const Instance *instance, const char *function, const void *pointer,
                        const char *name) {
    if (pointer != NULL) return true;
    instance_refuse(instance, "%s: %s = NULL: allowed is a valid address", function, name);
    return false;
}

/* The variable with that reference and type, or NULL. */
static const Variable *find(const Instance *instance, const char *function, fmi2ValueReference reference,
                            Type type) {
    const Variable *variable = variable_find(reference);
    if (variable != NULL && variable->type == type) return variable;
    if (variable == NULL)
        instance_refuse(instance,
                        "%s: no variable has value reference %u: allowed are those of %s variables in "
                        "modelDescription.xml",
                        function, reference, type_name(type));
    else
        instance_refuse(instance, "%s: %s (value reference %u) is %s: allowed are those of %s variables",
                        function, variable->name, reference, type_name(variable->type), type_name(type));
    return NULL;
}

/* ---- life ---- */

static const char *reason_not_to_instantiate(fmi2String name, fmi2Type type, fmi2String guid) {
    if (name == NULL) return "fmi2Instantiate: instanceName = NULL: allowed is any text";
    if (type != fmi2CoSimulation)
        return "fmi2Instantiate: fmuType is not fmi2CoSimulation, which alone is allowed";
    if (guid == NULL) return "fmi2Instantiate: fmuGUID = NULL: allowed is only " MODEL_GUID;
    if (strcmp(guid, MODEL_GUID) != 0)
        return "fmi2Instantiate: fmuGUID is not that of this FMU: allowed is only " MODEL_GUID;
    return NULL;
}

/* `loggingOn` is about debug messages, of which there are none: errors are always reported. */
fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn) {
    (void)visible, (void)loggingOn;
    const char *reason = reason_not_to_instantiate(instanceName, fmuType, fmuGUID);
    Instance *instance = reason == NULL ? instance_new(instanceName, fmuResourceLocation, functions) : NULL;
    if (instance != NULL) return instance;
    log_error(functions, instanceName != NULL ? instanceName : "",
              reason != NULL ? reason : "fmi2Instantiate: no memory left");
    return NULL;
}

void fmi2FreeInstance(fmi2Component c) {
    instance_free(c);
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

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
    Instance *instance = c;
    if (instance == NULL || !has_array(instance, __func__, nCategories, categories, "categories"))
        return fmi2Error;
    bool errors = nCategories == 0;
    for (size_t i = 0; i < nCategories; i++) {
        if (!has_pointer(instance, __func__, categories[i], "a category")) return fmi2Error;
        if (!is_log_category(categories[i]))
            return instance_refuse(
                instance,
                "%s: unknown category \"%.100s\": allowed are the standard ones, such as logStatusError",
                __func__, categories[i]);
        errors =
            errors || strcmp(categories[i], "logStatusError") == 0 || strcmp(categories[i], "logAll") == 0;
    }
    if (errors) instance->logs_errors = loggingOn != fmi2False;
    return fmi2OK;
}

/* A tolerance beyond TOLERANCE_MIN and TOLERANCE_MAX is taken as the nearest of them. The mechanism can go on
 * past the stop time. */
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    Instance *instance = c;
    if (!instance_is_in(instance, __func__, PHASE_INSTANTIATED)) return fmi2Error;
    if (toleranceDefined != fmi2False && !(isfinite(tolerance) && tolerance > 0.0))
        return instance_refuse(instance, "%s: tolerance = %.17g: allowed is any finite number > 0", __func__,
                               tolerance);
    if (!isfinite(startTime))
        return instance_refuse(instance, "%s: startTime = %.17g: allowed is any finite number", __func__,
                               startTime);
    if (stopTimeDefined != fmi2False && !(isfinite(stopTime) && stopTime >= startTime))
        return instance_refuse(instance,
                               "%s: stopTime = %.17g: allowed is any finite number from startTime = %.17g",
                               __func__, stopTime, startTime);
    instance->run.time = startTime;
    instance->values.machine.params.tolerance =
        toleranceDefined != fmi2False ? fmin(fmax(tolerance, TOLERANCE_MIN), TOLERANCE_MAX) : TOLERANCE_DEFAULT;
    instance_changed(instance);
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *instance = c;
    if (!instance_is_in(instance, __func__, PHASE_INSTANTIATED)) return fmi2Error;
    instance->run.phase = PHASE_INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance *instance = c;
    if (!instance_is_in(instance, __func__, PHASE_INITIALIZATION)) return fmi2Error;
    if (!instance_provide(instance, __func__, GROUP_STATE)) return fmi2Error;
    instance->run.phase = PHASE_STEP;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    Instance *instance = c;
    if (!instance_is_in(instance, __func__, PHASE_STEP)) return fmi2Error;
    instance->run.phase = PHASE_TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    if (c == NULL) return fmi2Error;
    instance_reset(c);
    return fmi2OK;
}

/* ---- reading ---- */

/* All variables exist, have that type, and their values are up to date. */
static bool can_read(Instance *instance, const char *function, const fmi2ValueReference vr[], size_t nvr,
                     const void *value, Type type) {
    if (instance == NULL || !has_arrays(instance, function, nvr, vr, value)) return false;
    unsigned groups = 0;
    for (size_t i = 0; i < nvr; i++) {
        const Variable *variable = find(instance, function, vr[i], type);
        if (variable == NULL) return false;
        groups |= variable->group;
    }
    return instance_provide(instance, function, groups);
}

static const void *address(const Instance *instance, fmi2ValueReference reference) {
    return (const char *)&instance->values + VARIABLES[reference].offset;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[]) {
    if (!can_read(c, __func__, vr, nvr, value, TYPE_REAL)) return fmi2Error;
    for (size_t i = 0; i < nvr; i++) value[i] = *(const double *)address(c, vr[i]);
    return fmi2OK;
}

static fmi2Integer integer_value(const Instance *instance, fmi2ValueReference reference) {
    const void *place = address(instance, reference);
    if (VARIABLES[reference].kind != KIND_COUNT) return *(const int *)place;
    const int64_t count = *(const int64_t *)place;
    return count < INT32_MAX ? (fmi2Integer)count : INT32_MAX;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[]) {
    if (!can_read(c, __func__, vr, nvr, value, TYPE_INTEGER)) return fmi2Error;
    for (size_t i = 0; i < nvr; i++) value[i] = integer_value(c, vr[i]);
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[]) {
    if (!can_read(c, __func__, vr, nvr, value, TYPE_BOOLEAN)) return fmi2Error;
    for (size_t i = 0; i < nvr; i++) value[i] = *(const bool *)address(c, vr[i]) ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[]) {
    if (!can_read(c, __func__, vr, nvr, value, TYPE_STRING)) return fmi2Error;
    for (size_t i = 0; i < nvr; i++) value[i] = address(c, vr[i]);
    return fmi2OK;
}

/* ---- setting ----
 * A call that sets nothing but inputs is the hot path: checked, then stored. Any other is carried out on a
 * draft, which replaces the values only if all of the call is good. */

typedef struct {
    Params params;
    MachineInputs inputs;
} Draft; /* the beginning of Values */

_Static_assert(offsetof(Values, machine.params) == offsetof(Draft, params), "one offset for both");
_Static_assert(offsetof(Values, machine.inputs) == offsetof(Draft, inputs), "one offset for both");
_Static_assert(VR_F_EXT < 32, "inputs come first, F_ext last: each has a bit in Run.with_rates");

static Draft draft_of(const Instance *instance) {
    return (Draft){.params = instance->values.machine.params, .inputs = instance->values.machine.inputs};
}

static void *draft_address(Draft *draft, const Variable *variable) {
    return (char *)draft + variable->offset;
}

/* During the run only tunable parameters can be in the draft, see find_settable(). */
static fmi2Status commit(Instance *instance, const char *function, const Draft *draft) {
    Machine *machine = &instance->values.machine;
    if (instance->run.phase == PHASE_STEP) {
        Fault fault;
        if (!model_retune(machine, &draft->params, &fault))
            return instance_refuse(instance, "%s: %s", function, fault.text);
    } else {
        machine->params = draft->params;
    }
    machine->inputs = draft->inputs;
    instance_changed(instance);
    return fmi2OK;
}

static bool can_set(const Instance *instance, const char *function, const fmi2ValueReference vr[], size_t nvr,
                    const void *value) {
    return instance_is_in(instance, function, PHASES_OF_SETTING) &&
           has_arrays(instance, function, nvr, vr, value);
}

static const Variable *find_settable(const Instance *instance, const char *function,
                                     fmi2ValueReference reference, Type type) {
    const Variable *variable = find(instance, function, reference, type);
    if (variable == NULL || variable->causality == CAUSALITY_INPUT) return variable;
    if (variable->causality != CAUSALITY_PARAMETER) {
        instance_refuse(instance, "%s: %s is calculated: allowed are parameters and inputs", function,
                        variable->name);
        return NULL;
    }
    if (variable->variability == VARIABILITY_FIXED && instance->run.phase == PHASE_STEP) {
        instance_refuse(instance,
                        "%s: %s is fixed: allowed is to set it before the end of initialization mode",
                        function, variable->name);
        return NULL;
    }
    return variable;
}

static bool accepts(const Instance *instance, const char *function, const Variable *variable, double value) {
    if (variable_allows(variable, value)) return true;
    instance_refuse(instance, "%s: %s = %s is refused: allowed is %s", function, variable->name,
                    digits_of(value).text, variable_allowed(variable).text);
    return false;
}

static bool accepts_text(const Instance *instance, const char *function, const Variable *variable,
                         fmi2String value) {
    if (value != NULL && variable_allows(variable, (double)strlen(value))) return true;
    instance_refuse(instance, "%s: %s = \"%.100s\" is refused: allowed is %s", function, variable->name,
                    value != NULL ? value : "NULL", variable_allowed(variable).text);
    return false;
}

static bool are_good_inputs(const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[]) {
    for (size_t i = 0; i < nvr; i++) {
        const Variable *variable = variable_find(vr[i]);
        if (variable == NULL || variable->group != GROUP_INPUTS || !isfinite(value[i])) return false;
    }
    return true;
}

static double *input_address(Instance *instance, fmi2ValueReference reference) {
    return (double *)((char *)&instance->values + VARIABLES[reference].offset);
}

static fmi2Status set_reals_on_draft(Instance *instance, const char *function, const fmi2ValueReference vr[],
                                     size_t nvr, const fmi2Real value[]) {
    Draft draft = draft_of(instance);
    for (size_t i = 0; i < nvr; i++) {
        const Variable *variable = find_settable(instance, function, vr[i], TYPE_REAL);
        if (variable == NULL || !accepts(instance, function, variable, value[i])) return fmi2Error;
        *(double *)draft_address(&draft, variable) = value[i];
    }
    return commit(instance, function, &draft);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[]) {
    Instance *instance = c;
    if (!can_set(instance, __func__, vr, nvr, value)) return fmi2Error;
    if (!are_good_inputs(vr, nvr, value)) return set_reals_on_draft(instance, __func__, vr, nvr, value);
    for (size_t i = 0; i < nvr; i++) *input_address(instance, vr[i]) = value[i];
    instance_changed(instance);
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Integer value[]) {
    Instance *instance = c;
    if (!can_set(instance, __func__, vr, nvr, value)) return fmi2Error;
    Draft draft = draft_of(instance);
    for (size_t i = 0; i < nvr; i++) {
        const Variable *variable = find_settable(instance, __func__, vr[i], TYPE_INTEGER);
        if (variable == NULL || !accepts(instance, __func__, variable, value[i])) return fmi2Error;
        *(int *)draft_address(&draft, variable) = value[i];
    }
    return commit(instance, __func__, &draft);
}

/* Any nonzero number is true: masters send 1 and -1. */
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Boolean value[]) {
    Instance *instance = c;
    if (!can_set(instance, __func__, vr, nvr, value)) return fmi2Error;
    Draft draft = draft_of(instance);
    for (size_t i = 0; i < nvr; i++) {
        const Variable *variable = find_settable(instance, __func__, vr[i], TYPE_BOOLEAN);
        if (variable == NULL) return fmi2Error;
        *(bool *)draft_address(&draft, variable) = value[i] != fmi2False;
    }
    return commit(instance, __func__, &draft);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[]) {
    Instance *instance = c;
    if (!can_set(instance, __func__, vr, nvr, value)) return fmi2Error;
    Draft draft = draft_of(instance);
    for (size_t i = 0; i < nvr; i++) {
        const Variable *variable = find_settable(instance, __func__, vr[i], TYPE_STRING);
        if (variable == NULL || !accepts_text(instance, __func__, variable, value[i])) return fmi2Error;
        strncpy(draft_address(&draft, variable), value[i], (size_t)variable->max + 1); /* zeros to the end */
    }
    return commit(instance, __func__, &draft);
}

/* ---- derivatives of inputs and outputs ---- */

static const Variable *find_input(const Instance *instance, const char *function,
                                  fmi2ValueReference reference) {
    const Variable *variable = find(instance, function, reference, TYPE_REAL);
    if (variable == NULL || variable->causality == CAUSALITY_INPUT) return variable;
    instance_refuse(instance, "%s: %s is no input: allowed are inputs", function, variable->name);
    return NULL;
}

static bool is_input_derivative(const Instance *instance, const char *function, fmi2ValueReference reference,
                                fmi2Integer order, fmi2Real value) {
    const Variable *variable = find_input(instance, function, reference);
    if (variable == NULL) return false;
    if (order < 1 || order > INPUT_ORDER) {
        instance_refuse(instance, "%s: %s: derivative of order %d: allowed is 1 to %d", function,
                        variable->name, order, (int)INPUT_ORDER);
        return false;
    }
    if (!isfinite(value)) {
        instance_refuse(instance, "%s: derivative of %s = %.17g: allowed is any finite number", function,
                        variable->name, value);
        return false;
    }
    return true;
}

/* Derivatives hold for one step: without new ones the inputs are constant over the next. The old ones
 * stay until then, since the derivatives of outputs at the end of a step depend on them. */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    Instance *instance = c;
    if (!can_set(instance, __func__, vr, nvr, value) || !has_array(instance, __func__, nvr, order, "order"))
        return fmi2Error;
    for (size_t i = 0; i < nvr; i++)
        if (!is_input_derivative(instance, __func__, vr[i], order[i], value[i])) return fmi2Error;
    if (nvr == 0) return fmi2OK;
    if (instance->run.with_rates == 0) model_forget_rates(&instance->values.machine.inputs);
    for (size_t i = 0; i < nvr; i++) {
        input_address(instance, vr[i])[order[i]] = value[i];
        instance->run.with_rates |= UINT32_C(1) << vr[i];
    }
    instance_changed(instance);
    return fmi2OK;
}

static const Variable *find_output(const Instance *instance, const char *function, fmi2ValueReference reference,
                                   fmi2Integer order) {
    const Variable *variable = find(instance, function, reference, TYPE_REAL);
    if (variable == NULL) return NULL;
    if (variable->causality != CAUSALITY_OUTPUT) {
        instance_refuse(instance, "%s: %s is no output: allowed are outputs", function, variable->name);
        return NULL;
    }
    if (order < 1 || order > MAX_OUTPUT_ORDER) {
        instance_refuse(instance, "%s: %s: derivative of order %d: allowed is 1 to maxOutputDerivativeOrder = %d",
                        function, variable->name, order, (int)MAX_OUTPUT_ORDER);
        return NULL;
    }
    return variable;
}

/* Where an output is refused, so are its derivatives. */
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
    Instance *instance = c;
    if (instance == NULL || !has_arrays(instance, __func__, nvr, vr, value) ||
        !has_array(instance, __func__, nvr, order, "order"))
        return fmi2Error;
    unsigned groups = GROUP_STATE;
    for (size_t i = 0; i < nvr; i++) {
        const Variable *variable = find_output(instance, __func__, vr[i], order[i]);
        if (variable == NULL) return fmi2Error;
        groups |= variable->group;
    }
    if (!instance_provide(instance, __func__, groups)) return fmi2Error;
    for (size_t i = 0; i < nvr; i++)
        value[i] = model_output_derivative(&instance->values.machine, vr[i], order[i]);
    return fmi2OK;
}

/* ---- partial derivatives ---- */

static bool is_unknown(const Instance *instance, const char *function, fmi2ValueReference reference) {
    const Variable *variable = find(instance, function, reference, TYPE_REAL);
    if (variable == NULL) return false;
    if (model_has_partials(reference)) return true;
    instance_refuse(instance, "%s: unknown %s: allowed are outputs and derivatives of states", function, variable->name);
    return false;
}

static bool is_known(const Instance *instance, const char *function, fmi2ValueReference reference, double direction) {
    const Variable *variable = find(instance, function, reference, TYPE_REAL);
    if (variable == NULL) return false;
    if (model_knob(reference) < 0) {
        instance_refuse(instance, "%s: known %s: allowed are Real inputs, states and tunable parameters", function,
                        variable->name);
        return false;
    }
    if (isfinite(direction)) return true;
    instance_refuse(instance, "%s: dvKnown of %s = %g: allowed is any finite number", function, variable->name, direction);
    return false;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[],
                                        size_t nUnknown, const fmi2ValueReference vKnown_ref[], size_t nKnown,
                                        const fmi2Real dvKnown[], fmi2Real dvUnknown[]) {
    Instance *instance = c;
    if (!instance_is_in(instance, __func__, PHASE_INITIALIZATION | PHASE_STEP) ||
        !has_array(instance, __func__, nUnknown, vUnknown_ref, "vUnknown_ref") ||
        !has_array(instance, __func__, nUnknown, dvUnknown, "dvUnknown") ||
        !has_array(instance, __func__, nKnown, vKnown_ref, "vKnown_ref") ||
        !has_array(instance, __func__, nKnown, dvKnown, "dvKnown"))
        return fmi2Error;
    for (size_t i = 0; i < nUnknown; i++)
        if (!is_unknown(instance, __func__, vUnknown_ref[i])) return fmi2Error;
    for (size_t j = 0; j < nKnown; j++)
        if (!is_known(instance, __func__, vKnown_ref[j], dvKnown[j])) return fmi2Error;
    if (!instance_provide(instance, __func__, GROUP_STATE)) return fmi2Error;
    const Machine *machine = &instance->values.machine;
    Partials partials;
    Fault fault;
    for (size_t i = 0; i < nUnknown; i++) /* nothing is written unless all can be */
        if (!model_partials(machine, vUnknown_ref[i], &partials, &fault))
            return instance_refuse(instance, "%s: %s", __func__, fault.text);
    for (size_t i = 0; i < nUnknown; i++) {
        (void)model_partials(machine, vUnknown_ref[i], &partials, &fault);
        double sum = 0.0;
        for (size_t j = 0; j < nKnown; j++) sum += partials.by[model_knob(vKnown_ref[j])] * dvKnown[j];
        dvUnknown[i] = sum;
    }
    return fmi2OK;
}

/* ---- the step ---- */

static bool is_step(const Instance *instance, const char *function, double t, double h) {
    const double time = instance->run.time;
    if (!(h > 0.0 && isfinite(h))) {
        instance_refuse(instance, "%s: communicationStepSize = %.17g: allowed is any finite number > 0",
                        function, h);
        return false;
    }
    if (!(isfinite(t + h) && fabs(t - time) <= TIME_ROUNDING * fmax(h, fmax(fabs(t), fabs(time))))) {
        instance_refuse(instance,
                        "%s: currentCommunicationPoint = %.17g: allowed is only the FMU's time, %.17g",
                        function, t, time);
        return false;
    }
    return true;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    (void)noSetFMUStatePriorToCurrentPoint;
    Instance *instance = c;
    if (!instance_is_in(instance, __func__, PHASE_STEP)) return fmi2Error;
    if (!is_step(instance, __func__, currentCommunicationPoint, communicationStepSize)) return fmi2Error;
    Machine *machine = &instance->values.machine;
    const MachineInputs before = machine->inputs;
    if (instance->run.with_rates == 0) model_forget_rates(&machine->inputs);
    Fault fault;
    if (!model_advance(machine, communicationStepSize, instance->run.with_rates, &fault)) {
        machine->inputs = before;
        return instance_refuse(instance, "%s: %s", __func__, fault.text);
    }
    instance->run.time = currentCommunicationPoint + communicationStepSize;
    instance->run.with_rates = 0;
    instance_changed(instance);
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    if (c == NULL) return fmi2Error;
    return instance_refuse(c, "%s: no step is ever pending: allowed is not to call it", __func__);
}

/* ---- status ---- */

static fmi2Status refuse_status(const Instance *instance, const char *function, fmi2StatusKind kind) {
    if (instance == NULL) return fmi2Error;
    return instance_refuse(
        instance,
        "%s: status kind %d has no answer, no step is ever pending: allowed are fmi2LastSuccessfulTime with "
        "fmi2GetRealStatus and fmi2Terminated with fmi2GetBooleanStatus",
        function, (int)kind);
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value) {
    (void)value;
    return refuse_status(c, __func__, s);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value) {
    const Instance *instance = c;
    if (instance == NULL || s != fmi2LastSuccessfulTime) return refuse_status(instance, __func__, s);
    if (!has_pointer(instance, __func__, value, "value")) return fmi2Error;
    *value = instance->run.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value) {
    (void)value;
    return refuse_status(c, __func__, s);
}

/* The mechanism never asks for the end of the simulation. */
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value) {
    const Instance *instance = c;
    if (instance == NULL || s != fmi2Terminated) return refuse_status(instance, __func__, s);
    if (!has_pointer(instance, __func__, value, "value")) return fmi2Error;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value) {
    (void)value;
    return refuse_status(c, __func__, s);
}

/* ---- states ---- */

static bool is_snapshot(const Instance *instance, const char *function, const void *state) {
    if (snapshot_is_valid(state)) return true;
    instance_refuse(instance,
                    "%s: FMUstate %s: allowed is one from fmi2GetFMUstate or fmi2DeSerializeFMUstate",
                    function, state == NULL ? "= NULL" : "is not of this FMU");
    return false;
}

/* Memory for a state: *state again if it is one, new if it is NULL. Returns NULL if neither works. */
static Snapshot *room_for_state(const Instance *instance, const char *function, const fmi2FMUstate *state) {
    if (!has_pointer(instance, function, state, "FMUstate")) return NULL;
    if (*state != NULL) return is_snapshot(instance, function, *state) ? *state : NULL;
    Snapshot *snapshot = calloc(1, sizeof *snapshot);
    if (snapshot == NULL) instance_refuse(instance, "%s: no memory left", function);
    return snapshot;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    const Instance *instance = c;
    Snapshot *snapshot = instance != NULL ? room_for_state(instance, __func__, FMUstate) : NULL;
    if (snapshot == NULL) return fmi2Error;
    snapshot_take(snapshot, instance);
    *FMUstate = snapshot;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
    Instance *instance = c;
    if (instance == NULL || !is_snapshot(instance, __func__, FMUstate)) return fmi2Error;
    Fault fault;
    if (!snapshot_restore(FMUstate, instance, &fault))
        return instance_refuse(instance, "%s: %s", __func__, fault.text);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    const Instance *instance = c;
    if (instance == NULL) return fmi2Error;
    if (FMUstate == NULL || *FMUstate == NULL) return fmi2OK;
    if (!is_snapshot(instance, __func__, *FMUstate)) return fmi2Error;
    free(*FMUstate);
    *FMUstate = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
    const Instance *instance = c;
    if (instance == NULL || !is_snapshot(instance, __func__, FMUstate) ||
        !has_pointer(instance, __func__, size, "size"))
        return fmi2Error;
    *size = sizeof(SealedSnapshot);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[],
                                 size_t size) {
    const Instance *instance = c;
    if (instance == NULL || !is_snapshot(instance, __func__, FMUstate) ||
        !has_pointer(instance, __func__, serializedState, "serializedState"))
        return fmi2Error;
    if (size < sizeof(SealedSnapshot))
        return instance_refuse(instance, "%s: size = %zu: allowed is at least %zu", __func__, size,
                               sizeof(SealedSnapshot));
    snapshot_seal(FMUstate, serializedState);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
    const Instance *instance = c;
    if (instance == NULL || !has_pointer(instance, __func__, serializedState, "serializedState"))
        return fmi2Error;
    Fault fault;
    Snapshot snapshot;
    if (!snapshot_open(serializedState, size, &snapshot, &fault))
        return instance_refuse(instance, "%s: %s", __func__, fault.text);
    Snapshot *room = room_for_state(instance, __func__, FMUstate);
    if (room == NULL) return fmi2Error;
    memcpy(room, &snapshot, sizeof snapshot);
    *FMUstate = room;
    return fmi2OK;
}
