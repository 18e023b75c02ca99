"""What an answer of `sof diagnose` says of mechanisms, and whether it is so."""

import collections

QUIET, SHORT = "no_mismatch", "insufficient_data"
BINS = ((0.0, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 1.0))  # of a stated probability
# Of what has a mechanism: right; right and another beside it; only others; an alarm without a mechanism; silence; too little data.
OUTCOMES = ("right", "beside", "wrong", "none", "missed", "short")


def named(mechanism):
    """A mechanism's id, or None where none is meant."""
    return mechanism if isinstance(mechanism, str) and mechanism not in ("", "none", "unknown") else None


def mechanisms_of(answer, catalogue):
    """{mechanism: probability or None} of the answer's own mechanism and those of its effects; the first that is said of a mechanism counts.

    catalogue: gives the mechanism of an effect whose answer has none; may be None.
    """
    said = {}
    own = named(answer.get("mechanism"))
    if own:
        said[own] = number(answer.get("probability"))
    for effect in answer.get("effects") or []:
        mechanism = named(effect.get("mechanism")) or (catalogue.mechanism(effect.get("id")) if catalogue else None)
        if mechanism and said.get(mechanism) is None:
            said[mechanism] = number(effect.get("probability"))
    return said


def number(value):
    """A number, or the one of a mechanism in an object; None for anything else."""
    value = value.get("mechanism") if isinstance(value, dict) else value
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def outcome(verdict, said, truths):
    """One of OUTCOMES.  said: mechanisms named.  truths: mechanisms that are there, at least one."""
    if verdict in (QUIET, SHORT):
        return "missed" if verdict == QUIET else "short"
    if set(said) & set(truths):
        return "beside" if set(said) - set(truths) else "right"
    return "wrong" if said else "none"


def claims(said, truths):
    """(mechanism, probability, whether it is there) of every mechanism that was named with a probability."""
    return [(mechanism, p, mechanism in truths) for mechanism, p in said.items() if p is not None]


def reliability(claimed):
    """(bin, claims that are right, claims) by stated probability."""
    rows = []
    for low, high in BINS:
        inside = [true for _, p, true in claimed if low <= p < high or p == high == 1.0]
        rows.append((f"{low:g} to {high:g}", sum(inside), len(inside)))
    return rows


def counted(outcomes):
    """Counts of all OUTCOMES."""
    counts = collections.Counter(outcomes)
    return {one: counts[one] for one in OUTCOMES}
