#include "bytes.h"

#include <float.h>
#include <math.h>
#include <string.h>

unsigned take_byte(Bytes *bytes) {
    return bytes_left(bytes) ? *bytes->at++ : 0u;
}

unsigned take_word(Bytes *bytes) {
    const unsigned low = take_byte(bytes);
    return low | take_byte(bytes) << 8;
}

unsigned take_below(Bytes *bytes, unsigned n) {
    return take_byte(bytes) % n;
}

static double take_eight_bytes(Bytes *bytes) {
    uint64_t bits = 0;
    double value;
    for (int i = 0; i < 64; i += 8) bits |= (uint64_t)take_byte(bytes) << i;
    memcpy(&value, &bits, sizeof value);
    return value;
}

double take_any_number(Bytes *bytes) {
    static const double special[] = {NAN,         INFINITY, -INFINITY, DBL_MAX, -DBL_MAX, DBL_MIN, 0x1p-1074, -0.0,
                                     DBL_EPSILON, 1e300,    -1e300,    1e150,   -1e150,   1e-300,  1e-150,    1e16};
    enum { SPECIALS = sizeof special / sizeof special[0] };
    const unsigned kind = take_byte(bytes);
    if (kind < SPECIALS) return special[kind];
    if (kind < 64) return take_eight_bytes(bytes);
    return ((int)kind - 160) / 8.0; /* -12 to 11.875 */
}

double size_of(unsigned byte, double low, double high) {
    return low * pow(high / low, (byte & 255u) / 255.0);
}
