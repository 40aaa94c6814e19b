// What the buffers hold. Twin: gpu/src/records.rs; gpu/src/shaders.rs writes the constants and the codes
// of enums from common.

struct Face {
    plane: vec4f,            // front normal, normal · corner
    tangent: vec4f,          // x axis of the face's frame; no point of a texel is w from its centre
    corners: array<vec4f, 4>,
    edges: array<vec4f, 4>,  // inward edge planes; zero for the edge that a triangle lacks
    sheet: u32,
    two_sided: u32,
    resolution: vec2u,       // texels W×H
}

struct Cell {
    centre: vec3f,
    area: f32,
    corners: array<vec4f, 4>,
    face: u32,
    first: u32,
    count: u32,
    open: f32,               // share of its points on which no body stands
    open_before: f32,        // the same before the objects came
    radius: f32,             // no point of it is farther from its centre
    pad0: u32,
    pad1: u32,
}

// A point in which a cell is looked at.
struct Point {
    position: vec3f,
    weight: f32,             // the area that it stands for over the mean
    cover: u32,              // what stands on it
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
    kind: u32,               // QUAD, UPRIGHT or INVERTED
    pad: u32,
}

// The links of one cell to all texels, kept: whose they are, and ΣF.
struct Row {
    cell: u32,               // its number + 1; 0: an empty place
    sum: f32,
}

// A shot in flight: who shoots, and what. One where each is chosen after the last, many where
// only links are made.
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
    radiosity: vec3f,        // mean residual radiosity of the cell
    cell: u32,
    flux: vec3f,             // radiosity × area
    first: u32,
    count: u32,
    sample: u32,             // the sample in hand, of which `centre` is the point
    next: u32,               // the sample after the ones in hand
    fresh: u32,              // 1: its links are to be made
    place: u32,              // where its links are kept
    scale: f32,              // what they are multiplied by
    open: f32,
    drawn: u32,              // how many faces the item buffer in hand shows
    open_before: f32,
    taken: u32,              // where what the cells take of it begins
    sum: f32,                // ΣF and the escaped share, once known
    escaped: f32,
    middle: vec3f,           // of the cell
    radius: f32,
}

// Which of the shots this invocation works on: the third dimension of a dispatch.
var<private> slot: u32;

// `lost` of a cell whose directions are counted.
const KNOWN = 0x80000000u;

struct Record {
    flux: vec3f,
    cell: u32,
    form_factor_sum: f32,
    escaped: f32,
    unshot: f32,
    pad: u32,
}

struct Params {
    texels: u32,
    cells: u32,
    faces: u32,
    replay: u32,             // 1: the script chooses
    threshold: f32,          // Σ|r|A at which a greedy run has converged
    unit: f32,               // scene units per mesh unit
    places: u32,             // rows of links that are kept
    step: u32,               // samples of one dispatch
    samples: u32,            // points of a cell
    conserve: u32,           // 1: scale each shot to its exact closure
    room: u32,               // the first so many faces are the room, the others objects
    rule: u32,               // how the room takes a shot
    groups: array<vec4u, 3>, // workgroups over texels, directions, cells
    tiles: u32,              // item buffers side by side
    first: u32,              // of the cells whose shots are collected
    end: u32,
    pad: u32,
}

// Workgroups beyond one dimension's limit go to the second.
fn flat(group: vec3u, groups: vec3u) -> u32 {
    return group.y * groups.x + group.x;
}
