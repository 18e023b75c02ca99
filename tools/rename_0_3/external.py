"""External names: CONTRACT.md, "Changes of 0.3". Runs on a tree after `names`."""
import re


def sub(tree, f, *pairs, need=True):
    """Literal or compiled replacements in one file; says which found nothing."""
    if f not in tree.text:
        print('external: no file', f)
        return
    text = tree.text[f]
    for old, new in pairs:
        after = re.sub(old, new, text) if not isinstance(old, str) else text.replace(old, new)
        if after == text and need:
            print('external:', f, 'has no', old if isinstance(old, str) else old.pattern)
        text = after
    tree.text[f] = text


R = re.compile


def keys(tree, f, table, need=False):
    sub(tree, f, *[(f'"{old}"', f'"{new}"') for old, new in table.items()], need=need)


MODEL_KEYS = {'std': 'std_error', 'suitability': 'window_quality', 'force': 'discrepancy', 'blocks': 'series_blocks',
              'learned': 'residual_regression', 'naive': 'baseline', 'experience': 'event_history', 'least_current_a': 'min_current_a',
              'force_memory': 'regressor_memory', 'family': 'mechanism', 'columns': 'regressors'}
DIAGNOSIS_KEYS = {'family': 'mechanism', 'families': 'mechanisms', 'learned': 'discrepancy', 'naive': 'baseline', 'naive_line': 'baseline_line',
                  'detectable': 'detection_limits', 'absorption': 'parameter_bias', 'source': 'charger_share', 'outside': 'unobservable',
                  'tied_with': 'indistinguishable_from', 'temper': 'effective_sample_fraction'}
# absorbed_into: CONTRACT.md lists the key and does not change it. WORDS.md would have it biased_parameters: one line here.


def messages(tree):
    field = lambda old, new: (R(r'(?m)^(\w[\w/\[\]]* )' + old + r'\b( *)'),
                              lambda m: m.group(1) + new + ' ' * max(1, len(m.group(2)) + len(old) - len(new)) if m.group(2) else m.group(1) + new)
    sub(tree, 'msg/SofStatus.msg', field('suitability', 'window_quality'), field('source_seen', 'charger_present'), field('source_share', 'charger_share'),
        field('voltage_drives', 'voltage_controlled'), ('adopt_diagnosis', 'use_diagnosis'))
    sub(tree, 'msg/EventRecord.msg', field('given', 'stimulus'), field('inside_share', 'coverage'), field('naive_mean_abs_error', 'baseline_mean_abs_error'),
        ('"model" or "naive"', '"model" or "baseline"'))
    sub(tree, 'msg/Diagnosis.msg', field('family', 'mechanism'), field('left_rmse', 'unexplained_rmse'), (R(r'(?m)^string\[\] outside     '), 'string[] unobservable'),
        ('string NAMED=named', 'string EFFECT=effect'),
        (R(r'# something is missing that the catalogue does not explain\nstring UNKNOWN=unknown'),
         '# a known mechanism is missing, and no equation of the catalogue fits\nstring MECHANISM=mechanism\n'
         '# something is missing whose mechanism is not known\nstring UNEXPLAINED=unexplained'),
        ('none unless the verdict is named, several', 'none unless the verdict is effect, several'),
        ('(parameter blocks)', '(parameter series_blocks)'), ('[0, 1] of the family', '[0, 1] of the mechanism'), need=False)
    sub(tree, 'msg/DiagnosisCandidate.msg', field('family', 'mechanism'))
    sub(tree, 'msg/DiagnosisEffect.msg', field('family', 'mechanism'), field('tied_with', 'indistinguishable_from'), (R(r'(?m)^string\[\] absorbed_into     '), 'string[] biased_parameters '),
        ('that its family is', 'that its mechanism is'), ('shared among those tied with it', 'shared among those indistinguishable from it'), need=False)
    sub(tree, 'msg/IdentifiedModel.msg', field('suitability', 'window_quality'), ('(parameter blocks)', '(parameter series_blocks)'))


def reports(tree):
    keys(tree, 'src/report/diagnosis_results.cpp', DIAGNOSIS_KEYS)
    sub(tree, 'src/report/diagnosis_results.cpp', ('"battery_sof/diagnosis/1"', '"battery_sof/diagnosis/2"'), ('{"imposed", operatingModeJson(', '{"operating_mode", operatingModeJson('),
        (R(r'\{"imposed", (toString\(totals\.mode\)\})'), r'{"mode", \1'),
        ('          {"probability", d.mechanism && d.probability', '          {"mechanisms", mechanismsJson(d)},\n          {"probability", d.mechanism && d.probability'),
        ('nlohmann::json diagnosisJson(const Diagnosis& d) {',
         'namespace {\n\n/// Those whose probabilities add up to 0.9, likeliest first: at present the one of the verdict.\n'
         'Json mechanismsJson(const Diagnosis& d) {\n  Json mechanisms = Json::array();\n  if (d.mechanism)\n'
         '    mechanisms.push_back({{"id", mechanismId(*d.mechanism)}, {"probability", d.probability > 0.0 ? number(d.probability) : Json(nullptr)}});\n'
         '  return mechanisms;\n}\n\n}  // namespace\n\nnlohmann::json diagnosisJson(const Diagnosis& d) {'))
    sub(tree, 'src/report/diagnosis_results.cpp', ('--confirm ID', '--verify-detection-limits ID'))
    keys(tree, 'src/report/results.cpp', {'std': 'std_error', 'suitability': 'window_quality', 'blocks': 'series_blocks', 'naive': 'baseline'})
    for f in ('model_writing', 'model_regressions', 'model_equations', 'model_yaml', 'discrepancy_yaml'):
        keys(tree, f'src/report/{f}.cpp', MODEL_KEYS)
    keys(tree, 'src/report/catalogue.cpp', {'family': 'mechanism', 'families': 'mechanisms', 'bends': 'is_nonlinear'})
    sub(tree, 'src/report/catalogue.cpp', ('padded("mechanism", mechanism_width)', 'padded("mechanism", mechanism_width)'), ('| id | code | family | title |', '| id | code | mechanism | title |'),
        ('\\n\\nfamily\\n', '\\n\\nmechanism\\n'), need=False)
    for f in ('check_command', 'diagnose_command', 'identify_command'):
        keys(tree, f'src/cli/{f}.cpp', {'blocks': 'series_blocks'})
    keys(tree, 'src/report/check_report.cpp', {'imposed': 'mode', 'least_current_a': 'min_current_a'})
    sub(tree, 'include/battery_sof/report/model_yaml.hpp', ('"battery_sof/model/1"', '"battery_sof/model/2"'))
    sub(tree, 'src/report/model_yaml.cpp',
        ('  if (schema != kModelSchema) root.fail("schema",',
         '  if (schema == "battery_sof/model/1")\n    root.fail("schema", "is of battery_sof 0.2, whose names are others; write the model anew: sof identify REC --out MODEL.yaml");\n'
         '  if (schema != kModelSchema) root.fail("schema",'))
    sub(tree, 'include/battery_sof/model/discrepancy_model.hpp', ('kDiscrepancyEffect = "learned"', 'kDiscrepancyEffect = "discrepancy"'))
    for f in tree.of('.cpp', '.hpp', under='(src|include)/'):
        tree.text[f] = tree.text[f].replace('effect "learned"', 'effect "discrepancy"').replace('of "learned" among', 'of "discrepancy" among')


def verdicts(tree):
    for f in tree.of('.cpp', '.hpp'):
        text = tree.text[f]
        if 'Verdict::k' not in text and 'enum class Verdict' not in text:
            continue
        text = text.replace('Verdict::kNamed', 'Verdict::kEffect')
        text = re.sub(r'( *)case Verdict::kUnknown:', r'\1case Verdict::kMechanism:\n\1case Verdict::kUnexplained:', text)
        text = text.replace('    case Verdict::kMechanism:\n    case Verdict::kUnexplained: return "unknown";',
                            '    case Verdict::kMechanism: return "mechanism";\n    case Verdict::kUnexplained: return "unexplained";')
        text = text.replace('    case Verdict::kMechanism:\n    case Verdict::kUnexplained: return "Unknown physics";',
                            '    case Verdict::kMechanism: return "A mechanism without an equation";\n    case Verdict::kUnexplained: return "Unexplained";')
        text = text.replace('return "named";', 'return "effect";') if f.endswith('verdict.cpp') else text
        if f == 'src/diagnosis/stage_name.cpp':
            text = text.replace('judged.verdict == Verdict::kUnknown', 'hasNoEquation(judged.verdict)')
        if f.endswith('/diagnose_test.cpp'):
            text = text.replace('EXPECT_EQ(Verdict::kUnknown, diagnosis.verdict)', 'EXPECT_TRUE(hasNoEquation(diagnosis.verdict))')
            text = text.replace('EXPECT_EQ(Verdict::kUnknown, cell.verdict)', 'EXPECT_TRUE(hasNoEquation(cell.verdict))')
        text = text.replace('Verdict::kUnknown', 'Verdict::kUnexplained')
        tree.text[f] = text
    sub(tree, 'include/battery_sof/diagnosis/diagnosis.hpp', (R(r'kNamed,  '), 'kEffect, '),
        (R(r'  kUnknown,           ///< something is missing that the catalogue does not explain'),
         '  kMechanism,         ///< a known mechanism is missing, and no equation of the catalogue fits\n  kUnexplained,       ///< something is missing whose mechanism is not known'),
        ('"no_mismatch", "named", "several", "ambiguous", "unknown",', '"no_mismatch", "effect", "several", "ambiguous", "mechanism", "unexplained",'),
        (R(r'(std::string toString\(Verdict verdict\);)'), r'\1\n\n/// Whether something is missing that no equation of the catalogue fits.\n'
         r'inline bool hasNoEquation(Verdict verdict) { return verdict == Verdict::kMechanism || verdict == Verdict::kUnexplained; }'))
    sub(tree, 'src/diagnosis/stage_judge.cpp', (R(r'(\n  judged\.candidates = candidatesOf\()'),
        r'\n  if (judged.verdict == Verdict::kUnexplained && judged.mechanism) judged.verdict = Verdict::kMechanism;\1'))
    for f in ('live/live.css', 'src/report/page/page.css'):
        sub(tree, f, ('.badge.unknown', '.badge.mechanism, .badge.unexplained'), ('.badge.named', '.badge.effect'), need=False)


def options(tree):
    sub(tree, 'src/cli/command.hpp', (R(r'(void addSeriesBlocksOption\()'),
        r'/// An option of 0.2 under its old name: refused with the new one.\nvoid addRenamedOption(CLI::App& command, const std::string& old, const std::string& now);\n\n\1'))
    sub(tree, 'src/cli/command.cpp', (R(r'(?m)^(void addSeriesBlocksOption\()'),
        'void addRenamedOption(CLI::App& command, const std::string& old, const std::string& now) {\n'
        '  command\n      .add_option_function<std::vector<std::string>>(\n'
        '          old, [old, now](const std::vector<std::string>&) { throw CLI::ValidationError(old, "is " + now + " since 0.3"); })\n'
        '      ->expected(0, CLI::detail::expected_max_vector_size)\n      ->group("");\n}\n\n\\1'),
        ('.add_option("--blocks"', '.add_option("--series-blocks"'), ('"--blocks is %g', '"--series-blocks is %g'),
        (R(r'(bounds and limits are those of one"\)\n      ->capture_default_str\(\);)'), r'\1\n  addRenamedOption(command, "--blocks", "--series-blocks");'))
    sub(tree, 'src/cli/predict_command.cpp', ('->add_option("--drive"', '->add_option("--mode"'), ('"--drive mixed: "', '"--mode mixed: "'),
        (R(r'(->check\(CLI::IsMember\(\{"mixed", "current"\}\)\);)'), r'\1\n  addRenamedOption(*command, "--drive", "--mode");'))
    sub(tree, 'src/cli/diagnose_command.cpp', ('->add_option("--confirm"', '->add_option("--verify-detection-limits"'),
        ('"--relevance-rmse"', '"--min-rmse"'), ('"--relevance-crank"', '"--min-crank"'), ('"--relevance-charge"', '"--min-charge"'),
        (R(r'(\n  addPriorsOptions\(\*command, arguments->priors\);)'),
         r'\n  addRenamedOption(*command, "--confirm", "--verify-detection-limits");'
         r'\n  for (const std::string limit : {"rmse", "crank", "charge"}) addRenamedOption(*command, "--relevance-" + limit, "--min-" + limit);\1'))
    sub(tree, 'completion/sof.bash', ('--confirm', '--verify-detection-limits'), ('--drive)', '--mode)'))
    for f in tree.of('.cpp', '.hpp', '.py', '.md', '.inc', '.js', '.cmake', '', under=r'(src|include|simulator|test|tools|scripts|docs/(?!archive|proof|decisions|cases)|README|examples|live|experiments|bench)'):
        text = tree.text[f]
        if f.startswith(('src/cli/', 'simulator/')) and f.endswith(('.cpp', '.hpp')):
            continue
        text = re.sub(r'(?<![\w-])--confirm(?![\w-])', '--verify-detection-limits', text)
        text = re.sub(r'(?<![\w-])--blocks(?![\w-])', '--series-blocks', text)
        text = re.sub(r'(?<![\w-])--relevance-(rmse|crank|charge)\b', r'--min-\1', text)
        text = re.sub(r'(?<![\w-])--relevance-\*', '--min-*', text)
        text = re.sub(r'(?<![\w-])--drive( mixed| current|[\'"], ?[\'"](?:mixed|current)|=(?:mixed|current))', r'--mode\1', text)
        tree.text[f] = text


def node(tree):
    f = 'src/ros/node_options.cpp'
    sub(tree, f, ('"blocks"', '"series_blocks"'), ('"min_suitability"', '"min_window_quality"'), ('"adopt_diagnosis"', '"use_diagnosis"'),
        ('~blocks', '~series_blocks'), ('~adopt_diagnosis', '~use_diagnosis'),
        ('        faults.push_back(prefix + key + " is unknown; known are " + known());',
         '        const auto renamed = kRenamed.find(key);\n'
         '        faults.push_back(prefix + key + (renamed == kRenamed.end() ? " is unknown; known are " + known() : " is " + renamed->second + " since 0.3"));'),
        (R(r'\nclass Schema \{'), '\n/// Parameters of 0.2 under their old names.\n'
         'const std::map<std::string, std::string> kRenamed = {\n'
         '    {"blocks", "series_blocks"}, {"adopt_diagnosis", "use_diagnosis"}, {"min_suitability", "min_window_quality"}};\n\nclass Schema {'))
    for f in tree.of('.cpp', '.hpp', '.yaml', '.launch', '.py', '.test', '.md', '.msg', '.srv', '', under=r'(src|include|config|launch|test|README|docs/(?!archive|proof|decisions)|tools|scripts|examples|msg|srv)'):
        text = tree.text[f]
        text = re.sub(r'~blocks\b', '~series_blocks', text)
        text = re.sub(r'\badopt_diagnosis\b(?!")', 'use_diagnosis', text) if f != 'src/ros/node_options.cpp' else text
        text = re.sub(r'\bmin_suitability\b(?!")', 'min_window_quality', text) if f != 'src/ros/node_options.cpp' else text
        if f.endswith('.py') or f.startswith(('test/', 'scripts/')) and not f.endswith(('.cpp', '.hpp')):
            text = re.sub(r'(["\'])(adopt_diagnosis)\1', r'\1use_diagnosis\1', text)
            text = re.sub(r'(["\'])(min_suitability)\1', r'\1min_window_quality\1', text)
        tree.text[f] = text
    sub(tree, 'config/battery_sof.yaml', (R(r'(?m)^blocks:'), 'series_blocks:'), ('times blocks', 'times series_blocks'), need=False)
    sub(tree, 'src/ros/status_conversion.cpp', ('? "naive" : "model"', '? "baseline" : "model"'), (R(r'\b(record|message)\.given\b'), r'\1.stimulus'), need=False)
    for f in tree.of('.cpp', '.hpp', under='(src/ros|test/unit/ros|examples)/'):
        text = tree.text[f]
        text = re.sub(r'\b(record|message|past_cranks|past_charges|event|cranks|charges|one)\.given\b', r'\1.stimulus', text)
        text = re.sub(r'\b(record|past_cranks|past_charges|cranks|charges)\.inside_share\b', r'\1.coverage', text)
        text = re.sub(r'\b(message|response\.diagnosis)\.outside\b', r'\1.unobservable', text)
        text = text.replace('Message::NAMED', 'Message::EFFECT').replace('Diagnosis::NAMED', 'Diagnosis::EFFECT')
        text = text.replace('Message::UNKNOWN', 'Message::UNEXPLAINED').replace('Diagnosis::UNKNOWN', 'Diagnosis::UNEXPLAINED')
        tree.text[f] = text
    for f in tree.of('.test', '.launch', '.yaml', under='(test|launch)/'):
        tree.text[f] = re.sub(r'(name="|^)blocks(?=[":])', r'\1series_blocks', tree.text[f], flags=re.M)
    sub(tree, 'config/plotjuggler_layout.xml', ('status/suitability', 'status/window_quality'), ('state and suitability', 'state and window quality'))


FIELDS = {'inside_share': 'coverage', 'given': 'stimulus', 'naive_mean_abs_error': 'baseline_mean_abs_error', 'suitability': 'window_quality', 'voltage_drives': 'voltage_controlled',
          'source_seen': 'charger_present', 'source_share': 'charger_share', 'left_rmse': 'unexplained_rmse', 'tied_with': 'indistinguishable_from'}


def readers(tree):
    """Python, JavaScript and pages that read messages and JSON."""
    python = tree.of('.py', under='(tools|scripts|test|examples|python)/') + [f for f in tree.of('', under='scripts/') if tree.text[f].startswith('#!/usr/bin/') and 'python' in tree.text[f][:30]]
    for f in python:
        text = tree.text[f]
        sealed = re.search(r'/proof/|test/proof', f)
        fleet = '/fleet/' in f or 'fleet_test' in f
        for old, new in FIELDS.items():
            if old == 'given':
                text = re.sub(r'\b(last|past_cranks|past_charges|record|event|cranks|charges)\.given\b', r'\1.stimulus', text)
                text = re.sub(r'(past_\w+[^\n]*)"given"', r'\1"stimulus"', text)
                continue
            if fleet and old == 'suitability':
                text = text.replace('one["suitability"], model', 'one["window_quality"], model').replace('(one["model"]["share_percent"], one["suitability"]', '(one["model"]["share_percent"], one["window_quality"]')
                text = re.sub(r'\b(answer|fit|ends)((?:\.get\(|\[)")suitability"', r'\1\2window_quality"', text)
                continue
            if old == 'suitability' and 'study' in f:
                text = text.replace('["suitability"]', '["suitability"]')
                continue
            text = re.sub(r'(?<=\.)' + old + r'\b', new, text)
            text = re.sub(r'(["\'])' + old + r'\1', r'\1' + new + r'\1', text)
        if not sealed and not fleet:
            text = re.sub(r'(["\'])family\1', r'\1mechanism\1', text)
            text = re.sub(r'(["\'])families\1', r'\1mechanisms\1', text)
            text = text.replace('--family', '--mechanism') if 'out_of_model' in f or '/real/' in f or 'test/tools' in f else text
        if sealed:
            text = text.replace('"family": e.get("family")', '"mechanism": e.get("mechanism")').replace('"family": diagnosis.get("family")', '"mechanism": diagnosis.get("mechanism")')
            text = text.replace('("id", "evidence", "family", ', '("id", "evidence", "mechanism", ')
            text = re.sub(r'(answer\((?:[^()]|\([^()]*\))*?)\bfamily=', r'\1mechanism=', text)
            text = text.replace('told["families"]', 'told["mechanisms"]')
        if fleet:
            text = re.sub(r'\b(answer|label)((?:\.get\(|\[)")family"', r'\1\2mechanism"', text)
            if f.endswith('rows.py'):
                text = re.sub(r'\bone\["family"\]', 'one["mechanism"]', text)
            text = text.replace('"family": "acid"', '"mechanism": "acid"')
        text = re.sub(r'\b(answer|ahead|diagnosis|one|f)((?:\.get\(|\[)")naive(_line)?"', r'\1\2baseline\3"', text)
        text = text.replace('"naive": {"rmse_v"', '"baseline": {"rmse_v"').replace('"naive_line": {"rmse_v"', '"baseline_line": {"rmse_v"').replace('"naive": ahead', '"baseline": ahead')
        text = text.replace('value("naive")', 'value("baseline")').replace('("model", "naive")', '("model", "baseline")').replace('(("naive", "0.5")', '(("baseline", "0.5")')
        text = re.sub(r'\b(answer|diagnosis|found|told|json)((?:\.get\(|\[)")detectable"', r'\1\2detection_limits"', text)
        text = re.sub(r'\b(answer|diagnosis|found|told|json)((?:\.get\(|\[)")learned"', r'\1\2discrepancy"', text)
        text = re.sub(r'\b(answer|diagnosis|found|told|json)((?:\.get\(|\[)")absorption"', r'\1\2parameter_bias"', text)
        text = re.sub(r'\b(diagnosis)((?:\.get\(|\[)")(source)"', r'\1\2charger_share"', text)
        if not f.startswith('tools/battery_sof_tools/proof') and not sealed:
            text = text.replace('Diagnosis.NAMED', 'Diagnosis.EFFECT').replace('Diagnosis.UNKNOWN', 'Diagnosis.MECHANISM, Diagnosis.UNEXPLAINED')
            text = re.sub(r'(verdict"?(?:\]|: |=|, ) ?(?:==|!=)? ?)"named"', r'\1"effect"', text)
            text = re.sub(r'(verdict"?(?:\]|: |=|, ) ?(?:==|!=)? ?)"unknown"', r'\1"unexplained"', text)
        text = text.replace('"unknown; ageing"', '"unexplained; ageing"')
        tree.text[f] = text
    sub(tree, 'tools/battery_sof_tools/proof/programs.py', ('"verdict": diagnosis["verdict"],', '"verdict": SEALED_WORDS.get(diagnosis["verdict"], diagnosis["verdict"]),'), need=False)
    f = 'tools/battery_sof_tools/proof/programs.py'
    if f in tree.text and 'SEALED_WORDS = ' not in tree.text[f]:
        tree.text[f] = re.sub(r'(\n\n\n(?:class|def) )', '\n\n# Labels of sealed cases keep the verdicts of the version that sealed them.\n'
                              'SEALED_WORDS = {"effect": "named", "mechanism": "unknown", "unexplained": "unknown"}\\1', tree.text[f], count=1)
    for f in tree.of('.py', under='tools/battery_sof_tools/fleet'):
        tree.text[f] = tree.text[f].replace('"named": "one effect is missing"', '"effect": "one effect is missing"')
        tree.text[f] = re.sub(r'"unknown": ("[^"]*")', r'"mechanism": "a mechanism without an equation", "unexplained": \1', tree.text[f])
    for f in ('live/live.js',):
        sub(tree, f, ('status.suitability', 'status.window_quality'), ("'Suitability'", "'Window quality'"), ('status.voltage_drives', 'status.voltage_controlled'),
            (R(r'\.inside_share\b'), '.coverage'), (R(r'\b(event|record|last)\.given\b'), r'\1.stimulus'), (R(r'\.naive_mean_abs_error\b'), '.baseline_mean_abs_error'),
            (R(r'\.source_share\b'), '.charger_share'), (R(r'\.source_seen\b'), '.charger_present'), need=False)
    for f in tree.of('.cpp', '.hpp', under='examples/'):
        tree.text[f] = re.sub(r'past_cranks\.given', 'past_cranks.stimulus', tree.text[f])
    # the package's own Python
    for f in tree.of('.py', '.pyi', under='(python|test/python)/'):
        text = tree.text[f]
        text = re.sub(r'\bblocks(?=: float| ?=|, threads|,$)', 'series_blocks', text)
        text = re.sub(r'(?m)^    std: Optional', '    std_error: Optional', text).replace('each.std ', 'each.std_error ').replace('blocks: of 12 V', 'series_blocks: of 12 V')
        text = re.sub(r'\bvoltage_drives\b', 'voltage_controlled', text)
        text = re.sub(r'\bsuitability\b', 'window_quality', text)
        text = re.sub(r'\.std\b(?!\()', '.std_error', text)
        text = re.sub(r'\bdrive=(?="|\'|None)', 'mode=', text)
        text = re.sub(r'\bdrive: (?=Optional\[str\])', 'mode: ', text)
        tree.text[f] = text
    sub(tree, 'python/models.cpp', ('arrays["voltage_drives"]', 'arrays["voltage_controlled"]'), ('"blocks is %g', '"series_blocks is %g'), ('"drive is \\""', '"mode is \\""'))
    sub(tree, 'src/prediction/online_session.cpp', ('"blocks is %g', '"series_blocks is %g'))
    sub(tree, 'src/prediction/online_session_answers.cpp', (', blocks is %g', ', series_blocks is %g'))


def simulator(tree):
    for f in tree.of('.cpp', '.hpp', under=r'simulator/(out_of_model|draw_out_of_model)'):
        tree.text[f] = tree.text[f].replace('"family"', '"mechanism"').replace('--family', '--mechanism').replace('kind family form', 'kind mechanism form')


def tests(tree):
    for f in tree.of('.cpp', '.hpp', under='(test|bench|experiments)/'):
        text = tree.text[f]
        if re.search(r'test/(unit/(report|cli|prediction|diagnosis|estimation|ros|model)|support|fuzz|property|page)', f) and 'simulator' not in f:
            text = re.sub(r'((?:\bjson|\bdocument|\bdiagnosis|\bfound|\btold|\banswer|\bd|\bone|\bmodel|\beffect|\bcandidate|\bentry|\boverview|\bcatalogue|\broot|\bnode|\bdiagnosisJson\([^()]*\)|\bidentifyJson\([^()]*\)|\bpredictionJson\([^()]*\)|\])(?:\.at\(|\.contains\(|\[))"(family|families|learned|naive|naive_line|detectable|absorption|outside|tied_with|suitability|force|blocks)"',
                          lambda m: m.group(1) + '"' + {**MODEL_KEYS, **DIAGNOSIS_KEYS, 'learned': 'discrepancy', 'families': 'mechanisms'}[m.group(2)] + '"', text)
            text = text.replace('"battery_sof/diagnosis/1"', '"battery_sof/diagnosis/2"')
            text = re.sub(r'(effects?\(?\)?[^\n]*)"learned"', r'\1"discrepancy"', text)
        tree.text[f] = text


def docs(tree):
    for f in list(tree.text):
        if re.match(r'CHANGELOG|docs/(archive|proof|decisions)/', f):
            continue
        text = tree.text[f].replace('draw_stranger', 'draw_out_of_model')
        text = re.sub(r'\bscripts/strangers\b', 'scripts/out_of_model', text)
        text = re.sub(r'\btest/strangers\b', 'test/out_of_model', text)
        tree.text[f] = text
    if 'docs/cases.md' in tree.text:
        text = re.sub(r'(draw_out_of_model[^\n]*)--family', r'\1--mechanism', tree.text['docs/cases.md']).replace('"kind family form"', '"kind mechanism form"')
        text = text.replace('| `--family`, `--form` |', '| `--mechanism`, `--form` |').replace('the law of `--family`', 'the law of `--mechanism`').replace('has `kind`, `family`, `form`', 'has `kind`, `mechanism`, `form`').replace("the answer's `family`", "the answer's `mechanism`")
        tree.text['docs/cases.md'] = text.replace('--out strangers', '--out out_of_model')
    sub(tree, 'src/ros/node_diagnostics.cpp', ('? "naive" : "model"', '? "baseline" : "model"'), ('"suitability"', '"window quality"'))
    aligned = lambda m: m.group(1).rstrip() + ' ' * max(1, 28 - len(m.group(1).rstrip())) + m.group(2)
    tree.text['config/battery_sof.yaml'] = re.sub(r'(?m)^((?:series_blocks|min_window_quality|use_diagnosis): .*?)(#.*)$', aligned, tree.text['config/battery_sof.yaml'])
    for f in tree.of('.md', under=r'(README|CONTRIBUTING|docs/(?!archive|proof|decisions|cases))'):
        text = tree.text[f]
        for old, new in {**{k: v for k, v in DIAGNOSIS_KEYS.items() if k not in ('source', 'outside')}, **FIELDS, 'suitability': 'window_quality', 'blocks': 'series_blocks',
                         'left_rmse': 'unexplained_rmse', 'named': 'effect', 'unknown': 'unexplained', 'imposed': 'operating_mode'}.items():
            text = re.sub(r'`' + old + r'`', '`' + new + '`', text)
            if old not in ('named', 'unknown', 'given'):
                text = re.sub(r'"' + old + r'":', '"' + new + '":', text)
        text = re.sub(r'`(naive|learned|experience|force)\.', lambda m: '`' + MODEL_KEYS[m.group(1)] + '.', text).replace('`source.least_current_a`', '`source.min_current_a`')
        text = re.sub(r'(draw_out_of_model[^\n]*|`)--family', r'\1--mechanism', text) if f != 'docs/cases.md' else text
        text = text.replace('battery_sof/diagnosis/1', 'battery_sof/diagnosis/2').replace('`learned`', '`discrepancy`')
        text = re.sub(r'\b(status|past_cranks|past_charges)\.(given|inside_share)\b', lambda m: m.group(1) + '.' + FIELDS[m.group(2)], text)
        tree.text[f] = text


def apply(tree):
    messages(tree)
    reports(tree)
    verdicts(tree)
    options(tree)
    node(tree)
    readers(tree)
    simulator(tree)
    tests(tree)
    docs(tree)
