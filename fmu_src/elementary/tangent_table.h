/* Written by make_elementary.py, which says what these numbers are. */
/* clang-format off */

enum { TAN_BITS = 3 }; /* the steps of a binade are 2^TAN_BITS */

static const double TAN_FIRST = 0x1.000000p-3;

/* (tan(x) - x)/x^3 as a polynomial in x^2, |x| <= 1/8 */
static const double TAN_SERIES[6] = {
    0x1.5555555555552p-2, 0x1.1111111113086p-3, 0x1.ba1ba1ad65113p-5, 0x1.664f5b6656c7ep-6, 0x1.226008392099bp-7,
    0x1.e1457e9446467p-9,
};

/* c near the middle of a step, of 26 bits. Its tangent and its cotangent are doubles up to 2^-58 of themselves */
typedef struct {
    double centre[21], tangent[21], cotangent[21];
} TanSteps;

static const TanSteps TAN_STEPS = {
    .centre = {
        0x1.0fffc0p-3, 0x1.3000908000000p-3, 0x1.4fff948000000p-3, 0x1.6fff7f8000000p-3, 0x1.9000a28000000p-3,
        0x1.b0005dp-3, 0x1.d000e1p-3, 0x1.efff1ep-3, 0x1.0ffec28000000p-2, 0x1.3000b0p-2, 0x1.4fff96p-2,
        0x1.6fff378000000p-2, 0x1.8fff388000000p-2, 0x1.b001e3p-2, 0x1.d00082p-2, 0x1.efff6bp-2, 0x1.1000568000000p-1,
        0x1.30009ap-1, 0x1.50012ap-1, 0x1.700082p-1, 0x1.9000edp-1,
    },
    .tangent = {
        0x1.119c1259df40ep-3, 0x1.32413e4df8c46p-3, 0x1.530bb81eb3e5dp-3, 0x1.7402aa945db11p-3, 0x1.952aec393e7cep-3,
        0x1.b6865bb7d3b61p-3, 0x1.d81bf52ed3217p-3, 0x1.f9ed4f2eade56p-3, 0x1.1693e9aa4c9e2p-2, 0x1.3942ab520e1f1p-2,
        0x1.5c998abb51f9bp-2, 0x1.80b3d8bebbbd7p-2, 0x1.a5aa3dab2ca14p-2, 0x1.cb9a9e13924dcp-2, 0x1.f29a80028263ep-2,
        0x1.0d67aa0b6bd8fp-1, 0x1.2cda0447c2b94p-1, 0x1.599a8a0bb88e0p-1, 0x1.8a4e2d87c9937p-1, 0x1.bfee624a600dcp-1,
        0x1.fbc6e7f9c6b38p-1,
    },
    .cotangent = {
        0x1.df0c23e127a68p+2, 0x1.abfbc12f5f037p+2, 0x1.829742ccaf0bep+2, 0x1.60558f86c9c9cp+2, 0x1.43802a02eb532p+2,
        0x1.2ae49b08be5efp+2, 0x1.15a1741b5dd6ap+2, 0x1.0312ad27e444bp+2, 0x1.d6810f22dae14p+1, 0x1.a269893a14d69p+1,
        0x1.77fee33d8bde1p+1, 0x1.54b5c2f65056fp+1, 0x1.36d80abc3a57cp+1, 0x1.1d2f456b3b354p+1, 0x1.06e0d26810baep+1,
        0x1.e6862c95a7eccp+0, 0x1.b3ab7ededab3fp+0, 0x1.7b4156f434af9p+0, 0x1.4c69934e20698p+0, 0x1.249dcab631082p+0,
        0x1.02210ae026093p+0,
    },
};
