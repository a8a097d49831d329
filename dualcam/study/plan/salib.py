"""Problems of SALib, in and out."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from dualcam.common.entries import hint
from dualcam.common.mistakes import StudyError
from dualcam.study.plan.vary import Vary


def _law(distribution: str, low: float = math.nan, high: float = math.nan, **arguments: float) -> Vary:
    return Vary(low, high, distribution=distribution, arguments=arguments)


MADE: dict[str, Callable[..., Vary]] = {  # SALib.util._nonuniform_scale_samples says what the bounds are
    "unif": Vary,
    "logunif": lambda low, high: Vary(low, high, log=True),
    "norm": lambda mean, std: _law("norm", loc=mean, scale=std),
    "truncnorm": lambda low, high, mean, std: _law("norm", low, high, loc=mean, scale=std),
    "triang": lambda low, high, peak: _law("triang", c=peak, loc=low, scale=high - low),
    "lognorm": lambda mean, std: _law("lognorm", s=std, scale=math.exp(mean)),
    "weibull": lambda shape, scale, start=0.0: _law("weibull_min", c=shape, scale=scale, loc=start),
}
SHARE = ("unif", [0.0, 1.0])
LENGTHS = {"triang": (3,), "truncnorm": (4,), "weibull": (2, 3)}


def vary_of(problem: Mapping[str, Any]) -> dict[str, Vary]:
    """What varies in a SALib problem. StudyError for a problem that is none, with all mistakes."""
    for key in ("names", "bounds"):
        if key not in problem:
            raise StudyError(f"SALib problem lacks {key}: it has {', '.join(problem)}")
    names, bounds = list(problem["names"]), list(problem["bounds"])
    dists = list(problem.get("dists") or ["unif"] * len(names))
    if not len(names) == len(bounds) == len(dists):
        found = f"SALib problem with {len(names)} names, {len(bounds)} bounds, {len(dists)} dists"
        raise StudyError(f"{found}: allowed is one of each for each name")
    if len(set(problem.get("groups") or names)) < len(names):
        raise StudyError("SALib problem with groups: allowed are problems without groups")
    return {name: _made(name, kind, ends) for name, kind, ends in zip(names, dists, bounds, strict=True)}


def _made(name: str, kind: str, ends: Sequence[float]) -> Vary:
    if kind not in MADE:
        raise StudyError(f"SALib problem: {name}: dists = {kind!r}{hint(kind, MADE)}")
    if len(ends) not in (lengths := LENGTHS.get(kind, (2,))):
        words = " or ".join(map(str, lengths))
        raise StudyError(f"SALib problem: {name}: bounds = {list(ends)}: {kind} has {words} numbers")
    return MADE[kind](*(float(end) for end in ends))


def problem_of(vary: Mapping[str, Vary]) -> dict[str, Any]:
    """The SALib problem of what varies. A list, and a distribution that SALib does not have, is its share in
    [0, 1], which serves the analysers but not SALib's samplers."""
    dists, bounds = zip(*map(_dist, vary.values()), strict=True)
    return {"num_vars": len(vary), "names": list(vary), "bounds": list(bounds), "dists": list(dists)}


def _dist(vary: Vary) -> tuple[str, list[float]]:
    if vary.is_list:
        return SHARE
    if not vary.distribution:
        return "logunif" if vary.log else "unif", list(vary.limits())
    given = dict(vary.arguments)
    loc, scale = given.get("loc", given.get("mean", 0.0)), given.get("scale", given.get("std", 1.0))
    is_whole = math.isnan(vary.low) and math.isnan(vary.high)
    match vary.distribution:
        case "norm" | "normal" | "gaussian" if is_whole:
            return "norm", [loc, scale]
        case "norm" | "normal" | "gaussian":
            low, high = vary.limits()
            if math.isfinite(low) and math.isfinite(high):
                return "truncnorm", [low, high, loc, scale]
        case "triang" if is_whole:
            return "triang", [loc, loc + scale, given["c"]]
        case "lognorm" | "lognormal" if is_whole and loc == 0.0:
            return "lognorm", [math.log(scale), given["s"]]
        case "weibull_min" if is_whole:
            return "weibull", [given["c"], scale, loc]
        case "uniform" if is_whole:
            return "unif", [loc, loc + scale]
        case "loguniform" | "reciprocal" if is_whole and loc == 0.0 and scale == 1.0:
            return "logunif", [given["a"], given["b"]]
    return SHARE
