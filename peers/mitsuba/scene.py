"""A scene for Mitsuba, and a sensor whose pixels are texels: its rays start just in front of them,
so that the path integrator finds the texel first and samples the light there as it does elsewhere."""

import drjit as dr
import mitsuba as mi
import numpy as np

# Rays start this share of the scene's size in front of a face.
LIFT = 1e-5


def rgb(values):
    return {"type": "rgb", "value": list(map(float, values))}


def mesh(truth, chosen):
    """Faces of one material, one-sided: `diffuse` is black behind by itself."""
    corners = truth.faces[chosen].reshape(-1, 3)
    quads = np.arange(len(corners)).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    # A triangle's second half has no area.
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    triangles = triangles[np.cross(b - a, c - a).any(axis=1)]
    reflectance, emission = truth.reflectance[chosen[0]], truth.emission[chosen[0]]
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": rgb(reflectance)})
    if emission.any():
        light = {"type": "area", "radiance": rgb(emission / np.pi)}
        properties["emitter"] = mi.load_dict(light)
    shape = mi.Mesh("faces", len(corners), len(triangles), props=properties)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = mi.Float(corners.ravel())
    parameters["faces"] = mi.UInt32(triangles.ravel())
    parameters.update()
    return shape


def scene(truth):
    """One mesh for each material: fewer are faster."""
    groups = {}
    for k, key in enumerate(zip(map(tuple, truth.reflectance), map(tuple, truth.emission))):
        groups.setdefault(key, []).append(k)
    shapes = {f"material{k}": mesh(truth, faces) for k, faces in enumerate(groups.values())}
    return mi.load_dict({"type": "scene", **shapes})


class Texels(mi.Sensor):
    """Pixel (i, j) of the film is texel j·N + i of all texels, N being the film's width."""

    truth = None

    def __init__(self, properties):
        super().__init__(properties)
        flat = self.truth.corners.reshape(-1, 4, 3)
        self.corners = [mi.Float(flat[:, k].ravel()) for k in range(4)]
        self.triangular = mi.Bool((flat[:, 2] == flat[:, 3]).all(axis=1))
        self.lift = LIFT * float(np.ptp(flat.reshape(-1, 3), axis=0).max())

    def sample_ray_differential(self, time, sample1, sample2, sample3, active=True):
        ray, weight = self.sample_ray(time, sample1, sample2, sample3, active)
        return mi.RayDifferential3f(ray), weight

    def sample_ray(self, time, sample1, sample2, sample3, active=True):
        width, height = self.film().size()
        x, y = sample2.x * width, sample2.y * height
        i, j = dr.minimum(mi.UInt32(x), width - 1), dr.minimum(mi.UInt32(y), height - 1)
        texel = j * width + i
        a, b, c, d = (dr.gather(mi.Point3f, corners, texel) for corners in self.corners)
        u, v = x - i, y - j
        quad = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
        root = dr.sqrt(u)
        triangle = (1 - root) * a + root * (1 - v) * b + root * v * c
        point = dr.select(dr.gather(mi.Bool, self.triangular, texel), triangle, quad)
        normal = dr.normalize(dr.cross(c - a, d - b))
        return mi.Ray3f(point + self.lift * normal, -normal), mi.Color3f(1)


def sensor(truth, sampler, samples):
    Texels.truth = truth
    mi.register_sensor("texels", Texels)
    film = {
        "type": "hdrfilm",
        "width": truth.texels,
        "height": truth.texels * len(truth.faces),
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }
    drawn = {"type": sampler, "sample_count": samples}
    return mi.load_dict({"type": "texels", "film": film, "sampler": drawn})
