#include "geometry/transmission_build.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "elementary/elementary.h"
#include "geometry/cam.h"
#include "geometry/groove_pair.h"
#include "geometry/pin_position.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- breakpoints ---- */

/* Where the polynomials must end: at the stops, and where the pin meets a knot of a table, for there the third
 * derivative of the groove jumps. */
typedef struct {
    double theta; /* rad */
    bool knot;    /* a knot of a table lies there */
} Breakpoint;

/* The stops, and what counts as the same theta. */
typedef struct {
    double lower, upper, slack; /* rad */
} StopRange;

/* Where the pin meets the knots of cam i's table, from stop to stop. Returns the number of breakpoints written. */
static size_t collect_knots(const Groove groove[2], int i, const StopRange *range, Breakpoint *out) {
    const Table *table = &groove[i].table;
    const Groove *other = &groove[1 - i];
    size_t count = 0;
    for (size_t j = 0; j <= table->count && table->count > 0; j++) {
        const double psi = j < table->count ? table->piece[j].psi : groove[i].last;
        const double z = groove_at(&groove[i], psi).z, theta = psi + groove_angle(other, z);
        const bool within = theta >= range->lower - range->slack && theta <= range->upper + range->slack;
        if (within) out[count++] = (Breakpoint){theta, true};
    }
    return count;
}

static int by_theta(const void *a, const void *b) {
    const double x = ((const Breakpoint *)a)->theta, y = ((const Breakpoint *)b)->theta;
    return (x > y) - (x < y);
}

/* Makes one breakpoint of those that differ by rounding only. The stops, at the front and at the end, keep their place.
 * Returns the number that remains. */
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

/* All breakpoints in order, from `lower` to `upper`, to be freed by the caller; NULL if memory is short. */
static Breakpoint *find_breakpoints(const Groove groove[2], double lower, double upper, size_t *count) {
    const StopRange range = {lower, upper, BREAKPOINT_MERGING * (upper - lower)};
    const size_t knots = groove[0].table.count + groove[1].table.count + 2;
    Breakpoint *breakpoint = malloc((knots + 2) * sizeof *breakpoint);
    if (!breakpoint) return NULL;
    size_t n = 1 + collect_knots(groove, 0, &range, breakpoint + 1);
    n += collect_knots(groove, 1, &range, breakpoint + n);
    qsort(breakpoint + 1, n - 1, sizeof *breakpoint, by_theta);
    breakpoint[0] = (Breakpoint){lower, false};
    breakpoint[n++] = (Breakpoint){upper, false};
    *count = merge(breakpoint, n, range.slack);
    return breakpoint;
}

/* ---- fit: interpolation in Chebyshev points, compared with the groove laws ---- */

enum { N = TRANSMISSION_DEGREE };

/* A transmission that is being built. */
typedef struct {
    Transmission *transmission;
    const Params *params;
    Fault *fault;
    ChebyshevBasis basis;
    size_t capacity, limit;      /* of pieces */
    double narrowest;            /* rad, pieces are not halved below this width */
    double steepest[2], highest; /* largest |a_i| and |z| between the stops */
    PinPosition latest;          /* the search for the next pin position starts from here */
    double latest_theta;
} Fit;

NOINLINE static PinPosition position_at(Fit *fit, double theta) {
    const double sum = fit->latest.slope[0] + fit->latest.slope[1];
    const double dgamma_dtheta = sum > 0.0 ? fit->latest.slope[1] / sum : 0.5;
    const double guess = fit->latest.gamma + dgamma_dtheta * (theta - fit->latest_theta);
    fit->latest = pin_position(fit->transmission->groove, theta, guess);
    fit->latest_theta = theta;
    return fit->latest;
}

/* ---- the list of pieces ---- */

static bool refuse_pieces(const Fit *fit) {
    snprintf(fit->fault->text, sizeof fit->fault->text,
             "stop.lower = %s, stop.upper = %s: describing the grooves in between takes more than %zu "
             "polynomials or more memory than there is: the range must be smaller",
             shortest_decimal(fit->transmission->lower).text, shortest_decimal(fit->transmission->upper).text,
             fit->limit);
    return false;
}

static bool append(Fit *fit, const TransmissionPiece *piece) {
    Transmission *transmission = fit->transmission;
    if (transmission->count == fit->limit) return refuse_pieces(fit);
    if (transmission->count == fit->capacity) {
        const size_t capacity = fit->capacity ? 2 * fit->capacity : 16;
        TransmissionPiece *larger = realloc(transmission->piece, capacity * sizeof *larger);
        if (!larger) return refuse_pieces(fit);
        transmission->piece = larger;
        fit->capacity = capacity;
    }
    transmission->piece[transmission->count++] = *piece;
    return true;
}

/* ---- samples at the nodes of one piece ---- */

/* a_1, a_2 and z' at the nodes, z at the middle and at the ends, and the errors allowed to the polynomials. */
typedef struct {
    double value[3][N + 1]; /* m/rad */
    double allowed[3];      /* m/rad */
    double z_lower, z_middle, z_upper, z_allowed;
} NodeSamples;

static double node_theta(const Fit *fit, const TransmissionPiece *piece, int j) {
    if (j == 0) return piece->lower;
    return j == N ? piece->upper : piece->middle + fit->basis.node[j] / piece->scale;
}

/* The error allowed to a_i is a share of the largest a_i between the stops or, where an end close to vertical makes
 * this value huge, of the larger of the piece's largest a_i and of slope 1; plus the rounding of a_i. Numbers below
 * DBL_MIN have few digits: a lead angle of 1e-315 rad would need more pieces than there may be. */
static void set_allowed(const Fit *fit, const double steepest[2], const double rounding[2], NodeSamples *samples) {
    for (int i = 0; i < 2; i++)
        samples->allowed[i] = TRANSMISSION_ERROR * min_of(fit->steepest[i], steepest[i]) +
                              TRANSMISSION_ROUNDING_FACTOR * rounding[i] + DBL_MIN;
    samples->allowed[2] = samples->allowed[0] + samples->allowed[1]; /* |dz'/da_i| <= 1 */
    samples->z_allowed = TRANSMISSION_ERROR * fit->highest + DBL_MIN;
}

/* On a dwell of a table the slope is 0 at all inner nodes. The knots at its ends are known to a rounding, past which
 * the slope has begun to rise. The polynomial would carry this rise, some 1e-50 m/rad, all over the dwell, where a
 * contact that friction locks under a slope > 0 would jam. */
static void level_dwells(NodeSamples *samples) {
    for (int i = 0; i < 3; i++) {
        double steepest = 0.0;
        for (int j = 1; j < N; j++) steepest = max_of(steepest, samples->value[i][j]);
        if (steepest == 0.0) samples->value[i][0] = samples->value[i][N] = 0.0;
    }
}

/* False if nothing fixes the pin at a node. */
static bool sample_nodes(Fit *fit, const TransmissionPiece *piece, NodeSamples *samples) {
    double rounding[2] = {0.0, 0.0}, steepest[2] = {fit->params->cam[0].radius, fit->params->cam[1].radius};
    for (int j = 0; j <= N; j++) {
        const PinPosition position = position_at(fit, node_theta(fit, piece, j));
        if (pin_is_undetermined(fit->transmission->groove, &position)) return false;
        for (int i = 0; i < 2; i++) {
            samples->value[i][j] = position.slope[i];
            steepest[i] = max_of(steepest[i], position.slope[i]);
            rounding[i] = max_of(rounding[i], position.rounding[i]);
        }
        samples->value[2][j] = cam_dz_dtheta(position.slope);
        if (j == 0) samples->z_lower = position.z;
        if (j == N / 2) samples->z_middle = position.z;
        if (j == N) samples->z_upper = position.z;
    }
    level_dwells(samples);
    set_allowed(fit, steepest, rounding, samples);
    return true;
}

/* ---- polynomials of one piece ---- */

/* The slope of cam i's groove. False if the last two Chebyshev coefficients are so large that the polynomial cannot be
 * accurate between the nodes. */
static bool set_slope(const ChebyshevBasis *basis, const double f[N + 1], double allowed, int i,
                      TransmissionPiece *piece) {
    double c[N + 1], monomial[N + 1];
    chebyshev_interpolate(basis, f, c);
    chebyshev_to_monomials(basis, c, monomial);
    for (int k = 0; k <= N; k++) piece->slope[k][i] = monomial[k];
    return fabs(c[N]) + fabs(c[N - 1]) <= CHEBYSHEV_TAIL_FACTOR * allowed;
}

/* z is the integral of z', so that the derivative of z agrees with the slopes: else the energy of the spring were not
 * the work of its force. */
static bool set_height(const ChebyshevBasis *basis, const NodeSamples *samples, TransmissionPiece *piece) {
    double c[N + 1], dz_dtheta[N + 1];
    chebyshev_interpolate(basis, samples->value[2], c);
    if (fabs(c[N]) > samples->allowed[2]) return false;
    c[N] = 0.0; /* the integral must not exceed degree N */
    chebyshev_to_monomials(basis, c, dz_dtheta);
    piece->z[0] = samples->z_middle;
    for (int m = 0; m < N; m++) piece->z[m + 1] = dz_dtheta[m] / ((m + 1) * piece->scale);
    return true;
}

/* The slope of a helix is constant: the interpolation's rounding is removed. */
static void set_helix(const Transmission *transmission, TransmissionPiece *piece) {
    for (int i = 0; i < 2; i++) {
        if (transmission->groove[i].profile != PROFILE_HELIX) continue;
        for (int k = 1; k <= N; k++) piece->slope[k][i] = 0.0;
        piece->slope[0][i] = transmission->groove[i].gain;
    }
}

/* ---- comparison with the groove laws ---- */

static bool near(double a, double b, double allowed) {
    return fabs(a - b) <= allowed;
}

/* dz/dtheta by the polynomial of z */
static double derivative_of_height(const TransmissionPiece *piece, double theta) {
    const double x = (theta - piece->middle) * piece->scale;
    double sum = 0.0;
    for (int k = N; k > 0; k--) sum = sum * x + k * piece->z[k];
    return sum * piece->scale;
}

static bool is_accurate_at(const TransmissionPiece *piece, double theta, const PinPosition *position,
                           const NodeSamples *samples) {
    const TransmissionPoint point = piece_at(piece, theta);
    return near(point.slope[0], position->slope[0], samples->allowed[0]) &&
           near(point.slope[1], position->slope[1], samples->allowed[1]) &&
           near(point.z, position->z, samples->z_allowed) &&
           near(derivative_of_height(piece, theta), cam_dz_dtheta(position->slope), samples->allowed[2]);
}

static bool is_accurate_between_nodes(Fit *fit, const TransmissionPiece *piece, const NodeSamples *samples) {
    for (int j = 0; j < CHEBYSHEV_CHECKS; j++) {
        const double theta = piece->middle + fit->basis.check[j] / piece->scale;
        const PinPosition position = position_at(fit, theta);
        if (!is_accurate_at(piece, theta, &position, samples)) return false;
    }
    return true;
}

static bool meets_neighbours(const TransmissionPiece *piece, const NodeSamples *samples) {
    return near(piece_at(piece, piece->lower).z, samples->z_lower, samples->z_allowed) &&
           near(piece_at(piece, piece->upper).z, samples->z_upper, samples->z_allowed);
}

/* ---- pieces from breakpoint to breakpoint ---- */

typedef enum { PIECE_ACCURATE, PIECE_TOO_WIDE, PIECE_UNDETERMINED /* nothing fixes the pin */ } PieceQuality;

/* Fills the polynomials of a piece whose ends are set. */
static PieceQuality fit_piece(Fit *fit, TransmissionPiece *piece) {
    NodeSamples samples;
    if (!sample_nodes(fit, piece, &samples)) return PIECE_UNDETERMINED;
    bool good = set_height(&fit->basis, &samples, piece);
    for (int i = 0; i < 2; i++) good = set_slope(&fit->basis, samples.value[i], samples.allowed[i], i, piece) && good;
    set_helix(fit->transmission, piece);
    good = good && meets_neighbours(piece, &samples) && is_accurate_between_nodes(fit, piece, &samples);
    return good ? PIECE_ACCURATE : PIECE_TOO_WIDE;
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

/* Appends pieces from one breakpoint to the next, halved until they are accurate or as narrow as allowed. */
static bool fit_between(Fit *fit, Breakpoint lower, Breakpoint upper) {
    TransmissionPiece piece = piece_between(lower, upper);
    const PieceQuality quality = fit_piece(fit, &piece);
    if (quality == PIECE_UNDETERMINED)
        return groove_pair_refuse_level(fit->transmission->groove, fit->latest_theta, fit->latest.z, fit->fault);
    if (quality == PIECE_ACCURATE || upper.theta - lower.theta <= fit->narrowest) return append(fit, &piece);
    const Breakpoint middle = {piece.middle, false};
    return fit_between(fit, lower, middle) && fit_between(fit, middle, upper);
}

/* A slope is largest at a breakpoint or, between two knots, about as large as in the middle. */
static void measure(Fit *fit, const Breakpoint *breakpoint, size_t count) {
    for (size_t j = 0; j < 2 * count - 1; j++) {
        const double left = breakpoint[j / 2].theta, right = breakpoint[(j + 1) / 2].theta;
        const PinPosition position = position_at(fit, 0.5 * (left + right));
        for (int i = 0; i < 2; i++) fit->steepest[i] = max_of(fit->steepest[i], position.slope[i]);
        fit->highest = max_of(fit->highest, fabs(position.z));
    }
}

/* Fills the pieces of a transmission whose grooves and stops are set and whose grooves reach the stops. */
static bool fit_pieces(Transmission *transmission, const Params *p, Fault *fault) {
    Fit fit = {.transmission = transmission, .params = p, .fault = fault, .limit = TRANSMISSION_MAX_PIECES};
    const double lower = transmission->lower, upper = transmission->upper;
    size_t count = 0;
    Breakpoint *breakpoint = find_breakpoints(transmission->groove, lower, upper, &count);
    if (!breakpoint) return refuse_pieces(&fit);
    chebyshev_build(&fit.basis);
    fit.limit += count;
    fit.narrowest = BREAKPOINT_MERGING * (upper - lower);
    measure(&fit, breakpoint, count);
    bool good = true;
    /* At most one turn per breakpoint. */
    for (size_t j = 0; good && j + 1 < count; j++) good = fit_between(&fit, breakpoint[j], breakpoint[j + 1]);
    free(breakpoint);
    return good;
}

/* ---- the transmission ---- */

/* Two helices: gamma, phi and z are linear in theta. */
static bool build_straight(Transmission *transmission, Fault *fault) {
    const double slope[2] = {transmission->groove[0].gain, transmission->groove[1].gain};
    if (!(slope[0] + slope[1] > 0.0))
        return groove_pair_refuse_level(transmission->groove, transmission->lower, 0.0, fault);
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
        .z = {0.0, cam_dz_dtheta(slope)},
    };
    return true;
}

static bool check_stops(double lower, double upper, Fault *fault) {
    if (isfinite(lower) && isfinite(upper) && lower < upper) return true;
    snprintf(fault->text, sizeof fault->text, "stop.lower = %s must be < stop.upper = %s, and both must be finite",
             shortest_decimal(lower).text, shortest_decimal(upper).text);
    return false;
}

static bool build(Transmission *transmission, const Params *p, const char *resources, Fault *fault) {
    if (!check_stops(p->stop.lower, p->stop.upper, fault)) return false;
    for (int i = 0; i < 2; i++)
        if (!groove_build(&transmission->groove[i], p, i + 1, resources, fault)) return false;
    if (transmission->straight) return build_straight(transmission, fault);
    return groove_pair_check_ends(transmission->groove, p, fault) && fit_pieces(transmission, p, fault);
}

/* At the ends of the pieces z, being monotone, is largest, and so, nearly, are the slopes. */
static void measure_size(Transmission *transmission) {
    for (size_t k = 0; !transmission->straight && k < transmission->count; k++) {
        const double ends[2] = {transmission->piece[k].lower, transmission->piece[k].upper};
        for (int i = 0; i < 2; i++) {
            const TransmissionPoint point = piece_at(&transmission->piece[k], ends[i]);
            transmission->slope_size =
                max_of(transmission->slope_size, max_of(fabs(point.slope[0]), fabs(point.slope[1])));
            for (int j = 0; j < 2; j++)
                if (transmission->groove[j].profile != PROFILE_HELIX)
                    transmission->steepest[j] = max_of(transmission->steepest[j], fabs(point.slope[j]));
            transmission->z_size = max_of(transmission->z_size, fabs(point.z));
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
