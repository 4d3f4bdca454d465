#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""train.py PATCHES TRUTH OUT: trains the network of learned_balls.

PATCHES: the folder that record_patches wrote; TRUTH: the truth.jsonl of the same frames, from `ssl-visionlab
simulate` or `annotate`; OUT: balls.onnx. Needs python3-numpy."""
import json
import pathlib
import struct
import sys

import numpy as np

MAX_OFF_MM = 30  # a patch farther than this from every true ball shows something else
HIDDEN, ROUNDS, RATE = 12, 600, 0.002


def read_patches(folder, truth):
    """Returns the patches as rows of levels 0 .. 1, in the order that learned_balls uses, and labels (1: a ball)."""
    frames = [json.loads(line)["balls"] for line in open(truth)]
    patches, labels = [], []
    for file in sorted(folder.glob("ball_*.ppm")):
        _, _, frame, x, y, _ = file.stem.split("_")
        patches.append(np.frombuffer(file.read_bytes().split(b"\n255\n", 1)[1], np.uint8) / 255)
        labels.append(
            any(np.hypot(ball["x"] - float(x), ball["y"] - float(y)) < MAX_OFF_MM for ball in frames[int(frame)])
        )
    return np.array(patches, np.float32), np.array(labels, np.float32)


def turned(patches, labels):
    """Rotates and mirrors each patch: eight examples instead of one."""
    side = int(round((patches.shape[1] / 3) ** 0.5))
    images = patches.reshape(-1, side, side, 3)
    all_ways = [np.rot90(way, turns, (1, 2)) for way in (images, images[:, :, ::-1]) for turns in range(4)]
    return np.concatenate(all_ways).reshape(-1, patches.shape[1]), np.tile(labels, 8)


def run(weights, patches):
    """Returns the hidden layer, and for each patch the confidence that it shows a ball."""
    w1, b1, w2, b2 = weights
    hidden = np.maximum(patches @ w1 + b1, 0)
    return hidden, 1 / (1 + np.exp(-(hidden @ w2 + b2)[:, 0]))


def train(patches, labels):
    """Trains two layers with Adam (Kingma and Ba, 2015). Balls and others weigh the same in the cross entropy."""
    chance = np.random.default_rng(1)
    size = patches.shape[1]
    weights = [
        chance.normal(0, size**-0.5, (size, HIDDEN)),
        np.zeros(HIDDEN),
        chance.normal(0, HIDDEN**-0.5, (HIDDEN, 1)),
        np.zeros(1),
    ]
    means, squares = [0 * w for w in weights], [0 * w for w in weights]
    weight_of = np.where(labels > 0, 0.5 / max(labels.mean(), 1e-9), 0.5 / max(1 - labels.mean(), 1e-9))
    for step in range(1, ROUNDS + 1):
        chosen = chance.integers(0, len(patches), 512)
        x = patches[chosen]
        hidden, found = run(weights, x)
        error = ((found - labels[chosen]) * weight_of[chosen] / len(x))[:, None]
        back = error @ weights[2].T * (hidden > 0)
        for i, slope in enumerate((x.T @ back, back.sum(0), hidden.T @ error, error.sum(0))):
            means[i] = 0.9 * means[i] + 0.1 * slope
            squares[i] = 0.999 * squares[i] + 0.001 * slope**2
            weights[i] -= RATE * means[i] / (1 - 0.9**step) / (np.sqrt(squares[i] / (1 - 0.999**step)) + 1e-8)
    return weights


def field(number, value):
    """Encodes a field of a protobuf message: an integer, a text, or bytes (also of a message)."""

    def varint(n):
        return bytes([n]) if n < 128 else bytes([n & 127 | 128]) + varint(n >> 7)

    if isinstance(value, int):
        return varint(number << 3) + varint(value)
    value = value.encode() if isinstance(value, str) else value
    return varint(number << 3 | 2) + varint(len(value)) + value


def onnx(weights):
    """Encodes the network as an ONNX file (onnx.proto3): Gemm, Relu, Gemm, Sigmoid."""

    def tensor(name, values):
        return field(
            5,
            b"".join(field(1, n) for n in values.shape)
            + field(2, 1)
            + field(8, name)
            + field(9, values.astype("<f4").tobytes()),
        )

    def node(kind, inputs, output, attribute=b""):
        return field(
            1,
            b"".join(field(1, name) for name in inputs)
            + field(2, output)
            + field(3, output)
            + field(4, kind)
            + attribute,
        )

    def value(number, name, shape):
        dimensions = b"".join(field(1, field(1, n)) for n in shape)
        return field(number, field(1, name) + field(2, field(1, field(1, 1) + field(2, dimensions))))

    turned = field(
        5, field(1, "transB") + field(3, 1) + field(20, 2)
    )  # a row of weights for each output, as in PyTorch
    graph = (
        node("Gemm", ["patch", "w1", "b1"], "sums", turned)
        + node("Relu", ["sums"], "hidden")
        + node("Gemm", ["hidden", "w2", "b2"], "score", turned)
        + node("Sigmoid", ["score"], "ball")
        + field(2, "balls")
        + b"".join(tensor(name, w.T) for name, w in zip(("w1", "b1", "w2", "b2"), weights))
        + value(11, "patch", (1, weights[0].shape[0]))
        + value(12, "ball", (1, 1))
    )
    return field(1, 7) + field(7, graph) + field(8, field(1, "") + field(2, 11))


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    patches, labels = read_patches(pathlib.Path(sys.argv[1]), sys.argv[2])
    if not 0 < labels.sum() < len(labels):
        sys.exit(f"{len(labels)} patches, {int(labels.sum())} of balls: both balls and other objects are needed")
    # Every fifth patch is not used for training, but to measure the network on unseen data.
    is_apart = np.arange(len(labels)) % 5 == 0
    weights = train(*turned(patches[~is_apart], labels[~is_apart]))
    right = (run(weights, patches[is_apart])[1] > 0.5) == (labels[is_apart] > 0)
    print(f"{len(labels)} patches, {int(labels.sum())} of balls;", end=" ")
    print(f"of {len(right)} held out, {right.mean():.1%} are classified correctly")
    pathlib.Path(sys.argv[3]).write_bytes(onnx(weights))


main()
