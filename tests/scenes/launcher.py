"""The launcher `./thixo`: it never waits for a build of another command without need, and says so where it must wait.

The launcher is the real one, in a folder of its own. Its tools and programs are scripts that take no time.

Usage: launcher.py
"""
import contextlib
import fcntl
import os
import pathlib
import select
import shutil
import signal
import subprocess
import tempfile
import unittest

LAUNCHER = pathlib.Path(__file__).resolve().parents[2] / "thixo"
SOON = 10  # seconds: a build that is waited for is held for ever

PROGRAM = """#!/bin/sh
echo "the {age} program was given: $*"
"""
CMAKE = """#!/bin/sh
mkdir -p build/run build/release
touch build/run/build.ninja build/release/build.ninja
"""
# Asked whether there is work (-n) it says yes, and then makes new programs.
NINJA = """#!/bin/sh
case " $* " in *" -n "*) echo "[1/1] link" && exit 0 ;; esac
mkdir -p "$2/bin"
for program in thixo thixo-sim; do
    printf '#!/bin/sh\necho "the new program was given: $*"\n' >"$2/bin/$program"
    chmod +x "$2/bin/$program"
done
"""
CTEST = """#!/bin/sh
echo "ctest was given: $*"
"""


def write_program(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)


class Launcher(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory(prefix="thixo launcher ")
        self.addCleanup(scratch.cleanup)
        self.root = pathlib.Path(scratch.name)
        shutil.copy(LAUNCHER, self.root / "thixo")
        (self.root / "packages.txt").write_text("# none: nothing is installed\n")
        tools = self.root / "tools"
        for name, text in {"cmake": CMAKE, "ninja": NINJA, "ctest": CTEST}.items():
            write_program(tools / name, text)
        self.environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"}
        self.ready = self.root / "build/run/ready"

    def has_old_programs(self):
        for name in ("thixo", "thixo-sim"):
            write_program(self.ready / name, PROGRAM.format(age="old"))
            os.utime(self.ready / name, (1, 1))

    def another_command_builds(self):
        """Holds the lock of builds until it is closed."""
        (self.root / "build").mkdir(exist_ok=True)
        lock = open(self.root / "build/lock", "w")  # pylint: disable=consider-using-with
        self.addCleanup(lock.close)
        fcntl.flock(lock, fcntl.LOCK_EX)
        return lock

    def start(self, *words):
        """The launcher in a session of its own, so that what it waits for ends with it."""
        process = subprocess.Popen([self.root / "thixo", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   env=self.environment, start_new_session=True)

        def stop():
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
        self.addCleanup(stop)
        return process

    def call(self, *words):
        process = self.start(*words)
        out, said = process.communicate(timeout=SOON)
        return subprocess.CompletedProcess(words, process.returncode, out, said)

    def test_every_verb_runs_the_programs_that_are_there_while_another_command_builds(self):
        self.has_old_programs()
        self.another_command_builds()
        for words in (["--help"], ["--version"], ["info", "out/x"], ["validate", "a.yaml"], ["run", "a.yaml"], ["check", "a", "--against", "b"]):
            with self.subTest(words=words):
                done = self.call(*words)
                self.assertEqual(0, done.returncode, done.stderr)
                self.assertEqual(f"the old program was given: {' '.join(words)}\n", done.stdout)
                self.assertIn("another command is building", done.stderr)

    def test_help_of_its_own_verbs_never_waits(self):
        self.another_command_builds()
        for words in (["test", "--help"], ["setup", "--help"]):
            with self.subTest(words=words):
                done = self.call(*words)
                self.assertEqual(0, done.returncode)
                self.assertEqual("", done.stderr)

    def test_no_build_never_waits(self):
        self.another_command_builds()
        self.assertEqual(2, self.call("--no-build", "info", "x").returncode)
        self.has_old_programs()
        self.assertEqual("the old program was given: info x\n", self.call("--no-build", "info", "x").stdout)

    def waits_aloud(self, *words):
        """Starts the launcher while the lock is held; after its release, the process's outcome."""
        lock = self.another_command_builds()
        process = self.start(*words)
        self.assertTrue(select.select([process.stderr], [], [], SOON)[0], "it waits without a word")
        self.assertIn("waiting", process.stderr.readline())
        with self.assertRaises(subprocess.TimeoutExpired):
            process.wait(0.5)
        lock.close()
        out, _ = process.communicate(timeout=SOON)
        self.assertEqual(0, process.returncode)
        return out

    def test_the_first_build_is_waited_for_aloud(self):
        self.assertEqual("the new program was given: info x\n", self.waits_aloud("info", "x"))

    def test_tests_wait_for_a_build_aloud(self):
        self.has_old_programs()
        self.assertIn("ctest was given", self.waits_aloud("test"))

    def test_a_build_of_its_own_replaces_the_programs(self):
        self.has_old_programs()
        self.assertEqual("the new program was given: info x\n", self.call("info", "x").stdout)
        self.assertIn("new", (self.ready / "thixo-sim").read_text())
        self.assertEqual({"thixo", "thixo-sim"}, {f.name for f in self.ready.iterdir()})

    def test_fast_tests_are_chosen_by_their_label(self):
        self.assertIn("--label-regex ^(fast)$", self.call("test", "--fast").stdout)
        self.assertIn("--label-regex ^(unit|physics|scene)$", self.call("test").stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
