"""Names that count as one."""

# Classes that no recording distinguishes (docs/physics.md#effects-that-cannot-be-distinguished): naming one names the other.
ALIKE = [{"current_offset", "parasitic_load"}, {"fast_arc", "sensor_lag"}, {"inductance", "time_skew"}]
LARGEST_CLASS = 3


def alike(a, b):
    return a == b or any(a in group and b in group for group in ALIKE)


def holds(names, truths):
    """Whether one of the names is, or counts as, one of the truths."""
    return any(alike(name, truth) for name in names for truth in truths)


def with_alike(names):
    """The names and all that count as one of them."""
    return set(names).union(*(group for group in ALIKE if group & set(names)))
