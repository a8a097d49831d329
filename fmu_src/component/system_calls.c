/* The system calls of WebAssembly's C library (WASI, preview 1), as the component answers them: one directory with the
 * tables that the component holds, to be read from the beginning to the end, and nothing else.
 *
 * The linker takes these functions in place of the host's: they have the names that the C library imports, and its
 * types of arguments. There an address is a number: with a pointer here, link-time optimisation would take the calls in
 * the library for calls that write no memory. What WASI defines is marked so. */
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "component/resource_files.h"

/* Replaced in a finished component, so its values may not be known to the optimiser. */
__attribute__((used)) static const volatile ResourceFiles FILES = {.mark = FILES_MARK};

/* WASI's error numbers */
enum { GOOD = 0, BAD_DESCRIPTOR = 8, NO_SUCH_FILE = 44 };
/* WASI's kinds of file */
enum { KIND_DIRECTORY = 3, KIND_FILE = 4 };
/* Descriptors: 0 to 2 are the usual streams; then come the directory and the files. */
enum { DIRECTORY = 3, FIRST_FILE = 4 };

static uint32_t places[FILE_COUNT]; /* where each file is read next */

#define I32(name) __attribute__((unused)) int32_t name
#define I64(name) __attribute__((unused)) int64_t name
#define SYSTEM_CALL(call, ...)                                                                                         \
    int32_t __imported_wasi_snapshot_preview1_##call(__VA_ARGS__);                                                     \
    int32_t __imported_wasi_snapshot_preview1_##call(__VA_ARGS__)

/* The memory of the C library. It is copied: the library's objects have types of its own. */
static void *at(int32_t address) {
    return (void *)(uintptr_t)(uint32_t)address;
}

static void put(int32_t address, const void *object, size_t size) {
    memcpy(at(address), object, size);
}

static bool is_file(int32_t descriptor) {
    return descriptor >= FIRST_FILE && descriptor < FIRST_FILE + FILE_COUNT;
}

/* ---- the directory ---- */

/* WASI's description of a directory that the host shows */
typedef struct {
    uint8_t kind; /* 0: a directory */
    uint32_t name_length;
} ShownDirectory;

SYSTEM_CALL(fd_prestat_get, I32(descriptor), I32(result)) {
    if (descriptor != DIRECTORY) return BAD_DESCRIPTOR;
    const ShownDirectory shown = {.name_length = strlen(RESOURCES_DIRECTORY)};
    put(result, &shown, sizeof shown);
    return GOOD;
}

SYSTEM_CALL(fd_prestat_dir_name, I32(descriptor), I32(name), I32(size)) {
    if (descriptor != DIRECTORY || (uint32_t)size > strlen(RESOURCES_DIRECTORY)) return BAD_DESCRIPTOR;
    memcpy(at(name), RESOURCES_DIRECTORY, (uint32_t)size);
    return GOOD;
}

/* ---- files ---- */

/* WASI's description of a descriptor */
typedef struct {
    uint8_t kind;
    uint16_t flags;
    uint64_t rights, inherited_rights;
} DescriptorState;

SYSTEM_CALL(fd_fdstat_get, I32(descriptor), I32(result)) {
    if (descriptor != DIRECTORY && !is_file(descriptor)) return BAD_DESCRIPTOR;
    const DescriptorState state = {
        .kind = descriptor == DIRECTORY ? KIND_DIRECTORY : KIND_FILE,
        .rights = UINT64_MAX,
        .inherited_rights = UINT64_MAX,
    };
    put(result, &state, sizeof state);
    return GOOD;
}

static bool has_name(const volatile ResourceFile *file, const char *name, size_t length) {
    if (length == 0 || length >= FILE_NAME_SIZE) return false;
    for (size_t i = 0; i < length; i++)
        if (file->name[i] != name[i]) return false;
    return file->name[length] == '\0';
}

SYSTEM_CALL(path_open, I32(directory), I32(lookup), I32(path), I32(length), I32(flags), I64(rights), I64(inherited),
            I32(descriptor_flags), I32(result)) {
    if (directory != DIRECTORY) return BAD_DESCRIPTOR;
    for (int32_t i = 0; i < FILE_COUNT; i++) {
        if (!has_name(&FILES.file[i], at(path), (uint32_t)length)) continue;
        places[i] = 0;
        const int32_t descriptor = FIRST_FILE + i;
        put(result, &descriptor, sizeof descriptor);
        return GOOD;
    }
    return NO_SUCH_FILE;
}

/* WASI's part of a reader's memory */
typedef struct {
    char *begin;
    size_t size;
} Part;

SYSTEM_CALL(fd_read, I32(descriptor), I32(parts), I32(count), I32(result)) {
    if (!is_file(descriptor)) return BAD_DESCRIPTOR;
    const volatile ResourceFile *const file = &FILES.file[descriptor - FIRST_FILE];
    uint32_t *const place = &places[descriptor - FIRST_FILE], sum = 0;
    for (int32_t i = 0; i < count; i++) {
        Part part;
        memcpy(&part, (const char *)at(parts) + (size_t)i * sizeof part, sizeof part);
        const uint32_t left = file->size - *place;
        const uint32_t size = part.size < left ? part.size : left;
        memcpy(part.begin, (const char *)(uintptr_t)file->address + *place, size);
        *place += size;
        sum += size;
    }
    put(result, &sum, sizeof sum);
    return GOOD;
}

SYSTEM_CALL(fd_close, I32(descriptor)) {
    return is_file(descriptor) ? GOOD : BAD_DESCRIPTOR;
}

/* ---- what there is not ---- */

/* There is no environment variable. */
SYSTEM_CALL(environ_sizes_get, I32(count), I32(size)) {
    const uint32_t none = 0;
    put(count, &none, sizeof none);
    put(size, &none, sizeof none);
    return GOOD;
}

#define REFUSED(call, ...)                                                                                             \
    SYSTEM_CALL(call, __VA_ARGS__) {                                                                                   \
        return BAD_DESCRIPTOR;                                                                                         \
    }

REFUSED(environ_get, I32(addresses), I32(content))
REFUSED(fd_fdstat_set_flags, I32(descriptor), I32(flags))
REFUSED(fd_write, I32(descriptor), I32(parts), I32(count), I32(result))
REFUSED(fd_seek, I32(descriptor), I64(offset), I32(whence), I32(result))
REFUSED(random_get, I32(buffer), I32(length))

_Noreturn void __imported_wasi_snapshot_preview1_proc_exit(int32_t code);
_Noreturn void __imported_wasi_snapshot_preview1_proc_exit(I32(code)) {
    __builtin_trap();
}
