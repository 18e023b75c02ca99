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
- 1: an honest negative outcome: the answer is no, or not supported, or the recording cannot tell; the message says which;
- 2: wrong usage or wrong input.

An output file appears whole or not at all, and never over a file that is read.
"""

ENDING = """
## What the help does not say

*Operating mode.* `sof check` says in which samples a source (a generator, a converter, a charger) holds the voltage. Where it does, and samples come a quarter of a second or more apart, `sof identify` is driven by the
voltage there and adds the physics of charging (`fresh_sulphate`); `--effects none` is the base circuit, `--effects IDS` what you name, `--start paper` the paper's own procedure. `sof predict` then goes the same way;
`--mode current` runs the model on the current alone, as in the paper. Q_dyn is always that of the current alone.

*Columns of `sof predict --csv`:* `time_s,current_a,voltage_v,predicted_v,lower_v,upper_v,driven_by,predicted_a,lower_a,upper_a`; of what drives, prediction and bounds are the measured value.

*MODEL.yaml* holds parameters with standard errors and correlations, the state, the errors, and what the window taught beside them: the source's rule, straight lines and past events (`naive`, `experience`) and a regression on
what the equations leave (`learned`). [model.md](model.md#modelyaml) lists its numbers. Files of earlier versions are read; those with `source_delay` or the parameters of the earlier `fresh_sulphate` are refused.

*Questions.* A model is asked from the state it was saved in (`--to` of identify), or `--rested`. `sof crank` also takes the stop and the crank as they happen: `--load-profile FILE.csv`, `--crank-profile FILE.csv` (columns
`time_s,current_a`). JSON holds the fields of the node's services under the same names; JSON has no infinity, so `t_stop` of a stop without an end (`--i-load 0`) is null with `outcome` "always".

*Diagnosis.* The page is one file that needs no network. `--given IDS` models what is known to be there; `--verify-detection-limits IDS` diagnoses the recording with each of these put in and reports the strength at which it is named. Ctrl-C
says what was being done, ends at once, and leaves no file.

*Series string.* `--series-blocks 2` reads a recording of 24 V as that of one of its two 12 V blocks; the model file remembers it, and `sof predict`, `crank`, `stop-time`, `charge` and `map` answer in the row's volts without being reported.

*Long work.* On a terminal a command says from two seconds on what it is at and for how long; `sof map` also how long it will still take. Nothing of it is written to a pipe or a file.

*Times* are those of the recording's own clock; `+60` counts from its first sample. Bags have the topic `battery_state`, or `--topic`.

*Scoring windows of a recording* beside straight lines and past events: `scripts/score_next_window drive.csv` (15 min fitted, the next 15 predicted), `--split 0.75` (three quarters fitted, the last predicted).

*Many recordings at once*, and what a fleet says of a battery (`sof identify --priors`): [fleet.md](fleet.md).
"""


def subcommands(help_text):
    """Names in the order of `sof --help`."""
    return re.findall(r"^  ([a-z-]+) {2,}\S", help_text.split("Subcommands:\n")[1], flags=re.M)


def section(title, text):
    lines = [line.rstrip() for line in text.strip().splitlines()]
    return f"\n## {title}\n\n" + "\n".join("    " + line if line else "" for line in lines) + "\n"


def page(sof):
    told = call([sof, "--help"])
    return BEGINNING + section("sof", told) + "".join(section(f"sof {name}", call([sof, name, "--help"])) for name in subcommands(told)) + ENDING


def main():
    build = sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "build")
    write_text(os.path.join(ROOT, "docs", "cli.md"), page(program(build, "sof")))
    print("docs/cli.md holds the help of every subcommand")
    return 0
