/* A CSV file of numbers that a parameter names: one header line, then the same count of numbers on every line. */
#ifndef DUALCAM_CSV_FILE_H
#define DUALCAM_CSV_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "model/fault.h"
#include "platform/platform.h"

enum { QUOTED_PATH = 120 }; /* bytes of a path in a message */

typedef struct {
    const char *variable, *path; /* for messages */
    Fault *fault;
    char *text;           /* owned: the whole file */
    const char *at, *end; /* what is not read yet */
    size_t line;          /* number of the latest line read, from 1 */
    PlainLocale *locale;  /* owned: of the file's numbers */
} CsvFile;

/* Reads the file `path`, which is absolute or relative to the directory `resources` (NULL: there is none). `variable`:
 * the name of the parameter that holds the path. Returns false with the reason in `fault`; then there is nothing to
 * close. */
bool csv_open(CsvFile *csv, const char *path, const char *resources, const char *variable, Fault *fault);

void csv_close(CsvFile *csv);

/* Reads line 1: which of `count` headers (1 or 2) it is, or -1, with the reason in the fault. */
int csv_header(CsvFile *csv, const char *const header[], int count);

/* Is nothing but blank lines left? */
bool csv_at_end(const CsvFile *csv);

/* Reads `columns` finite numbers (up to 3). `form` describes such a line in the message of a failure. */
bool csv_row(CsvFile *csv, int columns, const char *form, double value[]);

/* Writes `variable = "path": ...` into the fault; always false. */
bool csv_refuse(const CsvFile *csv, const char *format, ...);

/* The number of bytes of a text to quote in a message: at most `limit`, without cutting a UTF-8 character. */
int csv_quoted(const char *text, int limit);

#endif
