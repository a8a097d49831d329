/* The input of a fuzz target: bytes that are read one after the other. Behind the end stand zeros. */
#ifndef FUZZ_BYTES_H
#define FUZZ_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    const uint8_t *at, *end;
} Bytes;

static inline bool bytes_left(const Bytes *bytes) {
    return bytes->at < bytes->end;
}

unsigned take_byte(Bytes *bytes);
unsigned take_word(Bytes *bytes); /* two bytes, little-endian */
/* 0 to n - 1, n <= 256 */
unsigned take_below(Bytes *bytes, unsigned n);
/* Any double: a special value such as NaN, infinity or the largest number, a small integer, or eight bytes. */
double take_any_number(Bytes *bytes);

/* A size between `low` and `high`, which are positive: from a byte, in equal steps of the logarithm. */
double size_of(unsigned byte, double low, double high);

#endif
