#!/usr/bin/env python3
"""Times Mitsuba 3 on the scenes of scenes/peer_{a,b,c,d}.toml, and its error against its own long render.

Written from the same numbers as the scene files; what differs is said in docs/peers.md. Prints one line a scene and variant:
Msamples/s (median of rounds, kernel warm), the same a core of processor time (for busy machines), samples and seconds to a trimmed relMSE of 1e-2 by extrapolation 1/N.

    pip install mitsuba numpy               # 3.9.1; llvm variants need LLVM: DRJIT_LIBLLVM_PATH=.../libLLVM.so.19.1
    STERADIAN_ASSETS=../shared/assets python3 benches/peers_mitsuba.py --variant llvm_ad_rgb --scenes abc
"""
import argparse
import os
import sys
import time

import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
METALS = {
    "gold": ((0.1834, 0.4215, 1.3731), (3.4291, 2.3457, 1.7704)),
    "copper": ((0.2004, 0.9240, 1.1022), (3.9129, 2.4528, 2.1421)),
    "aluminium": ((1.6574, 0.8803, 0.5212), (9.2238, 6.2695, 4.8370)),
}


def rgb(value):
    return {"type": "rgb", "value": [float(c) for c in value]}



def build(mi, name):
    T = mi.ScalarTransform4f

    def diffuse(*c):
        return {"type": "diffuse", "reflectance": rgb(c)}

    def metal(which, alpha):
        eta, k = METALS[which]
        return {"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "eta": rgb_unbounded(mi, eta), "k": rgb_unbounded(mi, k)}

    def rectangle(center, u, v, bsdf, emission=None):
        n = np.cross(u, v)
        n = n / np.linalg.norm(n)
        m = np.eye(4)
        m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = u, v, n, center
        shape = {"type": "rectangle", "to_world": T(m), "bsdf": bsdf}
        if emission is not None:
            shape["emitter"] = {"type": "area", "radiance": rgb_unbounded(mi, emission)}
        return shape

    def box(low, high, turn, translate, bsdf):
        c, h = (np.add(low, high)) / 2, (np.subtract(high, low)) / 2
        to_world = T().translate(translate).rotate([0, 1, 0], turn).translate(list(c)).scale(list(h))
        return {"type": "cube", "to_world": to_world, "bsdf": bsdf}

    def camera(origin, target, fov):
        return {
            "type": "perspective", "fov": fov, "fov_axis": "y", "to_world": T().look_at(origin, target, [0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 256, "height": 256, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
            "sampler": {"type": "independent"},
        }

    def sky():
        # Steradian's image centre is -z; Mitsuba's is turned. The turn is from its documentation; no picture has confirmed it yet.
        assets = os.environ.get("STERADIAN_ASSETS", os.path.join(ROOT, "../shared/assets"))
        path = os.path.join(assets, "hdri/chinese_garden_1k.hdr")
        return {"type": "envmap", "filename": path, "to_world": T().rotate([0, 1, 0], 180)}

    def sphere(center, radius, bsdf):
        return {"type": "sphere", "center": center, "radius": radius, "bsdf": bsdf}

    scene = {"type": "scene", "integrator": {"type": "path", "max_depth": 8, "rr_depth": 5}}
    if name == "a":
        white, red, green = diffuse(0.73, 0.73, 0.73), diffuse(0.65, 0.05, 0.05), diffuse(0.12, 0.45, 0.15)
        scene |= {
            "sensor": camera([0, 0, 3.9], [0, 0, 0], 39),
            "floor": rectangle([0, -1, 0], [1, 0, 0], [0, 0, -1], white),
            "ceiling": rectangle([0, 1, 0], [1, 0, 0], [0, 0, 1], white),
            "back": rectangle([0, 0, -1], [1, 0, 0], [0, 1, 0], white),
            "left": rectangle([-1, 0, 0], [0, 0, -1], [0, 1, 0], red),
            "right": rectangle([1, 0, 0], [0, 0, 1], [0, 1, 0], green),
            "lamp": rectangle([0, 0.99, 0], [0.25, 0, 0], [0, 0, 0.25], diffuse(0, 0, 0), (17, 12, 4)),
            "tall": box([-0.3, -0.6, -0.3], [0.3, 0.6, 0.3], 18, [-0.35, -0.4, -0.3], white),
            "short": box([-0.3, -0.3, -0.3], [0.3, 0.3, 0.3], -17, [0.35, -0.7, 0.35], white),
        }
    elif name == "b":
        scene |= {
            "sensor": camera([0, 1.8, 6], [0, 0.7, 0], 38), "sky": sky(),
            "ground": rectangle([0, 0, 0], [20, 0, 0], [0, 0, -20], diffuse(0.5, 0.5, 0.5)),
            "gold": sphere([-1.6, 0.7, 0.3], 0.7, metal("gold", 0.05)),
            "aluminium": sphere([1.6, 0.7, 0.3], 0.7, metal("aluminium", 0.3)),
            "clay": sphere([0.9, 0.35, 1.6], 0.35, diffuse(0.8, 0.3, 0.2)),
            "statue": {"type": "ply", "filename": os.path.join(ROOT, "scenes/peer_b_statue.ply"), "bsdf": metal("copper", 0.15)},
        }
    elif name == "c":
        scene |= {
            "sensor": camera([0, 1.6, 5.2], [0, 0.75, 0], 38),
            "sky": {"type": "envmap", "filename": os.path.join(ROOT, "scenes/peer_c_sky.exr"), "to_world": T().rotate([0, 1, 0], 180)},
            "ground": rectangle([0, 0, 0], [20, 0, 0], [0, 0, -20], diffuse(0.5, 0.5, 0.5)),
            "glass": sphere([-0.8, 0.8, 0.3], 0.8, {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}),
            "gold": sphere([1, 0.6, 0], 0.6, metal("gold", 0.15)),
            "box": box([-0.45, 0, -0.35], [0.45, 1.5, 0.35], 25, [0.05, 0, -1.25], diffuse(0.2, 0.3, 0.7)),
            "lamp": rectangle([0, 3.5, 0], [0.5, 0, 0], [0, 0, 0.5], diffuse(0, 0, 0), (12, 11, 10)),
        }
    else:
        sys.exit(f"no scene {name}: a, b and c are written here")
    return mi.load_dict(scene)


def rgb_unbounded(mi, value):
    return {"type": "rgb", "value": [float(c) for c in value]}


def relmse_trimmed(image, reference):
    error = ((image - reference) ** 2 / (reference**2 + 0.01)).mean(axis=2).ravel()
    error.sort()
    return error[: int(np.ceil(len(error) * 0.999))].mean()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--scenes", default="abc")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--reference-spp", type=int, default=0, help="0: rates only")
    parser.add_argument("--save", help="folder for the images as .exr")
    args = parser.parse_args()
    import drjit as dr
    import mitsuba as mi

    mi.set_variant(args.variant)
    for name in args.scenes:
        scene = build(mi, name)

        def render(spp, seed):
            begun, begun_cpu = time.perf_counter(), time.process_time()
            image = mi.render(scene, spp=spp, seed=seed)
            dr.eval(image)
            dr.sync_thread()
            seconds, cpu = time.perf_counter() - begun, time.process_time() - begun_cpu
            return np.array(image, dtype=np.float64), seconds, cpu

        render(args.spp, 1)
        rounds = [render(args.spp, 2 + k)[1:] for k in range(args.rounds)]
        seconds = sorted(r[0] for r in rounds)
        cores = sorted(r[1] / r[0] for r in rounds)[len(rounds) // 2]
        per_core = args.spp * 0.065536 / sorted(r[1] for r in rounds)[len(rounds) // 2]
        rate = args.spp * 256 * 256 / seconds[len(seconds) // 2] * 1e-6
        line = f"{name} {args.variant}: {rate:.3f} Msamples/s [{args.spp * 0.065536 / seconds[-1]:.3f}, {args.spp * 0.065536 / seconds[0]:.3f}] with {cores:.2f} cores, {per_core:.3f} a core"
        if args.save:
            mi.util.write_bitmap(os.path.join(args.save, f"{name}_{args.variant}.exr"), mi.render(scene, spp=256, seed=99))
        if args.reference_spp:
            # In parts: one call holds all its samples in memory.
            part, count = 256, max(1, args.reference_spp // 256)
            reference = sum(render(part, 1000 + k)[0] for k in range(count)) / count
            error = np.mean([relmse_trimmed(render(args.spp, 50 + k)[0], reference) for k in range(3)])
            # The reference's own error adds in proportion to the samples.
            error /= 1 + args.spp / (part * count)
            samples = args.spp * error / 1e-2
            line += f", trimmed relMSE {error:.3e} at {args.spp} spp: 1e-2 at {samples:.1f} spp, {samples * 0.065536 / rate:.3f} s"
        print(line, flush=True)


if __name__ == "__main__":
    main()
