// Shows in three.js what `radiosity solve --gltf` writes:
//
//   const loader = new GLTFLoader();
//   loader.register(readLightmap);
//   const gltf = await loader.loadAsync("baked.glb");
//   renderer.toneMapping = LinearToneMapping;
//   renderer.toneMappingExposure = Math.PI / displayWhite(gltf);
//
// The lightmap holds all light: leave out other lights.
import { SRGBColorSpace } from "three";

/** Plugin of GLTFLoader: the extension MOZ_lightmap of materials as `lightMap`. */
export const readLightmap = (parser) => ({
  name: "MOZ_lightmap",
  extendMaterialParams(index, params) {
    const lightmap = parser.json.materials[index].extensions?.MOZ_lightmap;
    if (!lightmap) return null;
    // The light was solved for diffuse surfaces; a metal shows none of it.
    params.metalness = 0;
    params.lightMapIntensity = lightmap.intensity;
    return parser.assignTexture(params, "lightMap", lightmap, SRGBColorSpace);
  },
});

/** Radiosity that a display should show as white, W/m². */
export const displayWhite = (gltf) =>
  gltf.parser.json.textures.find((texture) => texture.name === "lightmap").extras.white;
