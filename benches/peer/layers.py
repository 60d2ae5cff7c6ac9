"""What layers cost: benches/peer/layers.py FSTOP FOLDER [RUNS [SCENE[:SAMPLES]...]]

FOLDER has the scenes with what they read: `PREPARE=FOLDER benches/peer/run.sh`. Each is rendered without layers, with those seven that are
plain means, and with all ten, in turns, on one thread, with its own samples or so many. Printed are processor seconds of the whole process
without any, the least of RUNS (5), and what the others take more.
"""

import math
import resource
import subprocess
import sys

SCENES = "creature cornell dgauss meadow copper glass media lamps textures room".split()
SEVEN = "albedo,normal,depth,position,uv,coc,alpha"
LAYERS = [[], ["--aov", SEVEN], ["--aov", f"{SEVEN},material,instance,motion"]]


def seconds(fstop, folder, name, spp, layers):
    def spent():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before = spent()
    words = [fstop, "render", f"{folder}/{name}.pbrt", "--threads", "1", "--quiet", "--no-checkpoint"]
    spp = ["--spp", spp] if spp else []
    subprocess.run([*words, *spp, *layers, "-o", f"{folder}/layers.exr"], check=True)
    return spent() - before


def main(fstop, folder, runs=5, *names):
    print(f"{'scene':12} {'seconds':>8} {'seven':>8} {'all ten':>8}")
    logs = [0.0, 0.0]
    names = names or SCENES
    for scene in names:
        name, _, spp = scene.partition(":")
        least = [math.inf] * len(LAYERS)
        for _ in range(int(runs)):
            for i, layers in enumerate(LAYERS):
                least[i] = min(least[i], seconds(fstop, folder, name, spp, layers))
        more = [time / least[0] for time in least[1:]]
        logs = [log + math.log(ratio) for log, ratio in zip(logs, more)]
        shown = " ".join(f"{100 * (ratio - 1):+7.1f}%" for ratio in more)
        print(f"{scene:12} {least[0]:8.2f} {shown}", flush=True)
    means = " ".join(f"{100 * math.expm1(log / len(names)):+7.1f}%" for log in logs)
    print(f"{'geometric mean':21} {means}")


main(*sys.argv[1:])
