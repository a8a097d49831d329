/* The FMU as a WebAssembly component: the functions of FMI 3.0 by the canonical ABI of WebAssembly's component model.
 *
 * The room component/ is compiled for WebAssembly alone, together with the other rooms. Which functions there are, and
 * with which types, stands in tools/webassembly/interface.py: the working draft of the layered standard
 * org.modelica.fmi-ls-wasm. tools/webassembly/component.py wraps the compiled module into the component. By the
 * canonical ABI
 *
 *   - a list or text is an address and a count, also where it is an element of a list;
 *   - what does not fit into one number is returned as the address of a struct in linear memory;
 *   - the host asks the component for the memory of lists and texts among the arguments. Such memory, and that of a
 *     result, belongs to one call: call_memory.c frees all of it when the host has read the result.
 *
 * A host cannot call the component while the component calls the host. So there is one call at a time.
 *
 * May include: no other room. The functions of the room fmi are those of FMI 3.0's header. */
#ifndef DUALCAM_COMPONENT_H
#define DUALCAM_COMPONENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fmi3Functions.h"

/* A function that the component exports; tools/webassembly finds the function by this name. */
#define EXPORT(name) __attribute__((export_name(name)))
/* A function of the host, or of the component's own wrapping. */
#define IMPORT(name) __attribute__((import_module("host"), import_name(name)))

/* What stands behind a handle of the host. */
typedef struct {
    fmi3Instance fmu;
    char name[]; /* of the instance, for messages */
} Handle;

/* A text or a list of bytes, not terminated by a zero. */
typedef struct {
    const char *begin;
    size_t length;
} Text;

/* A value reference and the order of a derivative. */
typedef struct {
    fmi3ValueReference reference;
    uint32_t order;
} Request;

/* A list, or the status of the refused call. */
typedef struct {
    uint8_t refused;
    union {
        struct {
            void *items;
            size_t count;
        } list;
        uint8_t status;
    };
} ListResult;

/* Memory until the end of the call. Traps if memory is short: the ABI has no other way. */
void *hold(size_t size);

/* A copy that ends with a zero. */
char *hold_text(const char *begin, size_t length);
fmi3String *hold_texts(const Text *texts, size_t count);

/* Result of a call: the list, unless the status says that the call was refused. */
ListResult *list_result(fmi3Status status, void *items, size_t count);

static inline bool is_refused(fmi3Status status) {
    return status > fmi3Warning;
}

/* Passes a message to the host. The last bytes of a text that was cut inside a character of UTF-8 are left out. */
void log_message(const Handle *me, fmi3Status status, const char *category, const char *message);

#endif
