"""One damage to one file of an output folder, then one verb. It names the file, mends it, or has the outcome of the undamaged folder.

A file in which nothing shows any more that Thixo wrote it counts as another's: it is named, with exit code 2, and stays."""
import json
import pathlib
import shutil

from end_to_end import tree
from campaign import SCENES, contents, run


def flip_bit(chance, data):
    at = chance.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << chance.randrange(8)]) + data[at + 1:]


def blank(chance, data):
    at = chance.randrange(len(data))
    end = min(len(data), at + chance.choice([16, 512, 4096]))
    return data[:at] + bytes(end - at) + data[end:]


DAMAGES = {
    "a bit flipped": flip_bit,
    "a block of zeros": blank,
    "cut": lambda chance, data: data[:chance.randrange(len(data))],
    "empty": lambda chance, data: b"",
    "longer": lambda chance, data: data + chance.randbytes(chance.choice([1, 100])),
    "noise": lambda chance, data: chance.randbytes(len(data)),
}
VERBS = {
    "run": lambda scene, out: ["run", scene, "--out", out],
    "sim": lambda scene, out: ["sim", scene, "--out", out],
    "render": lambda scene, out: ["render", out],
    "verify": lambda scene, out: ["verify", out],
    "repair": lambda scene, out: ["verify", scene, "--out", out, "--repair"],
    "info": lambda scene, out: ["info", out, "--json"],
    "export": lambda scene, out: ["export", out, "--to", "csv", "--out", out / "exported"],
}
# What each of these has made when it ends with 0.
MAKES = {"run": ("cache", "frames", ".mp4"), "sim": ("cache",), "render": ("frames",), "repair": ("cache", "frames", ".mp4")}


def same(found, expected, parts):
    of = lambda files: {name: h for name, h in files.items() if name.startswith(parts) or name.endswith(parts)}
    return of(found) == of(expected)


def judge(verb, done, out, file, reference, expected):
    """The kind of the outcome; None where it breaks the promise."""
    if done.code == 4 and file.name in done.said:
        return "named"
    if done.code == 2 and file.name in done.said and "was not written by Thixo" in done.said:
        return "refused as another's"  # nothing in it shows any more who wrote it, and the files of others stay
    if done.code != 0:
        return None
    if verb in MAKES:
        if not same(contents(out), expected, MAKES[verb]):
            return None
        return "mended or without effect"
    if verb == "verify":
        return None  # a checksum differs, and it said that all is well
    if verb == "info":
        whole = json.loads(run(["thixo", "info", reference, "--json"]).said)
        return "without effect" if json.loads(done.said)["frames"] == whole["frames"] else None
    run(["thixo", "export", reference, "--to", "csv", "--out", out / "whole"])
    return "without effect" if tree(out, "exported") == {f"exported/{pathlib.Path(n).name}": h for n, h in tree(out, "whole").items()} else None


def one_round(campaign, number):
    chance = campaign.chance(number)
    scene = SCENES[number % len(SCENES)]
    reference, expected, _ = campaign.reference(scene)
    out = campaign.fresh()
    shutil.copytree(reference, out)
    files = sorted(f for f in out.rglob("*") if f.is_file() and f.stat().st_size > 0 and
                   (f.parent.name in ("cache", "assets", "checkpoint", "frames") or f.suffix == ".mp4"))
    file = chance.choice(files)
    kind, verb = chance.choice(sorted(DAMAGES)), chance.choice(sorted(VERBS))
    before = file.read_bytes()
    damaged = DAMAGES[kind](chance, before)
    if damaged == before:
        campaign.counts["without effect"] += 1
        return
    file.write_bytes(damaged)
    done = run(["thixo", *VERBS[verb](scene, out)])
    outcome = judge(verb, done, out, file, reference, expected)
    if outcome:
        campaign.counts[outcome] += 1
    else:
        campaign.breaks(number, f"{verb} after {file.relative_to(out)} was {kind}: exit {done.code}, {done.said.strip()[:300]}")
