/* Written by make_elementary.py, which says what these numbers are. */
/* clang-format off */

#include "elementary/double_double.h"

enum { ATAN_BITS = 3 }; /* the steps of a binade are 2^ATAN_BITS */

static const double ATAN_FIRST = 0x1.000000p-3;
static const double ATAN_LAST = 0x1.000000p+3;

static const DoubleDouble PI = {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
static const DoubleDouble HALF_PI = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};

/* (atan(t) - t)/t^3 as a polynomial in t^2, |t| <= 0.03030 */
static const double ATAN_SERIES[4] = {
    -0x1.55555555554d8p-2, 0x1.999999977ca21p-3, -0x1.249230f058f3cp-3, 0x1.c63a3be9cfd0fp-4,
};

/* The same, |t| <= 1/8 */
static const double ATAN_NEAR_SERIES[6] = {
    -0x1.55555555554ccp-2, 0x1.9999999945f2ep-3, -0x1.2492489cdc06dp-3, 0x1.c71ba727dcf9ep-4, -0x1.741079d00c9cap-4,
    0x1.2cc205b488c0bp-4,
};

/* c near the middle of a step, of 26 bits, and its angle, which is a double up to 2^-58 of itself */
typedef struct {
    double centre[48], angle[48];
} AtanSteps;

static const AtanSteps ATAN_STEPS = {
    .centre = {
        0x1.0fffffp-3, 0x1.300003p-3, 0x1.5000028000000p-3, 0x1.6ffffc8000000p-3, 0x1.8fffffp-3, 0x1.affff9p-3,
        0x1.d00004p-3, 0x1.effffap-3, 0x1.1000078000000p-2, 0x1.2ffffbp-2, 0x1.4ffffdp-2, 0x1.7000078000000p-2,
        0x1.8ffffa8000000p-2, 0x1.b000018000000p-2, 0x1.cffffbp-2, 0x1.f000008000000p-2, 0x1.1000008000000p-1,
        0x1.2ffff8p-1, 0x1.5000018000000p-1, 0x1.70001ap-1, 0x1.8ffff0p-1, 0x1.b0000dp-1, 0x1.d00004p-1,
        0x1.f000088000000p-1, 0x1.0ffffe8000000p+0, 0x1.2fffffp+0, 0x1.4ffffdp+0, 0x1.700007p+0, 0x1.9000008000000p+0,
        0x1.affffc8000000p+0, 0x1.d00004p+0, 0x1.f0000d8000000p+0, 0x1.0ffffbp+1, 0x1.300003p+1, 0x1.5000028000000p+1,
        0x1.6fffffp+1, 0x1.8ffffe8000000p+1, 0x1.affffbp+1, 0x1.cffff38000000p+1, 0x1.effffc8000000p+1, 0x1.0ffffep+2,
        0x1.2ffff7p+2, 0x1.5000098000000p+2, 0x1.700007p+2, 0x1.8ffff5p+2, 0x1.affffep+2, 0x1.cffff8p+2, 0x1.f00006p+2,
    },
    .angle = {
        0x1.0e6adbd3b07e8p-3, 0x1.2dcbde1f2b843p-3, 0x1.4d087d0cde888p-3, 0x1.6c1d45349998cp-3, 0x1.8b06ed31e1e59p-3,
        0x1.a9c22b00599d8p-3, 0x1.c84bfc7543e19p-3, 0x1.e6a1433e88e76p-3, 0x1.09dc607efbd61p-2, 0x1.27836d6d2bc75p-2,
        0x1.44aa40b6d1642p-2, 0x1.614846d501b77p-2, 0x1.7d55fff0a1f16p-2, 0x1.98cd559ad2214p-2, 0x1.b3a90db470dd9p-2,
        0x1.cde5349a6e2f8p-2, 0x1.f40dd17ce8590p-2, 0x1.1255d3d58cb2cp-1, 0x1.2958e69f71087p-1, 0x1.3f140caeab893p-1,
        0x1.538f4dc904fa0p-1, 0x1.66d66b2a43c78p-1, 0x1.78f6be08104c2p-1, 0x1.89ff64580704ap-1, 0x1.a1a25dc3c2a98p-1,
        0x1.bde70dffcacbdp-1, 0x1.d6e57ac0c8feap-1, 0x1.ed0d9c59cf8c7p-1, 0x1.006133087f11dp+0, 0x1.092ce388a6c24p+0,
        0x1.110eb0f6ea83fp+0, 0x1.1825f34afe276p+0, 0x1.21862d6f8b0d0p+0, 0x1.2c1a2504b48e6p+0, 0x1.34f1fc53d672bp+0,
        0x1.3c6e64d3f5f76p+0, 0x1.42d703caa3597p+0, 0x1.4861b40122d4dp+0, 0x1.4d378a5500d52p+0, 0x1.51784f317043ep+0,
        0x1.56f6f2cecec7bp+0, 0x1.5d013aba8c5adp+0, 0x1.61f06dbf28cfcp+0, 0x1.660b0399a667ep+0, 0x1.69821290abdaep+0,
        0x1.6c78c7c1ef38cp+0, 0x1.6f08efdb449f4p+0, 0x1.7145eb26a6ccap+0,
    },
};
