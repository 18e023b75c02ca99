"""The command sof of the wheel, which has the program beside the module."""
import os
import sys


def main() -> None:
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "sof")
    os.execv(program, ["sof", *sys.argv[1:]])
