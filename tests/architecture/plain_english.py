"""Sentences in comments and documents have at most 25 words.

long_sentences.txt lists how many longer ones a file still has. Its numbers may only become smaller: a file with fewer has to be listed with fewer.

Usage: plain_english.py           runs the tests
       plain_english.py PATH...   prints the long sentences of these files
       plain_english.py --list    prints what long_sentences.txt should hold
"""
import pathlib
import re
import sys
import tokenize
import unittest

import shrinking_list
import source_rules

ROOT = source_rules.ROOT
MOST_WORDS = 25
LIST = ROOT / "tests/architecture/long_sentences.txt"
# An end, and what begins the next sentence. "fig. 6.9" and "et al. 2004" are no ends.
END = re.compile(r"(?<=[.!?])(?<!fig\.)(?<!figs\.)(?<!\sal\.)(?<!\seq\.)[)\"'*]*\s+(?=[A-Z0-9`(\"'*_])")
WORD = re.compile(r"[A-Za-z]")
GENERATED = {"docs/scene.md", "docs/gates.md", "docs/performance.md"}  # by code_files' comments and names, which are read there


def sentences(paragraph):
    return [s.strip() for s in END.split(" ".join(paragraph.split())) if s.strip()]


def words(sentence):
    """Words with a letter in them; code in backticks and links count as one."""
    sentence = re.sub(r"`[^`]*`", "code", sentence)
    sentence = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", sentence)
    return [w for w in sentence.split() if WORD.search(w)]


def paragraphs_of_lines(lines, first=1):
    """(line number, text): lines of prose joined. Blank lines part them, and list items begin new ones. Indented lines are no prose: formulas,
    tables, code."""
    number, text = 0, []
    for line_number, line in enumerate(lines, first):
        item = re.match(r"\s{0,3}([-*]|\d+\.)\s", line)
        indented = not item and re.match(r"\s{3,}\S", line)
        if not line.strip() or item or indented:
            if text:
                yield number, " ".join(text)
            number, text = line_number, []
        if line.strip() and not indented:
            number = number if text else line_number
            text.append(re.sub(r"^\s*([-*]|\d+\.)\s+", "", line.strip()) if item else line.strip())
    if text:
        yield number, " ".join(text)


def cpp_comments(text):
    """(first line, lines) of each run of comment lines, and of each comment behind code."""
    run, begin = [], 0
    for number, line in enumerate(text.splitlines(), 1):
        alone = re.match(r"\s*//[/!<]*( .*|$)", line)
        if alone:
            begin = begin if run else number
            run.append(alone.group(1)[1:])
            continue
        if run:
            yield begin, run
            run = []
        behind = re.search(r"(?:^|\s)//[/<]*\s+(.*)$", re.sub(r'"(\\.|[^"\\])*"', '""', line))
        if behind:
            yield number, [behind.group(1)]
    if run:
        yield begin, run


def hash_comments(text):
    run, begin = [], 0
    for number, line in enumerate(text.splitlines(), 1):
        alone = re.match(r"\s*#(?!!) ?(.*)", line)
        if alone:
            begin = begin if run else number
            run.append(alone.group(1))
            continue
        if run:
            yield begin, run
            run = []
    if run:
        yield begin, run


def python_comments(path):
    yield from hash_comments(path.read_text())
    with tokenize.open(path) as file:
        for token in tokenize.generate_tokens(file.readline):
            if token.type == tokenize.STRING and token.string.startswith('"""'):
                yield token.start[0], token.string.strip('"').splitlines()


def document_blocks(text):
    """Prose of a Markdown page: no code, no headings; each cell of a table is a block."""
    block, begin, fenced = [], 0, False
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            fenced = not fenced
        prose = not fenced and not line.startswith(("```", "#", "|", "    "))
        if prose:
            begin = begin if block else number
            block.append(line)
            continue
        if block:
            yield begin, block
            block = []
        if line.startswith("|") and not fenced:
            for cell in re.split(r"(?<!\\)\|", line.strip("|")):
                yield number, [cell.strip()]
    if block:
        yield begin, block


def blocks(name):
    path = ROOT / name
    if name.endswith((".h", ".cpp")):
        return cpp_comments(path.read_text())
    if name.endswith(".py"):
        return python_comments(path)
    if name.endswith(".md"):
        return document_blocks(path.read_text())
    return hash_comments(path.read_text())


def long_sentences(name):
    """(line, number of words, sentence) of a file."""
    for first, lines in blocks(name):
        for number, paragraph in paragraphs_of_lines(lines, first):
            for sentence in sentences(paragraph):
                if (count := len(words(sentence))) > MOST_WORDS:
                    yield number, count, sentence


def files():
    for name in source_rules.repository_files():
        suffix = pathlib.Path(name).suffix
        if suffix in {".h", ".cpp", ".py", ".md", ".cmake"} or name in {"thixo", "CMakeLists.txt"} or name.endswith("/CMakeLists.txt"):
            if name not in GENERATED and not name.startswith("tests/golden/"):
                yield name


def counts():
    found = {name: sum(1 for _ in long_sentences(name)) for name in files()}
    return {name: count for name, count in found.items() if count}


class PlainEnglish(unittest.TestCase):
    maxDiff = None

    def test_sentences_are_short(self):
        problems = [f"{name}:{line}: {size} words: {text[:100]}" for name in shrinking_list.exceeding(LIST, counts())
                    for line, size, text in long_sentences(name)]
        self.assertEqual([], problems, "\n" + "\n".join(problems))

    def test_the_list_of_exceptions_only_shrinks(self):
        self.assertEqual([], shrinking_list.stale(LIST, counts()), "lower these numbers in long_sentences.txt")

    def test_the_rule_counts_words_of_sentences(self):
        long = " ".join(["word"] * 26)
        self.assertEqual([26], [len(words(s)) for s in sentences(long + ".")])
        self.assertEqual([25, 1], [len(words(s)) for s in sentences(long[5:] + ". Short.")])
        self.assertEqual(1, len(sentences("As in fig. 6.9 and Wicke et al. 2004.")))
        self.assertEqual(["a", "b c"], [t for _, t in paragraphs_of_lines(["a", "", "b", "c"])])
        self.assertEqual([(1, "a:"), (3, "b c")], list(paragraphs_of_lines(["a:", "    x = 1", "b", "c"])))
        self.assertEqual([(1, "a b"), (3, "c")], list(paragraphs_of_lines(["- a", "  b", "- c"])))
        self.assertEqual([(1, ["one", "two"]), (3, ["three"])], list(cpp_comments("// one\n/// two\nint x;  // three\n")))
        self.assertEqual([["prose"], ["a"], ["b"]], [b for _, b in document_blocks("# Head\nprose\n| a | b |\n```\ncode\n```\n")])
        self.assertEqual(2, len(words("see `a long piece of code`")))


if __name__ == "__main__":
    if sys.argv[1:] == ["--list"]:
        print(shrinking_list.text(counts()), end="")
    elif len(sys.argv) > 1:
        for path in sys.argv[1:]:
            for line, size, text in long_sentences(path):
                print(f"{path}:{line}: {size}: {text}")
    else:
        unittest.main(verbosity=1)
