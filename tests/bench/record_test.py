"""record.py with programs that print what it is given: ratios, records, comparison.

Usage: record_test.py
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import figures  # pylint: disable=wrong-import-position

# Two repetitions in disorder, and an aggregate, which is no measurement.
SEARCH = [("grid_search/300763/212", 10, 3e-8), ("nanoflann_search/300763/212", 100, 3e-7), ("grid_search/300763/212", 30, 5e-8),
          ("nanoflann_search/300763/212", 300, 5e-7)]


def google_output(scale):
    entries = [{"run_name": name, "name": name, "run_type": "iteration", "cpu_time": scale * ms if name.startswith("grid") else ms, "s/particle": s}
               for name, ms, s in SEARCH]
    entries.append({"run_name": SEARCH[0][0], "name": "mean", "run_type": "aggregate", "cpu_time": 1e9, "s/particle": 1e9})
    return json.dumps({"benchmarks": entries})


class Record(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory(prefix="thixo record ")
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.docs = self.folder / "docs"
        self.docs.mkdir()
        self.prints("picture_bench", "499424 surfels, 640 x 360, 16 samples: ready in 0.1 s, picture in 3.90 s, peak 68 MB\n")

    def prints(self, program, text):
        (self.folder / "text").mkdir(exist_ok=True)
        (self.folder / "text" / program).write_text(text)
        file = self.folder / program
        file.write_text(f'#!/bin/sh\ncat "{self.folder}/text/{program}"\n')
        file.chmod(0o755)

    def record(self, *words, code=0):
        done = subprocess.run([sys.executable, HERE / "record.py", self.folder, *words, "--docs", self.docs], capture_output=True, text=True, check=False)
        self.assertEqual(code, done.returncode, done.stderr)
        return done.stdout

    def test_a_ratio_is_of_the_medians_and_a_better_one_is_no_failure(self):
        self.prints("search_bench", google_output(1))
        self.assertIn("ratio 0.1, the first record", self.record("search"))
        self.prints("search_bench", google_output(0.5))
        self.assertIn("ratio 0.05, before 0.1 (-50%)", self.record("search"))
        page = (self.docs / "performance.md").read_text()
        self.assertRegex(page, r"neighbour search.*\| 1/7 \| yes \| 40 ns a particle \| 0.05 \| nanoflann \| -50% \|")

    def test_a_ratio_that_is_worse_by_more_than_the_tolerance_fails(self):
        self.prints("search_bench", google_output(1))
        self.record("search")
        self.prints("search_bench", google_output(1.2))
        self.assertIn("WORSE", self.record("search", "--check", code=1))
        self.record("search", "--check", "--tolerance", "0.3")
        self.prints("search_bench", google_output(2))
        self.record("search", code=1)
        self.assertRegex((self.docs / "performance.md").read_text(), r"neighbour search.*\| no \|")

    def test_a_check_writes_nothing_and_what_is_not_run_keeps_its_record(self):
        self.record("picture", "--check")
        self.assertEqual([], list(self.docs.iterdir()))
        self.record("picture")
        self.prints("search_bench", google_output(1))
        self.record("search")
        page = (self.docs / "performance.md").read_text()
        self.assertIn("neighbour search", page)
        self.assertRegex(page, r"picture of 500 000 surfels, all threads \| 3.4 s \| no \| 3.9 s \|")
        self.assertRegex(page, r"peak of memory \| 200 MB \| yes \| 68 MB \|")

    def test_output_that_is_not_understood_is_no_record(self):
        self.prints("picture_bench", "another text")
        self.record("picture", code=1)
        self.assertEqual([], list(self.docs.iterdir()))

    def test_every_benchmark_program_has_a_run_and_every_run_a_figure(self):
        lists = (HERE / "CMakeLists.txt").read_text()
        programs = set(re.findall(r"add_executable\((\w+_bench) ", lists))
        for names in re.findall(r"foreach\(\w+ ([^)]*)\)\n  add_executable", lists):
            programs |= {f"{name}_bench" for name in names.split()}
        self.assertEqual({f.stem for f in HERE.glob("*_bench.cpp")}, programs)
        self.assertEqual(programs, {run.program for run in figures.RUNS.values()} | figures.BY_HAND)
        self.assertEqual(set(figures.RUNS), {figure.run for figure in figures.FIGURES})
        names = [figure.name for figure in figures.FIGURES]
        self.assertEqual(len(set(names)), len(names))


if __name__ == "__main__":
    unittest.main(verbosity=1)
