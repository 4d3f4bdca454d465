# SPDX-License-Identifier: Apache-2.0
"""checks.py SSL_VISIONLAB BUILD EXAMPLES SETTINGS FOLDER: runs the example stages of the folder BUILD on simulated
frames, and says whether they find what is there. SETTINGS: demo.json. FOLDER keeps what was made."""
import ctypes
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import numpy as np

LAB, BUILD, EXAMPLES, DEMO, FOLDER = [pathlib.Path(word).resolve() for word in sys.argv[1:]]
WIDTH, HEIGHT = 1560, 1160  # twice the demo's camera
STACK = ["segment", "detect_robots", "detect_balls"]
failures = []


def check(what, holds, found=""):
    print(f"{'ok  ' if holds else 'FAIL'}  {what}{f': {found}' if found else ''}", flush=True)
    if not holds:
        failures.append(what)


# ---- settings, frames, detections


def settings(name, added, source=None, scale=2, **camera):
    """A settings file with one camera of the demo that has these stages behind its detectors."""
    config = json.loads(DEMO.read_text())
    one = config["cameras"][0]
    config["cameras"] = [one]
    for key in ("focal_length", "principal_point_x", "principal_point_y", "pixel_image_width", "pixel_image_height"):
        one["calibration"][key] *= scale
    one["source"] |= {"width": 780 * scale, "height": 580 * scale, "pixel_format": "rgb24"} | (source or {})
    one["stack"] = STACK + added + ["publish"]
    one |= camera
    file = FOLDER / f"{name}.json"
    file.write_text(json.dumps(config, indent=1))
    return file


def lab(*words, **environment):
    done = subprocess.run([LAB, *map(str, words)], capture_output=True, text=True, env={**os.environ, **environment})
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, done.args))}: {done.stdout}{done.stderr}")
    return done


def simulate(file, count, name, start=0):
    """Frames as an array of (count, height, width, 3), their truth, and the folder with both."""
    folder = FOLDER / name
    lab(
        "simulate",
        "--settings",
        file,
        "--frames",
        count,
        "--start",
        start,
        "--stages",
        BUILD,
        "--raw",
        "--output",
        folder,
    )
    index = json.loads((folder / "frames.json").read_text())
    frames = [
        np.fromfile(folder / one["file"], np.uint8).reshape(index["height"], index["width"], 3)
        for one in index["frames"]
    ]
    return np.array(frames), [json.loads(line) for line in (folder / "truth.jsonl").open()], folder


def write(folder, frames):
    """Frames in place of those that are there."""
    for i, frame in enumerate(frames):
        frame.tofile(folder / f"frame_{i:06}.raw")


def process_words(file, folder, size, pixel_format="rgb24"):
    size = f"{size[0]}x{size[1]}"
    words = ["process", "--settings", file, "--input", folder, "--stages", BUILD]
    return words + ["--pixel-format", pixel_format, "--size", size]


def process(file, folder, size=(WIDTH, HEIGHT), pixel_format="rgb24", **environment):
    """What was found in each frame, and what stages said in the end."""
    done = lab(*process_words(file, folder, size, pixel_format), **environment)
    return [json.loads(line) for line in done.stdout.splitlines()], done.stderr


def in_format(frame, pixel_format):
    """An RGB frame as such a camera has it."""
    r, g, b = np.moveaxis(frame.astype(np.float64), 2, 0)
    luma = np.clip(0.299 * r + 0.587 * g + 0.114 * b + 0.5, 0, 255)
    if pixel_format == "rgb24":
        return frame
    if pixel_format == "bgr24":
        return frame[:, :, ::-1].copy()
    if pixel_format == "mono8":
        return luma.astype(np.uint8)
    if pixel_format in ("uyvy", "yuyv"):
        u, v = 128 + (b - luma) / 1.772, 128 + (r - luma) / 1.402
        pair = lambda plane: (plane[:, ::2] + plane[:, 1::2]) / 2
        chroma = np.stack([pair(u), pair(v)], 2).reshape(luma.shape)
        return np.clip(np.stack([chroma, luma] if pixel_format == "uyvy" else [luma, chroma], 2), 0, 255).astype(
            np.uint8
        )
    quad = {"rg": (0, 1, 1, 2), "gr": (1, 0, 2, 1), "gb": (1, 2, 0, 1), "bg": (2, 1, 1, 0)}[pixel_format[6:8]]
    out = np.empty(luma.shape, np.uint8)
    for i, channel in enumerate(quad):
        out[i // 2 :: 2, i % 2 :: 2] = frame[i // 2 :: 2, i % 2 :: 2, channel]
    return out


# ---- drawing, with a second implementation of the camera model, written from its description


class Camera:
    def __init__(self, file):
        c = json.loads(file.read_text())["cameras"][0]["calibration"]
        x, y, z, w = np.array([c["q0"], c["q1"], c["q2"], c["q3"]]) / np.linalg.norm(
            [c["q0"], c["q1"], c["q2"], c["q3"]]
        )
        self.turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        )
        self.shift = np.array([c["tx"], c["ty"], c["tz"]])
        self.middle, self.focal, self.distortion = (
            np.array([c["principal_point_x"], c["principal_point_y"]]),
            c["focal_length"],
            c["distortion"],
        )

    def project(self, place):
        p = self.turn @ np.asarray(place, float) + self.shift
        ideal = p[:2] / p[2]
        lens = ideal
        for _ in range(20):
            lens = ideal / (1 + self.distortion * (lens @ lens))
        return self.focal * lens + self.middle

    def unproject(self, pixels, height):
        lens = (pixels - self.middle) / self.focal
        ideal = lens * (1 + self.distortion * (lens**2).sum(-1, keepdims=True))
        rays = np.concatenate([ideal, np.ones(ideal.shape[:-1] + (1,))], -1) @ self.turn
        position = -self.turn.T @ self.shift
        return position[:2] + rays[..., :2] * ((height - position[2]) / rays[..., 2:])


def draw(frame, camera, place, height, angle, reach, paint):
    """Draws on the plane z = height what paint(x, y) says, in mm from the place and along `angle`: colours, and where
    they cover what is there."""
    at = np.rint(camera.project([*place, height])).astype(int)
    edge = camera.project([place[0] + reach, place[1], height])
    px = int(np.linalg.norm(edge - camera.project([*place, height])) * 1.2) + 2
    left, top = np.maximum(at - px, 0)
    right, bottom = np.minimum(at + px + 1, [frame.shape[1], frame.shape[0]])
    if left >= right or top >= bottom:
        return
    fine = 4  # samples along each side of a pixel
    x, y = np.meshgrid(
        left + (np.arange((right - left) * fine) + 0.5) / fine - 0.5,
        top + (np.arange((bottom - top) * fine) + 0.5) / fine - 0.5,
    )
    off = camera.unproject(np.stack([x, y], -1), height) - place
    color, cover = paint(
        off[..., 0] * np.cos(angle) + off[..., 1] * np.sin(angle),
        off[..., 1] * np.cos(angle) - off[..., 0] * np.sin(angle),
    )
    mean = lambda a: a.reshape(bottom - top, fine, right - left, fine, -1).mean((1, 3))
    cover = cover[..., None].astype(float)
    part = frame[top:bottom, left:right]
    part[:] = np.clip(part * (1 - mean(cover)) + mean(color * cover) + 0.5, 0, 255)


class GreyImage(ctypes.Structure):
    _fields_ = [
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("stride", ctypes.c_int32),
        ("bytes", ctypes.POINTER(ctypes.c_uint8)),
    ]


def tag_cells(family, number):
    """A tag's cells, by the library's own generator; white is 1. Its upper row first."""
    library = ctypes.CDLL("libapriltag.so.3")
    create = getattr(library, f"{family}_create")
    create.restype = ctypes.c_void_p
    library.apriltag_to_image.restype = ctypes.POINTER(GreyImage)
    image = library.apriltag_to_image(ctypes.c_void_p(create()), number).contents
    return np.array(
        [[image.bytes[y * image.stride + x] > 0 for x in range(image.width)] for y in range(image.height)], float
    )


def draw_tag(frame, camera, number, place, height, angle, side, family="tag36h11"):
    """`side`: of its black square. Its upper edge looks along `angle`."""
    cells = tag_cells(family, number)
    cell_mm = side / (len(cells) - 2)

    def paint(front, left):
        row, column = np.floor(len(cells) / 2 - front / cell_mm).astype(int), np.floor(
            len(cells) / 2 - left / cell_mm
        ).astype(int)
        inside = (row >= 0) & (row < len(cells)) & (column >= 0) & (column < len(cells))
        return 30 + 190 * cells[row % len(cells), column % len(cells)][..., None] * np.ones(3), inside

    draw(frame, camera, place, height, angle, side, paint)


# ---- the examples


def hello():
    # The stage sees a smaller field than the simulator, so that balls lie outside it.
    scattered = {"balls": 8, "robots_yellow": 0, "robots_blue": 0, "placement": "scatter"}
    drawn = settings("hello_drawn", [], scattered)
    _, truth, folder = simulate(drawn, 10, "hello")
    looks = settings(
        "hello",
        ["hello"],
        scattered,
        stages={"hello": {"margin_mm": 0}, "detect_balls": {"max_outside_mm": 10000}},
        mask={"beyond_boundary": None},
    )
    config = json.loads(looks.read_text())
    config["field"] = {"field_length": 4000, "field_width": 3000}
    looks.write_text(json.dumps(config))
    found, notes = process(looks, folder)
    expected = [
        sum(abs(b["x"]) <= 2000 and abs(b["y"]) <= 1500 and b["visible"] for b in one["balls"]) for one in truth
    ]
    check(
        "hello: balls inside the lines stay", [len(one["balls"]) for one in found] == expected, f"{sum(expected)} balls"
    )
    removed = sum(b["visible"] for one in truth for b in one["balls"]) - sum(expected)
    check(
        "hello: it says how many it removed", f"hello: {removed} balls removed" in notes, notes.strip().splitlines()[-1]
    )


def off(one, other):
    return abs((one - other + np.pi) % (2 * np.pi) - np.pi)


def april_tags():
    chance = np.random.default_rng(3)
    stages = {"april_tags": {"team": "yellow", "robot_tags": [0, 11]}}
    file = settings(
        "tags",
        ["april_tags", "tag_corners"],
        {"robots_yellow": 1, "robots_blue": 2, "first_yellow_id": 5, "speed": 0},
        stages=stages,
    )
    camera, size = Camera(file), (WIDTH, HEIGHT)
    frames, truth, folder = simulate(file, 6, "tags")
    drawn = []
    for frame, true in zip(frames, truth):
        taken = [(r["x"], r["y"]) for r in true["robots"]]
        here = {}
        for number in chance.permutation(12)[:6]:
            while True:
                place = chance.uniform([-4000, -2500], [-500, 2500])
                if all(np.hypot(*(place - other)) > 450 for other in taken):
                    break
            taken.append(tuple(place))
            here[int(number)] = (*place, chance.uniform(-np.pi, np.pi))
            draw_tag(frame, camera, int(number), place, 140, here[int(number)][2], 100)
        draw_tag(frame, camera, 101, (-4500, 3000), 0, 0.3, 160)
        draw_tag(frame, camera, 102, (-4500 + 12, -3000 - 5), 0, -2, 160)
        drawn.append(here)
    write(folder, frames)
    found, notes = process(file, folder)

    def errors(found):
        places, angles, missed, others = [], [], 0, 0
        for one, here in zip(found, drawn):
            yellow = {r["id"]: r for r in one["robots"] if r["team"] == "yellow" and r["id"] != 5}
            missed += len(here.keys() - yellow.keys() - {5})
            others += len(yellow.keys() - here.keys())
            for number in here.keys() & yellow.keys():
                x, y, angle = here[number]
                places.append(np.hypot(yellow[number]["x"] - x, yellow[number]["y"] - y))
                angles.append(np.degrees(off(yellow[number]["orientation"], angle)))
        return np.array(places), np.array(angles), missed, others

    def told(found):
        places, angles, missed, others = errors(found)
        spread = lambda errors, unit: f"{errors.mean():.2f} {unit} (at most {errors.max():.2f})"
        counts = f"{len(places)} tags, {missed} missed, {others} wrong"
        return f"{counts}, {spread(places, 'mm')}, {spread(angles, 'degrees')}"

    places, angles, missed, others = errors(found)
    check(
        "april_tags: robots by their tags",
        missed == 0 and others == 0 and places.max() < 1 and angles.max() < 2,
        told(found),
    )
    fives = [[r for r in one["robots"] if r["team"] == "yellow" and r["id"] == 5] for one in found]
    true = next(r for r in truth[0]["robots"] if r["team"] == "yellow")
    check(
        "april_tags: a robot that its pattern shows stays where it is",
        any(5 in here for here in drawn)
        and all(len(five) == 1 and np.hypot(five[0]["x"] - true["x"], five[0]["y"] - true["y"]) < 10 for five in fives),
    )
    corners = {
        int(n): np.array([float(x), float(y)])
        for n, x, y in re.findall(r"tag (\d+) is off by \(([-+.\d]+), ([-+.\d]+)\) mm", notes)
    }
    check(
        "tag_corners: how far tags lie off the corners",
        corners.keys() == {101, 102} and np.abs(corners[101]).max() < 1 and np.abs(corners[102] - [12, -5]).max() < 1,
        notes.strip().splitlines()[-1],
    )
    for what, changed, most_missed in (
        ("edges in a smaller image", {"decimate": 2}, 8),
        ("only clear bits", {"min_margin": 255}, 34),
    ):
        coarse = settings("tags_changed", ["april_tags"], stages={"april_tags": stages["april_tags"] | changed})
        _, _, missed, others = errors(found := process(coarse, folder)[0])
        check(
            f"april_tags: {what}",
            others == 0 and (missed <= most_missed if most_missed < 34 else missed == 34),
            f"{missed} missed",
        )
    for pixel_format in ("uyvy", "yuyv", "bgr24", "mono8", "bayer_rg8", "bayer_gr8", "bayer_gb8", "bayer_bg8"):
        write(folder, [in_format(frame, pixel_format) for frame in frames])
        found, _ = process(file, folder, pixel_format=pixel_format)
        places, angles, missed, others = errors(found)
        check(
            f"april_tags: {pixel_format}",
            missed <= 2 and others == 0 and places.max() < 1 and angles.max() < 2,
            told(found),
        )


def other_tags():
    # Another family, blue robots, at the resolution of the demo's camera; tag 5 is on robot 2.
    stages = {"april_tags": {"family": "tag16h5", "team": "blue", "robot_tags": [3, 8]}}
    file = settings("tag16h5", ["april_tags"], {"robots_yellow": 0, "robots_blue": 0}, scale=1, stages=stages)
    frames, _, folder = simulate(file, 1, "tag16h5")
    draw_tag(frames[0], Camera(file), 5, (-2000, 700), 140, 1, 150, "tag16h5")
    draw_tag(frames[0], Camera(file), 9, (-3000, 700), 140, 1, 150, "tag16h5")
    write(folder, frames)
    robots = process(file, folder, (780, 580))[0][0]["robots"]
    check(
        "april_tags: tag16h5 on a blue robot",
        [(r["team"], r["id"]) for r in robots] == [("blue", 2)]
        and np.hypot(robots[0]["x"] + 2000, robots[0]["y"] - 700) < 2,
        robots,
    )


SCATTERED = {
    "robots_yellow": 4,
    "robots_blue": 4,
    "balls": 4,
    "placement": "scatter",
    "noise_sigma": 3,
    "ball_gloss": 1,
}
DOUBTFUL = {"detect_balls": {"min_confidence": 0.02}}  # for stages that judge candidates themselves


def draw_orange_things(frames, truth, camera, chance):
    """Flat things of about a ball's colour and size, apart from all else: tape, corners of paper, peel, cable."""
    for frame, true in zip(frames, truth):
        taken = [(one["x"], one["y"]) for one in true["robots"] + true["balls"]]
        for _ in range(12):
            place = chance.uniform([-4300, -2800], [-200, 2800])
            kind, (a, b) = chance.integers(4), chance.uniform(25, 60, 2)
            color = np.clip(np.array([225, 103, 31]) * chance.uniform(0.75, 1.05) + chance.normal(0, 6, 3), 0, 255)
            if any(np.hypot(*(place - other)) < 250 for other in taken):
                continue
            taken.append(tuple(place))

            def paint(x, y):
                cover = [
                    (abs(x) < a / 2) & (abs(y) < b / 2),
                    (x > -a / 2) & (abs(y) < (a / 2 - x) / 2),
                    (np.hypot(x, y) < a / 2) & (np.hypot(x, y - a / 4) > a / 3),
                    (abs(x) < a) & (abs(y) < 9),
                ][kind]
                return color + np.zeros(x.shape + (1,)), cover

            draw(frame, camera, place, 0, chance.uniform(-np.pi, np.pi), max(a, 45), paint)


def record_patches():
    """Gives the patches for learned_balls: their folder, and the truth of their frames."""
    file = settings("record", ["record_patches"], SCATTERED, scale=1, stages=DOUBTFUL)
    frames, truth, folder = simulate(file, 150, "training", start=1000)
    draw_orange_things(frames, truth, Camera(file), np.random.default_rng(2))
    write(folder, frames)
    patches = FOLDER / "patches"
    patches.mkdir()
    found, notes = process(file, folder, (780, 580), SSLV_PATCHES=str(patches))
    balls = [(i, ball) for i, one in enumerate(found) for ball in one["balls"]]
    dropped = int(re.search(r"record_patches: (\d+) dropped", notes)[1])
    files = sorted(patches.iterdir())
    check(
        "record_patches: a patch of each ball",
        len(files) == len(balls) > 300 and dropped == 0,
        f"{len(files)} patches, {dropped} dropped",
    )

    pixels = {(i, f"{ball['x']:.1f}_{ball['y']:.1f}"): (ball["pixel_x"], ball["pixel_y"]) for i, ball in balls}
    differences = []
    for patch in files:
        _, camera, frame, x, y, _ = patch.stem.split("_")
        at = np.rint(np.clip(pixels[int(frame), f"{x}_{y}"], 1, [778, 578])).astype(int)
        middle = np.frombuffer(patch.read_bytes()[-12 * 12 * 3 :], np.uint8).reshape(12, 12, 3)[5:7, 5:7].mean((0, 1))
        near = frames[int(frame)][at[1] - 1 : at[1] + 2, at[0] - 1 : at[0] + 2].mean((0, 1))
        differences.append(np.abs(middle - near).mean())
    check(
        "record_patches: their middles show what is there",
        np.median(differences) < 15,
        f"median difference {np.median(differences):.1f} grey levels",
    )

    # A disk that hangs: the first file is a pipe that nobody reads. Processing continues; dropped patches are counted.
    slots = 1024
    things = [
        (i, kind, thing) for i, one in enumerate(found) for kind in ("ball", "robot") for thing in one[f"{kind}s"]
    ]
    hanging = FOLDER / "hanging"
    hanging.mkdir()
    i, kind, thing = things[0]
    first = hanging / f"{kind}_0_{i:06}_{thing['x']:.1f}_{thing['y']:.1f}_{thing['confidence']:.3f}.ppm"
    os.mkfifo(first)
    all_of_them = DOUBTFUL | {"record_patches": {"robots": True}}
    file = settings("record_all", ["record_patches"], SCATTERED, scale=1, stages=all_of_them)
    words = process_words(file, folder, (780, 580)) + ["--output", FOLDER / "hanging.jsonl"]
    environment = {**os.environ, "SSLV_PATCHES": str(hanging)}
    with subprocess.Popen([LAB, *words], stderr=subprocess.PIPE, text=True, env=environment) as running:
        said = (line.split() for line in running.stderr)
        dropped = next((int(words[1]) for words in said if words[0] == "record_patches:"), None)
        if dropped is not None:
            first.read_bytes()  # the disk works again
    frames_done = len((FOLDER / "hanging.jsonl").read_text().splitlines())
    check(
        "record_patches: a disk that hangs costs patches, no frames",
        dropped == len(things) - slots > 0 and frames_done == len(found) and len(list(hanging.iterdir())) == slots,
        f"{dropped} of {len(things)} dropped",
    )
    found, notes = process(file, folder, (780, 580))
    check("record_patches: without a folder it says so", "SSLV_PATCHES" in notes and len(found) == len(frames))
    return patches, folder / "truth.jsonl"


def score(found, truth):
    for name, lines in (("found", found), ("truth", truth)):
        (FOLDER / f"{name}.jsonl").write_text("\n".join(map(json.dumps, lines)))
    return json.loads(
        lab("score", "--json", "--detections", FOLDER / "found.jsonl", "--truth", FOLDER / "truth.jsonl").stdout
    )["balls"]


def learned_balls(patches, truth_of_patches):
    file = settings("balls", [], SCATTERED, scale=1)
    frames, truth, folder = simulate(file, 60, "balls")
    draw_orange_things(frames, truth, Camera(file), np.random.default_rng(1))
    write(folder, frames)
    before = score(process(file, folder, (780, 580))[0], truth)
    _, notes = process(file, folder, (780, 580))
    check(
        "learned_balls: without a network the library is left out, with a reason",
        "there is no" in notes and "balls.onnx; it is left out" in notes,
    )
    trained = subprocess.run(
        [sys.executable, EXAMPLES / "learned_balls/train.py", patches, truth_of_patches, BUILD / "balls.onnx"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout.strip()
    found, _ = process(settings("learned", ["learned_balls"], SCATTERED, scale=1, stages=DOUBTFUL), folder, (780, 580))
    after = score(found, truth)
    took = np.median([one["timing_us"]["learned_balls"] for one in found])
    tell = lambda one: f"{one['found']} of {one['expected']} found, {one['invented']} invented"
    check(
        "learned_balls: better than without it",
        after["found"] > before["found"] and after["invented"] < before["invented"] / 4,
        f"{tell(before)}; with it {tell(after)}; {took:.0f} us; {trained}",
    )
    by_confidence = [[ball["confidence"] for ball in one["balls"]] for one in found]
    check("learned_balls: sorted by confidence", all(one == sorted(one, reverse=True) for one in by_confidence))


def odd_frames():
    """All stages together on frames that show nothing."""
    stages = ["april_tags", "tag_corners", "record_patches", "learned_balls", "hello"]
    for name, size, pixel_format, calibration in (
        ("two pixels", (2, 2), "rgb24", True),
        ("no colours", (64, 48), "mono8", True),
        ("not calibrated", (64, 48), "bayer_gb8", False),
    ):
        file = settings("odd", stages, scale=1, **({} if calibration else {"calibration": None}))
        folder = FOLDER / f"odd_{pixel_format}"
        folder.mkdir()
        np.zeros(size[0] * size[1] * (3 if pixel_format == "rgb24" else 1), np.uint8).tofile(
            folder / "frame_000000.raw"
        )
        found, _ = process(file, folder, size, pixel_format, SSLV_PATCHES=str(FOLDER))
        check(f"all: {name}", len(found) == 1 and found[0]["robots"] == found[0]["balls"] == [])


def main():
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    (BUILD / "balls.onnx").unlink(missing_ok=True)
    hello()
    april_tags()
    other_tags()
    patches, truth = record_patches()
    learned_balls(patches, truth)
    odd_frames()
    sys.exit(f"{len(failures)} failed" if failures else 0)


main()
