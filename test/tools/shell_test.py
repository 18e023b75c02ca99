"""Every shell script of the checkout passes shellcheck. Exit code 77: skipped, shellcheck is not installed."""

import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
FOLDERS = ("scripts", ".ci", "test", "tools", "bench", "cmake", "completion")
SHELL = re.compile(rb"#!.*\b(ba)?sh\b")


def scripts():
    for folder in FOLDERS:
        for parent, _, names in os.walk(os.path.join(ROOT, folder)):
            for name in sorted(names):
                path = os.path.join(parent, name)
                with open(path, "rb") as file:
                    if SHELL.match(file.readline()):
                        yield path


def main():
    if not shutil.which("shellcheck"):
        print("SKIPPED: shellcheck is not installed (apt-get install shellcheck)")
        return 77
    found = list(scripts())
    print(f"shellcheck of {len(found)} scripts")
    if not found:
        print("no script was found")
        return 1
    return subprocess.run(["shellcheck", *found]).returncode


if __name__ == "__main__":
    sys.exit(main())
