"""From what the steps of a recording said to rows of the tables in schema.py."""

import json
import os

from .plan import MEANT, STEPS


def of_recording(entry, told):
    """Rows by table. told: the steps' files by name."""
    key = entry["key"]
    answers = {step: one["answer"] for step, one in told.items() if one["answer"]}
    made = {"recording": [recording(entry, told, answers.get("check") or {})], "step": [(key, s, told[s]["exit"], told[s]["reason"]) for s in STEPS if s in told],
            "cost": [(key, s, told[s]["cost"]["wall_s"], told[s]["cost"]["cpu_s"]) for s in STEPS if s in told and told[s]["cost"]]}
    for step in STEPS:
        for table, line in rows_of(step, answers[step]) if step in answers else ():
            made.setdefault(table, []).append((key, *line))
    return made


def outcome(told):
    """(done, partly or failed, and why): the first step that failed gives the reason; a step that is not needed or follows another's failure does not."""
    wanted = {step: told[step] for step in STEPS if step in told and step != "convert"}
    bad = [step for step, one in wanted.items() if one["answer"] is None and not (step in ("change", "score") and one["exit"] is None)]
    if not bad:
        return "done", None
    return ("failed" if len(bad) == len([step for step in wanted if step not in ("change", "score")]) else "partly"), f"{bad[0]}: {wanted[bad[0]]['reason']}"


def recording(entry, told, check):
    source, temperature = check.get("source") or {}, check.get("temperature_range_c") or (None, None)
    options = json.dumps({name: entry[name] for name in MEANT if entry.get(name)}, sort_keys=True)
    return (entry["key"], os.path.basename(entry["path"]), entry["path"], entry["sha256"], entry["bytes"], entry["battery"], entry.get("vehicle_type"), entry.get("age_years"), options,
            *outcome(told), check.get("samples"), check.get("from_s"), check.get("to_s"), check.get("median_interval_s"), *temperature, source.get("seen"), source.get("share"))


def parameters(source, effects, some):
    for one in some or ():
        yield "parameter", (source, ",".join(effects or ()), one["name"], one["value"], one.get("std_error", one.get("std")), one.get("unit"), one.get("determined"), one.get("at_bound"))


def rows_of(step, answer):
    """(table, row without the recording) of all that a step's answer holds."""
    ends = answer.get("window") or {}
    if step == "check":
        for one in answer["findings"]:
            yield "finding", (one["id"], one["severity"], one.get("value"), one.get("unit"), one.get("samples"), one["what"])
    elif step == "identify":
        yield "window", (ends.get("from_s"), ends.get("to_s"), answer.get("samples"), ",".join(answer.get("effects") or ()), answer.get("status"), answer.get("window_quality"),
                         answer.get("q_dyn_percent"), answer.get("rmse_v"))
        yield from parameters(step, answer.get("effects"), answer.get("parameters"))
    elif step == "predict":
        mixed, baseline = answer.get("mixed") or {}, answer.get("baseline") or {}
        yield "prediction", (ends.get("from_s"), ends.get("to_s"), answer.get("q_dyn_percent"), answer.get("rmse_v"), answer.get("max_abs_v"), answer.get("coverage_90"), answer.get("crank_mae_v"),
                             len(answer.get("cranks") or ()), mixed.get("share_percent", answer.get("q_dyn_percent")), baseline.get("share_percent"), baseline.get("crank_mae_v"))
    elif step == "diagnose":
        yield from of_diagnosis(answer)
    elif step == "change":
        first = (answer["changes"] or [None])[0]
        low, high = first["interval"] if first else (None, None)
        told = (first["id"], first["mechanism"], first["now"], first["unit"], low, high, first["probability"], ",".join(first["indistinguishable"])) if first else (None,) * 8
        yield "change", (",".join(answer["references"]), answer["verdict"], *told, answer.get("summary"))
    elif step == "score":
        for one in answer["windows"]:
            model, baseline = one["model"], one["baseline"]
            yield "score", (one["start_s"], ",".join(one["effects"]), one["window_quality"], model["share_percent"], model["current_share_percent"], model["voltage_share_percent"],
                            model["crank_mae_v"], baseline["share_percent"], baseline["crank_mae_v"])
            yield from parameters(f"score {one['start_s']:.3f}", one["effects"], one["parameters"])


def of_diagnosis(answer):
    """A verdict, every mechanism that the answer gives a probability (the verdict's first, then those of effects that were taken), candidates, parameters."""
    fit, evidence, effects = answer.get("fit") or {}, answer.get("evidence") or {}, answer.get("effects") or ()
    rmse = [((fit.get(which) or {}).get("holdout") or {}).get("rmse_v") for which in ("base", "extended")]
    both = evidence.get("base"), evidence.get("extended")
    yield "verdict", (answer["verdict"], answer.get("mechanism"), answer.get("probability"), None if None in both else both[1] - both[0], answer.get("summary"), *rmse)
    found = {answer["mechanism"]: answer.get("probability")} if answer.get("mechanism") else {}
    for one in effects:
        found.setdefault(one["mechanism"], one.get("probability"))
    for name in sorted(found):
        yield "mechanism", (name, found[name], ",".join(one["id"] for one in effects if one["mechanism"] == name))
    for one in answer.get("candidates") or ():
        yield "candidate", (one["id"], one["mechanism"], one.get("evidence"), one.get("confidence"), one.get("rejected_because"))
    for one in effects:
        yield from parameters("diagnose", [one["id"]], one.get("parameters"))
