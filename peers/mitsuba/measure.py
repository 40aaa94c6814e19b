"""Error against time of Mitsuba's path tracer, for the radiosity of each texel of a solved scene.

TRUTH… are directories of `solve`, or of the same layout: both the scene and the truth. What is
compared is B − E, its relative RMS by area, the worst channel."""

import argparse
import json
import math
import time
from pathlib import Path

import mitsuba as mi

# Three times as fast as scalar_rgb on the machine of docs/measurements.md.
VARIANT = "llvm_ad_rgb"
BOUNDS = [0.01, 0.003]


def render(truth, what, sampler, samples, seed):
    """B − E of each texel, the seconds of rendering and those of compiling its kernels."""
    import drjit as dr
    import numpy as np
    from scene import sensor

    view = sensor(truth, sampler, samples)
    dr.kernel_history_clear()
    start = time.perf_counter()
    image = np.array(mi.render(what, sensor=view, integrator=path(), spp=samples, seed=seed))
    seconds = time.perf_counter() - start
    parts = ("codegen_time", "backend_time")
    compiling = sum(kernel.get(part, 0.0) for kernel in dr.kernel_history() for part in parts) / 1e3
    reflected = np.pi * image.reshape(truth.reflected.shape) - truth.emission[:, None]
    return reflected, seconds - compiling, compiling


def path():
    """Light of any number of bounces; Russian roulette from the fifth, as by default."""
    return mi.load_dict({"type": "path", "max_depth": -1})


def points(folder, samplers, counts, threads):
    from scene import scene
    from truth import read, relative_rms

    truth = read(folder)
    start = time.perf_counter()
    what = scene(truth)
    loading = time.perf_counter() - start
    for sampler in samplers:
        for count in counts:
            # The faster of two, since the machine may be busy.
            _, first, compiling = render(truth, what, sampler, count, 0)
            reflected, second, _ = render(truth, what, sampler, count, 1)
            difference = reflected - truth.reflected
            covered = (truth.reflected == 0).all(axis=-1)
            yield {
                "peer": f"mitsuba {mi.__version__}",
                "variant": VARIANT,
                "sampler": sampler,
                "scene": truth.name,
                "texels": truth.texels,
                "samples": count,
                "seconds": min(first, second),
                "setup_seconds": loading + compiling,
                "error": relative_rms(difference, truth.reflected, truth.area),
                "bias": bias(difference, truth),
                "noise_of_truth": truth.noise,
                "light_on_dark_texels": float(reflected[covered].max(initial=0.0)),
                "threads": threads,
            }


def bias(difference, truth):
    """ΣA(a−b) / ΣA b, the worst channel."""
    total = lambda values: (truth.area[..., None] * values).sum((0, 1))
    return float(max(total(difference) / total(truth.reflected), key=abs))


def extrapolated(point, bound):
    """Seconds to an error, which falls as 1/√t; the truth's own noise is taken out."""
    own = math.sqrt(max(point["error"] ** 2 - point["noise_of_truth"] ** 2, 0.0))
    kept = ("peer", "variant", "sampler", "scene", "texels", "threads")
    seconds = point["seconds"] * (own / bound) ** 2
    return {key: point[key] for key in kept} | {"bound": bound, "seconds": seconds}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("truth", nargs="+", type=Path)
    parser.add_argument("--samples", default="16,64,256,1024")
    parser.add_argument("--samplers", default="multijitter,independent")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/peers.json"))
    arguments = parser.parse_args()
    mi.set_variant(VARIANT)
    import drjit

    drjit.set_thread_count(arguments.threads)
    drjit.set_flag(drjit.JitFlag.KernelHistory, True)
    counts = [int(count) for count in arguments.samples.split(",")]
    found, last = [], {}
    for folder in arguments.truth:
        for point in points(folder, arguments.samplers.split(","), counts, arguments.threads):
            found.append(point)
            last[point["scene"], point["sampler"]] = point
            print("{scene:16} {sampler:12} {samples:5} samples {seconds:8.2f} s "
                  "(set-up {setup_seconds:.2f} s) error {error:.4%}, bias {bias:.4%}".format(**point))
    ends = [extrapolated(point, bound) for point in last.values() for bound in BOUNDS]
    for end in ends:
        print("{scene:16} {sampler:12} {bound:.1%} in {seconds:.1f} s".format(**end))
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"points": found, "extrapolated": ends}, indent=1)
    arguments.out.write_text(text + "\n")


main()
