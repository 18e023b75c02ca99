"""Figures in the pages are copies of docs/results.json; this writes them, and finds those that differ.

In a sentence or a hand-made table a figure stands before a comment that names it, and keeps its own decimals, sign and thousands:

    58.8<!--= next_window.drive_1.model.share_percent --> %

A whole table, or any lines, stand between two comments (page_tables.py makes them):

    <!-- results: next_window -->
    ...
    <!-- end of results -->
"""

import os
import re

from ..files import ROOT, digest, pages_of_docs, read_json, read_text, write_text
from . import page_tables

RESULTS = os.path.join(ROOT, "docs", "results.json")
FIGURE = re.compile(r"(?P<number>[+-]?\d[\d,]*(?:\.\d+)?)<!--= (?P<id>[^>]+?) -->")
BLOCK = re.compile(r"(?P<begin><!-- results: (?P<name>\w+) -->\n)(?P<lines>.*?)(?P<end><!-- end of results -->)", re.S)


def value_of(results, name):
    """A figure by its id, measurement.group.figure; None where there is none."""
    first, *rest = name.split(".")
    value = results.get(first, {}).get("figures")
    for key in rest:
        value = value.get(key) if isinstance(value, dict) else None
    return value


def like(number, value):
    """A value with the decimals, sign and thousands of a number in a page."""
    decimals = len(number.partition(".")[2])
    return f"{value:{'+' if number.startswith('+') else ''}{',' if ',' in number else ''}.{decimals}f}"


def rendered(text, results, differs):
    """A page with the figures of results; differs(what) is called for each that was another."""
    def figure(match):
        value = value_of(results, match["id"])
        if not isinstance(value, (int, float)):
            differs(f"{match['id']}: docs/results.json has no such figure")
            return match[0]
        number = like(match["number"], value)
        if number != match["number"]:
            differs(f"{match['id']}: the page says {match['number']}, docs/results.json {number}")
        return match[0].replace(match["number"], number, 1)

    def block(match):
        make = getattr(page_tables, match["name"], None)
        if make is None:
            differs(f"results: {match['name']}: page_tables.py makes no such lines")
            return match[0]
        try:
            lines = "\n".join(make({name: entry["figures"] for name, entry in results.items()})) + "\n"
        except KeyError as missing:
            differs(f"results: {match['name']}: docs/results.json has no such figure: {missing}")
            return match[0]
        for old, new in zip(match["lines"].splitlines(), lines.splitlines()):
            if old != new:
                differs(f"results: {match['name']}: the page says\n  {old}\ndocs/results.json\n  {new}")
        if len(match["lines"].splitlines()) != len(lines.splitlines()):
            differs(f"results: {match['name']}: the page has {len(match['lines'].splitlines())} lines, docs/results.json {len(lines.splitlines())}")
        return match["begin"] + lines + match["end"]

    return FIGURE.sub(figure, BLOCK.sub(block, text))


def differing(results, texts=None):
    """Sentences, each with page and figure, on copies that differ from results, and on pictures that are not those of the run.

    texts: {page: text} in place of the files.
    """
    found = []
    for page in ("README.md", *pages_of_docs()):
        text = texts[page] if texts and page in texts else open_page(page)
        rendered(text, results, lambda what, page=page: found.append(f"{page}: {what}"))
    for entry in results.values():
        for file, known in entry.get("files", {}).items():
            if digest(os.path.join(ROOT, "docs", file)) != known:
                found.append(f"docs/{file}: not the picture that was made with the figures of docs/results.json")
    return found


def open_page(page):
    return read_text(os.path.join(ROOT, page))


def write():
    """Renders every page. SystemExit names what docs/results.json does not have."""
    results, missing = read_json(RESULTS), []
    for page in ("README.md", *pages_of_docs()):
        text, new = open_page(page), None
        new = rendered(text, results, lambda what, page=page: missing.append(f"{page}: {what}") if " no such " in what else None)
        if new != text:
            write_text(os.path.join(ROOT, page), new)
            print(f"{page}: figures written")
    if missing:
        raise SystemExit("\n".join(missing))
