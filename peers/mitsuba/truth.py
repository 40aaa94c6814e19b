"""A result of `solve`, or a file of the same layout, as arrays over faces and texels."""

import json
from dataclasses import dataclass
from pathlib import Path

import mitsuba as mi
import numpy as np


@dataclass
class Truth:
    name: str
    texels: int  # a side
    faces: np.ndarray  # [face, 4, 3]: corners; a triangle repeats its third
    emission: np.ndarray  # [face, 3]
    reflectance: np.ndarray  # [face, 3]
    corners: np.ndarray  # [face, texel, 4, 3]
    area: np.ndarray  # [face, texel]
    reflected: np.ndarray  # [face, texel, 3]: B − E
    noise: float  # its own standard error, relative, the worst channel


def quad(corners, n):
    """Texel (i, j): i from corner 0 to corner 1, j from corner 0 to corner 3, row by row."""
    a, b, c, d = corners
    u, v = (x[..., None] for x in np.meshgrid(*2 * [np.linspace(0, 1, n + 1)]))
    p = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
    texels = np.stack([p[:-1, :-1], p[:-1, 1:], p[1:, 1:], p[1:, :-1]], axis=2)
    return texels.reshape(-1, 4, 3)


def triangle(corners, n):
    """Row j holds 2(n − j) − 1 triangles, upright and inverted alternating."""
    a, b, c = corners[:3]
    at = lambda i, j: a + (b - a) * i / n + (c - a) * j / n
    texels = []
    for j in range(n):
        for t in range(2 * (n - j) - 1):
            i = t // 2
            upright = [at(i, j), at(i + 1, j), at(i, j + 1)]
            inverted = [at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)]
            texels.append(inverted if t % 2 else upright)
    texels = np.array(texels)
    return np.concatenate([texels, texels[:, 2:]], axis=1)


def pixels(path, faces, prefix):
    """[face, texel, 3] of the channels with this prefix; none where the file lacks them."""
    image = mi.Bitmap(str(path))
    names = [field.name for field in image.struct_()]
    if prefix + "R" not in names:
        return None
    values = np.array(image)[:, :, [names.index(prefix + c) for c in "RGB"]].astype(float)
    rects = [face["rect"] for face in faces]
    return np.stack([values[y : y + h, x : x + w].reshape(-1, 3) for x, y, w, h in rects])


def relative_rms(difference, reflected, area):
    """√(ΣA(a−b)² / ΣA b²), the worst channel."""
    mean = lambda values: (area[..., None] * values**2).sum((0, 1))
    return float(np.sqrt(mean(difference) / mean(reflected)).max())


def read(folder):
    folder = Path(folder)
    faces = json.loads((folder / "result.json").read_text())["faces"]
    n = faces[0]["texels"][0]
    if any(face["texels"] != [n, n] for face in faces):
        raise SystemExit(f"error: {folder}: every face must have the same texels")
    column = lambda key: np.array([face[key] for face in faces], float)
    outlines = np.array([(face["corners"] + face["corners"][-1:])[:4] for face in faces], float)
    cut = lambda face, outline: (quad if face["kind"] == "quad" else triangle)(outline, n)
    corners = np.stack([cut(face, outline) for face, outline in zip(faces, outlines)])
    a, b, c, d = (corners[:, :, k] for k in range(4))
    area = np.linalg.norm(np.cross(c - a, d - b), axis=-1) / 2
    emission, lightmap = column("emission"), folder / "lightmap.exr"
    reflected = pixels(lightmap, faces, "") - emission[:, None]
    error = pixels(lightmap, faces, "error.")
    return Truth(
        name=folder.name,
        texels=n,
        faces=outlines,
        emission=emission,
        reflectance=column("reflectance"),
        corners=corners,
        area=area,
        reflected=reflected,
        noise=0.0 if error is None else relative_rms(error, reflected, area),
    )
