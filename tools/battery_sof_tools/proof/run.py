"""Shows the recordings of a seal to `sof diagnose` and keeps what it answers.

The diagnosing process is given one file of a neutral name in a folder of its own: no label, no family, no seed. All answers are
written down and hashed before a scorer opens the labels; only then the models are fitted that are reported the truth (--given).
"""

import json
import math
import os
import sys

from ..files import append, digest, finished, lines_of
from .levels import SHORT_S
from .programs import Failure, Programs, Workplace
from .seal import opened

ANSWERS, TOLD = "answers.jsonl", "told.jsonl"
TOLD_LEVELS = ("C1", "C4", "X1")
SAME = 1e-5  # relative: strengths are sealed with six digits


def run(build, sealed, out, jobs=2, with_truth=True):
    """Writes answers.jsonl, answers.sha256 and reported.jsonl; goes on where it was cut off."""
    os.makedirs(out, exist_ok=True)
    said, labels = opened(sealed)
    labels = [label for label in labels if "failed" not in label]
    require_same(out, {"seal": said, "product_sha256": Programs(build).product()})
    complete(build, labels, out, ANSWERS, answered, jobs, "diagnosed")
    written = digest(os.path.join(out, ANSWERS))
    with open(os.path.join(out, "answers.sha256"), "w") as f:
        f.write(written + "\n")
    print(f"answers: {len(labels)}, SHA-256 {written}")
    if not with_truth:
        return
    if not Programs(build).knows_given():
        print("sof diagnose has no --given: no models that are reported the truth", file=sys.stderr)
        return
    known = [label for label in labels if truths_to_tell(label)]
    complete(build, known, out, TOLD, told, jobs, "fitted with the truth reported")


def require_same(out, asked):
    """Answers of two programs or to two seals do not mix."""
    path = os.path.join(out, "asked.json")
    if os.path.exists(path):
        with open(path) as f:
            if json.load(f) != asked:
                raise SystemExit(f"{out} holds answers of another build of sof or to another seal; take an empty folder")
        return
    with open(path, "w") as f:
        f.write(json.dumps(asked, indent=2) + "\n")


def complete(build, labels, out, name, work, jobs, what):
    path = os.path.join(out, name)
    done = {one["name"]: one for one in lines_of(path)}
    for result in finished(jobs, work, [(build, label) for label in labels if label["name"] not in done], what):
        append(path, result)
        done[result["name"]] = result
    ordered = sorted(done.values(), key=lambda one: one["name"])
    with open(path + ".new", "w") as f:
        f.writelines(json.dumps(one, sort_keys=True) + "\n" for one in ordered)
    os.replace(path + ".new", path)


def windows(label):
    """Parts of the recording that are shown, by name: the end [s], or None for all of it."""
    shown = {"whole": None}
    if label["level"] == "C3":
        shown["short"] = SHORT_S
    elif label["level"] == "C5":
        shown["short"] = label["regime_from_s"]
    return shown


def answered(build, label):
    programs = Programs(build)
    try:
        with Workplace() as folder:
            recording = drawn_again(programs, label, folder)
            return {"name": label["name"],
                    "answers": {name: programs.diagnose(recording, to_s) for name, to_s in windows(label).items()}}
    except Failure as failure:
        return {"name": label["name"], "failed": str(failure)}


def truths_to_tell(label):
    """The true ids, where an effect was added that the catalogue has."""
    return label["expected"]["effects"] if label["level"] in TOLD_LEVELS else []


def told(build, label):
    programs = Programs(build)
    try:
        with Workplace() as folder:
            recording = drawn_again(programs, label, folder)
            return {"name": label["name"], "answer": programs.diagnose(recording, given=truths_to_tell(label))}
    except Failure as failure:
        return {"name": label["name"], "failed": str(failure)}


def drawn_again(programs, label, folder):
    """The recording behind a label; refused if the generator now draws another case."""
    recording, now = programs.draw(label, folder)
    os.remove(os.path.join(folder, "label.json"))
    for key, value in label["strength"].items():
        other = now["strength"].get(key)
        same = math.isclose(value, other, rel_tol=SAME) if isinstance(value, float) and isinstance(other, (int, float)) else value == other
        if not same:
            raise Failure(f"the generator draws {key} = {other}, sealed was {value}")
    if not math.isclose(label["soc_at_end"], now["truth"]["soc_at_end"], rel_tol=SAME):
        raise Failure("the generator draws another drive than was sealed")
    if now["expected"] != label["expected"]:
        raise Failure("the generator expects something else of this case than was sealed")
    return recording
