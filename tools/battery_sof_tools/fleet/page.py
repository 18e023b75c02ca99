"""The page of a fleet: one HTML file that needs no network, in the style of the diagnosis page. Its sections are made from the database or what was counted in it."""

import html
import os

import numpy as np

from ..files import ROOT, read_text
from ..tables import grouped
from . import database, outliers, discoveries, page_plots, plan

HERE = os.path.dirname(os.path.abspath(__file__))
MAX_ROWS = 3000  # of recordings on the page; the database has all
MIN_POINTS = 3  # of a parameter, to be drawn
WORDS = {"acceptance": "charge acceptance", "side_reactions": "side reactions", "acid": "acid transport", "open_circuit": "open-circuit voltage", "structure": "the circuit's structure",
         "ageing": "ageing or warming", "instrument": "the instruments"}
MEANT = {"acceptance": "charging is limited by how fast the battery takes charge up", "side_reactions": "part of the charging current leaves no charge in the battery",
         "acid": "acid moves slowly between pores, plates and separator", "open_circuit": "the open-circuit voltage moves with the charge and the way it came there",
         "structure": "resistance, double layer or kinetics differ from the base circuit's", "ageing": "the battery's parameters change with time or temperature",
         "instrument": "the sensors or the wiring explain it"}
VERDICTS = {"no_mismatch": "no mismatch", "effect": "one effect is missing", "several": "several effects", "ambiguous": "one of a few", "mechanism": "a mechanism without an equation", "unexplained": "unknown physics",
            "sensor_fault": "the instruments", "insufficient_data": "not enough to judge"}


def words(mechanism):
    return WORDS.get(mechanism, mechanism)


def count(number, one, many):
    return f"{number} {one if number == 1 else many}"


def number(value, digits=4):
    return "" if value is None else f"{value:.{digits}g}"


def table(head, lines, numbers=()):
    """Cells are HTML. numbers: columns that stand at the right."""
    def cells(kind, row):
        return "".join(f'<{kind}{" class=number" if k in numbers else ""}>{cell}</{kind}>' for k, cell in enumerate(row))
    body = "".join(f"<tr>{cells('td', row)}</tr>\n" for row in lines)
    return f'<div class="scroll" tabindex="0"><table><thead><tr>{cells("th", head)}</tr></thead><tbody>\n{body}</tbody></table></div>'


def section(name, title, *parts):
    return f'<section id="{name}"><h2>{title}</h2>\n' + "\n".join(parts) + "</section>"


def linked(row):
    """A recording's name, as a link where it has a page."""
    name = html.escape(row["name"])
    return f'<a href="{plan.results(".", row["recording"])[2:]}/page.html">{name}</a>' if row["has_page"] else name


def recordings_of(base):
    """Rows of recordings with their verdict, by battery."""
    rows = base.execute("SELECT r.*, v.verdict, v.mechanism, v.probability, v.summary, EXISTS (SELECT 1 FROM file f WHERE f.recording = r.recording AND f.name = 'page.html') AS has_page "
                        "FROM recording r LEFT JOIN verdict v USING (recording) ORDER BY r.battery, r.name, recording")
    return rows.fetchall()


def by_battery(base):
    return grouped(recordings_of(base), lambda row: row["battery"])


def battery_list(standing, rows):
    """Batteries of a mechanism, the surest first, each with its recordings."""
    items = "".join(f'<li><b>{html.escape(one.name)}</b> <span class="soft">{one.probability or 0.0:.2f}</span> {" ".join(linked(row) for row in rows[one.name][:5])}</li>'
                    for one in standing[:200])
    more = f'<p class="note">{len(standing) - 200} more are in the database.</p>' if len(standing) > 200 else ""
    return f"<details><summary>{count(len(standing), 'battery', 'batteries')}</summary><ul class=\"names\">{items}</ul>{more}</details>"


def mechanisms(base, told, judged, nulls):
    """How many batteries lack which mechanism, and how sure that is."""
    if not told:
        return section("mechanisms", "What is missing", "<p>No recording reported of a mechanism of physics that the base circuit lacks.</p>")
    rows, most, lines = by_battery(base), max(max(len(row[2]) for row in told), 1), []
    for name, count_told, standing, expected, sure in told:
        bar = f'<span class="share"><i style="width:{100.0 * len(standing) / most:.1f}%"></i></span>'
        lines.append((f"<b>{html.escape(words(name))}</b><small class=wrap>{html.escape(MEANT.get(name, ''))}</small>", f"{bar}{len(standing)}<small>of {count_told} reported</small>",
                      "" if sure is None else f"{expected:.1f}", number(sure, 2), battery_list(standing, rows) if standing else ""))
    how = (f"Of the batteries counted here at most one in ten is expected to lack nothing at all: false discovery rate 10 %, Benjamini-Hochberg over {judged} batteries, each compared with "
           f"{len(nulls)} recordings that lack nothing." if nulls is not None else
           f"<strong>How many of the batteries counted here lack nothing is not known:</strong> no recordings that lack nothing were given (--nulls). The evidence that a diagnosis gains represents an "
           f"e-value in Benjamini-Hochberg over {judged} batteries; short recordings at 1 Hz gain evidence without lacking anything.")
    note = (f'<p class="note">{how} '
            "<em>Mechanism right</em> is the sum of the stated probabilities: so many of them are expected to lack this mechanism and not another one.</p>")
    return section("mechanisms", "What is missing, and in how many batteries", table(("mechanism", "batteries", "mechanism right", "median probability", "which"), lines, (2, 3)), note)


def changed_text(row):
    """A strength as a reader expects it."""
    scale, unit = {"ohm": (1e3, "mOhm"), "1": (1e2, "%")}.get(row["unit"], (1.0, row["unit"]))
    return f"{scale * row['now']:.3g} {unit} <small>{scale * row['lower']:.3g} to {scale * row['upper']:.3g}</small>"


def changes(base):
    """What has changed in which battery since its first recording."""
    compared = base.execute("SELECT count(*), count(DISTINCT r.battery) FROM change c JOIN recording r USING (recording) WHERE c.verdict != 'insufficient_data'").fetchone()
    if not compared[0]:
        return section("changes", "What has changed", "<p>No battery has a second recording that could be compared with its first one.</p>")
    rows = base.execute("SELECT c.*, r.name, r.battery, EXISTS (SELECT 1 FROM file f WHERE f.recording = r.recording AND f.name = 'page.html') AS has_page FROM change c "
                        "JOIN recording r USING (recording) WHERE c.verdict = 'changed' ORDER BY c.mechanism, c.id, c.probability DESC, r.battery, r.name").fetchall()
    lines = [(html.escape(words(row["mechanism"])), f"<code>{html.escape(row['id'])}</code>", f"<b>{html.escape(row['battery'])}</b>", linked(row), changed_text(row),
              f"{row['probability']:.2f}", html.escape(row["indistinguishable"].replace(",", ", "))) for row in rows[:MAX_ROWS]]
    said = (f"<p>{count(len(rows), 'recording shows', 'recordings show')} a change since the first one of the battery, of {compared[0]} that were compared "
            f"({count(compared[1], 'battery', 'batteries')}).</p>")
    note = ('<p class="note">Each recording is compared with the first one of its battery, as sof diagnose --reference does. One in 25 sound recordings is said to have changed by '
            "chance, so look for a change that stays.</p>")
    shown = table(("mechanism", "change", "battery", "recording", "strength, 90 % interval", "probability", "looks alike"), lines, (4, 5)) if rows else ""
    return section("changes", "What has changed", said, shown, note)


def deviating(base, found, compared):
    """Who deviates from the fleet."""
    if not compared:
        return section("deviating", "Who deviates from the fleet", f'<p>No type of vehicle has {outliers.LEAST} batteries whose parameters a recording determined.</p>')
    rows = by_battery(base)
    lines = [(f"<b>{html.escape(one.battery)}</b>", html.escape(one.vehicle_type), f"<code>{html.escape(one.name)}</code>", f"{number(one.value)} {html.escape(one.unit or '')}",
              f"{number(one.median)}", f"{one.z:+.1f}", " ".join(linked(row) for row in rows[one.battery][:3])) for one in found[:100]]
    said = f"<p>{count(len(found), 'parameter deviates', 'parameters deviate')} from those of the other batteries of their type, of {compared} that were compared.</p>"
    note = ('<p class="note">z: distance to the median of the type, in robust spreads of the type and standard errors of the fit together; logarithms, but for voltages. '
            "False discovery rate 10 %.</p>")
    shown = table(("battery", "type", "parameter", "value", "median of the type", "z", "recordings"), lines, (3, 4, 5)) if found else ""
    return section("deviating", "Who deviates from the fleet", said, shown, note)


def parameters(base):
    """Parameters over age and temperature where they are known, and by type of vehicle."""
    rows = base.execute("SELECT p.name, p.value, p.std, p.unit, r.age_years, r.temperature_min_c, r.temperature_max_c, r.vehicle_type, r.battery FROM parameter p "
                        f"JOIN recording r USING (recording) WHERE {outliers.OF_RECORDING} ORDER BY r.battery").fetchall()
    drawn = [page_plots.parameter(name, some) for name, some in grouped(rows, lambda row: row["name"]).items() if len(some) >= MIN_POINTS]
    if not drawn:
        return section("parameters", "Parameters", "<p>No parameter was determined by three recordings.</p>")
    ages = any(1 for row in rows if row["age_years"] is not None)
    heat = any(1 for row in rows if row["temperature_min_c"] is not None)
    note = "" if ages and heat else f'<p class="note">{"" if ages else "No battery has an age (age_years in the list of recordings). "}{"" if heat else "No recording has a temperature."}</p>'
    return section("parameters", "Parameters", f'<div class="plots">{"".join(drawn[:12])}</div>', note)


def predictions(base):
    """How well models predict: their own recording, and the next window beside baseline."""
    rows = base.execute("SELECT share_percent, baseline_share_percent, crank_mae_v, baseline_crank_mae_v FROM score").fetchall()
    within = [row[0] for row in base.execute("SELECT coverage_90 FROM prediction WHERE coverage_90 IS NOT NULL")]
    def quartiles(key, scale=1.0):
        values = [scale * row[key] for row in rows if row[key] is not None]
        return "" if not values else "{1:.1f} ({0:.1f} to {2:.1f})".format(*np.percentile(values, [25, 50, 75]))
    lines = [("model", quartiles("share_percent"), quartiles("crank_mae_v", 1e3)), ("baseline (a line fit and past events)", quartiles("baseline_share_percent"), quartiles("baseline_crank_mae_v", 1e3))]
    said = f'<p>{count(len(rows), "window", "windows")} predicted from the window before.</p>' if rows else "<p>No window was long enough to be predicted from the one before.</p>"
    inside = f'<p class="note">On their own recordings {100.0 * np.mean(within):.0f} % of the samples lie in their 90 % interval.</p>' if within else ""
    shown = table(("", "share of the next window explained [%], median (quartiles)", "error of cranks [mV], median (quartiles)"), lines, (1, 2)) if rows else ""
    return section("predictions", "How well the next window is predicted", said, shown, inside)


def recordings(base, standing):
    """Every recording, with its verdict or why there is none."""
    rows = recordings_of(base)
    rows.sort(key=lambda row: (row["outcome"] == "done", row["battery"] not in standing, row["battery"]))
    lines = [(linked(row), html.escape(row["battery"]), html.escape(row["vehicle_type"] or ""), "" if None in (row["from_s"], row["to_s"]) else f"{(row['to_s'] - row['from_s']) / 60.0:.0f}",
              f'<span class="badge {html.escape(row["verdict"])}">{html.escape(VERDICTS.get(row["verdict"], row["verdict"]))}</span>' if row["verdict"] else f'<span class="badge insufficient_data">{"no answer" if row["reason"] else "not judged"}</span>',
              html.escape(words(row["mechanism"]) if row["mechanism"] else ""), html.escape((row["reason"] or row["summary"] or "").replace(os.path.dirname(row["path"]) + os.sep, "")))
             for row in rows[:MAX_ROWS]]
    more = f'<p class="note">{len(rows) - MAX_ROWS} more are in the database.</p>' if len(rows) > MAX_ROWS else ""
    search = '<p><label>Show recordings with <input id="filter" type="search" size="24"></label> <span id="shown" class="note"></span></p>'
    return section("recordings", "Recordings", search, table(("recording", "battery", "type", "minutes", "verdict", "mechanism", "in a sentence"), lines, (3,)), more)


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


def figures(base, found):
    """Four numbers beneath the sentence."""
    def one(query):
        return base.execute(query).fetchone()[0] or 0
    numbers = [("recordings", str(one("SELECT count(*) FROM recording"))), ("not readable", str(one("SELECT count(*) FROM recording WHERE outcome = 'failed'"))),
               ("hours recorded", f"{one('SELECT sum(to_s - from_s) FROM recording') / 3600.0:.4g}"), ("batteries judged", str(len(found)))]
    return '<dl class="figures">' + "".join(f"<div><dt>{what}</dt><dd><b>{value}</b></dd></div>" for what, value in numbers) + "</dl>"


def make(folder, nulls=None):
    """HTML of a fleet's page. nulls: folder of a fleet of recordings that lack nothing, or None."""
    base = database.open_read(folder)
    null_gains = nulls_of(nulls)
    found = discoveries.batteries(base, null_gains)
    told = discoveries.mechanisms(found)
    title = "Fleet of " + count(base.execute("SELECT count(DISTINCT battery) FROM recording").fetchone()[0], "battery", "batteries")
    page_css = read_text(os.path.join(ROOT, "src", "report", "page", "page.css"))
    style = page_css + read_text(os.path.join(HERE, "page.css"))
    origin = f'<header><p class="origin">{html.escape(title)}, <strong>{html.escape(os.path.basename(os.path.abspath(folder)))}</strong></p><h1>{html.escape(headline(found, told, nulls is not None))}</h1>'
    parts = [origin, figures(base, found), "</header>", mechanisms(base, told, len(found), null_gains),
             changes(base), deviating(base, *outliers.outliers(base)), parameters(base), predictions(base), recordings(base, {one.name for one in found if one.found})]
    return read_text(os.path.join(HERE, "page.html")).format(title=html.escape(title), style=style, body="\n".join(parts), script=read_text(os.path.join(HERE, "page.js")))
