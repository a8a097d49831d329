"""From a wanted torque to a groove: `synthesize`, and the spring that a torque needs: `propose_spring`."""

from collections.abc import Sequence

import numpy as np

from dualcam.common.arrays import real_array
from dualcam.common.unit_guards import units_checked_before, warn_units
from dualcam.design.design import Design
from dualcam.design.groove_equation import groove_problem
from dualcam.design.grooves import Groove
from dualcam.design.mechanism import Spring
from dualcam.design.proposal import VARIED, SpringProposal, propose, with_proposals
from dualcam.design.tabulation import tabulate
from dualcam.design.torque import WantedTorque
from dualcam.errors import DesignError

TOLERANCE = 1e-7  # of the torque of the finished table


def synthesize(
    torque: WantedTorque,
    upper: float,
    spring: Spring,
    *,
    direction: str = "loading",
    groove2: Groove | None = None,
    friction: Sequence[float] = (0.14, 0.14),
    radius: float = 0.02,
    contacts: int = 2,
    kinks: Sequence[float] = (),
    tolerance: float = TOLERANCE,
) -> Design:
    """The groove that makes a given spring give a wanted torque in slow motion.

    The torque is that of spring and friction: no external force, damper, mass or shaft damping. The FMU
    refuses a mechanism that jams when loading; `assess` finds that. The equations are in groove_equation.py.

    Parameters
    ----------
    torque
        Wanted torque. A number: the same torque [N.m] at each angle. A function of an array of theta [rad].
        Samples (theta, torque) [rad, N.m], which a cubic spline joins.
    upper : End of the range of theta [rad], which begins at 0.
    spring : Force of the spring over z.
    direction : {"loading", "releasing", "frictionless"}
        The torque is that of slow loading or that of slow releasing, friction included; or that of the same
        grooves without friction, which lies between the two.
    groove2 : Groove of cam 2, by a law of this package. None: both grooves become equal.
    friction : Friction coefficients of both contacts [1].
    radius : Radius of cam 1 [m].
    contacts : Number of pin ends that share the load, 1 or 2.
    kinks : Angles at which the torque has a kink [rad].
    tolerance : Largest allowed relative error of the torque [1].

    Returns
    -------
    The groove as a table for the FMU. `Design.summary()` says what friction does to it.

    Raises
    ------
    DesignError
        Where no groove gives that torque: the message has the angle, the value, what is allowed, and a
        preload or a stiffness that works, if there is one.

    Warns
    -----
    UnitWarning : If `upper` or an angle of the samples is above 2 pi, which looks like degrees.

    Examples
    --------
    A constant torque from a linear spring:

    >>> design = synthesize(5.0, 1.2, Spring(preload=400.0, stiffness=10e3))
    >>> design.torque([0.0, 0.6, 1.2]).round(4)
    array([5., 5., 5.])
    """
    _check(torque, upper, contacts, tolerance)
    problem = groove_problem(torque, upper, spring, direction, groove2, friction, radius, kinks)
    with units_checked_before():
        try:
            solution = problem.solve()
        except DesignError as error:
            raise with_proposals(error, problem, contacts, tolerance) from None
        return tabulate(problem, solution, contacts, tolerance)


def propose_spring(
    torque: WantedTorque,
    upper: float,
    spring: Spring,
    *,
    vary: str = "preload",
    direction: str = "loading",
    groove2: Groove | None = None,
    friction: Sequence[float] = (0.14, 0.14),
    radius: float = 0.02,
    contacts: int = 2,
    kinks: Sequence[float] = (),
    tolerance: float = TOLERANCE,
) -> SpringProposal:
    """A spring with which `synthesize` gives the wanted torque.

    Of the springs that work, it is the one whose groove has lead angles nearest to 45 deg, where friction
    costs least. `SpringProposal.spring` goes into `synthesize`.

    `torque`, `upper`, `direction`, `groove2`, `friction`, `radius`, `contacts`, `kinks`, `tolerance`: as in
    `synthesize`. `spring`: the spring to change. `vary`: what may be changed, "preload", "stiffness" or
    "both": new ones with which the force doubles over about the range. DesignError: no such spring is found,
    or an argument is not allowed. UnitWarning: as in `synthesize`.

    Examples
    --------
    A constant torque needs a preload:

    >>> proposal = propose_spring(5.0, 1.2, Spring(preload=0.0, stiffness=10e3))
    >>> synthesize(5.0, 1.2, proposal.spring).torque(0.0).round(4)
    np.float64(5.0)
    """
    if vary not in VARIED:
        raise DesignError(f"vary = {vary!r}: allowed are {', '.join(VARIED)}")
    _check(torque, upper, contacts, tolerance)
    problem = groove_problem(torque, upper, spring, direction, groove2, friction, radius, kinks)
    with units_checked_before():
        found = propose(problem, vary, contacts, tolerance)
    if found is None:
        others = " and ".join(repr(other) for other in VARIED if other != vary)
        raise DesignError(
            f"vary = {vary!r}: no spring of that kind gives the torque from theta = 0 to {upper:g} rad; vary"
            f" = {others} are left to try, or another groove2, direction or radius"
        )
    return found


def _check(torque: WantedTorque, upper: float, contacts: int, tolerance: float) -> None:
    if not 0.0 < tolerance < 1.0:
        raise DesignError(f"tolerance = {tolerance}: allowed is a number > 0, below 1")
    if contacts not in (1, 2):
        raise DesignError(f"contacts = {contacts!r}: allowed are 1 and 2")
    guarded: dict[str, tuple[str, object]] = {"upper": ("stop.upper", upper)}
    if isinstance(torque, tuple | list) and len(torque) == 2:
        theta = np.ravel(real_array(torque[0], "torque: theta", DesignError))
        guarded["torque: theta"] = ("table.theta", max(theta.tolist(), key=abs, default=0.0))
    warn_units(guarded, stacklevel=4)
