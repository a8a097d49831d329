/* Replays inputs of the fuzz target without a fuzzer: replay FILE... Each must end without a report. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { LARGEST = 1 << 16 };

static int replay(const char *name) {
    FILE *file = fopen(name, "rb");
    uint8_t *data = malloc(LARGEST);
    if (file == NULL || data == NULL) {
        fprintf(stderr, "%s cannot be read\n", name);
        return 1;
    }
    const size_t size = fread(data, 1, LARGEST, file);
    fclose(file);
    uint8_t *exact = realloc(data, size > 0 ? size : 1); /* so that a sanitizer sees reads behind the end */
    LLVMFuzzerTestOneInput(exact, size);
    free(exact);
    return 0;
}

int main(int argc, char **argv) {
    LLVMFuzzerInitialize(&argc, &argv);
    for (int i = 1; i < argc; i++) {
        printf("%s\n", argv[i]); /* the last line names the input of a report */
        fflush(stdout);
        if (replay(argv[i]) != 0) return 1;
    }
    printf("%d inputs, all as it must be\n", argc - 1);
    return 0;
}
