"""What a fleet's prior is worth on a battery that it has not seen: next-window scores with it and without.

For every battery PRIORS.yaml is made without it, and its recordings are scored again. share: as in score_next_window. blow-ups: windows whose error (100 % - share) is above
three times the median error without a prior. rank: Spearman's correlation of the window's window quality with the share of the next one, inside the battery.
"""

import collections
import os
import tempfile

import numpy as np
from scipy.stats import spearmanr

from ..files import finished, write_json
from ..tables import grouped, table
from . import database, plan, priors, scoring, steps

FAR = 3.0  # times the median error


def scored(folder, battery, entries, setting):
    """(battery, {start and recording: window}) of a battery's recordings under the prior of the others, where there is one."""
    found = {}
    with tempfile.TemporaryDirectory(prefix="sof_fleet_") as temporary:
        path = os.path.join(temporary, "priors.yaml")
        try:
            priors.write(folder, path, [battery])
        except SystemExit:
            return battery, found
        for entry in entries:
            answer = scoring.answer(steps.Recording(folder, entry, dict(setting, priors=path)), setting["patience_s"])[1] or {"windows": []}
            found.update({(entry["key"], round(one["start_s"], 3)): (one["model"]["share_percent"], one["window_quality"], one["model"]["crank_mae_v"]) for one in answer["windows"]})
    return battery, found


def before(base):
    """The same of the scores in the database, by battery, and those of baseline."""
    found, baseline = collections.defaultdict(dict), {}
    for row in base.execute("SELECT s.*, r.battery FROM score s JOIN recording r USING (recording)"):
        place = row["recording"], round(row["start_s"], 3)
        found[row["battery"]][place] = row["share_percent"], row["window_quality"], row["crank_mae_v"]
        baseline[place] = row["baseline_share_percent"]
    return found, baseline


def told(windows, median_error):
    """Median share, quartiles, blow-ups and rank of windows."""
    share = np.array([one[0] for one in windows], float)
    rank = spearmanr([one[1] for one in windows], share).statistic if len(share) > 4 else np.nan
    cranks = [1e3 * one[2] for one in windows if one[2] is not None]
    return [f"{np.median(share):.1f} ({np.percentile(share, 25):.0f} {np.percentile(share, 75):.0f})", f"{np.mean(cranks):.0f}" if cranks else "-",
            str(int(np.sum(100.0 - share > FAR * median_error))), "-" if np.isnan(rank) else f"{rank:+.2f}"]


def rows(old, new, baseline):
    """One row a battery, and one of all, over windows that were scored both ways."""
    lines, everything = [], []
    for battery in sorted(new):
        common = [place for place in sorted(new[battery]) if place in old[battery] and None not in (new[battery][place][0], old[battery][place][0])]
        if common:
            everything += [(old[battery][place], new[battery][place], baseline[place]) for place in common]
            lines.append(line(battery, everything[-len(common):]))
    return lines + ([line("all", everything)] if len(lines) > 1 else [])


def line(name, windows):
    median_error = np.median([100.0 - one[0][0] for one in windows])
    straight = [one[2] for one in windows if one[2] is not None]
    return [name, str(len(windows)), f"{np.median(straight):.1f}" if straight else "-", *told([one[0] for one in windows], median_error), *told([one[1] for one in windows], median_error)]


def compare(folder, jobs, sof=None):
    """Lines of a Markdown table; every window is kept in leave_one_out.json."""
    kept, recordings = plan.load(folder)
    setting = plan.setting_of(folder, kept)
    setting["sof"] = sof or setting["sof"]
    old, baseline = before(database.open_read(folder))
    by_battery = grouped([entry for entry in recordings if entry["battery"] in old], lambda entry: entry["battery"])
    todo = [(folder, battery, entries, setting) for battery, entries in by_battery.items()]
    new = dict(finished(jobs, scored, todo, "battery"))
    write_json(os.path.join(folder, "leave_one_out.json"), {battery: [[*place, *value] for place, value in sorted(found.items())] for battery, found in new.items()})
    head = ["battery", "windows", "baseline: share [%]", "no prior: share [%]", "cranks [mV]", "blow-ups", "rank", "prior of the others: share [%]", "cranks [mV]", "blow-ups", "rank"]
    return table(head, rows(old, new, baseline))
