"""Makes a site of README.md, CONTRIBUTING.md and docs/ with mkdocs, and of the public headers with doxygen (both Debian's). A link that
leads nowhere ends it, and so do a formula that KaTeX does not understand and a parameter that a header describes and does not have.

Usage: make_docs [FOLDER]; FOLDER is build/docs unless given. Exit code 77: there is no mkdocs of version 1.4 or later, no doxygen, or no katex.
"""

import os
import re
import shutil
import subprocess
import sys

from .files import ROOT


def has_tools():
    """Whether there are doxygen, KaTeX and an mkdocs that knows hooks."""
    if not all(map(shutil.which, ("mkdocs", "doxygen", "katex"))):
        return False
    told = subprocess.run(["mkdocs", "--version"], capture_output=True, text=True, check=True).stdout
    return tuple(map(int, re.search(r"version (\d+)\.(\d+)", told).groups())) >= (1, 4)


def main():
    if not has_tools():
        print("SKIPPED: there is no mkdocs of version 1.4 or later, no doxygen, or no katex")
        return 77
    site = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "build", "docs"))
    # Quiet, it would not say which link leads nowhere.
    done = subprocess.run(["mkdocs", "build", "--strict", "-f", os.path.join(ROOT, "mkdocs.yml"), "-d", site], capture_output=True, text=True, check=False)
    if done.returncode == 0:
        print(f"the site's first page is {os.path.join(site, 'index.html')}")
    else:
        print("\n".join(line for line in (done.stdout + done.stderr).splitlines() if re.search("WARNING|ERROR|Aborted", line)), file=sys.stderr)
    return done.returncode
