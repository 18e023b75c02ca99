"""Words in comments, strings and pages: WORDS.md, "Words in texts", where a replacement is safe. The rest is listed in tools/rename_0_3/left.txt."""
import io, re, tokenize

# (pattern, replacement); a capital at the beginning of a match stays one
SAFE = [(re.compile(p, re.I), r) for p, r in [
    (r'\bfamily of physics\b', 'mechanism'), (r'\bfamilies of physics\b', 'mechanisms'), (r'\bfamily\b', 'mechanism'), (r'\bfamilies\b', 'mechanisms'),
    (r'\bnaive\b', 'baseline'), (r'\ba learnt force\b', 'a discrepancy model'), (r'\bthe learnt force\b', 'the discrepancy model'), (r'\blearnt forces?\b', 'discrepancy model'),
    (r'\b(what) (was|is) learnt\b', r'\1 \2 estimated'), (r'\blearnt\b', 'estimated'),
    (r'\bnot vouched for\b', 'not supported'), (r'\bvouched for\b', 'supported'), (r'\bvouch for\b', 'support'), (r'\bvouches for\b', 'supports'), (r'\bvouch\b', 'support'),
    (r'\bstands for\b', 'represents'), (r'\bstand for\b', 'represent'), (r'\banew\b', 'again'),
    (r'\bnot to be told apart here from\b', 'not distinguishable here from'), (r'\btold apart\b', 'distinguished'), (r'\btell apart\b', 'distinguish'), (r'\btells apart\b', 'distinguishes'), (r'\btells (\w+) apart\b', r'distinguishes \1'), (r'\btell (\w+) apart\b', r'distinguish \1'), 
    (r'\bnothing is told\b', 'nothing is reported'), (r'\b(is|are|be|was|were|been) told of\b', r'\1 reported'), (r'\b(is|are|be|was|were|been) told\b', r'\1 reported'),
    (r'\btold\b', 'reported'), (r'\btells\b(?! (?:a|an|you|us)\b)', 'reports'),
    (r'\bwho imposes what\b', 'operating mode'), (r'\bimposes\b', 'controls'), (r'\bimposed\b', 'controlled'), (r'\bimpose\b', 'control'), (r'\bimposing\b', 'controlling'),
    (r'\bpassed (crank|charge|event)s?\b', lambda m: 'previous ' + m.group(0).split()[1]),
    (r'\bruns beside the base model and answers while it errs less\b', 'runs with the base model and answers while its error is smaller'), (r'\bwhile it errs less\b', 'while its error is smaller'),
    (r'\b(rows?) of blocks\b', 'series string'), (r'\bblocks of 12 V in a row\b', 'blocks of 12 V in series'), (r'\bblocks in a row\b', 'blocks in series'), (r'\b12 V blocks in a row\b', '12 V blocks in series'),
    (r'\bsuitability\b', 'window quality'), (r'\bwhat could hide\b', 'detection limits'),
    (r'\bstrangers\b', 'out-of-model cases'), (r'\bstranger\b', 'out-of-model case'), (r'\bmixed drive\b', 'mixed mode'), (r'\bset beside\b', 'compared with'),
    (r'\bmended\b', 'fixed'), (r'\bnot to be relied on\b', 'outside the identified range'),
]]
LABELS = [('"told apart by  "', '"distinguish by "'), ('"Of what is missing the kind is known and the form is not: "', '"Missing mechanism, of which no equation of the catalogue fits: "'),
          ('in a way that no family of effects explains', 'in a way that no mechanism explains'), ('"[V] RMS below which nothing is told; half the noise', '"smallest RMS effect that is reported [V]; half the noise'),
          ('"suitability  %.2f of the window for this model', '"quality      %.2f of the window for this model'), ('"window quality  %.2f', '"quality      %.2f'), ('wrapped("family       ', 'wrapped("mechanism    '),
          ('wrapped("learnt       ', 'wrapped("discrepancy  '), ('wrapped("hidden       ', 'wrapped("limits       '), ('wrapped("outside      ', 'wrapped("unobservable '), ('wrapped("left         ', 'wrapped("unexplained  ')]
# what is left for hands: counted by file in left.txt
REST = re.compile(r'\b(beside|tell|wants?|straight lines?|alarms?|firm|nats|decoys?|nulls?|sealed|comes? in|came in|errs?|what is left|matters?|asked|asks|put into|forces?|columns?|lanes?|temper(?:ed)?|drives?|share|other forms?|Q_dyn|learns?)\b', re.I)
SIM_LABELS = re.compile(r'(simulator|test/unit/simulator)/(case_|draw_case)|tools/battery_sof_tools/(proof|fleet)/|test/proof/')


def shaped(old, new):
    return new[0].upper() + new[1:] if old[0].isupper() and new else new


def safe(text, f=''):
    for pattern, new in SAFE:
        if SIM_LABELS.match(f) and 'famil' in pattern.pattern:
            continue
        text = pattern.sub(lambda m: shaped(m.group(0), new(m) if callable(new) else m.expand(new)), text)
    # an article before a word that begins otherwise now
    return re.sub(r'\b([Aa])n? (estimated|out-of-model|operating)\b', lambda m: m.group(1) + 'n ' + m.group(2), text)


def outside_code(text, f):
    """Prose of a page or comment; words in `code` stay."""
    parts = re.split(r'(`[^`\n]*`|\]\([^)\n]*\)|<[^>\n]*>)', text)
    return ''.join(p if k % 2 else safe(p, f) for k, p in enumerate(parts))


def is_prose(string):
    return ' ' in string.strip('"\' ') and not re.match(r'"[a-z-]+=\\"', string)


def cpp(f, text, pieces):
    out = []
    page = re.search(r'src/report/page_|diagnosis_page|test/page/', f)
    for kind, t in pieces(text):
        if kind == 'comment':
            t = outside_code(t, f)
        elif kind == 'string' and t.startswith('"'):
            if page:
                t = t.replace('imposed', 'controlled')
            if is_prose(t):
                t = safe(t, f)
        out.append(t)
    return ''.join(out)


def python(f, text):
    try:
        tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    except (tokenize.TokenError, IndentationError, SyntaxError):
        return text
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    at = lambda where: starts[where[0] - 1] + where[1]
    for token in reversed(tokens):
        if token.type not in (tokenize.STRING, tokenize.COMMENT):
            continue
        s = token.string
        if token.type == tokenize.STRING and (' ' not in s or re.search(r'SELECT|INSERT|CREATE|TEXT', s)):
            continue
        if re.match(r'[rR]?[fF]', s):
            new = ''.join(p if k % 2 else outside_code(p, f) for k, p in enumerate(re.split(r'(\{[^{}]*\})', s)))
        else:
            new = outside_code(s, f)
        if new != s:
            text = text[:at(token.start)] + new + text[at(token.end):]
    return text


def slug(title):
    return re.sub(r'[^\w\- ]', '', re.sub(r'[`*]', '', title).strip().lower()).replace(' ', '-')


def headings(tree):
    return {f: [m.group(1) for m in re.finditer(r'(?m)^#+ (.*)$', tree.text[f])] for f in tree.of('.md')}


def anchors(tree, before):
    """Links and citations to headings whose words changed."""
    after = headings(tree)
    for f, old in before.items():
        moved = {slug(o): slug(n) for o, n in zip(old, after[f]) if slug(o) != slug(n)}
        if not moved:
            continue
        name = re.escape(f.rsplit('/', 1)[-1])
        for g, text in tree.text.items():
            if re.match('CHANGELOG', g) or '#' not in text:
                continue
            if '#' not in text or f.rsplit('/', 1)[-1] + '#' not in text and g != f:
                continue
            for o, n in moved.items():
                text = re.sub(r'(' + name + r'#)' + re.escape(o) + r'(?![\w-])', lambda m: m.group(1) + n, text)
                if g == f:
                    text = re.sub(r'(\]\(#)' + re.escape(o) + r'\)', lambda m: m.group(1) + n + ')', text)
            tree.text[g] = text


def apply(tree):
    from rename_pieces import pieces
    before = headings(tree)
    for f in tree.of('.cpp', '.hpp', '.inc'):
        text = tree.text[f]
        for old, new in LABELS:
            text = text.replace(old, new)
        tree.text[f] = cpp(f, text, pieces)
    for f in tree.of('.md', '.msg', '.srv', '.launch', under=r'(?!docs/(archive|proof|decisions)|CHANGELOG)'):
        code, out = False, []
        for line in tree.text[f].splitlines(keepends=True):
            if line.startswith('```'):
                code = not code
            text = line if code or line.startswith('    ') and f.endswith('.md') or re.match(r'(string|float64|bool|uint\d+)(\[\])? \w+ *=', line) else outside_code(line, f)
            if f.endswith('.md') and (code or line.startswith('    ')):
                for old, new in (('    family       ', '    mechanism    '), ('    learnt       ', '    discrepancy  '), ('    hidden       ', '    limits       '), ('    outside      ', '    unobservable ')):
                    text = text.replace(old, new)
                text = re.sub(r'^suitability  ', 'quality      ', text)
            if f.endswith(('.msg', '.srv')):
                body, mark, comment = line.partition('#')
                text = body + mark + (safe(comment, f) if mark else '')
            out.append(text)
        tree.text[f] = ''.join(out)
    for f in tree.of('.yaml', under='config/'):
        tree.text[f] = re.sub(r'#[^\n]*', lambda m: outside_code(m.group(0), f), tree.text[f])
    for f in tree.of('.py', '', under=r'(tools|scripts|test|python|examples)/'):
        if f.endswith('.py') or re.match(r'#!.*python', tree.text[f]):
            tree.text[f] = python(f, tree.text[f])
    for f in ('src/report/page/page.css', 'src/report/page/page.js'):
        if f in tree.text:
            tree.text[f] = tree.text[f].replace('imposed', 'controlled')
    anchors(tree, before)
    counts = []
    for f in tree.of('.cpp', '.hpp', '.inc', '.md', '.msg', '.srv', '.launch', under=r'(src|include|msg|srv|launch|README|docs/(?!archive|proof|decisions))'):
        text = tree.text[f]
        if f.endswith(('.cpp', '.hpp', '.inc')):
            text = '\n'.join(t for kind, t in pieces(text) if kind == 'comment' or kind == 'string' and is_prose(t))
        for n, line in enumerate(text.splitlines(), 1):
            for m in REST.finditer(line):
                counts.append(f'{m.group(0).lower()}\t{f}\t{line.strip()[:150]}')
    with open('tools/rename_0_3/left.txt', 'w') as file:
        file.write('\n'.join(sorted(counts)) + '\n')
