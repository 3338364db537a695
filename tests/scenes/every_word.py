"""Every value of every word key of a scene is run for two frames, or refused in one clear line: nothing crashes.

Usage: every_word.py BIN_FOLDER SCENE...     (`configs` stands for every scene of that folder)
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SLOWEST = 600  # s


def run(folder, program, *words):
    return subprocess.run([folder / program, *map(str, words)], capture_output=True, text=True, timeout=SLOWEST, check=False)


def enums(node):
    """The word lists of the schema, by the name of their key; a name may stand for several."""
    found = {}

    def visit(value):
        if isinstance(value, dict):
            for key, entry in value.get("properties", {}).items():
                if isinstance(entry, dict) and "enum" in entry:
                    found.setdefault(key, []).append(entry["enum"])
            for entry in value.values():
                visit(entry)
        elif isinstance(value, list):
            for entry in value:
                visit(entry)
    visit(node)
    return found


def entries(printed):
    """(path, value) of every plain value of a scene as `validate --print` writes it; entries of lists are left out."""
    path = []
    for line in printed.splitlines():
        match = re.match(r"( *)([\w.-]+):(?: (.*))?$", line)
        if not match or line.lstrip().startswith("- "):
            continue
        depth = len(match[1]) // 2
        path[depth:] = [match[2]]
        if len(path) == depth + 1 and match[3]:
            yield ".".join(path), match[3]


def variants(printed, words):
    """`key=value` for every other value of every word key and switch of a scene."""
    for path, value in entries(printed):
        key = path.rsplit(".", 1)[-1]
        others = {"true": ["false"], "false": ["true"]}.get(value, [])
        for values in words.get(key, []):
            if value in values:
                others = [v for v in values if v != value]
        for other in others:
            yield f"{path}={other}"


def problem(done):
    """What is wrong with the outcome of a run; empty where it did its work or refused in a clear line."""
    if done.returncode not in (0, 2) or "internal error" in done.stderr:
        return f"exit {done.returncode}: {done.stderr.strip()[-400:]}"
    if done.returncode == 2 and not done.stderr.strip():
        return "exit 2 without a word"
    return ""


def try_scene(folder, scene, words, scratch):
    printed = run(folder, "thixo", "validate", scene, "--print").stdout
    first, last = (int(re.search(rf"^  {key}: (\d+)$", printed, re.M)[1]) for key in ("first", "last"))
    frames = f"{first}-{min(first + 1, last)}"
    out, problems, count = scratch / "out", [], 0
    common = ("--draft", "--quiet", "--set", "look.output.samples=1", "--set", "look.output.film=false")
    for key in ["solver.seed=1", *variants(printed, words)]:
        if key.startswith("look."):
            done = run(folder, "thixo", "render", out, *common, "--restart", "--frames", frames, "--set", key)
        else:
            done = run(folder, "thixo", "sim", scene, "--draft", "--quiet", "--restart", "--frames", frames, "--out", out, "--set", key)
        count += 1
        if problem(done):
            problems.append(f"{scene.name} --set {key}: {problem(done)}")
    return count, problems


def main(folder, *names):
    words = enums(json.loads((ROOT / "docs/scene.schema.json").read_text()))
    scenes = [s for name in names for s in (sorted(ROOT.glob("configs/*.yaml")) + sorted(ROOT.glob("configs/thesis/*.yaml"))
                                            if name == "configs" else [pathlib.Path(name).resolve()])]
    total, problems = 0, []
    for scene in scenes:
        with tempfile.TemporaryDirectory(prefix="thixo words ") as scratch:
            count, found = try_scene(pathlib.Path(folder), scene, words, pathlib.Path(scratch))
        print(f"{scene.name}: {count} runs, {len(found)} problems", flush=True)
        total += count
        problems += found
    print("\n".join(problems))
    print(f"{total} runs of {len(scenes)} scenes, {len(problems)} problems")
    return 1 if problems or total <= len(scenes) else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
