"""Figures of a fleet's page, as page.html draws them: a parameter over age, temperature or batteries."""

import math

import numpy as np

WIDTH, HEIGHT, LEFT, BELOW, TOP = 420, 230, 58, 34, 10
X, Y = (LEFT, WIDTH - 16), (HEIGHT - BELOW, TOP)  # of the ends of both ranges
COLOURS = ("extended", "base", "good", "current", "measured")  # of types of vehicle, names of the style
MAX_POINTS = 4000


def ticks(low, high, about=4):
    """Round numbers from low to high."""
    span = (high - low) or abs(high) or 1.0
    step = 10.0**math.floor(math.log10(span / about))
    step = next(step * factor for factor in (1, 2, 5, 10) if span / (step * factor) <= about + 0.5)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, int(math.floor(high / step + 1e-9)) + 1)]


def range_of(values):
    """1 to 99 % of the values with a margin: one wild fit does not flatten the others."""
    low, high = (float(value) for value in np.percentile(values, [1, 99]))
    margin = max(0.06 * (high - low), 1e-9 * max(abs(low), abs(high))) or 1.0
    return low - margin, high + margin


def figure(title, x_label, xs, rows, x_range=None):
    """Places of ticks and points in the drawing, and who has which colour."""
    x_range, y_range = x_range or range_of(xs), range_of([row["value"] for row in rows])
    types = sorted({row["vehicle_type"] or "" for row in rows})
    return {"title": title, "x_label": x_label, "colours": {one: COLOURS[k % len(COLOURS)] for k, one in enumerate(types)},
            "x_ticks": [(value, np.interp(value, x_range, X)) for value in ticks(*x_range)], "y_ticks": [(value, np.interp(value, y_range, Y)) for value in ticks(*y_range)],
            "points": list(zip(np.interp(xs, x_range, X), np.interp([row["value"] for row in rows], y_range, Y), rows))[:MAX_POINTS]}


def parameter(name, rows):
    """One figure for each of age and temperature that is known; batteries side by side, in the order of values, where neither is."""
    title = f'{name} [{rows[0]["unit"] or "1"}]'
    aged = [row for row in rows if row["age_years"] is not None]
    warm = [row for row in rows if None not in (row["temperature_min_c"], row["temperature_max_c"])]
    over = (("age of the battery [years]", aged, [row["age_years"] for row in aged]),
            ("temperature [°C]", warm, [0.5 * (row["temperature_min_c"] + row["temperature_max_c"]) for row in warm]))
    ordered = sorted(rows, key=lambda row: row["value"])
    share = [100.0 * (k + 0.5) / len(ordered) for k in range(len(ordered))]
    return [figure(title, label, xs, some) for label, some, xs in over if len(some) > 1] or [figure(title, "recordings with less [%]", share, ordered, (0.0, 100.0))]
