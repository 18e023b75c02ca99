"""Names of the field: none of names.txt is a name in the code or in what it writes."""

import glob
import os
import re
import unittest

from battery_sof_tools.files import ROOT, read_text

FOLDERS = ("src", "include", "benchmark", "msg", "srv", "action", "launch", "tools", "config", "python", "live", "scripts", "examples", "completion")


class Names(unittest.TestCase):
    def test_are_the_fields(self):
        lines = read_text(os.path.join(ROOT, "test", "tools", "names.txt")).splitlines()
        gone = dict(line.split("\t") for line in lines if not line.startswith("#"))
        sources = [path for folder in FOLDERS for path in glob.glob(os.path.join(ROOT, folder, "**", "*"), recursive=True) if os.path.isfile(path) and not path.endswith(".pyc")]
        self.assertGreater(len(sources), 500)
        found = [f"{os.path.relpath(path, ROOT)}: {name}, use {gone[name]}" for path in sources for name in sorted(gone.keys() & set(re.findall(r"\w+", read_text(path))))]
        self.assertEqual([], found)


if __name__ == "__main__":
    unittest.main()
