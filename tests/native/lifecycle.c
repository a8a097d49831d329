/* A whole life of the FMU, called from C, for sanitizers and valgrind: many scenes with random torques
 * through all modes, states saved, restored and sent through bytes, every kind of bad call, resets and
 * many instances. Linked with the FMU's own sources.
 *
 *     lifecycle name=reference ...     the value references of modelDescription.xml
 *
 * Prints a line per scene and exits with 0, or with 1 at the first thing that is not as it must be.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define TEXT(x) #x
#define STRING(x) TEXT(x)
#define REQUIRE(condition)                                                                              \
    do {                                                                                                \
        if (!(condition)) {                                                                             \
            fprintf(stderr, "lifecycle.c:%d: not true: %s (latest message: %s)\n", __LINE__, #condition, \
                    latest_message);                                                                    \
            exit(1);                                                                                    \
        }                                                                                               \
    } while (0)

enum { STEPS = 1000, SNAPSHOT_EVERY = 250, REPLAY = 60, MODES = 6, MAX_SETTINGS = 16 };

static char latest_message[512] = "none";
static int messages;

static void log_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                        fmi2String category, fmi2String message, ...) {
    (void)environment, (void)status;
    snprintf(latest_message, sizeof latest_message, "%s [%s]: %s", instance, category, message);
    messages++;
}

static const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
static const fmi2CallbackFunctions no_callbacks = {NULL, NULL, NULL, NULL, NULL};

static int arguments;
static char **argument;

static fmi2ValueReference reference(const char *name) {
    const size_t length = strlen(name);
    for (int i = 1; i < arguments; i++)
        if (strncmp(argument[i], name, length) == 0 && argument[i][length] == '=')
            return (fmi2ValueReference)strtoul(argument[i] + length + 1, NULL, 10);
    fprintf(stderr, "lifecycle: no value reference given for %s\n", name);
    exit(1);
}

/* xorshift64: the same torques on every machine */
static uint64_t random_state = 88172645463325252u;
static double random_in(double low, double high) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return low + (high - low) * (double)(random_state >> 11) * 0x1p-53;
}

typedef struct {
    const char *name;
    double value;
} Setting;

typedef struct {
    const char *name;
    double torque; /* N.m, amplitude */
    Setting settings[MAX_SETTINGS];
} Scene;

static const Scene scenes[] = {
    {"default", 10.0, {{NULL, 0.0}}},
    {"one contact, no ledger", 10.0, {{"contacts", 1.0}, {"ledger", 0.0}}},
    {"damped, with masses", 10.0,
     {{"damper.c_load", 40.0}, {"damper.c_release", 80.0}, {"inertia.follower_mass", 0.3},
      {"inertia.follower", 3e-5}, {"shaft.damping", 0.01}}},
    {"bouncing stops on both sides of zero", 20.0,
     {{"stop.restitution", 0.6}, {"stop.lower", -0.4}, {"stop.upper", 0.5}, {"initial.theta", 0.1}}},
    {"self-locking", 30.0, {{"cam1.friction", 0.3}, {"cam1.lead_angle", 0.2}, {"spring.stiffness", 5e3}}},
    {"no spring", 1.0, {{"spring.preload", 0.0}, {"spring.stiffness", 0.0}, {"initial.omega", 2.0}}},
    {"overdamped", 10.0, {{"damper.c_load", 4000.0}, {"damper.c_release", 4000.0}}},
    {"two radii, frictionless", 10.0,
     {{"cam1.friction", 0.0}, {"cam2.friction", 0.0}, {"cam1.radius", 0.03}, {"cam2.lead_angle", 0.5}}},
    {"quadratic damper", 10.0, {{"damper.q_load", 300.0}, {"damper.q_release", 300.0}}},
    {"hardening spring", 10.0, {{"spring.stiffness2", 1e6}, {"spring.stiffness3", 1e8}}},
    {"ellipse", 10.0, {{"cam1.profile", 2.0}, {"cam2.profile", 2.0}}},
    {"viscous", 10.0, {{"inertia.shaft", 0.0}, {"damper.c_load", 100.0}, {"damper.c_release", 100.0}}},
    {"rate-independent", 10.0, {{"inertia.shaft", 0.0}}},
};

static void set_real(fmi2Component c, const char *name, double value) {
    const fmi2ValueReference vr = reference(name);
    REQUIRE(fmi2SetReal(c, &vr, 1, &value) == fmi2OK);
}

static fmi2Status set(fmi2Component c, Setting s) {
    const fmi2ValueReference vr = reference(s.name);
    const fmi2Integer integer = (fmi2Integer)s.value;
    if (strcmp(s.name, "contacts") == 0 || strstr(s.name, ".profile")) return fmi2SetInteger(c, &vr, 1, &integer);
    if (strcmp(s.name, "ledger") == 0) return fmi2SetBoolean(c, &vr, 1, &integer);
    return fmi2SetReal(c, &vr, 1, &s.value);
}

static int get_integer(fmi2Component c, const char *name) {
    const fmi2ValueReference vr = reference(name);
    fmi2Integer value = -1;
    REQUIRE(fmi2GetInteger(c, &vr, 1, &value) == fmi2OK);
    return value;
}

static fmi2Component instantiate(const fmi2CallbackFunctions *functions) {
    const fmi2Component c = fmi2Instantiate("lifecycle", fmi2CoSimulation, MODEL_GUID, "file:///nowhere",
                                            functions, fmi2False, fmi2True);
    REQUIRE(c != NULL);
    return c;
}

/* Settings, then initialization mode and out of it. False if the FMU refuses the settings. */
static bool begin(fmi2Component c, const Scene *scene) {
    for (const Setting *s = scene->settings; s->name; s++)
        if (set(c, *s) != fmi2OK) return false;
    REQUIRE(fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK);
    return fmi2EnterInitializationMode(c) == fmi2OK && fmi2ExitInitializationMode(c) == fmi2OK;
}

/* Everything a reader can see that depends on the past, as bits. */
typedef struct {
    double real[12];
    int integer[2];
} Picture;

static Picture picture(fmi2Component c) {
    static const char *const names[] = {"theta", "omega", "z", "v", "alpha", "cam1.reaction",
                                        "energy.work_in", "energy.heat_cam1", "energy.heat_stop",
                                        "energy.residual", "peak.omega", "torque_load"};
    fmi2ValueReference vr[12];
    Picture p;
    memset(&p, 0, sizeof p);
    for (size_t i = 0; i < 12; i++) vr[i] = reference(names[i]);
    REQUIRE(fmi2GetReal(c, vr, 12, p.real) == fmi2OK);
    p.integer[0] = get_integer(c, "mode");
    p.integer[1] = get_integer(c, "events");
    return p;
}

/* One step of a random size under a random torque that is held for a random number of steps. */
static void random_step(fmi2Component c, double *time, double amplitude) {
    static const double sizes[] = {1e-3, 1e-3, 1e-4, 3.7e-3, 2e-2};
    if (random_in(0.0, 1.0) < 0.2) set_real(c, "tau", random_in(-0.6 * amplitude, amplitude));
    if (random_in(0.0, 1.0) < 0.02) set_real(c, "F_ext", random_in(-5.0, 20.0));
    const double h = sizes[(size_t)random_in(0.0, 5.0)];
    REQUIRE(fmi2DoStep(c, *time, h, fmi2False) == fmi2OK);
    *time += h;
}

static Picture replay(fmi2Component c, double time, double amplitude, uint64_t seed) {
    random_state = seed;
    for (int i = 0; i < REPLAY; i++) random_step(c, &time, amplitude);
    return picture(c);
}

static bool same(const Picture *a, const Picture *b) { return memcmp(a, b, sizeof *a) == 0; }

/* From here the run goes on alike: on, restored, and in another instance that got the state as bytes. */
static void check_snapshots(fmi2Component c, const Scene *scene, double time) {
    const uint64_t seed = random_state;
    fmi2FMUstate state = NULL, copy = NULL;
    size_t size = 0;
    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK);
    const Picture first = replay(c, time, scene->torque, seed);
    REQUIRE(fmi2SetFMUstate(c, state) == fmi2OK);
    const Picture second = replay(c, time, scene->torque, seed);
    REQUIRE(same(&first, &second));

    REQUIRE(fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK && size > 0);
    fmi2Byte *bytes = malloc(size);
    REQUIRE(bytes != NULL && fmi2SerializeFMUstate(c, state, bytes, size) == fmi2OK);
    fmi2Component other = instantiate(&no_callbacks);
    REQUIRE(begin(other, scene));
    REQUIRE(fmi2DeSerializeFMUstate(other, bytes, size, &copy) == fmi2OK);
    REQUIRE(fmi2SetFMUstate(other, copy) == fmi2OK);
    const Picture third = replay(other, time, scene->torque, seed);
    REQUIRE(same(&first, &third));
    REQUIRE(fmi2FreeFMUstate(other, &copy) == fmi2OK && copy == NULL);

    bytes[size / 2] ^= 1;
    REQUIRE(fmi2DeSerializeFMUstate(other, bytes, size, &copy) == fmi2Error);
    bytes[size / 2] ^= 1;
    REQUIRE(fmi2DeSerializeFMUstate(other, bytes, size - 1, &copy) == fmi2Error);
    fmi2FreeInstance(other);

    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK); /* into the existing one */
    REQUIRE(fmi2DeSerializeFMUstate(c, bytes, size, &state) == fmi2OK);
    REQUIRE(fmi2SetFMUstate(c, state) == fmi2OK);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK && state == NULL);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK); /* of nothing */
    free(bytes);
    random_state = seed;
}

/* Runs a scene twice, the second time after a reset; returns the set of modes seen, as bits. */
static unsigned live(const Scene *scene) {
    const uint64_t seed = random_state;
    fmi2Component c = instantiate(&callbacks);
    unsigned seen = 0;
    Picture end[2];
    for (int life = 0; life < 2; life++) {
        random_state = seed;
        if (!begin(c, scene)) {
            REQUIRE(messages > 0);
            printf("%s: refused: %s\n", scene->name, latest_message);
            messages = 0;
            fmi2FreeInstance(c);
            return 0;
        }
        double time = 0.0;
        for (int i = 0; i < STEPS; i++) {
            if (i % SNAPSHOT_EVERY == SNAPSHOT_EVERY / 2 && life == 0) check_snapshots(c, scene, time);
            random_step(c, &time, scene->torque);
            const int mode = get_integer(c, "mode");
            REQUIRE(mode >= 1 && mode <= MODES);
            seen |= 1u << mode;
        }
        end[life] = picture(c);
        for (size_t i = 0; i < 10; i++) REQUIRE(isfinite(end[life].real[i]));
        REQUIRE(messages == 0);
        if (life == 0) REQUIRE(fmi2Terminate(c) == fmi2OK);
        REQUIRE(fmi2Reset(c) == fmi2OK);
    }
    REQUIRE(same(&end[0], &end[1]));
    fmi2FreeInstance(c);
    printf("%s: %d steps, %d events, modes", scene->name, 2 * STEPS, end[0].integer[1]);
    for (int mode = 1; mode <= MODES; mode++)
        if (seen & (1u << mode)) printf(" %d", mode);
    printf("\n");
    return seen;
}

/* Each must be refused with a message and leave an instance that a reset brings back to life. */
static void check_bad_calls(void) {
    const fmi2ValueReference unknown = 0xfffffff0u, tau = reference("tau"), theta = reference("theta"),
                             mode = reference("mode"), friction = reference("cam1.friction");
    const double one = 1.0, minus = -1.0, bad[] = {NAN, INFINITY, -INFINITY};
    double value = 0.0;
    fmi2Integer integer = 0;
    fmi2FMUstate state = NULL;
    const fmi2Byte garbage[64] = {0};

    REQUIRE(fmi2Instantiate("x", fmi2CoSimulation, "another guid", NULL, &callbacks, fmi2False, fmi2False) == NULL);
    REQUIRE(fmi2Instantiate("x", fmi2CoSimulation, NULL, NULL, &callbacks, fmi2False, fmi2False) == NULL);

    fmi2Component c = instantiate(&callbacks);
    messages = 0;
#define REFUSED(call)                                                                                   \
    do {                                                                                                \
        messages = 0;                                                                                   \
        REQUIRE((call) == fmi2Error);                                                                   \
        REQUIRE(messages >= 1);                                                                         \
        REQUIRE(fmi2Reset(c) == fmi2OK);                                                                \
    } while (0)
    REFUSED(fmi2DoStep(c, 0.0, 1e-3, fmi2True));
    REFUSED(fmi2ExitInitializationMode(c));
    REFUSED(fmi2SetReal(c, &unknown, 1, &one));
    REFUSED(fmi2GetReal(c, &unknown, 1, &value));
    REFUSED(fmi2GetInteger(c, &tau, 1, &integer));
    REFUSED(fmi2SetInteger(c, &mode, 1, &integer));
    REFUSED(fmi2SetReal(c, &friction, 1, &minus));
    for (size_t i = 0; i < 3; i++) REFUSED(fmi2SetReal(c, &tau, 1, &bad[i]));
    REFUSED(fmi2DeSerializeFMUstate(c, garbage, sizeof garbage, &state));
    REQUIRE(state == NULL);

    const Scene *scene = &scenes[0];
    const double steps[][2] = {{0.0, -1e-3}, {0.0, NAN}, {0.0, INFINITY}, {0.5, 1e-3}, {NAN, 1e-3}};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        REQUIRE(begin(c, scene));
        REFUSED(fmi2DoStep(c, steps[i][0], steps[i][1], fmi2True));
    }
    REQUIRE(begin(c, scene));
    REFUSED(fmi2SetReal(c, &theta, 1, &one));
    REQUIRE(begin(c, scene));
    REFUSED(fmi2EnterInitializationMode(c));
    REQUIRE(begin(c, scene));
    REQUIRE(fmi2DoStep(c, 0.0, 1e-3, fmi2True) == fmi2OK);
    REQUIRE(fmi2Terminate(c) == fmi2OK);
    REFUSED(fmi2DoStep(c, 1e-3, 1e-3, fmi2True));
    REQUIRE(begin(c, scene));
    fmi2FreeInstance(c); /* without terminate */
    fmi2FreeInstance(NULL);

    c = instantiate(&no_callbacks); /* nobody listens */
    REQUIRE(fmi2SetReal(c, &unknown, 1, &one) == fmi2Error);
    fmi2FreeInstance(c);
}

int main(int argc, char **argv) {
    arguments = argc, argument = argv;
    unsigned seen = 0;
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) seen |= live(&scenes[i]);
    for (int mode = 1; mode <= 5; mode++) REQUIRE(seen & (1u << mode));
    check_bad_calls();
    for (int i = 0; i < 300; i++) {
        fmi2Component c = instantiate(i % 2 ? &callbacks : &no_callbacks);
        REQUIRE(begin(c, &scenes[0]));
        REQUIRE(fmi2Reset(c) == fmi2OK);
        fmi2FreeInstance(c);
    }
    printf("lifecycle of %s: all as it must be\n", STRING(MODEL_IDENTIFIER));
    return 0;
}
