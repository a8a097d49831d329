/* Several threads, each with instances of its own. */
#include "faults.h"

#include <pthread.h>

enum { THREADS = 4 };

typedef struct {
    const Scene *scene;
    size_t count, first;
    const Picture *expected;
    bool good;
} Work;

/* All scenes, each thread from another one on. */
static void *live_in_thread(void *argument) {
    Work *work = argument;
    work->good = true;
    for (size_t i = 0; i < work->count; i++) {
        const size_t k = (work->first + i) % work->count;
        const Picture found = life(&work->scene[k]);
        work->good = work->good && same(&found, &work->expected[k]);
    }
    return NULL;
}

void check_threads(void) {
    size_t count;
    const Scene *scene = possible_scenes(&count);
    Picture expected[64];
    REQUIRE(count <= COUNT_OF(expected));
    for (size_t i = 0; i < count; i++) expected[i] = life(&scene[i]);
    pthread_t thread[THREADS];
    Work work[THREADS];
    for (size_t i = 0; i < THREADS; i++) {
        work[i] = (Work){scene, count, i * count / THREADS, expected, false};
        REQUIRE(pthread_create(&thread[i], NULL, live_in_thread, &work[i]) == 0);
    }
    for (size_t i = 0; i < THREADS; i++) REQUIRE(pthread_join(thread[i], NULL) == 0 && work[i].good);
    printf("%d threads, %zu scenes\n", THREADS, count);
}
