/* A small host of the forward FMU, for platforms that run in an emulator: loads the binary as a master does, plays
 * three stick-slip scenes and prints `scene step theta omega events` with all digits.
 *
 *     host binary guid resources table name=reference ...
 *
 * with the URI of a directory that holds groove.csv, the absolute path of the same table, and the value references of
 * modelDescription.xml. Exits with 0, or with 1 at the first call that fails. The torque is made of sums and products
 * alone, so it is the same on every machine.
 */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "library.h"

enum { STEPS = 1000, PRINT_EVERY = 20, PERIOD = 400, MAX_SETTINGS = 12 };

static const double STEP = 0x1p-10; /* s: no rounding in the time */
static const double TORQUE = 12.0;  /* N.m, at the top of the triangle */

static int arguments;
static char **argument;

static void fail(const char *what, const char *text) {
    fprintf(stderr, "host: %s: %s\n", what, text);
    exit(1);
}

static fmi2ValueReference reference(const char *name) {
    const size_t length = strlen(name);
    for (int i = 5; i < arguments; i++)
        if (strncmp(argument[i], name, length) == 0 && argument[i][length] == '=')
            return (fmi2ValueReference)strtoul(argument[i] + length + 1, NULL, 10);
    fail("no value reference", name);
    return 0;
}

static void log_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                        fmi2String category, fmi2String message, ...) {
    (void)environment, (void)status;
    fprintf(stderr, "%s [%s]: %s\n", instance, category, message);
}

static const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};

static fmi2InstantiateTYPE *instantiate;
static fmi2FreeInstanceTYPE *free_instance;
static fmi2SetRealTYPE *set_real;
static fmi2SetIntegerTYPE *set_integer;
static fmi2SetStringTYPE *set_string;
static fmi2GetRealTYPE *get_real;
static fmi2GetIntegerTYPE *get_integer;
static fmi2SetupExperimentTYPE *setup_experiment;
static fmi2EnterInitializationModeTYPE *enter_initialization;
static fmi2ExitInitializationModeTYPE *exit_initialization;
static fmi2DoStepTYPE *do_step;
static fmi2TerminateTYPE *terminate;

static void load(const char *path) {
    void *library = library_open(path);
    if (library == NULL) fail("cannot load", path);
    const struct {
        const char *name;
        void *pointer; /* to the function pointer */
    } functions[] = {
        {"fmi2Instantiate", &instantiate},
        {"fmi2FreeInstance", &free_instance},
        {"fmi2SetReal", &set_real},
        {"fmi2SetInteger", &set_integer},
        {"fmi2SetString", &set_string},
        {"fmi2GetReal", &get_real},
        {"fmi2GetInteger", &get_integer},
        {"fmi2SetupExperiment", &setup_experiment},
        {"fmi2EnterInitializationMode", &enter_initialization},
        {"fmi2ExitInitializationMode", &exit_initialization},
        {"fmi2DoStep", &do_step},
        {"fmi2Terminate", &terminate},
    };
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; i++) {
        void *function = library_find(library, functions[i].name);
        if (function == NULL) fail("no such function", functions[i].name);
        memcpy(functions[i].pointer, &function, sizeof function);
    }
}

typedef struct {
    const char *name;
    double value;
} Setting;

typedef struct {
    const char *name;
    Setting settings[MAX_SETTINGS]; /* of Real variables */
    fmi2Integer profile1, profile2;
    const char *table; /* of cam 2 */
} Scene;

static void check(fmi2Status status, const char *what) {
    if (status != fmi2OK) fail("not fmi2OK", what);
}

static void set_number(fmi2Component fmu, const char *name, double value) {
    const fmi2ValueReference at = reference(name);
    check(set_real(fmu, &at, 1, &value), name);
}

static void set_profile(fmi2Component fmu, const char *name, fmi2Integer value) {
    const fmi2ValueReference at = reference(name);
    check(set_integer(fmu, &at, 1, &value), name);
}

/* 0, up to TORQUE, and down again */
static double triangle(int step) {
    const int phase = step % PERIOD;
    return TORQUE * (double)(phase < PERIOD / 2 ? phase : PERIOD - phase) / (PERIOD / 2);
}

static void print_state(fmi2Component fmu, const char *scene, int step) {
    const fmi2ValueReference motion[] = {reference("theta"), reference("omega")};
    const fmi2ValueReference count = reference("events");
    double values[2];
    fmi2Integer events;
    check(get_real(fmu, motion, 2, values), "fmi2GetReal");
    check(get_integer(fmu, &count, 1, &events), "fmi2GetInteger");
    printf("%s %d %.17g %.17g %d\n", scene, step, values[0], values[1], events);
}

static void play(const Scene *scene) {
    fmi2Component fmu = instantiate(scene->name, fmi2CoSimulation, argument[2], argument[3], &callbacks, 0, 0);
    if (fmu == NULL) fail("fmi2Instantiate", scene->name);
    for (const Setting *s = scene->settings; s->name != NULL; s++) set_number(fmu, s->name, s->value);
    set_profile(fmu, "cam1.profile", scene->profile1);
    set_profile(fmu, "cam2.profile", scene->profile2);
    const fmi2ValueReference table = reference("cam2.table");
    check(set_string(fmu, &table, 1, &scene->table), "cam2.table");
    check(setup_experiment(fmu, 0, 0.0, 0.0, 0, 0.0), "fmi2SetupExperiment");
    check(enter_initialization(fmu), "fmi2EnterInitializationMode");
    check(exit_initialization(fmu), "fmi2ExitInitializationMode");
    for (int step = 0; step < STEPS; step++) {
        set_number(fmu, "tau", triangle(step));
        check(do_step(fmu, step * STEP, STEP, 1), "fmi2DoStep");
        if ((step + 1) % PRINT_EVERY == 0) print_state(fmu, scene->name, step + 1);
    }
    check(terminate(fmu), "fmi2Terminate");
    free_instance(fmu);
}

int main(int count, char **words) {
    arguments = count;
    argument = words;
    if (count < 5) fail("usage", "host binary guid resources table name=reference ...");
    load(words[1]);
    const Scene scenes[] = {
        {"closed_form", {{"shaft.damping", 0.02}, {NULL, 0.0}}, 1, 1, ""},
        {"general",
         {{"damper.c_load", 40.0}, {"damper.q_release", 900.0}, {"inertia.follower_mass", 0.7},
          {"spring.stiffness3", 4e7}, {"stop.restitution", 0.5}, {NULL, 0.0}},
         2, 3, "groove.csv"},
        {"absolute", {{"shaft.damping", 0.02}, {NULL, 0.0}}, 1, 3, words[4]},
    };
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++) play(&scenes[i]);
    return 0;
}
