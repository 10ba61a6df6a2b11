#!/usr/bin/env bash
# Rates and samples-to-quality of scenes/peer_{a,b,c,d}.toml on the default device; docs/peers.md has what it printed.
#
#     STERADIAN_ASSETS=../shared/assets benches/peers.sh [SCENES, such as abcd] [SPP OF THE REFERENCE]
#
# STERADIAN_PROFILE=dev times the optimised profile with debug assertions instead of `release`. Images go to target/peers.
# Trimmed relMSE of 3 seeds at 16, 64 and 256 spp against one reference of another seed; the reference's own share of the error,
# (spp of the image)/(spp of the reference) of it where both fall like 1/N, is taken off. Needs python3 for the arithmetic.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
scenes=${1:-abcd}
reference_spp=${2:-4096}
out=target/peers
mkdir -p "$out"
[[ -e scenes/peer_b_statue.ply && -e scenes/peer_c_sky.exr ]] || ./x generate peers -o scenes
export STERADIAN_ASSETS=${STERADIAN_ASSETS:-../shared/assets}
for scene in $(grep -o . <<<"$scenes"); do
    file=scenes/peer_$scene.toml
    rate=$(./x bench --filter samples "$file" --json)
    reference=$out/${scene}_reference_$reference_spp.exr
    [[ -e $reference ]] || ./x render "$file" --spp "$reference_spp" --seed 777 -o "$reference" 2>/dev/null >&2
    errors=
    for spp in 16 64 256; do
        for seed in 1 2 3; do
            ./x render "$file" --spp $spp --seed $seed -o "$out/image.exr" 2>/dev/null >&2
            errors+="$spp $(./x compare "$out/image.exr" "$reference" --json)"$'\n'
        done
    done
    RATE=$rate ERRORS=$errors SCENE=$scene REFERENCE=$reference_spp python3 - <<'PY'
import json, math, os
rate, reference = json.loads(os.environ["RATE"]), float(os.environ["REFERENCE"])
means = {}
for line in os.environ["ERRORS"].splitlines():
    spp, measures = line.split(" ", 1)
    means.setdefault(int(spp), []).append(json.loads(measures)["relmse_trimmed"])
means = {spp: sum(v) / len(v) / (1 + spp / reference) for spp, v in means.items()}
points = sorted(means.items())
# Between the two samplings about the target, else from the nearest end, as a power of the samples.
pairs = [p for p in zip(points, points[1:]) if p[0][1] >= 1e-2 >= p[1][1]] or ([(points[0], points[1])] if points[0][1] < 1e-2 else [(points[-2], points[-1])])
(n0, e0), (n1, e1) = pairs[0]
slope = math.log(e1 / e0) / math.log(n1 / n0)
spp = n0 * (1e-2 / e0) ** (1 / slope)
seconds = spp * rate["width"] * rate["height"] / (rate["throughput_MSps"] * 1e6)
print(f"{os.environ['SCENE']}: {rate['throughput_MSps']:.3f} Msamples/s {rate['throughput_MSps_range']}, {rate['throughput_Mrays_ps']:.2f} Mrays/s with {rate['cores']:.2f} cores, {rate['throughput_MSps'] / rate['cores']:.3f} Msamples/s a core; trimmed relMSE "
      + ", ".join(f"{e:.3e} at {n} spp" for n, e in points) + f"; 1e-2 at {spp:.1f} spp (slope {slope:.2f}), {seconds:.3f} s")
PY
done
