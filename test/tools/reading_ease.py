"""Flesch reading ease of pages: 206.835 - 1.015 words a sentence - 84.6 syllables a word (Flesch 1948). 60 and more is plain English.

Counts prose alone: no code, tables, headings, pictures or comments. An item of a list is a sentence. Syllables are groups of vowels of a word,
less a silent e; numbers, units and names in code are no words.
"""

import re

FENCE = re.compile(r"^```.*?^```", re.S | re.M)


def prose(text):
    """Paragraphs of a page as a reader sees them."""
    text = re.sub(r"<!--.*?-->", "", FENCE.sub("", text), flags=re.S)
    paragraphs, lines = [], []
    for line in [*text.splitlines(), ""]:
        is_code = line.startswith("    ") and not lines
        if not line.strip() or is_code or line.startswith(("#", "|", "![")):
            paragraphs.append(" ".join(lines))
            lines = []
        elif re.match(r"\s*([-*]|\d+\.) ", line):
            paragraphs.append(" ".join(lines))
            lines = [re.sub(r"^\s*([-*]|\d+\.) ", "", line)]
        else:
            lines.append(line.strip())
    words = [re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", one) for one in paragraphs]
    return [re.sub(r"`[^`]*`", " ", one).replace("*", "") for one in words if one]


def syllables(word):
    groups = sum(len(re.findall(r"[aeiouy]+", part)) for part in word.split("-"))
    if word.endswith("e") and not word.endswith(("le", "ee")) and groups > 1:
        groups -= 1
    if re.search(r"[^dt]ed$", word) and groups > 1:
        groups -= 1
    return max(groups, 1)


def counted(text):
    """Sentences, words and syllables of a page."""
    sentences, words = 0, []
    for paragraph in prose(text):
        for sentence in re.split(r"(?<=[.!?])\s+", paragraph):
            found = re.findall(r"[a-z]+(?:['-][a-z]+)*", sentence.lower())
            sentences += bool(found)
            words += found
    return sentences, len(words), sum(map(syllables, words))


def reading_ease(text):
    sentences, words, parts = counted(text)
    return 206.835 - 1.015 * words / sentences - 84.6 * parts / words
