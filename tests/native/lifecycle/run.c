#include "run.h"

#include <math.h>
#include <string.h>

void set_real(fmi2Component c, const char *name, double value) {
    const fmi2ValueReference vr = reference(name);
    REQUIRE(fmi2SetReal(c, &vr, 1, &value) == fmi2OK);
}

double get_real(fmi2Component c, const char *name) {
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
    if (strcmp(s.name, "contacts") == 0 || ends_with(s.name, ".profile") || ends_with(s.name, "_curvature") ||
        ends_with(s.name, "stribeck_exponent"))
        return fmi2SetInteger(c, &vr, 1, &integer);
    if (strcmp(s.name, "ledger") == 0) return fmi2SetBoolean(c, &vr, 1, &integer);
    return fmi2SetReal(c, &vr, 1, &s.value);
}

int get_integer(fmi2Component c, const char *name) {
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

fmi2Component instantiate_for(fmi2Type use, const fmi2CallbackFunctions *functions) {
    char location[PATH];
    snprintf(location, sizeof location, "file://%s", directory());
    const fmi2Component c = fmi2Instantiate("lifecycle", use, MODEL_GUID, location, functions, fmi2False, fmi2True);
    REQUIRE(c != NULL);
    return c;
}

fmi2Component instantiate(const fmi2CallbackFunctions *functions) {
    return instantiate_for(fmi2CoSimulation, functions);
}

bool begin(fmi2Component c, const Scene *scene) {
    for (const Setting *s = scene->settings; s->name; s++)
        if (set(c, *s) != fmi2OK) return false;
    REQUIRE(fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK);
    return fmi2EnterInitializationMode(c) == fmi2OK && fmi2ExitInitializationMode(c) == fmi2OK;
}

fmi2Component begun(const Scene *scene) {
    const fmi2Component c = instantiate(&callbacks);
    REQUIRE(begin(c, scene));
    return c;
}

Picture picture(fmi2Component c) {
    static const char *const common[] = {
        "theta",           "omega",      "z",          "v", "cam1.reaction", "energy.work_in", "energy.heat_cam1",
        "energy.residual", "peak.omega", "torque_load"};
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

bool same(const Picture *a, const Picture *b) {
    return memcmp(a, b, sizeof *a) == 0;
}

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

/* The cubic from the present angle and speed to others, in one of four ways: by its end, or by derivatives of theta,
 * omega or alpha. An elastic shaft is twisted past the stops. */
static void random_motion(fmi2Component c, const Scene *scene, double h) {
    const double upper = setting_of(scene, "stop.upper", 1.3963), past = setting_of(scene, "shaft.stiffness", 0.0);
    const double theta = get_real(c, "theta"), omega = get_real(c, "omega");
    const double end = past > 0.0 ? random_in(-0.5, upper + 0.5) : random_in(0.2 * upper, 0.8 * upper);
    const double speed = random_in(-0.3, 0.3) * upper / h;
    const double gap = end - theta - omega * h, bend = speed - omega;
    const double second = (6.0 * gap - 2.0 * bend * h) / (h * h), third = (6.0 * bend * h - 12.0 * gap) / (h * h * h);
    const double rate[] = {omega, second, third, 0.0, 0.0, 0.0};
    const int choice = scene->polynomial ? (int)random_in(0.0, 4.0) : 0;
    if (choice == 0) set_real(c, "theta", end), set_real(c, "omega", speed);
    if (choice == 1) set_derivatives(c, "theta", rate);
    if (choice == 2) set_derivatives(c, "omega", rate + 1);
    if (choice == 3) set_real(c, "alpha", second), set_derivatives(c, "alpha", rate + 2);
    /* an elastic shaft follows a polynomial force in many stairs: seldom */
    const bool polynomial = scene->polynomial && (past == 0.0 || chance(0.1));
    if (chance(0.2)) random_load(c, "F_ext", -0.2 * scene->torque, scene->torque, polynomial, h);
}

void random_step(fmi2Component c, double *time, const Scene *scene) {
    static const double sizes[] = {1e-3, 1e-3, 1e-4, 3.7e-3, 2e-2};
    const double h = sizes[(size_t)random_in(0.0, 5.0)];
    if (is_inverse() && chance(0.5)) random_motion(c, scene, h);
    if (!is_inverse()) random_torque(c, scene, h);
    if (chance(0.01)) set_real(c, "damper.c_load", random_in(0.0, 50.0));
    REQUIRE(fmi2DoStep(c, *time, h, fmi2False) == fmi2OK);
    *time += h;
}

Picture replay(fmi2Component c, double time, const Scene *scene, uint64_t seed) {
    random_state = seed;
    for (int i = 0; i < REPLAY; i++) random_step(c, &time, scene);
    return picture(c);
}
