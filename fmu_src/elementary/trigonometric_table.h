/* Written by make_elementary.py, which says what these numbers are. */
/* clang-format off */

#include <stdint.h>

static const double TWO_BY_PI_ROUNDED = 0x1.45f306dc9c883p-1;

/* pi/2 in four parts, of which three have 33 bits, and in two parts */
static const double HALF_PI_1 = 0x1.921fb54400000p+0;
static const double HALF_PI_2 = 0x1.0b4611a600000p-34;

static const double HALF_PI_3 = 0x1.3198a2e000000p-69;
static const double HALF_PI_4 = 0x1.b839a252049c1p-104;

static const double HALF_PI_HIGH = 0x1.921fb54442d18p+0;
static const double HALF_PI_LOW = 0x1.1a62633145c07p-54;

/* (sin(x) - x)/x^3 and (cos(x) - 1 + x^2/2)/x^4 as polynomials in x^2, side by side */
typedef double Pair __attribute__((vector_size(16)));

static const Pair SIN_COS_SERIES[6] = {
    {-0x1.5555555555549p-3, 0x1.555555555554cp-5}, {0x1.111111110f87ap-7, -0x1.6c16c16c1517ep-10},
    {-0x1.a01a019c11987p-13, 0x1.a01a019cb1c08p-16}, {0x1.71de3577b64eap-19, -0x1.27e4f809f26e7p-22},
    {-0x1.ae5e663a92bf9p-26, 0x1.1ee9ebea50ea9p-29}, {0x1.5d93010a602e0p-33, -0x1.8fae9d06809d3p-37},
};

/* The binary digits of 2/pi, 32 in a word */
static const uint32_t TWO_BY_PI[37] = {
    0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561, 0xb7246e3a,
    0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e, 0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41,
    0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b, 0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf,
    0x27cb09b7, 0x4f463f66, 0x9e5fea2d, 0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08,
    0x56033046,
};
