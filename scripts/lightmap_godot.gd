# Shows in Godot 4 what `radiosity solve --gltf` writes. Register it before the import, in an editor plugin or at run time:
#   GLTFDocument.register_gltf_document_extension(preload("lightmap_godot.gd").new())
# Each material becomes unshaded: colour × irradiance / π, and what it emits itself.
@tool
extends GLTFDocumentExtension

const SHADER := "
shader_type spatial;
render_mode unshaded;
uniform vec4 colour;
uniform sampler2D picture : source_color, hint_default_white;
uniform vec3 emitted;
uniform sampler2D lightmap : source_color, repeat_disable;
uniform float scale;
void fragment() {
	ALBEDO = colour.rgb * texture(picture, UV).rgb * texture(lightmap, UV2).rgb * scale + emitted;
}"

func _import_post(state: GLTFState, _root: Node) -> Error:
	var shader := Shader.new()
	shader.code = SHADER
	for mesh in state.get_meshes():
		for surface in mesh.mesh.get_surface_count():
			var material := mesh.mesh.get_surface_material(surface) as BaseMaterial3D
			var number := state.get_materials().find(material)
			if number < 0:
				continue
			var entry: Dictionary = state.json["materials"][number]
			var lightmap = entry.get("extensions", {}).get("MOZ_lightmap")
			if lightmap == null:
				continue
			var texture: Dictionary = state.json["textures"][int(lightmap["index"])]
			# White of the display is 1.
			var white: float = texture["extras"]["white"]
			var lit := ShaderMaterial.new()
			lit.shader = shader
			lit.set_shader_parameter("colour", material.albedo_color.srgb_to_linear())
			lit.set_shader_parameter("picture", material.albedo_texture)
			var emitted := material.emission.srgb_to_linear() * material.emission_energy_multiplier * PI / white
			lit.set_shader_parameter("emitted", Vector3(emitted.r, emitted.g, emitted.b))
			lit.set_shader_parameter("lightmap", state.get_images()[int(texture["source"])])
			lit.set_shader_parameter("scale", float(lightmap["intensity"]) / white)
			mesh.mesh.set_surface_material(surface, lit)
	return OK
