"""What layers cost: benches/peer/layers.py FSTOP FOLDER [RUNS [SCENE[:SAMPLES]...]]

FOLDER has the scenes with what they read: `PREPARE=FOLDER benches/peer/run.sh`. Each is rendered without layers, with those seven that are
plain means, and with all ten, in turns, on one thread, with its own samples or so many. Printed are processor seconds of the whole process
without any, the least of RUNS (5), and what the others take more. With COUNT=1 in the environment it is instructions, in units of 10^9, as valgrind counts
them, which no other program on the machine disturbs, of images a third as wide and as high.
"""

import math
import os
import re
import resource
import subprocess
import sys

SCENES = "creature cornell dgauss meadow copper glass media lamps textures room".split()
SEVEN = "albedo,normal,depth,position,uv,coc,alpha"
LAYERS = [[], ["--aov", SEVEN], ["--aov", f"{SEVEN},material,instance,motion"]]


def words(fstop, folder, scene, spp, layers):
    words = [fstop, "render", f"{folder}/{scene}.pbrt", "--threads", "1", "--quiet", "--no-checkpoint"]
    spp = ["--spp", spp] if spp else []
    return [*words, *spp, *layers, "-o", f"{folder}/layers.exr"]


def seconds(fstop, folder, *render):
    def spent():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before = spent()
    subprocess.run(words(fstop, folder, *render), check=True)
    return spent() - before


def instructions(fstop, folder, scene, *render):
    with open(f"{folder}/{scene}.pbrt") as file:
        text = file.read()
    size = r'("integer [xy]resolution" *\[ *)(\d+)'
    text = re.sub(size, lambda found: f"{found[1]}{int(found[2]) // 3}", text)
    with open(f"{folder}/layers_small.pbrt", "w") as file:
        file.write(text)
    valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    small = words(fstop, folder, "layers_small", *render)
    told = subprocess.run([*valgrind, *small], check=True, capture_output=True, text=True)
    return int(re.search(r"Collected : (\d+)", told.stderr)[1]) / 1e9


def main(fstop, folder, runs=5, *names):
    counts = "COUNT" in os.environ
    cost, runs = (instructions, 1) if counts else (seconds, runs)
    print(f"{'scene':12} {'10^9' if counts else 'seconds':>8} {'seven':>8} {'all ten':>8}")
    logs = [0.0, 0.0]
    names = names or SCENES
    for scene in names:
        name, _, spp = scene.partition(":")
        least = [math.inf] * len(LAYERS)
        for _ in range(int(runs)):
            for i, layers in enumerate(LAYERS):
                least[i] = min(least[i], cost(fstop, folder, name, spp, layers))
        more = [time / least[0] for time in least[1:]]
        logs = [log + math.log(ratio) for log, ratio in zip(logs, more)]
        shown = " ".join(f"{100 * (ratio - 1):+7.1f}%" for ratio in more)
        print(f"{scene:12} {least[0]:8.2f} {shown}", flush=True)
    means = " ".join(f"{100 * math.expm1(log / len(names)):+7.1f}%" for log in logs)
    print(f"{'geometric mean':21} {means}")


main(*sys.argv[1:])
