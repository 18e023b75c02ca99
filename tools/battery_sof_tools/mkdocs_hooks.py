"""What mkdocs does not do by itself for the site of README.md, CONTRIBUTING.md and docs/ (mkdocs.yml): links are those of the checkout, formulas are typeset, and
the public headers are pages of doxygen.

A file outside docs/ that a page links to is copied into files/ under a name that ends in .txt (roslaunch looks for launch files in build/, too). A link to a
folder, which a site cannot show, becomes plain text.
"""

import os
import re
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))  # mkdocs loads this file alone

from battery_sof_tools import formulas
from battery_sof_tools.files import ROOT

TOP = ("README.md", "CONTRIBUTING.md")  # pages outside docs/
LINK = re.compile(r"(!?\[([^\]]*)\]\()([^)\s#:]+)((?:#[^)\s]*)?\))")


def slug(text, separator):
    """Anchors as they are in the pages' links: python-markdown's own join hyphens and number headings differently."""
    return re.sub(r"[^\w\- ]", "", text).lower().replace(" ", separator)


def on_config(config):
    config["mdx_configs"]["toc"] = dict(config["mdx_configs"].get("toc") or {}, slugify=slug)
    return config


def copy(path, name, site):
    """A file that is copied into the site under a name."""
    from mkdocs.structure.files import File
    file = File(name, ROOT, site, False)
    file.abs_src_path = path
    return file


def on_files(files, config):
    """Files by their paths in the checkout, which links lead to; where they lie in the site does not change."""
    from mkdocs.exceptions import BuildError
    from mkdocs.structure.files import File, Files
    site = config["site_dir"]
    headers = subprocess.run(["doxygen", os.path.join(HERE, "headers.doxyfile")], cwd=ROOT, env=dict(os.environ, PAGES=site), capture_output=True, text=True, check=False)
    if headers.returncode:
        raise BuildError(headers.stderr)
    for file in files:
        if file.abs_src_path.startswith(config["docs_dir"] + os.sep):
            file.src_uri = "docs/" + file.src_uri
    look = [copy(path, os.path.join("katex", name), site) for name, path in formulas.style_files().items()]
    return Files([*files, *look, *(File(page, ROOT, site, False) for page in TOP), File("headers/index.html", site, site, False)])


def fitted(text, page, outside):
    """A page whose links mkdocs can follow. @param page its path in the checkout. @param outside is called with each file outside docs/ that is linked to."""
    here = os.path.dirname(page)

    def link(match):
        path = os.path.normpath(os.path.join(here, match[3]))
        if os.path.isdir(os.path.join(ROOT, path)):
            return match[2]
        if path.startswith("docs/") or path in TOP or not os.path.exists(os.path.join(ROOT, path)):
            return match[0]
        outside(path)
        return match[1] + os.path.relpath(f"files/{path}.txt", here or ".") + match[4]

    text = LINK.sub(link, text)
    return text.replace('="docs/', '="') if page in TOP else text  # of a picture that is chosen by the width of the screen


def on_page_markdown(markdown, page, config, files):
    from mkdocs.exceptions import BuildError
    try:
        page.formulas = formulas.typeset(formulas.formulas_of(markdown))
    except ValueError as error:
        raise BuildError(f"{page.file.src_uri}: {error}") from error
    return fitted(formulas.without_formulas(markdown), page.file.src_uri,
                  lambda path: files.append(copy(os.path.join(ROOT, path), f"files/{path}.txt", config["site_dir"])))


def on_page_content(html, page, config, files):
    return formulas.with_words(html, page.formulas)


def on_post_page(output, page, config):
    return formulas.with_formulas(output, page.formulas)
