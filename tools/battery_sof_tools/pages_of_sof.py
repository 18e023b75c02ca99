"""Writes what the built `sof` prints into pages: its subcommands' help, the catalogue of effects.

    update_cli_page [BUILD]         docs/cli.md
    update_effects_page [BUILD]     docs/effects.md

An option that several subcommands share with the same words is listed once, under the names of
those that take it.
"""

import os
import re
import sys

from .files import ROOT, read_text, with_part, write_text
from .sof import call, program

# page: marks between which its part stands
MARKS = {"cli.md": ("<!-- help: scripts/update_cli_page writes this part -->\n",
                    "<!-- end of the help -->\n"),
         "effects.md": ("<!-- catalogue: scripts/update_effects_page writes this part -->\n",
                        "<!-- end of the catalogue -->\n")}
HELP = "-h,--help"
SHARED = 3  # subcommands at least


def subcommands(help_text):
    """Names in the order of `sof --help`."""
    return re.findall(r"^  ([a-z-]+) {2,}\S", help_text.split("Subcommands:\n")[1], flags=re.M)


def options_of(text):
    """Head of a help, and its options, each with the lines that follow it."""
    head, _, tail = text.partition("\nOptions:\n")
    found = []
    for line in tail.splitlines():
        if re.match(r"  -", line):
            found.append(line.rstrip())
        elif line.strip() and found:
            found[-1] += "\n" + line.rstrip()
    return head.strip(), found


def shared(helps):
    """Options that several subcommands have alike, by their names, in the order they are met."""
    takers = {}
    for name, text in helps.items():
        for option in options_of(text)[1]:
            takers.setdefault(option, []).append(name)
    groups = {}
    for option, names in takers.items():
        if len(names) >= SHARED and HELP not in option:
            groups.setdefault(tuple(names), []).append(option)
    return groups


def block(text):
    lines = (line.rstrip() for line in text.strip("\n").splitlines())
    return "\n".join("    " + line if line else "" for line in lines) + "\n"


def head_of(text):
    """What a subcommand does, its usage, its positional arguments but those that several have."""
    what, _, rest = text.partition("Usage: ")
    usage, _, positionals = rest.partition("\n")
    lines = [what.strip(), "Usage: " + usage.replace(" [OPTIONS]", "")]
    lines += [line for line in positionals.splitlines()
              if line.strip() not in ("", "Positionals:") and not re.match(r"  (REC|MODEL) ", line)]
    return "\n".join(lines)


def section(name, text, common):
    head, options = options_of(text)
    own = [one for one in options if HELP not in one and one not in common]
    return f"\n## sof {name}\n\n" + block(head_of(head) + ("\n\n" + "\n".join(own) if own else ""))


def cli(sof):
    """The help of every subcommand."""
    helps = {name: call([sof, name, "--help"]) for name in subcommands(call([sof, "--help"]))}
    groups = shared(helps)
    common = {one for options in groups.values() for one in options}
    text = "".join(f"\n{', '.join(names)}:\n\n" + block("\n".join(options))
                   for names, options in groups.items())
    return text + "".join(section(name, told, common) for name, told in helps.items())


def main():
    which, build = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else os.path.join(ROOT, "build")
    sof, page = program(build, "sof"), which + ".md"
    part = cli(sof) if which == "cli" else call([sof, "effects", "--markdown"])
    path = os.path.join(ROOT, "docs", page)
    write_text(path, with_part(read_text(path), *MARKS[page], part))
    print(f"docs/{page} holds what sof prints")
