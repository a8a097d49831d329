/* Plays scenes of the FMU under random inputs and prints a hash of every bit of every output, one line for each scene:
 * `name, hash`. Where two machines or compilers differ in one last digit, the hashes differ.
 *
 *     hash directory name=reference ... real=reference ... integer=reference ...
 *
 * with the directory of the tables and the value references of modelDescription.xml: by name those of the settings, then
 * those of all variables that are hashed. Linked with the FMU's own sources; or with loaded.c, which loads the binary
 * of an FMU. Scenes, inputs and random numbers are those of ../lifecycle. */
#include "../lifecycle/run.h"

#include <inttypes.h>
#include <string.h>

enum { STEPS = 120, MOST = 400, MODES = 6 };

typedef struct {
    fmi2ValueReference vr[MOST];
    size_t count;
} References;

static References reals, integers;

/* FNV-1a of 64 bits (G. Fowler, L. C. Noll, P. Vo), byte by byte from the lowest one. */
static uint64_t mixed(uint64_t hash, uint64_t word) {
    for (int k = 0; k < 8; k++) hash = (hash ^ (word >> 8 * k & 0xff)) * 1099511628211u;
    return hash;
}

static uint64_t mixed_doubles(uint64_t hash, const double *value, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &value[i], sizeof bits);
        REQUIRE(value[i] == value[i]); /* the bits of a NaN would be those of the processor */
        hash = mixed(hash, bits);
    }
    return hash;
}

static void collect(References *all, const char *kind, int argc, char **argv) {
    const size_t length = strlen(kind);
    for (int i = 2; i < argc; i++) {
        if (strncmp(argv[i], kind, length) != 0 || argv[i][length] != '=') continue;
        REQUIRE(all->count < MOST);
        all->vr[all->count++] = (fmi2ValueReference)strtoul(argv[i] + length + 1, NULL, 10);
    }
}

static uint64_t mixed_outputs(uint64_t hash, fmi2Component c) {
    double real[MOST];
    fmi2Integer integer[MOST];
    REQUIRE(fmi2GetReal(c, reals.vr, reals.count, real) == fmi2OK);
    REQUIRE(fmi2GetInteger(c, integers.vr, integers.count, integer) == fmi2OK);
    hash = mixed_doubles(hash, real, reals.count);
    for (size_t i = 0; i < integers.count; i++) hash = mixed(hash, (uint64_t)(uint32_t)integer[i]);
    return hash;
}

/* The derivatives of speed, position and velocity along the inputs. Without them, where the outputs jump, the status. */
static uint64_t mixed_derivatives(uint64_t hash, fmi2Component c) {
    const fmi2ValueReference unknown[] = {reference(is_inverse() ? "tau" : "alpha")};
    const fmi2ValueReference known[] = {reference(is_inverse() ? "alpha" : "tau"), reference("F_ext")};
    for (size_t k = 0; k < COUNT_OF(known); k++) {
        const double seed = 1.0;
        double change = 0.0;
        const fmi2Status status = fmi2GetDirectionalDerivative(c, unknown, 1, &known[k], 1, &seed, &change);
        hash = status == fmi2OK ? mixed_doubles(hash, &change, 1) : mixed(hash, (uint64_t)status);
    }
    return hash;
}

static unsigned play(const Scene *scene) {
    uint64_t hash = 14695981039346656037u;
    unsigned seen = 0;
    double time = 0.0;
    fmi2Component c = begun(scene);
    random_state = 88172645463325252u;
    for (int i = 0; i < STEPS; i++) {
        random_step(c, &time, scene);
        hash = mixed_outputs(hash, c);
        hash = mixed_derivatives(hash, c);
        seen |= 1u << get_integer(c, "mode");
    }
    fmi2FreeInstance(c);
    printf("%s, %016" PRIx64 "\n", scene->name, hash);
    return seen;
}

int main(int argc, char **argv) {
    if (argc < 3) return 2;
    use_command_line(argc, argv);
    collect(&reals, "real", argc, argv);
    collect(&integers, "integer", argc, argv);
    size_t count;
    const Scene *scene = scenes(&count);
    unsigned seen = 0;
    for (size_t i = 0; i + 1 < count; i++) seen |= play(&scene[i]); /* the last one is of a missing table */
    for (int mode = 1; mode <= (is_inverse() ? 3 : 5); mode++) REQUIRE(seen & (1u << mode));
    return 0;
}
