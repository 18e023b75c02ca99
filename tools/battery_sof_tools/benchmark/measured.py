"""Every measured recording, whole, diagnosed: verdict, mechanism, hold-out errors beside a ridge regression, processor time."""

import argparse
import os
import resource

from .. import recordings, sof
from ..files import write_json
from ..progress import followed
from ..rates import geometric_mean
from ..tables import table
from .answers import class_of

# A wrong effect, given: what any further parameters gain. The second where the first is named.
PLACEBOS = ("current_offset", "high_rate_depletion")
HEAD = ("recording", "verdict; mechanism; effects", "RMS error [mV]: base, extended, ridge regression, line fit",
        "explained variation [%]: base, extended, line fit", "equations alone [%]: base, extended", "a wrong effect", "processor time [s]")


def whole_recordings():
    """By the path without its ending: the recordings as they are, whatever stretches of them others take."""
    return {os.path.splitext(one.path)[0]: one for one in recordings.MEASURED.values()}


def processor_time():
    """[s] of all programs called so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def figures(answer):
    """Errors [V] and shares [%] of a diagnosis, base circuit and extended model."""
    base, extended = (answer["fit"][one]["holdout"] for one in ("base", "extended")) if answer["fit"].get("extended") else (
        answer["fit"]["base"]["holdout"],) * 2
    return {"base": base["rmse_v"], "extended": extended["rmse_v"], "ridge": answer["baseline"]["rmse_v"], "line": answer["baseline_line"]["rmse_v"],
            "shares": (base["share_percent"], extended["share_percent"], answer["baseline_line"]["share_percent"])}


def equations(answer):
    """Explained variation of the equations alone [%], base circuit and extended model; None where nothing controls the voltage."""
    return tuple(answer["fit"][one]["holdout"]["equations_share_percent"] for one in ("base", "extended"))


def placebo(diagnosed, answer):
    """The hold-out with a wrong effect, given, in place of what the diagnosis found. diagnosed: (options) -> answer."""
    named = {one["id"] for one in answer["effects"]}
    effect = next(one for one in PLACEBOS if one not in named)
    wrong = diagnosed("--given", effect)
    return {"effect": effect, "extended": figures(wrong)["extended"], "share": figures(wrong)["shares"][1], "equations": equations(wrong)[1]}


def ratio(one):
    """Extended over base: of what is not explained of current and voltage while a charger regulates the voltage, of the voltage's errors elsewhere."""
    base, extended, _ = one["shares"]
    return one["extended"] / one["base"] if base is None or extended is None else (100 - extended) / (100 - base)


def told_of(answer):
    """Verdict, mechanism with its probability, and what is named."""
    parts = [answer["verdict"]]
    if answer["mechanism"]:
        stated = "" if answer["probability"] is None else f" ({answer['probability']:.2f})"
        parts.append(answer["mechanism"] + stated)
    named = dict.fromkeys(" or ".join(sorted(class_of(one))) for one in answer["effects"])
    return "; ".join(parts + ([", ".join(named)] if named else []))


def row(name, answer, found, seconds):
    errors = ", ".join(f"{1e3 * found[key]:.0f}" for key in ("base", "extended", "ridge", "line"))
    def percents(some):
        return ", ".join("-" if share is None else f"{share:.0f}" for share in some)
    wrong = found["placebo"]
    told = f"{wrong['effect']}: " + (f"{1e3 * wrong['extended']:.0f} mV" if wrong["share"] is None else percents((wrong["equations"], wrong["share"])))
    return (name, told_of(answer), errors, percents(found["shares"]), percents(found["equations"]), told, f"{seconds:.0f}")


def summary(found):
    """Extended over base as a geometric mean, and where the baseline predictors are ahead."""
    behind = [name for name, one in found.items() if one["ridge"] < one["extended"]]
    line = [name for name, one in found.items() if one["line"] < one["extended"]]
    def counted(names):
        return f"{len(names)}" + (f" ({', '.join(names)})" if names else "")
    return (f"Extended over base: {geometric_mean([ratio(one) for one in found.values()]):.2f} (geometric mean of {len(found)}). "
            f"A ridge regression is ahead on {counted(behind)}, a line fit on {counted(line)}. "
            f"Withheld as no improvement, and scored all the same: {counted([name for name, one in found.items() if one['withheld']])}.")


def parser(about):
    """Of a command that diagnoses the measured recordings."""
    made = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("build", nargs="?", default="build")
    made.add_argument("--data", required=True, help="folder of the recordings")
    made.add_argument("--sof", help="a copy of the command, its libraries above it, in place of the build's")
    made.add_argument("--json", help="file to write the figures to")
    made.add_argument("--only", default="", help="recordings, comma-separated, as the table names them")
    return made


def chosen(arguments):
    """The command, and {name: recording} of those that are wanted. SystemExit for a name of none."""
    every = whole_recordings()
    names = arguments.only.split(",") if arguments.only else every
    unknown = sorted(set(names) - set(every))
    if unknown:
        raise SystemExit(f"--only: no recording {', '.join(unknown)}; there are {', '.join(every)}")
    return sof.program(arguments.build, "sof", arguments.sof), {name: every[name] for name in names}


def main():
    arguments = parser("Diagnoses the measured recordings, one thread, one after the other.").parse_args()
    program, wanted = chosen(arguments)
    rows, found = [], {}
    for name, measured in followed(wanted.items(), "recording"):
        begun = processor_time()
        read = recordings.column_options(measured.columns, measured.discharge_positive) + recordings.capacity_options(measured.capacity_ah)
        def diagnosed(*options):
            return sof.diagnose(program, os.path.join(arguments.data, measured.path), *read, "--anyway", *options)
        try:
            answer = diagnosed()
        except sof.Failure as failure:
            rows.append((name, str(failure), *("",) * (len(HEAD) - 2)))
            continue
        seconds = processor_time() - begun
        found[name] = dict(figures(answer), equations=equations(answer), placebo=placebo(diagnosed, answer), told=told_of(answer), seconds=seconds, withheld=answer.get("withheld_rmse_v") is not None)
        rows.append(row(name, answer, found[name], seconds))
    print("\n".join(table(HEAD, rows)))
    write_json(arguments.json, found)
    if found:
        print("\n" + summary(found))
