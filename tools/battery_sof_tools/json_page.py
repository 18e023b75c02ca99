"""Writes what docs/schemas says of the JSON of every command into docs/json.md: update_json_page

The schemas are JSON Schema, draft 2020-12. One file has all that it refers to in its own $defs.
"""

import glob
import os

from .files import ROOT, read_json, read_text, with_part, write_text
from .tables import table

FOLDER = os.path.join(ROOT, "docs", "schemas")
PAGE = os.path.join(ROOT, "docs", "json.md")
ENDING = ".schema.json"
BEGIN = "<!-- schemas: scripts/update_json_page writes this part -->\n"
END = "<!-- end of the schemas -->\n"
# In the order in which the commands are used.
ORDER = ("check", "convert", "simulate", "identify", "predict", "crank", "stop-time", "charge", "map", "diagnose", "diagnose-reference", "effects")


def names():
    """Names of the schemas; those that ORDER lacks come last."""
    found = sorted(os.path.basename(path)[:-len(ENDING)] for path in glob.glob(os.path.join(FOLDER, "*" + ENDING)))
    return sorted(found, key=lambda name: ORDER.index(name) if name in ORDER else len(ORDER))


def referred(whole, part):
    """What a part refers to, and its name; None and None where it stands for itself."""
    for each in (part, *part.get("anyOf", ())):
        if "$ref" in each:
            name = each["$ref"].rpartition("/")[2]
            return name, whole["$defs"][name]
    return None, None


def meaning(whole, part):
    """The description of a part, or of what it refers to."""
    return part.get("description") or (referred(whole, part)[1] or {}).get("description", "")


def type_of(whole, part, anchor):
    """What a table says of the type: `number or null`, `list of` something with a table of its own."""
    name, _ = referred(whole, part)
    if name:
        return f"[{name}](#{anchor(name)})" + (" or null" if "anyOf" in part else "")
    if "const" in part:
        return f'`"{part["const"]}"`'
    if "enum" in part:
        return " or ".join("null" if one is None else f"`{one}`" for one in part["enum"])
    types = part["type"] if isinstance(part["type"], list) else [part["type"]]
    if "array" in types:
        size = f"{part['minItems']} " if part.get("minItems") and part["minItems"] == part.get("maxItems") else ""
        items = type_of(whole, part["items"], anchor).replace("number", "numbers").replace("string", "strings") if "array" in types else ""
        types = [f"list of {size}{items}" if one == "array" else one for one in types]
    return " or ".join(types)


def rows(whole, part, anchor, path=""):
    """Rows of the table of an object; objects without a name of their own are spread out in it."""
    optional = set(part["properties"]) - set(part["required"])
    for key, each in part["properties"].items():
        if each.get("type") == "object" and "$ref" not in each:
            yield f"`{path}{key}`", "object", meaning(whole, each)
            yield from rows(whole, each, anchor, path + key + ".")
        else:
            yield f"`{path}{key}`" + (" (optional)" if key in optional else ""), type_of(whole, each, anchor), meaning(whole, each)


def section(name):
    """What a page says of one schema."""
    whole = read_json(os.path.join(FOLDER, name + ENDING))

    def anchor(definition):
        return f"{name}-{definition}".replace(" ", "-")

    lines = [f"## {whole['title']}", "", f"{whole['description']} Schema: [{name}{ENDING}](schemas/{name}{ENDING}).", ""]
    lines += table(("key", "type", "meaning"), rows(whole, whole, anchor))
    for definition, part in whole.get("$defs", {}).items():
        lines += ["", f"### {name}: {definition}", ""] + table(("key", "type", "meaning"), rows(whole, part, anchor))
    return "\n".join(lines) + "\n"


def with_reference(text):
    """A page with the reference between its marks."""
    return with_part(text, BEGIN, END, "\n" + "\n".join(map(section, names())) + "\n")


def main():
    write_text(PAGE, with_reference(read_text(PAGE)))
    print("docs/json.md holds what docs/schemas says")
