"""From what the steps of a recording said to rows of the tables in schema.py."""

import json
import os

from .plan import MEANT, STEPS


def of_recording(entry, told):
    """Rows by table. reported: the steps' files by name."""
    key = entry["key"]
    answers = {step: one["answer"] for step, one in told.items() if one["answer"]}
    made = {"recording": [recording(entry, told, answers.get("check"))], "step": [(key, s, told[s]["exit"], told[s]["reason"]) for s in STEPS if s in told],
            "cost": [(key, s, told[s]["cost"]["wall_s"], told[s]["cost"]["cpu_s"]) for s in STEPS if s in told and told[s]["cost"]]}
    makers = {"check": (findings,), "identify": (window, parameters), "predict": (prediction,), "diagnose": (verdict, mechanisms, candidates, found_parameters), "score": (scores, window_parameters)}
    for step, functions in makers.items():
        for maker in functions if step in answers else ():
            table, lines = maker(answers[step])
            made.setdefault(table, []).extend((key, *line) for line in lines)
    return made


def outcome(told):
    """(done, partly or failed, and why): the first step that failed gives the reason; a step that is not needed or follows another's failure does not."""
    wanted = {step: told[step] for step in STEPS if step in told and step != "convert"}
    bad = [step for step, one in wanted.items() if one["answer"] is None and not (step == "score" and one["exit"] is None)]
    if not bad:
        return "done", None
    return ("failed" if len(bad) == len([step for step in wanted if step != "score"]) else "partly"), f"{bad[0]}: {wanted[bad[0]]['reason']}"


def recording(entry, told, check):
    check = check or {}
    source, temperature = check.get("source") or {}, check.get("temperature_range_c") or (None, None)
    options = json.dumps({name: entry[name] for name in MEANT if entry.get(name)}, sort_keys=True)
    return (entry["key"], os.path.basename(entry["path"]), entry["path"], entry["sha256"], entry["bytes"], entry["battery"], entry.get("vehicle_type"), entry.get("age_years"), options,
            *outcome(told), check.get("samples"), check.get("from_s"), check.get("to_s"), check.get("median_interval_s"), *temperature,
            None if "seen" not in source else int(source["seen"]), source.get("share"))


def findings(answer):
    return "finding", [(one["id"], one["severity"], one.get("value"), one.get("unit"), one.get("samples"), one["what"]) for one in answer["findings"]]


def window(answer):
    ends = answer.get("window") or {}
    return "window", [(ends.get("from_s"), ends.get("to_s"), answer.get("samples"), ",".join(answer.get("effects") or ()), answer.get("status"), answer.get("window_quality"),
                       answer.get("q_dyn_percent"), answer.get("rmse_v"))]


def parameter(source, effects, one):
    return (source, ",".join(effects), one["name"], one["value"], one.get("std_error", one.get("std")), one.get("unit"), flag(one.get("determined")), flag(one.get("at_bound")))


def flag(value):
    return None if value is None else int(value)


def parameters(answer):
    return "parameter", [parameter("identify", answer.get("effects") or (), one) for one in answer.get("parameters") or ()]


def found_parameters(answer):
    return "parameter", [parameter("diagnose", [effect["id"]], one) for effect in answer.get("effects") or () for one in effect.get("parameters") or ()]


def window_parameters(answer):
    return "parameter", [parameter(f"score {one['start_s']:.3f}", one["effects"], each) for one in answer["windows"] for each in one["parameters"]]


def prediction(answer):
    mixed, baseline, ends = answer.get("mixed") or {}, answer.get("baseline") or {}, answer.get("window") or {}
    return "prediction", [(ends.get("from_s"), ends.get("to_s"), answer.get("q_dyn_percent"), answer.get("rmse_v"), answer.get("max_abs_v"), answer.get("coverage_90"), answer.get("crank_mae_v"),
                           len(answer.get("cranks") or ()), mixed.get("share_percent", answer.get("q_dyn_percent")), baseline.get("share_percent"), baseline.get("crank_mae_v"))]


def verdict(answer):
    fit, evidence = answer.get("fit") or {}, answer.get("evidence") or {}
    rmse = [((fit.get(which) or {}).get("holdout") or {}).get("rmse_v") for which in ("base", "extended")]
    both = evidence.get("base"), evidence.get("extended")
    return "verdict", [(answer["verdict"], answer.get("mechanism"), answer.get("probability"), None if None in both else both[1] - both[0], answer.get("summary"), *rmse)]


def mechanisms(answer):
    """Every family that the answer gives a probability: the verdict's first, then those of effects that were taken."""
    found, effects = {}, {}
    if answer.get("mechanism"):
        found[answer["mechanism"]] = answer.get("probability")
    for one in answer.get("effects") or ():
        found.setdefault(one["mechanism"], one.get("probability"))
        effects.setdefault(one["mechanism"], []).append(one["id"])
    return "family", [(name, found[name], ",".join(effects.get(name, ()))) for name in sorted(found)]


def candidates(answer):
    return "candidate", [(one["id"], one["mechanism"], one.get("evidence"), one.get("probability"), one.get("rejected_because")) for one in answer.get("candidates") or ()]


def scores(answer):
    lines = []
    for one in answer["windows"]:
        model, baseline = one["model"], one["baseline"]
        lines.append((one["start_s"], ",".join(one["effects"]), one["window_quality"], model["share_percent"], model["current_share_percent"], model["voltage_share_percent"], model["crank_mae_v"],
                      baseline["share_percent"], baseline["crank_mae_v"]))
    return "score", lines
