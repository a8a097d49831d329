/* Files of tables that are wrong, change, or go away. */
#include "checks.h"

/* Each text is refused as the table of a scene, by one message. */
static void check_texts(const Scene *scene, const char *const texts[], size_t count) {
    fmi2Component c = instantiate(&callbacks);
    for (size_t i = 0; i < count; i++) {
        write_text("bad.csv", texts[i]);
        messages = 0;
        REQUIRE(!begin(c, scene) && messages == 1);
        REQUIRE(fmi2Reset(c) == fmi2OK);
    }
    messages = 0;
    remove_table("bad.csv");
    fmi2FreeInstance(c);
}

void check_bad_tables(void) {
    static const char *const texts[] = {
        "",
        "\n",
        "psi_rad,z_m",
        "psi_rad,z_m\n0,0\n1,1\n",
        "psi_rad;z_m\n0;0\n1;1\n2;2\n3;3\n",
        "psi_rad,z_m\n-1,0\n0,0.01\n1,0.02\n2,nan\n",
        "psi_rad,z_m\n-1,0\n0,0.01\n1,0.02\n2\n",
        "psi_rad,z_m\n-1,0\n0,0.01\n0,0.02\n2,0.03\n",
        "psi_rad,z_m\n-1,0\n0,0.01\n1,0.02\n2,0.01",
        "psi_rad,z_m\n1,0\n2,0.01\n3,0.02\n4,0.03\n",
        "psi_rad,z_m\n-1,0\n0,1e400\n1,2e400\n2,3e400\n",
        "psi_rad,z_m\n0,0\n1e-320,1\n2e-320,2\n3e-320,3\n",
        "psi_rad,z_m\n0,0\n1,0.00000000000000000000000000000000000000000000000000000000000000000000000001\n",
    };
    const Scene scene = {"bad table", 1.0, false, {{"cam1.profile", 3.0, NULL}, {"cam1.table", 0.0, "bad.csv"}}};
    check_texts(&scene, texts, COUNT_OF(texts));
}

void check_bad_friction_tables(void) {
    static const char *const texts[] = {
        "",
        "\n",
        "v_m_s,mu",
        "v_m_s,mu\n0,0.2\n1,0.1\n",
        "v_m_s;mu\n0;0.2\n1;0.1\n2;0.1\n",
        "v_m_s,mu\n0,0.2\n1,nan\n2,0.1\n",
        "v_m_s,mu\n0,0.2\n1\n2,0.1\n",
        "v_m_s,mu\n0.1,0.2\n1,0.1\n2,0.1\n",
        "v_m_s,mu\n0,0.2\n0,0.1\n2,0.1\n",
        "v_m_s,mu\n0,0.2\n1,-0.1\n2,0.1\n",
        "v_m_s,mu\n0,0.2\n1e-320,0.1\n2,20\n",
        "v_m_s,R_N,mu\n0,50,0.2\n1,50,0.1\n2,50,0.1\n",
        "v_m_s,R_N,mu\n0,50,0.2\n1,50,0.1\n2,50,0.1\n0,90,0.1\n1,90,0.1\n",
        "v_m_s,R_N,mu\n0,50,0.2\n1,50,0.1\n2,50,0.1\n0,40,0.2\n1,40,0.1\n2,40,0.1\n",
    };
    const Scene scene = {"bad friction table", 1.0, false, {{"cam1.friction_table", 0.0, "bad.csv"}}};
    check_texts(&scene, texts, COUNT_OF(texts));
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

static void lose_table(void) {
    remove_table("two.csv");
}

static void steepen_tables(void) { /* friction jams them */
    write_table("one.csv", 0.4, 0.0);
    write_table("two.csv", 0.4, 0.0);
}

void check_lost_tables(void) {
    const char *with_tables = is_inverse() ? "tables" : "tables, all forces";
    check_lost_table(with_tables, lose_table, write_tables);
    check_lost_table(with_tables, steepen_tables, write_tables);
}
