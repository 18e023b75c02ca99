"""The two programs the benchmark calls: `draw_case` makes a case, `sof diagnose` is asked about its recording."""

import json
import os
import shutil
import subprocess
import tempfile

from ..sof import RECORDING, Failure, call, diagnose, product_digest, program

LABEL = "label.json"
PATIENCE_S = 600.0  # of one diagnosis
METRICS = ("rmse_v", "q_dyn_percent", "crank_mae_v", "charge_bias_v", "charge_current_error_a", "max_abs_v")

# Labels of sealed cases keep the verdicts of the version that sealed them.
SEALED_WORDS = {"effect": "named", "mechanism": "unknown", "unexplained": "unknown"}


class Programs:
    def __init__(self, build):
        self.draw_case, self.sof = program(build, "draw_case"), program(build, "sof")

    def product(self):
        """SHA-256 over `sof` and the product's libraries."""
        return product_digest(self.sof)

    def knows_given(self):
        return "--given" in call([self.sof, "diagnose", "--help"])

    def draw(self, case, folder, quiet=False):
        """Draws a case into a folder: path of the recording, and the label. Scale 1 is the generator's own."""
        recording, label = os.path.join(folder, RECORDING), os.path.join(folder, LABEL)
        command = [self.draw_case, "--family", case["family"], "--seed", str(case["seed"]), "--out", recording, "--label", label]
        if case["id"] != "-":
            command += ["--id", case["id"]]
        if any(scale != 1.0 for scale in case["scale"]):
            command += ["--scale", ",".join(f"{scale:.6g}" for scale in case["scale"])]
        if case.get("duration_s"):
            command += ["--duration", f"{case['duration_s']:g}"]
        if quiet:
            command += ["--quiet"]
        told = subprocess.run(command, capture_output=True, text=True)
        if told.returncode:
            raise Failure(f"draw_case: {told.stderr.strip()[:300]}")
        with open(label) as f:
            return recording, json.load(f)

    def diagnose(self, recording, to_s=None, given=()):
        """What is scored of the answer to a recording that lies alone in a folder of its own, under a name that reports nothing."""
        options = ["--to", f"{to_s:g}"] if to_s else []
        options += ["--given", ",".join(given)] if given else []
        return essentials(diagnose(self.sof, recording, *options, patience_s=PATIENCE_S))


def essentials(diagnosis):
    """What is scored of an answer."""
    fit = diagnosis["fit"] or {}
    return {
        "verdict": SEALED_WORDS.get(diagnosis["verdict"], diagnosis["verdict"]),
        "effects": [{"id": e["id"], "mechanism": e.get("mechanism"), "probability": e.get("probability"), "confidence": e["confidence"],
                     "evidence": e.get("evidence"), "indistinguishable_from": e.get("indistinguishable_from", []),
                     "parameters": [{k: p.get(k) for k in ("name", "value", "lower", "upper", "at_bound")} for p in e["parameters"]]}
                    for e in diagnosis["effects"]],
        "candidates": [{k: c.get(k) for k in ("id", "evidence", "mechanism", "holdout_gain_percent", "rejected_because")}
                       for c in diagnosis["candidates"]],
        "holdout": {side: {m: fit[side]["holdout"].get(m) for m in METRICS} for side in ("base", "extended")} if fit else None,
        "hidden": [d["id"] for d in diagnosis["detection_limits"] if not d["visible"]],
        "mismatch": [[m["from_s"], m["to_s"], m["regime"], m["mean_error_v"]] for m in diagnosis["mismatch"]],
        "instrument": diagnosis["instrument"], "next_experiment": diagnosis["next_experiment"],
        "mechanism": diagnosis.get("mechanism"), "probability": diagnosis.get("probability")}


class Workplace:
    """A folder for one case's files, gone afterwards."""

    def __enter__(self):
        self.folder = tempfile.mkdtemp(prefix="proof_")
        return self.folder

    def __exit__(self, *_):
        shutil.rmtree(self.folder, ignore_errors=True)
