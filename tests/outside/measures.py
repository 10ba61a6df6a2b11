"""Holds `steradian compare` against numpy and the authors' own FLIP on ten pairs of images; exit code 1 past 1e-4.

    pip install numpy flip-evaluator
    python3 tests/outside/measures.py target/release/steradian

Writes each pair as Radiance .hdr, which both sides read: what is compared is the measures, not the writers.
"""

import json
import subprocess
import sys
import tempfile

import flip_evaluator
import numpy as np


def write_hdr(path, pixels):
    """Radiance RGBE without run lengths; returns what a reader gets back."""
    top = np.maximum(pixels.max(axis=2), 1e-32)
    exponent = np.floor(np.log2(top)).astype(int) + 1
    mantissa = np.clip(np.floor(pixels / np.exp2(exponent - 8)[..., None]), 0, 255).astype(np.uint8)
    rgbe = np.concatenate([mantissa, (exponent + 128).astype(np.uint8)[..., None]], axis=2)
    height, width, _ = pixels.shape
    with open(path, "wb") as out:
        out.write(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode())
        out.write(rgbe.tobytes())
    return (mantissa * np.exp2(exponent - 8.0)[..., None]).astype(np.float32)


def pairs(random):
    """Ten pairs: smooth, noisy, shifted, dim, bright, with fireflies, nearly equal."""
    y, x = np.mgrid[0:96, 0:128]
    smooth = np.stack([0.5 + 0.4 * np.sin(x / 9), 0.5 + 0.4 * np.cos(y / 7), 0.3 + 0.2 * np.sin((x + y) / 11)], axis=2)
    blocks = np.where(((x // 16 + y // 16) % 2 == 0)[..., None], [0.8, 0.2, 0.1], [0.1, 0.3, 0.7])
    sun = smooth + 400.0 * np.exp(-((x - 90) ** 2 + (y - 20) ** 2) / 30.0)[..., None]
    noise = lambda scale: scale * random.exponential(1.0, smooth.shape)
    spark = np.where(random.random(smooth.shape[:2])[..., None] < 0.002, 50.0, 0.0)
    yield "noise", smooth * noise(1.0), smooth
    yield "little noise", smooth * (1 + 0.05 * random.standard_normal(smooth.shape)).clip(0), smooth
    yield "shift", np.roll(blocks, 2, axis=1), blocks
    yield "tint", blocks * [1.1, 1.0, 0.9], blocks
    yield "dim", 1e-3 * smooth * noise(1.0), 1e-3 * smooth
    yield "sun", sun * (1 + 0.2 * random.standard_normal(sun.shape)).clip(0), sun
    yield "fireflies", smooth + spark, smooth
    yield "bright", 3e4 * blocks * noise(1.0), 3e4 * blocks
    yield "half black", np.where((x < 50)[..., None], 0.0, smooth) + 0.01, np.where((x < 50)[..., None], 0.0, blocks) + 0.02
    yield "gray", np.full_like(smooth, 0.5), np.full_like(smooth, 0.48)


def srgb(linear):
    v = np.clip(linear, 0, 1)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.maximum(v, 1e-9) ** (1 / 2.4) - 0.055)


def expected(image, reference):
    """The measures by numpy and flip-evaluator."""
    x, r = image.astype(np.float64), reference.astype(np.float64)
    term = ((x - r) ** 2 / (r * r + 0.01)).mean(axis=2).ravel()
    kept = np.sort(term)[: term.size - int(np.ceil(term.size * 0.001))]
    evaluate = flip_evaluator.evaluate
    return {
        "relmse": term.mean(),
        "relmse_exposure": ((x - r) ** 2 / (r * r + (0.1 * r.mean()) ** 2)).mean(),
        "relmse_trimmed": kept.mean(),
        "rmse": np.sqrt(((x - r) ** 2).mean()),
        "bias": (x - r).mean(),
        "flip": evaluate(srgb(reference).astype(np.float32), srgb(image).astype(np.float32), "LDR", applyMagma=False)[1],
        "flip_hdr": evaluate(reference, image, "HDR", inputsRGB=False, applyMagma=False)[1],
    }


def main():
    program = sys.argv[1]
    worst = 0.0
    print(f"{'pair':14}" + "".join(f"{k:>17}" for k in ["relmse", "relmse_exposure", "relmse_trimmed", "rmse", "bias", "flip", "flip_hdr"]))
    for name, image, reference in pairs(np.random.default_rng(7)):
        with tempfile.TemporaryDirectory() as folder:
            a, b = f"{folder}/a.hdr", f"{folder}/b.hdr"
            image, reference = write_hdr(a, image), write_hdr(b, reference)
            said = json.loads(subprocess.run([program, "compare", a, b, "--json"], check=True, capture_output=True).stdout)
        row = f"{name:14}"
        for key, value in expected(image, reference).items():
            # FLIP lies in [0, 1] and is held absolutely, the others relative to their size.
            scale = 1.0 if key.startswith("flip") else max(abs(value), 1e-6)
            off = abs(said[key] - value) / scale
            worst = max(worst, off)
            row += f"{said[key]:>17.6g}" if off <= 1e-4 else f"{said[key]:>9.4g}!{value:<7.4g}"
        print(row)
    print(f"largest difference {worst:.1e} (relative; FLIP absolute), bound 1e-4")
    sys.exit(0 if worst <= 1e-4 else 1)


main()
