"""Stage `test`: test/tools/words_test.py with its list test/tools/words.txt. What is not yet gone is in the list behind a #, with its count."""
import re

# (word or identifier, what to use); case counts where a capital stands in it
CANDIDATES = '''
Drive\tInputSequence
DriveStep\tInputStep
DriveSample\tInputSample
imposes_voltage\tvoltage_controlled
voltage_drives\tvoltage_controlled
Imposed\tControlMode
SourceWatch\tControlModeDetector
findSource\tdetectControlMode
drivingSource\tchargerControl
source_seen\tcharger_present
LearnedForce\tDiscrepancyModel
ForceKind\tRegressorKind
ForceColumn\tRegressor
ForceTable\tDesignMatrix
BaseResponse\tLinearization
LearnedResidual\tResidualRegression
experiencedCrank\tcorrectCrankPrediction
NaivePredictor\tBaselinePredictor
NaiveContest\tBaselineSelector
ErrorTracker\tResidualFilter
IntervalScale\tIntervalCalibration
crank_scale\tcrank_calibration
LiveModel\tModelSnapshot
TrackedModel\tModelMonitor
EdgeNoise\tTimingJitterNoise
Explainer\tStepwiseSelection
Detectable\tDetectionLimit
Absorption\tParameterBias
absorbed_into\tbiased_parameters
tied_with\tindistinguishable_from
left_rmse\tunexplained_rmse
inside_share\tcoverage
row_of_blocks\tseries_blocks
suitability\twindow quality
naive\tbaseline
family\tmechanism
families\tmechanisms
learnt\testimated from the data
told\treported
tells\treports
vouch\tsupport
vouches\tsupports
vouched\tsupported
imposes\tcontrols
imposed\tcontrolled
strangers?\tout-of-model case
stands? for\trepresents
anew\tagain
row of blocks\tseries string
passed cranks?\tprevious crank
what could hide\tdetection limit
--confirm\t--verify-detection-limits
mended\tfixed
beside\twith, compared with, in addition to
straight lines?\tbaseline
wants?\tneeds, fits better with
firm\treproducible
nats\tdefine in the glossary
decoys?\tinstrument fault
nulls?\tfault-free control
sealed\tpreregistered
put into\tinjected
errs\tdeviates
comes in\tis selected
what is left\tthe residual
other forms?\tout-of-catalogue law
lanes?\ttangents (of derivatives)
temper(ed)?\teffective sample fraction
forces?\tdiscrepancy
is asked\tis queried
asks for\trequires
alarms?\tfalse positive
matters\texceeds the relevance threshold
least_\\w+\tmin_
most_\\w+\tmax_
'''

TEST = '''"""Words of the field: none of words.txt stands in what a reader reads. Code between backticks in a page's table of old names, archives and decisions are quotes."""

import os
import re
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.realpath(os.path.join(HERE, "..", ".."))
FOLDERS = ("src", "include", "msg", "srv", "launch", "docs")
QUOTES = ("docs/archive/", "docs/proof/", "docs/decisions/")  # as they were written
ENDINGS = (".cpp", ".hpp", ".inc", ".msg", ".srv", ".launch", ".md")


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def entries():
    """(pattern, what to use) of words.txt, and what is allowed: lines that begin with a plus."""
    words, allowed = [], []
    for line in read(os.path.join(HERE, "words.txt")).splitlines():
        if line.startswith("+"):
            allowed.append(line[1:].strip())
        elif line and not line.startswith("#"):
            words.append(tuple(line.split("\\t")))
    return words, allowed


def pages():
    yield os.path.join(ROOT, "README.md")
    for folder in FOLDERS:
        for parent, _, names in os.walk(os.path.join(ROOT, folder)):
            for name in sorted(names):
                path = os.path.join(parent, name)
                if name.endswith(ENDINGS) and not os.path.relpath(path, ROOT).startswith(QUOTES):
                    yield path


class Words(unittest.TestCase):
    def test_are_the_fields(self):
        words, allowed = entries()
        without = re.compile("|".join(allowed)) if allowed else None
        patterns = [(re.compile(r"(?<![\\w-])" + word + r"(?![\\w-])", 0 if any(map(str.isupper, word)) else re.I), word, use) for word, use in words]
        found = []
        for path in pages():
            text = read(path)
            text = without.sub("", text) if without else text
            for pattern, word, use in patterns:
                for match in pattern.finditer(text):
                    line = text.count("\\n", 0, match.start()) + 1
                    found.append(f"{os.path.relpath(path, ROOT)}:{line}: {match.group(0)!r}, use {use!r}")
        self.assertEqual([], found[:20], f"{len(found)} words of words.txt")


if __name__ == "__main__":
    unittest.main()
'''
ALLOWED = ['absorbed_into', 'contest_duration']


def apply(tree):
    scope = [tree.text[f] for f in tree.text if (re.match(r'(src|include|msg|srv|launch|docs)/', f) or f == 'README.md') and f.endswith(('.cpp', '.hpp', '.inc', '.msg', '.srv', '.launch', '.md'))
             and not re.match(r'docs/(archive|proof|decisions)/', f)]
    allowed = re.compile('|'.join(ALLOWED))
    scope = [allowed.sub('', text) for text in scope]
    active, open_ = [], []
    for line in CANDIDATES.strip().splitlines():
        word, use = line.split('\t')
        pattern = re.compile(r'(?<![\w-])' + word + r'(?![\w-])', 0 if any(map(str.isupper, word)) else re.I)
        count = sum(len(pattern.findall(text)) for text in scope)
        (open_ if count else active).append(f'{word}\t{use}' if not count else f'# {count} still: {word}\t{use}')
    tree.text['test/tools/words.txt'] = ('# A regular expression of a whole word, a tab, what to use; case counts where it has a capital. +: allowed (names of the contract).\n'
                                         + ''.join(f'+{a}\n' for a in ALLOWED) + '\n'.join(active + open_) + '\n')
    tree.text['test/tools/words_test.py'] = TEST
    print(f'test: {len(active)} words at zero, {len(open_)} still there')
    for one in open_:
        print('   ', one)
