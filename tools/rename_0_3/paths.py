"""Which file moves where, and what says so."""
import os, re

FOLDERS = [  # old folder -> new folder, longest first
    ('include/battery_sof/naive/', 'include/battery_sof/baseline/'), ('src/naive/', 'src/baseline/'), ('test/unit/naive/', 'test/unit/baseline/'),
    ('include/battery_sof/learn/', 'include/battery_sof/regression/'), ('src/learn/', 'src/regression/'), ('test/unit/learn/', 'test/unit/regression/'),
    ('include/battery_sof/identify/', 'include/battery_sof/estimation/'), ('src/identify/', 'src/estimation/'), ('test/unit/identify/', 'test/unit/estimation/'),
    ('include/battery_sof/predict/', 'include/battery_sof/prediction/'), ('src/predict/', 'src/prediction/'), ('test/unit/predict/', 'test/unit/prediction/'),
    ('include/battery_sof/diagnose/', 'include/battery_sof/diagnosis/'), ('src/diagnose/', 'src/diagnosis/'), ('test/unit/diagnose/', 'test/unit/diagnosis/'),
    ('src/reference/', 'simulator/'), ('test/unit/reference/', 'test/unit/simulator/'),
    ('tools/battery_sof_tools/strangers/', 'tools/battery_sof_tools/out_of_model/'), ('test/strangers/', 'test/out_of_model/'),
]
# words that a folder has in an include, in CMake or in a sentence of a page: `predict/x`
STAGES = {'naive': 'baseline', 'learn': 'regression', 'identify': 'estimation', 'predict': 'prediction', 'diagnose': 'diagnosis'}

STEMS = dict(line.split() for line in '''
source control_mode
source_overview control_mode_overview
source_share charger_share
family mechanism
force_columns regressors
learned_force discrepancy_model
force_fit discrepancy_fit
force_curve discrepancy_curve
force_answers discrepancy_answers
force_rows design_matrix
force_kernel regressor_kernel
force_run discrepancy_run
force_yaml discrepancy_yaml
page_force page_discrepancy
page_source page_operating_mode
learned_residual residual_regression
experience event_history
experienced event_corrections
window_experience window_history
error_tracker residual_filter
naive_predictor baseline_predictor
naive_contest baseline_selector
contest model_selector
interval_scale interval_calibration
live_model model_snapshot
tracked_model model_monitor
absorption parameter_bias
edge_noise timing_jitter_noise
blocks series_blocks
row_of_blocks series_blocks
model_lessons model_regressions
stage_learn stage_discrepancy
blocks_option series_blocks_option
learned_answers discrepancy_answers
learned_effect discrepancy_effect
made_force made_discrepancy
learnt_drive drive_with_discrepancy
suitability_experiment_main window_quality_experiment_main
words text
strangers out_of_model
families mechanisms
by_family by_mechanism
'''.strip().splitlines())
EXACT = {
    'include/battery_sof/model/drive.hpp': 'include/battery_sof/model/input_sequence.hpp',
    'src/model/drive.cpp': 'src/model/input_sequence.cpp',
    'test/unit/model/drive_test.cpp': 'test/unit/model/input_sequence_test.cpp',
    'src/model/lanes.hpp': 'src/model/tangents.hpp',
    'test/unit/predict/row_of_blocks_test.cpp': 'test/unit/prediction/series_scaling_test.cpp',
}


def new_path(path):
    if path in EXACT:
        return EXACT[path]
    if re.match(r'docs/|test/(proof|fuzz/corpus|examples)/', path):
        return path
    new = path
    for old_folder, new_folder in FOLDERS:
        if new.startswith(old_folder):
            new = new_folder + new[len(old_folder):]
            break
    folder, base = os.path.split(new)
    stem, dot, ending = base.partition('.')
    ending = dot + ending
    test = '_test' if stem.endswith('_test') else ''
    bare = stem[:-5] if test else stem
    if bare in STEMS:
        bare = STEMS[bare]
    elif re.search(r'(?:^|_)stranger(?:_|$)', bare):
        bare = re.sub(r'(^|_)stranger(?=_|$)', r'\1out_of_model', bare)
    return os.path.join(folder, bare + test + ending)


def moves(files):
    return [(f, new_path(f)) for f in files if new_path(f) != f]


def rewrite(tree, table):
    new_of = dict(table)
    headers = {}  # include path as written -> new, for roots include/, src/, test/ and .
    for old, new in table:
        for root in ('include/', 'src/', 'test/'):
            if old.startswith(root):
                short = new
                for new_root in ('include/', 'src/', 'test/'):
                    if new.startswith(new_root):
                        short = new[len(new_root):]
                headers[old[len(root):]] = short
    for f in tree.of('.cpp', '.hpp', '.inc'):
        folder, now = os.path.dirname(f), os.path.dirname(new_of.get(f, f))
        def include(m):
            path = m.group(2)
            beside = os.path.normpath(os.path.join(folder, path))
            if beside in tree.text:
                return m.group(1) + os.path.relpath(new_of.get(beside, beside), now) + m.group(3)
            if path in headers:
                return m.group(1) + headers[path] + m.group(3)
            return m.group(0)
        tree.text[f] = sort_includes(re.sub(r'^(#include ["<])([\w/.]+)([">])', include, tree.text[f], flags=re.M))
    # paths and `folder/stem` in all other texts
    long_table = sorted(((o, n) for o, n in table), key=lambda x: -len(x[0]))
    stems = {}
    for old, new in table:
        o, n = old.split('/'), new.split('/')
        if old.endswith(('.hpp', '.cpp')) and len(o) >= 2:
            key, value = '/'.join(o[-2:]).rsplit('.', 1)[0], '/'.join(n[-2:]).rsplit('.', 1)[0]
            stems[key] = value
    stem_pattern = re.compile(r'(?<![\w/])(' + '|'.join(sorted(map(re.escape, stems), key=len, reverse=True)) + r')(?![\w/-])')
    folder_names = [(o.rstrip('/'), n.rstrip('/')) for o, n in FOLDERS]
    long_pattern = re.compile(r'(?<![\w/])(' + '|'.join(re.escape(o) for o, _ in long_table) + r')(?![\w])')
    long_of = dict(long_table)
    for f in list(tree.text):
        if re.match(r'CHANGELOG|docs/(archive|proof)/', f):
            continue
        text = tree.text[f]
        if f.endswith(('.cpp', '.hpp', '.inc', '.md', '.txt', '.cmake', '.in', '.py', '.yml', '.clang-tidy', 'Makefile')) or f.startswith(('scripts/', '.ci/', 'Dockerfile')):
            text = long_pattern.sub(lambda m: long_of[m.group(1)], text)
            for o, n in folder_names:
                text = re.sub(r'(?<![\w/])' + re.escape(o) + r'(?=[/"\'`*\s,)]|$)', n, text)
            text = stem_pattern.sub(lambda m: stems[m.group(1)], text)
        if f.endswith('.md'):
            for o, n in STAGES.items():
                text = re.sub(r'`' + o + r'/`', '`' + n + '/`', text)
                text = re.sub(r'`' + o + r'/(?=\w)', '`' + n + '/', text)
            text = text.replace('`src/reference', '`simulator').replace('`test/strangers`', '`test/out_of_model`')
        if f == 'CONTRIBUTING.md':
            for o, n in STAGES.items():
                text = text.replace(f'`{o}`', f'`{n}`')
        tree.text[f] = special(f, text)


def sort_includes(text):
    """Each block of #include lines in clang-format's order is left to clang-format; here nothing is moved."""
    return text


def special(f, text):
    if f in ('test/architecture/walls_test.cpp', 'test/architecture/lengths_test.cpp', 'test/architecture/documents_test.cpp', 'test/architecture/citations_test.cpp'):
        for o, n in STAGES.items():
            text = re.sub(r'"' + o + r'"', f'"{n}"', text)
        text = text.replace('kRoot / "src" / "reference"', 'kRoot / "simulator"').replace('"reference/"', '"simulator/"')
        text = text.replace('"battery_sof/diagnose/', '"battery_sof/diagnosis/')
    if f == 'test/architecture/lengths_test.cpp':
        text = text.replace('{"src", "include", "tools"', '{"src", "include", "simulator", "tools"')
    if f == 'test/architecture/citations_test.cpp':
        text = text.replace('"scripts", "src",', '"scripts", "simulator", "src",')
    if f == 'test/tools/style_test.py':
        text = text.replace('("src", "include", "test"', '("src", "include", "simulator", "test"')
    if f == '.clang-tidy':
        text = text.replace('(include/battery_sof|src)/', '(include/battery_sof|simulator|src)/')
    if f == 'tools/battery_sof_tools/tidy.py':
        text = text.replace('entry["file"].startswith(os.path.join(ROOT, "src") + os.sep)', 'entry["file"].startswith((os.path.join(ROOT, "src") + os.sep, os.path.join(ROOT, "simulator") + os.sep))')
    if f == 'CMakeLists.txt':
        text = text.replace('PUBLIC src)', 'PUBLIC "${PROJECT_SOURCE_DIR}")')
        text = text.replace('draw_stranger', 'draw_out_of_model')
        text = re.sub(r'_reference\b', '_simulator', text).replace('reference_sources', 'simulator_sources').replace('reference_bag', 'simulator_bag')
        text = text.replace('# The reference: an independent', '# The simulator: an independent')
    if f.startswith('test/') and (f.endswith('.cmake') or f.endswith('CMakeLists.txt')) or f.startswith('bench/CMake') or f.startswith('cmake/') or f == 'Makefile':
        text = text.replace('draw_stranger', 'draw_out_of_model')
        text = re.sub(r'battery_sof_reference\b', 'battery_sof_simulator', text).replace('reference_test', 'simulator_test')
        for o, n in STAGES.items():
            text = re.sub(r'\bunit/' + o + r'\b', f'unit/{n}', text)
            text = re.sub(r'\b' + o + r'_test\b', f'{n}_test', text)
        text = text.replace('unit/reference', 'unit/simulator').replace('test/strangers', 'test/out_of_model').replace('/strangers', '/out_of_model')
    return text
