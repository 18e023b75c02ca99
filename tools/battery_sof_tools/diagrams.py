"""Diagrams of the maintainers' pages as SVG: the circuit (docs/model.md) and the data flow (docs/developing.md). Usage: draw_diagrams [FOLDER]; docs/pictures unless given."""

import os
import sys

from .files import ROOT, write_text

HEAD = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="sans-serif" font-size="14">
<title>{title}</title>
<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto-start-reverse"><path d="M0 0 8 4 0 8z" fill="{ink}"/></marker>
<marker id="red" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto-start-reverse"><path d="M0 0 8 4 0 8z" fill="{sign}"/></marker></defs>
<rect width="{width}" height="{height}" fill="#fff"/>
"""
INK, SIGN, GREY, FILL = "#222", "#b03020", "#777", "#eef3f8"


def line(*points, colour=INK, tip="", dashed=False):
    """A line through points (x, y); tip: id of the marker at its end."""
    end = f' marker-end="url(#{tip})"' if tip else ""
    dash = ' stroke-dasharray="5 4"' if dashed else ""
    return f'<polyline points="{" ".join(f"{x},{y}" for x, y in points)}" fill="none" stroke="{colour}" stroke-width="1.6"{dash}{end}/>\n'


def text(x, y, words, colour=INK, size=14, anchor="middle", bold=False):
    weight = ' font-weight="bold"' if bold else ""
    return f'<text x="{x}" y="{y}" text-anchor="{anchor}" fill="{colour}" font-size="{size}"{weight}>{words}</text>\n'


def box(x, y, width, height, fill="#fff", colour=INK, dashed=False):
    dash = ' stroke-dasharray="5 4"' if dashed else ""
    return f'<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="{fill}" stroke="{colour}" stroke-width="1.6"{dash}/>\n'


def dot(x, y):
    return f'<circle cx="{x}" cy="{y}" r="3" fill="{INK}"/>\n'


# ---------------------------------------------------------------------------------------------- the circuit

def terminals():
    """Both terminals, the current's arrow into the positive one, and the terminal voltage from minus to plus."""
    return (f'<circle cx="40" cy="90" r="5" fill="#fff" stroke="{INK}" stroke-width="1.6"/>\n<circle cx="40" cy="290" r="5" fill="#fff" stroke="{INK}" stroke-width="1.6"/>\n'
            + text(22, 82, "+", size=18) + text(22, 300, "−", size=18)
            + line((52, 72), (108, 72), colour=SIGN, tip="red") + text(80, 62, "i", SIGN) + text(112, 46, "i &gt; 0: charging", SIGN, 12)
            + line((40, 278), (40, 104), colour=SIGN, tip="red") + text(56, 196, "u", SIGN))


def resistance():
    """r(i): a resistance for each sign, with ideal diodes."""
    parts = line((46, 90), (130, 90)) + dot(130, 90) + line((130, 60), (130, 120)) + line((290, 60), (290, 120)) + dot(290, 90)
    for y, name, charges in ((60, "r_charge", True), (120, "r_discharge", False)):
        parts += line((130, y), (150, y)) + line((170, y), (186, y)) + box(186, y - 10, 92, 20, FILL) + line((278, y), (290, y)) + text(232, y + 5, name, size=13)
        tri = f"150,{y - 8} 150,{y + 8} 168,{y}" if charges else f"170,{y - 8} 170,{y + 8} 152,{y}"
        bar = 169 if charges else 151
        parts += f'<polygon points="{tri}" fill="{INK}"/>\n' + line((bar, y - 9), (bar, y + 9))
    return parts + text(210, 32, "r(i)", bold=True)


def double_layer():
    """C_2 beside the charge transfer, with a dashed branch for side currents; its voltage from right to left."""
    parts = line((290, 90), (350, 90)) + dot(350, 90) + line((350, 50), (350, 165)) + line((530, 50), (530, 165)) + dot(530, 90)
    parts += line((350, 50), (432, 50)) + line((432, 36), (432, 64)) + line((444, 36), (444, 64)) + line((444, 50), (530, 50)) + text(470, 42, "c2")
    parts += line((350, 105), (390, 105)) + box(390, 94, 100, 22, FILL) + line((490, 105), (530, 105)) + text(440, 110, "i_r2(u_c2)", size=13)
    parts += line((350, 165), (385, 165), dashed=True) + box(385, 153, 110, 24, colour=GREY, dashed=True) + line((495, 165), (530, 165), dashed=True) + text(440, 170, "side currents", GREY, 12)
    return parts + line((522, 26), (358, 26), colour=SIGN, tip="red") + text(440, 20, "u_c2", SIGN)


def rest_of_loop():
    """Voltages of effects in series, the open-circuit voltage, and the way back."""
    parts = line((530, 90), (575, 90)) + box(575, 74, 110, 32, colour=GREY, dashed=True) + text(630, 87, "voltages of", GREY, 12) + text(630, 101, "effects", GREY, 12)
    parts += line((685, 90), (740, 90), (740, 175)) + line((722, 175), (758, 175)) + line((731, 187), (749, 187)) + line((740, 187), (740, 290), (46, 290))
    return parts + line((775, 205), (775, 155), colour=SIGN, tip="red") + text(788, 184, "u_dc", SIGN, anchor="start")


def circuit():
    return (HEAD.format(width=830, height=345, title="The base circuit with its signs", ink=INK, sign=SIGN) + terminals() + resistance() + double_layer() + rest_of_loop()
            + text(390, 318, "u = u_dc + u_c2 + r(i) i + voltages of effects;   c2 du_c2/dt = i − i_r2 − side currents", size=13)
            + text(390, 336, "Voltage arrows point from − to +. Dashed: only with effects.", GREY, 12) + "</svg>\n")


# ---------------------------------------------------------------------------------------------- the data flow

COLUMN, TOP = 210, 60
# folder: column, row, what it does
FOLDERS = {"bag": (0, 0, "bags to series"), "recording": (1, 0, "intake, checks, events,\noperating mode"), "model": (1, 2, "base circuit, effects,\nsimulation"),
           "baseline": (2, 0, "predictors without physics"), "state": (2, 1, "a fitted model's state:\nestimator, posterior, events"), "regression": (2, 2, "regressors, evidence,\ndiscrepancy model"),
           "estimation": (3, 1, "window, cost, fit,\ncovariance"), "prediction": (4, 0.5, "queries, online session,\nmodel selection"), "diagnosis": (4, 2, "locate, select, judge,\ncompare"),
           "report": (5, 1, "text, JSON, MODEL.yaml,\npages"), "ros": (6, 0, "battery_sof_node"), "cli": (6, 1, "sof"), "api": (6, 2, "C++ interface, Python")}
ARROWS = (("bag", "recording"), ("recording", "baseline"), ("recording", "state"), ("model", "state"), ("model", "regression"), ("baseline", "prediction"), ("state", "estimation"), ("regression", "estimation"),
          ("estimation", "prediction"), ("estimation", "diagnosis"), ("regression", "diagnosis"), ("prediction", "report"), ("diagnosis", "report"), ("report", "ros"), ("report", "cli"), ("report", "api"))


def edges(name):
    column, row, _ = FOLDERS[name]
    return 20 + COLUMN * column, TOP + 110 * row


def data_flow():
    width = 20 + COLUMN * 7 - 30
    parts = HEAD.format(width=width, height=440, title="Data flow through the folders of src", ink=INK, sign=SIGN)
    parts += text(20, 30, "src/: who uses whom. Order of includes: util, recording, model, regression, baseline, state, estimation, prediction, diagnosis, report", anchor="start", size=14)
    for first, second in ARROWS:
        (x1, y1), (x2, y2) = edges(first), edges(second)
        parts += line((x1 + 165, y1 + 40), (x2 - 2, y2 + 40), colour=GREY, tip="tip")
    for name, (_, _, words) in FOLDERS.items():
        x, y = edges(name)
        parts += box(x, y, 165, 78, FILL) + text(x + 82, y + 22, name + "/", bold=True)
        for number, words_line in enumerate(words.split("\n")):
            parts += text(x + 82, y + 42 + 17 * number, words_line, size=12)
    parts += box(20, 390, 375, 36, colour=GREY, dashed=True) + text(207, 413, "simulator/: second implementation, shares no code", GREY, 13)
    parts += box(440, 390, 375, 36, colour=GREY, dashed=True) + text(627, 413, "tools/, experiments/, bench/: measure, not installed", GREY, 13)
    return parts + "</svg>\n"


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "docs", "pictures")
    for name, drawn in (("circuit.svg", circuit()), ("data_flow.svg", data_flow())):
        write_text(os.path.join(folder, name), drawn)
    return 0
