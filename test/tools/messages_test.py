#!/usr/bin/env python3
"""docs/messages.md has every field of msg, srv and action, as scripts/update_messages_page writes it."""

import re
import unittest

from battery_sof_tools import message_page
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


if __name__ == "__main__":
    unittest.main()
