import re
import names

NOT_IN_TEXT = {'contest_duration'}
SIMD = re.compile(r'base_normal_equations|products_kernel|scores_kernel|base_residual|overpotential_(kernel|sweep)|micro_benchmark')
TANGENTS = [(('lane',), ('tangent',)), (('lanes',), ('tangents',))]
INPUTS = re.compile(r'\b(Drive|DriveStep|DriveSample|fullDrive|compressedDrive|driveOf|exactDrive)\b')
SIMULATOR = re.compile(r'src/reference/|test/unit/reference/|simulator/')
SERIES = re.compile(r'(src|include/battery_sof|test/unit)/(predict|ros|cli)/|python/|src/report/(results|model_\w+|check_report)\.|include/battery_sof/(recording/blocks|identify/fitted_model)\.hpp|'
                    r'test/unit/report/|test/unit/recording/blocks_test|test/fuzz/|test/support/|examples/|src/identify/(identification|composition_identification|fitted_model)')


def before_names(f, text):
    """Names that mean different things in different places: told apart by what stands around them."""
    sub = lambda pattern, new: re.sub(pattern, new, text)
    if not SIMULATOR.match(f):
        text = sub(r'\b(fit(?:\.|->))learned\b', r'\1residual_regression')
        text = sub(r'\b(at|out|followed|moved|sample|step)\.learned\b', r'\1.regression_correction')
        text = sub(r'\b(fit(?:\.|->))blocks\b', r'\1series_blocks')
        text = sub(r'\b(options_?|session|session_options|order)\.blocks\b(?=.*)', lambda m: m.group(0)) if False else text
        text = sub(r'\b(stretch|totals|one_stretch)\.imposed\b', r'\1.mode')
        text = sub(r'\bImposed imposed(?= =)', 'ControlMode mode')
        text = sub(r'(\]|totals\.front\(\)|stretches\.front\(\))\.imposed\b', r'\1.mode')
        text = sub(r'\bdouble learned(?= = 0\.0)', 'double regression_correction')
        text = sub(r'\bLeftOver left;', 'LeftOver unexplained;')
        text = sub(r'\b(d|found|diagnosis|learned|made|drawing\.diagnosis|result\.diagnosis)(\.|->)left\b(?!\()', r'\1\2unexplained')
    return text


def local_names(f, text):
    """(names of this file alone, phrases, names left as they are)."""
    local, phrases, without = {}, list(names.PHRASES), set()
    if SIMULATOR.match(f):
        without |= {'drive', 'drive_', 'Drive', 'DriveMode', 'force', 'source', 'Source', 'Discrepancy', 'Component', 'components', 'sentence', 'listed', 'describe', 'wander',
                    'learn', 'absorbed', 'contest', 'tracked', 'component', 'left', 'experience', 'tied', 'hiddenBy'} - {'sentence', 'listed', 'describe'}
        phrases = [p for p in phrases if p[0][0] in ('family', 'families', 'stranger', 'strangers')]
    else:
        phrases += names.FORCE
        if not SIMD.search(f):
            phrases += TANGENTS
            local['kMaxLanes'] = 'kMaxTangents'
        product = re.match(r'(src|include)/', f) and not SIMD.search(f)
        if product or INPUTS.search(text) or re.search(r'\b(ground|rows|learnt)\.drive\b', text):
            local['drive'] = 'inputs'
        if SERIES.match(f):
            local['blocks'] = 'series_blocks'
    if re.search(r'(identify|report)/(learned_residual|follower|window_experience|model_writing|model_lessons|fitted_model)', f) or 'learned_residual_test' in f:
        local['learned'] = 'residual_regression'
        local['learned_'] = 'residual_regression_'
    if re.search(r'range_prediction|predict_command|python/', f):
        local['drive'] = 'mode'
        local['driveOf'] = 'modeOf'
    if re.search(r'diagnose/(explanation|effect_search|explanation_fits|explanation_state)', f):
        local.update(place='linearize', settle='optimize', weigh='evaluateEvidence', polish='refine')
    if re.search(r'predict/(naive_contest|tracked_model|live_model)|naive_contest_test', f):
        local.update(standing='selection', standings='selections', scale_='calibration_')
    if re.search(r'predict/online_session', f):
        local.update(standings='selections')
    if re.search(r'predict/(state_tracker)', f):
        local.update(Place='SimulationPoint', place='point', imposed='given')
    if re.search(r'predict/mixed_scores', f):
        local.update(voltage_imposed='of_voltage')
    if re.search(r'source_overview|page_|check_report|diagnosis_results|made_diagnosis|pages?_test', f):
        local.update(voltage_imposed='voltage_controlled')
    return local, phrases, without


FUNCTIONS = {'sentence', 'listed', 'describe'}


def name_in_context(f, name, parts, n):
    """Functions are told from variables of the same name by what follows."""
    if name in FUNCTIONS:
        before = parts[n - 1][1] if n else ''
        after = parts[n + 1][1] if n + 1 < len(parts) else ''
        if after != '(' or before in ('.', '>' if n > 1 and parts[n - 2][1] == '-' else '.'):
            return name
    return None


def after_names(f, text):
    if f.endswith('faulty_core.cpp'):  # names of symbols in strings
        def symbol(m):
            old = m.group(2)[:int(m.group(1))]
            new = names.renamed(old, {}, names.PHRASES + names.FORCE)
            return f'{len(new)}{new}' + m.group(2)[int(m.group(1)):]
        text = re.sub(r'"_Z\w+"', lambda s: re.sub(r'(\d+)(\D\w*?)(?=\d|"|$)', symbol, s.group(0)), text)
    return text


PY = [p for p in names.PHRASES if p[0][0] in ('naive', 'family', 'families', 'stranger', 'strangers')]
SEALED = {'families': 'mechanisms', 'families_of': 'mechanisms_of', 'by_family': 'by_mechanism', 'family_of': 'mechanism_of', 'naive': 'baseline', 'strangers': 'out_of_model'}


def python_name(f, name):
    if names.is_sentence(name) or name.startswith('test_'):
        return name
    if '/proof/' in f or '/fleet/' in f or 'proof_test' in f or 'fleet_test' in f:
        return SEALED.get(name, name)
    return names.by_phrases(name, PY)


def add_test(tree):
    import wordtest
    wordtest.apply(tree)


def reformat(tree):
    import os, subprocess
    f = '.clang-format'
    tree.text[f] = re.sub(r'ColumnLimit: \d+', 'ColumnLimit: 100', tree.text[f])
    if 'ReflowComments' not in tree.text[f]:
        tree.text[f] = tree.text[f].rstrip('\n') + '\nReflowComments: false\n'
    tree.write()
    sources = [os.path.join(tree.root, f) for f in tree.of('.cpp', '.hpp', under='(src|include|test|bench|experiments|examples|python|simulator)/')]
    for k in range(0, len(sources), 40):
        subprocess.run(['nice', 'clang-format-14', '-i', *sources[k:k + 40]], check=True)
    for f in list(tree.text):  # as they are now
        with open(os.path.join(tree.root, f), encoding='utf-8', newline='') as file:
            tree.text[f] = tree.before[f] = file.read()
