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
    -0x1.000000000002bp-1, 0x1.55555555555fdp-2, -0x1.ffffffef46442p-3, 0x1.9999998275dc4p-3,
    -0x1.555cc781e37eep-3, 0x1.249a4da1cdf29p-3,
};

/* The same, -0.03516 <= r <= 0.03906 */
static const double LOG_NEAR_LOW = -0x1.200000p-5;
static const double LOG_NEAR_HIGH = 0x1.400000p-5;

static const double LOG_NEAR_SERIES[9] = {
    -0x1.ffffffffffff1p-2, 0x1.555555555553ap-2, -0x1.000000002517cp-2, 0x1.9999999ae00bfp-3,
    -0x1.55555245223cep-3, 0x1.249233e3a95d2p-3, -0x1.000c06d0e0e32p-3, 0x1.c7fec55e3d302p-4,
    -0x1.7a5ba97a3bfcbp-4,
};

/* c near the middle of a step, 1/c, and log c, a multiple of 2^-42 up to 2^-57 of results */
typedef struct {
    double centre[64], inverse[64], log[64];
} LogSteps;

static const LogSteps LOG_STEPS = {
    .centre = {
        0x1.6c0001566c000p-1, 0x1.70000256c0000p-1, 0x1.740000a0f2000p-1, 0x1.780001ccce000p-1,
        0x1.7c0002b52e000p-1, 0x1.800008ed70000p-1, 0x1.84000253ea000p-1, 0x1.88000147e8000p-1,
        0x1.8c00009c88000p-1, 0x1.9000032220000p-1, 0x1.940000ef98000p-1, 0x1.980001a2be000p-1,
        0x1.9c00015bf4000p-1, 0x1.a000038af8000p-1, 0x1.a400008a20000p-1, 0x1.a8000d90ce000p-1,
        0x1.ac00009c90000p-1, 0x1.b00003923c000p-1, 0x1.b40000c834000p-1, 0x1.b800018d90000p-1,
        0x1.bc00005f6e000p-1, 0x1.c0000108fa000p-1, 0x1.c40000e236000p-1, 0x1.c80000cefa000p-1,
        0x1.cc000104a4000p-1, 0x1.d0000323d4000p-1, 0x1.d4000241e0000p-1, 0x1.d8000300d8000p-1,
        0x1.dc00006186000p-1, 0x1.e000037714000p-1, 0x1.e400035bbe000p-1, 0x1.e800160434000p-1,
        0x1.ec00122e2e000p-1, 0x1.f00002b026000p-1, 0x1.f400001260000p-1, 0x1.f800017852000p-1,
        0x1.fc0001ce78000p-1, 0x1.0080007392000p+0, 0x1.0400010031000p+0, 0x1.08000189e1000p+0,
        0x1.0c00091d29000p+0, 0x1.100000ee54000p+0, 0x1.1400019ce6000p+0, 0x1.180001b8a4000p+0,
        0x1.1c0001453d000p+0, 0x1.200001af11000p+0, 0x1.2400027f5f000p+0, 0x1.2800016d70000p+0,
        0x1.2c0000c2e9000p+0, 0x1.300002b579000p+0, 0x1.340000c342000p+0, 0x1.380001cf41000p+0,
        0x1.3c000177f7000p+0, 0x1.400001d282000p+0, 0x1.4400017440000p+0, 0x1.480001d367000p+0,
        0x1.4c00014170000p+0, 0x1.5000032729000p+0, 0x1.5400019092000p+0, 0x1.5800018d0c000p+0,
        0x1.5c0000a4c8000p+0, 0x1.600001ccb5000p+0, 0x1.6400012725000p+0, 0x1.680001bbfd000p+0,
    },
    .inverse = {
        0x1.6816801558a2cp+0, 0x1.642c834d2fec7p+0, 0x1.6058156d106dap+0, 0x1.5c98810df8d2ap+0,
        0x1.58ed2092e26eap+0, 0x1.55554d65d5849p+0, 0x1.51d07ca7597fdp+0, 0x1.4e5e095b3df38p+0,
        0x1.4afd698256751p+0, 0x1.47ae11e9c77edp+0, 0x1.446f8595c53a5p+0, 0x1.41413ff78aaf2p+0,
        0x1.3e22cac19c584p+0, 0x1.3b13ae8c2460cp+0, 0x1.381380d171a98p+0, 0x1.3521c5cebf84ep+0,
        0x1.323e3432aaf72p+0, 0x1.2f684957fa66fp+0, 0x1.2c9fb44e08517p+0, 0x1.29e41191184acp+0,
        0x1.27350b489f67dp+0, 0x1.2492487786884p+0, 0x1.21fb7780ff56fp+0, 0x1.1f7047599a5b8p+0,
        0x1.1cf06a38b507ep+0, 0x1.1a7b94284911ap+0, 0x1.18117fbe3f2ddp+0, 0x1.15b1e432fbac2p+0,
        0x1.135c80daf1eaep+0, 0x1.11110f186af72p+0, 0x1.0ecf54dd5dc93p+0, 0x1.0c9708ddb2877p+0,
        0x1.0a6806ce603d3p+0, 0x1.08420f157f9bbp+0, 0x1.0624dd25785f9p+0, 0x1.04104041e1f20p+0,
        0x1.020407253c5d5p+0, 0x1.ff007ed9e2679p-1, 0x1.f81f800762781p-1, 0x1.f07c1c2304f42p-1,
        0x1.e9130a1d4026fp-1, 0x1.e1e1e03ba76cap-1, 0x1.dae604a5244fap-1, 0x1.d41d3ef36f676p-1,
        0x1.cd85667fb0617p-1, 0x1.c71c6f1deb78fp-1, 0x1.c0e06c613cb4cp-1, 0x1.bacf8f296b88bp-1,
        0x1.b4e81a32a5efbp-1, 0x1.af2867f290b2fp-1, 0x1.a98ef4f8dd6adp-1, 0x1.a41a3f3456dccp-1,
        0x1.9ec8e7638475ap-1, 0x1.9999974478555p-1, 0x1.948b0dfca4fa6p-1, 0x1.8f9c16c04f341p-1,
        0x1.8acb8f78831bdp-1, 0x1.86185ddcfbf89p-1, 0x1.81817fbb52ac2p-1, 0x1.7d05f26008de6p-1,
        0x1.78a4c7653228ep-1, 0x1.745d155e756e6p-1, 0x1.702e048f7a12cp-1, 0x1.6c16bfab0eccbp-1,
    },
    .log = {
        -0x1.5d5bda324a000p-2, -0x1.522ad9f174000p-2, -0x1.4718da6c14000p-2, -0x1.3c25228c3e000p-2,
        -0x1.314f16d146000p-2, -0x1.26960944ce000p-2, -0x1.1bf99010ee000p-2, -0x1.1178e4c9ec000p-2,
        -0x1.0713847011000p-2, -0x1.f991b6c05a000p-3, -0x1.e530eb3fde000p-3, -0x1.d10376f06a000p-3,
        -0x1.bd086cc21c000p-3, -0x1.a93ec2579a000p-3, -0x1.95a5ab2dea000p-3, -0x1.823bd4cece000p-3,
        -0x1.6f0125ca2e000p-3, -0x1.5bf3f5c71e000p-3, -0x1.4913d486d4000p-3, -0x1.365fc3c6e0000p-3,
        -0x1.23d710ec6e000p-3, -0x1.1178e3672c000p-3, -0x1.fe890b9bd4000p-4, -0x1.da726ef51c000p-4,
        -0x1.b6ac7fca00000p-4, -0x1.9335ca1db8000p-4, -0x1.700d1ced08000p-4, -0x1.4d30fbc208000p-4,
        -0x1.2aa046fd40000p-4, -0x1.08596dc828000p-4, -0x1.ccb7040630000p-5, -0x1.89492fb3b8000p-5,
        -0x1.4669be8ce8000p-5, -0x1.0415ac38e8000p-5, -0x1.8492503270000p-6, -0x1.020535bfd0000p-6,
        -0x1.0100e2d180000p-7, 0x1.ff81f7fc00000p-10, 0x1.fc0b092fc0000p-7, 0x1.f82a1063e0000p-6,
        0x1.7746a5f940000p-5, 0x1.f0a3280af8000p-5, 0x1.341d915164000p-4, 0x1.6f0d41dc48000p-4,
        0x1.a926e5f770000p-4, 0x1.e2708ed568000p-4, 0x1.0d77f95164000p-3, 0x1.295539626e000p-3,
        0x1.44d2bbff4e000p-3, 0x1.5ff3194a4a000p-3, 0x1.7ab8953364000p-3, 0x1.9525b5b01e000p-3,
        0x1.af3c9e6cae000p-3, 0x1.c8ff882350000p-3, 0x1.e2708013ac000p-3, 0x1.fb91923c4e000p-3,
        0x1.0a325206a5000p-2, 0x1.1675d456a5000p-2, 0x1.2294247364000p-2, 0x1.2e8e304bfa000p-2,
        0x1.3a64c73b74000p-2, 0x1.4618c15e03000p-2, 0x1.51aadbc3d4000p-2, 0x1.5d1be0e467000p-2,
    },
};
