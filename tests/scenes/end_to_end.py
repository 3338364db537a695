"""The promises of the whole, tried on a tiny scene with the real programs. The bytes are the same whatever happens on the way, exit codes
are as listed, and nothing is made twice.

Usage: end_to_end.py BIN_FOLDER TEST_CLASS
"""
import hashlib
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
SCENE = HERE / "tiny.yaml"
LAST_FRAME = 6
bin_folder = pathlib.Path()


def call(*words, code=0, cwd=None, env=None, before=None):
    """Runs one of the programs; its outcome after the exit code was checked."""
    done = subprocess.run([bin_folder / words[0], *map(str, words[1:])], capture_output=True, text=True, cwd=cwd,
                          env={**os.environ, **(env or {})}, preexec_fn=before, check=False)
    if done.returncode != code:
        raise AssertionError(f"exit {done.returncode}, not {code}: {' '.join(map(str, words))}\n{done.stdout}{done.stderr}")
    return done


def sim(out, *words, scene=SCENE, **how):
    return call("thixo-sim", f"--out={out}", *words, scene, **how)


def render(out, *words, **how):
    return call("thixo-render", f"--out={out}", *words, **how)


def digest(file):
    return hashlib.sha256(file.read_bytes()).hexdigest()


def tree(folder, *parts):
    """Checksum of every file of the named parts of a folder, by relative path."""
    files = {}
    for part in parts:
        for file in sorted((folder / part).rglob("*")):
            if file.is_file():
                files[str(file.relative_to(folder))] = digest(file)
    return files


def pictures(folder):
    return sorted(p.name for p in (folder / "frames").glob("beauty.*.exr"))


class Case(unittest.TestCase):
    """Each class makes one uninterrupted output, the reference, and tries things in folders beside it."""
    scene = SCENE
    parts = ("cache", "frames")

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="thixo scenes ")
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.reference = cls.folder / "reference"
        start = time.monotonic()
        sim(cls.reference, scene=cls.scene)
        cls.sim_seconds = time.monotonic() - start
        start = time.monotonic()
        render(cls.reference)
        cls.render_seconds = time.monotonic() - start

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def assert_same(self, folder, *parts):
        """Byte for byte as the reference, nothing missing, nothing more."""
        parts = parts or self.parts
        expected, found = tree(self.reference, *parts), tree(folder, *parts)
        self.assertTrue(expected)
        differing = sorted(name for name in expected.keys() | found.keys() if expected.get(name) != found.get(name))
        self.assertEqual([], differing)


class SameBytes(Case):
    def test_the_reference_is_whole(self):
        self.assertEqual([f"beauty.{n:04}.exr" for n in range(1, LAST_FRAME + 1)], pictures(self.reference))
        manifest = json.loads((self.reference / "cache/manifest.json").read_text())
        self.assertTrue(manifest["complete"])
        info = json.loads(call("thixo", "info", self.reference, "--json").stdout)
        self.assertGreater(info["frames"][0]["particles"], 50)
        self.assertGreater(info["frames"][-1]["particles"], info["frames"][0]["particles"])  # the jet adds some
        self.assertGreater(info["frames"][-1]["surfels"], 50)

    def test_at_any_thread_count(self):
        for threads in (1, 2, 3):
            out = self.folder / f"threads {threads}"
            sim(out, f"--threads={threads}")
            render(out, f"--threads={threads}")
            with self.subTest(threads=threads):
                self.assert_same(out)

    def test_a_body_that_bursts_does_so_alike_at_any_thread_count(self):
        scene = HERE.parents[1] / "configs/thesis/fig_5_07_hollow_stone.yaml"
        words = ("--set=bodies.head.surfels=3000", "--set=frames.fps=4800", "--set=frames.last=10", "--quiet")
        caches = {}
        for threads in (1, 2, 3):
            out = self.folder / f"burst {threads}"
            call("thixo-sim", scene, "--out", out, f"--threads={threads}", *words)
            caches[threads] = tree(out, "cache")
        self.assertGreater(len(caches[1]), 20)
        for threads in (2, 3):
            with self.subTest(threads=threads):
                self.assertEqual(caches[1], caches[threads])

    def test_another_seed_gives_another_cache(self):
        """Or equal bytes would prove nothing."""
        out = self.folder / "seed"
        sim(out, "--seed=99", "--frames=1-2")
        self.assertNotEqual(digest(self.reference / "cache/particles.0002.vdb"), digest(out / "cache/particles.0002.vdb"))

    def test_a_moved_cache_without_its_scene_renders_the_same(self):
        scene = self.folder / "gone.yaml"
        shutil.copy(SCENE, scene)
        out = self.folder / "first place"
        call("thixo-sim", f"--out={out}", scene)
        scene.unlink()
        moved = self.folder / "moved" / "elsewhere"
        moved.parent.mkdir()
        out.rename(moved)
        render(moved)
        self.assert_same(moved, "frames")

    def test_two_halves_rendered_apart_are_the_whole(self):
        halves = [self.folder / "half 1", self.folder / "half 2"]
        for half, frames in zip(halves, ("1-3", "4-6")):
            shutil.copytree(self.reference / "cache", half / "cache")
            render(half, f"--frames={frames}")
        for file in (halves[1] / "frames").glob("*.*.*"):
            shutil.copy(file, halves[0] / "frames")
        self.assert_same(halves[0], "frames")

    def test_a_larger_last_frame_continues_to_the_same_bytes(self):
        out = self.folder / "longer"
        sim(out, "--frames=1-3")
        before = {f.name: f.stat().st_mtime_ns for f in (out / "cache").glob("*.vdb")}
        self.assertIn("particles.0003.vdb", before)
        self.assertNotIn("particles.0004.vdb", before)
        sim(out)
        self.assert_same(out, "cache")
        kept = {f.name: f.stat().st_mtime_ns for f in (out / "cache").glob("*.vdb")}
        self.assertEqual(before["particles.0001.vdb"], kept["particles.0001.vdb"])


class Kills(Case):
    def killed(self, words, seconds):
        """Starts a program and kills it after so long; whether it was still running."""
        process = subprocess.Popen([bin_folder / words[0], *map(str, words[1:])], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            process.wait(seconds)
            return False
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            return True

    def finish(self, out):
        sim(out, scene=self.scene)

    def try_kills(self, name, words, seconds, finish, part, prepare=lambda out: None):
        """Five runs, each killed four times at random instants, then finished."""
        chance = random.Random(20260101)
        hits = 0
        for chain in range(5):
            out = self.folder / f"{name} {chain}"
            prepare(out)
            for _ in range(4):
                hits += self.killed([words[0], f"--out={out}", *words[1:]], chance.uniform(0.02, 0.8) * seconds)
            finish(out)
            with self.subTest(chain=chain):
                self.assert_same(out, part)
        self.assertGreaterEqual(hits, 5, "too few kills met a running program")

    def test_a_killed_simulation_continues_to_the_same_bytes(self):
        self.try_kills("sim", ["thixo-sim", self.scene], self.sim_seconds, self.finish, "cache")

    def test_a_killed_rendering_continues_to_the_same_bytes(self):
        self.try_kills("render", ["thixo-render"], self.render_seconds, render, "frames",
                       lambda out: shutil.copytree(self.reference / "cache", out / "cache"))

    def test_a_kill_within_any_write_is_survived(self):
        """Not by the clock: the process kills itself within its nth write of a file."""
        for nth in range(1, 14):
            out = self.folder / f"write {nth}"
            done = subprocess.run([bin_folder / "thixo-sim", f"--out={out}", self.scene], env={**os.environ, "THIXO_WRITE_FAULT": f"{nth}:100:kill"},
                                  capture_output=True, check=False)
            self.assertEqual(-signal.SIGKILL, done.returncode, f"write {nth} of the simulation")
            self.finish(out)
            with self.subTest(nth=nth):
                self.assert_same(out, "cache")

    def test_an_interrupted_run_continues_to_the_same_bytes(self):
        out = self.folder / "interrupted"
        with subprocess.Popen([bin_folder / "thixo", "run", self.scene, "--out", out], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              text=True) as process:
            for line in process.stderr:
                if line.startswith("sim 2/"):
                    process.send_signal(signal.SIGINT)
                    break
            words = process.stderr.read()
        self.assertEqual(130, process.returncode, words)
        self.assertLess(len(pictures(out)), LAST_FRAME)
        call("thixo", "run", self.scene, "--out", out)
        self.assert_same(out)


class ImplicitSolvers(Kills):
    """The same with solvers that start from what the step before found."""
    scene = HERE / "tiny_implicit.yaml"

    def test_they_are_at_work(self):
        solves = [json.loads(line)["solves"] for line in (self.reference / "stats.jsonl").read_text().splitlines()]
        self.assertGreater(max(s["divergence"]["iterations"] for s in solves), 0)
        frames = [json.loads(line)["viscosity"]["iterations"] for line in (self.reference / "stats.jsonl").read_text().splitlines()]
        self.assertGreater(max(frames), 0)

    def test_at_any_thread_count(self):
        for threads in (1, 2, 3):
            out = self.folder / f"threads {threads}"
            sim(out, f"--threads={threads}", scene=self.scene)
            with self.subTest(threads=threads):
                self.assert_same(out, "cache")


class Refusals(Case):
    def last_line(self, done):
        return done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ""

    def test_bad_usage_is_one_line_and_exit_2(self):
        for words in (["thixo", "simulate"], ["thixo"], ["thixo", "run"], ["thixo", "run", SCENE, "--nonsense"], ["thixo-sim"],
                      ["thixo-render"], ["thixo-sim", "--out=x"], ["thixo", "run", SCENE, "--frames", "9-1"]):
            with self.subTest(words=words[:2]):
                done = call(*words, code=2)
                self.assertEqual(1, len(done.stderr.strip().splitlines()), done.stderr)

    def test_all_problems_of_a_bad_scene_are_named_at_once(self):
        bad = self.folder / "bad.yaml"
        bad.write_text(SCENE.read_text().replace("viscosity: 0.05", "viscosty: 0.05").replace("spacing: 0.008", "spacing: -1"))
        for words in (["thixo", "run", bad], ["thixo", "validate", bad], ["thixo-sim", f"--out={self.folder / 'x'}", bad]):
            with self.subTest(program=words[:2]):
                done = call(*words, code=2, cwd=self.folder)
                self.assertIn("viscosty", done.stderr)
                self.assertIn("viscosity", done.stderr)  # the nearest key
                self.assertIn("spacing", done.stderr)
        self.assertFalse((self.folder / "out").exists())

    def test_a_missing_scene_is_exit_2(self):
        self.assertIn("nowhere.yaml", call("thixo", "run", "nowhere.yaml", code=2).stderr)

    def test_a_missing_cache_is_exit_4(self):
        render(self.folder / "nothing here", code=4)
        empty = self.folder / "empty"
        empty.mkdir()
        for verb in (["render"], ["info"], ["export", "--to", "csv"], ["preview"]):
            call("thixo", verb[0], empty, *verb[1:], code=4)

    def test_a_damaged_cache_is_exit_4_and_names_the_file(self):
        out = self.folder / "damaged"
        shutil.copytree(self.reference / "cache", out / "cache")
        file = out / "cache/surfels.0002.vdb"
        data = bytearray(file.read_bytes())
        data[len(data) // 2] ^= 1
        file.write_bytes(data)
        self.assertIn("surfels.0002.vdb", render(out, code=4).stderr)

    def test_a_frame_that_is_not_cached_is_exit_4(self):
        out = self.folder / "short"
        shutil.copytree(self.reference / "cache", out / "cache")
        self.assertIn("9", self.last_line(render(out, "--frames=9", code=4)))

    def test_another_scene_does_not_overwrite(self):
        out = self.folder / "other"
        sim(out, "--frames=1-2")
        before = tree(out, "cache")
        done = sim(out, "--set=materials.water.viscosity=0.5", code=2)
        self.assertIn("materials.water.viscosity", done.stderr)
        self.assertIn("--restart", done.stderr)
        self.assertEqual(before, tree(out, "cache"))
        sim(out, "--set=materials.water.viscosity=0.5", "--restart", "--frames=1-2")
        self.assertNotEqual(before, tree(out, "cache"))

    def test_a_full_disk_is_exit_5_and_keeps_what_was_there(self):
        out = self.folder / "full"
        sim(out, "--frames=1-2")
        before = tree(out, "cache")
        for fault in ("1:50:enospc", "3:50:enospc"):
            sim(out, code=5, env={"THIXO_WRITE_FAULT": fault})
            manifest = json.loads((out / "cache/manifest.json").read_text())
            for name, checksum in before.items():
                if name.endswith(".vdb"):
                    self.assertEqual(checksum, digest(out / name))
            self.assertGreaterEqual(len(manifest["frames"]), 2)
        sim(out)
        self.assert_same(out, "cache")
        render(out, code=5, env={"THIXO_WRITE_FAULT": "2:50:enospc"})
        render(out)
        self.assert_same(out, "frames")

    def test_a_limit_on_file_size_is_exit_5(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
        sim(self.folder / "limited", code=5, before=limit)


if __name__ == "__main__":
    bin_folder = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=2)
