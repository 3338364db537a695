"""Long campaigns against the promises about files: many rounds, drawn by a fixed seed, each judged by what is promised.

Usage: campaign.py BIN_FOLDER kills|damage|together [--rounds N] [--seed N] [--record docs/reliability.md]

Every campaign prints what happened how often, and ends with 1 where a promise was broken. With --record it writes its row of the page.
"""
import argparse
import collections
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "scenes")]
import end_to_end as tools  # noqa: E402

SCENES = [HERE.parent / "scenes/tiny.yaml", HERE.parent / "scenes/tiny_implicit.yaml",
          *(HERE / f"{name}.yaml" for name in ("melting", "rubber", "breaking", "implicit", "periodic", "lights"))]
longest = 60  # seconds that a verb may take on these scenes; --longest tells another number where the machine is busy


class Outcome:
    """What a program said and did."""
    def __init__(self, code, said, seconds):
        self.code, self.said, self.seconds = code, said, seconds


def run(words, limit=None):
    limit = limit or longest
    begun = time.monotonic()
    try:
        done = subprocess.run([tools.bin_folder / words[0], *map(str, words[1:])], capture_output=True, check=False, timeout=limit)
        return Outcome(done.returncode, (done.stdout + done.stderr).decode("utf-8", "replace"), time.monotonic() - begun)
    except subprocess.TimeoutExpired:
        return Outcome(None, "", limit)


def contents(out):
    """Checksums of all that a run promises: cache, pictures and film. States and times differ by how it was made."""
    files = tools.tree(out, *[p.name for p in out.iterdir() if p.is_dir() and p.name != "checkpoint"])
    files.update({f.name: tools.digest(f) for f in out.glob("*.mp4")})
    return files


def differing(found, expected):
    return sorted(name for name in found.keys() | expected.keys() if found.get(name) != expected.get(name))


class Campaign:
    """Counts outcomes, and keeps the broken promises with the round that broke them."""
    def __init__(self, place, seed):
        self.place, self.seed = place, seed
        self.counts, self.broken = collections.Counter(), []
        self.references = {}

    def chance(self, number):
        """Rounds do not depend on each other, so that one can be repeated alone."""
        return random.Random(f"{self.seed} {number}")

    def reference(self, scene):
        if scene not in self.references:
            out = self.place / f"reference {scene.stem}"
            done = run(["thixo", "run", scene, "--out", out], 10 * longest)
            if done.code != 0:
                raise RuntimeError(f"{scene.name} does not run: {done.said}")
            self.references[scene] = out, contents(out), done.seconds
        return self.references[scene]

    def fresh(self, name="tried"):
        out = self.place / name
        shutil.rmtree(out, ignore_errors=True)
        return out

    def breaks(self, number, what):
        self.counts["broken"] += 1
        self.broken.append(f"round {number}: {what}")


def children_of(pid):
    try:
        return [int(c) for c in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def program_of(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/comm").read_text().strip()
    except OSError:
        return ""


def leftovers(out):
    return sorted(str(p.relative_to(out)) for p in out.rglob("*") if ".tmp" in p.name or p.name.startswith(".film") or p.name.startswith("refused."))


def record(page, name, campaign, rounds):
    """Replaces the campaign's row of the table."""
    told = ", ".join(f"{count} {what}" for what, count in sorted(campaign.counts.items()))
    row = f"| {name} | {rounds} | {campaign.seed} | {told} |"
    lines = page.read_text().splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith(f"| {name} |"))
    lines[at] = row
    page.write_text("\n".join(lines) + "\n")


def attempt(one_round, campaign, numbers):
    """Makes the rounds, and returns how many. Ctrl-C ends them: what was counted by then is told."""
    done = 0
    try:
        for number in numbers:
            one_round(campaign, number)
            done += 1
            if done % 100 == 0:
                print(f"{done} rounds:", dict(sorted(campaign.counts.items())), *campaign.broken, sep="\n  ", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
    return done


def main():
    global longest
    import damage
    import kills
    import together
    campaigns = {"kills": kills.one_round, "damage": damage.one_round, "together": together.one_round}
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("bin_folder", type=pathlib.Path)
    words.add_argument("campaign", choices=campaigns)
    words.add_argument("--rounds", type=int, default=10)
    words.add_argument("--first", type=int, default=0, help="number of the first round")
    words.add_argument("--step", type=int, default=1, help="from a round's number to the next: 8 stays with one scene")
    words.add_argument("--seed", type=int, default=20260101)
    words.add_argument("--longest", type=int, default=longest, help="seconds that a verb may take before it counts as hanging")
    words.add_argument("--record", type=pathlib.Path)
    given = words.parse_args()
    tools.bin_folder = given.bin_folder.resolve()
    longest = given.longest
    with tempfile.TemporaryDirectory(prefix="thixo faults ") as place:
        campaign = Campaign(pathlib.Path(place), given.seed)
        done = attempt(campaigns[given.campaign], campaign, range(given.first, given.first + given.rounds * given.step, given.step))
    print(f"{given.campaign}, {done} rounds from {given.first} by {given.step}, seed {given.seed}:", dict(sorted(campaign.counts.items())))
    print(*campaign.broken, sep="\n")
    if given.record:
        record(given.record, given.campaign, campaign, done)
    return 1 if campaign.broken else 0


if __name__ == "__main__":
    # The campaigns import this file by its name.
    sys.modules["campaign"] = sys.modules["__main__"]
    sys.exit(main())
