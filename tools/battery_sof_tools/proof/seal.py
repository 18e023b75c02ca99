"""Seals a set of cases: draws their strengths, keeps their labels, and publishes the labels' digest."""

import collections
import json
import os
import sys

from ..files import append, digest, finished, lines_of
from . import levels, strength
from .programs import Failure, Programs, Workplace

KEPT = ("name", "level", "family", "id", "seed", "scale", "duration_s", "z", "z_whole", "z_wanted", "z_short", "bias", "biased",
        "absorbed", "ratio", "as_wanted")


def seal(build, secret, share, out, most_porous=None, duration_s=None, only=None, jobs=2):
    """Writes plan, labels.jsonl and seal.json; goes on where it was cut off."""
    os.makedirs(out, exist_ok=True)
    settings = {"frozen_commit": secret, "share": share, "most_porous": most_porous, "duration_s": duration_s, "only": only}
    begun = os.path.join(out, "begun.jsonl")
    known = lines_of(begun)
    if known and known[0] != settings:
        raise SystemExit(f"{out} holds another seal ({known[0]}); take an empty folder")
    if not known:
        append(begun, settings)
    cases = levels.plan(secret, share, most_porous, duration_s, only)
    done = {one["name"]: one for one in known[1:]}
    for label in finished(jobs, labelled, [(build, case) for case in cases if case["name"] not in done], "sealed"):
        append(begun, label)
        done[label["name"]] = label
    labels = [done[case["name"]] for case in cases]
    with open(os.path.join(out, "labels.jsonl"), "w") as f:
        f.writelines(json.dumps(label, sort_keys=True) + "\n" for label in labels)
    with open(os.path.join(out, "plan"), "w") as f:
        f.writelines(label["name"] + "\n" for label in labels)
    said = dict(settings, cases=len(labels), levels=dict(sorted(collections.Counter(one["level"] for one in labels).items())),
                labels_sha256=digest(os.path.join(out, "labels.jsonl")))
    with open(os.path.join(out, "seal.json"), "w") as f:
        f.write(json.dumps(said, indent=2) + "\n")
    os.remove(begun)
    print(json.dumps(said, indent=2))
    for label in labels:
        if "failed" in label:
            print("not drawn:", label["name"], label["failed"], file=sys.stderr)


def labelled(build, case):
    """The label of a case: strength found, then what the generator says of it as it will be shown."""
    programs = Programs(build)
    try:
        case = strength.with_strength(programs, case)
        with Workplace() as folder:
            _, label = programs.draw(case, folder)
    except Failure as failure:
        return dict({key: case[key] for key in KEPT if key in case}, failed=str(failure))
    kept = {key: case[key] for key in KEPT if key in case}
    kept.update(structure=label["structure"], strength=six_digits(label["strength"]), expected=label["expected"],
                soc_at_end=strength.rounded(label["truth"]["soc_at_end"], 6))
    if "regime_from_s" in label:
        kept["regime_from_s"] = label["regime_from_s"]
    return kept


def six_digits(strength_of):
    """Numbers so that another machine's last bit changes no digest."""
    return {key: strength.rounded(value, 6) if isinstance(value, float) else value for key, value in strength_of.items()}


def opened(folder):
    """The labels, once their digest is that of the seal."""
    with open(os.path.join(folder, "seal.json")) as f:
        said = json.load(f)
    path = os.path.join(folder, "labels.jsonl")
    if digest(path) != said["labels_sha256"]:
        raise SystemExit(f"{path} is not what was sealed: digest {digest(path)}, seal.json says {said['labels_sha256']}")
    return said, lines_of(path)
