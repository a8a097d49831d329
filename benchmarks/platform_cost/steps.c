/* Blocks of steps, each from the same saved state of the forward FMU.
 *
 *     steps binary guid repeats blocks steps low high tau=reference theta=reference events=reference name=reference=value ...
 *
 * The torque of a step lies between `low` and `high`, N.m. Settings with a decimal point are Real, others Integer.
 * Prints the seconds of all blocks, the least of all repeats, and the angle and the number of mode changes at the
 * end. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "harness/clock.h"
#include "library.h"

enum { LEAD_IN = 10, MOST = 1000, SETTINGS = 8 };

static const double STEP = 1e-3; /* s */

static void *library;

static void *function(const char *name) {
    void *const found = library == NULL ? NULL : library_find(library, name);
    if (found != NULL) return found;
    fprintf(stderr, "steps: no %s\n", name);
    exit(1);
}

#define DECLARE(name) LIBRARY_FUNCTION(name##TYPE, name##_, function(#name))

static void require(fmi2Status status, const char *what) {
    if (status == fmi2OK) return;
    fprintf(stderr, "steps: %s: status %d\n", what, (int)status);
    exit(1);
}

static fmi2ValueReference reference(const char *word) {
    return (fmi2ValueReference)strtoul(strchr(word, '=') + 1, NULL, 10);
}

static void set(fmi2Component c, const char *word) {
    DECLARE(fmi2SetReal);
    DECLARE(fmi2SetInteger);
    const fmi2ValueReference at = reference(word);
    const char *const text = strrchr(word, '=') + 1;
    const fmi2Real real = strtod(text, NULL);
    const fmi2Integer integer = atoi(text);
    if (strchr(text, '.') != NULL) require(fmi2SetReal_.call(c, &at, 1, &real), word);
    else require(fmi2SetInteger_.call(c, &at, 1, &integer), word);
}

static fmi2Component begun(const char *guid, int settings, char **setting) {
    DECLARE(fmi2Instantiate);
    DECLARE(fmi2SetupExperiment);
    DECLARE(fmi2EnterInitializationMode);
    DECLARE(fmi2ExitInitializationMode);
    static const fmi2CallbackFunctions NONE = {NULL, NULL, NULL, NULL, NULL};
    const fmi2Component c = fmi2Instantiate_.call("cam", fmi2CoSimulation, guid, NULL, &NONE, fmi2False, fmi2False);
    require(c == NULL ? fmi2Error : fmi2OK, "fmi2Instantiate");
    for (int k = 0; k < settings; k++) set(c, setting[k]);
    require(fmi2SetupExperiment_.call(c, fmi2False, 0.0, 0.0, fmi2False, 0.0), "fmi2SetupExperiment");
    require(fmi2EnterInitializationMode_.call(c), "fmi2EnterInitializationMode");
    require(fmi2ExitInitializationMode_.call(c), "fmi2ExitInitializationMode");
    return c;
}

typedef struct {
    fmi2SetRealTYPE *set_real;
    fmi2GetRealTYPE *get_real;
    fmi2DoStepTYPE *do_step;
    fmi2SetFMUstateTYPE *set_state;
    fmi2Component component;
    fmi2ValueReference tau, theta;
    double torque[LEAD_IN + MOST];
    int status; /* not fmi2OK if a call was not */
} Run;

static void step(Run *run, int k) {
    run->status |= (int)run->set_real(run->component, &run->tau, 1, &run->torque[k]);
    run->status |= (int)run->do_step(run->component, k * STEP, STEP, fmi2True);
}

/* Seconds of these blocks; `angle` gets that after the last step. */
static double seconds_of_blocks(Run *run, fmi2FMUstate state, int blocks, int steps, double *angle) {
    const double start = now();
    for (int block = 0; block < blocks; block++) {
        run->status |= (int)run->set_state(run->component, state);
        for (int k = LEAD_IN; k < LEAD_IN + steps; k++) {
            step(run, k);
            run->status |= (int)run->get_real(run->component, &run->theta, 1, angle);
        }
    }
    return now() - start;
}

/* Torques between `low` and `high`, by the linear congruential generator of C's standard. */
static void choose_torques(double torque[LEAD_IN + MOST], double low, double high) {
    uint32_t random = 1;
    for (int k = 0; k < LEAD_IN + MOST; k++) {
        random = random * 1103515245u + 12345u;
        torque[k] = low + (high - low) * (double)(random >> 16 & 0x7fff) / 0x8000;
    }
}

int main(int argc, char **argv) {
    if (argc < 11) return 2;
    library = library_open(argv[1]);
    DECLARE(fmi2SetReal);
    DECLARE(fmi2GetReal);
    DECLARE(fmi2GetInteger);
    DECLARE(fmi2DoStep);
    DECLARE(fmi2GetFMUstate);
    DECLARE(fmi2SetFMUstate);
    const int repeats = atoi(argv[3]), blocks = atoi(argv[4]), steps = atoi(argv[5]);
    if (steps > MOST) return 2;
    static Run run;
    run = (Run){.set_real = fmi2SetReal_.call,
                .get_real = fmi2GetReal_.call,
                .do_step = fmi2DoStep_.call,
                .set_state = fmi2SetFMUstate_.call,
                .component = begun(argv[2], argc - 11, argv + 11),
                .tau = reference(argv[8]),
                .theta = reference(argv[9])};
    choose_torques(run.torque, strtod(argv[6], NULL), strtod(argv[7], NULL));
    for (int k = 0; k < LEAD_IN; k++) step(&run, k);
    fmi2FMUstate state = NULL;
    require(fmi2GetFMUstate_.call(run.component, &state), "fmi2GetFMUstate");
    double least = HUGE_VAL, angle = 0.0;
    for (int k = 0; k < repeats; k++) least = fmin(least, seconds_of_blocks(&run, state, blocks, steps, &angle));
    require(run.status == 0 ? fmi2OK : fmi2Error, "a step");
    const fmi2ValueReference events = reference(argv[10]);
    fmi2Integer changes = 0;
    require(fmi2GetInteger_.call(run.component, &events, 1, &changes), "fmi2GetInteger");
    uint64_t bits;
    memcpy(&bits, &angle, sizeof bits);
    printf("%.9f %016" PRIx64 " %d\n", least, bits, changes);
    return 0;
}
