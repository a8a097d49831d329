"""The fit of a design's parameters to a recording."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array
from dualcam.design_file import DesignSource, as_design
from dualcam.errors import FmuError, IdentificationError
from dualcam.identification.ambiguity import Ambiguity, ambiguities_of, exchangeable_cams
from dualcam.identification.identification import Identification
from dualcam.identification.lack_of_fit import lack_of_fit
from dualcam.identification.least_squares import Problem, Solution
from dualcam.identification.motion import AUTO, MeasuredMotion, motion_of
from dualcam.identification.recording import Recording, read_recording
from dualcam.identification.result import AT_LIMIT, KNOWN, OPEN, FittedParameter
from dualcam.identification.smoothing import NARROWEST, noise_between, noise_of
from dualcam.identification.torque_model import TorqueModel
from dualcam.identification.unknowns import DEFAULT, Unknown, unknowns_of

MOST_SAMPLES = 20_000  # of the fit; of longer recordings every k-th sample counts
LEAST_NOISE = 1e-6  # of the largest torque: least standard deviation of a recording without noise
NEAR = 1e-3  # of a size: distance from a limit that counts as none
STRIBECK = (0.05, 0.3)  # first guesses of a Stribeck velocity, as shares of the largest sliding speed


def identify(
    recording: Recording | str | Path,
    design: DesignSource,
    fit: Sequence[str] = DEFAULT,
    *,
    motion: str = AUTO,
    window: float | None = None,
    progress: Callable[[str], None] | None = None,
) -> Identification:
    """Fit friction, spring and losses of a design to a recording of time, angle and torque.

    The recorded motion goes into the inverse FMU, and the parameters are those whose torque is nearest to the
    recorded one, by least squares. Where the cam rests, friction can carry any torque of the stick band:
    there only a torque outside the band counts.

    Parameters
    ----------
    recording : Samples, or the path of a CSV file with a header such as `time_s,theta_deg,tau_Nm`.
    design : Grooves and all values that are not fitted; start values of the others.
    fit
        What is fitted: real parameters of the FMU such as `spring.preload` or `cam1.friction`; `friction`,
        `friction_peak` and the like for one value of both cams; `torque_offset` and `angle_offset` for the
        zero errors of the sensors.
    motion : {"auto", "quasi-static", "dynamic"}
        Whether the acceleration counts. auto: it does where it stands out of its noise.
    window
        Length of the window in which the angle is smoothed [s]. Default: that of the least error of
        prediction.
    progress : Called with the stage of the work, often.

    Returns
    -------
    Values with 95 % intervals, what the data cannot tell apart, residuals, picture, report.

    Raises
    ------
    IdentificationError : The recording or the names are refused.
    DesignFileError : The design file is refused.
    FmuError : The FMU refuses the design.

    Examples
    --------
    A recording that a simulation makes, of a friction that the design does not know:

    >>> import tempfile
    >>> from dualcam import identify, simulate
    >>> from dualcam.design_file import read_design, write_template
    >>> from dualcam.identification import Recording
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = write_template("minimal", Path(folder) / "my.toml")
    ...     bench = Path(folder) / "bench.toml"
    ...     _ = bench.write_text(path.read_text().replace("friction = 0.14", "friction = 0.17"))
    ...     run = simulate(bench)
    ...     recording = Recording.from_arrays(run["time"], run["theta"], run["tau"])
    ...     found = identify(recording, path, ["friction"])
    >>> round(found["friction"].value, 3)
    0.17
    """
    if not isinstance(recording, Recording):
        recording = read_recording(recording)
    design = as_design(design)
    unknowns = unknowns_of(design, fit)
    tell = progress or (lambda stage: None)
    tell(f"{len(recording)} samples read, angle being smoothed")
    full = motion_of(recording, motion, window)
    _require_motion(full, len(unknowns))
    moved = _thinned(full)
    rows = slice(None, None, max(1, -(-len(recording) // MOST_SAMPLES)))
    force = np.zeros(len(recording)) if recording.F_ext is None else recording.F_ext
    noise = _torque_noise(recording, full)
    with _explained(recording, moved), TorqueModel(design, moved, force[rows], unknowns) as model:
        problem = Problem(model, recording.tau[rows], noise, unknowns, tell)
        solution = problem.solve(_guesses(problem, model))
        low, high = model.limits(solution.values)
        before = np.clip(recording.tau[rows], *model.limits(problem.start))
        speeds = model.sliding_speeds(solution.values)
        span = model.upper - model.lower
        swapped = exchangeable_cams(model, solution, unknowns)
    slips = moved.direction != 0
    ambiguities = ambiguities_of(solution, unknowns, moved, span, speeds[slips].ravel())
    ambiguities += [one for one in swapped if not any(set(one.names) <= set(a.names) for a in ambiguities)]
    tell("search for values that are missing in the fit")
    missing, levers = lack_of_fit(design, moved, force[rows], unknowns, solution)
    return Identification(
        design=design,
        recording=recording,
        motion=moved,
        time=recording.time[rows],
        measured=recording.tau[rows],
        low=low,
        high=high,
        before=before,
        residual=solution.residual,
        sliding_speed=speeds.max(axis=1),
        noise=noise,
        parameters=tuple(_fitted(unknowns, solution, ambiguities, slips)),
        correlation=solution.correlation,
        ambiguities=tuple(ambiguities),
        missing=tuple(missing),
        levers=tuple(levers),
    )


@contextmanager
def _explained(recording: Recording, motion: MeasuredMotion) -> Iterator[None]:
    """A question after the unit of time in errors of the FMU, where the recorded speeds are strange."""
    try:
        yield
    except FmuError as error:
        if question := motion.time_question(float(np.ptp(recording.time))):
            raise IdentificationError(f"{recording.source}: {question}. The FMU says: {error}") from error
        raise


def _require_motion(motion: MeasuredMotion, count: int) -> None:
    moving = motion.count(1) + motion.count(-1)
    if moving <= count:
        raise IdentificationError(
            f"the cam slips in {moving} of {len(motion.theta)} samples: allowed are more than the {count}"
            " values that are fitted. At rest friction can carry any torque of the stick band: record motion."
            " Where too few samples show the direction, add a column of the angular velocity, omega_rad/s"
        )


def _torque_noise(recording: Recording, motion: MeasuredMotion) -> float:
    """Standard deviation of the torque's noise [N.m], where no reversal makes the torque jump."""
    width = 2 * NARROWEST + 1
    moving = np.convolve(motion.direction, np.ones(width), "same")
    rows = np.flatnonzero(np.abs(moving) == width)
    if len(rows) > width:
        noise = noise_of(recording.time, recording.tau, rows)
    else:
        noise = noise_between(recording.tau)
    steps = np.diff(np.unique(recording.tau))
    if len(steps) < len(recording) / 2:  # a coarse sensor: the error is even within a step
        noise = max(noise, float(np.median(steps)) / math.sqrt(12.0))
    return max(noise, LEAST_NOISE * float(np.abs(recording.tau).max()))


def _thinned(motion: MeasuredMotion) -> MeasuredMotion:
    step = max(1, -(-len(motion.theta) // MOST_SAMPLES))
    arrays = {name: getattr(motion, name)[::step] for name in ("theta", "omega", "alpha", "direction")}
    return replace(motion, **arrays)


def _guesses(problem: Problem, model: TorqueModel) -> list[Array]:
    """The start and, as the error has several minima over the Stribeck velocity, some other velocities."""
    found = [problem.start]
    places = [k for k, one in enumerate(problem.unknowns) if one.name.endswith("stribeck_velocity")]
    if places:
        fastest = float(np.max(model.sliding_speeds(problem.start)))
        for share in STRIBECK:
            guess = problem.start.copy()
            guess[places] = share * fastest
            found.append(guess)
    return found


def _fitted(
    unknowns: Sequence[Unknown],
    solution: Solution,
    ambiguities: Sequence[Ambiguity],
    slips: NDArray[np.bool_],
) -> list[FittedParameter]:
    open_names = {name for ambiguity in ambiguities for name in ambiguity.names}
    found = []
    for k, unknown in enumerate(unknowns):
        value, size = float(solution.values[k]), float(solution.sizes[k])
        half = solution.half_width(np.eye(len(unknowns))[k])
        status, limit = KNOWN, None
        if min(value - unknown.least, unknown.greatest - value) < NEAR * size:
            limit = min((unknown.least, unknown.greatest), key=lambda end: abs(value - end))
            if abs(solution.pull(k)) > half:
                status = AT_LIMIT
        if unknown.name in open_names:
            status = OPEN
        found.append(
            FittedParameter(
                unknown.name,
                unknown.keys,
                unknown.unit,
                unknown.start,
                value,
                max(value - half * size, unknown.least),
                min(value + half * size, unknown.greatest),
                status,
                limit,
                abs(value / size) * math.sqrt(float(np.mean(solution.jacobian[slips, k] ** 2))),
            )
        )
    return found
