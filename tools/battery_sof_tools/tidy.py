"""Runs clang-tidy (14, .clang-tidy) over the code of src and include. Usage: tidy BUILD [--changed] [--seconds N] [--jobs N] [FILE...]

All sources, those named, or with --changed those that differ from where this branch left main; the last commits on main itself; a small
sample where there is neither git nor a change. A header is looked at through the source of its name. Exit code 1: something was found.
"""

import argparse
import concurrent.futures
import os
import re
import shlex
import subprocess
import time

from .files import ROOT, read_json, read_text, write_json

LAST_COMMITS = 5
OF_GCC_ALONE = "-Wno-unused-command-line-argument"  # limits of inlining
MAINS = ("origin/main", "main")
SAMPLE = ("src/util/text.cpp", "src/prediction/profile.cpp")


def git(*arguments):
    """Lines of git's answer, None where there is no git, no repository or no such commit."""
    try:
        answer = subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True, text=True)
    except OSError:
        return None
    return answer.stdout.splitlines() if answer.returncode == 0 else None


def changed():
    """Files that differ from where this branch left main, or from main's last commits; new ones too."""
    head = git("rev-parse", "HEAD")
    meetings = [git("merge-base", "HEAD", main) for main in MAINS]
    before = git("rev-parse", "--verify", "--quiet", f"HEAD~{LAST_COMMITS}")
    since = next((one for one in meetings if one and one != head), before)
    if not since:
        return []
    return (git("diff", "--name-only", "--diff-filter=d", since[0]) or []) + \
        (git("ls-files", "--others", "--exclude-standard") or [])


def without_precompiled(command):
    """A compiler's command without GCC's precompiled header, which clang cannot read."""
    words = shlex.split(command)
    kept = []
    for word in words:
        if word.endswith("cmake_pch.hxx") and kept and kept[-1] == "-include":
            kept.pop()
        elif word != "-Winvalid-pch":
            kept.append(word)
    return shlex.join(kept)


def database(build):
    """How each source of src is compiled, as clang-tidy reads it: the folder of the file, and the sources."""
    folders = tuple(os.path.join(ROOT, name) + os.sep for name in ("src", os.path.join("benchmark", "simulator")))
    entries = [entry for entry in read_json(os.path.join(build, "compile_commands.json")) if entry["file"].startswith(folders)]
    folder = os.path.join(build, "tidy")
    os.makedirs(folder, exist_ok=True)
    write_json(os.path.join(folder, "compile_commands.json"), [{**entry, "command": without_precompiled(entry["command"])} for entry in entries])
    return folder, sorted({os.path.relpath(entry["file"], ROOT) for entry in entries})


def sources_of(files, sources):
    """Each file as a source: itself, or for a header the source of its name, else the first that includes it."""
    found = []
    for path in files:
        if path.endswith(".hpp") and path.startswith(("src/", "include/")):
            name = re.compile(rf'#include "([^"]*/)?{re.escape(os.path.basename(path))}"')
            stem = os.path.splitext(os.path.basename(path))[0] + ".cpp"
            named = [source for source in sources if os.path.basename(source) == stem]
            found += (named or [source for source in sources
                                if name.search(read_text(os.path.join(ROOT, source)))])[:1]
        elif path in sources:
            found.append(path)
    return list(dict.fromkeys(found))


def look(folder, sources, jobs, seconds):
    """Prints what is found. @return how many sources have findings, and those left out for time."""
    until = time.monotonic() + seconds if seconds else float("inf")
    faulty, left_out = 0, []

    def findings(source):
        """What clang-tidy says of a source, empty where that is nothing; None after the time."""
        if time.monotonic() >= until:
            return None
        run = subprocess.run(["clang-tidy", "-p", folder, "--quiet", f"--extra-arg={OF_GCC_ALONE}",
                              os.path.join(ROOT, source)], capture_output=True, text=True)
        return "" if run.returncode == 0 else run.stdout + run.stderr + "\n"

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for source, said in zip(sources, pool.map(findings, sources)):
            if said is None:
                left_out.append(source)
            elif said:
                faulty += 1
                print(said, end="", flush=True)
    return faulty, left_out


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("files", nargs="*")
    parser.add_argument("--changed", action="store_true")
    parser.add_argument("--seconds", type=float, help="no further file is begun after them")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    chosen = parser.parse_intermixed_args(arguments)
    folder, sources = database(chosen.build)
    wanted = sources
    if chosen.files or chosen.changed:
        wanted = sources_of([os.path.relpath(file, ROOT) for file in chosen.files] or changed(), sources) or sources_of(SAMPLE, sources)
    faulty, left_out = look(folder, wanted, chosen.jobs, chosen.seconds)
    print(f"clang-tidy: {len(wanted) - len(left_out)} of {len(wanted)} sources looked at, {faulty} with findings")
    if left_out:
        print("left out for time: " + " ".join(left_out))
    return 1 if faulty or len(left_out) == len(wanted) else 0
