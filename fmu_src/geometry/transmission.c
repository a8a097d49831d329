#include "geometry/transmission.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    N = TRANSMISSION_DEGREE,
    MAX_PIECES = 20000, /* besides those that end at table knots */
    MAX_ITERATIONS = 200,
    CHECKS = N / 2, /* places between nodes where a polynomial is compared with what it stands for */
};

static const double PI = 3.14159265358979323846;
/* Largest error of a polynomial, as a share of the function's size. */
static const double TOLERANCE = 1e-13;
/* Borders closer than this share of the range are one. */
static const double SAME_BREAKPOINT = 1e-9;
/* What a groove may lack at a stop, rad: rounding of an end that is meant to be the stop. */
static const double END_SLACK = 1e-12;
/* How many times the estimate of rounding errors a polynomial may be off. */
static const double DOUBT_SAFETY = 16.0;
/* A groove with tan(lead angle) below this counts as level. */
static const double LEVEL = 1e-9;

/* ---- where the pin is: g1(gamma) = g2(theta - gamma) ---- */

typedef struct {
    double lower, upper;
} Interval;

/* Where gamma can be so that both laws hold. */
static Interval gamma_range(const Groove groove[2], double theta) {
    return (Interval){
        .lower = fmax(groove[0].first, theta - groove[1].last),
        .upper = fmin(groove[0].last, theta - groove[1].first),
    };
}

/* g1(gamma) - g2(theta - gamma): increases with gamma */
static double gap(const Groove groove[2], double theta, double gamma) {
    return groove_at(&groove[0], gamma).z - groove_at(&groove[1], theta - gamma).z;
}

/* The root by Newton's method, inside a bracket. The bracket is halved where a slope that nearly vanishes
 * would send Newton's method astray. Ends when the step or the gap is rounding. Unbounded grooves are
 * left to the straight course. */
static double solve_gamma(const Groove groove[2], double theta, double guess) {
    Interval in = gamma_range(groove, theta);
    double gamma = guess >= in.lower && guess <= in.upper ? guess : 0.5 * (in.lower + in.upper);
    double before = INFINITY; /* size of the latest step */
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        const double phi = theta - gamma;
        const GroovePoint p1 = groove_at(&groove[0], gamma), p2 = groove_at(&groove[1], phi);
        const double f = p1.z - p2.z, slope = p1.slope + p2.slope;
        if (f < 0.0) in.lower = gamma;
        else in.upper = gamma;
        double next = gamma - f / slope;
        const bool inside = next >= in.lower && next <= in.upper;
        if (fabs(f) <= 2.0 * DBL_EPSILON * fabs(p1.z)) return inside ? next : gamma;
        if (!inside || fabs(next - gamma) > 0.5 * before) next = 0.5 * (in.lower + in.upper);
        before = fabs(next - gamma);
        gamma = next;
        if (before <= 2.0 * DBL_EPSILON * fmax(fabs(gamma), fabs(phi))) return gamma;
    }
    return gamma;
}

/* Everything about one theta, from the groove laws. */
typedef struct {
    double gamma, z;
    double slope[2];
    double doubt[2]; /* m/rad, how far rounding alone may have moved the slopes */
} Sight;

/* In the flatter groove an error of the angle moves z least. */
static double flatter_height(GroovePoint p1, GroovePoint p2) {
    return p1.slope <= p2.slope ? p1.z : p2.z;
}

static Sight configuration_at(const Groove groove[2], double theta, double guess) {
    const double gamma = solve_gamma(groove, theta, guess), psi[2] = {gamma, theta - gamma};
    const GroovePoint p[2] = {groove_at(&groove[0], psi[0]), groove_at(&groove[1], psi[1])};
    Sight sight = {.gamma = gamma, .z = flatter_height(p[0], p[1])};
    /* rounding of the angles, and of the heights that determine them */
    const double angle = fmax(fabs(psi[0]), fabs(psi[1])) + fabs(sight.z) / (p[0].slope + p[1].slope);
    for (int i = 0; i < 2; i++) {
        sight.slope[i] = groove_slope(&groove[i], psi[i], sight.z);
        const double by_angle = fabs(p[i].dslope_dpsi) * angle;
        /* d slope/dz = bend/slope where the slope comes from the height */
        const double by_height = fabs(p[i].dslope_dpsi / p[i].slope * groove[i].height);
        const bool steep = groove[i].profile == PROFILE_ELLIPSE && by_height < by_angle;
        sight.doubt[i] = DBL_EPSILON * (steep ? by_height : by_angle);
    }
    return sight;
}

static bool is_undetermined(const Groove groove[2], const Sight *sight) {
    return sight->slope[0] <= LEVEL * groove[0].radius && sight->slope[1] <= LEVEL * groove[1].radius;
}

/* ---- do the grooves reach as far as the stops? ---- */

static bool is_covered(const Groove groove[2], double theta) {
    const Interval in = gamma_range(groove, theta);
    return in.lower <= in.upper && gap(groove, theta, in.lower) <= 0.0 && gap(groove, theta, in.upper) >= 0.0;
}

/* The last theta on the way from 0 to `stop` where both laws hold. */
static double transmission_end(const Groove groove[2], double stop) {
    double good = 0.0, bad = stop;
    for (int i = 0; i < 200; i++) {
        const double middle = 0.5 * (good + bad);
        if (middle == good || middle == bad) break;
        if (is_covered(groove, middle)) good = middle;
        else bad = middle;
    }
    return good;
}

/* The parameter to look at, "cam1.ellipse_a = 0.05" */
typedef struct {
    char text[QUOTED_PATH + 32];
} Name;

static Name name_of(const Params *p, int i) {
    const CamParams *cam = p->cam;
    Name name;
    switch (cam[i].profile) {
        case PROFILE_HELIX:
            snprintf(name.text, sizeof name.text, "cam%d.lead_angle = %.17g", i + 1, cam[i].lead_angle);
            break;
        case PROFILE_ELLIPSE:
            snprintf(name.text, sizeof name.text, "cam%d.ellipse_a = %.17g", i + 1, cam[i].ellipse_a);
            break;
        default:
            snprintf(name.text, sizeof name.text, "cam%d.table = \"%.*s\"", i + 1,
                     samples_quoted(p->table[i], QUOTED_PATH), p->table[i]);
    }
    return name;
}

static bool refuse_end(const Groove groove[2], const Params *p, double end, double stop, Fault *fault) {
    const bool up = stop > 0.0;
    const Interval in = gamma_range(groove, end);
    const double gamma = solve_gamma(groove, end, 0.5 * (in.lower + in.upper)), psi[2] = {gamma, end - gamma};
    double limit[2], room[2];
    for (int i = 0; i < 2; i++) {
        limit[i] = up ? groove[i].last : groove[i].first;
        room[i] = fabs(limit[i] - psi[i]);
    }
    const int i = room[1] < room[0] ? 1 : 0;
    const bool ellipse = groove[i].profile == PROFILE_ELLIPSE;
    const Name name = name_of(p, i);
    snprintf(fault->text, sizeof fault->text,
             "%s: the %s groove of cam %d ends at psi = %.10g rad, reached at theta = %.10g rad, "
             "before %s = %.10g rad: %s",
             name.text, ellipse ? "elliptical" : "sampled", i + 1, limit[i], end, up ? "stop.upper" : "stop.lower",
             stop,
             ellipse ? "S = S0 + kappa r psi/a must stay in [0, 1)" : "the samples must reach as far as the stops");
    return false;
}

static bool check_end(const Groove groove[2], const Params *p, double stop, Fault *fault) {
    if (is_covered(groove, stop)) return true;
    const double end = transmission_end(groove, stop);
    return fabs(stop - end) <= END_SLACK * (1.0 + fabs(stop)) || refuse_end(groove, p, end, stop, fault);
}

/* Both laws hold at theta = 0, so they do between it and any theta where they hold. */
static bool check_ends(const Groove groove[2], const Params *p, Fault *fault) {
    const double lower = p->stop.lower, upper = p->stop.upper;
    if (upper > 0.0 && !check_end(groove, p, upper, fault)) return false;
    return !(lower < 0.0) || check_end(groove, p, lower, fault);
}

static bool refuse_level(const Params *p, double theta, double z, Fault *fault) {
    const Name first = name_of(p, 0), second = name_of(p, 1);
    snprintf(fault->text, sizeof fault->text,
             "%s and %s: both grooves are level at theta = %.10g rad, z = %.10g m: between the stops at "
             "least one slope must be > 0, or nothing fixes the pin",
             first.text, second.text, theta, z);
    return false;
}

/* ---- borders: stops and table knots ---- */

typedef struct {
    double theta;
    bool knot;
} Breakpoint;

/* Where the pin meets the knots of cam i's table: those from stop to stop, give or take `slack`. */
static size_t collect_knots(const Transmission *transmission, int i, double slack, Breakpoint *out) {
    const Table *table = &transmission->groove[i].table;
    const Groove *other = &transmission->groove[1 - i];
    size_t count = 0;
    for (size_t j = 0; j <= table->count && table->count > 0; j++) {
        const double psi = j < table->count ? table->piece[j].psi : transmission->groove[i].last;
        const double z = groove_at(&transmission->groove[i], psi).z, theta = psi + groove_angle(other, z);
        const bool within = theta >= transmission->lower - slack && theta <= transmission->upper + slack;
        if (within) out[count++] = (Breakpoint){theta, true};
    }
    return count;
}

static int by_theta(const void *a, const void *b) {
    const double x = ((const Breakpoint *)a)->theta, y = ((const Breakpoint *)b)->theta;
    return (x > y) - (x < y);
}

/* Makes one border of those that differ by rounding only; the stops, in front and at the end, keep their
 * place. Returns how many are left. */
static size_t merge(Breakpoint *breakpoint, size_t count, double slack) {
    size_t kept = 1;
    for (size_t j = 1; j < count; j++) {
        Breakpoint *latest = &breakpoint[kept - 1];
        const bool is_end = j + 1 == count;
        if (breakpoint[j].theta - latest->theta > slack) {
            breakpoint[kept++] = breakpoint[j];
        } else if (is_end && kept > 1) {
            *latest = (Breakpoint){breakpoint[j].theta, latest->knot || breakpoint[j].knot};
        } else {
            latest->knot = latest->knot || breakpoint[j].knot;
        }
    }
    return kept;
}

/* All borders in order, to be freed by the caller; NULL if memory is short. */
static Breakpoint *breakpoints_of(const Transmission *transmission, size_t *count) {
    const size_t knots = transmission->groove[0].table.count + transmission->groove[1].table.count + 2;
    Breakpoint *breakpoint = malloc((knots + 2) * sizeof *breakpoint);
    if (!breakpoint) return NULL;
    const double slack = SAME_BREAKPOINT * (transmission->upper - transmission->lower);
    size_t n = 1 + collect_knots(transmission, 0, slack, breakpoint + 1);
    n += collect_knots(transmission, 1, slack, breakpoint + n);
    qsort(breakpoint + 1, n - 1, sizeof *breakpoint, by_theta);
    breakpoint[0] = (Breakpoint){transmission->lower, false};
    breakpoint[n++] = (Breakpoint){transmission->upper, false};
    *count = merge(breakpoint, n, slack);
    return breakpoint;
}

/* ---- polynomials ---- */

typedef struct {
    double node[N + 1];            /* extrema of T_N, rising: both borders are nodes, so that pieces meet */
    double weight[N + 1][N + 1];   /* c_k = sum_j weight[k][j] f(node[j]) */
    double monomial[N + 1][N + 1]; /* T_k = sum_m monomial[k][m] x^m */
    double check[CHECKS];          /* places between nodes */
} Basis;

/* Interpolation in the extrema of T_N (L. N. Trefethen, Approximation Theory and Approximation Practice,
 * chapters 3 and 4). */
static void build_basis(Basis *basis) {
    const double degree = N;
    double cosine[2 * N];
    for (int j = 0; j < 2 * N; j++) cosine[j] = cos(PI * j / degree);
    cosine[N / 2] = cosine[N + N / 2] = 0.0;
    for (int j = 0; j <= N; j++) basis->node[j] = -cosine[j];
    for (int k = 0; k <= N; k++) {
        for (int j = 0; j <= N; j++) {
            const double ends = (j == 0 || j == N ? 0.5 : 1.0) * (k == 0 || k == N ? 0.5 : 1.0);
            basis->weight[k][j] = ends * 2.0 / degree * cosine[(k * (N - j)) % (2 * N)];
        }
    }
    memset(basis->monomial, 0, sizeof basis->monomial);
    basis->monomial[0][0] = basis->monomial[1][1] = 1.0;
    for (int k = 2; k <= N; k++) {
        for (int m = 0; m <= k; m++) basis->monomial[k][m] = -basis->monomial[k - 2][m];
        for (int m = 1; m <= k; m++) basis->monomial[k][m] += 2.0 * basis->monomial[k - 1][m - 1];
    }
    for (int j = 0; j < CHECKS; j++) basis->check[j] = -cos(PI * (2 * j + 0.5) / degree);
}

/* Chebyshev coefficients of the polynomial through f(node[j]). The constant part is kept out of the sums,
 * for its rounding would end up in every coefficient. */
static void interpolate(const Basis *basis, const double f[N + 1], double c[N + 1]) {
    double rest[N + 1];
    for (int j = 0; j <= N; j++) rest[j] = f[j] - f[N / 2];
    for (int k = 0; k <= N; k++) {
        double sum = 0.0;
        for (int j = 0; j <= N; j++) sum += basis->weight[k][j] * rest[j];
        c[k] = sum;
    }
    c[0] += f[N / 2];
}

static void to_monomials(const Basis *basis, const double c[N + 1], double out[N + 1]) {
    for (int m = 0; m <= N; m++) out[m] = 0.0;
    for (int k = N; k >= 0; k--)
        for (int m = k & 1; m <= k; m += 2) out[m] += c[k] * basis->monomial[k][m];
}

/* ---- pieces ---- */

typedef struct {
    Transmission *transmission;
    const Params *params;
    Fault *fault;
    Basis basis;
    size_t capacity, limit;      /* of pieces */
    double narrowest;            /* rad, pieces are not halved below that */
    double steepest[2], highest; /* largest |a_i| and |z| of the whole range */
    Sight latest;                /* the next root is sought from here */
    double latest_theta;
} Builder;

static Sight look_on(Builder *b, double theta) {
    const double sum = b->latest.slope[0] + b->latest.slope[1];
    const double dpsi_dtheta = sum > 0.0 ? b->latest.slope[1] / sum : 0.5;
    b->latest =
        configuration_at(b->transmission->groove, theta, b->latest.gamma + dpsi_dtheta * (theta - b->latest_theta));
    b->latest_theta = theta;
    return b->latest;
}

static bool refuse_pieces(const Builder *b) {
    snprintf(b->fault->text, sizeof b->fault->text,
             "stop.lower = %.17g, stop.upper = %.17g: describing the grooves in between takes more than %zu "
             "polynomials or more memory than there is: the range must be smaller",
             b->transmission->lower, b->transmission->upper, b->limit);
    return false;
}

static bool append(Builder *b, const TransmissionPiece *piece) {
    Transmission *transmission = b->transmission;
    if (transmission->count == b->limit) return refuse_pieces(b);
    if (transmission->count == b->capacity) {
        const size_t capacity = b->capacity ? 2 * b->capacity : 16;
        TransmissionPiece *larger = realloc(transmission->piece, capacity * sizeof *larger);
        if (!larger) return refuse_pieces(b);
        transmission->piece = larger;
        b->capacity = capacity;
    }
    transmission->piece[transmission->count++] = *piece;
    return true;
}

typedef enum { FITS, TOO_COARSE, UNDETERMINED } Verdict;

/* a_1, a_2 and z' at the nodes of a piece, z at its middle and ends, and how far a polynomial may be off. */
typedef struct {
    double value[3][N + 1];
    double allowed[3];
    double z_lower, z_middle, z_upper, z_allowed;
} Nodes;

static double node_theta(const Builder *b, const TransmissionPiece *piece, int j) {
    if (j == 0) return piece->lower;
    return j == N ? piece->upper : piece->middle + b->basis.node[j] / piece->scale;
}

static double dz_dtheta_of(const double slope[2]) {
    return slope[0] * (slope[1] / (slope[0] + slope[1]));
}

/* A polynomial of a_i may be off by a share of the largest a_i on the range, or, if an end close to
 * vertical makes that huge, of the largest on the piece or slope 1; and by what rounding does to a_i
 * anyway. False if nothing fixes the pin at a node. */
static bool look_at_nodes(Builder *b, const TransmissionPiece *piece, Nodes *nodes) {
    double doubt[2] = {0.0, 0.0}, steepest[2] = {b->params->cam[0].radius, b->params->cam[1].radius};
    for (int j = 0; j <= N; j++) {
        const Sight sight = look_on(b, node_theta(b, piece, j));
        if (is_undetermined(b->transmission->groove, &sight)) return false;
        for (int i = 0; i < 2; i++) {
            nodes->value[i][j] = sight.slope[i];
            steepest[i] = fmax(steepest[i], sight.slope[i]);
            doubt[i] = fmax(doubt[i], sight.doubt[i]);
        }
        nodes->value[2][j] = dz_dtheta_of(sight.slope);
        if (j == 0) nodes->z_lower = sight.z;
        if (j == N / 2) nodes->z_middle = sight.z;
        if (j == N) nodes->z_upper = sight.z;
    }
    for (int i = 0; i < 2; i++)
        nodes->allowed[i] = TOLERANCE * fmin(b->steepest[i], steepest[i]) + DOUBT_SAFETY * doubt[i];
    nodes->allowed[2] = nodes->allowed[0] + nodes->allowed[1]; /* no partial derivative of z' exceeds 1 */
    nodes->z_allowed = TOLERANCE * b->highest;
    return true;
}

/* The slope of cam i's groove. False if the last two Chebyshev coefficients are so large that there is no need to look
 * between nodes. */
static bool set_slope(const Basis *basis, const double f[N + 1], double allowed, int i, TransmissionPiece *piece) {
    double c[N + 1], monomial[N + 1];
    interpolate(basis, f, c);
    to_monomials(basis, c, monomial);
    for (int k = 0; k <= N; k++) piece->slope[k][i] = monomial[k];
    return fabs(c[N]) + fabs(c[N - 1]) <= 100.0 * allowed;
}

/* z is the integral of z', so that its derivative belongs to the slopes as well as they are known: else the
 * energy of the spring would not be the work of its force. */
static bool set_height(const Basis *basis, const Nodes *nodes, TransmissionPiece *piece) {
    double c[N + 1], dz_dtheta[N + 1];
    interpolate(basis, nodes->value[2], c);
    if (fabs(c[N]) > nodes->allowed[2]) return false;
    c[N] = 0.0;
    to_monomials(basis, c, dz_dtheta);
    piece->z[0] = nodes->z_middle;
    for (int m = 0; m < N; m++) piece->z[m + 1] = dz_dtheta[m] / ((m + 1) * piece->scale);
    return true;
}

/* A helix has one slope: no rounding of an interpolation. */
static void set_helix(const Transmission *transmission, TransmissionPiece *piece) {
    for (int i = 0; i < 2; i++) {
        if (transmission->groove[i].profile != PROFILE_HELIX) continue;
        for (int k = 1; k <= N; k++) piece->slope[k][i] = 0.0;
        piece->slope[0][i] = transmission->groove[i].gain;
    }
}

static bool near(double a, double b, double allowed) {
    return fabs(a - b) <= allowed;
}

/* dz/dtheta by the polynomial of z */
static double lift_by_height(const TransmissionPiece *piece, double theta) {
    const double x = (theta - piece->middle) * piece->scale;
    double sum = 0.0;
    for (int k = N; k > 0; k--) sum = sum * x + k * piece->z[k];
    return sum * piece->scale;
}

static bool is_true_at(const TransmissionPiece *piece, double theta, const Sight *sight, const Nodes *nodes) {
    const TransmissionPoint point = piece_at(piece, theta);
    return near(point.slope[0], sight->slope[0], nodes->allowed[0]) &&
           near(point.slope[1], sight->slope[1], nodes->allowed[1]) && near(point.z, sight->z, nodes->z_allowed) &&
           near(lift_by_height(piece, theta), dz_dtheta_of(sight->slope), nodes->allowed[2]);
}

static bool is_true_between_nodes(Builder *b, const TransmissionPiece *piece, const Nodes *nodes) {
    for (int j = 0; j < CHECKS; j++) {
        const double theta = piece->middle + b->basis.check[j] / piece->scale;
        const Sight sight = look_on(b, theta);
        if (!is_true_at(piece, theta, &sight, nodes)) return false;
    }
    return true;
}

static bool meets_neighbours(const TransmissionPiece *piece, const Nodes *nodes) {
    return near(piece_at(piece, piece->lower).z, nodes->z_lower, nodes->z_allowed) &&
           near(piece_at(piece, piece->upper).z, nodes->z_upper, nodes->z_allowed);
}

/* Fills the piece's polynomials; its borders are set. */
static Verdict fit(Builder *b, TransmissionPiece *piece) {
    Nodes nodes;
    if (!look_at_nodes(b, piece, &nodes)) return UNDETERMINED;
    bool good = set_height(&b->basis, &nodes, piece);
    for (int i = 0; i < 2; i++) good = set_slope(&b->basis, nodes.value[i], nodes.allowed[i], i, piece) && good;
    set_helix(b->transmission, piece);
    good = good && meets_neighbours(piece, &nodes) && is_true_between_nodes(b, piece, &nodes);
    return good ? FITS : TOO_COARSE;
}

static TransmissionPiece piece_between(Breakpoint lower, Breakpoint upper) {
    return (TransmissionPiece){
        .lower = lower.theta,
        .upper = upper.theta,
        .middle = 0.5 * (lower.theta + upper.theta),
        .scale = 2.0 / (upper.theta - lower.theta),
        .knot_lower = lower.knot,
        .knot_upper = upper.knot,
    };
}

/* Appends pieces from border to border, halving until they fit. */
static bool cover(Builder *b, Breakpoint lower, Breakpoint upper) {
    TransmissionPiece piece = piece_between(lower, upper);
    const Verdict verdict = fit(b, &piece);
    if (verdict == UNDETERMINED) return refuse_level(b->params, b->latest_theta, b->latest.z, b->fault);
    if (verdict == FITS || upper.theta - lower.theta <= b->narrowest) return append(b, &piece);
    const Breakpoint middle = {piece.middle, false};
    return cover(b, lower, middle) && cover(b, middle, upper);
}

/* Slopes are largest at a border or, between two knots, about as large as in the middle. */
static void measure(Builder *b, const Breakpoint *breakpoint, size_t count) {
    for (size_t j = 0; j < 2 * count - 1; j++) {
        const double left = breakpoint[j / 2].theta, right = breakpoint[(j + 1) / 2].theta;
        const Sight sight = look_on(b, 0.5 * (left + right));
        for (int i = 0; i < 2; i++) b->steepest[i] = fmax(b->steepest[i], sight.slope[i]);
        b->highest = fmax(b->highest, fabs(sight.z));
    }
}

static bool build_pieces(Transmission *transmission, const Params *p, Fault *fault) {
    Builder b = {.transmission = transmission, .params = p, .fault = fault, .limit = MAX_PIECES};
    size_t count = 0;
    Breakpoint *breakpoint = breakpoints_of(transmission, &count);
    if (!breakpoint) return refuse_pieces(&b);
    build_basis(&b.basis);
    b.limit += count;
    b.narrowest = SAME_BREAKPOINT * (transmission->upper - transmission->lower);
    measure(&b, breakpoint, count);
    bool good = true;
    for (size_t j = 0; good && j + 1 < count; j++) good = cover(&b, breakpoint[j], breakpoint[j + 1]);
    free(breakpoint);
    return good;
}

/* Two helices: everything is linear in theta. */
static bool build_straight(Transmission *transmission, const Params *p, Fault *fault) {
    const double slope[2] = {transmission->groove[0].gain, transmission->groove[1].gain};
    if (!(slope[0] + slope[1] > 0.0)) return refuse_level(p, transmission->lower, 0.0, fault);
    transmission->piece = malloc(sizeof *transmission->piece);
    if (!transmission->piece) {
        snprintf(fault->text, sizeof fault->text, "not enough memory: %zu bytes must be available",
                 sizeof(TransmissionPiece));
        return false;
    }
    transmission->count = 1;
    *transmission->piece = (TransmissionPiece){
        .lower = transmission->lower,
        .upper = transmission->upper,
        .scale = 1.0,
        .slope = {{slope[0], slope[1]}},
        .z = {0.0, dz_dtheta_of(slope)},
    };
    return true;
}

static bool check_stops(double lower, double upper, Fault *fault) {
    if (isfinite(lower) && isfinite(upper) && lower < upper) return true;
    snprintf(fault->text, sizeof fault->text,
             "stop.lower = %.17g must be < stop.upper = %.17g, and both must be finite", lower, upper);
    return false;
}

static bool build(Transmission *transmission, const Params *p, const char *resources, Fault *fault) {
    if (!check_stops(p->stop.lower, p->stop.upper, fault)) return false;
    for (int i = 0; i < 2; i++)
        if (!groove_build(&transmission->groove[i], p, i + 1, resources, fault)) return false;
    if (transmission->straight) return build_straight(transmission, p, fault);
    return check_ends(transmission->groove, p, fault) && build_pieces(transmission, p, fault);
}

/* z is monotone; so is, from piece to piece nearly, a slope. */
static void measure_size(Transmission *transmission) {
    for (size_t k = 0; !transmission->straight && k < transmission->count; k++) {
        const double ends[2] = {transmission->piece[k].lower, transmission->piece[k].upper};
        for (int i = 0; i < 2; i++) {
            const TransmissionPoint point = piece_at(&transmission->piece[k], ends[i]);
            transmission->slope_size = fmax(transmission->slope_size, fmax(fabs(point.slope[0]), fabs(point.slope[1])));
            transmission->z_size = fmax(transmission->z_size, fabs(point.z));
        }
    }
}

bool transmission_build(Transmission *transmission, const Params *p, const char *resources, Fault *fault) {
    *transmission = (Transmission){
        .cam = {p->cam[0], p->cam[1]},
        .lower = p->stop.lower,
        .upper = p->stop.upper,
        .straight = p->cam[0].profile == PROFILE_HELIX && p->cam[1].profile == PROFILE_HELIX,
    };
    const bool good = build(transmission, p, resources, fault);
    if (good) measure_size(transmission);
    else transmission_free(transmission);
    return good;
}

void transmission_free(Transmission *transmission) {
    for (int i = 0; i < 2; i++) groove_free(&transmission->groove[i]);
    free(transmission->piece);
    *transmission = (Transmission){.piece = NULL};
}

static bool is_same_groove(const Transmission *transmission, const Params *p, int i) {
    CamParams cam = p->cam[i];
    cam.friction = transmission->cam[i].friction;
    const char *path = transmission->groove[i].path;
    return memcmp(&cam, &transmission->cam[i], sizeof cam) == 0 && (path == NULL || strcmp(path, p->table[i]) == 0);
}

bool transmission_is_of(const Transmission *transmission, const Params *p) {
    return transmission->piece != NULL && transmission->lower == p->stop.lower &&
           transmission->upper == p->stop.upper && is_same_groove(transmission, p, 0) &&
           is_same_groove(transmission, p, 1);
}

/* ---- reading ---- */

const TransmissionPiece *transmission_piece(const Transmission *transmission, double theta, int direction) {
    size_t low = 0, high = transmission->count; /* piece[low].lower <= theta < piece[high].lower */
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (theta >= transmission->piece[middle].lower) low = middle;
        else high = middle;
    }
    const TransmissionPiece *piece = &transmission->piece[low];
    const double near = SAME_BREAKPOINT * (piece->upper - piece->lower);
    if (direction > 0 && low + 1 < transmission->count && theta >= piece->upper - near) return piece + 1;
    if (direction < 0 && low > 0 && theta <= piece->lower + near) return piece - 1;
    return piece;
}

/* The polynomials know z well enough to start Newton's method next to the root. */
static double guess_gamma(const Transmission *transmission, double theta) {
    const TransmissionPoint point = piece_at(transmission_piece(transmission, theta, 0), theta);
    if (point.slope[0] >= point.slope[1]) return groove_angle(&transmission->groove[0], point.z);
    return theta - groove_angle(&transmission->groove[1], point.z);
}

double transmission_gamma(const Transmission *transmission, double theta) {
    if (transmission->straight) {
        const double a1 = transmission->groove[0].gain, a2 = transmission->groove[1].gain;
        return a2 / (a1 + a2) * theta;
    }
    return solve_gamma(transmission->groove, theta, guess_gamma(transmission, theta));
}

double transmission_z(const Transmission *transmission, double theta) {
    if (transmission->straight) return transmission->piece->z[1] * theta;
    const double gamma = transmission_gamma(transmission, theta);
    return flatter_height(groove_at(&transmission->groove[0], gamma),
                          groove_at(&transmission->groove[1], theta - gamma));
}
