// Records of the hierarchical solve. A node of its tree is a shot: `first` and `count` are its children.
// gpu/src/linked.rs lays them out.

// Linear radiosity of a node: mean, slopes and the residual of that fit.
struct Radiosity {
    mean: vec3f,
    pad0: u32,
    slope_x: vec3f,          // along the face's tangent and bitangent
    pad1: u32,
    slope_y: vec3f,
    pad2: u32,
    rest: vec3f,             // RMS of the residual
    pad3: u32,
}

// A receiving surface element: one lane of a block.
struct Spot {
    corners: array<vec4f, 4>,
    centre: vec3f,
    face: u32,
    normal: vec3f,
    lit: u32,                // node that receives its light
}

struct Block {
    scale: vec3f,            // reflectance over the RMS of the reflected light
    radius: f32,             // largest radius of a spot
    plane: vec4f,            // of the face on which all lie; else 0
    middle: vec3f,
    reach: f32,              // largest distance of a spot's corner from it
    count: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

// A node and a block that may receive its light.
struct Pair {
    block: u32,
    node: u32,
    state: u32,              // PAIR_…
    samples: u32,            // visibility samples requested; 0: none
    known: u32,              // of which so many are known
    places: u32,             // points per side of a spot, of which its factor is the mean
    factor: f32,             // F at most
    mean: f32,               // light that the block would reflect at F = 1, over the RMS of the reflected light
    rest: f32,
}

// A pair at one spot.
struct Lane {
    bound: vec4f,            // bounds of F, and of the errors by variation, by slope and within a spot
    along: vec2f,            // w·o
    factor: f32,             // F
    weight: f32,             // w
    blocked: vec2u,          // a bit for each sample
    known: f32,              // F where some sample exchanges light
    pad: u32,
}

struct Request {
    source: f32,             // thresholds
    visibility: f32,
    near: f32,
    edge: f32,               // change at a shadow's edge that is followed
    blocks: u32,
    pairs: u32,              // most pairs
    links: u32,              // most links
    pad: u32,
}
