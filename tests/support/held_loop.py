"""A reference for position loops: the default helices under a torque that is held over each period, in closed
form, without the FMU.

In slip with direction sigma theta is a harmonic oscillation about c = (tau/rho_sigma - F0)/(k z'), with
w^2 = rho_sigma k z'/J. It ends where the speed is zero, or at a stop, where the cam stays (restitution 0).
Coulomb friction, no damping, no mass of the follower."""

import math
from itertools import pairwise

import numpy as np
from mechanisms import INERTIA, LIFT, PRELOAD, RHO, STIFFNESS

UPPER = 1.3963  # rad, of the stops: 0 and this
LEAST = 1e-13  # rad of phase
ROUNDING = 1e-15  # rad, of an oscillation that is none


def edge(sigma, theta):
    """Of the stick band [N.m]."""
    return RHO[sigma] * (PRELOAD + STIFFNESS * LIFT * theta)


def advance(theta, omega, tau, h):
    """Angle and speed after a time h [s] under a torque [N.m]."""
    while h > 0.0:
        sigma = math.copysign(1, omega) if omega else 0
        if not omega:
            if tau > edge(+1, theta) and theta < UPPER:
                sigma = 1
            elif tau < edge(-1, theta) and theta > 0.0:
                sigma = -1
            else:
                return theta, 0.0
        rise = RHO[sigma] * STIFFNESS * LIFT
        w, middle = math.sqrt(rise / INERTIA), (tau - RHO[sigma] * PRELOAD) / rise
        a, b = theta - middle, omega / w
        radius, turn = math.hypot(a, b), math.atan2(b, a) % math.pi
        turn = turn if turn > LEAST else math.pi  # phase at which the speed is zero
        if radius < ROUNDING:
            return theta, 0.0
        stop = UPPER if sigma > 0 else 0.0
        share, hit = (stop - middle) / radius, math.inf
        if abs(share) <= 1.0:
            # phases of x = radius cos(p - delta); before the turn the cosine has one sign of its slope
            hit = turn - math.acos(share) if sigma > 0 else turn - (math.pi - math.acos(share))
            hit = hit if hit >= 0.0 else math.inf
        end = min(turn, hit)
        if end > w * h:
            p = w * h
            return (
                middle + a * math.cos(p) + b * math.sin(p),
                w * (b * math.cos(p) - a * math.sin(p)),
            )
        theta = stop if hit <= turn else middle + a * math.cos(turn) + b * math.sin(turn)
        omega, h = 0.0, h - end / w
    return theta, omega


def pi_loop(proportional, integral, period, reference, start, count):
    """Angles at the samples of a PI loop, shape (count,). `start`: theta, omega, and the integral [N.m]."""
    theta, omega, held = start
    found = np.empty(count)
    for k in range(count):
        error = reference - theta
        found[k] = theta
        tau = held + proportional * error
        held += integral * period * error
        theta, omega = advance(theta, omega, tau, period)
    return found


def swing(angles, period):
    """Half the range [rad] and angular frequency [rad/s] of an oscillation about its middle."""
    middle = 0.5 * (angles.min() + angles.max())
    ups = np.flatnonzero((angles[1:] >= middle) & (angles[:-1] < middle))
    cycles = [np.ptp(angles[a : b + 1]) for a, b in pairwise(ups)]
    return 0.5 * float(np.mean(cycles)), 2.0 * math.pi * (len(ups) - 1) / (period * (ups[-1] - ups[0]))
