#!/usr/bin/env python3
"""docs/messages.md has every field of msg, srv and action, and docs/python.md every docstring, as their scripts write them."""

import re
import unittest

from battery_sof_tools import message_page, python_page
from battery_sof_tools.files import read_text


class Messages(unittest.TestCase):
    def test_the_page_is_what_the_definitions_say(self):
        page = read_text(message_page.PAGE)
        self.assertEqual(page, message_page.with_reference(page), "docs/messages.md is behind: run scripts/update_messages_page")

    def test_every_field_and_constant_has_a_row(self):
        page = read_text(message_page.PAGE)
        for path in message_page.files():
            name = message_page.name_of(path)
            section = re.search(rf"^## {name}$(.*?)(?=^## |\Z)", page, re.S | re.M)[1]
            fields = re.findall(r"^[\w/]+(?:\[\])? (\w+)", re.sub(r"#.*", "", read_text(path)), re.M)
            self.assertEqual(fields, re.findall(r"^\| .*? \| `(\w+)`", section, re.M), name)


class Python(unittest.TestCase):
    def test_the_page_is_what_the_docstrings_say(self):
        page = read_text(python_page.PAGE)
        self.assertEqual(page, python_page.with_reference(page), "docs/python.md is behind: run scripts/update_python_page")

    def test_every_public_name_is_there_and_every_field_is_described(self):
        page = read_text(python_page.PAGE)
        public = read_text(python_page.ROOT + "/python/battery_sof/__init__.py").partition("_PLACES = {")[2].partition("\n}")[0]
        self.assertEqual(set(re.findall(r'"(\w+)"', public)) - {"api", "results", "session"}, set(re.findall(r"^## (\w+)$", page, re.M)) - {"Make"})
        self.assertEqual(re.findall(r"^\| `(\w+)` \| [^|]+ \|  \|$", page, re.M), [])


if __name__ == "__main__":
    unittest.main()
