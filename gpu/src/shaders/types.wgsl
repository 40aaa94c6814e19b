// Records of the storage buffers: faces, patches, texels, links and shots. gpu/src/records.rs lays them out;
// gpu/src/shaders.rs writes the constants and the codes of enums before them.

struct Face {
    plane: vec4f,            // front normal, normal · corner
    tangent: vec4f,          // x axis of the face's frame; w: largest radius of a texel
    corners: array<vec4f, 4>,
    edges: array<vec4f, 4>,  // inward edge planes; zero for the edge that a triangle lacks
    sheet: u32,
    two_sided: u32,
    resolution: vec2u,       // texels W×H
}

struct Patch {
    centre: vec3f,
    area: f32,
    corners: array<vec4f, 4>,
    face: u32,
    first: u32,
    count: u32,
    open: f32,               // share of its points on which no body stands
    open_before: f32,        // the same before the objects came
    radius: f32,             // largest distance of a point of it from its centre
    pad0: u32,
    pad1: u32,
}

// A sample point of a patch.
struct Point {
    position: vec3f,
    weight: f32,             // area that it represents, over the mean
    cover: u32,              // body that covers it: COVER_…
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

struct Texel {
    position: vec3f,
    area: f32,
    reflectance: vec3f,
    face: u32,
    place: vec2u,            // lower corner on the face's lattice
    kind: u32,               // TEXEL_QUAD, UPRIGHT or TEXEL_INVERTED
    pad: u32,
}

// A kept row: the links of one patch to all texels.
struct Row {
    patch_index: u32,               // number + 1; 0: an empty row
    sum: f32,
}

// A shot in flight. There is one where each is selected after the last, many where only links are made.
struct Shot {
    centre: vec3f,
    area: f32,
    normal: vec3f,
    shooting: u32,           // 0 once the order has ended
    tangent: vec3f,
    sheet: u32,
    bitangent: vec3f,
    face: u32,
    corners: array<vec4f, 4>,
    radiosity: vec3f,        // mean residual radiosity of the patch
    patch_index: u32,
    flux: vec3f,             // radiosity × area
    first: u32,
    count: u32,
    sample: u32,             // the current sample, of which `centre` is the point
    next: u32,               // the first sample of the next dispatch
    fresh: u32,              // 1: its links are to be made
    place: u32,              // row in which its links are kept
    scale: f32,              // factor that scales its links
    open: f32,
    drawn: u32,              // number of faces that the current item buffer shows
    open_before: f32,
    transfer_start: u32,              // where what the patches take of it begins
    sum: f32,                // ΣF and the escaped share, once known
    escaped: f32,
    middle: vec3f,           // of the patch
    radius: f32,
}

// Index of this invocation's shot: the third dimension of a dispatch.
var<private> slot: u32;

// Bit of `escape_counts` that marks a patch whose directions are counted.
const COUNTED_BIT = 0x80000000u;

struct Record {
    flux: vec3f,
    patch_index: u32,
    form_factor_sum: f32,
    escaped: f32,
    unshot: f32,
    pad: u32,
}

struct Params {
    texels: u32,
    patches: u32,
    faces: u32,
    replay: u32,             // 1: the script chooses
    threshold: f32,          // Σ|r|A at which a greedy run has converged
    unit: f32,               // scene units per mesh unit
    places: u32,             // number of kept rows
    step: u32,               // samples of one dispatch
    samples: u32,            // sample points of a patch
    conserve: u32,           // 1: scale each shot to its exact closure
    room: u32,               // the first so many faces are the room, the others objects
    rule: u32,               // how the room receives a shot: CAPTURED_BIT, SUBTRACTED_BITS, KEEP_BIT; PROBE_BIT
    groups: array<vec4u, 3>, // workgroups over texels, directions, patches
    tiles: u32,              // item buffers side by side
    first: u32,              // range of patches whose shots are gathered
    end: u32,
    pad: u32,
}

// Number of a workgroup: those beyond the limit of the first dimension go to the second.
fn flat_index(group: vec3u, groups: vec3u) -> u32 {
    return group.y * groups.x + group.x;
}
