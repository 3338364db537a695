"""Functions have at most seven parameters.

many_parameters.txt lists those that still have more. Its numbers may only become smaller.

Usage: parameters.py           runs the tests
       parameters.py --list    prints what many_parameters.txt should hold
"""
import re
import sys
import unittest

import shrinking_list
import source_rules

ROOT = source_rules.ROOT
MOST_PARAMETERS = 7
LIST = ROOT / "tests/architecture/many_parameters.txt"
NO_FUNCTIONS = {"if", "for", "while", "switch", "catch", "return", "decltype", "requires", "sizeof"}
BLANKED = re.compile(r'//[^\n]*|/\*.*?\*/|R"\(.*?\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.S)
# What may stand between the parameters of a function and its body.
BEFORE_BODY = re.compile(r"\s*((const|noexcept|override|final|mutable|->\s*[\w:<>,&*\s]+?)\s*)*(:[^;{}]*(\{[^{}]*\}[^;{}]*)*)?\{")


def closing(text, opening):
    """Place of the bracket that closes the one at `opening`."""
    depth = 0
    for place in range(opening, len(text)):
        depth += {"(": 1, ")": -1}.get(text[place], 0)
        if depth == 0:
            return place
    return -1


def parameter_count(parameters):
    depth, count = 0, 1
    for place, letter in enumerate(parameters):
        if letter in "<([{":
            depth += 1
        elif letter in ")]}" or (letter == ">" and parameters[place - 1] != "-"):
            depth -= 1
        elif letter == "," and depth == 0:
            count += 1
    return count if parameters.strip() not in {"", "void"} else 0


def functions(text):
    """(name, number of parameters) of every function that is defined in a text; lambdas are called `lambda`."""
    text = BLANKED.sub(lambda m: '""' if m.group()[0] in "\"R'" else "", text)
    for match in re.finditer(r"(~?\w+|operator\W{1,3}|\])\s*\(", text):
        name, opening = match.group(1), match.end() - 1
        end = closing(text, opening)
        before = text[max(0, match.start() - 200):match.start()].rstrip()
        if before.endswith(",") or (before.endswith(":") and not before.endswith("::")):  # initialises a member
            continue
        if name in NO_FUNCTIONS or end < 0 or not BEFORE_BODY.match(text, end + 1):
            continue
        yield ("lambda" if name == "]" else name), parameter_count(text[opening + 1:end])


def counts():
    found = {}
    for file in source_rules.code_files(source_rules.CODE_FOLDERS + ("tests",)):
        for name, count in functions((ROOT / file).read_text()):
            if count > MOST_PARAMETERS:
                found[f"{file} {name}"] = max(count, found.get(f"{file} {name}", 0))
    return found


class Parameters(unittest.TestCase):
    def test_no_function_has_more_than_seven(self):
        self.assertEqual([], shrinking_list.exceeding(LIST, counts()))

    def test_the_list_of_exceptions_only_shrinks(self):
        self.assertEqual([], shrinking_list.stale(LIST, counts()), "lower these numbers in many_parameters.txt, or take them out")

    def test_the_rule_finds_functions_and_counts_their_parameters(self):
        self.assertEqual([("f", 2)], list(functions("int f(std::map<int, int> a, int b = g(1, 2)) { return a; }")))
        self.assertEqual([("f", 0), ("lambda", 3)], list(functions("void f() { auto g = [&](int a, int b, int c) { h(a, b); }; }")))
        self.assertEqual([("S", 1), ("get", 0)], list(functions("struct S { S(int a) : x(a) {} int get() const { return x; } };")))
        self.assertEqual([], list(functions("int f(int a, int b);  // f(a) {\nvoid x = g(1) + 2;")))
        self.assertEqual([("f", 1)], list(functions("void f(int n) { if (n > g(2, 3)) { while (n) { --n; } } }")))


if __name__ == "__main__":
    if sys.argv[1:] == ["--list"]:
        print(shrinking_list.text(counts()), end="")
    else:
        unittest.main(verbosity=1)
