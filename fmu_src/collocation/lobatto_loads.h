/* Lobatto steps where friction depends on the load: mu_i and R_i together, by Newton's method as in
 * contact/loaded_contacts.h, one iteration in each sweep.
 *
 * The friction force is F = f x with f ~ |x|^nu. At the x_i of the sweep before it is the line f' x - rest, f' the
 * tangent coefficient. The forces of the line give the next x_i. The curve leaves the line by F'' (change of x_i)^2/2,
 * which is then part of the rest: the error is of third order in the change. */
#ifndef DUALCAM_LOBATTO_LOADS_H
#define DUALCAM_LOBATTO_LOADS_H

#include "collocation/lobatto_nodes.h"
#include "geometry/cam.h"

/* A first guess of x_i at all nodes: that at the start, at the height z. Turns the coefficients f_i at R_ref into those
 * under the loads. */
void lobatto_loads_guess(LobattoSystem *system, const Geometry *geometry, const GrooveBend *bend, double z,
                         double value[2], double kinetic[2]);

/* x_i at the nodes from those at the start and, in the pair, in the middle and at the end of the step. */
void lobatto_loads_place(LobattoSystem *system, const NodePair *pair);

/* Turns f_i at R_ref into the tangent coefficients f'_i under the loads x_i of the sweep before. */
void lobatto_loads_linearise(LobattoSystem *system, NodePair *pair);

/* x_i under the forces of the lines with alpha, and the part of the damping rate that is due to friction. `shift`: of
 * the lines. Returns alpha with the forces of the curves. */
Vector2 lobatto_loads_find(LobattoSystem *system, Vector2 omega, Vector2 alpha, const LoadShift *shift, NodePair *pair);

/* Relative error of a force by the changes of x_i since the last call. */
double lobatto_loads_error(LobattoSystem *system);

#endif
