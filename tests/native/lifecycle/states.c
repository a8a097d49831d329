/* Saved states: restored, as bytes, in other instances, damaged. */
#include "checks.h"

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

void check_snapshots(fmi2Component c, const Scene *scene, double time) {
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
