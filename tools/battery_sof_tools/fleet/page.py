"""The page of a fleet: one HTML file that needs no network, in the style of the diagnosis page."""

import html
import os

from ..files import ROOT, read_text, write_text
from . import database, departures, discoveries
from . import page_sections as sections

HERE = os.path.dirname(os.path.abspath(__file__))
HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:">
<title>{title}</title>
<style>
{style}
</style>
</head>
<body>
<main>
"""
FOOT = """</main>
<script>
{script}
</script>
</body>
</html>
"""


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
        return f"None of {sections.count(len(found), 'battery', 'batteries')} lacks a kind of physics that stands among so many."
    first = told[0]
    lack = "lack" if held else "are reported to lack"
    return (f"{len(standing)} of {sections.count(len(found), 'battery', 'batteries')} {lack} a kind of physics that the base circuit does not have; the most frequent one is "
            f"{sections.words(first[0])} ({len(first[2])}).")


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
    title = "Fleet of " + sections.count(base.execute("SELECT count(DISTINCT battery) FROM recording").fetchone()[0], "battery", "batteries")
    page_css = read_text(os.path.join(ROOT, "src", "report", "page", "page.css"))
    style = page_css + read_text(os.path.join(HERE, "page.css"))
    origin = f'<header><p class="origin">{html.escape(title)}, <strong>{html.escape(os.path.basename(os.path.abspath(folder)))}</strong></p><h1>{html.escape(headline(found, told, nulls is not None))}</h1>'
    parts = [HEAD.format(title=html.escape(title), style=style), origin, figures(base, found), "</header>", sections.mechanisms(base, told, len(found), null_gains),
             sections.departing(base, *departures.departures(base)), sections.parameters(base), sections.predictions(base), sections.recordings(base, {one.name for one in found if one.found}),
             FOOT.format(script=read_text(os.path.join(HERE, "page.js")))]
    return "\n".join(parts)


def write(folder, out, nulls=None):
    write_text(out, make(folder, nulls))
