#!/usr/bin/env python3
"""Moves include/battery_sof/<folder>/x.hpp beside its source (src/<folder>/x.hpp), text/number/file helpers into src/util; includes follow.
PUBLIC headers go to include/battery_sof/ itself. Usage: headers.py ROOT"""
import os, re, subprocess, sys
root = os.path.abspath(sys.argv[1]); os.chdir(root)
ls = lambda: [f for f in subprocess.check_output(['git', 'ls-files', '-z']).decode().split('\0')[:-1] if os.path.isfile(f)]
PUBLIC = {'recording/series.hpp', 'recording/csv.hpp', 'recording/recording_error.hpp', 'recording/intake.hpp', 'recording/sample_list.hpp', 'report/version.hpp'}
UTIL = set(sys.argv[2].split(',')) if len(sys.argv) > 2 else {'words', 'number_text', 'printable', 'atomic_file', 'regular_file', 'separate_files', 'student', 'pi'}
moved = {}
def move(f, target):
    assert not os.path.exists(target), target
    os.makedirs(os.path.dirname(target), exist_ok=True)
    subprocess.check_call(['git', 'mv', f, target])
for f in ls():
    m = re.fullmatch(r'include/battery_sof/([a-z_]+)/([a-z_0-9]+\.hpp)', f)
    if m:
        key = f'{m[1]}/{m[2]}'
        if key in PUBLIC: target, inc = f'include/battery_sof/{m[2]}', f'battery_sof/{m[2]}'
        else:
            folder = 'util' if m[1] == 'recording' and m[2][:-4] in UTIL else m[1]
            target, inc = f'src/{folder}/{m[2]}', f'{folder}/{m[2]}'
        move(f, target); moved['battery_sof/' + key] = inc
    m = re.fullmatch(r'src/recording/([a-z_0-9]+)\.cpp', f)
    if m and m[1] in UTIL: move(f, f'src/util/{m[1]}.cpp')
    m = re.fullmatch(r'test/unit/recording/([a-z_0-9]+)_test\.cpp', f)
    if m and m[1] in UTIL: move(f, f'test/unit/util/{m[1]}_test.cpp')
n = 0
for f in ls():
    if not re.search(r'\.(hpp|cpp|h|inc|cmake|md|py|txt)$', f): continue
    if f.startswith('CHANGELOG'): continue
    text = open(f, encoding='utf-8').read()
    new = re.sub(r'([<"])(battery_sof/[a-z_]+/[a-z_0-9]+\.hpp)([>"])', lambda m: '"' + moved[m[2]] + '"' if m[2] in moved else m[0], text)
    def path(m):
        t = moved.get('battery_sof/' + m[1]);
        return m[0] if t is None else ('include/' + t if t.startswith('battery_sof/') else 'src/' + t)
    new = re.sub(r'include/battery_sof/([a-z_]+/[a-z_0-9]+\.hpp)', path, new)
    if new != text:
        open(f, 'w', encoding='utf-8').write(new); n += 1
print(len(moved), 'headers moved;', n, 'files changed')
