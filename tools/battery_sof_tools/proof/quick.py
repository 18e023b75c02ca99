"""Bounds for a tenth of the benchmark: a set this small shows only what is clearly broken."""

# figure of score.py, most or least, bound on the count, as a share of the cases (at least one case is always allowed to fail).
BOUNDS = (("false_alarm", "most", 0.17), ("false_physics", "most", 0.34), ("class_C1", "least", 0.70), ("c3_short_wrong", "most", 0.34),
          ("decoy_physics", "most", 0.34), ("x1_wrong", "most", 0.50))


def broken(report):
    """Sentences about figures beyond their bound; empty when all is well."""
    by_key = {figure.key: figure for figure in report["figures"]}
    said = [f"not judged: {one}" for one in report["failed"]]
    for key, kind, share in BOUNDS:
        one = by_key[key]
        allowed = max(1, int(share * one.n)) if kind == "most" else min(one.n - 1, -int(-share * one.n // 1))
        bad = one.k > allowed if kind == "most" else one.k < allowed
        if bad:
            said.append(f"{one.level}, {one.text}: {one.k} of {one.n}, at {kind} {allowed} expected")
    return said
