"""Kills at random instants: of the command, of its stages, or of both. The run that goes on ends with the same bytes, and leaves nothing."""
import os
import signal
import subprocess
import time

import end_to_end as tools
from campaign import SCENES, children_of, contents, differing, leftovers, run


def kill(process, victims):
    stages = children_of(process.pid)
    for pid in {"command": [process.pid], "stages": stages, "both": [process.pid, *stages]}[victims]:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass  # it ended by itself


def one_round(campaign, number):
    """One chain of up to four kills, then a run to the end."""
    chance = campaign.chance(number)
    scene = SCENES[number % len(SCENES)]
    _, expected, seconds = campaign.reference(scene)
    out = campaign.fresh()
    for _ in range(chance.randint(1, 4)):
        victims = chance.choice(["command", "stages", "both"])
        process = subprocess.Popen([tools.bin_folder / "thixo", "run", str(scene), "--out", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(chance.uniform(0.01, 1) * seconds)
        if process.poll() is None:
            kill(process, victims)
            campaign.counts["kills"] += 1
        process.wait()
    done = run(["thixo", "run", scene, "--out", out])
    if done.code != 0:
        return campaign.breaks(number, f"exit {done.code} after kills: {done.said}")
    if leftovers(out):
        return campaign.breaks(number, f"left over: {leftovers(out)}")
    if other := differing(contents(out), expected):
        return campaign.breaks(number, f"other bytes after kills: {other}")
    campaign.counts["chains with the same bytes"] += 1
    return None
