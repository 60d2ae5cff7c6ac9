"""fstop beside Mitsuba 3 (`pip install mitsuba numpy`): benches/peer/mitsuba/compare.py FSTOP FOLDER [RUNS [SCENE[:SAMPLES]...]]

FOLDER has the .pbrt files with what they read: `PREPARE=FOLDER benches/peer/run.sh`. The programs take turns, with as many threads as
there are processors (with a pool of one, Dr.Jit 1.5 hung with LLVM 20). Processor seconds of user code, the median of RUNS (5): of
fstop for the whole process, of Mitsuba for rendering alone and after a first one, which compiles. The error is each program's own,
from the scatter of its runs with different seeds, over the square of its mean: models that differ a little do not count. Time to
equal error: error times seconds, as errors fall with samples.

Mitsuba's sampler is `multijitter`, its best, which rounds 32 samples up to 35, and 8 to 9; `ldsampler` is biased in the box.
DRJIT_LIBLLVM_PATH names LLVM's library where it is not found: 14 is not, 15 cannot compile these scenes for AVX-512, 20 can.
"""

import os
import resource
import statistics
import subprocess
import sys

import mitsuba as mi
import numpy

import scenes

VARIANT = os.environ.get("VARIANT", "llvm_ad_rgb")


def user_seconds(who):
    return resource.getrusage(who).ru_utime


def theirs(scene, spp, seed):
    before = user_seconds(resource.RUSAGE_SELF)
    image = numpy.array(mi.render(scene, spp=spp, seed=seed))
    return user_seconds(resource.RUSAGE_SELF) - before, image


def ours(fstop, folder, name, spp, seed):
    before = user_seconds(resource.RUSAGE_CHILDREN)
    words = [fstop, "render", f"{folder}/{name}.pbrt", "--spp", str(spp), "--seed", str(seed)]
    subprocess.run(words + ["--quiet", "-o", f"{folder}/ours.exr"], check=True)
    seconds = user_seconds(resource.RUSAGE_CHILDREN) - before
    bitmap = mi.Bitmap(f"{folder}/ours.exr").convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return seconds, numpy.array(bitmap)


def error(images):
    """Mean variance of a pixel over the squared mean of all."""
    images = numpy.stack(images)
    return float(images.var(axis=0, ddof=1).mean() / images.mean() ** 2)


def main():
    fstop, folder = sys.argv[1:3]
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    mi.set_variant(VARIANT)
    print(f"{'scene':10} {'spp':>4} {'fstop s':>8} {'Mitsuba s':>9} {'ratio':>6} {'error':>9} {'Mitsuba':>9} {'equal error':>11} {'means':>6}")
    for word in sys.argv[4:] or scenes.SCENES:
        name, _, samples = word.partition(":")
        make, spp = scenes.SCENES[name]
        spp = int(samples or spp)
        scene = mi.load_dict(make(mi, folder))
        theirs(scene, spp, 0)
        pairs = [(ours(fstop, folder, name, spp, i), theirs(scene, spp, i)) for i in range(1, runs + 1)]
        (a, b) = ([pair[k][0] for pair in pairs] for k in (0, 1))
        (x, y) = ([pair[k][1] for pair in pairs] for k in (0, 1))
        seconds = [statistics.median(a), statistics.median(b)]
        errors = [error(x), error(y)]
        equal = seconds[1] * errors[1] / (seconds[0] * errors[0])
        means = numpy.mean(x) / numpy.mean(y)
        print(
            f"{name:10} {spp:4} {seconds[0]:8.2f} {seconds[1]:9.2f} {seconds[1] / seconds[0]:6.2f} "
            f"{errors[0]:9.2e} {errors[1]:9.2e} {equal:11.2f} {means:6.3f}",
            flush=True,
        )


main()
