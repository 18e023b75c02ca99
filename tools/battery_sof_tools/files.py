"""Files of results: JSON that appears whole or not at all, rows that a run which was cut off goes on from, digests; work in turns."""

import concurrent.futures
import errno
import glob
import hashlib
import json
import os
import re
import stat

from .progress import followed

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))  # of the package


def pages_of_docs():
    """Paths of every page below docs/, from ROOT on."""
    return sorted(glob.glob(os.path.join("docs", "**", "*.md"), root_dir=ROOT, recursive=True))


def version():
    """The package's version, which package.xml has."""
    return re.search("<version>(.*)</version>", read_text(os.path.join(ROOT, "package.xml")))[1]


def require_regular(path):
    """OSError for what is not a regular file: a pipe or a device may never end."""
    if not stat.S_ISREG(os.stat(path).st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file", path)


def utf8(text):
    """A text that can be written: bytes of a file's name that are no UTF-8, and halves of characters, as their codes."""
    return re.sub("[\ud800-\udfff]", lambda half: f"\\x{ord(half[0]) - 0xdc00:02x}" if "\udc80" <= half[0] <= "\udcff" else f"\\u{ord(half[0]):04x}", text)


def printable(text):
    """A text for a terminal: what cannot be shown, such as a newline or an escape, as its code."""
    return "".join(one if one.isprintable() else one.encode("unicode_escape").decode() for one in utf8(text))


def read_text(path):
    with open(path) as file:
        return file.read()


def read_json(path):
    return json.loads(read_text(path))


def write_json(path, value):
    """As write_text()."""
    write_text(path, json.dumps(value))


def write_text(path, text):
    """Written under another name, then renamed; nothing without a path."""
    if not path:
        return
    beside = f"{path}.{os.getpid()}.part"
    with open(beside, "w") as file:
        file.write(text)
    os.replace(beside, path)


def with_part(text, begin, end, part):
    """A page with another part between two marks; SystemExit without them."""
    head, is_there, rest = text.partition(begin)
    _, is_whole, tail = rest.partition(end)
    if not is_there or not is_whole:
        raise SystemExit(f"the marks {begin.strip()} and {end.strip()} are missing in the page")
    return head + begin + part + end + tail


def lines_of(path):
    """One object a line; a last line that was cut off is left, a missing file has none."""
    if not os.path.exists(path):
        return []
    with open(path) as file:
        return [json.loads(line) for line in file if line.endswith("\n")]


def append(path, entry):
    with open(path, "a") as file:
        file.write(json.dumps(entry) + "\n")


def digest(*paths):
    """SHA-256 of files, one after the other."""
    total = hashlib.sha256()
    for path in paths:
        with open(path, "rb") as file:
            for part in iter(lambda: file.read(1 << 20), b""):
                total.update(part)
    return total.hexdigest()


def require_digest(what, wanted, where, *paths):
    """SystemExit where files do not have the digest that `where` says of them."""
    found = digest(*paths)
    if found != wanted:
        raise SystemExit(f"{what} is not what was sealed: digest {found}, {where} says {wanted}")


def require_same(path, value, what):
    """Keeps a value; SystemExit where another is kept already."""
    if os.path.exists(path) and read_json(path) != value:
        raise SystemExit(f"{os.path.dirname(path)} holds {what}; take an empty folder")
    write_json(path, value)


def finished(jobs, work, todo, what):
    """Results of work(*arguments) as they come, each from a process of its own, with progress on standard error."""
    if not todo:
        return
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        pending = [pool.submit(work, *arguments) for arguments in todo]
        for one in followed(concurrent.futures.as_completed(pending), what, len(todo)):
            yield one.result()
