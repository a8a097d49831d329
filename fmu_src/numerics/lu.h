/* LU factorization with row exchange of a small dense matrix.
 * (G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., algorithm 3.4.1.) */
#ifndef DUALCAM_LU_H
#define DUALCAM_LU_H

#include <stdbool.h>

enum { LU_MAX = 7 }; /* largest size */

typedef struct {
    int n;
    double a[LU_MAX][LU_MAX]; /* [row][column]: the matrix, then its factors */
    int pivot[LU_MAX];
} Lu;

/* Replaces the matrix by its factors. False if the matrix is singular. */
bool lu_factorize(Lu *lu);

/* Replaces the right-hand side x by the solution. */
void lu_solve(const Lu *lu, double x[LU_MAX]);

#endif
