/* Many instances of one FMU for FMI 2.0 co-simulation, stepped by one call. This library is no part of an FMU:
 * the Python package loads it, and hands it the functions of an FMU's binary. It includes no file of the FMUs.
 *
 * A call does the same job for each instance: set inputs, step, get outputs. Threads share the instances of a
 * call. No call depends on the number of threads in any bit: instances share nothing. */
#ifndef DUALCAM_FLEET_H
#define DUALCAM_FLEET_H

#include <stddef.h>
#include <stdint.h>

#include "fmi2FunctionTypes.h"

#if defined _WIN32
#define FLEET_EXPORT __declspec(dllexport)
#else
#define FLEET_EXPORT __attribute__((visibility("default")))
#endif

enum { FLEET_TEXT = 512, FLEET_REPORTS = 16 };

/* What the functions of a fleet return instead of a number of instances: a call returned fmi2Fatal, after which FMI
 * allows no further call; an input of an instance that has not failed is not finite, and no instance was stepped; all
 * instances have failed, and none is left to step. */
enum { FLEET_FATAL = -1, FLEET_NOT_FINITE = -2, FLEET_ALL_FAILED = -3 };

/* Functions of the FMU's binary. The last three are NULL where the FMU saves no states. */
typedef struct {
    fmi2InstantiateTYPE *instantiate;
    fmi2FreeInstanceTYPE *free_instance;
    fmi2SetupExperimentTYPE *setup_experiment;
    fmi2EnterInitializationModeTYPE *enter_initialization;
    fmi2ExitInitializationModeTYPE *exit_initialization;
    fmi2ResetTYPE *reset;
    fmi2SetRealTYPE *set_real;
    fmi2SetIntegerTYPE *set_integer;
    fmi2SetBooleanTYPE *set_boolean;
    fmi2SetStringTYPE *set_string;
    fmi2GetRealTYPE *get_real;
    fmi2GetIntegerTYPE *get_integer;
    fmi2GetBooleanTYPE *get_boolean;
    fmi2DoStepTYPE *do_step;
    fmi2GetFMUstateTYPE *get_state;
    fmi2SetFMUstateTYPE *set_state;
    fmi2FreeFMUstateTYPE *free_state;
} FleetFunctions;

/* How every instance is made, and how every run begins. */
typedef struct {
    const char *model;
    const char *guid;
    const char *resources; /* URI */
    double start_time;     /* s */
    double tolerance;      /* relative; 0: the FMU's default */
} FleetExperiment;

/* Variables that are set at one time. Values of instance i begin at [i * count]. */
typedef struct {
    size_t real_count, integer_count, boolean_count, string_count;
    const fmi2ValueReference *real_references, *integer_references, *boolean_references, *string_references;
    const double *reals;
    const int *integers;
    const int *booleans;
    const char *const *strings;
} FleetValues;

/* Real variables that are written before a step, and read after it. */
typedef struct {
    size_t input_count, output_count;
    const fmi2ValueReference *input_references, *output_references;
} FleetPorts;

/* Why an instance failed. */
typedef struct {
    size_t instance;
    char text[FLEET_TEXT];
} FleetReport;

typedef struct Fleet Fleet;

/* Every function below that has `chosen` does its job for the instances i with chosen[i] != 0 (NULL: all), of
 * these only for those that have not failed, and returns the number of instances that failed in this call, or
 * FLEET_FATAL. An instance that failed is left alone by all jobs but fleet_start and fleet_restore. */

/* Instances 0 to count - 1, not yet started. NULL: out of memory, or a thread could not be started. */
FLEET_EXPORT Fleet *fleet_open(const FleetFunctions *functions, const FleetExperiment *experiment, size_t count,
                               unsigned threads);
/* Not in a forked child: its threads are not there. All other functions work there, without threads. */
FLEET_EXPORT void fleet_close(Fleet *fleet);
/* Makes the instances. Returns the number of those that the FMU refused. */
FLEET_EXPORT long fleet_instantiate(Fleet *fleet);
/* A new run: reset, start values, initialization. */
FLEET_EXPORT long fleet_start(Fleet *fleet, const FleetValues *values, const uint8_t *chosen);
FLEET_EXPORT long fleet_set(Fleet *fleet, const FleetValues *values, const uint8_t *chosen);
FLEET_EXPORT long fleet_get_reals(Fleet *fleet, fmi2ValueReference reference, double *values);
FLEET_EXPORT long fleet_get_integers(Fleet *fleet, fmi2ValueReference reference, int *values);
FLEET_EXPORT long fleet_get_booleans(Fleet *fleet, fmi2ValueReference reference, int *values);
/* `steps` steps of `size` s. inputs[count][steps][input_count] -> outputs[count][steps][output_count]. Of instances
 * that have failed the inputs are not read, and the outputs are NaN. */
FLEET_EXPORT long fleet_roll(Fleet *fleet, const FleetPorts *ports, const double *inputs, size_t steps, double size,
                             double *outputs);
/* states[i]: NULL, or a state of instance i, which fleet_save overwrites. times[i]: its time, s. */
FLEET_EXPORT long fleet_save(Fleet *fleet, const uint8_t *chosen, fmi2FMUstate *states, double *times);
FLEET_EXPORT long fleet_restore(Fleet *fleet, const uint8_t *chosen, fmi2FMUstate *states, const double *times);
FLEET_EXPORT long fleet_free_states(Fleet *fleet, fmi2FMUstate *states);

/* failed[i] = 1 where instance i has failed, else 0. */
FLEET_EXPORT void fleet_failed(const Fleet *fleet, uint8_t *failed);
/* times[i]: present time of instance i, s. */
FLEET_EXPORT void fleet_times(const Fleet *fleet, double *times);
/* Reports of the last call, at most FLEET_REPORTS; their number. */
FLEET_EXPORT size_t fleet_reports(const Fleet *fleet, const FleetReport **reports);

#endif
