"""Which cases are drawn, and where what belongs to them lies."""

import collections
import hashlib
import os
import random
import subprocess

KINDS = ("null", "imperfect_null", "other_form")
RECORDINGS, LABELS, ANSWERS, RIDGES = "recordings", "labels", "answers", "ridges"


def path(out, folder, name, ending):
    return os.path.join(out, folder, f"{name}.{ending}")


def seed_of(*parts):
    """63 bits of its own for every case."""
    return int.from_bytes(hashlib.sha256("/".join(map(str, parts)).encode()).digest()[:8], "big") >> 1


def forms_of(draw):
    """{mechanism: [form, ...]} of other forms, as `draw_out_of_model --list` names them."""
    told = subprocess.run([draw, "--list"], capture_output=True, text=True, check=True)
    forms = collections.defaultdict(list)
    for line in told.stdout.splitlines():
        kind, mechanism, form = line.split()
        if kind == "other_form":
            forms[mechanism].append(form)
    return dict(forms)


def plan(wanted, seed, forms, **given):
    """Cases under opaque names, in an order of the seed. Mechanisms take turns, and within a mechanism its forms.

    wanted: number by kind.  forms: {mechanism: [form, ...]}.  given: rate [Hz] or duration [s] of all, in place of the seeds' choice.
    """
    cases = []
    for kind in KINDS:
        for number in range(wanted.get(kind, 0)):
            case = {"kind": kind, "seed": seed_of(seed, kind, number), **given}
            if kind == "other_form":
                mechanism = sorted(forms)[number % len(forms)]
                case.update(mechanism=mechanism, form=forms[mechanism][number // len(forms) % len(forms[mechanism])])
            cases.append(case)
    random.Random(seed).shuffle(cases)
    return [dict(case, name=f"case_{k:04d}") for k, case in enumerate(cases, 1)]


def drawn(draw, out, case):
    """Draws a case unless it is there; what went wrong, or None."""
    recording, label = path(out, RECORDINGS, case["name"], "csv"), path(out, LABELS, case["name"], "json")
    if os.path.exists(recording) and os.path.exists(label):
        return None
    command = [draw, "--kind", case["kind"], "--seed", str(case["seed"]), "--out", recording, "--label", label]
    command += [word for key in ("mechanism", "form", "rate", "duration") if key in case for word in ("--" + key, str(case[key]))]
    told = subprocess.run(command, capture_output=True, text=True)
    return None if told.returncode == 0 else f"{case['name']}: {told.stderr.strip()[:300]}"
