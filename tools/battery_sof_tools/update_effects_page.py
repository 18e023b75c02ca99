"""Writes the catalogue of effects into docs/effects.md, as the built `sof` prints it. Usage: update_effects_page [BUILD]"""

import os
import re
import sys

from .files import ROOT, write_text
from .sof import call, program

BEGIN = "<!-- catalogue: scripts/update_effects_page writes this part -->\n"
END = "<!-- end of the catalogue -->\n"


def with_catalogue(page, catalogue):
    """A page with another catalogue between its marks; SystemExit without the marks."""
    parts = re.split(f"(?<={re.escape(BEGIN)}).*(?={re.escape(END)})", page, flags=re.S)
    if len(parts) != 2:
        raise SystemExit("docs/effects.md: the marks of the catalogue are missing")
    return parts[0] + catalogue + parts[1]


def main():
    build = sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "build")
    path = os.path.join(ROOT, "docs", "effects.md")
    with open(path) as file:
        page = file.read()
    write_text(path, with_catalogue(page, call([program(build, "sof"), "effects", "--markdown"])))
    print("docs/effects.md holds the catalogue")
    return 0
