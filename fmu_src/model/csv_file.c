#include "model/csv_file.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "numerics/tolerances.h"
#include "platform/attributes.h"

enum { QUOTED_LINE = 40, NUMBER_SIZE = 64 };

static const char BYTE_ORDER_MARK[] = "\xEF\xBB\xBF";

/* A part of the file's text, not terminated by a zero. */
typedef struct {
    const char *begin, *end;
} Span;

COLD int csv_quoted(const char *text, int limit) {
    const size_t length = strlen(text);
    if (length <= (size_t)limit) return (int)length;
    while (limit > 0 && ((unsigned char)text[limit] & 0xC0) == 0x80) /* at most one turn per character */
        limit--;                                                     /* the cut would be inside a UTF-8 character */
    return limit;
}

bool csv_refuse(const CsvFile *csv, const char *format, ...) {
    char *text = csv->fault->text;
    const size_t size = sizeof csv->fault->text;
    const int used =
        snprintf(text, size, "%s = \"%.*s\": ", csv->variable, csv_quoted(csv->path, QUOTED_PATH), csv->path);
    va_list arguments;
    va_start(arguments, format);
    if (used >= 0 && (size_t)used < size) vsnprintf(text + used, size - (size_t)used, format, arguments);
    va_end(arguments);
    return false;
}

/* ---- the file ---- */

static const char UNREADABLE[] = "this file cannot be opened: it must be a readable CSV file";

/* A relative path never starts from the current directory: the host application owns and may change this directory. */
static FILE *open_in_resources(const CsvFile *csv, const char *resources) {
    const size_t size = strlen(resources) + strlen(csv->path) + 2;
    char *joined = malloc(size);
    if (!joined) {
        csv_refuse(csv, "not enough memory to read it, %zu bytes must be available", size);
        return NULL;
    }
    snprintf(joined, size, "%s/%s", resources, csv->path);
    FILE *file = platform_open(joined);
    free(joined);
    if (!file)
        csv_refuse(csv,
                   "%s. A relative path starts from the FMU's resources, \"%.*s\": give an absolute path for a file "
                   "elsewhere",
                   UNREADABLE, csv_quoted(resources, QUOTED_PATH), resources);
    return file;
}

static FILE *open_table(const CsvFile *csv, const char *resources) {
    const bool is_absolute = platform_is_absolute(csv->path);
    if (!is_absolute && resources) return open_in_resources(csv, resources);
    FILE *file = is_absolute ? platform_open(csv->path) : NULL;
    if (!file)
        csv_refuse(csv, "%s",
                   is_absolute ? UNREADABLE
                               : "the path must be absolute, because the FMU's resources directory is not known");
    return file;
}

/* The whole file as text, to be freed by the caller; NULL with the reason in the fault. */
static char *read_all(const CsvFile *csv, FILE *file, size_t *length) {
    size_t size = 1 << 14, used = 0;
    char *text = malloc(size);
    while (text) { /* at most one turn per block of the file */
        used += fread(text + used, 1, size - used, file);
        if (used < size) break;
        if (size > CSV_MAX_BYTES) break;
        char *larger = realloc(text, size *= 2);
        if (!larger) free(text);
        text = larger;
    }
    *length = used;
    if (!text) {
        csv_refuse(csv, "not enough memory to read it, %zu bytes must be available", size);
    } else if (ferror(file)) {
        csv_refuse(csv, "reading failed: it must be a readable CSV file");
    } else if (used > CSV_MAX_BYTES) {
        csv_refuse(csv, "the file is too large: at most %d bytes are allowed", CSV_MAX_BYTES);
    } else {
        return text;
    }
    free(text);
    return NULL;
}

/* ---- lines and numbers ---- */

static bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

static Span trimmed(Span span) {
    while (span.begin < span.end && is_space(*span.begin)) span.begin++; /* at most one turn per character */
    while (span.begin < span.end && is_space(span.end[-1])) span.end--;  /* at most one turn per character */
    return span;
}

/* Cuts the first line off `text`. */
static Span next_line(Span *text) {
    const char *end = memchr(text->begin, '\n', (size_t)(text->end - text->begin));
    const Span line = {text->begin, end ? end : text->end};
    text->begin = end ? end + 1 : text->end;
    return trimmed(line);
}

static bool is_blank(Span text) {
    for (const char *c = text.begin; c < text.end; c++) /* at most one turn per character */
        if (!is_space(*c) && *c != '\n') return false;
    return true;
}

static const char *skip_digits(const char *c, const char *end) {
    while (c < end && *c >= '0' && *c <= '9') c++; /* at most one turn per character */
    return c;
}

static const char *skip_sign(const char *c, const char *end) {
    return c < end && (*c == '+' || *c == '-') ? c + 1 : c;
}

/* Is the text a plain decimal number? strtod() would also accept "nan", "inf", hexadecimal numbers and leading line
 * ends. */
static bool is_decimal(Span span) {
    const char *c = skip_sign(span.begin, span.end);
    const char *whole = c;
    c = skip_digits(c, span.end);
    ptrdiff_t digits = c - whole;
    if (c < span.end && *c == '.') {
        const char *fraction = c + 1;
        c = skip_digits(fraction, span.end);
        digits += c - fraction;
    }
    if (digits == 0) return false;
    if (c < span.end && (*c == 'e' || *c == 'E')) {
        const char *exponent = skip_sign(c + 1, span.end);
        c = skip_digits(exponent, span.end);
        if (c == exponent) return false;
    }
    return c == span.end;
}

/* The number in `span`; NAN if `span` holds no number. */
static double number(Span span, PlainLocale *locale) {
    span = trimmed(span);
    char text[NUMBER_SIZE];
    const size_t length = (size_t)(span.end - span.begin);
    if (length >= sizeof text || !is_decimal(span)) return NAN;
    memcpy(text, span.begin, length);
    text[length] = '\0';
    return plain_number(text, locale);
}

/* `line` as printable text. */
static const char *quoted_line(Span line, char text[QUOTED_LINE + 1]) {
    size_t length = (size_t)(line.end - line.begin);
    if (length > QUOTED_LINE) length = QUOTED_LINE;
    for (size_t i = 0; i < length; i++) {
        const char c = line.begin[i];
        text[i] = c >= ' ' && c <= '~' ? c : '?';
    }
    text[length] = '\0';
    return text;
}

/* ---- the calls of csv_file.h ---- */

COLD bool csv_open(CsvFile *csv, const char *path, const char *resources, const char *variable, Fault *fault) {
    *csv = (CsvFile){.variable = variable, .path = path, .fault = fault};
    FILE *file = open_table(csv, resources);
    if (!file) return false;
    size_t length = 0;
    csv->text = read_all(csv, file, &length);
    fclose(file);
    if (!csv->text) return false;
    csv->at = csv->text;
    csv->end = csv->text + length;
    csv->locale = plain_locale_new();
    if (csv->locale) return true;
    csv_close(csv);
    return csv_refuse(csv, "not enough memory to read it, some must be available");
}

void csv_close(CsvFile *csv) {
    if (csv->locale) plain_locale_free(csv->locale);
    free(csv->text);
    csv->locale = NULL;
    csv->text = NULL;
}

static Span read_line(CsvFile *csv) {
    Span left = {csv->at, csv->end};
    const Span line = next_line(&left);
    csv->at = left.begin;
    csv->line++;
    return line;
}

bool csv_at_end(const CsvFile *csv) {
    return is_blank((Span){csv->at, csv->end});
}

int csv_header(CsvFile *csv, const char *const header[], int count) {
    const size_t mark = sizeof BYTE_ORDER_MARK - 1;
    if ((size_t)(csv->end - csv->at) >= mark && memcmp(csv->at, BYTE_ORDER_MARK, mark) == 0) csv->at += mark;
    const Span line = read_line(csv);
    const size_t length = (size_t)(line.end - line.begin);
    for (int k = 0; k < count; k++)
        if (length == strlen(header[k]) && memcmp(line.begin, header[k], length) == 0) return k;
    char quoted[QUOTED_LINE + 1];
    csv_refuse(csv, "line 1, \"%s\", must be the header \"%s\"%s%s%s", quoted_line(line, quoted), header[0],
               count > 1 ? " or \"" : "", count > 1 ? header[1] : "", count > 1 ? "\"" : "");
    return -1;
}

bool csv_row(CsvFile *csv, int columns, const char *form, double value[]) {
    const Span line = read_line(csv);
    bool good = true;
    const char *begin = line.begin;
    for (int k = 0; k < columns && good; k++) {
        const char *comma = k + 1 < columns ? memchr(begin, ',', (size_t)(line.end - begin)) : line.end;
        good = comma != NULL;
        if (!good) break;
        value[k] = number((Span){begin, comma}, csv->locale);
        good = isfinite(value[k]);
        begin = comma + 1;
    }
    char text[QUOTED_LINE + 1];
    return good || csv_refuse(csv, "line %zu, \"%s\", must be %s", csv->line, quoted_line(line, text), form);
}
