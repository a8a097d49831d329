/* A locale with a decimal comma. */
#include "faults.h"

#include <locale.h>

enum { SCENES_MAX = 64 };

void check_locale(void) {
    size_t count;
    const Scene *scene = possible_scenes(&count);
    Picture expected[SCENES_MAX];
    REQUIRE(count <= SCENES_MAX);
    for (size_t i = 0; i < count; i++) expected[i] = life(&scene[i]);
    REQUIRE(setlocale(LC_ALL, "") != NULL && localeconv()->decimal_point[0] == ',');
    for (size_t i = 0; i < count; i++) {
        const Picture found = life(&scene[i]);
        REQUIRE(same(&found, &expected[i]));
    }
}
