"""Writes docs/cli.md from what the built `sof` prints for --help, of itself and of every subcommand. Usage: update_cli_page [BUILD]"""

import os
import re
import sys

from .files import ROOT, write_text
from .sof import call, program

BEGINNING = """# The command sof

<!-- scripts/update_cli_page writes this page from `sof --help`; a test finds it stale. -->

Times are in seconds, currents in ampere and positive into the battery, voltages in volt. Examples with their output are in
[getting-started.md](getting-started.md); what an effect is, in [effects.md](effects.md).

Every subcommand takes `--json FILE` (`-` for standard output) and exits with

- 0: done;
- 1: an honest negative outcome: the answer is no, or not vouched for, or the recording cannot tell; the message says which;
- 2: wrong usage or wrong input.

An output file appears whole or not at all, and never over a file that is read.
"""


def subcommands(help_text):
    """Names in the order of `sof --help`."""
    return re.findall(r"^  ([a-z-]+) {2,}\S", help_text.split("Subcommands:\n")[1], flags=re.M)


def section(title, text):
    lines = [line.rstrip() for line in text.strip().splitlines()]
    return f"\n## {title}\n\n" + "\n".join("    " + line if line else "" for line in lines) + "\n"


def page(sof):
    told = call([sof, "--help"])
    return BEGINNING + section("sof", told) + "".join(section(f"sof {name}", call([sof, name, "--help"])) for name in subcommands(told))


def main():
    build = sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "build")
    write_text(os.path.join(ROOT, "docs", "cli.md"), page(program(build, "sof")))
    print("docs/cli.md holds the help of every subcommand")
    return 0
