/* Written by make_elementary.py, which says what these numbers are. */
/* clang-format off */

enum { LOG_BITS = 6 }; /* the steps of a binade are 2^LOG_BITS */

/* The steps around 1, which have the series of their own: the first one, and how many */
enum { LOG_NEAR = 33, LOG_NEAR_STEPS = 7 };

/* log 2 in two parts. Multiples of 2^-42 add up without rounding. */
static const double LOG_2_HIGH = 0x1.62e42fefa3800p-1;
static const double LOG_2_LOW = 0x1.ef35793c76730p-45;

/* (log(1 + r) - r)/r^2, |r| < 0.00769 */
static const double LOG_SERIES[6] = {
    -0x1.000000000002bp-1, 0x1.55555555555fdp-2, -0x1.ffffffef46442p-3, 0x1.9999998275dc5p-3,
    -0x1.555cc781e214ep-3, 0x1.249a4da1cc6cap-3,
};

/* The same, -0.03516 <= r <= 0.03906 */
static const double LOG_NEAR_LOW = -0x1.200000p-5;
static const double LOG_NEAR_HIGH = 0x1.400000p-5;

static const double LOG_NEAR_SERIES[9] = {
    -0x1.ffffffffffff1p-2, 0x1.555555555553ap-2, -0x1.000000002517cp-2, 0x1.9999999ae00bfp-3,
    -0x1.55555245223cep-3, 0x1.249233e3a95d2p-3, -0x1.000c06d0e0e32p-3, 0x1.c7fec55e3d302p-4,
    -0x1.7a5ba97a3bfcbp-4,
};

/* c near the middle of a step, 1/c, and log c in two parts */
typedef struct {
    double centre[64], inverse[64], high[64], low[64];
} LogSteps;

static const LogSteps LOG_STEPS = {
    .centre = {
        0x1.6bffe6p-1, 0x1.7000138000000p-1, 0x1.74000bp-1, 0x1.780041p-1,
        0x1.7c0014p-1, 0x1.7ffffe8000000p-1, 0x1.83ffeb8000000p-1, 0x1.88003dp-1,
        0x1.8bffd7p-1, 0x1.8fffe58000000p-1, 0x1.94001d8000000p-1, 0x1.98000a8000000p-1,
        0x1.9bffc9p-1, 0x1.a000068000000p-1, 0x1.a4000c8000000p-1, 0x1.a8002a8000000p-1,
        0x1.abffda8000000p-1, 0x1.b0002bp-1, 0x1.b400488000000p-1, 0x1.b80027p-1,
        0x1.bc00168000000p-1, 0x1.bffffc8000000p-1, 0x1.c4000e8000000p-1, 0x1.c8000fp-1,
        0x1.cc0038p-1, 0x1.d000028000000p-1, 0x1.d3fff08000000p-1, 0x1.d7fffep-1,
        0x1.dbffd78000000p-1, 0x1.dffff7p-1, 0x1.e400068000000p-1, 0x1.e7ffc78000000p-1,
        0x1.ebfff98000000p-1, 0x1.f0004e8000000p-1, 0x1.f3fff48000000p-1, 0x1.f7ffbap-1,
        0x1.fc008cp-1, 0x1.0080108000000p+0, 0x1.040001p+0, 0x1.07fff2p+0,
        0x1.0bfff08000000p+0, 0x1.100007p+0, 0x1.140004p+0, 0x1.17ffcdp+0,
        0x1.1bfff98000000p+0, 0x1.1fffee8000000p+0, 0x1.24000ap+0, 0x1.27fffa8000000p+0,
        0x1.2bfff7p+0, 0x1.3000098000000p+0, 0x1.3400198000000p+0, 0x1.37ffdb8000000p+0,
        0x1.3c0012p+0, 0x1.3fffcfp+0, 0x1.440023p+0, 0x1.47ffed8000000p+0,
        0x1.4c000bp+0, 0x1.50000bp+0, 0x1.54000bp+0, 0x1.57fff08000000p+0,
        0x1.5bffd18000000p+0, 0x1.6000028000000p+0, 0x1.63ffcbp+0, 0x1.6800078000000p+0,
    },
    .inverse = {
        0x1.68169b208f4cep+0, 0x1.642c72b11f7cep+0, 0x1.60580b9a4cbb7p+0, 0x1.5c9846760428ep+0,
        0x1.58ed10e0a8e15p+0, 0x1.555556aaaaac0p+0, 0x1.51d090876401ep+0, 0x1.4e5dd66addfb2p+0,
        0x1.4afd8c4a16eddp+0, 0x1.47ae2a3056a29p+0, 0x1.446f6ea57cac5p+0, 0x1.414138fcc0bacp+0,
        0x1.3e22f6468805bp+0, 0x1.3b13ac4ec5000p+0, 0x1.381377ee5a9a2p+0, 0x1.3521b0b6488d2p+0,
        0x1.323e4f77b3d29p+0, 0x1.2f682da6d0ca1p+0, 0x1.2c9f82dae82f9p+0, 0x1.29e3f836d9206p+0,
        0x1.2734fc925c234p+0, 0x1.24924b6db6e00p+0, 0x1.21fb6ec4ad701p+0, 0x1.1f703e67892cep+0,
        0x1.1cf04829fbaacp+0, 0x1.1a7b948c0618ap+0, 0x1.18118a5eaa999p+0, 0x1.15b1e7248ce96p+0,
        0x1.135c988127dddp+0, 0x1.1111162fc97b9p+0, 0x1.0ecf531b5d4c1p+0, 0x1.0c973414a7576p+0,
        0x1.0a68142b85784p+0, 0x1.0841e6b170e89p+0, 0x1.0624e3369bc10p+0, 0x1.04106522c8f7ap+0,
        0x1.0203c0f4e3031p+0, 0x1.ff005ee1095ddp-1, 0x1.f81f8007c17a1p-1, 0x1.f07c395bebc4ep-1,
        0x1.e91337084686bp-1, 0x1.e1e1d57b21182p-1, 0x1.dae60089a6f2ep-1, 0x1.d41d9717ace45p-1,
        0x1.cd857320599efp-1, 0x1.c71c8d6e9fb48p-1, 0x1.c0e060d8c1112p-1, 0x1.bacf998673b7bp-1,
        0x1.b4e82869f38f2p-1, 0x1.af285e50d8000p-1, 0x1.a98ed2cb08507p-1, 0x1.a41a72c9a8817p-1,
        0x1.9ec8d1b082a35p-1, 0x1.9999d851f51fcp-1, 0x1.948ae41a152fcp-1, 0x1.8f9c2f83bc6fap-1,
        0x1.8acb83e21fdf1p-1, 0x1.861854c0ba2d8p-1, 0x1.818175089c971p-1, 0x1.7d060542e03cbp-1,
        0x1.78a4fa6b60b9cp-1, 0x1.745d14a0cb205p-1, 0x1.702e3c90f371ap-1, 0x1.6c16b9d64837ap-1,
    },
    .high = {
        -0x1.5d5c271a2b000p-2, -0x1.522aaa30c3000p-2, -0x1.4718bddf8b000p-2, -0x1.3c24766dd0000p-2,
        -0x1.314ee8382a000p-2, -0x1.269625134e000p-2, -0x1.1bf9cc500c000p-2, -0x1.117848c9ba000p-2,
        -0x1.0713f00a07000p-2, -0x1.f9924e7954000p-3, -0x1.e5305a730e000p-3, -0x1.d1034a71a2000p-3,
        -0x1.bd0984e9b6000p-3, -0x1.a93eb3c8ae000p-3, -0x1.95a570dba2000p-3, -0x1.823b490cb0000p-3,
        -0x1.6f01dc27d2000p-3, -0x1.5bf33adb3c000p-3, -0x1.491283a66c000p-3, -0x1.365f157a66000p-3,
        -0x1.23d6aadbf8000p-3, -0x1.1178f8227e000p-3, -0x1.fe889037cc000p-4, -0x1.da71ef7ba4000p-4,
        -0x1.b6aa963638000p-4, -0x1.9335cfc3ec000p-4, -0x1.700db85728000p-4, -0x1.4d31272d28000p-4,
        -0x1.2aa1a6c594000p-4, -0x1.0859d826b0000p-4, -0x1.ccb6ced9a0000p-5, -0x1.894e55bfb8000p-5,
        -0x1.466b597d28000p-5, -0x1.0410c81ab8000p-5, -0x1.8493cb6190000p-6, -0x1.020e491810000p-6,
        -0x1.00de10d060000p-7, 0x1.ffc209a900000p-10, 0x1.fc0b0917a0000p-7, 0x1.f8264c0e30000p-6,
        0x1.7743b598a0000p-5, 0x1.f0a3ded3e8000p-5, 0x1.341db4be7c000p-4, 0x1.6f0a3e9f70000p-4,
        0x1.a92675e594000p-4, 0x1.e26f7dff18000p-4, 0x1.0d782df01a000p-3, 0x1.2955097428000p-3,
        0x1.44d2795c14000p-3, 0x1.5ff3470a78000p-3, 0x1.7ab939affc000p-3, 0x1.9524ba383e000p-3,
        0x1.af3d09908a000p-3, 0x1.c8fe42dff8000p-3, 0x1.e271541eb0000p-3, 0x1.fb911352c2000p-3,
        0x1.0a327014b7000p-2, 0x1.1675ec40d2000p-2, 0x1.229440de18000p-2, 0x1.2e8dfd8a58000p-2,
        0x1.3a643c82af000p-2, 0x1.4618c36797000p-2, 0x1.51aa3fffc6000p-2, 0x1.5d1bf14ad6000p-2,
    },
    .low = {
        0x1.39266fe8cc177p-45, -0x1.51e5c33711a82p-44, 0x1.816bb119c4c3dp-45, -0x1.9fdad54884e3cp-49,
        0x1.ff9e8052128f1p-45, 0x1.1361f0ffcd0cfp-44, -0x1.c46090c98af3fp-44, 0x1.346e839b5f0ccp-44,
        0x1.c9d0d265789bap-48, -0x1.88529d533a8bdp-46, -0x1.164209ef0a98dp-44, 0x1.f60a6a48a7ea3p-47,
        -0x1.df85363750a26p-44, 0x1.0e486f6019727p-46, 0x1.e674b02a1cda9p-46, -0x1.327e0dadec95dp-44,
        0x1.4115ca56251a6p-44, 0x1.ec58e8b8e7cd4p-44, -0x1.935e9f7f8e366p-44, 0x1.2e2b2d14b0937p-45,
        -0x1.66e9c40ea5b4dp-44, -0x1.5ef78d3825d4fp-45, -0x1.09aed8511557dp-44, -0x1.e499549b09fcfp-45,
        -0x1.0e1ff5a26d2dbp-44, -0x1.dcc42f51bde54p-45, -0x1.a9a19de0595afp-45, 0x1.ac5b2ab4d9a02p-44,
        0x1.56efb43868d3bp-46, -0x1.258744df983e6p-44, -0x1.58f7fca656b5dp-46, 0x1.e56020db57d60p-44,
        0x1.235ef2d00a086p-44, -0x1.d4e2684ccb090p-45, 0x1.0afc3943bb54ap-46, 0x1.c8ce2cf96bed9p-45,
        0x1.fe06883e23d57p-44, 0x1.4e30adb407c85p-47, 0x1.f8e4656937b75p-49, 0x1.76334e47e4b59p-44,
        -0x1.ccc70faf1af23p-45, -0x1.b94147781aca1p-45, 0x1.9c5d1a18eb7a8p-44, 0x1.d8d8c7f32e6b7p-44,
        -0x1.f3714680e021bp-45, 0x1.65ad536695780p-44, -0x1.8a30a738b0cb4p-44, 0x1.eca25e6813edfp-45,
        -0x1.e2237e5e05c8fp-44, 0x1.e9e4649baeae4p-46, 0x1.24aea5247afc4p-44, -0x1.009334bd3d4f9p-48,
        0x1.2d91417d68c20p-45, 0x1.7bd6492424a98p-49, -0x1.029e29ce558d4p-46, -0x1.2ef4a1c30c829p-44,
        -0x1.8f0e87a0c3319p-47, 0x1.af5a234a61bcfp-45, 0x1.724b6dde86722p-45, 0x1.d060aad4eeda9p-45,
        -0x1.d8ab55ce1db5cp-44, 0x1.67a1609d89c5fp-44, -0x1.c0bab457a5300p-45, -0x1.1ba4bd019ef41p-44,
    },
};
