"""Formulas of the pages, set by KaTeX (Debian's `katex`) while the site is made, so that its pages need neither a script nor a network to show them.

A formula is LaTeX: a block between a line "```math" and a line "```", or between "$`" and "`$" within a line. GitHub and GitLab show both, too.
"""

import glob
import html
import json
import os
import re
import shutil
import subprocess

FORMULA = re.compile(r"^```math\n(?P<block>.+?)\n```$|(?<!`)\$`(?P<inline>[^`\n]+)`\$(?!`)", re.M | re.S)
PLACE = re.compile(r'<(?P<kind>div|span) data-formula="(?P<index>\d+)">.*?</(?P=kind)>', re.S)
# A line does not end between a formula and the signs that touch it.
IN_A_LINE = re.compile(r"([(\[]?)" + PLACE.pattern + r"([])?!.,:;]*)", re.S)
# MathML, for screen readers, repeats what HTML shows. What is not understood is an error, not text in red.
PROGRAM = """
const katex = require(process.argv[1]);
const set = ([latex, displayMode]) => {
  try {
    return {html: katex.renderToString(latex, {displayMode, strict: "error"})};
  } catch (error) {
    return {fault: error.message};
  }
};
process.stdout.write(JSON.stringify(JSON.parse(require("fs").readFileSync(0, "utf8")).map(set)));
"""


def katex():
    """Folder of KaTeX, which node requires. FileNotFoundError without it."""
    command = shutil.which("katex")
    if not command:
        raise FileNotFoundError("there is no katex (package katex)")
    return os.path.dirname(os.path.realpath(command))


def style_files():
    """What a page with formulas needs: katex.min.css and fonts, each with its path. Every browser of today reads WOFF 2."""
    dist = os.path.join(katex(), "dist")
    names = ("katex.min.css", *sorted(glob.glob(os.path.join("fonts", "*.woff2"), root_dir=dist)))
    return {name: os.path.join(dist, name) for name in names}


def formulas_of(page):
    """LaTeX of a page's formulas, each with whether it is a block."""
    return [(match["block"] or match["inline"], bool(match["block"])) for match in FORMULA.finditer(page)]


def typeset(formulas):
    """HTML of each formula. ValueError naming those that KaTeX does not understand."""
    if not formulas:
        return []
    done = subprocess.run(["node", "-e", PROGRAM, katex()], input=json.dumps(formulas), capture_output=True, encoding="utf-8", check=True)
    results = json.loads(done.stdout)
    faults = [f"{result['fault']} in {latex}" for (latex, _), result in zip(formulas, results) if "fault" in result]
    if faults:
        raise ValueError(" ".join("; ".join(faults).split()))  # in one line
    return [finished(result["html"]) for result in results]


def finished(formula):
    """HTML of KaTeX without the LaTeX that it hides in it. Lines may end between its parts: the style sheet forbids it elsewhere (formula in site.css)."""
    formula = re.sub("<annotation.*?</annotation>", "", formula, flags=re.S)
    return formula.replace('</span><span class="base">', '</span><wbr><span class="base">')


def without_formulas(page):
    """A page with an empty place for each formula, which Markdown leaves as it is."""
    count = 0

    def place(match):
        nonlocal count
        count += 1
        return f'\n<div data-formula="{count - 1}"></div>\n' if match["block"] else f'<span data-formula="{count - 1}"></span>'

    return FORMULA.sub(place, page)


def with_formulas(text, typeset_formulas):
    """HTML with formulas in their places."""
    def formula(place):
        return f'<{place["kind"]} class="formula">{place[1]}{typeset_formulas[int(place["index"])]}{place[4]}</{place["kind"]}>'

    return IN_A_LINE.sub(formula, text)


def with_words(text, typeset_formulas):
    """HTML with the characters of formulas in their places, which stay: what a search finds."""
    def words(place):
        mathml = re.search("<math.*?</math>", typeset_formulas[int(place["index"])], re.S)[0]
        return f'<{place["kind"]} data-formula="{place["index"]}">{html.escape(html.unescape(re.sub("<[^>]+>", "", mathml)))}</{place["kind"]}>'

    return PLACE.sub(words, text)
