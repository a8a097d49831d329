"""The C core's grooves and transmission by ctypes: structures, signatures, and cams to build them from."""

from ctypes import POINTER, Structure, c_bool, c_char, c_char_p, c_double, c_int, c_size_t, c_void_p

HELIX, ELLIPSE, TABLE, CYCLOID = 1, 2, 3, 4
DEGREE = 12
SHIM = """
TransmissionPoint point(const TransmissionPiece *p, double t);
TransmissionPoint point(const TransmissionPiece *p, double t) {
    return piece_point(p, t, TRANSMISSION_SECOND_DERIVATIVES);
}
"""


class FrictionParams(Structure):
    _fields_ = [
        *((n, c_double) for n in ("peak", "stribeck_velocity", "viscous", "load_exponent", "load")),
        ("stribeck_exponent", c_int),
        ("table", c_void_p),
    ]


class CamParams(Structure):
    _fields_ = [
        *((n, c_double) for n in ("radius", "lead_angle", "ellipse_a", "ellipse_b")),
        *((n, c_double) for n in ("cycloid_rise", "cycloid_angle", "friction")),
        ("law", FrictionParams),
        ("wear", c_double),
        ("profile", c_int),
        ("ellipse_curvature", c_int),
    ]


class Cam(CamParams):
    """With the path of its table, which Params hold."""

    table = b""


class StopParams(Structure):
    _fields_ = [(n, c_double) for n in ("lower", "upper", "restitution")]


class Params(Structure):
    _fields_ = [
        ("cam", CamParams * 2),
        *((name, c_double * n) for name, n in (("spring", 4), ("damper", 4), ("inertia", 3), ("shaft", 2))),
        ("stop", StopParams),
        ("initial", c_double * 2),
        ("tolerance", c_double),
        ("contacts", c_int),
        ("ledger", c_bool),
        ("table", c_char * 1024 * 2),
        ("friction_table", c_char * 1024 * 2),
    ]


class Fault(Structure):
    _fields_ = [("text", c_char * 512)]


class GroovePoint(Structure):
    _fields_ = [(n, c_double) for n in ("z", "slope", "dslope_dpsi")]


class TablePiece(Structure):
    _fields_ = [("psi", c_double), ("width", c_double), ("z", c_double), ("slope", c_double * 5)]


class Table(Structure):
    _fields_ = [("piece", POINTER(TablePiece)), ("count", c_size_t)]


class Groove(Structure):
    _fields_ = [
        ("law", c_void_p),
        ("profile", c_int),
        *((n, c_double) for n in ("radius", "gain", "height", "rate", "S0", "C0")),
        ("table", Table),
        ("path", c_char_p),
        ("first", c_double),
        ("last", c_double),
        ("parameter", c_char_p),
        ("size", c_double),
    ]


class TransmissionPiece(Structure):
    _fields_ = [
        *((n, c_double) for n in ("lower", "upper", "middle", "scale")),
        ("slope", c_double * 2 * (DEGREE + 1)),
        ("z", c_double * (DEGREE + 1)),
        ("knot_lower", c_bool),
        ("knot_upper", c_bool),
    ]


class TransmissionPoint(Structure):
    _fields_ = [(n, c_double * 2) for n in ("slope", "dslope_dtheta", "d2slope_dtheta2")] + [("z", c_double)]


class Transmission(Structure):
    _fields_ = [
        ("groove", Groove * 2),
        ("cam", CamParams * 2),
        ("lower", c_double),
        ("upper", c_double),
        ("count", c_size_t),
        ("piece", POINTER(TransmissionPiece)),
        ("straight", c_bool),
        ("slope_size", c_double),
        ("steepest", c_double * 2),
        ("z_size", c_double),
    ]


FILES = ["geometry/groove_table", "geometry/transmission_build"]
STRUCTURES = [
    CamParams,
    StopParams,
    Params,
    Fault,
    GroovePoint,
    TablePiece,
    Table,
    Groove,
    TransmissionPiece,
    TransmissionPoint,
    Transmission,
]


def with_signatures(c):
    """The library `c` of the core with the types of its functions."""
    for name, result, arguments in (
        ("groove_build", c_bool, [POINTER(Groove), POINTER(Params), c_int, c_char_p, POINTER(Fault)]),
        ("groove_free", None, [POINTER(Groove)]),
        ("groove_at", GroovePoint, [POINTER(Groove), c_double]),
        ("groove_angle", c_double, [POINTER(Groove), c_double]),
        ("groove_slope", c_double, [POINTER(Groove), c_double, c_double]),
        ("transmission_build", c_bool, [POINTER(Transmission), POINTER(Params), c_char_p, POINTER(Fault)]),
        ("transmission_is_of", c_bool, [POINTER(Transmission), POINTER(Params)]),
        ("transmission_free", None, [POINTER(Transmission)]),
        ("transmission_piece", POINTER(TransmissionPiece), [POINTER(Transmission), c_double, c_int]),
        ("transmission_gamma", c_double, [POINTER(Transmission), c_double]),
        ("transmission_z", c_double, [POINTER(Transmission), c_double]),
        ("point", TransmissionPoint, [POINTER(TransmissionPiece), c_double]),
    ):
        function = getattr(c, name)
        function.restype, function.argtypes = result, arguments
    return c


def cam(profile=HELIX, radius=0.02, lead=0.8, a=0.05, b=0.05, kappa=-1, rise=0.02, angle=1.3963, table=""):
    coulomb = FrictionParams(peak=1.0, stribeck_velocity=0.01, stribeck_exponent=2, load=100.0)
    made = Cam(radius, lead, a, b, rise, angle, 0.14, coulomb, 0.0, profile, kappa)
    made.table = str(table).encode()
    return made


def params_of(first, second, lower=0.0, upper=1.3963):
    params = Params(cam=(first, second), stop=StopParams(lower, upper, 0.0))
    for place, one in zip(params.table, (first, second), strict=True):
        place.value = one.table
    return params


def write_table(path, psi, z):
    path.write_text("psi_rad,z_m\n" + "".join(f"{p!r},{h!r}\n" for p, h in zip(psi, z, strict=True)))
    return path
