/* A program that the build runs: it prints modelDescription.xml, from variables.def, of the FMU that MODEL_BUILT and
 * FMI_VERSION choose. emit.c holds the parts that both versions of FMI share; emit_fmi2.c and emit_fmi3.c hold the
 * rest. */
#ifndef DUALCAM_EMIT_H
#define DUALCAM_EMIT_H

#include <stdio.h>

#include "fmi/dependencies.h"

/* Text goes into the hash, and to `file` unless `file` is NULL. */
typedef struct {
    FILE *file;
    uint64_t hash[2];
    bool failed;
} Sink;

/* Prints the whole document. The GUID (FMI 3.0: instantiation token) is the hash of the document printed with an empty
 * GUID, so equal descriptions have equal GUIDs. `sources`: names of files; NULL ends the list. */
void put_document(Sink *sink, const char *guid, char *const *sources);

void put(Sink *sink, const char *text);
__attribute__((format(printf, 2, 3))) void print(Sink *sink, const char *format, ...);
void put_attribute(Sink *sink, const char *name, const char *value); /* ` name="value"`, with the value escaped */
void put_number(Sink *sink, const char *name, double value);

/* The attributes of the root element, one per line. */
void put_head(Sink *sink, const char *version, const char *guid_name, const char *guid);
void put_units(Sink *sink);
void put_types(Sink *sink, void (*put_type)(Sink *sink, const Unit *unit)); /* one for each unit */
void put_categories_and_experiment(Sink *sink);

/* name, value reference, causality, variability, initial, description. Inputs and time must not have `initial`. */
void put_variable_attributes(Sink *sink, unsigned reference);
void put_unit_and_range(Sink *sink, const Variable *variable); /* declaredType, unit; min, max, nominal */
bool has_start(const Variable *variable);
const char *start_of(unsigned reference, ShortestDecimal *text); /* not of a String, whose start is "" */

/* ` dependencies="..." dependenciesKind="..."`: the dependencies of `unknown` in `list`. `number` gives the number by
 * which the standard refers to a known. */
void put_dependencies(Sink *sink, unsigned unknown, const Dependency *list, unsigned (*number)(unsigned reference));

bool is_output(unsigned reference);

extern const char *const IDENTIFIER;

#endif
