"""Writes what msg/, srv/ and action/ say of their fields into docs/messages.md: update_messages_page"""

import glob
import os
import re

from .files import ROOT, read_text, with_part, write_text
from .tables import table

PAGE = os.path.join(ROOT, "docs", "messages.md")
BEGIN = "<!-- messages: scripts/update_messages_page writes this part -->\n"
END = "<!-- end of the messages -->\n"
PARTS = {"msg": ("",), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}
# In the order in which they are used; what is missing here comes last.
ORDER = ("SofStatus", "CrankAnswer", "StopTimeAnswer", "ChargeAnswer", "EventRecord", "IdentifiedModel", "Diagnosis",
         "PredictCranking", "PredictStopTime", "PredictChargeAcceptance", "PredictMap", "SimulateProfile", "SetStandingQuery", "Identify", "Diagnose")
FIELD = re.compile(r"(?P<type>[\w/]+(?:\[\])?) (?P<name>\w+)(?: *= *(?P<value>\S+))?(?: +# (?P<says>.*))?$")
RANGE = re.compile(r"\[([^\]]+)\] *")


def files():
    """Paths of the definitions."""
    found = sorted(path for kind in PARTS for path in glob.glob(os.path.join(ROOT, kind, "*." + kind)))

    def place(path):
        name = name_of(path)
        return list(PARTS).index(path.rpartition(".")[2]), ORDER.index(name) if name in ORDER else len(ORDER), name

    return sorted(found, key=place)


def name_of(path):
    return os.path.splitext(os.path.basename(path))[0]


def comment(lines):
    """Lines of a comment as text; those that are indented in it are kept as they are."""
    text, kept = [], []
    for line in lines:
        (kept if line.startswith("  ") else text).append(line)
    return ([" ".join(text), ""] if text else []) + (["```", *(line.strip("\n") for line in kept), "```", ""] if kept else [])


def row(match, types):
    """The row of a field: type, name or constant, unit or range, meaning."""
    kind, says = match["type"], match["says"] or ""
    base = kind.removesuffix("[]")
    unit = RANGE.match(says) if says.count("[") == 1 else None  # more than one: they stay where they are explained
    shown = f"[{kind}](#{base.lower()})".replace("[]]", r"\[\]]") if base in types else kind.replace("[]", r"\[\]")
    return shown, f"`{match['name']}`" + (f" = {match['value']}" if match["value"] else ""), unit[1].replace("0, 1", "0 to 1") if unit else "", (says[unit.end():] if unit else says).strip("; ,").replace("|", r"\|")


def part(text, types):
    """Text and tables of a message, or of one part of a service or an action."""
    lines, rows, said = [], [], []

    def close():
        if rows:
            lines.extend(table(("type", "field", "unit, range", "meaning"), rows) + [""])
            rows.clear()

    constant = is_group = False
    for line in [*text.splitlines(), ""]:
        match = FIELD.match(line.rstrip())
        if line.startswith("#"):
            said.append(line[1:].removeprefix(" "))
        elif match:
            if match["value"] and not match["says"] and said:  # a string constant has its comment above it
                rows.append((match["type"], f"`{match['name']}` = `{match['value']}`", "", " ".join(said)))
                said.clear()
                constant = True
                continue
            if said and not constant:
                close()
                lines.extend(comment(said))
                is_group = True
            said.clear()
            rows.append(row(match, types))
        elif said and not rows:
            lines.extend(comment(said))
            said.clear()
        elif not line and is_group:  # what follows without a comment is not of the group
            close()
        constant = constant and bool(line)
    close()
    return lines


def section(path, types):
    """What a page says of one definition."""
    kind = path.rpartition(".")[2]
    lines = [f"## {name_of(path)}", ""]
    texts = re.split(r"^---$", read_text(path), flags=re.M)
    for title, text in zip(PARTS[kind], texts):
        shown = part(text, types)
        at = next((k for k, line in enumerate(shown) if line.startswith("|")), len(shown))  # an introduction stands above the first title
        if title == PARTS[kind][0] and title:
            lines += shown[:at]
            shown = shown[at:]
        lines += ([f"**{title}**" + ("" if shown else " without fields"), ""] if title else []) + shown
    return "\n".join(lines).rstrip("\n") + "\n"


def with_reference(text):
    """A page with the reference between its marks."""
    paths = files()
    types = {name_of(path) for path in paths if path.endswith(".msg")}
    return with_part(text, BEGIN, END, "\n" + "\n".join(section(path, types) for path in paths) + "\n")


def main():
    write_text(PAGE, with_reference(read_text(PAGE)))
    print("docs/messages.md holds what msg, srv and action say")
