"""Rows in groups, and Markdown tables."""

import collections


def grouped(rows, key):
    """{key(row): rows} in the keys' order."""
    groups = collections.defaultdict(list)
    for one in rows:
        groups[key(one)].append(one)
    return dict(sorted(groups.items()))


def table(head, rows):
    """Lines of a table; cells are written as they are, None is empty."""
    def line(cells):
        return "| " + " | ".join("" if cell is None else str(cell) for cell in cells) + " |"
    return [line(head), "|" + "---|" * len(head)] + [line(row) for row in rows]
