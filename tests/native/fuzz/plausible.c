#include "plausible.h"

#include <string.h>

#include "calls.h"

enum { ZERO = 1, SIGNED = 2, NEGATIVE = 4 };

typedef struct {
    const char *name; /* with which the variable's name ends */
    double low, high;
    int flags;
} Range;

static const Range ranges[] = {
    {".radius", 5e-3, 0.1, 0},
    {".lead_angle", 0.1, 1.4, 0},
    {".ellipse_a", 0.02, 0.5, 0},
    {".ellipse_b", 0.02, 0.5, 0},
    {".cycloid_rise", 5e-3, 0.1, 0},
    {".cycloid_angle", 0.3, 5.0, 0},
    {".friction", 0.01, 0.5, ZERO},
    {".friction_peak", 1.0, 2.0, 0},
    {".stribeck_velocity", 1e-3, 0.1, 0},
    {".friction_viscous", 1e-4, 1e-2, ZERO},
    {".friction_load_exponent", 0.01, 0.5, ZERO | SIGNED},
    {".friction_load", 10.0, 1000.0, 0},
    {".wear", 1e-15, 1e-12, ZERO},
    {".preload", 1.0, 1000.0, ZERO | SIGNED},
    {".stiffness2", 1e3, 1e7, ZERO | SIGNED},
    {".stiffness3", 1e4, 1e9, ZERO | SIGNED},
    {"spring.stiffness", 100.0, 1e5, ZERO},
    {"shaft.stiffness", 1.0, 1000.0, ZERO},
    {".c_load", 1.0, 1e4, ZERO},
    {".c_release", 1.0, 1e4, ZERO},
    {".q_load", 1.0, 1e5, ZERO},
    {".q_release", 1.0, 1e5, ZERO},
    {"inertia.shaft", 1e-4, 1.0, ZERO},
    {"inertia.follower_mass", 1e-2, 10.0, ZERO},
    {"inertia.follower", 1e-5, 1e-2, ZERO},
    {"shaft.damping", 1e-3, 1.0, ZERO},
    {"stop.lower", 0.1, 2.0, ZERO | NEGATIVE},
    {"stop.upper", 0.2, 3.0, 0},
    {"stop.restitution", 0.05, 0.8, ZERO},
    {"initial.theta", 0.01, 2.0, ZERO},
    {"initial.omega", 0.1, 20.0, ZERO | SIGNED},
    {"tau", 0.1, 100.0, ZERO | SIGNED},
    {"F_ext", 0.1, 1000.0, ZERO | SIGNED},
    {"theta", 0.01, 2.0, ZERO},
    {"omega", 0.01, 10.0, ZERO | SIGNED},
    {"alpha", 0.1, 100.0, ZERO | SIGNED},
};

static bool ends_with(const char *text, const char *end) {
    const size_t a = strlen(text), b = strlen(end);
    return a >= b && strcmp(text + a - b, end) == 0;
}

static const Range *find_range(unsigned vr) {
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++)
        if (ends_with(VARIABLES[vr].name, ranges[i].name)) return &ranges[i];
    return NULL;
}

/* A fuzzer watches comparisons of texts, so each name is looked up once. */
static const Range *range_of(unsigned vr) {
    static const Range *found[START_END];
    if (found[vr] == NULL) found[vr] = find_range(vr);
    return found[vr];
}

static double take_size(Run *run, const Range *range) {
    const unsigned byte = take_byte(&run->in);
    if (byte == 0 && range->flags & ZERO) return 0.0;
    if (range->flags & SIGNED) return (byte & 1 ? -1.0 : 1.0) * size_of(byte & 254u, range->low, range->high);
    return (range->flags & NEGATIVE ? -1.0 : 1.0) * size_of(byte, range->low, range->high);
}

const char *take_file_name(Run *run) {
    static const char *const files[] = {"", "groove.csv", "steep.csv", "speed.csv", "load.csv", "none.csv"};
    return files[take_below(&run->in, 6)];
}

static bool set_real(Run *run, unsigned vr) {
    const Range *range = range_of(vr);
    const double value = range != NULL ? take_size(run, range) : 0.0;
    return range != NULL && call_set_reals(run, &vr, 1, &value);
}

/* The limits of an integer are its few possible values. */
static bool set_integer(Run *run, unsigned vr) {
    const int low = (int)LIMITS[vr].min, values = (int)LIMITS[vr].max - low + 1;
    int value = low + (int)take_below(&run->in, (unsigned)values);
    if (VARIABLES[vr].kind == KIND_SIGN && value == 0) value = 1;
    return call_set_integers(run, &vr, 1, &value);
}

static bool set_text(Run *run, unsigned vr) {
    const char *text = take_file_name(run);
    return call_set_texts(run, &vr, 1, &text);
}

static bool is_settable(unsigned vr) {
    const Variable *variable = variable_find(vr);
    return variable != NULL && (variable->causality == CAUSALITY_PARAMETER || variable->causality == CAUSALITY_INPUT);
}

bool set_plausible(Run *run) {
    unsigned vr = take_below(&run->in, START_END);
    while (!is_settable(vr)) vr = (vr + 1) % START_END;
    const int boolean = (int)(take_byte(&run->in) & 1);
    switch (VARIABLES[vr].type) {
        case TYPE_REAL: return set_real(run, vr);
        case TYPE_INTEGER: return set_integer(run, vr);
        case TYPE_BOOLEAN: return call_set_booleans(run, &vr, 1, &boolean);
        default: return set_text(run, vr);
    }
}

bool set_groove_table(Run *run, unsigned cam, const char *file) {
    const unsigned profile = cam == 0 ? VR_CAM1_PROFILE : VR_CAM2_PROFILE;
    const unsigned table = cam == 0 ? VR_CAM1_TABLE : VR_CAM2_TABLE;
    const int value = 3;
    return call_set_integers(run, &profile, 1, &value) && call_set_texts(run, &table, 1, &file);
}

void set_plausible_inputs(Run *run) {
    for (unsigned vr = 0; vr < START_END; vr++)
        if (VARIABLES[vr].causality == CAUSALITY_INPUT) set_real(run, vr);
}

/* z = slope psi + bend psi^2, on [-2.5, 3.5] rad */
static void write_groove(const char *name, double slope, double bend) {
    char text[4096];
    size_t length = (size_t)snprintf(text, sizeof text, "psi_rad,z_m\n");
    for (int k = -25; k <= 35; k++)
        length += (size_t)snprintf(text + length, sizeof text - length, "%.17g,%.17g\n", 0.1 * k,
                                   slope * 0.1 * k + bend * 0.01 * k * k);
    write_file(name, text, length);
}

void write_tables(void) {
    static const char speed[] = "v_m_s,mu\n0,0.2\n0.01,0.15\n0.05,0.1\n0.3,0.12\n1,0.14\n";
    static const char load[] =
        "v_m_s,R_N,mu\n0,10,0.2\n0.1,10,0.15\n1,10,0.16\n0,1000,0.18\n0.1,1000,0.13\n1,1000,0.15\n";
    write_groove("groove.csv", 0.02, 1e-3);
    write_groove("steep.csv", 0.05, 5e-3);
    write_file("speed.csv", speed, sizeof speed - 1);
    write_file("load.csv", load, sizeof load - 1);
}
