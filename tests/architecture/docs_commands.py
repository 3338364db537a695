"""Every ./thixo command in the documents exists with its options, and every file they name is there.

Usage: docs_commands.py PROGRAM   (PROGRAM is the built `thixo`)
"""
import pathlib
import re
import shlex
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LAUNCHER_VERBS = {"setup", "test"}
program = ""


def documents():
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def commands(text):
    """Words after ./thixo of every line of a code block that starts with it; a comment after two blanks or # ends the command."""
    found = []
    fenced = False
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif (fenced or line.startswith("    ")) and line.strip().startswith("./thixo"):
            command = re.split(r"\s{2,}|\s#", line.strip())[0]
            found.append(shlex.split(command)[1:])
    return found


def help_of(verb):
    command = [ROOT / "thixo", verb, "--help"] if verb in LAUNCHER_VERBS else [program, verb, "--help"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout


class DocsCommands(unittest.TestCase):
    def test_the_readme_shows_the_two_commands(self):
        words = commands((ROOT / "README.md").read_text())
        self.assertIn(["run", "configs/quickstart.yaml"], words)
        self.assertIn(["test"], words)

    def test_commands_in_the_documents_exist(self):
        for document in documents():
            for words in commands(document.read_text()):
                with self.subTest(document=document.name, command=" ".join(words)):
                    if words[:1] == ["--no-build"]:
                        words = words[1:]
                    code, text = help_of(words[0]) if not words[0].startswith("-") else (0, "--help --version")
                    self.assertEqual(0, code, f"./thixo {words[0]} is no verb")
                    for word in words:
                        if word.startswith("--"):
                            self.assertIn(word.split("=")[0], text, f"./thixo {words[0]} has no such option")
                        elif word.startswith("configs/"):
                            self.assertTrue((ROOT / word).exists(), f"{word} does not exist")

    def test_links_in_the_documents_lead_somewhere(self):
        for document in documents():
            prose = re.sub(r"^```.*?^```", "", document.read_text(), flags=re.M | re.S)  # in code, ]( is no link
            for target in re.findall(r"\]\(([^)#:]+)\)", prose):
                with self.subTest(document=document.name, target=target):
                    self.assertTrue((document.parent / target).exists())


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program = sys.argv.pop()
    unittest.main(verbosity=1)
