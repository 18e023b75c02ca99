"""Ids of the catalogue by tier, which of them count as one, and rates with their intervals."""

STRUCTURE = {"cpe2", "fast_arc", "current_dependent_resistance", "charge_transfer", "second_electrode", "inductance"}
PHYSICS = {"gassing", "charge_acceptance", "sulphate_history", "acid_transport", "ocv_soc", "ocv_hysteresis",
           "high_rate_depletion", "coup_de_fouet", "self_heating", "parameter_drift", "parasitic_load", "fresh_sulphate"}
INSTRUMENT = {"current_offset", "current_gain", "time_skew", "sensor_lag", "quantisation", "contact_resistance", "clipping",
              "dropouts", "voltage_drift", "aliasing"}
# Classes that no recording tells apart (docs/physics.md#effects-that-cannot-be-told-apart): naming one names the other.
ALIKE = [{"current_offset", "parasitic_load"}, {"fast_arc", "sensor_lag"}, {"inductance", "time_skew"}]
LARGEST_CLASS = 3


def alike(a, b):
    return a == b or any(a in group and b in group for group in ALIKE)


def holds(names, truths):
    """Whether one of the names is, or counts as, one of the truths."""
    return any(alike(name, truth) for name in names for truth in truths)


def interval(k, n):
    """95 % interval of a rate of k in n (Clopper and Pearson 1934)."""
    from scipy.stats import beta
    low = beta.ppf(0.025, k, n - k + 1) if k else 0.0
    high = beta.ppf(0.975, k + 1, n - k) if k < n else 1.0
    return low, high


def rate(k, n):
    if not n:
        return "no case"
    low, high = interval(k, n)
    return f"{k} of {n} = {100 * k / n:.1f} % ({100 * low:.1f} to {100 * high:.1f} %)"
