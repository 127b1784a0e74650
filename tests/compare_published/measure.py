"""FLIP, SSIM and PSNR of picture pairs by their published implementations.

Reads a JSON object a line on stdin: {"a": FILE, "b": FILE, "width": W, "height":
H, "map": FILE}, A and B being 16-bit little-endian RGB without a header. Writes
FLIP's error map, 32-bit floats, and prints an object a line: {"flip": …, "ssim": …,
"psnr": …, …}.
"""

import json
import sys

import flip_evaluator
import numpy as np
from skimage.metrics import peak_signal_noise_ratio, structural_similarity


def picture(path, width, height):
    return np.fromfile(path, "<u2").reshape(height, width, 3) / 65535.0


for line in sys.stdin:
    pair = json.loads(line)
    a, b = (picture(pair[side], pair["width"], pair["height"]) for side in "ab")
    # NVIDIA's defaults: LDR-FLIP, sRGB, 67 pixels per degree.
    errors, quoted, parameters = flip_evaluator.evaluate(
        a.astype(np.float32), b.astype(np.float32), "LDR", applyMagma=False
    )
    errors.astype("<f4").tofile(pair["map"])
    ssim = structural_similarity(
        a,
        b,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        data_range=1.0,
        channel_axis=2,
    )
    psnr = peak_signal_noise_ratio(a, b, data_range=1.0)
    print(
        json.dumps(
            {
                # The evaluator sums its map in single precision, which costs the
                # fourth digit: the mean of the same map in double precision.
                "flip": float(errors.mean(dtype=np.float64)),
                "quoted_flip": float(quoted),
                "ssim": float(ssim),
                "psnr": float(psnr),
                "ppd": float(parameters["ppd"]),
            }
        )
    )
