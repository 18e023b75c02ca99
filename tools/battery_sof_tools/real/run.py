"""Shows recordings with and without laws to `sof diagnose` and keeps one row a case."""

import os
import tempfile
import time

from .. import concealment, mechanisms, recordings
from ..files import append, lines_of, require_same
from ..sof import Failure, diagnose, product_digest
from . import laws, plan

ROWS, UNCHANGED = "rows.jsonl", "unchanged.jsonl"
PATIENCE_S = 300.0  # of one diagnosis


def essentials(answer):
    """What is kept of an answer."""
    fit = answer.get("fit") or {}
    holdout = {side: ((fit.get(side) or {}).get("holdout") or {}).get("rmse_v") for side in ("base", "extended")}
    return {"verdict": answer["verdict"], "mechanisms": mechanisms.mechanisms_of(answer, None),
            "effects": [one["id"] for one in answer["effects"]],
            "parts": [one["mechanism"] for one in answer["candidates"] if not one["rejected_because"]],
            "promised": {one["id"]: one["strength"] for one in answer["detection_limits"] if one["strength"] is not None},
            "limit_v": answer["relevance"]["limits"]["rmse_v"],
            "holdout_v": dict(holdout, ridge=(answer.get("baseline") or {}).get("rmse_v"))}


def in_folder(folder):
    """Names of the recordings of a folder that are written as draw_out_of_model writes them. SystemExit where there are none."""
    names = sorted(name[:-len(".csv")] for name in os.listdir(folder) if name.endswith(".csv")) if os.path.isdir(folder) else []
    if not names:
        raise SystemExit(f"{folder}: no folder of recordings, expected CSV files (time_s, current_a, voltage_v)")
    return names


class Bench:
    """Programs, the folder of recordings, and where results are kept.

    plain: the folder holds CSV files (time_s, current_a, voltage_v) under any names, in place of the recordings that were measured.
    """

    def __init__(self, sof, draw, data, out, plain=False):
        self.sof, self.draw, self.data, self.out, self.plain = sof, draw, data, out, plain
        self.loaded = (None, None)
        os.makedirs(out, exist_ok=True)
        require_same(os.path.join(out, "product.json"), product_digest(sof), "answers of another build of sof")
        self.unchanged = {row["recording"]: row["answer"] for row in lines_of(os.path.join(out, UNCHANGED))}

    def recording(self, name):
        """The stretch of a recording that is shown; its time begins at 0."""
        if self.loaded[0] != name:
            t, i, u = recordings.read(os.path.join(self.data, name + ".csv")) if self.plain else recordings.measured(self.data, name)
            count = plan.stretch(t)
            self.loaded = (name, laws.Beside(t[:count] - t[0], i[:count], u[:count]))
        return self.loaded[1]

    def told(self, t, i, u):
        with tempfile.TemporaryDirectory(prefix="real_") as folder:
            path = os.path.join(folder, "shown.csv")
            recordings.write(path, t, i, u)
            return essentials(diagnose(self.sof, path, patience_s=PATIENCE_S))

    def before(self, name):
        """The answer to the recording as it is. Failure where there was none: it is asked for once."""
        if name not in self.unchanged:
            beside = self.recording(name)
            try:
                self.unchanged[name] = self.told(beside.t, beside.i, beside.u)
            except Failure as failure:
                self.unchanged[name] = {"failed": str(failure)}
            append(os.path.join(self.out, UNCHANGED), {"recording": name, "answer": self.unchanged[name]})
        if "failed" in self.unchanged[name]:
            raise Failure("as it is: " + self.unchanged[name]["failed"])
        return self.unchanged[name]

    def case(self, case, forms):
        """A row: the case, what was put in, and the answer; or why there is none."""
        limit, beside = self.before(case["recording"])["limit_v"], self.recording(case["recording"])
        if case["kind"] == plan.ZERO:
            voltage, drawn = laws.neutral(beside.t, beside.i, beside.u, limit, case["seed"])
            return dict(case, drawn=drawn, answer=self.told(beside.t, beside.i, voltage))
        if "effect" in case:
            return self.promised(case)
        if case["kind"] == plan.INSTRUMENT and beside.t[-1] > plan.LONGEST_INSTRUMENT_S:
            return dict(case, not_drawn=[f"a law of an instrument takes at most {plan.LONGEST_INSTRUMENT_S:g} s"])
        drawn, current, voltage, why = self.law(case, forms, laws.PROMISED * limit)
        if drawn is None:
            return dict(case, not_drawn=why)
        return dict(case, drawn=drawn, answer=self.told(beside.t, current, voltage))

    def promised(self, case):
        """A row with an effect at the least strength that the answer to the unchanged recording calls enough."""
        strength, beside = self.before(case["recording"])["promised"].get(case["effect"]), self.recording(case["recording"])
        if strength is None:
            return dict(case, not_drawn=[f"{case['effect']} would be reported at no strength, or is reported"])
        instant = concealment.instant_of_throughput(beside.t, beside.i, plan.INSTANT_SHARE)
        current, voltage = concealment.changed(case["effect"], beside.t, beside.i, beside.u, strength, case["tau_s"], instant)
        return dict(case, drawn={"form": case["effect"], "strength": strength}, answer=self.told(beside.t, current, voltage))

    def law(self, case, forms, wanted):
        """The first form of the mechanism that shows as it should."""
        beside, why = self.recording(case["recording"]), []
        with tempfile.TemporaryDirectory(prefix="real_") as folder:
            path = os.path.join(folder, "measured.csv")
            recordings.write(path, beside.t, beside.i, beside.u)
            for form in plan.forms_in_turn(case, forms):
                try:
                    strength, shown, current, voltage = laws.with_strength(
                        self.draw, beside, path, case["kind"], form, case["seed"], wanted, folder)
                except Failure as failure:
                    why.append(str(failure))
                    continue
                drawn = {"form": form, "strength": strength, "visible_v": shown[0], "visible_held_v": shown[1], "wanted_v": wanted}
                return drawn, current, voltage, why
        return None, None, None, why


def run(bench, seed, forms, count, minutes, only=(), say=print, catalogue=None):
    """Goes through the plan until `count` cases are asked or `minutes` have passed; goes on where it was cut off.

    catalogue: its effects at promised strengths, in place of laws.
    """
    path, ends = os.path.join(bench.out, ROWS), time.monotonic() + 60.0 * minutes
    require_same(os.path.join(bench.out, "seed.json"), seed, "cases of another seed")
    done = {row["name"] for row in lines_of(path)}
    asked = sum("answer" in row for row in lines_of(path))
    names = in_folder(bench.data) if bench.plain else plan.MEASURED
    for case in plan.promised(seed, catalogue, only, names) if catalogue else plan.rounds(seed, forms, only):
        if asked >= count or time.monotonic() > ends:
            return
        if case["name"] in done:
            continue
        began = time.monotonic()
        try:
            row = bench.case(case, forms)
        except Failure as failure:
            row = dict(case, failed=str(failure))
        append(path, dict(row, seconds=time.monotonic() - began))
        asked += "answer" in row
        answer = row.get("answer", {})
        say(case["name"], row.get("drawn", {}).get("form", ""), answer.get("verdict", "no answer"), *answer.get("mechanisms", {}))
