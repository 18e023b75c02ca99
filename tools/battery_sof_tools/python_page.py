"""Writes what the docstrings of python/battery_sof say into docs/python.md: update_python_page"""

import ast
import os
import textwrap

from .files import ROOT, read_text, with_part, write_text
from .tables import table

PAGE = os.path.join(ROOT, "docs", "python.md")
BEGIN = "<!-- python: scripts/update_python_page writes this part -->\n"
END = "<!-- end of python -->\n"
FILES = ("api.py", "session.py", "results.py")


def described(node):
    """The docstring of a class or function as paragraphs of Markdown."""
    text = ast.get_docstring(node) or ""
    return "\n\n".join(textwrap.fill(" ".join(one.split()), 110, break_long_words=False, break_on_hyphens=False) for one in text.split("\n\n")).replace("<", r"\<")


def annotation(node):
    """A type as a reader writes it."""
    return ast.unparse(node).strip("'\"").replace("Numbers", "ArrayLike")


def signature(name, node, is_method=False):
    """Lines of a call: one argument a line where they are many."""
    args = node.args
    plain = args.args[1:] if is_method else args.args
    firsts = [None] * (len(plain) - len(args.defaults)) + args.defaults
    parts = [(arg, default) for arg, default in zip(plain, firsts)]
    shown = [f"{arg.arg}: {annotation(arg.annotation)}" + (f" = {ast.unparse(default)}" if default is not None else "") for arg, default in parts]
    if args.kwonlyargs:
        shown.append("*")
        shown += [f"{arg.arg}: {annotation(arg.annotation)}" + (f" = {ast.unparse(default)}" if default is not None else "") for arg, default in zip(args.kwonlyargs, args.kw_defaults)]
    end = f") -> {annotation(node.returns)}" if node.returns and annotation(node.returns) != "None" else ")"
    whole = f"{name}({', '.join(shown)}{end}"
    if len(whole) <= 110:
        return whole
    return name + "(" + ",\n".join(("" if k == 0 else " " * (len(name) + 1)) + one for k, one in enumerate(shown)).replace("*,\n" + " " * (len(name) + 1), "*, ") + end


def call(title, name, node, is_method=False):
    is_property = any(ast.unparse(one) == "property" for one in node.decorator_list)
    shown = f"{name}: {annotation(node.returns)}" if is_property else signature(name, node, is_method)
    return f"{title}\n\n```python\n{shown}\n```\n\n{described(node)}\n"


def remark(lines, node):
    """What stands behind a field after `#:`."""
    return lines[node.end_lineno - 1][node.end_col_offset:].partition("#:")[2].strip().replace("|", r"\|")


def section(node, lines):
    """What the page says of a class or a function."""
    if isinstance(node, ast.FunctionDef):
        return call(f"## {node.name}", node.name, node)
    fields = [each for each in node.body if isinstance(each, ast.AnnAssign) and not each.target.id.startswith("_")]
    said = f"## {node.name}\n\n{described(node)}\n"
    if any(remark(lines, each) for each in fields) or node.decorator_list:
        rows = [(f"`{each.target.id}`", annotation(each.annotation).replace("|", r"\|"), remark(lines, each)) for each in fields]
        said += "\n" + "\n".join(table(("field", "type", "meaning"), rows)) + "\n"
    for each in node.body:
        if isinstance(each, ast.FunctionDef) and (not each.name.startswith("_") or each.name == "__init__") and ast.get_docstring(each):
            name = node.name if each.name == "__init__" else f"{node.name}.{each.name}"
            said += "\n" + call(f"### {name}" if each.name != "__init__" else f"### Make a {node.name}", name, each, True)
    return said


def members():
    """Public classes and functions, with the lines of their file."""
    for file in FILES:
        text = read_text(os.path.join(ROOT, "python", "battery_sof", file))
        for node in ast.parse(text).body:
            is_result = isinstance(node, ast.ClassDef) or file == "api.py" and isinstance(node, ast.FunctionDef)
            if is_result and not node.name.startswith("_") and not any(ast.unparse(one) == "overload" for one in node.decorator_list):
                yield node, text.splitlines()


def with_reference(text):
    """A page with the reference between its marks."""
    return with_part(text, BEGIN, END, "\n" + "\n".join(section(*each) for each in members()) + "\n")


def main():
    write_text(PAGE, with_reference(read_text(PAGE)))
    print("docs/python.md holds what the docstrings say")
