"""The page of a fleet: one HTML file that needs no network, in the style of the diagnosis page. Here is what it shows; page.html has how."""

import os

import jinja2
import numpy as np

from ..files import ROOT, read_text
from ..tables import grouped
from . import database, discoveries, outliers, page_plots, plan

HERE = os.path.dirname(os.path.abspath(__file__))
MAX_ROWS = 3000  # of recordings on the page; the database has all
MIN_POINTS = 3  # of a parameter, to be drawn
WORDS = {"acceptance": "charge acceptance", "side_reactions": "side reactions", "acid": "acid transport", "open_circuit": "open-circuit voltage", "structure": "the circuit's structure",
         "ageing": "ageing or warming", "instrument": "the instruments"}
MEANT = {"acceptance": "charging is limited by how fast the battery takes charge up", "side_reactions": "part of the charging current leaves no charge in the battery",
         "acid": "acid moves slowly between pores, plates and separator", "open_circuit": "open-circuit voltage and resistance depend on the charge and on its history",
         "structure": "resistance, double layer or kinetics differ from the base circuit's", "ageing": "the battery's parameters change with time or temperature",
         "instrument": "the sensors or the wiring explain it"}
VERDICTS = {"no_mismatch": "no mismatch", "effect": "one effect is missing", "several": "several effects", "ambiguous": "one of a few", "mechanism": "a mechanism without an equation", "unexplained": "unknown physics",
            "sensor_fault": "the instruments", "insufficient_data": "not enough to judge"}
UNITS = {"ohm": (1e3, "mOhm"), "1": (1e2, "%")}  # as a reader expects a strength
HAS_PAGE = "EXISTS (SELECT 1 FROM file f WHERE f.recording = r.recording AND f.name = 'page.html') AS has_page"


def words(mechanism):
    return WORDS.get(mechanism, mechanism)


def count(number, one, many):
    return f"{number} {one if number == 1 else many}"


def recordings_of(base):
    """Rows of recordings with their verdict."""
    return base.execute(f"SELECT r.*, v.verdict, v.mechanism, v.probability, v.summary, {HAS_PAGE} FROM recording r LEFT JOIN verdict v USING (recording) "
                        "ORDER BY r.battery, r.name, recording").fetchall()


def changes_of(base):
    """How many recordings of how many batteries were compared with the first one, and rows of those that have changed."""
    compared = base.execute("SELECT count(*), count(DISTINCT r.battery) FROM change c JOIN recording r USING (recording) WHERE c.verdict != 'insufficient_data'").fetchone()
    return compared, base.execute(f"SELECT c.*, r.name, r.battery, {HAS_PAGE} FROM change c JOIN recording r USING (recording) WHERE c.verdict = 'changed' "
                                  "ORDER BY c.mechanism, c.id, c.probability DESC, r.battery, r.name").fetchall()


def parameters_of(base):
    """Figures of parameters over age and temperature where they are known, and what no recording has of the two."""
    rows = base.execute("SELECT p.name, p.value, p.std, p.unit, r.age_years, r.temperature_min_c, r.temperature_max_c, r.vehicle_type, r.battery FROM parameter p "
                        f"JOIN recording r USING (recording) WHERE {outliers.OF_RECORDING} ORDER BY r.battery").fetchall()
    drawn = [page_plots.parameter(name, some) for name, some in grouped(rows, lambda row: row["name"]).items() if len(some) >= MIN_POINTS]
    lacking = {"age_years": "No battery has an age (age_years in the list of recordings).", "temperature_min_c": "No recording has a temperature."}
    return sum(drawn[:12], []), " ".join(text for column, text in lacking.items() if all(row[column] is None for row in rows))


def predictions_of(base):
    """Windows that were predicted, quartiles of model and baseline, and the share of samples inside their intervals."""
    rows = base.execute("SELECT share_percent, baseline_share_percent, crank_mae_v, baseline_crank_mae_v FROM score").fetchall()

    def quartiles(key, scale=1.0):
        values = [scale * row[key] for row in rows if row[key] is not None]
        return "" if not values else "{1:.1f} ({0:.1f} to {2:.1f})".format(*np.percentile(values, [25, 50, 75]))

    who = (("model", ""), ("baseline (a line fit and past events)", "baseline_"))
    within = [row[0] for row in base.execute("SELECT coverage_90 FROM prediction WHERE coverage_90 IS NOT NULL")]
    return len(rows), [(name, quartiles(of + "share_percent"), quartiles(of + "crank_mae_v", 1e3)) for name, of in who], 100.0 * np.mean(within) if within else None


def nulls_of(folder):
    """Gains of recordings that lack nothing, or None."""
    if not folder:
        return None
    values = [row[4] for row in discoveries.gains(database.open_read(folder))]
    if not values:
        raise SystemExit(f"{folder}: no recording was judged there")
    return values


def headline(found, told, held):
    """One sentence: what the fleet lacks. held: the share of false ones is."""
    if not found:
        return "No battery of this fleet was judged."
    standing = [one for one in found if one.found]
    if not standing:
        return f"None of {count(len(found), 'battery', 'batteries')} lacks a kind of physics that stands among so many."
    first = told[0]
    lack = "lack" if held else "are reported to lack"
    return (f"{len(standing)} of {count(len(found), 'battery', 'batteries')} {lack} a kind of physics that the base circuit does not have; the most frequent one is "
            f"{words(first[0])} ({len(first[2])}).")


def make(folder, nulls=None):
    """HTML of a fleet's page. nulls: folder of a fleet of recordings that lack nothing, or None."""
    base = database.open_read(folder)
    null_gains = nulls_of(nulls)
    found = discoveries.batteries(base, null_gains)
    told = discoveries.mechanisms(found)
    recordings, standing = recordings_of(base), {one.name for one in found if one.found}

    def one(query):
        return base.execute(query).fetchone()[0] or 0

    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    environment.filters.update(words=words, number=lambda value, digits=4: "" if value is None else f"{value:.{digits}g}")
    return environment.from_string(read_text(os.path.join(HERE, "page.html"))).render(
        count=count, MEANT=MEANT, VERDICTS=VERDICTS, UNITS=UNITS, MAX_ROWS=MAX_ROWS, LEAST=outliers.LEAST, results=lambda key: plan.results("", key), separator=os.sep, dirname=os.path.dirname,
        style=read_text(os.path.join(ROOT, "src", "report", "page", "page.css")) + read_text(os.path.join(HERE, "page.css")), script=read_text(os.path.join(HERE, "page.js")),
        title="Fleet of " + count(one("SELECT count(DISTINCT battery) FROM recording"), "battery", "batteries"), name=os.path.basename(os.path.abspath(folder)),
        headline=headline(found, told, nulls is not None), judged=len(found), nulls=null_gains, told=told, by_battery=grouped(recordings, lambda row: row["battery"]),
        recordings=sorted(recordings, key=lambda row: (row["outcome"] == "done", row["battery"] not in standing, row["battery"])),
        unreadable=one("SELECT count(*) FROM recording WHERE outcome = 'failed'"), hours=one("SELECT sum(to_s - from_s) FROM recording") / 3600.0,
        changes=changes_of(base), deviating=outliers.outliers(base), parameters=parameters_of(base), plot=page_plots, predictions=predictions_of(base))
