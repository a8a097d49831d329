"""Independent reference simulator of the dual cylindrical cam, the oracle of the accuracy tests.

It shares nothing with the C core but the equations. Two ways to integrate are built on one event
logic, which is generic in the number type:

`simulate`        DOP853 at rtol 1e-13 in double precision; the accounts are extra states; events are
                  bracketed on the dense output and polished by integrating again from the last
                  accepted step. Any grooves, springs and dampers, inputs cubic in time; steps end
                  where a table's third derivative jumps.
`simulate_exact`  closed form at 60 digits: while one set of flanks slides, a scene with helical grooves,
                  linear spring and linear dampers is a linear ODE with polynomial forcing, so the
                  motion is a sum of t^p exp(lambda t), its zeros are isolated by Rolle's theorem and
                  the accounts are integrals of products of such terms. Never stiff, no tolerance.

Contact unknowns are x_i = R_i/hypot(r_i, a_i), signed, with a_i = r_i tan(lambda_i). For sliding in
direction sigma on flanks e_i = sign(x_i), and with n_i = a_i + sigma e_i mu_i r_i,
d_i = r_i - sigma e_i mu_i a_i:

    d_1 x_1 + d_2 x_2 = A := F + m z_ddot             axial balance of the follower
    r_1 n_1 x_1 - r_2 n_2 x_2 = -G := -I gamma_ddot   its moment balance about the axis
    r_2 n_2 x_2 = tau - b omega - J alpha             moment balance of cam 2

Grooves g_i(psi) have a_i = g_i' and curvature b_i = g_i''. With gamma the root of g_1(gamma) = g_2(phi),
phi = theta - gamma, and a prime for d/dtheta:

    gamma' = a_2/(a_1 + a_2)     gamma'' = (b_2 phi'^2 - b_1 gamma'^2)/(a_1 + a_2)
    z' = a_1 gamma'              z'' = (a_2 b_1 gamma'^2 + a_1 b_2 phi'^2)/(a_1 + a_2)
    a_1' = b_1 gamma'            a_2' = b_2 phi'

The modules, bottom up (each imports from those above it):

    parameters              parameters, names of modes and accounts
    arithmetic              number types, polynomials
    scene                   inputs of an interval, results at its end
    table, grooves          groove laws
    kinematics              gamma, z and their derivatives by theta
    friction                friction that depends on the sliding speed
    mechanism               balance of forces, contact loads, acceleration
    segment                 sliding on one pair of flanks up to the first event
    closed_form             a segment at 60 digits
    integration, numerical  a segment by DOP853
    state                   angle, speed, inputs, mode, accounts
    stick, flank_choice     decisions: stick or slip, flanks
    band_edge, creep, play  motion without inertia and damping
    simulation              a scene: segments and decisions in turn
    random_scenes, random_general_scenes, random_friction_scenes
"""

from .arithmetic import DOUBLE, MP, SIXTY_DIGITS
from .grooves import CYCLOID, ELLIPSE, HELIX, TABLE, Cycloid, Ellipse, Groove, Helix, groove_of
from .kinematics import Grooves, Helices, Kinematics
from .mechanism import Mechanism, Slip
from .parameters import (
    DEFAULTS,
    ENERGIES,
    HEATS,
    INTEGERS,
    LOADING,
    LOWER_STOP,
    PEAKS,
    RELEASING,
    STICK,
    UPPER_STOP,
    WEDGED,
    Params,
    Refused,
)
from .random_friction_scenes import random_friction_scene
from .random_general_scenes import draw_table, plain, random_general_scene
from .random_scenes import random_scene
from .scene import Interval, Point
from .simulation import simulate, simulate_exact
from .table import Table, read_table, write_table
