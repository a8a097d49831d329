/* What the FMU reads besides calls: files of tables, and the bytes of a saved state. */
#ifndef FUZZ_READERS_H
#define FUZZ_READERS_H

#include "bytes.h"

typedef enum { TABLE_GROOVE, TABLE_FRICTION } TableKind;

/* The rest of the input is the file. */
void read_table(Bytes in, TableKind kind);
/* The bytes of a saved state with changes by the input, with or without the checksum of the changed bytes. */
void read_state(Bytes in);

#endif
