"""Words of the field: none of words.txt stands in what a reader reads. Code between backticks in a page's table of old names is a quote."""

import os
import re
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.realpath(os.path.join(HERE, "..", ".."))
FOLDERS = ("src", "include", "msg", "srv", "action", "launch", "docs", "tools", "config", "python", "live", "scripts", "examples", "completion")
ENDINGS = (".cpp", ".hpp", ".inc", ".msg", ".srv", ".action", ".launch", ".md", ".py", ".js", ".html", ".css", ".yaml", ".bash", ".xml")


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def entries():
    """(pattern, what to use) of words.txt, and (allowed, in which files) of its lines that begin with a plus."""
    words, allowed = [], []
    for line in read(os.path.join(HERE, "words.txt")).splitlines():
        if line.startswith("+"):
            allowed.append((line[1:] + "\t").split("\t")[:2])
        elif line and not line.startswith("#"):
            words.append(tuple(line.split("\t")))
    return words, allowed


def pages():
    yield os.path.join(ROOT, "README.md")
    for folder in FOLDERS:
        for parent, _, names in os.walk(os.path.join(ROOT, folder)):
            for name in sorted(names):
                path = os.path.join(parent, name)
                if name.endswith(ENDINGS) or ("." not in name and not os.path.islink(path)):
                    yield path


class Words(unittest.TestCase):
    def test_are_the_fields(self):
        words, allowed = entries()
        patterns = [(re.compile(r"(?<![\w-])" + word + r"(?![\w-])", 0 if any(map(str.isupper, word)) else re.I), word, use) for word, use in words]
        found = []
        for path in pages():
            quotes = [quote for quote, where in allowed if re.match(where, os.path.relpath(path, ROOT))]
            text = re.sub("|".join(quotes) or "(?!)", "", read(path))
            for pattern, word, use in patterns:
                for match in pattern.finditer(text):
                    line = text.count("\n", 0, match.start()) + 1
                    found.append(f"{os.path.relpath(path, ROOT)}:{line}: {match.group(0)!r}, use {use!r}")
        self.assertEqual([], found[:20], f"{len(found)} words of words.txt")


if __name__ == "__main__":
    unittest.main()
