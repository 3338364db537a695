"""What each verb of the command does, tried on a tiny scene with the real programs.

Usage: command.py BIN_FOLDER [TEST_CLASS]
"""
import csv
import fcntl
import json
import pathlib
import shutil
import subprocess
import sys
import unittest

import end_to_end as tools
from end_to_end import LAST_FRAME, SCENE, Case, call, digest, pictures, render, sim, tree


class Command(Case):
    def files(self, folder):
        return {str(f.relative_to(folder)): f.stat().st_mtime_ns for f in sorted(folder.rglob("*")) if f.is_file()}

    def test_run_makes_what_the_stages_make_and_a_film(self):
        out = self.folder / "run"
        done = call("thixo", "run", SCENE, "--out", out)
        self.assert_same(out)
        film = out / "tiny.mp4"
        self.assertEqual(str(film), done.stdout.strip())
        probe = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames,width,height", "-of", "csv=p=0",
                                film], capture_output=True, text=True, check=True)
        self.assertEqual("64,36,6", probe.stdout.strip())
        self.assertIn("sim 6/6", done.stderr)
        self.assertIn("render 6/6", done.stderr)

        # Again: everything is there, so nothing is made.
        before = self.files(out)
        call("thixo", "run", SCENE, "--out", out)
        self.assertEqual(before, self.files(out))

        # A lost picture, and nothing else, is made again, and the film of it: the same bytes.
        checksum = digest(film)
        (out / "frames/beauty.0003.exr").unlink()
        (out / "frames/beauty.0003.png").unlink()
        call("thixo", "run", SCENE, "--out", out)
        self.assert_same(out)
        after = self.files(out)
        self.assertEqual({"frames/beauty.0003.exr", "frames/beauty.0003.png", "tiny.mp4"},
                         {name for name in after if after[name] != before.get(name)})
        self.assertEqual(checksum, digest(film))

    def test_film_shows_finished_frames_again_without_a_ray(self):
        out = self.folder / "again"
        shutil.copytree(self.reference, out)
        same = call("thixo", "film", out, "--fps", 12, "--codec", "prores")
        film = pathlib.Path(same.stdout.strip())
        self.assertEqual(out / "tiny.12fps.mov", film)
        brighter = call("thixo", "film", out, "--set", "look.output.exposure=1")
        self.assertEqual(out / "tiny.relit.mp4", pathlib.Path(brighter.stdout.strip()))
        call("thixo", "verify", out)
        self.assertNotIn("is rendered", brighter.stderr)  # these pictures have no light groups, and need none
        first, second = (out / f / "beauty.0001.png" for f in ("frames", "frames.relit"))
        self.assertNotEqual(digest(first), digest(second))
        made = second.stat().st_mtime_ns
        call("thixo", "film", out, "--set", "look.output.exposure=1")
        self.assertEqual(made, second.stat().st_mtime_ns)  # nothing is made twice
        lit = call("thixo", "film", out, "--restart", "--frames", 1, "--set", "look.lights.lamp.strength=3")
        self.assertIn("no light groups", lit.stderr)
        part = call("thixo", "film", out, "--frames", "2-3")
        self.assertEqual(out / "tiny.2-3.mp4", pathlib.Path(part.stdout.strip()))
        (out / "frames/beauty.0002.png").unlink()
        self.assertIn("1 of 6 frames have no picture", call("thixo", "film", out).stderr)
        call("thixo", "film", out, "--frames", "99", code=4)
        call("thixo", "film", out, "--restart", code=2)
        call("thixo", "film", out, "--draft", code=2)
        call("thixo", "film", out, "--look", self.folder / "none.yaml", code=4)

    def test_output_goes_to_out_below_the_current_folder(self):
        place = self.folder / "a place"
        place.mkdir()
        done = call("thixo", "sim", SCENE, "--frames", "1", cwd=place)
        self.assertEqual("out/tiny/cache", done.stdout.strip())
        self.assertTrue((place / "out/tiny/cache/manifest.json").exists())
        self.assertEqual("out/tiny/frames", call("thixo", "render", SCENE, "--frames", "1", cwd=place).stdout.strip())
        self.assertEqual(digest(self.reference / "frames/beauty.0001.exr"), digest(place / "out/tiny/frames/beauty.0001.exr"))

    def test_dry_run_prints_commands_that_do_the_work(self):
        out = self.folder / "by hand"
        done = call("thixo", "run", SCENE, "--out", out, "--dry-run")
        self.assertFalse(out.exists())
        lines = done.stdout.strip().splitlines()
        self.assertEqual(2, len(lines))
        for line in lines:
            subprocess.run(["sh", "-c", line], check=True, capture_output=True)
        self.assert_same(out)

    def test_preview_of_a_scene_simulates_nothing(self):
        out = self.folder / "previewed"
        done = call("thixo", "preview", SCENE, "--out", out)
        picture = pathlib.Path(done.stdout.strip())
        self.assertEqual(b"\x89PNG", picture.read_bytes()[:4])
        self.assertEqual({"preview"}, {p.name for p in out.iterdir()})

    def test_preview_of_a_cache_takes_frames_and_attributes(self):
        call("thixo", "preview", self.reference, "--frames", "2,4", "--what", "particles", "--attribute", "v")
        self.assertEqual(["particles.v.0002.png", "particles.v.0004.png"], sorted(p.name for p in (self.reference / "preview").iterdir()))

    def test_a_folder_that_is_being_written_is_left_alone(self):
        out = self.folder / "held"
        sim(out, "--frames=1-3")
        before = tree(out, "cache")
        with open(out / ".lock", "r+") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            for word in ("--frames=1-5", "--restart"):
                said = sim(out, word, code=2).stderr
                self.assertIn("is being written by another simulation", said)
                self.assertEqual(1, len(said.strip().splitlines()), said)
            self.assertEqual(before, tree(out, "cache"))
        sim(out, "--frames=1-5")

    def test_statistics_have_one_line_a_frame(self):
        out = self.folder / "counted"
        for word in ("--frames=1-4", "--restart", "--frames=1-6"):
            sim(out, word)
        frames = [json.loads(line)["frame"] for line in (out / "stats.jsonl").read_text().splitlines()]
        self.assertEqual(sorted(set(frames)), frames)

    def test_validate_estimates(self):
        facts = json.loads(call("thixo", "validate", SCENE, "--json").stdout)
        info = json.loads(call("thixo", "info", self.reference, "--json").stdout)
        last = info["frames"][-1]["particles"]
        # Half to double: what emitters release depends on the flow.
        self.assertTrue(last / 2 <= facts["particles"] <= last * 2, (facts, last))
        solid = self.folder / "solid.yaml"
        solid.write_text("frames: {first: 0, last: 2}\nmaterials: {rubber: {youngs_modulus: 1.0e5}}\n"
                         "bodies: {ball: {material: rubber, surfels: 5000, angular_velocity: [1, 2, 3], shape: {sphere: {radius: 0.1}}}}\n"
                         "solver: {spacing: 0.02}\n")
        facts = json.loads(call("thixo", "validate", solid, "--json").stdout)
        out = self.folder / "solid"
        sim(out, scene=solid)
        used = sum(f.stat().st_size for f in (out / "cache").glob("*.vdb"))
        self.assertTrue(used / 2 <= facts["disk"] <= used * 2, (facts, used))
        printed = self.folder / "printed.yaml"
        printed.write_text(call("thixo", "validate", SCENE, "--print").stdout)
        call("thixo", "validate", printed)

    def test_validate_estimates_what_a_crack_adds(self):
        """A plate breaks once, and another along a painted line: both are what the estimate assumes. Half to double."""
        for name, last in (("breaking_plate", 16), ("scored_plate", 8)):
            scene = pathlib.Path(__file__).resolve().parents[2] / "configs" / f"{name}.yaml"
            facts = json.loads(call("thixo", "validate", scene, "--json").stdout)
            out = self.folder / name
            sim(out, f"--set=frames.last={last}", scene=scene)
            rows = [json.loads(line) for line in (out / "stats.jsonl").read_text().splitlines()]
            self.assertEqual(2, rows[-1]["cracks"]["bodies"])
            added = rows[-1]["surfels"] - 20000
            self.assertTrue(added / 2 <= facts["crack_surfels"] <= added * 2, (name, facts, added))
            self.assertLessEqual(added, facts["crack_surfels_most"])
        plain = json.loads(call("thixo", "validate", SCENE, "--json").stdout)
        self.assertNotIn("crack_surfels", plain)

    def test_a_picture_is_the_same_where_a_spacing_is_a_micrometre_or_a_thousand_kilometres(self):
        """A drop over a plane; Z alone, in metres, is another. FLIP up to 0.02 is no difference that one sees."""
        def rendered(size):
            m = lambda spacings: f"{spacings * size:.12f}"
            scene = self.folder / f"drop {size}.yaml"
            scene.write_text(
                f"frames: {{last: 1}}\nmaterials: {{m: {{}}}}\nsolver: {{spacing: {m(1)}, expected_speed: 1}}\n"
                f"world: {{gravity: [0, 0, 0], boundaries: {{floor: {{shape: {{plane: {{offset: {m(-4)}}}}}}}}}}}\n"
                f"bodies: {{b: {{material: m, shape: {{sphere: {{radius: {m(3.3)}}}}}}}}}\n"
                f"look: {{camera: {{position: [{m(10)}, {m(-20)}, {m(10)}], look_at: [0, 0, 0]}}, "
                "output: {width: 96, height: 72, samples: 16, film: false}}\n", encoding="utf8")
            out = self.folder / f"drop {size}"
            call("thixo", "run", scene, "--out", out, "--quiet")
            return out / "frames"

        usual = rendered(0.01)
        for size in (1e-6, 1e6):
            done = call("thixo", "check", rendered(size), "--against", usual, "--max-rel-mse", "1e-7", "--json", code=1)
            self.assertLess(json.loads(done.stdout)["frames"][0]["flip"], 0.02, size)

    def test_export_and_info_agree(self):
        out = self.folder / "exported"
        call("thixo", "export", self.reference, "--to", "csv", "--what", "particles", "--frames", "3", "--out", out)
        with open(out / "particles.0003.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        frame = json.loads(call("thixo", "info", self.reference, "--json").stdout)["frames"][2]
        self.assertEqual(3, frame["frame"])
        self.assertEqual(frame["particles"], len(rows))
        facts = json.loads(call("thixo", "info", self.reference / "cache/particles.0003.vdb", "--json").stdout)
        mean = sum(float(row["P.z"]) for row in rows) / len(rows)
        found = facts["attributes"]["P"]["mean"][2]
        self.assertAlmostEqual(mean, found, delta=1e-6)  # float32 positions of 0.1 m

    def test_check_tells_equal_from_different(self):
        other = self.folder / "checked"
        shutil.copytree(self.reference, other)
        call("thixo", "check", other, "--against", self.reference)
        call("thixo", "check", other / "frames", "--against", self.reference / "frames")
        shutil.copy(other / "frames/beauty.0001.exr", other / "frames/beauty.0002.exr")
        call("thixo", "check", other / "frames", "--against", self.reference / "frames", code=1)

    def test_a_draft_has_a_folder_of_its_own(self):
        place = self.folder / "draft"
        place.mkdir()
        call("thixo", "sim", SCENE, "--frames", "1", "--draft", cwd=place)
        self.assertTrue((place / "out/tiny.draft/cache/manifest.json").exists())

    def test_quiet_says_nothing(self):
        done = call("thixo", "sim", SCENE, "--frames", "1", "--out", self.folder / "quiet", "--quiet")
        self.assertEqual("", done.stdout + done.stderr)

    def test_the_programs_work_from_another_folder(self):
        moved = self.folder / "moved bin"
        moved.mkdir()
        for program in ("thixo", "thixo-sim", "thixo-render", "thixo-check"):
            shutil.copy(tools.bin_folder / program, moved)
        out = self.folder / "by moved"
        subprocess.run([moved / "thixo", "run", SCENE, "--out", out, "--frames", "1-2"], check=True, capture_output=True)
        self.assertEqual(digest(self.reference / "frames/beauty.0002.exr"), digest(out / "frames/beauty.0002.exr"))

    def test_without_ffmpeg_nothing_starts_and_without_a_film_all_is_made(self):
        out = self.folder / "no film"
        done = call("thixo", "run", SCENE, "--out", out, code=2, env={"PATH": "/nonexistent"})
        self.assertIn("look.output.film=false", done.stderr)
        self.assertFalse(out.exists())
        call("thixo", "run", SCENE, "--out", out, "--set", "look.output.film=false", env={"PATH": "/nonexistent"})
        self.assertEqual(LAST_FRAME, len(pictures(out)))
        self.assertEqual([], list(out.glob("*.mp4")))


if __name__ == "__main__":
    tools.bin_folder = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=2)
