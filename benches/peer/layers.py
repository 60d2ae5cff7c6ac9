"""What layers cost: benches/peer/layers.py FSTOP FOLDER [TURNS [SCENE[:SAMPLES]...]]

FOLDER has the scenes with what they read: `PREPARE=FOLDER benches/peer/run.sh`. Each is rendered without layers and with all ten, on one thread,
with its own samples or so many. In a turn that is done three times, without and with by turns, scene after scene. Printed are processor seconds of the whole
process without any, and what layers add: medians over TURNS (31, and six at least) of a turn's least times, and a range that has the true median with 95 % confidence
(of order statistics, which no outlier moves). The last line is of the geometric mean over the scenes of each turn. SMALLER=2 in the environment
makes images so many times less wide and high.

With COUNT=1 in the environment it is instructions, in units of 10^9, as valgrind counts them, which no other program on the machine disturbs, of images a
third as wide and as high, with those seven that are plain means and with all ten.
"""

import math
import os
import re
import resource
import statistics
import subprocess
import sys

SCENES = "creature cornell dgauss meadow copper glass media lamps textures room".split()
SEVEN = "albedo,normal,depth,position,uv,coc,alpha"
TEN = f"{SEVEN},material,instance,motion"


def words(fstop, folder, scene, layers):
    name, _, spp = scene.partition(":")
    words = [fstop, "render", f"{folder}/layers_{name}.pbrt", "--threads", "1", "--quiet", "--no-checkpoint"]
    spp = ["--spp", spp] if spp else []
    layers = ["--aov", layers] if layers else []
    return [*words, *spp, *layers, "-o", f"{folder}/layers.exr"]


def shrink(folder, scene, by):
    """The scene with images so many times less wide and high."""
    name = scene.partition(":")[0]
    with open(f"{folder}/{name}.pbrt") as file:
        text = file.read()
    size = r'("integer [xy]resolution" *\[ *)(\d+)'
    text = re.sub(size, lambda found: f"{found[1]}{int(int(found[2]) / by)}", text)
    with open(f"{folder}/layers_{name}.pbrt", "w") as file:
        file.write(text)


def seconds(words):
    def spent():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before = spent()
    subprocess.run(words, check=True)
    return spent() - before


def instructions(words):
    valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    told = subprocess.run([*valgrind, *words], check=True, capture_output=True, text=True)
    return int(re.search(r"Collected : (\d+)", told.stderr)[1]) / 1e9


def interval(values):
    """The median, and order statistics that have that of the distribution between them with 95 % confidence (binomial)."""
    values, n = sorted(values), len(values)
    below, beyond = 0, 0.0
    while (beyond := beyond + math.comb(n, below) / 2**n) < 0.025:
        below += 1
    low = max(below - 1, 0)
    return statistics.median(values), values[low], values[n - 1 - low]


def percent(value):
    return f"{100 * math.expm1(value):+7.2f}%"


def report(name, least, logs):
    median, low, high = map(percent, interval(logs))
    print(f"{name:14} {least} {median}   {low} to {high}", flush=True)


def main(fstop, folder, turns=31, *names):
    names = names or SCENES
    counts = "COUNT" in os.environ
    for scene in names:
        shrink(folder, scene, 3 if counts else float(os.environ.get("SMALLER", 1)))
    if counts:
        return count(fstop, folder, names)
    logs = {scene: [] for scene in names}
    plain = {scene: [] for scene in names}
    for _ in range(int(turns)):
        for scene in names:
            times = {"": [], TEN: []}
            for layers in ["", TEN, TEN, "", "", TEN]:
                times[layers].append(seconds(words(fstop, folder, scene, layers)))
            without, with_all = (min(all) for all in times.values())
            plain[scene].append(without)
            logs[scene].append(math.log(with_all / without))
    print(f"{'scene':14} {'seconds':>8} {'all ten':>8}   with 95 % confidence")
    for scene in names:
        report(scene, f"{statistics.median(plain[scene]):8.3f}", logs[scene])
    report("geometric mean", " " * 8, [sum(turn) / len(turn) for turn in zip(*logs.values())])


def count(fstop, folder, names):
    print(f"{'scene':14} {'10^9':>8} {'seven':>8} {'all ten':>8}")
    logs = []
    for scene in names:
        none, *more = (instructions(words(fstop, folder, scene, layers)) for layers in ["", SEVEN, TEN])
        logs.append([math.log(cost / none) for cost in more])
        print(f"{scene:14} {none:8.2f}", *map(percent, logs[-1]), flush=True)
    print(f"{'geometric mean':23}", *(percent(sum(all) / len(all)) for all in zip(*logs)))


main(*sys.argv[1:])
