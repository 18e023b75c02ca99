"""The score as text, as Markdown, and the confusion matrix as a picture."""

import collections
import os

from .levels import TITLES
from .score import written


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
    lines += ["", "who was taken for whom (truth: first name, or verdict in brackets)"]
    rows, columns, counts = matrix(report)
    for row in rows:
        heard = sorted(((counts[row, column], column) for column in columns if counts[row, column]), reverse=True)
        lines.append(f"  {row:44s} " + ", ".join(f"{column} {count}" for count, column in heard))
    lines += ["", f"what went wrong ({len(report['wrong'])} cases)"] + ["  " + one for one in report["wrong"]]
    if report["failed"]:
        lines += ["", "not judged"] + ["  " + one for one in report["failed"]]
    return "\n".join(lines) + "\n"


def as_markdown(report, picture=None):
    said = report["seal"]
    lines = [f"{said['cases']} cases, sealed from commit `{said['frozen_commit']}`; SHA-256 of the labels `{said['labels_sha256']}`.", "",
             "| level | figure | measured (95 % interval) | aim |", "|---|---|---|---|"]
    lines += [f"| {one.level} | {one.text} | {written(one)} | {one.target} |" for one in report["figures"]]
    if picture:
        lines += ["", f"![Truth against first name]({picture})"]
    lines += ["", "### What went wrong", "", "Case, truth, what was said (evidence; rejected candidates in brackets), how hard it was.", ""]
    lines += ["- " + one.replace("|", "\\|") for one in report["wrong"] + report["failed"]]
    return "\n".join(lines) + "\n"


def draw_matrix(report, path):
    """Rows are what is true, columns the first name; a cell's shade is its share of the row."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    rows, columns, counts = matrix(report)
    figure, axes = pyplot.subplots(figsize=(3.6 + 0.34 * len(columns), 1.9 + 0.23 * len(rows)))
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
    pyplot.close(figure)


def write(report, markdown, pictures):
    picture = None
    if pictures:
        os.makedirs(pictures, exist_ok=True)
        picture = os.path.join(pictures, "proof_confusion.png")
        draw_matrix(report, picture)
    if markdown:
        os.makedirs(os.path.dirname(os.path.abspath(markdown)), exist_ok=True)
        link = os.path.relpath(picture, os.path.dirname(os.path.abspath(markdown))) if picture else None
        with open(markdown, "w") as f:
            f.write(as_markdown(report, link))
