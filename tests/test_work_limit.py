"""Calls that spend their evaluations (fmu_src/model/work.h).

A call is made with a limit of one evaluation, of two, and so on, until it succeeds. Each refusal names the
limit and leaves the state as it was. The call that succeeds gives the bits of a call without a limit.
The FMUs allow 10 million evaluations: a test of an FMU would take seconds, and could not end inside a search.
"""

import ctypes
import math
import re

import pytest

# Of a mechanism of the type `Held`.
SHARED = """
static Held held;
size_t state_size(void) { return sizeof held.state; }
void state(void *copy) { memcpy(copy, &held.state, sizeof held.state); }

static CamParams cam(double lead_angle, double ellipse_a, double wear) {
    return (CamParams){.radius = 0.02, .lead_angle = lead_angle, .ellipse_a = ellipse_a, .ellipse_b = 0.05,
                       .ellipse_curvature = 1, .profile = PROFILE_ELLIPSE, .friction = 0.2, .wear = wear,
                       .law = {.peak = 1.0, .stribeck_velocity = 0.01, .stribeck_exponent = 2,
                               .load = 100.0}};
}

static Params parameters(void) {
    return (Params){.cam = {cam(0.5, 0.06, 1e-15), cam(0.6, 0.05, 1e-15)},
                    .spring = {.preload = 60.0, .stiffness = 8e3, .stiffness2 = 1e5},
                    .damper = {.c_load = 5.0, .c_release = 8.0},
                    .stop = {.lower = -1.5, .upper = 1.5},
                    .tolerance = 1e-8, .contacts = 2, .ledger = true};
}

static Fault fault;
const char *message(void) { return fault.text; }
"""

INVERSE = (
    "typedef Inverse Held;"
    + SHARED
    + """
/* K: N.m/rad; 0: rigid. */
bool start(double K, double theta, int64_t limit) {
    inverse_free(&held);
    memset(&held, 0, sizeof held);
    held.params = parameters();
    held.params.shaft.stiffness = K;
    held.params.inertia.shaft = 1e-3;
    held.inputs.theta[0] = theta;
    held.work_limit = limit;
    return inverse_start(&held, &fault);
}

double cam_at(double theta, int64_t limit) {
    ElasticShaftState now;
    held.inputs.theta[0] = theta;
    held.work_limit = limit;
    elastic_shaft_present(&held, &now);
    return now.x;
}

bool move(double theta, double omega, double alpha, bool given, double h, int64_t limit) {
    InverseInputs before = held.inputs;
    held.inputs.theta[0] = theta;
    held.inputs.theta[1] = given ? omega : 0.0;
    held.inputs.theta[2] = given ? alpha : 0.0;
    held.inputs.omega[0] = omega;
    held.inputs.F_ext[1] = 20.0;
    held.work_limit = limit;
    if (inverse_advance(&held, h, given ? GIVEN_THETA : GIVEN_ENDS, &fault)) return true;
    held.inputs = before;
    return false;
}
"""
)

FORWARD = (
    "typedef Mechanism Held;"
    + SHARED
    + """
bool start(double J, double damping, double load_exponent, int64_t limit) {
    mechanism_free(&held);
    memset(&held, 0, sizeof held);
    held.params = parameters();
    held.params.damper.c_load *= damping;
    held.params.damper.c_release *= damping;
    held.params.inertia.shaft = J;
    held.params.cam[0].law.load_exponent = held.params.cam[1].law.load_exponent = load_exponent;
    held.work_limit = limit;
    return mechanism_start(&held, &fault);
}

bool step(double tau, double rate, double F_ext, double h, int64_t limit) {
    const Inputs before = held.inputs;
    held.inputs = (Inputs){.tau = {tau, rate}, .F_ext = {F_ext}};
    held.work_limit = limit;
    if (mechanism_advance(&held, h, NULL, &fault)) return true;
    held.inputs = before;
    return false;
}
"""
)


class Core:
    """The C core with one mechanism."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self.library = library
        library.message.restype = ctypes.c_char_p
        library.state_size.restype = ctypes.c_size_t
        for function in ("start", "move", "step"):
            if hasattr(library, function):
                getattr(library, function).restype = ctypes.c_bool

    def state(self) -> bytes:
        copy = ctypes.create_string_buffer(self.library.state_size())
        self.library.state(copy)
        return copy.raw

    def message(self) -> str:
        return self.library.message().decode()

    def call(self, function: str, *values: float | bool, limit: int) -> bool | float:
        arguments = [ctypes.c_bool(v) if isinstance(v, bool) else ctypes.c_double(v) for v in values]
        return getattr(self.library, function)(*arguments, ctypes.c_int64(limit))

    def start(self, *values: float) -> None:
        assert self.call("start", *values, limit=0), self.message()


@pytest.fixture(scope="module")
def inverse(core):
    return Core(core(["string", "inverse/elastic_shaft", "inverse/inverse"], [], INVERSE))


@pytest.fixture(scope="module")
def forward(core):
    return Core(core(["string", "forward/lifecycle", "forward/step"], [], FORWARD))


def limits():
    """1, 2, 3 and on; above 100 in steps of 1 %."""
    limit = 1
    while limit < 1_000_000:
        yield limit
        limit += 1 + limit // 100


def refusals(core, function, *values):
    """The limits that are too low, each after its refusal. The call with the next limit has succeeded."""
    for limit in limits():
        if core.call(function, *values, limit=limit):
            return
        assert re.search(rf"\b{limit}( evaluations|$)", core.message())
        yield limit
    raise AssertionError("no limit suffices")


def refused_limits(core, start, function, *values):
    """Their number, from the values `start` on."""
    core.start(*start)
    assert core.call(function, *values, limit=0), core.message()
    unlimited = core.state()
    core.start(*start)
    before, count = core.state(), 0
    for _ in refusals(core, function, *values):
        assert core.state() == before
        count += 1
    assert core.state() == unlimited
    return count


def test_start_on_an_elastic_shaft(inverse):
    values = 2.0, 0.4  # N.m/rad, rad
    inverse.start(*values)
    unlimited = inverse.state()
    assert len(list(refusals(inverse, "start", *values))) > 0
    assert inverse.state() == unlimited


@pytest.mark.parametrize("theta", [-0.4, 0.4])  # rad
def test_angle_of_cam_2_before_a_step(inverse, theta):
    inverse.start(2.0, 0.1)
    inverse.library.cam_at.restype = ctypes.c_double
    unlimited, before, refused = inverse.call("cam_at", theta, limit=0), inverse.state(), 0
    for limit in limits():
        found = inverse.call("cam_at", theta, limit=limit)
        if not math.isnan(found):
            break
        refused += 1
    assert refused > 0
    assert found == unlimited
    assert inverse.state() == before


# rad, rad/s, rad/s^2, are derivatives given?, s
MOTIONS = {
    "across": (0.4, 0.1, 0.0, False, 1.0),
    "there and back": (0.3, -8.0, 0.0, False, 1.0),
    "rest": (0.2, 0.0, 0.0, False, 1.0),
    "from another angle": (0.1, 0.5, -2.0, True, 0.5),
    "as far as a stop": (0.5, 3.0, 0.0, False, 0.2),
}


@pytest.mark.parametrize("stiffness", [0.0, 2.0, 200.0])  # N.m/rad
@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_imposed_motion(inverse, stiffness, motion):
    costs_nothing = stiffness == 0.0 and motion == MOTIONS["rest"]
    assert (refused_limits(inverse, (stiffness, 0.2), "move", *motion) > 0) != costs_nothing


# inertia.shaft in kg.m^2, share of the damper, load exponent
# tau in N.m, its rate in N.m/s, F_ext in N, the step in s
STEPS = {
    "jump": ((0.0, 0.0, 0.0), (0.9, 0.0, 0.0, 1.0)),
    "jump back": ((0.0, 0.0, 0.0), (-0.9, 0.0, 0.0, 1.0)),
    "jump under load friction": ((0.0, 0.0, 0.1), (0.9, 0.0, 0.0, 1.0)),
    "along the edge": ((0.0, 0.0, 0.0), (0.3, 0.8, 0.0, 1.0)),
    "jump of the load": ((0.0, 0.0, 0.0), (0.1, 0.0, -300.0, 1.0)),
    "damped": ((0.0, 1.0, 0.0), (0.9, 0.0, 0.0, 1.0)),
    "damped, load passes zero": ((0.0, 1.0, 0.0), (0.9, 0.0, -70.0, 1.0)),
    "inertial": ((1e-3, 1.0, 0.0), (0.9, 0.0, 0.0, 0.1)),
    "inertial under load friction": ((1e-3, 1.0, 0.1), (0.9, 0.0, 0.0, 0.1)),
}


@pytest.mark.parametrize("scene", STEPS.values(), ids=STEPS)
def test_step(forward, scene):
    mechanism, inputs = scene
    assert refused_limits(forward, mechanism, "step", *inputs) > 0
