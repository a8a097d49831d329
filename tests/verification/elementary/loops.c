/* Loops over the elementary functions of the core and over those of the C library, for the benchmark beside this file.
 * The loops of both kinds differ in the called function alone.
 *
 *     loops own|library function count       (as a program: for callgrind) */
#define _POSIX_C_SOURCE 200809L /* clock_gettime */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "elementary/elementary.h"
#include "elementary/vector2.h"

#define EXPORT __attribute__((visibility("default"), noinline))

static double library_atan2_of_1(double x) { return atan2(x, 1.0 - x); }
static double own_atan2_of_1(double x) { return elementary_atan2(x, 1.0 - x); }
static double library_sin_cos(double x) { return sin(x) + cos(x); }
static double own_sin_cos(double x) {
    const SinCos both = elementary_sin_cos(x);
    return both.sin + both.cos;
}
static double own_sin(double x) { return elementary_sin_cos(x).sin; }
static double own_cos(double x) { return elementary_sin_cos(x).cos; }
/* Of two numbers at once, for the two cams. The sum keeps the second one. */
static double own_exp_of_two(double x) {
    const Vector2 both = vector2_exp((Vector2){x, -x});
    return both[0] + 0.0 * both[1];
}
static double own_small_exp_of_two(double x) {
    const Vector2 both = vector2_exp_small((Vector2){x, -x});
    return both[0] + 0.0 * both[1];
}
static double library_exp_of_two(double x) { return exp(x) + exp(-x); }
static double own_log_of_two(double x) {
    const Vector2 both = vector2_log((Vector2){x, x + 1.0});
    return both[0] + 0.0 * both[1];
}
static double library_log_of_two(double x) { return log(x) + log(x + 1.0); }

typedef double Function(double);
typedef struct {
    const char *name;
    Function *own, *library;
} Pair;

static const Pair PAIRS[] = {
    {"exp", elementary_exp, exp},       {"expm1", elementary_expm1, expm1},
    {"log", elementary_log, log},       {"log1p", elementary_log1p, log1p},
    {"sin", own_sin, sin},              {"cos", own_cos, cos},
    {"tan", elementary_tan, tan},       {"atan", elementary_atan, atan},
    {"cbrt", elementary_cbrt, cbrt},    {"sin and cos", own_sin_cos, library_sin_cos},
    {"atan2", own_atan2_of_1, library_atan2_of_1},
    {"exp of two", own_exp_of_two, library_exp_of_two},
    {"small exp of two", own_small_exp_of_two, library_exp_of_two},
    {"log of two", own_log_of_two, library_log_of_two},
};

static Function *function_of(const char *kind, const char *name) {
    for (size_t i = 0; i < sizeof PAIRS / sizeof PAIRS[0]; i++)
        if (strcmp(PAIRS[i].name, name) == 0) return strcmp(kind, "own") == 0 ? PAIRS[i].own : PAIRS[i].library;
    return NULL;
}

/* The loop that callgrind counts and that is timed. */
EXPORT void loop(Function *f, size_t count, const double *x, double *y) {
    for (size_t i = 0; i < count; i++) y[i] = f(x[i]);
}

/* `second`: for atan2 alone */
EXPORT void values(const char *kind, const char *name, size_t count, const double *x, const double *second, double *y) {
    const int own = strcmp(kind, "own") == 0;
    if (strcmp(name, "atan2") == 0)
        for (size_t i = 0; i < count; i++) y[i] = own ? elementary_atan2(x[i], second[i]) : atan2(x[i], second[i]);
    else loop(function_of(kind, name), count, x, y);
}

/* Processor time in seconds of one call. */
EXPORT double seconds(const char *kind, const char *name, size_t count, const double *x, double *y) {
    struct timespec begin, end;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    loop(function_of(kind, name), count, x, y);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    return ((double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec)) / (double)count;
}

int main(int argc, char **argv) {
    if (argc != 4) return 2;
    Function *f = function_of(argv[1], argv[2]);
    const size_t count = (size_t)strtoul(argv[3], NULL, 10);
    double *x = malloc(2 * count * sizeof *x);
    if (f == NULL || x == NULL) return 1;
    for (size_t i = 0; i < count; i++) x[i] = 0.01 + 6.0 * (double)(i * 7919 % count) / (double)count;
    loop(f, count, x, x + count);
    free(x);
    return 0;
}
