"""Rows in groups, and Markdown tables."""

import itertools


def grouped(rows, key):
    """{key(row): rows} in the keys' order."""
    return {name: list(some) for name, some in itertools.groupby(sorted(rows, key=key), key)}


def table(head, rows):
    """Lines of a table; cells are written as they are, None is empty."""
    def line(cells):
        return "| " + " | ".join("" if cell is None else str(cell) for cell in cells) + " |"
    return [line(head), "|" + "---|" * len(head)] + [line(row) for row in rows]
