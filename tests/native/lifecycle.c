/* A whole life of an FMU, called from C, for sanitizers and valgrind: many scenes with random inputs through
 * all modes, states saved, restored and sent through bytes into other instances, every kind of bad call, table
 * files that change or go away, resets and many instances. Linked with the FMU's own sources.
 *
 *     lifecycle directory name=reference ...
 *
 * with a directory to write tables into and the value references of modelDescription.xml, from which it also
 * sees which of the FMUs it is. Prints a line per scene and exits with 0, or with 1 at the first thing that is
 * not as it must be.
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
#define COUNT_OF(array) (sizeof(array) / sizeof(array)[0])

enum {
    STEPS = 300,
    SNAPSHOT_EVERY = 150,
    REPLAY = 40,
    MODES = 6,
    LIVES = 1000,
    AT_ONCE = 50,
    ORDERS = 3,
    MAX_SETTINGS = 16,
    PATH = 1024
};

/* ---- what the command line says ---- */

static int arguments;
static char **argument;

static bool find_reference(const char *name, fmi2ValueReference *found) {
    const size_t length = strlen(name);
    for (int i = 2; i < arguments; i++) {
        if (strncmp(argument[i], name, length) != 0 || argument[i][length] != '=') continue;
        *found = (fmi2ValueReference)strtoul(argument[i] + length + 1, NULL, 10);
        return true;
    }
    return false;
}

static fmi2ValueReference reference(const char *name) {
    fmi2ValueReference found = 0;
    if (find_reference(name, &found)) return found;
    fprintf(stderr, "lifecycle: no value reference given for %s\n", name);
    exit(1);
}

static bool is_inverse(void) {
    fmi2ValueReference found;
    return find_reference("shaft.stiffness", &found);
}

/* ---- messages ---- */

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

/* ---- random numbers ---- */

/* xorshift64: the same inputs on every machine */
static uint64_t random_state = 88172645463325252u;
static double random_in(double low, double high) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return low + (high - low) * (double)(random_state >> 11) * 0x1p-53;
}

static bool chance(double share) { return random_in(0.0, 1.0) < share; }

/* ---- tables ---- */

/* z = slope psi + bend psi^2 in metres, on [-2, 2] rad */
static void write_table(const char *name, double slope, double bend) {
    char path[PATH];
    snprintf(path, sizeof path, "%s/%s", argument[1], name);
    FILE *file = fopen(path, "w");
    REQUIRE(file != NULL);
    fprintf(file, "psi_rad,z_m\n");
    for (int k = -20; k <= 20; k++)
        fprintf(file, "%.17g,%.17g\n", 0.1 * k, slope * 0.1 * k + bend * 0.01 * k * k);
    REQUIRE(fclose(file) == 0);
}

static void write_text(const char *name, const char *text) {
    char path[PATH];
    snprintf(path, sizeof path, "%s/%s", argument[1], name);
    FILE *file = fopen(path, "w");
    REQUIRE(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
}

static void remove_table(const char *name) {
    char path[PATH];
    snprintf(path, sizeof path, "%s/%s", argument[1], name);
    REQUIRE(remove(path) == 0);
}

/* ---- scenes ---- */

typedef struct {
    const char *name;
    double value;
    const char *text; /* of a text variable */
} Setting;

typedef struct {
    const char *name;
    double torque;   /* N.m, amplitude; inverse: N, of the axial force */
    bool polynomial; /* inputs with derivatives up to the third */
    Setting settings[MAX_SETTINGS];
} Scene;

#define ELLIPSES {"cam1.profile", 2.0, NULL}, {"cam2.profile", 2.0, NULL}, {"stop.upper", 0.6, NULL}
#define MIXED_ELLIPSES                                                                                     \
    {"cam1.profile", 2.0, NULL}, {"cam2.profile", 2.0, NULL}, {"cam1.ellipse_curvature", 1.0, NULL},       \
    {"cam1.ellipse_a", 0.15, NULL}, {"cam1.ellipse_b", 0.15, NULL}, {"cam2.ellipse_a", 0.12, NULL},        \
    {"cam2.ellipse_b", 0.12, NULL}
#define TABLES                                                                                             \
    {"cam1.profile", 3.0, NULL}, {"cam2.profile", 3.0, NULL}, {"cam1.table", 0.0, "one.csv"},              \
    {"cam2.table", 0.0, "two.csv"}
#define MASSES {"inertia.follower_mass", 0.3, NULL}, {"inertia.follower", 3e-5, NULL}
#define CUBIC_SPRING {"spring.stiffness2", 1e6, NULL}, {"spring.stiffness3", 1e8, NULL}
#define DAMPED {"damper.c_load", 40.0, NULL}, {"damper.c_release", 80.0, NULL}
#define SQUARE {"damper.q_load", 300.0, NULL}, {"damper.q_release", 500.0, NULL}

static const Scene forward_scenes[] = {
    {"default", 10.0, false, {{NULL, 0.0, NULL}}},
    {"one contact, no ledger", 10.0, false, {{"contacts", 1.0, NULL}, {"ledger", 0.0, NULL}}},
    {"damped, with masses", 10.0, false, {DAMPED, MASSES, {"shaft.damping", 0.01, NULL}}},
    {"bouncing stops on both sides of zero", 20.0, false,
     {{"stop.restitution", 0.6, NULL}, {"stop.lower", -0.4, NULL}, {"stop.upper", 0.5, NULL},
      {"initial.theta", 0.1, NULL}}},
    {"self-locking", 30.0, false,
     {{"cam1.friction", 0.3, NULL}, {"cam1.lead_angle", 0.2, NULL}, {"spring.stiffness", 5e3, NULL}}},
    {"no spring", 1.0, false,
     {{"spring.preload", 0.0, NULL}, {"spring.stiffness", 0.0, NULL}, {"initial.omega", 2.0, NULL}}},
    {"overdamped", 10.0, false, {{"damper.c_load", 4000.0, NULL}, {"damper.c_release", 4000.0, NULL}}},
    {"two radii, frictionless", 10.0, false,
     {{"cam1.friction", 0.0, NULL}, {"cam2.friction", 0.0, NULL}, {"cam1.radius", 0.03, NULL},
      {"cam2.lead_angle", 0.5, NULL}}},
    {"quadratic damper", 10.0, false, {SQUARE}},
    {"hardening spring", 10.0, true, {CUBIC_SPRING}},
    {"viscous", 10.0, true, {{"inertia.shaft", 0.0, NULL}, DAMPED}},
    {"rate-independent", 10.0, false, {{"inertia.shaft", 0.0, NULL}}},
    {"ellipses", 10.0, true, {ELLIPSES}},
    {"ellipses, all forces", 10.0, true,
     {MIXED_ELLIPSES, MASSES, CUBIC_SPRING, DAMPED, {"stop.restitution", 0.5, NULL}}},
    {"viscous ellipses", 10.0, true, {ELLIPSES, {"inertia.shaft", 0.0, NULL}, DAMPED}},
    {"rate-independent ellipses, no ledger", 10.0, true,
     {ELLIPSES, {"inertia.shaft", 0.0, NULL}, {"ledger", 0.0, NULL}}},
    {"tables, all forces", 10.0, true, {TABLES, MASSES, CUBIC_SPRING, DAMPED, SQUARE}},
    {"helix against table, quadratic damper, no inertia", 10.0, true,
     {{"cam2.profile", 3.0, NULL}, {"cam2.table", 0.0, "two.csv"}, {"inertia.shaft", 0.0, NULL}, SQUARE}},
    {"no such table", 10.0, false, {{"cam1.profile", 3.0, NULL}, {"cam1.table", 0.0, "none.csv"}}},
};

static const Scene inverse_scenes[] = {
    {"default", 5.0, false, {{NULL, 0.0, NULL}}},
    {"all forces, one contact", 5.0, true, {MASSES, CUBIC_SPRING, DAMPED, SQUARE, {"contacts", 1.0, NULL}}},
    {"ellipses", 5.0, true, {ELLIPSES, MASSES, DAMPED}},
    {"ellipses, no ledger", 5.0, true, {MIXED_ELLIPSES, CUBIC_SPRING, {"ledger", 0.0, NULL}}},
    {"tables", 5.0, true, {TABLES, MASSES, SQUARE, {"shaft.damping", 0.01, NULL}}},
    {"frictionless", 5.0, true, {{"cam1.friction", 0.0, NULL}, {"cam2.friction", 0.0, NULL}}},
    {"elastic shaft", 5.0, true, {{"shaft.stiffness", 20.0, NULL}, CUBIC_SPRING}},
    {"soft shaft, ellipses", 5.0, true, {ELLIPSES, {"shaft.stiffness", 3.0, NULL}}},
    {"elastic shaft, tables", 5.0, false, {TABLES, {"shaft.stiffness", 20.0, NULL}}},
    {"no such table", 5.0, false, {{"cam1.profile", 3.0, NULL}, {"cam1.table", 0.0, "none.csv"}}},
};

static const Scene *scenes(size_t *count) {
    *count = is_inverse() ? COUNT_OF(inverse_scenes) : COUNT_OF(forward_scenes);
    return is_inverse() ? inverse_scenes : forward_scenes;
}

static const Scene *scene_called(const char *name) {
    size_t count;
    const Scene *scene = scenes(&count);
    for (size_t i = 0; i < count; i++)
        if (strcmp(scene[i].name, name) == 0) return &scene[i];
    fprintf(stderr, "lifecycle: no scene %s\n", name);
    exit(1);
}

static double setting_of(const Scene *scene, const char *name, double otherwise) {
    for (const Setting *s = scene->settings; s->name; s++)
        if (strcmp(s->name, name) == 0) return s->value;
    return otherwise;
}

/* ---- access by name ---- */

static void set_real(fmi2Component c, const char *name, double value) {
    const fmi2ValueReference vr = reference(name);
    REQUIRE(fmi2SetReal(c, &vr, 1, &value) == fmi2OK);
}

static double get_real(fmi2Component c, const char *name) {
    const fmi2ValueReference vr = reference(name);
    double value = NAN;
    REQUIRE(fmi2GetReal(c, &vr, 1, &value) == fmi2OK);
    return value;
}

static bool ends_with(const char *text, const char *end) {
    const size_t a = strlen(text), b = strlen(end);
    return a >= b && strcmp(text + a - b, end) == 0;
}

static fmi2Status set(fmi2Component c, Setting s) {
    const fmi2ValueReference vr = reference(s.name);
    const fmi2Integer integer = (fmi2Integer)s.value;
    if (s.text != NULL) return fmi2SetString(c, &vr, 1, &s.text);
    if (strcmp(s.name, "contacts") == 0 || ends_with(s.name, ".profile") || ends_with(s.name, "_curvature"))
        return fmi2SetInteger(c, &vr, 1, &integer);
    if (strcmp(s.name, "ledger") == 0) return fmi2SetBoolean(c, &vr, 1, &integer);
    return fmi2SetReal(c, &vr, 1, &s.value);
}

static int get_integer(fmi2Component c, const char *name) {
    const fmi2ValueReference vr = reference(name);
    fmi2Integer value = -1;
    REQUIRE(fmi2GetInteger(c, &vr, 1, &value) == fmi2OK);
    return value;
}

static void set_derivatives(fmi2Component c, const char *name, const double rate[ORDERS]) {
    const fmi2ValueReference vr = reference(name), all[ORDERS] = {vr, vr, vr};
    const fmi2Integer order[ORDERS] = {1, 2, 3};
    REQUIRE(fmi2SetRealInputDerivatives(c, all, ORDERS, order, rate) == fmi2OK);
}

/* ---- instances ---- */

static fmi2Component instantiate_for(fmi2Type use, const fmi2CallbackFunctions *functions) {
    char location[PATH];
    snprintf(location, sizeof location, "file://%s", argument[1]);
    const fmi2Component c = fmi2Instantiate("lifecycle", use, MODEL_GUID, location, functions, fmi2False, fmi2True);
    REQUIRE(c != NULL);
    return c;
}

static fmi2Component instantiate(const fmi2CallbackFunctions *functions) {
    return instantiate_for(fmi2CoSimulation, functions);
}

/* Settings, then initialization mode and out of it. False if the FMU refuses the settings. */
static bool begin(fmi2Component c, const Scene *scene) {
    for (const Setting *s = scene->settings; s->name; s++)
        if (set(c, *s) != fmi2OK) return false;
    REQUIRE(fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK);
    return fmi2EnterInitializationMode(c) == fmi2OK && fmi2ExitInitializationMode(c) == fmi2OK;
}

static fmi2Component begun(const Scene *scene) {
    const fmi2Component c = instantiate(&callbacks);
    REQUIRE(begin(c, scene));
    return c;
}

/* Everything a reader can see that depends on the past, as bits. */
enum { REALS = 12 };
typedef struct {
    double real[REALS];
    int integer[2];
} Picture;

static Picture picture(fmi2Component c) {
    static const char *const common[] = {"theta", "omega", "z", "v", "cam1.reaction", "energy.work_in",
                                         "energy.heat_cam1", "energy.residual", "peak.omega", "torque_load"};
    fmi2ValueReference vr[REALS];
    Picture p;
    memset(&p, 0, sizeof p);
    for (size_t i = 0; i < COUNT_OF(common); i++) vr[i] = reference(common[i]);
    vr[REALS - 2] = reference(is_inverse() ? "tau" : "alpha");
    vr[REALS - 1] = reference(is_inverse() ? "theta_cam" : "energy.heat_stop");
    REQUIRE(fmi2GetReal(c, vr, REALS, p.real) == fmi2OK);
    p.integer[0] = get_integer(c, "mode");
    p.integer[1] = get_integer(c, "events");
    return p;
}

static bool same(const Picture *a, const Picture *b) { return memcmp(a, b, sizeof *a) == 0; }

/* ---- random steps ---- */

static void random_rates(fmi2Component c, const char *name, double amplitude, double h) {
    const double size = 0.3 * amplitude;
    const double rate[ORDERS] = {random_in(-size, size) / h, random_in(-size, size) / (h * h),
                                 random_in(-size, size) / (h * h * h)};
    set_derivatives(c, name, rate);
}

static void random_load(fmi2Component c, const char *name, double low, double high, bool polynomial, double h) {
    set_real(c, name, random_in(low, high));
    if (polynomial) random_rates(c, name, high, h);
}

static void random_torque(fmi2Component c, const Scene *scene, double h) {
    if (chance(0.2)) random_load(c, "tau", -0.6 * scene->torque, scene->torque, scene->polynomial && chance(0.5), h);
    if (chance(0.02)) random_load(c, "F_ext", -5.0, 20.0, scene->polynomial, h);
}

/* The cubic from the present angle and speed to others, as `way` tells it: by its end, or by derivatives of theta,
 * omega or alpha. An elastic shaft is twisted past the stops. */
static void random_motion(fmi2Component c, const Scene *scene, double h) {
    const double upper = setting_of(scene, "stop.upper", 1.3963), past = setting_of(scene, "shaft.stiffness", 0.0);
    const double theta = get_real(c, "theta"), omega = get_real(c, "omega");
    const double end = past > 0.0 ? random_in(-0.5, upper + 0.5) : random_in(0.2 * upper, 0.8 * upper);
    const double speed = random_in(-0.3, 0.3) * upper / h;
    const double gap = end - theta - omega * h, bend = speed - omega;
    const double second = (6.0 * gap - 2.0 * bend * h) / (h * h), third = (6.0 * bend * h - 12.0 * gap) / (h * h * h);
    const double rate[] = {omega, second, third, 0.0, 0.0, 0.0};
    const int way = scene->polynomial ? (int)random_in(0.0, 4.0) : 0;
    if (way == 0) set_real(c, "theta", end), set_real(c, "omega", speed);
    if (way == 1) set_derivatives(c, "theta", rate);
    if (way == 2) set_derivatives(c, "omega", rate + 1);
    if (way == 3) set_real(c, "alpha", second), set_derivatives(c, "alpha", rate + 2);
    /* an elastic shaft follows a polynomial force in many stairs: seldom */
    const bool polynomial = scene->polynomial && (past == 0.0 || chance(0.1));
    if (chance(0.2)) random_load(c, "F_ext", -0.2 * scene->torque, scene->torque, polynomial, h);
}

/* One step of a random size under inputs that are held for a random number of steps. */
static void random_step(fmi2Component c, double *time, const Scene *scene) {
    static const double sizes[] = {1e-3, 1e-3, 1e-4, 3.7e-3, 2e-2};
    const double h = sizes[(size_t)random_in(0.0, 5.0)];
    if (is_inverse() && chance(0.5)) random_motion(c, scene, h);
    if (!is_inverse()) random_torque(c, scene, h);
    if (chance(0.01)) set_real(c, "damper.c_load", random_in(0.0, 50.0));
    REQUIRE(fmi2DoStep(c, *time, h, fmi2False) == fmi2OK);
    *time += h;
}

static Picture replay(fmi2Component c, double time, const Scene *scene, uint64_t seed) {
    random_state = seed;
    for (int i = 0; i < REPLAY; i++) random_step(c, &time, scene);
    return picture(c);
}

/* ---- states ---- */

/* A saved state that is sent through bytes goes on in `other` as it did where it came from, whatever `other` was
 * before; frees `other`. */
static void check_elsewhere(fmi2Component other, const fmi2Byte *bytes, size_t size, const Scene *scene, double time,
                            uint64_t seed, const Picture *expected) {
    fmi2FMUstate copy = NULL;
    REQUIRE(fmi2DeSerializeFMUstate(other, bytes, size, &copy) == fmi2OK);
    for (int i = 0; i < 2; i++) {
        REQUIRE(fmi2SetFMUstate(other, copy) == fmi2OK);
        const Picture there = replay(other, time, scene, seed);
        REQUIRE(same(&there, expected));
    }
    REQUIRE(fmi2FreeFMUstate(other, &copy) == fmi2OK && copy == NULL);
    fmi2FreeInstance(other);
}

static void check_damage(fmi2Component c, fmi2Byte *bytes, size_t size) {
    fmi2FMUstate state = NULL;
    const int before = messages;
    bytes[size / 2] ^= 1;
    REQUIRE(fmi2DeSerializeFMUstate(c, bytes, size, &state) == fmi2Error);
    bytes[size / 2] ^= 1;
    REQUIRE(fmi2DeSerializeFMUstate(c, bytes, size - 1, &state) == fmi2Error);
    REQUIRE(state == NULL && messages == before + 2);
    messages = before;
}

/* From here the run goes on alike: on, restored, and in other instances that got the state as bytes. */
static void check_snapshots(fmi2Component c, const Scene *scene, double time) {
    const uint64_t seed = random_state;
    fmi2FMUstate state = NULL;
    size_t size = 0;
    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK);
    const Picture first = replay(c, time, scene, seed);
    REQUIRE(fmi2SetFMUstate(c, state) == fmi2OK);
    const Picture second = replay(c, time, scene, seed);
    REQUIRE(same(&first, &second));

    REQUIRE(fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK && size > 0);
    fmi2Byte *bytes = malloc(size);
    REQUIRE(bytes != NULL && fmi2SerializeFMUstate(c, state, bytes, size) == fmi2OK);
    check_elsewhere(begun(scene), bytes, size, scene, time, seed, &first);
    check_elsewhere(begun(scene_called("default")), bytes, size, scene, time, seed, &first);
    check_elsewhere(begun(scene_called("ellipses")), bytes, size, scene, time, seed, &first);
    check_elsewhere(instantiate(&no_callbacks), bytes, size, scene, time, seed, &first);
    check_damage(c, bytes, size);

    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK); /* into the existing one */
    REQUIRE(fmi2DeSerializeFMUstate(c, bytes, size, &state) == fmi2OK);
    REQUIRE(fmi2SetFMUstate(c, state) == fmi2OK);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK && state == NULL);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK); /* of nothing */
    free(bytes);
    random_state = seed;
}

/* ---- derivatives ---- */

static size_t outputs(fmi2ValueReference vr[4]) {
    static const char *const forward[] = {"theta", "omega", "z", "v"}, *const inverse[] = {"tau", "z", "v"};
    const size_t count = is_inverse() ? COUNT_OF(inverse) : COUNT_OF(forward);
    for (size_t i = 0; i < count; i++) vr[i] = reference(is_inverse() ? inverse[i] : forward[i]);
    return count;
}

/* By time, by inputs and a tunable parameter, and of the latest step. What does not exist is refused with a message. */
static void check_derivatives(fmi2Component c) {
    fmi2ValueReference vr[5];
    const size_t count = outputs(vr);
    const fmi2ValueReference known[] = {reference(is_inverse() ? "alpha" : "tau"), reference("F_ext"),
                                        reference("cam1.friction")};
    const double seed[] = {1.0, -2.0, 0.5};
    for (fmi2Integer order = 1; order <= 2; order++) {
        const fmi2Integer orders[] = {order, order, order, order};
        double value[4];
        REQUIRE(fmi2GetRealOutputDerivatives(c, vr, count, orders, value) == fmi2OK);
        for (size_t i = 0; i < count; i++) REQUIRE(!isnan(value[i]));
    }
    if (!is_inverse()) {
        vr[count] = reference("alpha");
        REQUIRE(!isnan(get_real(c, "step.dtheta_dtau")) && !isnan(get_real(c, "step.domega_dtau")));
    }
    const int before = messages;
    double change[5] = {0.0};
    const size_t unknowns = is_inverse() ? count : count + 1;
    const bool exists =
        fmi2GetDirectionalDerivative(c, vr, unknowns, known, COUNT_OF(known), seed, change) == fmi2OK;
    REQUIRE(messages == (exists ? before : before + 1));
    for (size_t i = 0; i < unknowns; i++) REQUIRE(!isnan(change[i]));
    messages = before;
}

/* ---- a life ---- */

/* A file may have been looked for already: nothing but the message is left of that. */
static unsigned refused(fmi2Component c, const Scene *scene) {
    REQUIRE(messages > 0);
    printf("%s: refused: %s\n", scene->name, latest_message);
    messages = 0;
    fmi2FreeInstance(c);
    return 0;
}

static void print_modes(unsigned seen) {
    for (int mode = 1; mode <= MODES; mode++)
        if (seen & (1u << mode)) printf(" %d", mode);
    printf("\n");
}

static unsigned steps_of(fmi2Component c, const Scene *scene, bool with_snapshots) {
    unsigned seen = 0;
    double time = 0.0;
    for (int i = 0; i < STEPS; i++) {
        if (with_snapshots && i % SNAPSHOT_EVERY == SNAPSHOT_EVERY / 2) check_snapshots(c, scene, time);
        random_step(c, &time, scene);
        const int mode = get_integer(c, "mode");
        REQUIRE(mode >= 1 && mode <= MODES);
        seen |= 1u << mode;
        if (i % 10 == 0) check_derivatives(c);
    }
    return seen;
}

/* Runs a scene twice, the second time after a reset; returns the set of modes seen, as bits. */
static unsigned live(const Scene *scene) {
    const uint64_t seed = random_state;
    fmi2Component c = instantiate(&callbacks);
    unsigned seen = 0;
    Picture end[2];
    for (int life = 0; life < 2; life++) {
        random_state = seed;
        if (!begin(c, scene)) return refused(c, scene);
        seen |= steps_of(c, scene, life == 0);
        end[life] = picture(c);
        for (size_t i = 0; i < 9; i++) REQUIRE(isfinite(end[life].real[i]));
        REQUIRE(messages == 0);
        if (life == 0) REQUIRE(fmi2Terminate(c) == fmi2OK);
        REQUIRE(fmi2Reset(c) == fmi2OK);
    }
    REQUIRE(same(&end[0], &end[1]));
    fmi2FreeInstance(c);
    printf("%s: %d steps, %d events, modes", scene->name, 2 * STEPS, end[0].integer[1]);
    print_modes(seen);
    return seen;
}

/* ---- model exchange ---- */

enum { STATES_MAX = 2, INDICATORS_MAX = 7, EULER_STEPS = 3000 };

static void settle(fmi2Component c) {
    fmi2EventInfo info;
    REQUIRE(fmi2NewDiscreteStates(c, &info) == fmi2OK && !info.newDiscreteStatesNeeded);
    REQUIRE(fmi2EnterContinuousTimeMode(c) == fmi2OK);
}

/* Euler's method, whose steps end well beyond an event. Returns how many events there were. */
static int integrate(fmi2Component c, const Scene *scene) {
    const double h = 1e-4, upper = setting_of(scene, "stop.upper", 1.3963);
    const size_t nx = is_inverse() ? 0 : STATES_MAX, nz = is_inverse() ? 1 : INDICATORS_MAX;
    double x[STATES_MAX], rate[STATES_MAX], before[INDICATORS_MAX], after[INDICATORS_MAX];
    fmi2Boolean enter, end;
    int events = 0;
    for (int i = 1; i <= EULER_STEPS; i++) {
        const double t = i * h, phase = 20.0 * t;
        REQUIRE(fmi2GetEventIndicators(c, before, nz) == fmi2OK && fmi2GetDerivatives(c, rate, nx) == fmi2OK);
        REQUIRE(fmi2GetContinuousStates(c, x, nx) == fmi2OK && fmi2SetTime(c, t) == fmi2OK);
        for (size_t k = 0; k < nx; k++) x[k] += h * rate[k];
        REQUIRE(fmi2SetContinuousStates(c, x, nx) == fmi2OK);
        if (is_inverse()) {
            set_real(c, "theta", upper * (0.5 - 0.4 * cos(phase)));
            set_real(c, "omega", upper * 8.0 * sin(phase));
            set_real(c, "alpha", upper * 160.0 * cos(phase));
        } else {
            set_real(c, "tau", scene->torque * (0.4 + 0.6 * sin(phase)));
        }
        REQUIRE(fmi2CompletedIntegratorStep(c, fmi2True, &enter, &end) == fmi2OK && !enter && !end);
        REQUIRE(fmi2GetEventIndicators(c, after, nz) == fmi2OK);
        bool crossed = false;
        for (size_t k = 0; k < nz; k++) crossed = crossed || (before[k] > 0.0) != (after[k] > 0.0);
        if (!crossed) continue;
        REQUIRE(fmi2EnterEventMode(c) == fmi2OK);
        settle(c);
        check_derivatives(c);
        events++;
    }
    return events;
}

static void exchange(const Scene *scene) {
    fmi2Component c = instantiate_for(fmi2ModelExchange, &callbacks);
    fmi2FMUstate state = NULL;
    if (!begin(c, scene)) { /* without inertia, or without its table */
        (void)refused(c, scene);
        return;
    }
    settle(c);
    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK);
    const int events = integrate(c, scene);
    const Picture first = picture(c);
    REQUIRE(fmi2SetFMUstate(c, state) == fmi2OK && integrate(c, scene) == events);
    const Picture second = picture(c);
    REQUIRE(same(&first, &second) && messages == 0);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK && fmi2Terminate(c) == fmi2OK);
    fmi2FreeInstance(c);
    printf("%s: model exchange, %d events\n", scene->name, events);
}

/* ---- refused calls ---- */

/* Each must be refused with a message and leave an instance that a reset brings back to life. */
#define REFUSED(call)                                                                                   \
    do {                                                                                                \
        messages = 0;                                                                                   \
        REQUIRE((call) == fmi2Error);                                                                   \
        REQUIRE(messages >= 1);                                                                         \
        messages = 0;                                                                                   \
        REQUIRE(fmi2Reset(c) == fmi2OK);                                                                \
    } while (0)

static void check_bad_values(fmi2Component c) {
    const fmi2ValueReference unknown = 0xfffffff0u, input = reference(is_inverse() ? "theta" : "tau"),
                             mode = reference("mode"), friction = reference("cam1.friction"), z = reference("z"),
                             table = reference("cam1.table");
    const double one = 1.0, minus = -1.0, bad[] = {NAN, INFINITY, -INFINITY};
    const fmi2Integer order[] = {1, 4};
    double value = 0.0;
    fmi2Integer integer = 0;
    REFUSED(fmi2SetReal(c, &unknown, 1, &one));
    REFUSED(fmi2GetReal(c, &unknown, 1, &value));
    REFUSED(fmi2GetInteger(c, &input, 1, &integer));
    REFUSED(fmi2SetInteger(c, &mode, 1, &integer));
    REFUSED(fmi2SetReal(c, &friction, 1, &minus));
    REFUSED(fmi2SetReal(c, &z, 1, &one));
    for (size_t i = 0; i < COUNT_OF(bad); i++) REFUSED(fmi2SetReal(c, &input, 1, &bad[i]));
    REFUSED(fmi2SetRealInputDerivatives(c, &z, 1, order, &one));
    REFUSED(fmi2SetRealInputDerivatives(c, &input, 1, order + 1, &one));
    REFUSED(fmi2SetRealInputDerivatives(c, &input, 1, order, bad));

    char path[PATH + 2];
    memset(path, 'x', sizeof path);
    path[sizeof path - 1] = '\0';
    const fmi2String too_long = path + 1, none = NULL;
    REFUSED(fmi2SetString(c, &table, 1, &too_long));
    REFUSED(fmi2SetString(c, &table, 1, &none));
    const fmi2String longest = path + 2;
    REQUIRE(fmi2SetString(c, &table, 1, &longest) == fmi2OK);
    fmi2String read = NULL;
    REQUIRE(fmi2GetString(c, &table, 1, &read) == fmi2OK && strcmp(read, longest) == 0);
    REQUIRE(fmi2Reset(c) == fmi2OK);
}

static void check_bad_life(fmi2Component c) {
    const Scene *scene = scene_called("default");
    const fmi2Byte garbage[64] = {0};
    fmi2FMUstate state = NULL;
    REFUSED(fmi2DoStep(c, 0.0, 1e-3, fmi2True));
    REFUSED(fmi2ExitInitializationMode(c));
    REFUSED(fmi2DeSerializeFMUstate(c, garbage, sizeof garbage, &state));
    REQUIRE(state == NULL);

    const double steps[][2] = {{0.0, -1e-3}, {0.0, NAN}, {0.0, INFINITY}, {0.5, 1e-3}, {NAN, 1e-3}};
    for (size_t i = 0; i < COUNT_OF(steps); i++) {
        REQUIRE(begin(c, scene));
        REFUSED(fmi2DoStep(c, steps[i][0], steps[i][1], fmi2True));
    }
    REQUIRE(begin(c, scene));
    REFUSED(fmi2EnterInitializationMode(c));
    REQUIRE(begin(c, scene));
    REQUIRE(fmi2DoStep(c, 0.0, 1e-3, fmi2True) == fmi2OK);
    REQUIRE(fmi2Terminate(c) == fmi2OK);
    REFUSED(fmi2DoStep(c, 1e-3, 1e-3, fmi2True));
}

/* A motion past the stops is refused, and the way there, too; what is allowed goes on. */
static void check_bad_motion(fmi2Component c) {
    REQUIRE(begin(c, scene_called("ellipses")));
    const fmi2ValueReference theta = reference("theta"), tau = reference("tau");
    const double inside = 0.3, outside = 0.7;
    double value;
    REQUIRE(fmi2SetReal(c, &theta, 1, &outside) == fmi2OK);
    messages = 0;
    REQUIRE(fmi2DoStep(c, 0.0, 1e-3, fmi2True) == fmi2Error);
    REQUIRE(fmi2GetReal(c, &tau, 1, &value) == fmi2Error && messages == 2);
    REQUIRE(fmi2SetReal(c, &theta, 1, &inside) == fmi2OK);
    REQUIRE(fmi2DoStep(c, 0.0, 1e-3, fmi2True) == fmi2OK);
    REQUIRE(fmi2GetReal(c, &tau, 1, &value) == fmi2OK && isfinite(value));
    REQUIRE(fmi2Reset(c) == fmi2OK);
}

static void check_bad_calls(void) {
    REQUIRE(fmi2Instantiate("x", fmi2CoSimulation, "another guid", NULL, &callbacks, fmi2False, fmi2False) == NULL);
    REQUIRE(fmi2Instantiate("x", fmi2CoSimulation, NULL, NULL, &callbacks, fmi2False, fmi2False) == NULL);
    fmi2Component c = instantiate(&callbacks);
    check_bad_values(c);
    check_bad_life(c);
    if (is_inverse()) check_bad_motion(c);
    REQUIRE(begin(c, scene_called("default")));
    fmi2FreeInstance(c); /* without terminate */
    fmi2FreeInstance(NULL);

    const fmi2ValueReference unknown = 0xfffffff0u;
    const double one = 1.0;
    c = instantiate(&no_callbacks); /* nobody listens */
    REQUIRE(fmi2SetReal(c, &unknown, 1, &one) == fmi2Error);
    fmi2FreeInstance(c);
}

/* ---- tables that are wrong, change, or go away ---- */

static void check_bad_tables(void) {
    static const char *const texts[] = {
        "", "\n", "psi_rad,z_m", "psi_rad,z_m\n0,0\n1,1\n", "psi_rad;z_m\n0;0\n1;1\n2;2\n3;3\n",
        "psi_rad,z_m\n-1,0\n0,0.01\n1,0.02\n2,nan\n", "psi_rad,z_m\n-1,0\n0,0.01\n1,0.02\n2\n",
        "psi_rad,z_m\n-1,0\n0,0.01\n0,0.02\n2,0.03\n", "psi_rad,z_m\n-1,0\n0,0.01\n1,0.02\n2,0.01",
        "psi_rad,z_m\n1,0\n2,0.01\n3,0.02\n4,0.03\n", "psi_rad,z_m\n-1,0\n0,1e400\n1,2e400\n2,3e400\n",
        "psi_rad,z_m\n0,0\n1e-320,1\n2e-320,2\n3e-320,3\n",
        "psi_rad,z_m\n0,0\n1,0.00000000000000000000000000000000000000000000000000000000000000000000000001\n",
    };
    const Scene scene = {"bad table", 1.0, false, {{"cam1.profile", 3.0, NULL}, {"cam1.table", 0.0, "bad.csv"}}};
    fmi2Component c = instantiate(&callbacks);
    for (size_t i = 0; i < COUNT_OF(texts); i++) {
        write_text("bad.csv", texts[i]);
        messages = 0;
        REQUIRE(!begin(c, &scene) && messages == 1);
        REQUIRE(fmi2Reset(c) == fmi2OK);
    }
    messages = 0;
    remove_table("bad.csv");
    fmi2FreeInstance(c);
}

/* What an instance does that was refused a state, and one that never heard of it. */
static void check_goes_on(fmi2Component refuser, fmi2Component other, double time, const Scene *scene) {
    const uint64_t seed = random_state;
    const Picture a = replay(refuser, time, scene, seed), b = replay(other, time, scene, seed);
    REQUIRE(same(&a, &b));
}

/* A state holds the path of a table. Whoever has read the file can restore it; for all others it must be there and
 * fit, or they refuse the state and go on as before. */
static void check_lost_table(const char *table_scene, void (*spoil)(void), void (*mend)(void)) {
    const Scene *scene = scene_called(table_scene), *usual = scene_called("ellipses");
    fmi2Component owner = begun(scene), refuser = begun(usual), other = begun(usual);
    const uint64_t seed = random_state;
    replay(refuser, 0.0, usual, seed), replay(other, 0.0, usual, seed);
    fmi2FMUstate state = NULL, present = NULL;
    double time = 0.0, now = 0.0;
    for (int i = 0; i < REPLAY; i++) random_step(owner, &time, scene);
    REQUIRE(fmi2GetFMUstate(owner, &state) == fmi2OK);
    REQUIRE(fmi2GetRealStatus(refuser, fmi2LastSuccessfulTime, &now) == fmi2OK);
    REQUIRE(fmi2GetFMUstate(refuser, &present) == fmi2OK);
    spoil();
    REQUIRE(fmi2SetFMUstate(owner, state) == fmi2OK);
    replay(owner, time, scene, seed);
    messages = 0;
    REQUIRE(fmi2SetFMUstate(refuser, state) == fmi2Error && messages == 1);
    messages = 0;
    check_goes_on(refuser, other, now, usual);
    mend();
    REQUIRE(fmi2SetFMUstate(refuser, state) == fmi2OK);
    REQUIRE(fmi2SetFMUstate(refuser, present) == fmi2OK);
    fmi2FreeInstance(owner); /* the state outlives it */
    REQUIRE(fmi2FreeFMUstate(refuser, &state) == fmi2OK);
    REQUIRE(fmi2FreeFMUstate(refuser, &present) == fmi2OK);
    fmi2FreeInstance(refuser);
    fmi2FreeInstance(other);
}

static void write_tables(void) {
    write_table("one.csv", 0.02, 1e-4);
    write_table("two.csv", 0.021, -2e-4);
}

static void lose_table(void) { remove_table("two.csv"); }

static void steepen_tables(void) { /* friction jams them */
    write_table("one.csv", 0.4, 0.0);
    write_table("two.csv", 0.4, 0.0);
}

/* ---- crowds ---- */

/* Many lives, one after the other and in one instance. */
static void check_many_lives(void) {
    size_t count;
    const Scene *scene = scenes(&count);
    fmi2Component lasting = instantiate(&callbacks);
    for (size_t i = 0; i < LIVES; i++) {
        const Scene *next = i % 20 == 0 ? &scene[i / 20 % (count - 1)] : scene; /* the last one cannot be */
        fmi2Component c = instantiate(i % 2 ? &callbacks : &no_callbacks), both[] = {c, lasting};
        for (size_t k = 0; k < 2; k++) {
            REQUIRE(begin(both[k], next));
            REQUIRE(fmi2DoStep(both[k], 0.0, 1e-3, fmi2True) == fmi2OK);
            if (i % 3 == 0 || k == 1) REQUIRE(fmi2Reset(both[k]) == fmi2OK);
        }
        fmi2FreeInstance(c);
    }
    fmi2FreeInstance(lasting);
}

/* Many at once, that hand a state round. */
static void check_many_at_once(void) {
    size_t count;
    const Scene *scene = scenes(&count);
    fmi2Component crowd[AT_ONCE];
    fmi2FMUstate state = NULL;
    for (size_t i = 0; i < AT_ONCE; i++) {
        crowd[i] = begun(&scene[i % (count - 1)]);
        const bool takes = i > 0 && i % 5 == 0;
        if (takes) REQUIRE(fmi2SetFMUstate(crowd[i], state) == fmi2OK);
        double time = 0.0;
        REQUIRE(fmi2GetRealStatus(crowd[i], fmi2LastSuccessfulTime, &time) == fmi2OK);
        REQUIRE(fmi2DoStep(crowd[i], time, 1e-3, fmi2True) == fmi2OK);
        REQUIRE(fmi2GetFMUstate(crowd[i], &state) == fmi2OK);
    }
    for (size_t i = 0; i < AT_ONCE; i++) { /* in another order than they came */
        const size_t place = 7 * i % AT_ONCE;
        if (i == AT_ONCE - 1) REQUIRE(fmi2FreeFMUstate(crowd[place], &state) == fmi2OK);
        fmi2FreeInstance(crowd[place]);
    }
}

int main(int argc, char **argv) {
    arguments = argc, argument = argv;
    if (argc < 3) return 2;
    write_tables();
    size_t count;
    const Scene *scene = scenes(&count);
    unsigned seen = 0;
    for (size_t i = 0; i < count; i++) seen |= live(&scene[i]);
    for (size_t i = 0; i < count; i++) exchange(&scene[i]);
    for (int mode = 1; mode <= (is_inverse() ? 3 : 5); mode++) REQUIRE(seen & (1u << mode));
    check_bad_calls();
    check_bad_tables();
    const char *with_tables = is_inverse() ? "tables" : "tables, all forces";
    check_lost_table(with_tables, lose_table, write_tables);
    check_lost_table(with_tables, steepen_tables, write_tables);
    check_many_lives();
    check_many_at_once();
    printf("lifecycle of %s: all as it must be\n", STRING(MODEL_IDENTIFIER));
    return 0;
}
