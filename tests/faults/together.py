"""Two verbs at once on one folder: each does its work or is refused in clear words, and nothing is lost."""
import shutil
import subprocess

import end_to_end as tools
import campaign as common
from campaign import SCENES, contents, run

VERBS = {
    "run": lambda scene, out: ["run", scene, "--out", out],
    "sim": lambda scene, out: ["sim", scene, "--out", out],
    "render": lambda scene, out: ["render", out],
    "preview": lambda scene, out: ["preview", out, "--frames", "1-2"],
    "verify": lambda scene, out: ["verify", out],
    "repair": lambda scene, out: ["verify", scene, "--out", out, "--repair"],
    "info": lambda scene, out: ["info", out],
}
PAIRS = [(a, b) for a in sorted(VERBS) for b in sorted(VERBS) if a <= b]


def refused_clearly(code, said):
    """Another one writes the folder; or a reader came upon what was just being replaced."""
    return (code == 2 and "is being written" in said) or code == 4


def one_round(campaign, number):
    """A finished folder, or one with some pictures gone, of which both verbs may make what is missing."""
    chance = campaign.chance(number)
    scene = SCENES[number // len(PAIRS) % len(SCENES)]
    reference, expected, _ = campaign.reference(scene)
    out = campaign.fresh()
    shutil.copytree(reference, out)
    for file in chance.sample(sorted((out / "frames").glob("beauty.*")), 2):
        file.unlink()
    pair = PAIRS[number % len(PAIRS)]
    started = [subprocess.Popen([tools.bin_folder / "thixo", *map(str, VERBS[verb](scene, out))], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
               for verb in pair]
    for verb, process in zip(pair, started):
        said = process.communicate(timeout=common.longest)[0]
        if process.returncode == 0:
            campaign.counts["done"] += 1
        elif refused_clearly(process.returncode, said):
            campaign.counts["told"] += 1
        else:
            campaign.breaks(number, f"{verb} beside {' and '.join(pair)}: exit {process.returncode}, {said.strip()[:300]}")
    done = run(["thixo", "run", scene, "--out", out])
    found = {name: h for name, h in contents(out).items() if name in expected}
    if done.code != 0 or found != expected:
        campaign.breaks(number, f"after {' and '.join(pair)}: exit {done.code}, other bytes: {found != expected}")
