/* Seconds of the start-up of an FMU in a process of its own, in four parts: load the library and look up its functions,
 * instantiate, initialise, make the first step.
 *
 *     start_up LIBRARY GUID RESOURCES REFERENCE-OF-TAU */
#define _POSIX_C_SOURCE 199309L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../harness/clock.h"
#include "fmi2FunctionTypes.h"

static void log_nothing(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String message, ...) {
    (void)environment, (void)name, (void)status, (void)category, (void)message;
}

typedef struct {
    fmi2InstantiateTYPE *instantiate;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
    fmi2SetRealTYPE *set_real;
    fmi2DoStepTYPE *do_step;
} Functions;

/* Copies the object pointer of dlsym into a function pointer, as POSIX allows. */
static int look_up(void *library, const char *name, void *function) {
    void *const found = dlsym(library, name);
    memcpy(function, &found, sizeof found);
    return found == NULL;
}

static int load(const char *path, Functions *f) {
    void *const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) return 1;
    return look_up(library, "fmi2Instantiate", &f->instantiate) | look_up(library, "fmi2SetupExperiment", &f->setup) |
           look_up(library, "fmi2EnterInitializationMode", &f->enter) |
           look_up(library, "fmi2ExitInitializationMode", &f->leave) |
           look_up(library, "fmi2SetReal", &f->set_real) | look_up(library, "fmi2DoStep", &f->do_step);
}

int main(int count, char *word[]) {
    static const fmi2CallbackFunctions CALLBACKS = {log_nothing, calloc, free, NULL, NULL};
    if (count != 5) return 2;
    const fmi2ValueReference tau = (fmi2ValueReference)strtoul(word[4], NULL, 10);
    const double torque = 5.0, begin = now();
    Functions f;
    if (load(word[1], &f) != 0) return 3;
    const double loaded = now();
    const fmi2Component c =
        f.instantiate("cam", fmi2CoSimulation, word[2], word[3], &CALLBACKS, fmi2False, fmi2False);
    if (c == NULL) return 4;
    const double instantiated = now();
    int status = (int)f.setup(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) | (int)f.enter(c) | (int)f.leave(c);
    const double initialised = now();
    status |= (int)f.set_real(c, &tau, 1, &torque) | (int)f.do_step(c, 0.0, 1e-3, fmi2True);
    const double stepped = now();
    printf("%.9g %.9g %.9g %.9g\n", loaded - begin, instantiated - loaded, initialised - instantiated,
           stepped - initialised);
    return status;
}
