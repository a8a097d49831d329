#include "run.h"

void require_failed(const Run *run, const char *file, int line, const char *condition) {
    fprintf(stderr, "%s:%d: not true: %s (%d bytes of the input left; latest message: %s)\n", file, line, condition,
            (int)(run->in.end - run->in.at), run->message);
    abort();
}

const char *directory(void) {
    const char *path = getenv("FUZZ_DIRECTORY");
    return path != NULL ? path : ".";
}

void write_file(const char *name, const void *content, size_t size) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", directory(), name);
    FILE *file = fopen(path, "wb");
    const bool good = file != NULL && fwrite(content, 1, size, file) == size && fclose(file) == 0;
    if (good) return;
    fprintf(stderr, "%s cannot be written\n", path);
    abort();
}
