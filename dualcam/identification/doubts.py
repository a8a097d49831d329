"""What is doubtful about a fit: what the data cannot tell apart, lack of fit, faults of the recording."""

import math

import numpy as np

from dualcam.common.unit_guards import torque_factor_warnings
from dualcam.identification.motion import rms_of
from dualcam.identification.result import OPEN, Fit
from dualcam.identification.smoothing import NORMAL

WELL = 1.2  # RMS of residuals over noise, up to which the model explains the recording
EXACT = 1e-3  # residual over torque, below which nothing is missing
FAR = 6.0  # standard deviations, from which a sample may be a fault
CLOSE = 0.95  # correlation from which two values are named
SMOOTH = 0.1  # noise of alpha over its RMS, from which inertias come out too small
MOST_SHOWN = 3  # values that the residuals ask for, in one warning


def doubts_of(fit: Fit) -> list[str]:
    """What the data cannot tell apart, and other doubts."""
    if gross := recording_faults(fit):
        return gross  # all else follows from the fault
    found = torque_factor_warnings(_factor(fit), fit.recording.torque_unit)
    if not found:  # after another unit the shape of the residuals says little
        found += _asked_for(fit)
    found += [str(ambiguity) for ambiguity in fit.ambiguities]
    found += [text for one in fit.parameters if (text := one.limit_text)]
    found += _levers_of(fit)
    found += _weak_parts(fit)
    found += _close_pairs(fit)
    found += _outliers(fit)
    if fit.rms > max(WELL * fit.noise, EXACT * rms_of(fit.measured)):
        found.append(
            f"The residual is {fit.rms / fit.noise:.2g} times the noise: the model lacks something. The"
            " residuals over angle and speed show what"
        )
    motion = fit.motion
    inertias = [one.name for one in fit.parameters if one.name.startswith("inertia.")]
    if inertias and motion.alpha_noise > SMOOTH * motion.alpha_rms:
        found.append(
            f"The acceleration has noise of {motion.alpha_noise:.2g} rad/s2 at an RMS of"
            f" {motion.alpha_rms:.2g} rad/s2: {' and '.join(inertias)} may come out too small. Give a"
            " longer window, or measure the speed"
        )
    return found


def recording_faults(fit: Fit) -> list[str]:
    """What makes the recording useless as read: another unit of time, or a torque of opposite sign."""
    if question := fit.motion.time_question(float(np.ptp(fit.recording.time))):
        return [question]
    slips = fit.slips
    if np.mean(fit.measured[slips]) * np.mean(fit.before[slips]) >= 0.0:
        return []
    return [
        "The measured torque has the opposite sign of the design's: is the torque positive in the"
        " loading direction? Change the sign of the torque in the recording"
    ]


def _factor(fit: Fit) -> float:
    """RMS of the measured torque over that of the start values, where the cam slips."""
    before = rms_of(fit.before[fit.slips])
    return rms_of(fit.measured[fit.slips]) / before if before else math.nan


def _asked_for(fit: Fit) -> list[str]:
    """A warning where the residuals ask for a value outside of the fit."""
    if not fit.missing:
        return []
    best, *others = fit.missing
    unit = "" if best.unit == "1" else f" {best.unit}"
    held = f", held at {best.held:.4g}{unit}," if best.held else ""
    text = (
        f"Lack of fit: the residuals ask for {best.name}{held} to change by {best.change:+.3g}{unit}"
        f" (95 % interval {best.half_width:.2g}{unit} to both sides). So the intervals above are too narrow."
        f" Try --fit {','.join([*(one.name for one in fit.parameters), best.name])}"
    )
    if others:
        names = " or ".join(one.name for one in others[: MOST_SHOWN - 1])
        text += f". A change of {names} would explain nearly as much"
    return [text]


def _levers_of(fit: Fit) -> list[str]:
    """A warning for each fitted value that small errors of held values change strongly."""
    texts = []
    for one in fit.parameters:
        if one.status == OPEN or one.limit is not None:
            continue
        levers = [lever for lever in fit.levers if lever.name == one.name]
        if levers:
            unit = "" if one.unit == "1" else f" {one.unit}"
            parts = [f"{lever.held_text} by {abs(lever.change):.2g}{unit}" for lever in levers]
            texts.append(
                f"{one.name} depends on values that are held: an error of 10 % changes {one.name} through"
                f" {', through '.join(parts)}. Fit these too, or be sure of their values"
            )
    return texts


def _weak_parts(fit: Fit) -> list[str]:
    """A warning for each fitted value whose part of the torque is below the noise."""
    return [
        f"{one.name} makes {one.part:.2g} N.m RMS of the torque, less than the noise of {fit.noise:.2g}"
        " N.m: other errors of the model can show up as this value"
        for one in fit.parameters
        if one.status == "known" and one.limit is None and one.part < fit.noise
    ]


def _close_pairs(fit: Fit) -> list[str]:
    known = [k for k, one in enumerate(fit.parameters) if one.status != OPEN]
    return [
        f"{fit.parameters[i].name} and {fit.parameters[k].name} have a correlation of"
        f" {fit.correlation[i, k]:.3f}: an error of one is an error of the other"
        for i in known
        for k in known
        if i < k and abs(fit.correlation[i, k]) > CLOSE
    ]


def _outliers(fit: Fit) -> list[str]:
    """A warning where single samples are far from the others."""
    usual = NORMAL * float(np.median(np.abs(fit.residual[fit.slips])))
    far = np.flatnonzero(fit.slips & (np.abs(fit.residual) > FAR * max(usual, fit.noise)))
    if not len(far):
        return []
    count = "1 sample is" if len(far) == 1 else f"{len(far)} samples are"
    return [
        f"{count} off by more than {FAR:g} standard deviations, the first at {fit.time[far[0]]:.6g} s:"
        " leave out samples that are faults"
    ]
