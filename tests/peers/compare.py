"""A table of errors at equal processor time: Regulus by its defaults beside Mitsuba 3, LuxCore and Cycles by theirs.

  tests/peers/run BUILD-FOLDER [--side 64] [--seconds 4] [--seeds 5] [--reference-seconds 60] SCENE...

Each renderer is measured against its own converged picture, because converted materials are only alike; how far the means
of these pictures differ from Regulus' stands in a column of its own. Seconds are those of processor time of rendering:
two renders tell start-up from the time of a sample, and so many samples are taken as the seconds pay for.
"""
import argparse
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
PEERS = ("regulus", "mitsuba", "luxcore", "cycles")
TRIMMED = 0.001  # of the pixels, the largest, are left out of the second error


def render(peer, scene, side, samples, seed, regulus):
    """A picture, and the processor time that the process took, in seconds."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "picture.npy")
        if peer == "regulus":
            exr = os.path.join(folder, "picture.exr")
            command = [regulus, "render", scene, "--size", f"{side}x{side}", "-s", str(samples), "--seed", str(seed),
                       "--filter", "box", "--quiet", "-o", exr]
        else:
            command = [sys.executable, str(HERE / f"{peer}_peer.py"), scene, str(side), str(samples), str(seed), out]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            raise RuntimeError(f"{peer}: {done.stdout[-2000:]}")
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        if peer == "regulus":
            import mitsuba
            mitsuba.set_variant("scalar_rgb")
            return np.array(mitsuba.Bitmap(exr), dtype=float)[..., :3], cpu
        return np.load(out), cpu


def errors(picture, reference):
    """Mean squared error, and trimmed relative mean squared error."""
    squares = (picture - reference) ** 2
    relative = np.sort((squares / (reference ** 2 + 0.01)).mean(axis=2).ravel())
    return squares.mean(), relative[:len(relative) - int(TRIMMED * len(relative))].mean()


def cost(peer, scene, options):
    """Seconds of start-up, and of a sample."""
    render(peer, scene, options.side, 1, 1, options.regulus)  # fills caches of compiled kernels
    few = render(peer, scene, options.side, 1, 1, options.regulus)[1]
    samples = 16
    while True:
        many = render(peer, scene, options.side, samples, 1, options.regulus)[1]
        if many - few > options.seconds / 2 or samples >= 4096:
            each = max((many - few) / (samples - 1), 1e-6)
            return max(few - each, 0), each
        samples *= 4


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("regulus")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--side", type=int, default=64, help="pixels")
    parser.add_argument("--seconds", type=float, default=4)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--reference-seconds", type=float, default=60)
    options = parser.parse_args()
    print("| scene | renderer | samples | start-up, s | MSE | trimmed relMSE | mean over Regulus' |\n|---|---|---|---|---|---|---|")
    for scene in options.scenes:
        mean = None
        for peer in PEERS:
            name = pathlib.Path(scene).stem
            try:
                start, each = cost(peer, scene, options)
                samples = max(1, round(options.seconds / each))
                reference = render(peer, scene, options.side, max(16, round(options.reference_seconds / each)), 1000,
                                   options.regulus)[0]
                found = [errors(render(peer, scene, options.side, samples, seed, options.regulus)[0], reference)
                         for seed in range(1, options.seeds + 1)]
            except (RuntimeError, ValueError) as error:
                print(f"| {name} | {peer} | {str(error).splitlines()[-1][:100]} | | | | |", flush=True)
                continue
            if mean is None:
                mean = reference.mean()
            mse, trimmed = np.mean(found, axis=0)
            print(f"| {name} | {peer} | {samples} | {start:.1f} | {mse:.3g} | {trimmed:.3g} | {reference.mean() / mean:.3f} |",
                  flush=True)


main()
