#include "numerics/chebyshev.h"

#include <string.h>

#include "elementary/elementary.h"
#include "platform/attributes.h"

enum { N = CHEBYSHEV_DEGREE };

static const double PI = 3.14159265358979323846;

/* c_k = (2/N) sum'' f(x_j) cos(k (N - j) pi/N), where '' halves the first and the last term, and c_0 and c_N too. */
static void build_weights(const double cosine[2 * N], ChebyshevBasis *basis) {
    const double degree = N;
    for (int k = 0; k <= N; k++) {
        for (int j = 0; j <= N; j++) {
            const double ends = (j == 0 || j == N ? 0.5 : 1.0) * (k == 0 || k == N ? 0.5 : 1.0);
            basis->weight[k][j] = ends * 2.0 / degree * cosine[(k * (N - j)) % (2 * N)];
        }
    }
}

/* T_k = 2 x T_{k-1} - T_{k-2} */
static void build_monomials(ChebyshevBasis *basis) {
    memset(basis->monomial, 0, sizeof basis->monomial);
    basis->monomial[0][0] = basis->monomial[1][1] = 1.0;
    for (int k = 2; k <= N; k++) {
        for (int m = 0; m <= k; m++) basis->monomial[k][m] = -basis->monomial[k - 2][m];
        for (int m = 1; m <= k; m++) basis->monomial[k][m] += 2.0 * basis->monomial[k - 1][m - 1];
    }
}

void chebyshev_build(ChebyshevBasis *basis) {
    const double degree = N;
    double cosine[2 * N];
    for (int j = 0; j < 2 * N; j++) cosine[j] = elementary_sin_cos(PI * j / degree).cos;
    cosine[N / 2] = cosine[N + N / 2] = 0.0;
    for (int j = 0; j <= N; j++) basis->node[j] = -cosine[j];
    build_weights(cosine, basis);
    build_monomials(basis);
    for (int j = 0; j < CHEBYSHEV_CHECKS; j++) basis->check[j] = -elementary_sin_cos(PI * (2 * j + 0.5) / degree).cos;
}

/* The value at the middle node is kept out of the sums: its rounding would enter every coefficient. */
NOINLINE void chebyshev_interpolate(const ChebyshevBasis *basis, const double f[CHEBYSHEV_NODES],
                                    double c[CHEBYSHEV_NODES]) {
    double rest[N + 1];
    for (int j = 0; j <= N; j++) rest[j] = f[j] - f[N / 2];
    for (int k = 0; k <= N; k++) {
        double sum = 0.0;
        for (int j = 0; j <= N; j++) sum += basis->weight[k][j] * rest[j];
        c[k] = sum;
    }
    c[0] += f[N / 2];
}

NOINLINE void chebyshev_to_monomials(const ChebyshevBasis *basis, const double c[CHEBYSHEV_NODES],
                                     double out[CHEBYSHEV_NODES]) {
    for (int m = 0; m <= N; m++) out[m] = 0.0;
    for (int k = N; k >= 0; k--)
        for (int m = k & 1; m <= k; m += 2) out[m] += c[k] * basis->monomial[k][m];
}
