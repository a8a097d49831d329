/* A fleet of several threads gives the bits of a fleet of one. For ThreadSanitizer, linked with dualcam/fleet.
 *
 *     fleet_threads binary guid reference-of-tau reference-of-theta
 */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../dualcam/fleet/fleet.h"

enum { COUNT = 96, STEPS = 50, ROLLS = 8, THREADS = 4 };

static void fail(const char *what) {
    fprintf(stderr, "fleet_threads: %s\n", what);
    exit(1);
}

static void *library;

/* Copies the object pointer of dlsym() into a function pointer, as POSIX allows. */
static void look_up(const char *name, void *function) {
    void *const found = dlsym(library, name);
    if (found == NULL) fail(name);
    memcpy(function, &found, sizeof found);
}

static FleetFunctions functions_of(const char *path) {
    FleetFunctions f;
    const struct {
        const char *name;
        void *function;
    } all[] = {
        {"fmi2Instantiate", &f.instantiate},
        {"fmi2FreeInstance", &f.free_instance},
        {"fmi2SetupExperiment", &f.setup_experiment},
        {"fmi2EnterInitializationMode", &f.enter_initialization},
        {"fmi2ExitInitializationMode", &f.exit_initialization},
        {"fmi2Reset", &f.reset},
        {"fmi2SetReal", &f.set_real},
        {"fmi2SetInteger", &f.set_integer},
        {"fmi2SetBoolean", &f.set_boolean},
        {"fmi2SetString", &f.set_string},
        {"fmi2GetReal", &f.get_real},
        {"fmi2GetInteger", &f.get_integer},
        {"fmi2GetBoolean", &f.get_boolean},
        {"fmi2DoStep", &f.do_step},
        {"fmi2GetFMUstate", &f.get_state},
        {"fmi2SetFMUstate", &f.set_state},
        {"fmi2FreeFMUstate", &f.free_state},
    };
    library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) fail(dlerror());
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) look_up(all[i].name, all[i].function);
    return f;
}

typedef struct {
    double torque[COUNT][STEPS], angle[COUNT][STEPS];
} Roll;

/* A run of ROLLS calls, the last one a second time from saved states. */
static void run(const FleetFunctions *f, const FleetExperiment *experiment, const FleetPorts *ports, unsigned threads,
                Roll *roll) {
    fmi2FMUstate states[COUNT] = {NULL};
    double times[COUNT];
    Fleet *fleet = fleet_open(f, experiment, COUNT, threads);
    const FleetValues nothing = {0};
    if (fleet == NULL || fleet_instantiate(fleet) != 0 || fleet_start(fleet, &nothing, NULL) != 0) fail("no fleet");
    for (int r = 0; r < ROLLS; r++) {
        for (int i = 0; i < COUNT; i++)
            for (int k = 0; k < STEPS; k++) roll->torque[i][k] = 0.25 * ((7 * i + 3 * k + 11 * r) % 60);
        if (r == ROLLS - 1 && fleet_save(fleet, NULL, states, times) != 0) fail("no states");
        if (fleet_roll(fleet, ports, roll->torque[0], STEPS, 1e-3, roll->angle[0]) != 0) fail("a step failed");
    }
    static Roll again;
    again = *roll;
    if (fleet_restore(fleet, NULL, states, times) != 0 || fleet_free_states(fleet, states) != 0) fail("no states");
    if (fleet_roll(fleet, ports, again.torque[0], STEPS, 1e-3, again.angle[0]) != 0) fail("a step failed");
    if (memcmp(&again, roll, sizeof again) != 0) fail("other bits after a restored state");
    fleet_close(fleet);
}

int main(int argc, char **argv) {
    if (argc != 5) return 2;
    const FleetFunctions f = functions_of(argv[1]);
    const FleetExperiment experiment = {.model = "fleet", .guid = argv[2], .resources = "file:///"};
    const fmi2ValueReference tau = (fmi2ValueReference)strtoul(argv[3], NULL, 10);
    const fmi2ValueReference theta = (fmi2ValueReference)strtoul(argv[4], NULL, 10);
    const FleetPorts ports = {1, 1, &tau, &theta};
    static Roll alone, shared;
    run(&f, &experiment, &ports, 1, &alone);
    run(&f, &experiment, &ports, THREADS, &shared);
    if (memcmp(&alone, &shared, sizeof alone) != 0) fail("other bits with several threads");
    printf("%d instances, %d threads: all as it must be\n", COUNT, THREADS);
    return 0;
}
