"""The score as text, as Markdown, and the confusion matrix as a picture."""

import collections
import os

from ...files import write_text
from ...tables import table
from ..scorers import written
from .levels import TITLES
from .score import SIDES, WITH_TRUTH, mechanism_lines


def matrix(report):
    """Rows, columns (by how often they were said; what says no name last) and counts."""
    counts = report["confusion"]
    totals = collections.Counter()
    for (_, column), count in counts.items():
        totals[column] += count
    columns = sorted(totals, key=lambda column: (column.startswith("("), -totals[column], column))
    rows = sorted({row for row, _ in counts}, key=lambda row: (list(TITLES).index(row.split()[0]), row))
    return rows, columns, counts


def as_text(report):
    said = report["seal"]
    lines = [f"{said['cases']} cases sealed from {said['frozen_commit']}, labels SHA-256 {said['labels_sha256']}", ""]
    lines += [f"{one.level:8s} {one.text:68s} {written(one):42s} {one.target}".rstrip() for one in report["figures"]]
    lines += [""] + mechanism_lines(report["mechanisms"])
    lines += ["", "who was taken for whom (truth: first name, or verdict in brackets)"]
    rows, columns, counts = matrix(report)
    for row in rows:
        heard = sorted(((counts[row, column], column) for column in columns if counts[row, column]), reverse=True)
        lines.append(f"  {row:44s} " + ", ".join(f"{column} {count}" for count, column in heard))
    lines += ["", f"what went wrong ({len(report['wrong'])} cases)"] + ["  " + one for one in report["wrong"]]
    if report["failed"]:
        lines += ["", "not judged"] + ["  " + one for one in report["failed"]]
    return "\n".join(lines) + "\n"


def before_after_lines(report):
    """Medians on the part that was held out, level by level."""
    def cell(row, metric, scale, digits):
        values = [row[f"{side}_{metric}"] for side in SIDES]
        return " -> ".join("-" if value is None else f"{scale * value:.{digits}f}" for value in values[:2]) + \
            ("" if values[2] is None else f" ({scale * values[2]:.{digits}f})")

    rows = [(level, name, row["cases"], cell(row, "rmse_v", 1e3, 1), cell(row, "charge_current_error_a", 1.0, 2), cell(row, "crank_mae_v", 1e3, 1))
            for (level, name), row in sorted(report["before_after"].items())]
    return ["### Before and after", "",
            "Medians on the part that was held out: base model -> extended model (the model that was reported the truth).", "",
            *table(["level", "truth", "cases", "RMS error [mV]", "charge current error [A]", "cranks' minima [mV]"], rows)]


def as_markdown(report, pictures=()):
    said = report["seal"]
    lines = [f"{said['cases']} cases, sealed from commit `{said['frozen_commit']}`; SHA-256 of the labels `{said['labels_sha256']}`.", "",
             *table(["level", "figure", "measured (95 % interval)", "aim"], [(one.level, one.text, written(one), one.target) for one in report["figures"]])]
    lines += [""] + mechanism_lines(report["mechanisms"])
    for picture, title in pictures:
        lines += ["", f"![{title}]({picture})"]
    lines += [""] + before_after_lines(report)
    lines += ["", "### What went wrong", "", "Case, truth, what was said (evidence; rejected candidates in brackets), how hard it was.", ""]
    lines += ["- " + one.replace("|", "\\|") for one in report["wrong"] + report["failed"]]
    return "\n".join(lines) + "\n"


def drawing(width, height):
    """A figure of a size [inch] and its axes."""
    from matplotlib.figure import Figure  # half a second
    figure = Figure(figsize=(width, height))
    return figure, figure.subplots()


def draw_matrix(report, path):
    """Rows are what is true, columns the first name; a cell's shade is its share of the row."""
    rows, columns, counts = matrix(report)
    figure, axes = drawing(3.6 + 0.34 * len(columns), 1.9 + 0.23 * len(rows))
    sums = {row: sum(counts[row, column] for column in columns) for row in rows}
    axes.imshow([[counts[row, column] / sums[row] for column in columns] for row in rows], cmap="Blues", vmin=0.0, vmax=1.3, aspect="auto")
    for y, row in enumerate(rows):
        for x, column in enumerate(columns):
            if counts[row, column]:
                right = column in row.split()[1].split("+")
                axes.text(x, y, counts[row, column], ha="center", va="center", fontsize=8, weight="bold" if right else "normal")
    axes.set_xticks(range(len(columns)))
    axes.set_xticklabels(columns, rotation=60, ha="left", rotation_mode="anchor", fontsize=8)
    axes.set_yticks(range(len(rows)))
    axes.set_yticklabels([f"{row}  ({sums[row]})" for row in rows], fontsize=8)
    axes.xaxis.tick_top()
    for y in range(1, len(rows)):
        if rows[y].split()[0] != rows[y - 1].split()[0]:
            axes.axhline(y - 0.5, color="0.4", linewidth=0.8)
    for x in range(1, len(columns)):
        if columns[x].startswith("(") and not columns[x - 1].startswith("("):
            axes.axvline(x - 0.5, color="0.4", linewidth=0.8)
    axes.tick_params(length=0)
    axes.set_xlabel("Rows: level, what is true, (cases). Columns: first name, or verdict without a name. Bold: the id itself.", fontsize=7.5)
    figure.savefig(path, dpi=130, bbox_inches="tight")


def draw_before_after(report, path):
    """Held-out RMS error of every case with something to find: base model against extended model."""
    figure, axes = drawing(5.4, 5.0)
    points = collections.defaultdict(list)
    for case in report["cases"]:
        if case.level in WITH_TRUTH and case.answer["holdout"]:
            points[case.level].append([1e3 * case.held(side) for side in SIDES[:2]])
    for level, marker in zip(WITH_TRUTH, "osD^vP"):
        if points[level]:
            axes.scatter(*zip(*points[level]), s=22, marker=marker, alpha=0.75, label=f"{level} {TITLES[level]} ({len(points[level])})")
    both = [value for mine in points.values() for point in mine for value in point]
    ends = [0.8 * min(both, default=1.0), 1.25 * max(both, default=10.0)]
    axes.plot(ends, ends, color="0.4", linewidth=0.8)
    axes.set(xscale="log", yscale="log", xlim=ends, ylim=ends, xlabel="base model: RMS error held out [mV]",
             ylabel="extended model: RMS error held out [mV]")
    axes.legend(fontsize=7.5, loc="upper left")
    figure.savefig(path, dpi=130, bbox_inches="tight")


DRAWN = (("proof_confusion.png", "Truth against first name", draw_matrix), ("proof_before_after.png", "Held-out error before and after", draw_before_after))


def write(report, markdown, pictures):
    paths = []
    if pictures:
        os.makedirs(pictures, exist_ok=True)
        for name, title, draw in DRAWN:
            paths.append((os.path.join(pictures, name), title))
            draw(report, paths[-1][0])
    if markdown:
        folder = os.path.dirname(os.path.abspath(markdown))
        os.makedirs(folder, exist_ok=True)
        write_text(markdown, as_markdown(report, [(os.path.relpath(path, folder), title) for path, title in paths]))
