"""The folders of src/ in layers as an SVG drawing, from the #include lines of their files."""

import glob
import os
import re

from .files import ROOT, read_text
from .node_drawing import EDGE, FILL, GREY, INK, Svg

# The stages in the order of the data flow, then what stands beside and above them; test/architecture/walls_test.cpp enforces the order.
CONTENT = {
    "util": "text, numbers, files",
    "recording": "intake, checks, events, operating mode",
    "model": "base circuit, effects, simulation",
    "regression": "regressors, evidence, discrepancy",
    "baseline": "predictors without physics",
    "state": "a fitted model, and how it follows samples",
    "estimation": "window, cost, fit, covariance",
    "prediction": "questions, online session, intervals",
    "diagnosis": "where the model deviates, and why",
    "report": "text, JSON, MODEL.yaml, pages",
    "bag": "bags to recordings and back",
    "api": "Model and Session, for C++ and Python",
    "ros": "battery_sof_node",
    "cli": "the command sof"}
ROW, CELL, LEFT, TOP = 26, 19, 10, 96  # [px]
NAME, WORDS = 104, 330  # widths of the columns [px]
WIDE, NARROW = LEFT + NAME + WORDS + CELL * len(CONTENT) + LEFT, LEFT + NAME + CELL * len(CONTENT) + LEFT


def includes():
    """Folders of src/ whose headers a folder includes, for every folder."""
    found = {name: set() for name in sorted(os.listdir(os.path.join(ROOT, "src"))) if os.path.isdir(os.path.join(ROOT, "src", name))}
    for path in sorted(glob.glob(os.path.join(ROOT, "src", "**", "*"), recursive=True)):
        if path.endswith((".cpp", ".hpp", ".inc")):
            own = os.path.relpath(path, os.path.join(ROOT, "src")).split(os.sep)[0]
            found[own] |= {name for name in re.findall(r'^#include "(\w+)/', read_text(path), re.M) if name in found and name != own}
    return found


def drawing(width):
    """A row for each folder; a mark in its row for each folder that it includes, whose name stands above the mark."""
    found, svg = includes(), Svg()
    names = [*CONTENT, *sorted(set(found) - set(CONTENT))]
    marks = width - LEFT - CELL * len(names)
    svg.text(LEFT, 20, "a folder" if width == NARROW else "a folder of src, and what it contains", size=12, color=GREY)
    svg.text(marks - 8, TOP - 8, "includes", "end", 12, color=GREY)
    for k, name in enumerate(names):
        x, y = marks + CELL * (k + 0.5), TOP + ROW * (k + 0.5)
        svg.box(LEFT, TOP + ROW * k + 2, NAME - 4, ROW - 4)
        svg.text(LEFT + 8, y + 4.5, name, size=13, bold=True)
        if width == WIDE:
            svg.text(LEFT + NAME + 8, y + 4.5, CONTENT.get(name, ""), size=12.5)
        svg.parts.append(f'<text transform="translate({x + 4.5:g} {TOP - 8:g}) rotate(-90)" font-size="12.5" fill="{INK}">{name}</text>')
        svg.parts.append(f'<rect x="{marks + CELL * k:g}" y="{TOP + ROW * k:g}" width="{CELL}" height="{ROW}" fill="{FILL}"/>')
        for j, other in enumerate(names):
            if other in found[name]:
                svg.parts.append(f'<circle cx="{marks + CELL * (j + 0.5):g}" cy="{y:g}" r="5" fill="{EDGE}"/>')
    bottom = TOP + ROW * len(names)
    for k in range(len(names) + 1):
        svg.parts.append(f'<path d="M{marks:g} {TOP + ROW * k:g} h{CELL * len(names)} M{marks + CELL * k:g} {TOP:g} V{bottom:g}" stroke="#d0d7de" fill="none"/>')
    return svg.document(bottom + 10, "The folders of src and what each of them includes", {name: sorted(found[name]) for name in names}, width)
