#include "numerics/lu.h"

#include <math.h>

static int pivot_row(const Lu *lu, int k) {
    int p = k;
    for (int i = k + 1; i < lu->n; i++)
        if (fabs(lu->a[i][k]) > fabs(lu->a[p][k])) p = i;
    return p;
}

static void exchange_rows(Lu *lu, int k, int p) {
    for (int j = 0; p != k && j < lu->n; j++) {
        const double row = lu->a[k][j];
        lu->a[k][j] = lu->a[p][j];
        lu->a[p][j] = row;
    }
}

bool lu_factorize(Lu *lu) {
    for (int k = 0; k < lu->n; k++) {
        const int p = pivot_row(lu, k);
        lu->pivot[k] = p;
        if (!(fabs(lu->a[p][k]) > 0.0)) return false;
        exchange_rows(lu, k, p);
        const double inverse = 1.0 / lu->a[k][k];
        for (int i = k + 1; i < lu->n; i++) {
            const double l = lu->a[i][k] *= inverse;
            for (int j = k + 1; j < lu->n; j++) lu->a[i][j] -= l * lu->a[k][j];
        }
    }
    return true;
}

void lu_solve(const Lu *lu, double x[LU_MAX]) {
    for (int k = 0; k < lu->n; k++) {
        const double exchanged = x[lu->pivot[k]];
        x[lu->pivot[k]] = x[k];
        x[k] = exchanged;
    }
    for (int i = 1; i < lu->n; i++)
        for (int j = 0; j < i; j++) x[i] -= lu->a[i][j] * x[j];
    for (int i = lu->n - 1; i >= 0; i--) {
        for (int j = i + 1; j < lu->n; j++) x[i] -= lu->a[i][j] * x[j];
        x[i] /= lu->a[i][i];
    }
}
