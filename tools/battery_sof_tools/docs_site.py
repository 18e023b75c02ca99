"""Makes a site of README.md, CONTRIBUTING.md and docs/ with mkdocs, and of the public headers with doxygen (both Debian's). A link that
leads nowhere ends it, and so does a parameter that a header describes and does not have.

Usage: make_docs [FOLDER]; FOLDER is build/docs unless given. Exit code 77: there is no mkdocs of version 1.4 or later, or no doxygen.

The pages are copied beside the site first: README.md becomes index.md, links are made to fit, and a file outside docs/ that a page links to
is copied into files/ under a name that ends in .txt (roslaunch looks for launch files in build/, too). A link to a folder, which a site cannot
show, becomes plain text.
"""

import os
import re
import shutil
import subprocess
import sys

from .files import ROOT, pages_of_docs, read_text, write_text

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = {"README.md": "index.md", "CONTRIBUTING.md": "CONTRIBUTING.md"}  # pages outside docs/, and what they are called in the site
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]*)(#[^)\s]*)?\)")
PICTURE = re.compile(r'(<source [^>]*srcset|<img src)="([^":]+)"')  # of an element that chooses a picture by the width of the screen
FILES = "files"
SETTINGS = """INHERIT: {settings}
docs_dir: {pages}
site_dir: {site}
hooks: [{hooks}]
"""


def place_in_site(path):
    """Where a file of the checkout lies in the site; None for a folder."""
    if os.path.isdir(os.path.join(ROOT, path)):
        return None
    if path in TOP:
        return TOP[path]
    return os.path.relpath(path, "docs") if path.startswith("docs/") else os.path.join(FILES, path + ".txt")


def fitted(text, page, outside):
    """A page with links that fit the site. @param page its path in the checkout. @param outside gains the files that are linked to."""
    here = os.path.dirname(place_in_site(page))

    def link(match):
        mark, words, target, anchor = match[1], match[2], match[3], match[4] or ""
        path = os.path.normpath(os.path.join(os.path.dirname(page), target))
        if not target or ":" in target or not os.path.exists(os.path.join(ROOT, path)):
            return match[0]
        place = place_in_site(path)
        if place is None:
            return words
        if place.startswith(FILES + os.sep):
            outside.add(path)
        return f"{mark}[{words}]({os.path.relpath(place, here or '.')}{anchor})"

    def picture(match):
        place = place_in_site(os.path.normpath(os.path.join(os.path.dirname(page), match[2])))
        return f'{match[1]}="{os.path.relpath(place, here or ".")}"'

    return PICTURE.sub(picture, LINK.sub(link, text))


def assemble(folder):
    """The pages as mkdocs is to read them."""
    outside = set()
    shutil.copytree(os.path.join(ROOT, "docs"), folder)
    for page in [*TOP, *pages_of_docs()]:
        text = fitted(read_text(os.path.join(ROOT, page)), page, outside)
        write_text(os.path.join(folder, place_in_site(page)), text)
    for path in outside:
        goal = os.path.join(folder, place_in_site(path))
        os.makedirs(os.path.dirname(goal), exist_ok=True)
        shutil.copyfile(os.path.join(ROOT, path), goal)


def has_tools():
    """Whether there are doxygen and an mkdocs that knows hooks and INHERIT."""
    if not shutil.which("mkdocs") or not shutil.which("doxygen"):
        return False
    told = subprocess.run(["mkdocs", "--version"], capture_output=True, text=True, check=True).stdout
    return tuple(map(int, re.search(r"version (\d+)\.(\d+)", told).groups())) >= (1, 4)


def main():
    if not has_tools():
        print("SKIPPED: there is no mkdocs of version 1.4 or later, or no doxygen")
        return 77
    site = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "build", "docs"))
    work = site + ".work"
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    pages, settings = (os.path.join(work, name) for name in ("pages", "mkdocs.yml"))
    assemble(pages)
    headers = subprocess.run(["doxygen", os.path.join(HERE, "headers.doxyfile")], cwd=ROOT, env=dict(os.environ, PAGES=pages), capture_output=True, text=True, check=False)
    if headers.returncode:
        print(headers.stderr, file=sys.stderr)
        return 1
    write_text(settings, SETTINGS.format(settings=os.path.join(ROOT, "mkdocs.yml"), pages=pages, site=site, hooks=os.path.join(HERE, "mkdocs_hooks.py")))
    # Quiet, it would not say which link leads nowhere.
    done = subprocess.run(["mkdocs", "build", "--strict", "-f", settings], capture_output=True, text=True, check=False)
    shutil.rmtree(work)
    if done.returncode == 0:
        print(f"the site's first page is {os.path.join(site, 'index.html')}")
    else:
        print("\n".join(line for line in (done.stdout + done.stderr).splitlines() if re.search("WARNING|ERROR|Aborted", line)), file=sys.stderr)
    return done.returncode
