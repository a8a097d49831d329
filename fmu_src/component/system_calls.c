/* The system calls of WebAssembly's C library (WASI, preview 1), as the component answers them: there are no files and
 * no environment. The draft does not say how a host shows the FMU's resources to a component. So the component needs
 * nothing of the host's system, and the FMU refuses a groove table with its message on a file that cannot be opened.
 *
 * The linker takes these functions in place of the host's: they have the names that the C library imports. */
#include <stdint.h>

enum { BAD_DESCRIPTOR = 8, NO_SUCH_FILE = 44 }; /* error numbers of WASI */

#define I32(name) __attribute__((unused)) int32_t name
#define I64(name) __attribute__((unused)) int64_t name
#define ANSWER(call, number, ...)                                                                                      \
    int32_t __imported_wasi_snapshot_preview1_##call(__VA_ARGS__);                                                     \
    int32_t __imported_wasi_snapshot_preview1_##call(__VA_ARGS__) {                                                    \
        return number;                                                                                                 \
    }

ANSWER(fd_prestat_get, BAD_DESCRIPTOR, I32(fd), I32(result)) /* no directory that the host shows */
ANSWER(fd_prestat_dir_name, BAD_DESCRIPTOR, I32(fd), I32(path), I32(length))
ANSWER(path_open, NO_SUCH_FILE, I32(fd), I32(lookup), I32(path), I32(length), I32(flags), I64(rights), I64(inherited),
       I32(fd_flags), I32(result))
ANSWER(fd_fdstat_get, BAD_DESCRIPTOR, I32(fd), I32(result))
ANSWER(fd_fdstat_set_flags, BAD_DESCRIPTOR, I32(fd), I32(flags))
ANSWER(fd_read, BAD_DESCRIPTOR, I32(fd), I32(parts), I32(count), I32(result))
ANSWER(fd_write, BAD_DESCRIPTOR, I32(fd), I32(parts), I32(count), I32(result))
ANSWER(fd_seek, BAD_DESCRIPTOR, I32(fd), I64(offset), I32(whence), I32(result))
ANSWER(fd_close, BAD_DESCRIPTOR, I32(fd))
ANSWER(random_get, BAD_DESCRIPTOR, I32(buffer), I32(length))

_Noreturn void __imported_wasi_snapshot_preview1_proc_exit(int32_t code);
_Noreturn void __imported_wasi_snapshot_preview1_proc_exit(I32(code)) {
    __builtin_trap();
}
