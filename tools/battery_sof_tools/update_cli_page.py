"""Writes docs/cli.md from what the built `sof` prints for --help, of itself and of every subcommand. Usage: update_cli_page [BUILD]

An option that several subcommands share with the same words is listed once, under the names of those that take it.
"""

import os
import re
import sys

from .files import ROOT, write_text
from .sof import call, program

BEGINNING = """# The command sof

<!-- scripts/update_cli_page writes this page from `sof --help`; a test finds it stale. -->

Times are in seconds, currents in ampere and positive into the battery, voltages in volt. The [tutorial](tutorial.md) has examples with
their output.

| exit code | meaning |
|---|---|
| 0 | done |
| 1 | the answer is no or not supported, or the recording cannot decide; the message says which |
| 2 | wrong usage or input |

An output file appears whole or not at all, and never replaces a file that is read.
"""

ENDING = """
## What the help does not say

**Queries** begin at the state that the model was saved in (`--to` of identify), unless `--rested` is given. JSON has the fields of the
node's services. It has no infinity: a stop without an end (`--i-load 0`) has `t_stop` null and `outcome` "always".

**Operating mode.** `sof check` reports when a charger (alternator, converter) controls the voltage. There, and only if samples are
0.25 s or more apart, `sof identify` uses the voltage as the input. It then adds the physics of charging (`fresh_sulphate`).
`--effects none` fits the base circuit, `--start paper` follows the paper. `sof predict` runs as the model was fitted;
`--mode current` uses the current throughout, as in the paper. Q_dyn always belongs to the current alone.

**CSV of `sof predict`:** `time_s,current_a,voltage_v,predicted_v,lower_v,upper_v,driven_by,predicted_a,lower_a,upper_a`. Of the input,
prediction and bounds are the measured value.

**MODEL.yaml** holds parameters with standard errors and correlations, the state, the errors, past events and the baseline. It remembers
`--series-blocks`, so `sof predict`, `crank`, `stop-time`, `charge` and `map` work in the battery's own volts.

**Diagnosis.** Ctrl-C says what was being done, and leaves no file.

**Long work.** A terminal shows progress after 2 s. Pipes and files get none of it.

**Scoring.** `scripts/score_next_window drive.csv` fits 15 min and predicts the next 15. `--split 0.75` fits three quarters and predicts
the rest. [Fleet](fleet.md) has many recordings at once, and `--priors`.
"""

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
    """Options that several subcommands have alike, by the names of those, in the order in which they are met."""
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
    return "\n".join("    " + line.rstrip() if line.strip() else "" for line in text.strip("\n").splitlines()) + "\n"


def head_of(text):
    """What a subcommand does, its usage, and its positional arguments, but those that several have."""
    what, _, rest = text.partition("Usage: ")
    usage, _, positionals = rest.partition("\n")
    lines = [what.strip(), "Usage: " + usage.replace(" [OPTIONS]", "")]
    lines += [line for line in positionals.splitlines() if line.strip() and line.strip() != "Positionals:" and not re.match(r"  (REC|MODEL) ", line)]
    return "\n".join(lines)


def section(name, text, common):
    head, options = options_of(text)
    own = [one for one in options if HELP not in one and one not in common]
    return f"\n## sof {name}\n\n" + block(head_of(head) + ("\n\n" + "\n".join(own) if own else ""))


def page(sof):
    helps = {name: call([sof, name, "--help"]) for name in subcommands(call([sof, "--help"]))}
    groups = shared(helps)
    common = {one for options in groups.values() for one in options}
    text = BEGINNING + "\n## Options of several subcommands\n\nREC is a recording: .bag, .csv, or CSV from a pipe. MODEL is a file of `sof identify`. Every subcommand has `--help`.\n"
    for names, options in groups.items():
        text += f"\n{', '.join(names)}:\n\n" + block("\n".join(options))
    return text + "".join(section(name, told, common) for name, told in helps.items()) + ENDING


def main():
    build = sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "build")
    write_text(os.path.join(ROOT, "docs", "cli.md"), page(program(build, "sof")))
    print("docs/cli.md holds the help of every subcommand")
    return 0
