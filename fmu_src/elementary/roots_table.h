/* Written by make_elementary.py, which says what these numbers are. */
/* clang-format off */

/* The third root of m, 1 <= m <= 8, to two digits */
static const double CBRT_START[4] = {
    0x1.6ef7d7cd66d8cp-1, 0x1.50ba80e69b747p-2, -0x1.16bdce74d65dbp-5, 0x1.aaa35d014643bp-10,
};
