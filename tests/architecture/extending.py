"""The diffs of docs/extending.md apply, are short, and touch few files; with --build, what they add is compiled and its tests pass.

Usage: extending.py                       the first three, in a second
       extending.py --build [WORD...]     builds and tests the diffs whose heading has one of the words, in one copy of the repository; all without words
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import source_rules

ROOT = source_rules.ROOT
PAGE = ROOT / "docs/extending.md"
MOST_LINES = 60
MOST_FILES = 3  # that exist before; what is generated does not count
GENERATED = {"docs/scene.md", "docs/scene.schema.json"}
FILE = re.compile(r"^--- (\S+)\n\+\+\+ (\S+)\n", re.M)


class Example:
    """One heading of the page with a diff: its title, the diff, the targets to build and the pattern of its tests' names."""

    def __init__(self, title, text):
        self.title = title
        self.diff = "".join(re.findall(r"^```diff\n(.*?)^```$", text, re.M | re.S))
        named = re.search(r"^builds: `([^`]+)`, tests: `([^`]+)`$", text, re.M)
        self.targets, self.tests = (named.group(1).split(), named.group(2)) if named else ([], "")

    def existing_files(self):
        return {old[2:] for old, _ in FILE.findall(self.diff) if old != "/dev/null"} - GENERATED


def examples(text):
    parts = re.split(r"^## (.*)$", text, flags=re.M)
    return [e for e in map(Example, parts[1::2], parts[2::2]) if e.diff]


def copy_of_repository(to):
    for name in source_rules.repository_files():
        target = to / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, target)


def apply(diff, folder):
    """git's complaint about the diff as it stands on the page; empty where it applies."""
    # A context of one line is enough: comments may change beside it.
    done = subprocess.run(["git", "apply", "-C1", "-"], cwd=folder, input=diff, text=True, capture_output=True, check=False,
                          env={**os.environ, "GIT_CEILING_DIRECTORIES": str(folder.parent)})
    return done.stderr if done.returncode else ""


class Extending(unittest.TestCase):
    def setUp(self):
        self.examples = examples(PAGE.read_text())

    def test_the_page_has_its_six_examples(self):
        self.assertEqual(["force", "law", "potential", "material", "pass", "scene key"],
                         [next((w for w in ("force", "law", "potential", "material", "pass", "scene key") if w in e.title), e.title)
                          for e in self.examples])

    def test_every_diff_is_short_and_touches_few_files(self):
        for example in self.examples:
            with self.subTest(example.title):
                self.assertLessEqual(example.diff.count("\n"), MOST_LINES)
                self.assertLessEqual(len(example.existing_files()), MOST_FILES, example.existing_files())

    def test_every_diff_names_its_test(self):
        for example in self.examples:
            with self.subTest(example.title):
                self.assertTrue(example.targets)
                added = re.findall(r"^\+TEST\((\w+), (\w+)\)", example.diff, re.M)
                changed = re.findall(r"^[+]{3} b/tests/\S+_test\.cpp$", example.diff, re.M)
                self.assertTrue(changed)
                for suite, test in added:
                    self.assertRegex(f"{suite}.{test}", example.tests)

    def test_every_diff_applies(self):
        with tempfile.TemporaryDirectory() as scratch:
            for number, example in enumerate(self.examples):
                with self.subTest(example.title):
                    folder = pathlib.Path(scratch) / str(number)
                    for name in example.existing_files():
                        (folder / name).parent.mkdir(parents=True, exist_ok=True)
                        shutil.copy2(ROOT / name, folder / name)
                    self.assertEqual("", apply(example.diff, folder))

    def test_the_rules_see_what_is_wrong(self):
        text = ("## A force\n```diff\n--- a/x\n+++ b/x\n@@ -2,2 +2,3 @@\n one\n+two\n three\n"
                "--- /dev/null\n+++ b/y\n@@ -0,0 +1 @@\n+new\n```\n## Words\nno diff\n")
        found = examples(text)
        self.assertEqual(["A force"], [e.title for e in found])
        self.assertEqual({"x"}, found[0].existing_files())
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch) / "tree"
            folder.mkdir()
            (folder / "x").write_text("zero\none\nthree\n")
            self.assertEqual("", apply(found[0].diff, folder))
            self.assertEqual("zero\none\ntwo\nthree\n", (folder / "x").read_text())
            self.assertEqual("new\n", (folder / "y").read_text())
            (folder / "x").write_text("zero\n")
            self.assertIn("x", apply(found[0].diff, folder))
            (folder / "x").write_text("zero\none\nthree\n")
            self.assertIn("corrupt patch", apply(found[0].diff.replace("-2,2 +2,3", "-2,4 +2,5"), folder))


def run(command, folder, **settings):
    print("$", " ".join(map(str, command)), flush=True)
    return subprocess.run(command, cwd=folder, check=False, **settings).returncode == 0


def build(words):
    """What failed. One copy takes all the diffs, so that what they share is compiled once and they are seen to stand side by side."""
    failed = []
    chosen = [e for e in examples(PAGE.read_text()) if not words or any(w in e.title for w in words)]
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch) / "thixo"
        copy_of_repository(folder)
        settings = {**os.environ, "CCACHE_SLOPPINESS": "pch_defines,time_macros", "CCACHE_BASEDIR": str(folder), "CCACHE_NOHASHDIR": "1"}
        for example in chosen:
            if complaint := apply(example.diff, folder):
                print(complaint)
                failed.append(example.title)
        if not run(["cmake", "--preset", "release"], folder, env=settings, stdout=subprocess.DEVNULL):
            return failed + ["the configuration"]
        for example in chosen:
            print(f"== {example.title}", flush=True)
            built = run(["nice", "ninja", "-C", "build/release", f"-j{os.cpu_count()}", *example.targets], folder, env=settings)
            # --no-tests=error: a pattern that finds no test is a failure.
            if not built or not run(["ctest", "--test-dir", "build/release", "-R", example.tests, "--no-tests=error", "--output-on-failure"], folder):
                failed.append(example.title)
    return failed or ([] if chosen else ["no heading has these words"])


if __name__ == "__main__":
    if sys.argv[1:2] == ["--build"]:
        failures = build(sys.argv[2:])
        print("failed: " + ", ".join(failures) if failures else "all passed")
        sys.exit(1 if failures else 0)
    unittest.main(verbosity=1)
