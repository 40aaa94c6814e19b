"""Shows in Blender what `radiosity solve --gltf` writes: import the GLB, then call show_lightmap("baked.glb").

Each material becomes emission: colour × irradiance / π, and what it emits itself.
"""

import json
import math
import struct
import tempfile


def read_lightmap(path):
    """Returns the document, and the PNG file of the lightmap."""
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    image = next(image for image in document["images"] if image.get("name") == "lightmap")
    view = document["bufferViews"][image["bufferView"]]
    start = 28 + length + view["byteOffset"]
    return document, data[start : start + view["byteLength"]]


def show_lightmap(path):
    import bpy

    document, png = read_lightmap(path)
    with tempfile.NamedTemporaryFile(suffix=".png", delete=False) as file:
        file.write(png)
    picture = bpy.data.images.load(file.name)
    picture.pack()
    for entry in document["materials"]:
        lightmap = entry.get("extensions", {}).get("MOZ_lightmap")
        material = bpy.data.materials.get(entry.get("name", ""))
        if lightmap is None or material is None:
            continue
        nodes, links = material.node_tree.nodes, material.node_tree.links
        surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
        output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
        place = nodes.new("ShaderNodeUVMap")
        place.uv_map = "UVMap.%03d" % lightmap["texCoord"]
        light = nodes.new("ShaderNodeTexImage")
        light.image = picture
        links.new(place.outputs["UV"], light.inputs["Vector"])
        product = nodes.new("ShaderNodeVectorMath")
        product.operation = "MULTIPLY"
        links.new(light.outputs["Color"], product.inputs[0])
        colour = surface.inputs["Base Color"]
        if colour.is_linked:
            links.new(colour.links[0].from_socket, product.inputs[1])
        else:
            product.inputs[1].default_value = colour.default_value[:3]
        reflected = nodes.new("ShaderNodeEmission")
        reflected.inputs["Strength"].default_value = lightmap["intensity"] / math.pi
        links.new(product.outputs["Vector"], reflected.inputs["Color"])
        emitted = nodes.new("ShaderNodeEmission")
        for of, to in [("Emission Color", "Color"), ("Emission Strength", "Strength")]:
            if surface.inputs[of].is_linked:
                links.new(surface.inputs[of].links[0].from_socket, emitted.inputs[to])
            else:
                emitted.inputs[to].default_value = surface.inputs[of].default_value
        total = nodes.new("ShaderNodeAddShader")
        links.new(reflected.outputs[0], total.inputs[0])
        links.new(emitted.outputs[0], total.inputs[1])
        links.new(total.outputs[0], output.inputs["Surface"])
