"""FLIP, SSIM and PSNR of picture pairs by their published implementations.

Reads a JSON object a line on stdin: {"a": FILE, "b": FILE, "width": W, "height":
H}, the files being 16-bit little-endian RGB without a header. Prints an object a
line: {"flip": …, "ssim": …, "psnr": …}.
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
    _, flip, parameters = flip_evaluator.evaluate(
        a.astype(np.float32), b.astype(np.float32), "LDR", applyMagma=False
    )
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
                "flip": float(flip),
                "ssim": float(ssim),
                "psnr": float(psnr),
                "ppd": float(parameters["ppd"]),
            }
        )
    )
