#!/usr/bin/env python3
"""python3 rename.py WORKTREE [--stages names,external,words,test,format,dead] [--dump FILE]

Throwaway: names of battery_sof 0.3 over a clean tree of 0.2. Stages in this order, each leaves a tree that compiles."""
import argparse, io, os, re, subprocess, sys, tokenize
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import names, paths, external, words, extra

from rename_pieces import pieces


def git(root, *arguments):
    return subprocess.run(['git', '-C', root, *arguments], check=True, capture_output=True, text=True).stdout


class Tree:
    """The files of a worktree, read once, written where they changed."""

    def __init__(self, root):
        self.root = root
        self.files = [f for f in git(root, 'ls-files').splitlines() if f and os.path.isfile(os.path.join(root, f))]
        self.text, self.before = {}, {}
        for f in self.files:
            try:
                with open(os.path.join(root, f), encoding='utf-8', newline='') as file:
                    self.text[f] = self.before[f] = file.read()
            except UnicodeDecodeError:
                pass

    def of(self, *endings, under=''):
        return [f for f in self.text if f.endswith(endings) and re.match(under, f)]

    def move(self, table):
        for old, new in table:
            if old not in self.files:
                continue
            os.makedirs(os.path.dirname(os.path.join(self.root, new)), exist_ok=True)
            git(self.root, 'mv', old, new)
            self.files[self.files.index(old)] = new
            if old in self.text:
                self.text[new] = self.text.pop(old)
                self.before[new] = self.before.pop(old)

    def write(self):
        for f, text in self.text.items():
            if text != self.before.get(f):
                with open(os.path.join(self.root, f), 'w', encoding='utf-8', newline='') as file:
                    file.write(text)
                self.before[f] = text


CODE_WORD = re.compile(r'(?<![\w/.-])([A-Za-z]+[A-Za-z0-9]*(?:_[A-Za-z0-9]+)*_?)(?![\w/-]|\.[a-z])')


def looks_like_code(word):
    return '_' in word.strip('_') or bool(re.search(r'[a-z0-9][A-Z]', word)) or word.endswith('_')


def in_prose(text, rename, types):
    """Code words in a comment or a page; whole words of one part only where they are a type's name."""
    def one(m):
        w = m.group(1)
        if looks_like_code(w) or w in types and m.start() and text[m.start() - 1] in '`:<&':
            return rename(w)
        if text[m.end():m.end() + 2] in ('()', '::', '(S') or text[m.start() - 2:m.start()] == '::':
            return rename(w)
        return w
    return CODE_WORD.sub(one, text)


CAMEL = re.compile(r'(?<![\w/.-])[a-z]+[a-z0-9]*(?:[A-Z][a-z0-9]*)+(?=:|\()')


def types_in(comment, rename):
    """Types of one word in the middle of a comment's sentence."""
    def one(m):
        return m.group(1) + rename(m.group(2)) if m.group(2) in TYPES else m.group(0)
    return re.sub(r'([a-z0-9,;(] |\()([A-Z][a-z]+)\b(?!-)', one, comment)


TYPES = {w for w in names.EXACT if w[0].isupper()}


def stage_names(tree, dump):
    used = {}
    clashes = []
    for f in tree.of('.cpp', '.hpp', '.inc'):
        text = extra.before_names(f, tree.text[f])
        local, phrases, without = extra.local_names(f, text)
        def rename(w):
            if w in without:
                return w
            new = names.renamed(w, local, phrases)
            return new
        out, seen, after = [], set(), {}
        parts = list(pieces(text))
        for n, (kind, t) in enumerate(parts):
            if kind == 'name':
                if t.startswith('KEPT_'):
                    out.append(t[5:])
                    continue
                if t in without:
                    out.append(t)
                    continue
                new = extra.name_in_context(f, t, parts, n) or rename(t)
                seen.add(t)
                if new != t:
                    used.setdefault((t, new), set()).add(f)
                    after.setdefault(new, set()).add(t)
                out.append(new)
            elif kind == 'comment':
                out.append(types_in(in_prose(t, rename, TYPES), rename))
            elif kind == 'string' and t.startswith('"') and ' ' in t:
                t = CAMEL.sub(lambda m: rename(m.group(0)), t)
                out.append(re.sub(r'(?<=^")([A-Z]\w+)(?=::|:)', lambda m: rename(m.group(1)), t))
            else:
                out.append(t)
        for new, olds in after.items():
            if len(olds) > 1 or new in seen:
                clashes.append((f, sorted(olds), new, new in seen))
        tree.text[f] = extra.after_names(f, ''.join(out))
    # code words in pages, messages' comments and the package's Python
    def plain(w):
        if w in extra.NOT_IN_TEXT:
            return w
        return names.renamed(w, {}, names.PHRASES)
    for f in tree.of('.md', '.txt', '.yml', '.yaml', under=r'(?!docs/(archive|proof)|CHANGELOG|test/|config/)'):
        text = in_prose(tree.text[f], plain, TYPES)
        tree.text[f] = re.sub(r'(?<=`)([a-z]+/)(\w+)(?=[`:.(])', lambda m: m.group(1) + plain(m.group(2)) if m.group(2) in names.EXACT else m.group(0), text)
    for f in tree.of('.py', '', under=r'(tools|scripts|test|examples|python)/.*'):
        if f.endswith('.py') or tree.text[f].startswith('#!/usr/bin/env python') or tree.text[f].startswith('#!/usr/bin/python'):
            tree.text[f] = python_names(f, tree.text[f])
    if dump:
        with open(dump, 'w') as file:
            for (old, new), where in sorted(used.items(), key=lambda x: (x[0][0].lower(), x[0])):
                file.write(f'{old}\t{new}\t{len(where)}\t{sorted(where)[0]}\n')
        with open(dump + '.clashes', 'w') as file:
            for c in clashes:
                file.write(repr(c) + '\n')


def python_names(f, text):
    """Names of Python code, by the few words that its tools share with the core."""
    try:
        tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    except (tokenize.TokenError, IndentationError, SyntaxError):
        return text
    lines = text.splitlines(keepends=True)
    for token in reversed(tokens):
        if token.type == tokenize.STRING and re.match(r'[rR]?[fF]', token.string) and token.start[0] == token.end[0]:
            inner = re.compile(r'(?<![\w"\'-])([A-Za-z_]\w*)(?![\w"\'])')
            new = re.sub(r'(?<!\{)\{[^{}]*\}', lambda m: inner.sub(lambda w: extra.python_name(f, w.group(1)), m.group(0)), token.string)
        elif token.type == tokenize.NAME:
            new = extra.python_name(f, token.string)
        else:
            continue
        if new != token.string:
            row, column = token.start
            line = lines[row - 1]
            lines[row - 1] = line[:column] + new + line[column + len(token.string):]
    return re.sub(r'\b(catalogue|known)\.family\(', r'\1.mechanism(', ''.join(lines))


def stage_files(tree):
    table = paths.moves(tree.files)
    clash = {}
    for old, new in table:
        clash.setdefault(new, []).append(old)
    existing = set(tree.files) - {o for o, _ in table}
    for new, olds in clash.items():
        if len(olds) > 1 or new in existing:
            sys.exit(f'two files would be {new}: {olds}')
    paths.rewrite(tree, table)
    tree.move(table)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('root')
    parser.add_argument('--stages', default='names,external,words,test,format')
    parser.add_argument('--dump', default='tools/rename_0_3/identifiers.tsv')
    parser.add_argument('--force', action='store_true', help='on a tree with changes, too')
    arguments = parser.parse_args()
    root = os.path.abspath(arguments.root)
    if git(root, 'status', '--porcelain', '--untracked-files=no').strip() and not arguments.force:
        sys.exit('the tree has changes; commit or stash them, or say --force')
    for stage in arguments.stages.split(','):
        tree = Tree(root)
        if stage == 'names':
            stage_names(tree, arguments.dump)
            tree.write()
            tree = Tree(root)
            stage_files(tree)
        elif stage == 'external':
            external.apply(tree)
        elif stage == 'words':
            words.apply(tree)
        elif stage == 'test':
            extra.add_test(tree)
        elif stage == 'format':
            extra.reformat(tree)
        else:
            sys.exit(f'no stage {stage}')
        tree.write()
        print(stage, 'done')


main()
