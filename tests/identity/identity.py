"""Same bytes before and after: what two builds make of every scene of configs/, compared by hash.

Usage: identity.py record BIN_FOLDER HASHES.json [SCENE ...]
       identity.py check  BIN_FOLDER HASHES.json [SCENE ...]

`record` simulates the first frames of every scene, or of those named, at --draft with the programs of BIN_FOLDER. It renders three of
them, and writes the hash of every frame file. `check` does the same with another build, prints each scene that differs, with its
first file that does, and exits with 1 if there is one. Manifests are left out: they hold the scene's text with its defaults.
"""
import hashlib
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs"
FRAMES = 12
RENDERED = {"thesis/fig_6_10_pour.yaml": 6, "thesis/fig_5_10_creases.yaml": 2, "thesis/fig_6_04_cube.yaml": 4}
PARTS = [folder for folder in ("", "thesis")]


def scenes():
    """Every scene of configs/ that can be run by itself, by its path there."""
    return sorted(str(p.relative_to(CONFIGS)) for part in PARTS for p in (CONFIGS / part).glob("*.yaml"))


def frames_of(bin_folder, scene):
    """The first frames of a scene, as --frames takes them."""
    done = subprocess.run([bin_folder / "thixo", "validate", CONFIGS / scene, "--print"], capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("frames:"))
    text = " ".join(lines[at:at + 4])
    first, last = (int(text.split(key)[1].split(",")[0].split()[0]) for key in ("first:", "last:"))
    return first, min(first + FRAMES - 1, last)


def digest(file):
    return hashlib.sha256(file.read_bytes()).hexdigest()[:24]


def hashes_of(bin_folder, scene):
    """Hash of every frame file that the build makes of a scene; the exit code and last line of error where it makes none."""
    out = pathlib.Path(tempfile.mkdtemp(prefix="identity."))
    try:
        first, last = frames_of(bin_folder, scene)
        frames = f"{first}-{last}"
        done = subprocess.run([bin_folder / "thixo", "sim", CONFIGS / scene, "--draft", "--quiet", "--frames", frames, "--out", out],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return {"exit": f"{done.returncode}: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ''}"}
        files = [f for f in sorted((out / "cache").iterdir()) if f.is_file() and f.name != "manifest.json"]
        if scene in RENDERED:
            frame = min(first + RENDERED[scene] - 1, last)
            subprocess.run([bin_folder / "thixo", "render", out, "--draft", "--quiet", "--frames", str(frame)], check=True,
                           capture_output=True)
            files += sorted((out / "frames").glob("*.exr"))
        return {f.name: digest(f) for f in files}
    finally:
        shutil.rmtree(out)


def main(action, bin_folder, file, *names):
    bin_folder, file = pathlib.Path(bin_folder).resolve(), pathlib.Path(file)
    known = json.loads(file.read_text()) if file.exists() else {}
    differ = []
    for scene in names or scenes():
        started = time.monotonic()
        now = hashes_of(bin_folder, scene)
        seconds = time.monotonic() - started
        if action == "record":
            known[scene] = now
            file.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n")
            print(f"{scene}: {len(now)} files, {seconds:.0f} s", flush=True)
            continue
        before = known.get(scene)
        wrong = sorted(n for n in {*now, *before} if now.get(n) != before.get(n)) if before else ["is not recorded"]
        print(f"{scene}: {'equal' if not wrong else 'DIFFERS: ' + wrong[0]}, {seconds:.0f} s", flush=True)
        if wrong:
            differ.append(scene)
    return 1 if differ else 0


if __name__ == "__main__":
    if len(sys.argv) < 4 or sys.argv[1] not in ("record", "check"):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
