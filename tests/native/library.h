/* Loading the binary of an FMU on Linux, macOS and Windows. */
#ifndef NATIVE_LIBRARY_H
#define NATIVE_LIBRARY_H

#ifdef _WIN32

#include <windows.h>

static inline void *library_open(const char *path) {
    return (void *)LoadLibraryA(path);
}

static inline void *library_find(void *library, const char *name) {
    return (void *)GetProcAddress((HMODULE)library, name);
}

#else

#include <dlfcn.h>

static inline void *library_open(const char *path) {
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}
static inline void *library_find(void *library, const char *name) {
    return dlsym(library, name);
}

#endif

/* A variable whose member `call` is the function at `found`. ISO C converts no data pointer to a function pointer; POSIX
 * and Windows do, through a union of both. */
#define LIBRARY_FUNCTION(type, variable, found)                                                                        \
    union {                                                                                                            \
        void *data;                                                                                                    \
        type *call;                                                                                                    \
    } variable = {found}

#endif
