"""Nothing lost, nothing let in: what the programs promise about files, tried with the real programs on a tiny scene.

Usage: promises.py BIN_FOLDER [TEST_CLASS]
"""
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "scenes"))
import end_to_end as tools  # noqa: E402
from end_to_end import Case, SCENE, call, digest, render, sim, tree  # noqa: E402


def flip(file, at=None):
    data = bytearray(file.read_bytes())
    data[len(data) // 2 if at is None else at] ^= 1
    file.write_bytes(data)


def png(width, height):
    """A PNG of one colour: small as a file, large in memory."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    packer = zlib.compressobj(9)
    row = bytes(1 + 3 * width)
    pixels = b"".join(packer.compress(row) for _ in range(height)) + packer.flush()
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def catches(pid, number):
    """Whether a process has set a handler for the signal. Until then the system loads the program, and none of its code has run."""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt:"))
    return bool(int(caught.split()[1], 16) >> (number - 1) & 1)


class Copies(Case):
    """Each test works on a copy of a finished output folder."""
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="thixo faults ")
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.reference = cls.folder / "reference"
        call("thixo", "run", SCENE, "--out", cls.reference)

    def copy(self):
        out = self.folder / self.id().rsplit(".", 1)[1]
        shutil.copytree(self.reference, out)
        return out

    def everything(self, out):
        return {str(f.relative_to(out)): digest(f) for f in sorted(out.rglob("*")) if f.is_file() and not f.is_symlink()}


class OtherPeoplesFiles(Copies):
    FILES = {"cache/assets/logo.png": b"logo", "cache/particles.backup.vdb": b"backup", "cache/frame.notes.json": b"{}",
             "frames/notes.txt": b"notes", "checkpoint/notes.bin": b"notes", ".film/mine": b"mine", ".preview/mine": b"mine", "preview/mine.png": b"mine"}

    def put(self, out):
        for name, data in self.FILES.items():
            (out / name).parent.mkdir(exist_ok=True)
            (out / name).write_bytes(data)

    def test_stay_whatever_a_verb_does(self):
        out = self.copy()
        self.put(out)
        for words in (["sim", SCENE, "--out", out, "--restart", "--frames", "1-3"], ["sim", SCENE, "--out", out], ["run", SCENE, "--out", out],
                      ["preview", SCENE, "--out", out], ["preview", out, "--frames", "1"], ["render", out, "--restart"]):
            call("thixo", *words)
            for name, data in self.FILES.items():
                self.assertEqual(data, (out / name).read_bytes(), f"{name} after {words[0]}")

    def test_in_the_way_are_refused_by_name(self):
        for name, words in (("frames/beauty.0001.png", ["render"]), ("frames/beauty.0002.exr", ["render"]), ("tiny.mp4", ["run", SCENE]),
                            ("cache/particles.0003.vdb", ["sim", SCENE]), ("stats.jsonl", ["sim", SCENE]),
                            ("preview/surfels.material.0001.png", ["preview"])):
            with self.subTest(name=name):
                out = self.folder / "in the way"
                shutil.rmtree(out, ignore_errors=True)
                sim(out, "--frames=1-2")
                (out / name).parent.mkdir(exist_ok=True)
                (out / name).write_bytes(b"another program's")
                verb = words + ["--out", out] if len(words) > 1 else words + [out]
                self.assertIn(pathlib.Path(name).name, call("thixo", *verb, code=2).stderr)
                self.assertEqual(b"another program's", (out / name).read_bytes())

    def test_a_picture_of_a_high_number_makes_no_long_film(self):
        out = self.copy()
        shutil.copy(out / "frames/beauty.0001.png", out / "frames/beauty.0200000.png")
        film = digest(out / "tiny.mp4")
        (out / "tiny.mp4").unlink()
        call("thixo", "run", SCENE, "--out", out)
        self.assertEqual(film, digest(out / "tiny.mp4"))


class Links(Copies):
    def test_in_the_output_folder_are_refused_and_lead_nowhere(self):
        elsewhere = self.folder / "elsewhere"
        elsewhere.mkdir()
        (elsewhere / "mine.png").write_bytes(b"mine")
        for name in ("cache/assets", "cache", "frames", "checkpoint", "stats.jsonl", ".lock"):
            with self.subTest(name=name):
                out = self.folder / "linked"
                shutil.rmtree(out, ignore_errors=True)
                (out / name).parent.mkdir(parents=True)
                (out / name).symlink_to(elsewhere if name != "stats.jsonl" and name != ".lock" else elsewhere / "made")
                self.assertIn("link", call("thixo", "run", SCENE, "--out", out, code=2).stderr)
                self.assertEqual({"mine.png": digest(elsewhere / "mine.png")}, self.everything(elsewhere))


class Pictures(Copies):
    def test_a_png_that_is_not_the_one_of_its_exr_is_made_again(self):
        out = self.copy()
        first, second = out / "frames/beauty.0001.png", out / "frames/beauty.0002.png"
        for spoil in (lambda: first.write_bytes(b"junk"), lambda: first.write_bytes(b""), lambda: shutil.copy(second, first), lambda: flip(first)):
            spoil()
            call("thixo", "run", SCENE, "--out", out)
            self.assert_same(out)

    def test_a_film_that_is_empty_cut_or_damaged_is_made_again(self):
        out = self.copy()
        film = out / "tiny.mp4"
        for spoil in (lambda: film.write_bytes(b""), lambda: film.write_bytes(film.read_bytes()[:-20]), lambda: flip(film)):
            spoil()
            call("thixo", "run", SCENE, "--out", out)
            self.assertEqual(digest(self.reference / "tiny.mp4"), digest(film))

    def test_a_kill_between_the_png_and_the_exr_of_another_look_is_noticed(self):
        out = self.copy()
        # The third write: the EXR of frame 1 comes after its PNG.
        other = ["--set", "look.output.exposure=1", "--restart"]
        done = subprocess.run([tools.bin_folder / "thixo-render", f"--out={out}", f"--set={other[1]}", "--restart"],
                              env={**os.environ, "THIXO_WRITE_FAULT": "2:10:kill"}, check=False, capture_output=True)
        self.assertEqual(-signal.SIGKILL, done.returncode)
        self.assertNotEqual(digest(out / "frames/beauty.0001.png"), digest(self.reference / "frames/beauty.0001.png"))
        render(out)
        self.assert_same(out, "frames")


class Resuming(Copies):
    def test_what_a_complete_cache_lacks_is_made_again(self):
        out = self.copy()
        for spoil in (lambda: (out / "cache/particles.0003.vdb").unlink(), lambda: flip(out / "cache/surfels.0002.vdb"),
                      lambda: flip(out / "cache/frame.0006.json"), lambda: next((out / "cache/assets").iterdir()).unlink()):
            spoil()
            sim(out)
            self.assert_same(out, "cache")
            render(out)
            self.assert_same(out)

    def test_after_a_kill_between_the_film_and_its_last_link_nothing_stays(self):
        out = self.copy()
        ended = subprocess.Popen(["true"])
        ended.wait()
        (out / f".thixo-{ended.pid}-{socket.gethostname()}-film.tmp").mkdir()
        call("thixo", "run", SCENE, "--out", out)
        self.assertEqual([], [p.name for p in out.iterdir() if ".tmp" in p.name])
        self.assert_same(out)

    def test_what_is_damaged_is_told_once(self):
        out = self.copy()
        for file in (out / "cache/particles.0003.vdb", out / "cache/frame.0006.json", next((out / "cache/assets").iterdir())):
            flip(file)
            said = call("thixo", "run", SCENE, "--out", out).stderr
            self.assertEqual(1, said.count(file.name), said)
            self.assert_same(out)

    def test_a_folder_as_manifest_is_a_damaged_cache(self):
        out = self.copy()
        (out / "cache/manifest.json").unlink()
        (out / "cache/manifest.json").mkdir()
        for words in (["info", out], ["render", out], ["sim", SCENE, "--out", out], ["info", out / "cache/manifest.json"]):
            self.assertIn("manifest.json", call("thixo", *words, code=4).stderr)

    def test_a_dying_stage_is_waited_for(self):
        out = self.folder / "dying"
        for _ in range(3):
            process = subprocess.Popen([tools.bin_folder / "thixo", "sim", SCENE, "--out", out, "--set", "frames.last=40"],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(0.4)
            process.send_signal(signal.SIGKILL)  # the stage is told by the system and saves its state
            process.wait()
            call("thixo", "sim", SCENE, "--out", out, "--set", "frames.last=40", "--frames", "1-2")


class Paths(Copies):
    def test_two_ways_to_one_scene_give_the_same_bytes_and_tell_no_folder(self):
        place = self.folder / "a secret place"
        place.mkdir()
        (place / "wood.png").write_bytes(png(4, 4))
        plain, image = "colour: [0.7, 0.7, 0.65], colour2: [0.4, 0.4, 0.45], checker: 0.05", "image: {file: wood.png, size: [0.1, 0.1]}"
        self.assertIn(plain, SCENE.read_text())
        scene = place / "textured.yaml"
        scene.write_text(SCENE.read_text().replace(plain, image))
        call("thixo", "sim", "textured.yaml", "--out", "relative", "--frames", "1", cwd=place)
        call("thixo", "sim", scene, "--out", place / "absolute", "--frames", "1")
        self.assertEqual(tree(place / "relative", "cache"), tree(place / "absolute", "cache"))
        manifest = (place / "relative/cache/manifest.json").read_text()
        self.assertNotIn("secret", manifest)
        self.assertNotIn("wood", manifest)

        # An image that the manifest does not list is looked for nowhere else.
        listed = json.loads(manifest)
        self.assertEqual(1, sum(a["name"].endswith(".png") for a in listed["assets"]))
        for a in listed["assets"]:
            if a["name"].endswith(".png"):
                (place / "relative/cache" / a["name"]).unlink()
        render(place / "relative", code=4, cwd=place)


class Strangers(Copies):
    def test_scenes_have_nothing_opened_outside_of_their_folder(self):
        place = self.folder / "given"
        place.mkdir()
        secret = self.folder / "secret.png"
        secret.write_bytes(png(4, 4))
        (place / "link.png").symlink_to(secret)
        plain = "colour: [0.7, 0.7, 0.65], colour2: [0.4, 0.4, 0.45], checker: 0.05"
        scene = place / "scene.yaml"
        for name in ("../secret.png", secret, "link.png"):
            scene.write_text(SCENE.read_text().replace(plain, f"image: {{file: {name}, size: [0.1, 0.1]}}"))
            for words in (["validate", scene], ["run", scene, "--out", place / "out"], ["info", scene]):
                self.assertIn("lies outside of the scene's folder", call("thixo", *words, code=2).stderr)
            self.assertFalse((place / "out").exists())
            call("thixo", "validate", scene, env={"THIXO_FILES": f"/nowhere:{self.folder}"})
        scene.write_text("extends: ../base.yaml\n")
        shutil.copy(SCENE, self.folder / "base.yaml")
        self.assertIn("lies outside", call("thixo", "validate", scene, code=2).stderr)
        call("thixo", "validate", SCENE, "--set", f"look.appearances.table={{checker: 0, image: {{file: {secret}}}}}")


class Verify(Copies):
    """`thixo verify` names what is damaged and nothing else; with --repair the folder is as it was."""
    FILES = ("cache/manifest.json", "cache/particles.0003.vdb", "cache/surfels.0004.vdb", "cache/frame.0002.json", "checkpoint/checkpoint.0005.bin",
             "frames/beauty.0001.exr", "frames/beauty.0005.png", "tiny.mp4")

    def verify(self, *words, code):
        return call("thixo", "verify", *words, code=code)

    def test_a_sound_folder_is_sound(self):
        told = json.loads(self.verify(self.reference, "--json", code=0).stdout)
        self.assertEqual([], told["damaged"])
        listed = json.loads((self.reference / "cache/manifest.json").read_text())
        self.assertGreaterEqual(told["files"], 1 + 3 * len(listed["frames"]) + len(listed["assets"]) + 2 * 6 + 1)

    def test_one_flipped_bit_is_named_in_every_kind_of_file(self):
        for name in self.FILES:
            with self.subTest(name=name):
                out = self.folder / "flipped"
                shutil.rmtree(out, ignore_errors=True)
                shutil.copytree(self.reference, out)
                flip(out / name)
                said = self.verify(out, "--json", code=4)
                damaged = json.loads(said.stdout)["damaged"]
                self.assertEqual([pathlib.Path(name).stem], [pathlib.Path(d["file"]).stem for d in damaged])
                self.assertTrue(damaged[0]["remedy"])
                self.assertIn(pathlib.Path(name).name, said.stderr)

    def test_repair_makes_the_same_bytes_again(self):
        for name in self.FILES:
            with self.subTest(name=name):
                out = self.folder / "repaired"
                shutil.rmtree(out, ignore_errors=True)
                shutil.copytree(self.reference, out)
                flip(out / name)
                place = [SCENE, "--out", out] if name.endswith("manifest.json") else [out]
                self.verify(*place, "--repair", code=0)
                self.assertEqual({f: h for f, h in self.everything(self.reference).items() if f.startswith(("cache", "frames")) or f == "tiny.mp4"},
                                 {f: h for f, h in self.everything(out).items() if f.startswith(("cache", "frames")) or f == "tiny.mp4"})
                self.verify(out, code=0)

    def test_repair_of_a_sound_folder_changes_nothing(self):
        out = self.copy()
        before = {f: f.stat().st_mtime_ns for f in out.rglob("*") if f.is_file()}
        self.verify(out, "--repair", code=0)
        self.assertEqual(before, {f: f.stat().st_mtime_ns for f in out.rglob("*") if f.is_file()})

    def test_repair_leaves_the_files_of_others(self):
        out = self.copy()
        (out / "cache/notes.txt").write_bytes(b"mine")
        (out / "checkpoint/checkpoint.0099.bin").write_bytes(b"mine too")
        flip(out / "cache/particles.0003.vdb")
        self.verify(out, "--repair", code=4)
        self.assertEqual(b"mine", (out / "cache/notes.txt").read_bytes())
        self.assertIn(b"mine too", [f.read_bytes() for f in (out / "checkpoint").iterdir()])

    def test_a_manifest_without_its_scene_is_told_and_not_made(self):
        out = self.copy()
        flip(out / "cache/manifest.json")
        self.assertIn("scene", self.verify(out, "--repair", code=4).stderr)


class Signals(Copies):
    """At any moment: the exit code tells the signal, the words tell no lie, and the same command ends with the same bytes."""
    def interrupted(self, words, number, seconds):
        """Of a program that gets a signal after so long: exit code, words, seconds, whether its code ran by then. None where it had ended."""
        process = subprocess.Popen([tools.bin_folder / words[0], *map(str, words[1:])], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            process.communicate(timeout=seconds)
            return None
        except subprocess.TimeoutExpired:
            ran = catches(process.pid, number)
            process.send_signal(number)
            sent = time.monotonic()
            said = process.communicate()[1]
        return process.returncode, said, time.monotonic() - sent, ran

    def slow_to_set_up(self):
        scene = self.folder / "slow.yaml"
        bodies = "".join(f"  b{k}: {{material: water, shape: {{box: {{size: [0.4, 0.4, 0.4]}}, translate: [{k % 10}, {k // 10}, 0]}}}}\n" for k in range(100))
        scene.write_text("frames: {first: 0, last: 24}\nmaterials: {water: {}}\nsolver: {spacing: 0.01}\nbodies:\n" + bodies)
        return scene

    def test_in_set_up_and_in_validate_end_at_once(self):
        scene = self.slow_to_set_up()
        for words in (["thixo", "validate", scene], ["thixo-sim", f"--out={self.folder / 'set up'}", scene],
                      ["thixo", "sim", scene, "--out", self.folder / "set up too"]):
            for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
                with self.subTest(words=words[:2], signal=number.name):
                    outcome = self.interrupted(words, number, 0.7)
                    self.assertIsNotNone(outcome, "it had ended: the scene is too small for this test")
                    self.assertEqual(code, outcome[0], outcome[1])
                    self.assertIn("interrupted", outcome[1])
                    self.assertNotIn("state is saved", outcome[1] if words[1] == "validate" else "")
                    self.assertLess(outcome[2], 2)

    def test_in_a_long_frame_are_answered_within_two_seconds(self):
        out = self.copy()
        endless = ["--set=look.output.samples=1000000", "--set=look.output.noise=0", "--restart"]
        for words in (["thixo-render", f"--out={out}", *endless], ["thixo", "render", out, *endless],
                      ["thixo", "sim", SCENE, "--out", self.folder / "long", "--set", "frames.fps=0.01"]):
            for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
                with self.subTest(words=words[:2], signal=number.name):
                    outcome = self.interrupted(words, number, 2)
                    self.assertIsNotNone(outcome, "it had ended: the frame is too short for this test")
                    self.assertEqual(code, outcome[0], outcome[1])
                    self.assertIn("interrupted", outcome[1])
                    self.assertLess(outcome[2], 2)
        self.assertEqual(["checkpoint.0001.bin"], [f.name for f in (self.folder / "long/checkpoint").iterdir()])

    def test_at_any_moment_of_a_run_lose_nothing(self):
        chance = random.Random(20260101)
        begun = time.monotonic()
        call("thixo", "run", SCENE, "--out", self.folder / "timed")
        whole = time.monotonic() - begun
        out, hits = self.folder / "run", 0
        for k in range(12):
            number, code = ((signal.SIGINT, 130), (signal.SIGTERM, 143))[k % 2]
            after = chance.uniform(0, 1) * whole
            outcome = self.interrupted(["thixo", "run", SCENE, "--out", out], number, after)
            if outcome is None:  # it went on from before, and was quicker
                shutil.rmtree(out)
                continue
            if outcome[0] == -number and not outcome[3]:
                continue
            if outcome[0] == 0:  # the signal came when all was done
                self.assert_same(out)
                shutil.rmtree(out)
                continue
            hits += 1
            self.assertEqual(code, outcome[0], outcome[1])
            self.assertIn("interrupted", outcome[1])
        self.assertGreaterEqual(hits, 4)
        call("thixo", "run", SCENE, "--out", out)
        self.assert_same(out)
        self.assertEqual(digest(self.reference / "tiny.mp4"), digest(out / "tiny.mp4"))


class Usage(Copies):
    def test_numbers_that_are_none_compare_nothing(self):
        for word in ("nan", "inf", "-1", "1e9"):
            self.assertIn("--max-rel-mse", call("thixo", "check", self.reference / "frames", "--against", self.reference / "frames",
                                                "--max-rel-mse", word, code=2).stderr)

    def test_empty_and_unprintable_words_are_refused_before_the_work(self):
        call("thixo", "sim", SCENE, "--out", "", code=2, cwd=self.folder)
        done = subprocess.run([tools.bin_folder / "thixo", "sim", SCENE, "--json", "--out", os.fsencode(self.folder) + b"/\xff"], check=False,
                              capture_output=True)
        self.assertEqual(2, done.returncode)
        self.assertNotIn(b"internal", done.stderr)
        self.assertFalse(os.path.exists(os.fsencode(self.folder) + b"/\xff"))

    def test_names_steer_no_terminal(self):
        out = self.copy()
        shutil.move(out, self.folder / "with \x1b[31m colour")
        self.assertNotIn("\x1b", call("thixo", "info", self.folder / "with \x1b[31m colour" / "nothing", code=2).stderr)

    def test_closed_streams_let_nothing_into_files(self):
        out = self.folder / "closed"
        subprocess.run(["sh", "-c", f"'{tools.bin_folder}/thixo' sim '{SCENE}' --out '{out}' --frames 1-2 2>&- >&-"], check=True)
        self.assertEqual(b"", (out / ".lock").read_bytes())

    def test_little_memory_is_exit_5(self):
        """At any limit. Where the system cannot even load a program, none of its code runs: exit 127 is the system's. Each says 5 at some limit."""
        out = self.copy()
        for program, words in (("thixo", ["sim", SCENE, "--restart"]), ("thixo-sim", [SCENE, "--restart"]), ("thixo-render", ["--restart"])):
            codes = set()
            for megabytes in (90, 100, 110, 120, 150, 310, 350, 360, 400, 500, 600):
                limit = megabytes * 1_000_000
                done = subprocess.run([tools.bin_folder / program, *words, f"--out={out}"], capture_output=True, check=False,
                                      preexec_fn=lambda size=limit: resource.setrlimit(resource.RLIMIT_AS, (size, size)))
                if done.returncode == 127 and b"error while loading shared libraries" in done.stderr:
                    continue
                self.assertIn(done.returncode, (0, 5), f"{program} with {megabytes} MB: {done.stderr}")
                codes.add(done.returncode)
            self.assertIn(5, codes, program)


class Estimates(Copies):
    def facts(self, *words):
        start = time.monotonic()
        facts = json.loads(call("thixo", "validate", *words, "--json").stdout)
        return facts, time.monotonic() - start

    def test_count_pictures_and_images(self):
        plain, _ = self.facts(SCENE)
        large, _ = self.facts(SCENE, "--set", "look.output.width=32768", "--set", "look.output.height=32768")
        self.assertGreater(large["memory"], 60 * 32768 ** 2)  # 15 float channels
        self.assertLess(plain["memory"], 1e9)
        image = self.folder / "large.png"
        image.write_bytes(png(8192, 8192))
        self.assertLess(image.stat().st_size, 1e6)
        pictured, _ = self.facts(SCENE, "--set", f"look.appearances.table={{checker: 0, image: {{file: {image}}}}}")
        self.assertGreater(pictured["memory"] - plain["memory"], 3 * 4 * 8192 ** 2)  # three float channels
        done = render(self.reference, "--set=look.output.width=32768", "--set=look.output.height=32768", "--restart", code=5)
        self.assertIn("GB", done.stderr)

    def test_of_wide_emitters_and_many_bodies_are_quick(self):
        scene = self.folder / "wide.yaml"
        head = "frames: {first: 0, last: 24}\nmaterials: {water: {}}\nsolver: {spacing: 0.01}\n"
        for radius in (10, 100):
            scene.write_text(head + f"emitters: {{spout: {{material: water, radius: {radius}, speed: 1}}}}\n")
            facts, seconds = self.facts(scene)
            self.assertAlmostEqual(1, facts["particles"] / (3.14159265 * radius ** 2 / 0.01 ** 3), delta=0.01)
            self.assertLess(seconds, 5)
        bodies = "".join(f"  b{k}: {{material: water, shape: {{box: {{size: [0.04, 0.04, 0.04]}}, translate: [{k % 50 * 0.1}, {k // 50 * 0.1}, 0]}}}}\n"
                         for k in range(3000))
        scene.write_text(head + "bodies:\n" + bodies)
        facts, seconds = self.facts(scene)
        self.assertGreater(facts["particles"], 3000 * 30)
        self.assertLess(seconds, 5)


class TwoAtOnce(Copies):
    def both(self, *words, codes=(0,)):
        started = [subprocess.Popen([tools.bin_folder / "thixo", *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                   for _ in range(2)]
        for process in started:
            said = process.communicate()[1]
            self.assertIn(process.returncode, codes, said)
        return [process.returncode for process in started]

    def test_films_and_previews_do_not_disturb_each_other(self):
        out = self.copy()
        for _ in range(3):
            (out / "tiny.mp4").unlink()
            self.both("run", SCENE, "--out", out)
            self.assertEqual(digest(self.reference / "tiny.mp4"), digest(out / "tiny.mp4"))
            self.both("preview", SCENE, "--out", out)
        self.assertEqual([], [p.name for p in out.iterdir() if ".tmp" in p.name])

    def test_renderers_share_the_frames_of_a_folder(self):
        out = self.copy()
        for _ in range(3):
            for file in (out / "frames").glob("beauty.*"):
                file.unlink()
            self.both("render", out)
            self.assert_same(out)

    def test_of_two_simulations_one_is_refused_and_nothing_is_lost(self):
        out = self.folder / "simulated twice"
        self.both("sim", SCENE, "--out", out, codes=(0, 2))
        self.assert_same(out, "cache")


if __name__ == "__main__":
    tools.bin_folder = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=2)
