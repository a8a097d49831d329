#include "geometry/groove_csv.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "platform/attributes.h"
#include "platform/platform.h"

enum { QUOTED_LINE = 40, NUMBER_SIZE = 64 };

static const char HEADER[] = "psi_rad,z_m";
static const char BYTE_ORDER_MARK[] = "\xEF\xBB\xBF";

/* The file being read. */
typedef struct {
    const char *variable, *path; /* for messages */
    Fault *fault;
    PlainLocale *locale; /* of the file's numbers */
} Source;

/* A part of the file's text, not terminated by a zero. */
typedef struct {
    const char *begin, *end;
} Span;

int samples_quoted(const char *text, int limit) {
    const size_t length = strlen(text);
    if (length <= (size_t)limit) return (int)length;
    while (limit > 0 && ((unsigned char)text[limit] & 0xC0) == 0x80)
        limit--; /* the cut would be inside a UTF-8 character */
    return limit;
}

/* Writes `variable = "path": ...` into the fault; always false. */
static bool refuse(const Source *source, const char *format, ...) {
    char *text = source->fault->text;
    const size_t size = sizeof source->fault->text;
    const int used = snprintf(text, size, "%s = \"%.*s\": ", source->variable,
                              samples_quoted(source->path, QUOTED_PATH), source->path);
    va_list arguments;
    va_start(arguments, format);
    if (used >= 0 && (size_t)used < size) vsnprintf(text + used, size - (size_t)used, format, arguments);
    va_end(arguments);
    return false;
}

/* ---- the file ---- */

static FILE *open_absolute(const Source *source, const char *path) {
    FILE *file = platform_open(path);
    if (!file) refuse(source, "this file cannot be opened: it must be a readable CSV file");
    return file;
}

/* A relative path never starts from the current directory: the host application owns and may change this directory. */
static FILE *open_table(const Source *source, const char *resources) {
    if (platform_is_absolute(source->path)) return open_absolute(source, source->path);
    if (!resources) {
        refuse(source, "the path must be absolute, because the FMU's resources directory is not known");
        return NULL;
    }
    const size_t size = strlen(resources) + strlen(source->path) + 2;
    char *joined = malloc(size);
    if (!joined) {
        refuse(source, "not enough memory to read it, %zu bytes must be available", size);
        return NULL;
    }
    snprintf(joined, size, "%s/%s", resources, source->path);
    FILE *file = open_absolute(source, joined);
    free(joined);
    return file;
}

/* The whole file as text, to be freed by the caller; NULL with the reason in the fault. */
static char *read_all(const Source *source, FILE *file, size_t *length) {
    size_t size = 1 << 14, used = 0;
    char *text = malloc(size);
    while (text) {
        used += fread(text + used, 1, size - used, file);
        if (used < size) break;
        if (size > SAMPLES_MAX_BYTES) break;
        char *larger = realloc(text, size *= 2);
        if (!larger) free(text);
        text = larger;
    }
    *length = used;
    if (!text) {
        refuse(source, "not enough memory to read it, %zu bytes must be available", size);
    } else if (ferror(file)) {
        refuse(source, "reading failed: it must be a readable CSV file");
    } else if (used > SAMPLES_MAX_BYTES) {
        refuse(source, "the file is too large: at most %d bytes are allowed", SAMPLES_MAX_BYTES);
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
    while (span.begin < span.end && is_space(*span.begin)) span.begin++;
    while (span.begin < span.end && is_space(span.end[-1])) span.end--;
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
    for (const char *c = text.begin; c < text.end; c++)
        if (!is_space(*c) && *c != '\n') return false;
    return true;
}

static const char *skip_digits(const char *c, const char *end) {
    while (c < end && *c >= '0' && *c <= '9') c++;
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

static bool read_sample(const Source *source, Span line, size_t line_number, Sample *out) {
    const char *comma = memchr(line.begin, ',', (size_t)(line.end - line.begin));
    if (comma)
        *out = (Sample){number((Span){line.begin, comma}, source->locale),
                        number((Span){comma + 1, line.end}, source->locale)};
    if (comma && isfinite(out->psi) && isfinite(out->z)) return true;
    char text[QUOTED_LINE + 1];
    return refuse(source, "line %zu, \"%s\", must be two finite numbers \"psi_rad,z_m\", like \"0.25,0.005\"",
                  line_number, quoted_line(line, text));
}

static bool is_in_order(const Source *source, size_t line_number, Sample before, Sample sample) {
    if (!(sample.psi > before.psi))
        return refuse(source, "line %zu: psi_rad = %.17g must be > %.17g, that of the line before", line_number,
                      sample.psi, before.psi);
    if (!(sample.z >= before.z))
        return refuse(source, "line %zu: z_m = %.17g must be >= %.17g, that of the line before", line_number, sample.z,
                      before.z);
    return true;
}

/* Reads all lines after the header. samples->sample has space for SAMPLES_MAX samples. */
static bool read_samples(const Source *source, Span text, Samples *samples) {
    for (size_t line_number = 2; !is_blank(text); line_number++) {
        const Span line = next_line(&text);
        const size_t k = samples->count;
        if (k == SAMPLES_MAX)
            return refuse(source, "the table is too long: at most %d points are allowed", SAMPLES_MAX);
        if (!read_sample(source, line, line_number, &samples->sample[k])) return false;
        if (k > 0 && !is_in_order(source, line_number, samples->sample[k - 1], samples->sample[k])) return false;
        samples->count++;
    }
    return true;
}

static bool check_whole(const Source *source, const Samples *samples) {
    if (samples->count < SAMPLES_MIN)
        return refuse(source, "%zu points, but there must be at least %d", samples->count, SAMPLES_MIN);
    const double first = samples->sample[0].psi, last = samples->sample[samples->count - 1].psi;
    if (!(first <= 0.0 && last >= 0.0))
        return refuse(source, "psi_rad goes from %.17g to %.17g, but it must include 0, from where z counts", first,
                      last);
    return true;
}

static bool read_header(const Source *source, Span *text) {
    const size_t mark = sizeof BYTE_ORDER_MARK - 1;
    if ((size_t)(text->end - text->begin) >= mark && memcmp(text->begin, BYTE_ORDER_MARK, mark) == 0)
        text->begin += mark;
    const Span line = next_line(text);
    const size_t length = (size_t)(line.end - line.begin);
    if (length == sizeof HEADER - 1 && memcmp(line.begin, HEADER, length) == 0) return true;
    char quoted[QUOTED_LINE + 1];
    return refuse(source, "line 1, \"%s\", must be the header \"%s\"", quoted_line(line, quoted), HEADER);
}

static bool parse(const Source *source, Span text, Samples *samples) {
    if (!read_header(source, &text)) return false;
    samples->sample = malloc(SAMPLES_MAX * sizeof samples->sample[0]);
    if (!samples->sample) return refuse(source, "not enough memory for it, fewer points must do");
    return read_samples(source, text, samples) && check_whole(source, samples);
}

COLD bool samples_read(Samples *samples, const char *path, const char *resources, const char *variable, Fault *fault) {
    Source source = {variable, path, fault, NULL};
    *samples = (Samples){.sample = NULL};
    if (path[0] == '\0') return refuse(&source, "a table profile must name a CSV file");
    FILE *file = open_table(&source, resources);
    if (!file) return false;
    size_t length;
    char *text = read_all(&source, file, &length);
    fclose(file);
    if (!text) return false;
    source.locale = plain_locale_new();
    const bool good = source.locale ? parse(&source, (Span){text, text + length}, samples)
                                    : refuse(&source, "not enough memory to read it, some must be available");
    if (source.locale) plain_locale_free(source.locale);
    free(text);
    if (!good) samples_free(samples);
    return good;
}

void samples_free(Samples *samples) {
    free(samples->sample);
    *samples = (Samples){.sample = NULL};
}
