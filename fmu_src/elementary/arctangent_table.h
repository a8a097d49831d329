/* Written by make_elementary.py, which says what these numbers are. */
/* clang-format off */

#include "elementary/double_double.h"

enum { ATAN_BITS = 3 }; /* the steps of a binade are 2^ATAN_BITS */

static const double ATAN_FIRST = 0x1.000000p-4;
static const double ATAN_LAST = 0x1.000000p+4;

static const DoubleDouble PI = {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
static const DoubleDouble HALF_PI = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};

/* (atan(t) - t)/t^3 as a polynomial in t^2, |t| <= 0.03030 */
static const double ATAN_SERIES[4] = {
    -0x1.55555555554d8p-2, 0x1.999999977c9cbp-3, -0x1.249230f02fea5p-3, 0x1.c63a3b2a218b5p-4,
};

/* The same, |t| <= 1/16 */
static const double ATAN_NEAR_SERIES[5] = {
    -0x1.5555555555537p-2, 0x1.9999999963174p-3, -0x1.249248297a59cp-3, 0x1.c7187fd6ca15dp-4,
    -0x1.70c2296fb3a85p-4,
};

/* c near the middle of a step, of 26 bits, and its angle, which is a double up to 2^-60 of itself */
typedef struct {
    double centre[64], angle[64];
} AtanSteps;

static const AtanSteps ATAN_STEPS = {
    .centre = {
        0x1.0fffc2p-4, 0x1.30002ep-4, 0x1.4fffdb8000000p-4, 0x1.70001dp-4,
        0x1.8ffffd8000000p-4, 0x1.affffa8000000p-4, 0x1.d00001p-4, 0x1.effff58000000p-4,
        0x1.100076p-3, 0x1.3000088000000p-3, 0x1.4fffe6p-3, 0x1.6ffff6p-3,
        0x1.9000018000000p-3, 0x1.afffb38000000p-3, 0x1.d000098000000p-3, 0x1.effffap-3,
        0x1.1000288000000p-2, 0x1.2ffff0p-2, 0x1.500007p-2, 0x1.6fffd18000000p-2,
        0x1.9000248000000p-2, 0x1.b000038000000p-2, 0x1.cfffefp-2, 0x1.f0000fp-2,
        0x1.10001a8000000p-1, 0x1.2ffff8p-1, 0x1.500010p-1, 0x1.70002a8000000p-1,
        0x1.8ffff0p-1, 0x1.b0002c8000000p-1, 0x1.d00004p-1, 0x1.efffecp-1,
        0x1.1000058000000p+0, 0x1.30000cp+0, 0x1.5000168000000p+0, 0x1.700008p+0,
        0x1.9000008000000p+0, 0x1.affffc8000000p+0, 0x1.cffff88000000p+0, 0x1.efffea8000000p+0,
        0x1.0ffff88000000p+1, 0x1.2ffff18000000p+1, 0x1.5000048000000p+1, 0x1.7000028000000p+1,
        0x1.9000088000000p+1, 0x1.b0000d8000000p+1, 0x1.cffff38000000p+1, 0x1.f000048000000p+1,
        0x1.0ffff78000000p+2, 0x1.2fffdbp+2, 0x1.5000098000000p+2, 0x1.700011p+2,
        0x1.900035p+2, 0x1.affffbp+2, 0x1.cfffecp+2, 0x1.f00016p+2,
        0x1.1000038000000p+3, 0x1.3000018000000p+3, 0x1.500009p+3, 0x1.7000438000000p+3,
        0x1.90002bp+3, 0x1.affffa8000000p+3, 0x1.cffff48000000p+3, 0x1.effffc8000000p+3,
    },
    .angle = {
        0x1.0f99acb7846fbp-4, 0x1.2f71c0d82198bp-4, 0x1.4f3fb2359e119p-4, 0x1.6f03da9332831p-4,
        0x1.8ebc51cd9b6fdp-4, 0x1.ae68a1abef8f4p-4, 0x1.ce07c6c08e4afp-4, 0x1.ed98b7bfd8ef8p-4,
        0x1.0e6b50c3a4137p-3, 0x1.2dcbe380d0bb2p-3, 0x1.4d08614c1ac03p-3, 0x1.6c1d3ee8a5655p-3,
        0x1.8b06ef9a5d8dfp-3, 0x1.a9c1e87645d46p-3, 0x1.c84c01b08538fp-3, 0x1.e6a1433e88e76p-3,
        0x1.09dc7f5234484p-2, 0x1.27836351418c6p-2, 0x1.44aa49bdfbde6p-2, 0x1.614817022bd01p-2,
        0x1.7d56246134321p-2, 0x1.98cd574d76b5bp-2, 0x1.b3a903bfbe9dfp-2, 0x1.cde54059067dap-2,
        0x1.f40dfa0ad840fp-2, 0x1.1255d3d58cb2cp-1, 0x1.2958f0c20a4cap-1, 0x1.3f14178fd784bp-1,
        0x1.538f4dc904fa0p-1, 0x1.66d67d90c711ap-1, 0x1.78f6be08104c2p-1, 0x1.89ff55a43f153p-1,
        0x1.a1a2645740f78p-1, 0x1.bde718c9701e0p-1, 0x1.d6e58d7c197a4p-1, 0x1.ed0d9d00c807bp-1,
        0x1.006133087f11dp+0, 0x1.092ce388a6c24p+0, 0x1.110eae47e4aa7p+0, 0x1.1825ebee3a02cp+0,
        0x1.21862c87799c9p+0, 0x1.2c1a1fbf6f1dcp+0, 0x1.34f1fcd59ca61p+0, 0x1.3c6e65955d240p+0,
        0x1.42d705a639cc8p+0, 0x1.4861b6fd95b3fp+0, 0x1.4d378a5500d52p+0, 0x1.5178503130536p+0,
        0x1.56f6f171a3ec7p+0, 0x1.5d0135f9b25f2p+0, 0x1.61f06dbf28cfcp+0, 0x1.660b04c64609bp+0,
        0x1.698218f483436p+0, 0x1.6c78c77ff5672p+0, 0x1.6f08eef5da865p+0, 0x1.7145ec32f7720p+0,
        0x1.7424def22099cp+0, 0x1.77467e57f9cebp+0, 0x1.79d0f4a080142p+0, 0x1.7beb3d79c8a77p+0,
        0x1.7daffa8a694ccp+0, 0x1.7f3209d2278ccp+0, 0x1.807f20a31b5a8p+0, 0x1.81a16e263b504p+0,
    },
};
