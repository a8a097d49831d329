/* Host program of the build: prints the modelDescription.xml of the FMU that MODEL_BUILT and FMI_VERSION choose, from
 * variables.def. Here is what both versions of FMI have in common; emit_fmi2.c or emit_fmi3.c is the rest. */
#ifndef DUALCAM_EMIT_H
#define DUALCAM_EMIT_H

#include <stdio.h>

#include "fmi/dependencies.h"

/* Where the text goes: always into the hash, and to `file` unless that is NULL. */
typedef struct {
    FILE *file;
    uint64_t hash[2];
    bool failed;
} Sink;

/* All of the text. Its GUID (FMI 3.0: instantiation token) is a hash of the text printed with an empty one, so equal
 * descriptions have equal GUIDs and there is no clock in it. `sources`: names of files, to NULL. */
void put_document(Sink *sink, const char *guid, char *const *sources);

void put(Sink *sink, const char *text);
__attribute__((format(printf, 2, 3))) void print(Sink *sink, const char *format, ...);
void put_attribute(Sink *sink, const char *name, const char *value); /* ` name="value"` with the value escaped */
void put_number(Sink *sink, const char *name, double value);

/* The attributes of the root element, one per line. */
void put_head(Sink *sink, const char *version, const char *guid_name, const char *guid);
void put_units(Sink *sink);
void put_types(Sink *sink, void (*put_type)(Sink *sink, const Unit *unit)); /* one for each unit */
void put_categories_and_experiment(Sink *sink);

/* name, value reference, causality, variability, initial, description. `initial` is spelt out only where FMI has a
 * choice: inputs and time must not have it. */
void put_variable_attributes(Sink *sink, unsigned reference);
void put_unit_and_range(Sink *sink, const Variable *variable); /* declaredType, unit; min, max, nominal */
bool has_start(const Variable *variable);
const char *start_of(const Variable *variable, Digits *room); /* less that of a String, which is "" */

/* ` dependencies="..." dependenciesKind="..."` of what `list` has on `unknown`; `place` tells how a known is written. */
void put_dependencies(Sink *sink, unsigned unknown, const Dependency *list,
                      unsigned (*configuration)(unsigned reference));

bool is_output(unsigned reference);

extern const char *const IDENTIFIER;

#endif
