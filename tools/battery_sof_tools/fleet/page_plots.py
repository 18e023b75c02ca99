"""Drawings of a fleet's page as SVG: a parameter over age, temperature or batteries."""

import html
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


def axes(x_range, y_range, x_label):
    parts = []
    for value in ticks(*y_range):
        y = np.interp(value, y_range, Y)
        parts.append(f'<path class="grid" d="M{LEFT} {y:.1f}H{WIDTH - 16}"/><text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{value:.6g}</text>')
    for value in ticks(*x_range):
        x = np.interp(value, x_range, X)
        parts.append(f'<text x="{x:.1f}" y="{HEIGHT - BELOW + 16}" text-anchor="middle">{value:.6g}</text>')
    return "".join(parts) + f'<text x="{(LEFT + WIDTH) / 2}" y="{HEIGHT - 4}" text-anchor="middle">{html.escape(x_label)}</text>'


def points(xs, rows, x_range, y_range, colours):
    parts = []
    for x, row in list(zip(xs, rows))[:MAX_POINTS]:
        at, y = np.interp(x, x_range, X), np.interp(row["value"], y_range, Y)
        told = f'{row["battery"]}: {row["value"]:.4g}' + (f' ± {row["std"]:.2g}' if row["std"] else "") + f' {row["unit"] or ""}'
        parts.append(f'<circle cx="{at:.1f}" cy="{y:.1f}" r="2.6" class="{colours[row["vehicle_type"] or ""]}"><title>{html.escape(told)}</title></circle>')
    return "".join(parts)


def drawing(title, xs, rows, x_label, colours, x_range=None):
    x_range, y_range = x_range or range_of(xs), range_of([row["value"] for row in rows])
    legend = "".join(f'<span><i class="dot {colour}"></i>{html.escape(name or "no type")}</span>' for name, colour in colours.items()) if len(colours) > 1 else ""
    return (f'<figure class="chart"><figcaption><span class="what">{html.escape(title)}</span><span class="legend">{legend}</span></figcaption>'
            f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{html.escape(title + " over " + x_label)}">{axes(x_range, y_range, x_label)}'
            f"{points(xs, rows, x_range, y_range, colours)}</svg></figure>")


def parameter(name, rows):
    """One figure for each of age and temperature that is known; batteries side by side, in the order of values, where neither is."""
    title = f'{name} [{rows[0]["unit"] or "1"}]'
    types = sorted({row["vehicle_type"] or "" for row in rows})
    colours = {one: COLOURS[k % len(COLOURS)] for k, one in enumerate(types)}
    aged = [row for row in rows if row["age_years"] is not None]
    warm = [row for row in rows if None not in (row["temperature_min_c"], row["temperature_max_c"])]
    made = ""
    if len(aged) > 1:
        made += drawing(title, [row["age_years"] for row in aged], aged, "age of the battery [years]", colours)
    if len(warm) > 1:
        made += drawing(title, [0.5 * (row["temperature_min_c"] + row["temperature_max_c"]) for row in warm], warm, "temperature [°C]", colours)
    if made:
        return made
    ordered = sorted(rows, key=lambda row: row["value"])
    share = [100.0 * (k + 0.5) / len(ordered) for k in range(len(ordered))]
    return drawing(title, share, ordered, "recordings with less [%]", colours, (0.0, 100.0))
