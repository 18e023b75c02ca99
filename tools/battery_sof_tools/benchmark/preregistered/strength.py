"""How strong the addition of a case is made: searched on noise-free drawings, with the measure of difficulty.py."""

import random

import numpy as np

from ...rates import rms
from ...sof import Failure
from ..generator import seed_of
from . import difficulty
from .levels import SHORT_S, WITH_COMPANION, Z_WANTED

LARGEST_SCALE, SMALLEST_SCALE = 1.0, 1e-3  # what the generator draws reaches to the ends of the catalogue's ranges
LARGEST_SECOND = 3.0
NEAR_Z = 0.1           # relative distance to the wanted z that is near enough
HIDDEN_Z, BIASED = 5.0, 0.1     # absorbed: z below, bias above
# Concealed: the residual is raised by no more, a parameter is biased by BIASED and by as many of its standard errors.
RAISED, BIASED_IN_ERRORS = 1.1, 3.0
MASKED_RATIO = 0.4
MIN_MASKED_Z = 8.0   # of both together: a mask that leaves less is a null
SEEDS_TRIED = 5        # drives drawn for an absorbed or a masked case until one does
# Faults of the sampling itself: a noise-free drawing has no z in the sense of the others.
WITHOUT_Z = ("quantisation", "clipping", "dropouts", "aliasing")


def rounded(value, digits=3):
    return float(f"{value:.{digits}g}")


def drawn(generator, case, *scale):
    """Label and recording of a noise-free drawing of a case at a scale."""
    with generator.drawn(dict(case, scale=list(scale)), quiet=True) as (label, recording):
        return label, difficulty.measured(recording)


def drawn_and_fitted(generator, case, *scale, to_s=None):
    """The same, and the base circuit fitted to it."""
    label, recording = drawn(generator, case, *scale)
    return label, recording, difficulty.fitted(label, cut(recording, to_s))


def cut(recording, to_s):
    interval, current, voltage = recording
    count = len(current) if to_s is None else int(round(to_s / interval))
    return interval, current[:count], voltage[:count]


def drives(case):
    """The case with one drive after the other."""
    return [dict(case, seed=seed_of(case["seed"], "drive", k)) for k in range(SEEDS_TRIED)]


def with_strength(generator, case):
    """The case with its scale, and what is known of its difficulty."""
    search = {"z": for_z, "absorbed": for_absorbed, "concealed": for_concealed, "masked": for_masked, "as drawn": as_drawn}[case["rule"]]
    return search(generator, case)


def as_drawn(generator, case):
    if case["family"] in ("null", "porous_null", "porous_effect") or case["id"] in WITHOUT_Z:
        return case
    label, recording, fit = drawn_and_fitted(generator, case, 1.0)
    known = {"z_whole": rounded(fit.z)}
    if case["family"] == "structural_effect":
        known["z"] = rounded(difficulty.difference(label, recording, fit, drawn_and_fitted(generator, case, 0.0)[2]))
    elif "regime_from_s" in label:
        known["z_short"] = rounded(difficulty.fitted(label, cut(recording, label["regime_from_s"])).z)
    return dict(case, **known)


def for_z(generator, case):
    """Of some drives the first on which the wanted z is reached; where none does, the one that comes nearest."""
    low, high = Z_WANTED[case["level"]]
    wanted = random.Random(seed_of(case["seed"], "z")).uniform(low, high)
    best = None
    tried = [case, *drives(case)[1:]]
    for one in tried:
        try:
            found = with_z(generator, one, low, high, wanted)
        except Failure:
            if best is None and one is tried[-1]:
                raise
            continue
        if best is None or distance(found["z"], wanted) < distance(best["z"], wanted):
            best = found
        if low <= best["z"] <= high:
            break
    return best


def distance(z, wanted):
    return abs(np.log(max(z, 1e-9) / wanted))


def with_z(generator, case, low, high, wanted):
    without = drawn_and_fitted(generator, case, 0.0)[2] if case["id"] in WITH_COMPANION else None

    def reached(scale):
        label, recording, fit = drawn_and_fitted(generator, case, scale)
        return (difficulty.difference(label, recording, fit, without) if without else fit.z), fit.z

    tried, most, scale = [], LARGEST_SCALE, 1.0
    for _ in range(5):
        try:
            z, whole = reached(scale)
        except Failure:
            most = 0.7 * scale
            scale = most
            continue
        tried.append((scale, z, whole))
        if abs(z / wanted - 1.0) < NEAR_Z and low <= z <= high:
            break
        scale = rounded(min(max(next_scale(tried, wanted), SMALLEST_SCALE), most))
        if any(scale == one[0] for one in tried):
            break
    if not tried:
        raise Failure("no strength of this case could be drawn")
    scale, z, whole = min(tried, key=lambda one: distance(one[1], wanted))
    return dict(case, scale=[scale], z=rounded(z), z_whole=rounded(whole), z_wanted=rounded(wanted))


def next_scale(tried, wanted):
    """Secant on logarithms; z goes about in proportion to the scale."""
    scale, z, _ = tried[-1]
    slope = 1.0
    if len(tried) > 1 and tried[-2][0] != scale and min(z, tried[-2][1]) > 0.0:
        slope = np.log(z / tried[-2][1]) / np.log(scale / tried[-2][0])
    return scale * (wanted / max(z, 1e-3)) ** (1.0 / min(max(slope, 0.3), 3.0))


def most_biased(generator, case, left, most, enough=lambda seen: False):
    """Of some drives, at full strength, the one with the most bias for what the fit leaves of the effect, left(seen); most: as much may be left."""
    best = None
    for one in drives(case):
        try:
            seen = absorbed_at(generator, one, 1.0)
        except Failure:
            continue
        gain = abs(seen["bias"]) / left(seen)
        if best is None or gain > best[0]:
            best = gain, seen
        if enough(seen) or gain * most > 1.5 * BIASED:
            break
    if best is None:
        raise Failure("no drive of this case could be drawn")
    return best[1]


def for_absorbed(generator, case):
    """Hidden in the first minutes: the base circuit takes the effect up in biased parameters and leaves z < 5.

    Bias and z both go about in proportion to the scale: of some drives the one with the most bias for its z is taken.
    """
    seen = most_biased(generator, case, lambda one: max(one["z_short"], 1e-3), HIDDEN_Z)
    for _ in range(3):
        scale = rounded(min(max(0.9 * HIDDEN_Z / max(seen["z_short"], 1e-3) * seen["scale"][0], 0.01), LARGEST_SCALE))
        if scale == seen["scale"][0]:
            break
        seen = absorbed_at(generator, seen, scale)
        if 0.7 * HIDDEN_Z < seen["z_short"] < HIDDEN_Z:
            break
    return dict(seen, as_wanted=bool(seen["z_short"] < HIDDEN_Z and abs(seen["bias"]) >= BIASED))


def absorbed_at(generator, case, scale):
    """The case at a scale. Beside a companion z is that of the difference to a drawing without the effect, bias that between the two fits."""
    label, recording = drawn(generator, case, scale)
    first = cut(recording, SHORT_S)
    short = difficulty.fitted(label, first)
    z, start, left = short.z, None, short.residual[short.kept]
    if case["id"] in WITH_COMPANION:
        without = drawn_and_fitted(generator, case, 0.0, to_s=SHORT_S)[2]
        z, start = difficulty.difference(label, first, short, without), without.parameters
        left = (short.residual - without.residual)[short.kept & without.kept]
    bias, parameter = difficulty.largest_bias(label, short, start)
    seen = dict(case, scale=[scale], z_short=rounded(z), z_whole=rounded(difficulty.fitted(label, recording).z), bias=rounded(bias),
                biased=parameter, absorbed=rounded(1.0 - short.z / max(short.z_start, short.z, 1e-9)))
    if case["rule"] == "concealed":
        seen.update(raised=rounded(difficulty.raised(label, left), 4), bias_in_errors=rounded(difficulty.bias_in_errors(label, short, parameter, start)))
    return seen


def for_concealed(generator, case):
    """Concealed in the first minutes: the base circuit takes the effect up in biased parameters, and its residual hardly shows it.

    Bias and residual go about in proportion to the scale: of some drives the one with the most bias for what is left is taken.
    """
    seen = most_biased(generator, case, lambda one: max(left_of(one["raised"]), 1e-6), left_of(RAISED), is_concealed)
    for _ in range(3):
        scale = rounded(min(max(0.95 * left_of(RAISED) / max(left_of(seen["raised"]), 1e-6) * seen["scale"][0], 0.01), LARGEST_SCALE))
        if is_concealed(seen) or scale == seen["scale"][0]:
            break
        seen = absorbed_at(generator, seen, scale)
    return dict(seen, as_wanted=is_concealed(seen))


def left_of(raised):
    """RMS of what the fit leaves of the effect, in that of the noise."""
    return float(np.sqrt(max(raised ** 2 - 1.0, 0.0)))


def is_concealed(seen):
    return bool(seen["raised"] <= RAISED and abs(seen["bias"]) >= BIASED and seen["bias_in_errors"] >= BIASED_IN_ERRORS)


def for_masked(generator, case):
    """The second addition as strong as hides the first best: least RMS of what the true base circuit leaves unfitted.

    What the two leave nearly adds up: the drive is chosen, and the strengths begun, by that of each alone.
    """
    best = None
    for one in drives(case):
        alone, other = (raw(generator, one, scales) for scales in ((1.0, 0.0), (0.0, 1.0)))
        count = min(len(alone), len(other))
        alone, other = alone[:count], other[:count]
        second = max(-(alone @ other) / max(other @ other, 1e-30), 0.05)
        ratio = rms(alone + second * other) / max(rms(alone), second * rms(other))
        if best is None or ratio < best[0]:
            best = ratio, one, second
        if ratio < 0.8 * MASKED_RATIO:
            break
    _, one, second = best
    first = rounded(min(1.0, LARGEST_SECOND / second))  # what would need too strong a second masks a weaker first
    found = masked(generator, one, first, rounded(first * second))
    while found["z_whole"] < MIN_MASKED_Z and first < LARGEST_SCALE:
        first = rounded(min(2.0 * first, LARGEST_SCALE))
        found = masked(generator, one, first, rounded(min(first * second, LARGEST_SECOND)))
    return found


def masked(generator, case, first, second):
    tried = {0.0: rms(raw(generator, case, (first, 0.0)))}
    alone = tried[0.0]
    for _ in range(3):
        tried[second] = rms(raw(generator, case, (first, second)))
        second = rounded(min(max(bottom(tried, second), 0.05), LARGEST_SECOND))
        if any(abs(second - scale) < 0.05 * scale for scale in tried):
            break
    second = min((scale for scale in tried if scale), key=lambda scale: tried[scale])
    ratio = tried[second] / max(alone, rms(raw(generator, case, (0.0, second))))
    whole = drawn_and_fitted(generator, case, first, second)[2].z
    return dict(case, scale=[first, second], ratio=rounded(ratio), z_whole=rounded(whole), as_wanted=bool(ratio < MASKED_RATIO))


def raw(generator, case, scales):
    return difficulty.raw_error(*drawn(generator, case, *scales))


def bottom(tried, last):
    """Where the parabola through the squares of the three best RMS is least; with two known, half as far again."""
    if len(tried) < 3:
        return 1.4 * last if tried[last] < tried[0.0] else 0.5 * last
    scales = sorted(tried, key=lambda scale: tried[scale])[:3]
    a, b, _ = np.polyfit(scales, [tried[scale] ** 2 for scale in scales], 2)
    return -b / (2.0 * a) if a > 0.0 else last
