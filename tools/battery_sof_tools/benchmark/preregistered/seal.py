"""Seals a set of cases (draws their strengths, keeps their labels, publishes the labels' digest), and shows a sealed set to `sof diagnose`.

The diagnosing process is given one file of a neutral name in a folder of its own: no label, no mechanism, no seed. All answers are
written down and hashed before a scorer opens the labels; only then the models are fitted that are reported the truth (--given).
"""

import collections
import contextlib
import functools
import json
import math
import os
import sys

from ...files import digest, lines_of, read_json, read_text, require_digest, require_same, write_text
from ...sof import Failure, product_digest, program
from .. import answers
from ..generator import Generator
from ..runner import ANSWERS, complete
from . import judged, levels, strength

KEPT = ("name", "level", "family", "id", "seed", "scale", "duration_s", "z", "z_whole", "z_wanted", "z_short", "bias", "biased",
        "absorbed", "raised", "bias_in_errors", "ratio", "as_wanted")
BEGUN, SETTINGS, LABELS, SEAL, TOLD = "begun.jsonl", "settings.json", "labels.jsonl", "seal.json", "told.jsonl"
TOLD_LEVELS = ("C1", "C4", "X1")
SAME = 1e-5  # relative: strengths are sealed with six digits
PATIENCE_S = 600.0  # of one diagnosis


def write_lines(path, rows):
    write_text(path, "".join(json.dumps(row, sort_keys=True) + "\n" for row in rows))


def seal(build, secret, share, out, max_porous=None, duration_s=None, only=None, jobs=2):
    """Writes plan, labels.jsonl and seal.json; goes on where it was cut off."""
    os.makedirs(out, exist_ok=True)
    settings = {"frozen_commit": secret, "share": share, "max_porous": max_porous, "duration_s": duration_s, "only": only}
    require_same(os.path.join(out, SETTINGS), settings, "another seal")
    cases = levels.plan(secret, share, max_porous, duration_s, only)
    done = complete(os.path.join(out, BEGUN), functools.partial(labelled, Generator(build)), cases, jobs, "sealed", timed=False)
    labels = [done[case["name"]] for case in cases]
    write_lines(os.path.join(out, LABELS), labels)
    write_text(os.path.join(out, "plan"), "".join(label["name"] + "\n" for label in labels))
    said = dict(settings, cases=len(labels), levels=dict(sorted(collections.Counter(one["level"] for one in labels).items())),
                labels_sha256=digest(os.path.join(out, LABELS)))
    write_text(os.path.join(out, SEAL), json.dumps(said, indent=2) + "\n")
    for name in (BEGUN, SETTINGS):
        os.remove(os.path.join(out, name))
    print(json.dumps(said, indent=2))
    for label in labels:
        if "failed" in label:
            print("not drawn:", label["name"], label["failed"], file=sys.stderr)


def labelled(generator, case):
    """The label of a case: strength found, then what the generator says of it as it will be shown."""
    try:
        case = strength.with_strength(generator, case)
        with generator.drawn(case) as (label, _):
            shown = {key: label[key] for key in ("structure", "strength", "expected", "regime_from_s") if key in label}
    except Failure as failure:
        shown = {"failed": str(failure)}
    else:
        # Six digits, so that another machine's last bit changes no digest.
        shown["strength"] = {key: strength.rounded(value, 6) if isinstance(value, float) else value for key, value in label["strength"].items()}
        shown["soc_at_end"] = strength.rounded(label["truth"]["soc_at_end"], 6)
    return {**{key: case[key] for key in KEPT if key in case}, **shown}


def opened(folder):
    """The labels, once their digest is that of the seal."""
    said, path = read_json(os.path.join(folder, SEAL)), os.path.join(folder, LABELS)
    require_digest(path, said["labels_sha256"], SEAL, path)
    return said, lines_of(path)


def run(build, sealed, out, jobs=2, with_truth=True):
    """Writes answers.jsonl, answers.sha256 and reported.jsonl; goes on where it was cut off."""
    os.makedirs(out, exist_ok=True)
    said, labels = opened(sealed)
    labels, sof, generator = [label for label in labels if "failed" not in label], program(build, "sof"), Generator(build)
    require_same(os.path.join(out, "asked.json"), {"seal": said, "product_sha256": product_digest(sof)}, "answers of another build of sof or to another seal")
    path = os.path.join(out, ANSWERS)
    rows = complete(path, functools.partial(answered, generator, sof), labels, jobs, "diagnosed", timed=False)
    write_lines(path, sorted(rows.values(), key=lambda row: row["name"]))
    write_text(os.path.join(out, "answers.sha256"), digest(path) + "\n")
    print(f"answers: {len(labels)}, SHA-256 {digest(path)}")
    if not with_truth:
        return
    known = [label for label in labels if truths_to_tell(label)]
    complete(os.path.join(out, TOLD), functools.partial(told, generator, sof), known, jobs, "fitted with the truth reported", timed=False)


def windows(label):
    """Parts of the recording that are shown, by name: options of sof."""
    ends = {"C3": levels.SHORT_S, "C6": levels.SHORT_S, "C5": label.get("regime_from_s")}
    return {"whole": (), **({"short": ("--to", f"{ends[label['level']]:g}")} if label["level"] in ends else {})}


def answered(generator, sof, label):
    with drawn_again(generator, label) as recording:
        return {"answers": {name: answers.asked(sof, recording, *options, patience_s=PATIENCE_S) for name, options in windows(label).items()}}


def truths_to_tell(label):
    """The true ids, where an effect was added that the catalogue has."""
    return label["expected"]["effects"] if label["level"] in TOLD_LEVELS else []


def told(generator, sof, label):
    with drawn_again(generator, label) as recording:
        return {"answer": answers.asked(sof, recording, "--given", ",".join(truths_to_tell(label)), patience_s=PATIENCE_S)}


@contextlib.contextmanager
def drawn_again(generator, label):
    """The recording behind a label; refused if the generator now draws another case."""
    with generator.drawn(label) as (now, recording):
        for key, value in label["strength"].items():
            other = now["strength"].get(key)
            same = math.isclose(value, other, rel_tol=SAME) if isinstance(value, float) and isinstance(other, (int, float)) else value == other
            if not same:
                raise Failure(f"the generator draws {key} = {other}, sealed was {value}")
        if not math.isclose(label["soc_at_end"], now["truth"]["soc_at_end"], rel_tol=SAME):
            raise Failure("the generator draws another drive than was sealed")
        if now["expected"] != label["expected"]:
            raise Failure("the generator expects something else of this case than was sealed")
        yield recording


def cases_of(sealed, results, catalogue):
    """What the seal says, judged cases, and what could not be judged; nothing is opened unless both digests are right."""
    path = os.path.join(results, ANSWERS)
    require_digest(path, read_text(os.path.join(results, "answers.sha256")).strip(), "answers.sha256", path)
    said, labels = opened(sealed)
    rows = {one["name"]: one for one in lines_of(path)}
    told_truth = {one["name"]: one.get("answer") for one in lines_of(os.path.join(results, TOLD))}
    cases, failed = [], []
    for label in labels:
        row = rows.get(label["name"], {"failed": label.get("failed", "no answer")})
        if "failed" in row:
            failed.append(f"{label['name']} {label['level']} {label.get('mechanism', label.get('family'))} {label['id']}: {row['failed']}")
        else:
            cases.append(judged.Case(label, row["answers"], told_truth.get(label["name"]), catalogue))
    return said, cases, failed
