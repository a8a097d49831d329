/* Written by make_elementary.py, which says what these numbers are. */
/* clang-format off */

enum { TAN_BITS = 3 }; /* the steps of a binade are 2^TAN_BITS */

static const double TAN_FIRST = 0x1.000000p-3;

/* (tan(x) - x)/x^3 as a polynomial in x^2, |x| <= 1/8 */
static const double TAN_SERIES[6] = {
    0x1.5555555555552p-2, 0x1.1111111113086p-3, 0x1.ba1ba1ad65113p-5, 0x1.664f5b6656c7ep-6,
    0x1.226008392099bp-7, 0x1.e1457e9446467p-9,
};

/* c near the middle of a step, its tangent, a double up to 2^-60 of itself, and its cotangent in two parts */
typedef struct {
    double centre[21], tangent[21], cotangent[21], low[21];
} TanSteps;

static const TanSteps TAN_STEPS = {
    .centre = {
        0x1.0ffff78000000p-3, 0x1.300049p-3, 0x1.50000bp-3, 0x1.70000e8000000p-3,
        0x1.9000018000000p-3, 0x1.b0006ep-3, 0x1.d000068000000p-3, 0x1.efffe6p-3,
        0x1.0ffffe8000000p-2, 0x1.3000128000000p-2, 0x1.5000348000000p-2, 0x1.700001p-2,
        0x1.90000e8000000p-2, 0x1.affff98000000p-2, 0x1.cffffbp-2, 0x1.f000148000000p-2,
        0x1.10004d8000000p-1, 0x1.3000188000000p-1, 0x1.4fffe08000000p-1, 0x1.70000dp-1,
        0x1.8ffffdp-1,
    },
    .tangent = {
        0x1.119c4ad7770f4p-3, 0x1.3240f534a9db6p-3, 0x1.530c31de1df33p-3, 0x1.74033e4c42a13p-3,
        0x1.952a44ec19fb1p-3, 0x1.b6866d7f5c806p-3, 0x1.d81b0f1262478p-3, 0x1.f9ee23633ca2ep-3,
        0x1.16953d0d8f5a1p-2, 0x1.3941ff14b26aap-2, 0x1.5c9a3b99cca50p-2, 0x1.80b4beaf5dc93p-2,
        0x1.a5ab37f4af8fcp-2, 0x1.cb9851f7f0d12p-2, 0x1.f299d900c47dfp-2, 0x1.0d6816425d46ep-1,
        0x1.2cd9f82c3f84fp-1, 0x1.5999cd8aa55b2p-1, 0x1.8a4c209be9bc1p-1, 0x1.bfed93bd94a6fp-1,
        0x1.fbc50bebfc7f7p-1,
    },
    .cotangent = {
        0x1.df0bc0f943329p+2, 0x1.abfc2756d7629p+2, 0x1.8296b7facb36dp+2, 0x1.6055039f4037ap+2,
        0x1.4380af977beb0p+2, 0x1.2ae48eea7a2c0p+2, 0x1.15a1fb6d96a2fp+2, 0x1.0312407dc7a45p+2,
        0x1.d67ed1f00a768p+1, 0x1.a26a6f48b560fp+1, 0x1.77fe2479158d9p+1, 0x1.54b4f75199b1ep+1,
        0x1.36d7523ace890p+1, 0x1.1d30b258f372bp+1, 0x1.06e12a7530effp+1, 0x1.e6856928a0a2bp+0,
        0x1.b3ab9067546c7p+0, 0x1.7b4225d08821ep+0, 0x1.4c6b4dd714c0fp+0, 0x1.249e51a4d450ep+0,
        0x1.0221fce1b291dp+0,
    },
    .low = {
        0x1.36f46b384a6bdp-53, 0x1.55895bc5cf756p-52, 0x1.59acb54eb6fa6p-52, 0x1.2e3c0122b449fp-53,
        -0x1.fc6e7ef43f13fp-52, 0x1.bd4ff5ce2daf6p-54, 0x1.9c5d55972a583p-52, 0x1.47bf74f6ea580p-53,
        0x1.dc33f9273ef4ap-56, 0x1.8e651fba4291bp-53, 0x1.a5af29f8c5a6ep-53, -0x1.143f61f0742ddp-55,
        -0x1.e1e39af6bbe09p-56, -0x1.b7b70889695c0p-54, -0x1.bcc117c34d965p-53, 0x1.c3b697a87a5d3p-54,
        -0x1.bb66f9599f991p-55, -0x1.c07611ae5a4ffp-55, 0x1.53c8741792cd4p-55, -0x1.8c39b664f1478p-54,
        0x1.139007cf7def4p-55,
    },
};
