"""Kills at random instants: of the command, of its stages, or of both. The run that goes on ends with the same bytes, and leaves nothing."""
import os
import shutil
import signal
import subprocess
import time

import end_to_end as tools
from campaign import SCENES, children_of, contents, differing, leftovers, program_of, run

film_seconds = {}  # by scene: what the film alone takes


def kill(process, victims):
    """Kills, and returns the stage that was running: the film's encoder, the renderer, the simulation or none."""
    stages = children_of(process.pid)
    running = {program_of(pid) for pid in stages}
    for pid in {"command": [process.pid], "stages": stages, "both": [process.pid, *stages]}[victims]:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass  # it ended by itself
    return next((name for name in ("ffmpeg", "thixo-render", "thixo-sim") if name in running), "no stage")


def without_film(reference, out):
    shutil.copytree(reference, out)
    for film in out.glob("*.mp4"):
        film.unlink()


def seconds_of_film(scene, reference, out):
    if scene not in film_seconds:
        without_film(reference, out)
        film_seconds[scene] = run(["thixo", "run", scene, "--out", out]).seconds
        shutil.rmtree(out)
    return film_seconds[scene]


def one_round(campaign, number):
    """One chain of up to four kills, then a run to the end. One chain in four begins when all but the film is there."""
    chance = campaign.chance(number)
    scene = SCENES[number % len(SCENES)]
    reference, expected, seconds = campaign.reference(scene)
    out = campaign.fresh()
    if chance.random() < 0.25:
        seconds = seconds_of_film(scene, reference, out)
        without_film(reference, out)
    for _ in range(chance.randint(1, 4)):
        victims = chance.choice(["command", "stages", "both"])
        process = subprocess.Popen([tools.bin_folder / "thixo", "run", str(scene), "--out", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(chance.uniform(0.01, 1) * seconds)
        if process.poll() is None:
            campaign.counts[f"kills during {kill(process, victims)}"] += 1
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
