"""The node with its topics, services and actions as an SVG drawing, from what its sources advertise."""

import glob
import json
import os
import re
from html import escape

from .files import ROOT, read_text

WIDTH, NARROW, LINE, MARGIN, GAP = 920, 400, 19, 10, 34  # [px]
NODE = (300, 160)  # left edge and width of the node's box
RIGHT = 585  # left edge of the boxes beside it
FILL, EDGE, INK, GREY = "#eef4fa", "#0969a8", "#1b1f24", "#57606a"
# What a service or topic is for; a name that is missing here is drawn without a purpose.
USES = {
    "status": "answers once a second", "model": "each accepted fit", "diagnosis": "each finished diagnosis", "change": "changes since the reference", "/diagnostics": "rates, faults, errors",
    "predict_cranking": "SOF1", "predict_stop_time": "longest stop", "predict_charge_acceptance": "SOF2", "predict_map": "grids of both",
    "simulate_profile": "voltage of a profile", "set_standing_query": "what ~status answers", "set_reference": "new reference of ~change", "identify": "fit now", "diagnose": "diagnose now"}


def interface():
    """Names of the node's own topics, services and actions, each with its type; in the order of the sources."""
    text = "\n".join(read_text(path) for path in sorted(glob.glob(os.path.join(ROOT, "src", "ros", "*.[ch]pp"))))
    topics = {name: kind for kind, name in re.findall(r'publisher_\W[^;]*?advertise<(?:\w+::)?(\w+)>\("(\w+)"', text)}
    aliases = dict(re.findall(r"using (\w+) = battery_sof::(\w+);", text))
    services = {name: kind for kind, name in re.findall(r'serve<(\w+)>\(\s*"(\w+)"', text)}
    for name, method in re.findall(r'advertiseService\("(\w+)",\s*&BatterySofNode::on(\w+)', text):
        services[name] = re.search(rf"on{method}\(\s*(?:\w+::)?(\w+)::Request", text).group(1)
    actions = {name: kind + "Action" for kind, name in ((name.capitalize(), name) for name in re.findall(r'_server_\(\s*[\w.()]+,\s*"(\w+)"', text))}
    return {"topics": {name: aliases.get(kind, kind).replace("Message", "") for name, kind in topics.items()}, "services": services, "actions": actions}


class Svg:
    def __init__(self):
        self.parts = []

    def text(self, x, y, words, anchor="start", size=13, bold=False, color=INK):
        self.parts.append(f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" font-size="{size}" fill="{color}"{" font-weight=" + chr(34) + "bold" + chr(34) if bold else ""}>{escape(words)}</text>')

    def box(self, x, y, width, height, fill=FILL, edge=EDGE):
        self.parts.append(f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="8" fill="{fill}" stroke="{edge}" stroke-width="1.5"/>')

    def arrow(self, x, y, to, both=False):
        self.parts.append(f'<path d="M{x:g} {y:g} H{to:g}" fill="none" stroke="{INK}" stroke-width="1.4"{" marker-start=" + chr(34) + "url(#head)" + chr(34) if both else ""} marker-end="url(#head)"/>')

    def down(self, x, y, to, both=False):
        self.parts.append(f'<path d="M{x:g} {y:g} V{to:g}" fill="none" stroke="{INK}" stroke-width="1.4"{" marker-start=" + chr(34) + "url(#head)" + chr(34) if both else ""} marker-end="url(#head)"/>')

    def document(self, height, title, numbers, width=WIDTH):
        head = f'''<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" width="{width:g}" height="{height:g}" font-family="DejaVu Sans, Verdana, sans-serif" role="img">
<title>{escape(title)}</title>
<metadata xmlns:dc="http://purl.org/dc/elements/1.1/"><dc:description>{escape(json.dumps(numbers))}</dc:description></metadata>
<defs><marker id="head" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto-start-reverse"><path d="M0 0 L10 5 L0 10 z" fill="{INK}"/></marker></defs>
<rect width="100%" height="100%" fill="#ffffff"/>
'''
        return head + "\n".join(self.parts) + "\n</svg>\n"


def names(svg, left, top, right, title, rows):
    """A box of names, each with its use. Returns its height."""
    height = 34 + LINE * len(rows)
    svg.box(left, top, right - left, height, "#ffffff", GREY)
    svg.text(left + 12, top + 21, title, bold=True)
    for k, (name, use) in enumerate(rows):
        y = top + 21 + LINE * (k + 1)
        svg.text(left + 12, y, name, size=12)
        svg.text(right - 10, y, use, "end", 11, color=GREY)
    return height


def group(svg, top, title, label, rows, both):
    """A box of names beside the node, and its arrow. Returns where the next one may begin."""
    height = names(svg, RIGHT, top, WIDTH - MARGIN, title, rows)
    middle = top + height / 2
    svg.arrow(NODE[0] + NODE[1], middle, RIGHT, both)
    svg.text((NODE[0] + NODE[1] + RIGHT) / 2, middle - 7, label, "middle", 11)
    return top + height + 16


def groups(found):
    """Of names and their uses: title, what the node does with them, rows, whether something goes both ways."""
    def rows(kind):
        return [("~" + name, USES.get(name, "")) for name in found[kind]]

    return [("Topics", "publishes", rows("topics") + [("/diagnostics", USES["/diagnostics"])], False),
            ("Services", "answers", rows("services"), True), ("Actions", "works on goals", rows("actions"), True)]


def narrow_drawing():
    """For a narrow screen: what the node takes above it, and what it offers below."""
    found, svg, right = interface(), Svg(), NARROW - MARGIN
    bottom = MARGIN + names(svg, MARGIN, MARGIN, right, "Input and state", [("battery_state", "sensor_msgs/BatteryState"), ("~state_file", "the model, kept over a restart")])
    svg.box(MARGIN, bottom + GAP, right - MARGIN, 56)
    svg.text(NARROW / 2, bottom + GAP + 24, "battery_sof_node", "middle", bold=True)
    svg.text(NARROW / 2, bottom + GAP + 43, "follows the battery and fits in the background", "middle", 12)
    svg.down(NARROW / 2, bottom, bottom + GAP)
    bottom += GAP + 56
    svg.down(NARROW / 2, bottom, bottom + GAP - MARGIN, True)
    bottom += GAP - 2 * MARGIN
    for title, _, rows, _ in groups(found):
        bottom += MARGIN + names(svg, MARGIN, bottom + MARGIN, right, title, rows)
    return svg.document(bottom + MARGIN, "battery_sof_node with its topics, services and actions", found, NARROW)


def drawing():
    found, svg = interface(), Svg()
    bottom = MARGIN
    for each in groups(found):
        bottom = group(svg, bottom, *each)
    height = bottom - 16 + MARGIN
    left, width = NODE
    svg.box(left, MARGIN, width, height - 2 * MARGIN)
    svg.text(left + width / 2, height / 2 - 16, "battery_sof_node", "middle", bold=True)
    for k, words in enumerate(("follows the battery", "with every sample, and", "fits in the background")):
        svg.text(left + width / 2, height / 2 + 6 + 17 * k, words, "middle", 12)
    for at, title, words, label, both in ((0.25, "Battery sensor", ("any driver of", "sensor_msgs/BatteryState"), "battery_state", False),
                                          (0.72, "State file", ("the model, kept", "over a restart"), "~state_file", True)):
        middle = height * at
        svg.box(MARGIN, middle - 36, 180, 72, "#ffffff", GREY)
        svg.text(MARGIN + 90, middle - 14, title, "middle", bold=True)
        for k, line in enumerate(words):
            svg.text(MARGIN + 90, middle + 5 + 17 * k, line, "middle", 12)
        svg.arrow(MARGIN + 180, middle, left, both)
        svg.text((MARGIN + 180 + left) / 2, middle - 7, label, "middle", 11)
    return svg.document(height, "battery_sof_node with its topics, services and actions", found)
