#!/usr/bin/env python3
"""Formulas of the pages: KaTeX understands each, GitHub shows each, and no page of the site shows what is written in their place. Exit code 77: there is no KaTeX."""

import glob
import html
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from battery_sof_tools import docs_site, formulas
from battery_sof_tools.files import ROOT, pages_of_docs, read_text

PAGES = ("README.md", "CONTRIBUTING.md", *pages_of_docs())
# GitHub answers "The following macros are not allowed": what defines, hides or styles.
REFUSED = {"DeclareMathOperator", "class", "cssId", "def", "edef", "gdef", "hphantom", "href", "let", "mbox", "newcommand", "operatorname", "phantom", "renewcommand", "require", "style", "unicode", "vphantom"}


def shown_by(page):
    """What a reader sees of a page of the site, without code."""
    page = re.sub(r"<(script|style|pre|code|math|head)\b.*?</\1>", "", page, flags=re.S)
    return html.unescape(re.sub("<[^>]+>", "", page))


class Formulas(unittest.TestCase):
    def test_each_is_understood(self):
        count = 0
        for page in PAGES:
            of_page = formulas.formulas_of(read_text(os.path.join(ROOT, page)))
            try:
                count += len(formulas.typeset(of_page))
            except ValueError as error:
                self.fail(f"{page}: {error}")
        self.assertGreater(count, 200)

    def test_github_shows_each(self):
        for page in PAGES:
            text = read_text(os.path.join(ROOT, page))
            for latex, is_block in formulas.formulas_of(text):
                self.assertEqual(REFUSED & set(re.findall(r"\\([A-Za-z]+)", latex)), set(), f"{page}: {latex}")
                self.assertFalse(is_block and "\n\n" in latex, f"{page}: an empty line in {latex}")
                self.assertFalse(not is_block and "|" in latex, f"{page}: | is the end of a table's cell; write \\lvert and \\rvert in {latex}")
            self.assertEqual(re.findall(r"\w\$`.*|`\$\w.*", text), [], f"{page}: GitHub wants a space or a sign before and after a formula")
            self.assertEqual(re.findall(r".*(?:\$`|`\$|```math).*", formulas.FORMULA.sub("", text.replace("`$`", ""))), [], f"{page}: the line has half a formula")

    def test_what_is_not_understood_is_named(self):
        with self.assertRaisesRegex(ValueError, r"KaTeX parse error: Undefined control sequence: \\nothing .* in y = \\nothing x$"):
            formulas.typeset([("x^2", False), ("y =\n\\nothing x", True)])

    def test_a_block_and_a_formula_in_a_line_are_found_and_set_in_their_places(self):
        page = "With $`a_1`$:\n\n```math\nx = [y](z)\n```\n\n```python\n`$`\n```\n"
        self.assertEqual(formulas.formulas_of(page), [("a_1", False), ("x = [y](z)", True)])
        left = formulas.without_formulas(page)
        self.assertNotIn("[y](z)", left)
        self.assertIn("```python\n`$`\n```", left)
        set_ones = formulas.typeset(formulas.formulas_of(page))
        self.assertIn(">x=[y](z)</div>", formulas.with_words(left, set_ones))
        whole = formulas.with_formulas(formulas.with_words(left, set_ones), set_ones)
        self.assertEqual((whole.count('class="katex-display"'), whole.count("<math")), (1, 2))
        self.assertNotIn("data-formula", whole)
        self.assertNotIn("a_1", whole)


@unittest.skipUnless(docs_site.has_tools(), "there is no mkdocs or no doxygen")
class Site(unittest.TestCase):
    def test_no_page_shows_latex(self):
        with tempfile.TemporaryDirectory(prefix="a site ") as site:
            subprocess.run([sys.executable, os.path.join(ROOT, "scripts", "make_docs"), site], check=True, capture_output=True)
            pages = [path for path in glob.glob(os.path.join(site, "**", "*.html"), recursive=True) if os.sep + "headers" + os.sep not in path]
            self.assertGreaterEqual(len(pages), len(PAGES))
            typeset = 0
            for path in pages:
                page = read_text(path)
                typeset += page.count('<span class="katex">')
                self.assertEqual(re.findall(r".*(?:\\[A-Za-z]{2,}|\$|\\\\).*", shown_by(page)), [], path)
                self.assertNotRegex(page, "data-formula|katex-error|application/x-tex|```math", path)
            self.assertEqual(typeset, sum(len(formulas.formulas_of(read_text(os.path.join(ROOT, page)))) for page in PAGES))
            self.assertNotRegex(read_text(os.path.join(site, "search", "search_index.json")), r"\\\\[a-z]{2,}\{|\$`")
            for name in re.findall(r"url\(([^)]+\.woff2)\)", read_text(os.path.join(site, "katex", "katex.min.css"))):
                self.assertTrue(os.path.exists(os.path.join(site, "katex", name)), name)

    def test_latex_that_is_shown_would_be_seen(self):
        self.assertIn(r"\beta", shown_by(r"<p>the slope \beta</p>"))
        self.assertNotIn(r"\beta", shown_by(r"<pre>\beta</pre><p><code>\beta</code></p>"))


if __name__ == "__main__":
    if not shutil.which("katex"):
        print("SKIPPED: there is no katex")
        sys.exit(77)
    unittest.main(verbosity=2)
