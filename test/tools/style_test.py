"""Style of the checkout, by the tools that define it: clang-format, clang-tidy, catkin_lint, shellcheck.

Usage: style_test.py clang-format|clang-tidy|catkin_lint|shellcheck. Exit code 77: skipped, the tool is not installed or not the one that is meant.
"""

import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
SHELL_FOLDERS = ("scripts", ".ci", "test", "tools", "benchmark", "cmake", "completion", "debian")
CODE_FOLDERS = ("src", "include", "benchmark", "test", "examples", "python")
SHELL = re.compile(rb"#!.*\b(ba)?sh\b")
CLANG = 14  # two versions neither format alike nor find the same
BUILD = os.environ.get("BATTERY_SOF_BUILD", os.path.join(ROOT, "build"))
TIDY_SECONDS = "90"  # in which a file is begun: one takes ten to thirty


def files(folders):
    for folder in folders:
        for parent, _, names in os.walk(os.path.join(ROOT, folder)):
            for name in sorted(names):
                yield os.path.join(parent, name)


def is_shell(path):
    with open(path, "rb") as file:
        return SHELL.match(file.readline())


def shellcheck():
    return ["shellcheck", *(path for path in files(SHELL_FOLDERS) if is_shell(path))]


def clang_format():
    return ["clang-format", "--dry-run", "--Werror", *(path for path in files(CODE_FOLDERS) if path.endswith((".cpp", ".hpp")))]


def catkin_lint():
    # Scripts of the checkout are not installed: they build or need sources.
    return ["catkin_lint", "--offline", "--strict", "-W1", "--ignore", "uninstalled_script", ROOT]


def clang_tidy():
    # What has changed: all of it takes an hour (make tidy).
    return [os.path.join(ROOT, "scripts", "tidy"), BUILD, "--changed", "--seconds", TIDY_SECONDS]


TOOLS = {"shellcheck": shellcheck, "clang-format": clang_format, "clang-tidy": clang_tidy, "catkin_lint": catkin_lint}


def other_version(tool):
    """What makes a tool that is there not the one that is meant, or None."""
    if not tool.startswith("clang"):
        return None
    said = subprocess.run([tool, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    return None if re.search(rf"version {CLANG}\.", said) else f"{said}, expected version {CLANG}"


def main(tool):
    reason = "not installed" if not shutil.which(tool) else other_version(tool)
    if reason:
        print(f"SKIPPED: {tool} is {reason}")
        return 77
    command = TOOLS[tool]()
    if len(command) < 3:
        print(f"{tool}: no file was found")
        return 1
    return subprocess.run(command).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
