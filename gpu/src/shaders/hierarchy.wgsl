// What the shaders of the hierarchical solve hold. A node of its tree is a shot: `first` and `count` are
// its parts. Twin: gpu/src/records.rs.

// What a node shines.
struct Glow {
    mean: vec3f,
    pad0: u32,
    slope_x: vec3f,          // along the face's tangent and bitangent
    pad1: u32,
    slope_y: vec3f,
    pad2: u32,
    rest: vec3f,             // RMS of what mean and slope leave
    pad3: u32,
}

// What one lane of a block receives on.
struct Spot {
    corners: array<vec4f, 4>,
    centre: vec3f,
    face: u32,
    normal: vec3f,
    lit: u32,                // the node that it lights
}

struct Block {
    scale: vec3f,            // reflectance over the RMS of the reflected light
    radius: f32,             // no point of a spot is farther from its centre
    plane: vec4f,            // of the face on which all lie; else 0
    middle: vec3f,
    reach: f32,              // no spot reaches farther from it
    count: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

// A node and a block that it may shine on.
struct Pair {
    block: u32,
    node: u32,
    state: u32,              // what is done about it
    samples: u32,            // pairs of points to be asked now; 0: none
    known: u32,              // of which so many were asked before
    places: u32,             // places a side on each spot, of which its factor is the mean
    factor: f32,             // F at most
    mean: f32,               // of the RMS of the reflected light, what the block would reflect at F = 1
    rest: f32,
}

// The same at one spot.
struct Lane {
    bound: vec4f,            // F, and F of what varies, slopes, and lies within a spot
    along: vec2f,            // w·o
    factor: f32,             // F
    weight: f32,             // w
    stopped: vec2u,          // a bit a pair of points
    known: f32,              // F where some pair of points exchanges light
    pad: u32,
}

struct Asked {
    source: f32,             // thresholds
    visibility: f32,
    near: f32,
    blocks: u32,
    pairs: u32,              // room for so many
    links: u32,
    pad0: u32,
    pad1: u32,
}
