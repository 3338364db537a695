"""What a run could not do stands at its end, in `info` and in `validate`; with --strict the exit code is 6.

Usage: falls_short.py BIN_FOLDER
"""
import json
import pathlib
import shlex
import subprocess
import sys
import tempfile
import unittest

bin_folder = pathlib.Path()
WATER = "materials: {m: {viscosity: 0.01}}\nsurface: {enabled: false}\n"
SCENES = {
    # An emitter in an obstacle; one whose disc is half in it.
    "blocked": "frames: {first: 1, last: 6, fps: 48}\nworld: {boundaries: {block: {shape: {box: {size: [0.2, 0.2, 0.2]}}}}}\n"
               "emitters: {s: {material: m, radius: 0.03, speed: 1}}\nsolver: {spacing: 0.015, checkpoint_every: 2}\n",
    # A fixed step that is too long, which gains energy from nowhere.
    "energy": "frames: {first: 1, last: 12, fps: 48}\nworld: {boundaries: {floor: {shape: {plane: {offset: -0.1}}}}}\n"
              "bodies: {b: {material: m, shape: {sphere: {radius: 0.05}}}}\nsolver: {spacing: 0.015, time_step: {fixed: 0.02}}\n",
    "good": "frames: {first: 1, last: 6, fps: 48}\nworld: {boundaries: {floor: {shape: {plane: {offset: -0.1}}}}}\n"
            "bodies: {b: {material: m, shape: {sphere: {radius: 0.05}}}}\nsolver: {spacing: 0.015}\n",
}


def thixo(*words, code=0):
    done = subprocess.run([bin_folder / "thixo", *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != code:
        raise AssertionError(f"exit {done.returncode}, not {code}: {words}\n{done.stdout}{done.stderr}")
    return done


class FallsShort(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="thixo short ")
        cls.folder = pathlib.Path(cls.scratch.name)
        for name, text in SCENES.items():
            (cls.folder / f"{name}.yaml").write_text(WATER + text, encoding="utf8")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def sim(self, name, out, *words, code=0):
        return thixo("sim", self.folder / f"{name}.yaml", "--out", self.folder / out, *words, code=code)

    def listed(self, out):
        return json.loads(thixo("info", self.folder / out, "--json").stdout)["shortfalls"]

    def test_a_blocked_emitter_is_named_at_the_end_and_in_info_and_in_validate(self):
        done = self.sim("blocked", "blocked")
        self.assertIn("emitter 's' is blocked: 100 %", done.stderr)
        (entry,) = self.listed("blocked")
        self.assertEqual(("blocked", "s", entry["of"]), (entry["kind"], entry["name"], entry["count"]))
        self.assertIn("emitter 's' is blocked: 100 %", thixo("info", self.folder / "blocked").stdout)
        told = thixo("validate", self.folder / "blocked.yaml", "--json")
        self.assertEqual(["blocked"], [s["kind"] for s in json.loads(told.stdout)["shortfalls"]])
        self.assertIn("emitter 's' is blocked", told.stderr)

    def test_energy_from_nowhere_is_told_and_the_step_that_makes_it(self):
        for fixed in ("0.02", "0.01", "0.005"):
            out = f"energy {fixed}"
            done = self.sim("energy", out, "--set", f"solver.time_step.fixed={fixed}")
            self.assertIn("from nowhere", done.stderr)
            self.assertLessEqual({"long_step", "energy"}, {s["kind"] for s in self.listed(out)})
        told = thixo("validate", self.folder / "energy.yaml", "--json")
        (entry,) = json.loads(told.stdout)["shortfalls"]
        self.assertEqual("long_step", entry["kind"])
        self.assertGreater(entry["worst"], 2)

    def test_with_strict_the_exit_code_is_6_and_the_cache_is_whole(self):
        self.sim("blocked", "strict", "--strict", code=6)
        self.assertTrue(json.loads((self.folder / "strict/cache/manifest.json").read_text())["complete"])
        self.sim("blocked", "strict", "--strict", code=6)  # already there: told again
        self.sim("blocked", "strict")
        thixo("validate", self.folder / "blocked.yaml", "--strict", code=6)
        thixo("validate", self.folder / "energy.yaml", "--strict", code=6)

    def test_a_run_that_does_all_says_nothing(self):
        done = self.sim("good", "good", "--strict", "--quiet")
        self.assertEqual("", done.stdout + done.stderr)
        self.assertEqual([], self.listed("good"))
        self.assertIn("no problems", thixo("validate", self.folder / "good.yaml", "--strict").stdout)

    def test_the_list_is_the_same_at_any_thread_count_and_after_a_resume(self):
        for name in ("blocked", "energy"):
            self.sim(name, f"{name} whole", "--threads", 1)
            for threads in (2, 3):
                self.sim(name, f"{name} {threads}", "--threads", threads)
                self.assertEqual(self.listed(f"{name} whole"), self.listed(f"{name} {threads}"))
            self.sim(name, f"{name} halves", "--frames", "1-3")
            self.sim(name, f"{name} halves")
            self.assertEqual(self.listed(f"{name} whole"), self.listed(f"{name} halves"))

    def test_the_replay_line_of_a_diverged_run_gives_it_again(self):
        """With what was set, drafted, seeded, and where it went; in the words of a shell."""
        scene = self.folder / "it's fast.yaml"
        scene.write_text(
            "frames: {first: 0, last: 9, fps: 100}\nmaterials: {stuff: {density: 1000, youngs_modulus: 1.0e4}}\n"
            "bodies: {thing: {material: stuff, shape: {box: {size: [0.06, 0.06, 0.06]}}}}\n"
            "handles: {hand: {body: thing, region: {box: {size: [1, 1, 0.03]}, translate: [0, 0, 0.03]}, "
            "motion: [{time: 0}, {time: 0.1, position: [1000, 0, 0]}]}}\nsolver: {spacing: 0.005}\n", encoding="utf8")
        out = self.folder / "replay (1)"
        first = thixo("sim", scene, "--draft", "--seed", 7, "--set", "materials.stuff.density=900", "--out", out, code=3).stderr
        line = next(words for words in first.splitlines() if words.startswith("replay: ")).removeprefix("replay: ")
        words = shlex.split(line)
        self.assertEqual(["thixo", "sim"], words[:2])
        for word in ("--draft", "--seed=7", "--set=materials.stuff.density=900", f"--out={out}", str(scene)):
            self.assertIn(word, words)
        again = thixo(*words[1:], code=3).stderr
        self.assertIn(line, again)
        message = next(words for words in first.splitlines() if "diverged" in words)
        self.assertIn(message, again)


if __name__ == "__main__":
    bin_folder = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=2)
