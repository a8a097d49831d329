#include "scenes.h"

#include <string.h>

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
#define STRIBECK                                                                                           \
    {"cam1.friction_peak", 1.5, NULL}, {"cam1.stribeck_velocity", 0.02, NULL},                             \
    {"cam1.friction_viscous", 1e-3, NULL}, {"cam2.friction_peak", 1.2, NULL},                               \
    {"cam2.stribeck_exponent", 1.0, NULL}, {"cam1.wear", 1e-13, NULL}
#define LOADED                                                                                             \
    {"cam1.friction_load_exponent", -0.2, NULL}, {"cam1.friction_load", 80.0, NULL},                       \
    {"cam2.friction_load_exponent", -0.1, NULL}
#define FRICTION_TABLES                                                                                    \
    {"cam1.friction_table", 0.0, "speed.csv"}, {"cam2.friction_table", 0.0, "load.csv"}

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
    {"friction over the speed", 10.0, false, {STRIBECK}},
    {"ellipses, friction over the speed, all forces", 10.0, true, {ELLIPSES, STRIBECK, MASSES, DAMPED}},
    {"ellipses, friction over the load", 10.0, true, {ELLIPSES, LOADED, DAMPED}},
    {"tables, friction over speed and load", 10.0, false, {TABLES, STRIBECK, LOADED}},
    {"friction tables", 10.0, false, {FRICTION_TABLES, MASSES, CUBIC_SPRING}},
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
    {"ellipses, friction over speed and load", 5.0, true, {ELLIPSES, STRIBECK, LOADED}},
    {"friction tables", 5.0, false, {FRICTION_TABLES, MASSES}},
    {"elastic shaft, friction over the load", 5.0, true, {{"shaft.stiffness", 20.0, NULL}, LOADED}},
    {"no such table", 5.0, false, {{"cam1.profile", 3.0, NULL}, {"cam1.table", 0.0, "none.csv"}}},
};

void write_tables(void) {
    write_table("one.csv", 0.02, 1e-4);
    write_table("two.csv", 0.021, -2e-4);
    write_text("speed.csv", "v_m_s,mu\n0,0.2\n0.005,0.17\n0.02,0.12\n0.1,0.115\n0.2,0.13\n");
    write_text("load.csv",
               "v_m_s,R_N,mu\n0,50,0.2\n0.02,50,0.15\n0.2,50,0.14\n0,200,0.17\n0.02,200,0.13\n0.2,200,0.12\n");
}

const Scene *scenes(size_t *count) {
    *count = is_inverse() ? COUNT_OF(inverse_scenes) : COUNT_OF(forward_scenes);
    return is_inverse() ? inverse_scenes : forward_scenes;
}

const Scene *scene_called(const char *name) {
    size_t count;
    const Scene *scene = scenes(&count);
    for (size_t i = 0; i < count; i++)
        if (strcmp(scene[i].name, name) == 0) return &scene[i];
    fprintf(stderr, "lifecycle: no scene %s\n", name);
    exit(1);
}

double setting_of(const Scene *scene, const char *name, double otherwise) {
    for (const Setting *s = scene->settings; s->name; s++)
        if (strcmp(s->name, name) == 0) return s->value;
    return otherwise;
}
