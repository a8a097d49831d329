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
#include "checks.h"

#include <math.h>

#define TEXT(x) #x
#define STRING(x) TEXT(x)

enum { STEPS = 300, SNAPSHOT_EVERY = 150, MODES = 6 };

unsigned refused(fmi2Component c, const Scene *scene) {
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
        if (i % 10 == 0) {
            check_output_derivatives(c);
            check_derivatives(c);
        }
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

int main(int argc, char **argv) {
    if (argc < 3) return 2;
    use_command_line(argc, argv);
    write_tables();
    size_t count;
    const Scene *scene = scenes(&count);
    unsigned seen = 0;
    for (size_t i = 0; i < count; i++) seen |= live(&scene[i]);
    for (size_t i = 0; i < count; i++) check_model_exchange(&scene[i]);
    for (int mode = 1; mode <= (is_inverse() ? 3 : 5); mode++) REQUIRE(seen & (1u << mode));
    check_bad_calls();
    check_bad_tables();
    check_bad_friction_tables();
    check_lost_tables();
    check_many_lives();
    check_many_at_once();
    printf("lifecycle of %s: all as it must be\n", STRING(MODEL_IDENTIFIER));
    return 0;
}
