//! Calls of single WGSL functions with arguments from the host: at the limits of their branches, which scenes seldom meet.

/// Most arguments of a call, vectors of four words each.
pub const ARGUMENT_COUNT: usize = 8;
/// Arguments of a call: bits of numbers and integers.
pub type CallArguments = [[u32; 4]; ARGUMENT_COUNT];

/// Entry point of a call.
pub(crate) const CALL_ENTRY: &str = "call_function";

/// A WGSL function that is called by itself.
#[derive(Clone, Copy, Debug)]
pub struct FunctionCall {
    /// The function.
    pub function: &'static str,
    /// The file that defines it, then files that this one needs.
    pub(crate) files: &'static [&'static str],
    /// Declarations of what the files read and do not declare.
    declarations: &'static str,
    /// Statements before the result.
    statements: &'static str,
    /// Expression of the result, four numbers; `real(k)` is argument `k`, and `word(k)` its bits.
    result: &'static str,
}

/// The calls.
pub const FUNCTION_CALLS: [FunctionCall; 19] = [
    FunctionCall {
        function: "project_direction",
        files: &["projection", "hemicube"],
        declarations: "var<private> params: Params;",
        statements: "",
        result: "vec4f(project_direction(real(0u).xyz), 0.0, 0.0)",
    },
    FunctionCall {
        function: "unproject_point",
        files: &["projection", "hemicube"],
        declarations: "var<private> params: Params;",
        statements: "let p = real(0u).xy;",
        result: "vec4f(unproject_point(p), f32(is_covered(p)))",
    },
    FunctionCall {
        function: "side_extent",
        files: &["hemicube"],
        declarations: "",
        statements: "",
        result: "side_extent(word(0u).x)",
    },
    FunctionCall {
        function: "edge_distance",
        files: &["image_bound", "frame", "hemicube", "projection"],
        declarations: "",
        statements: "",
        result: "vec4f(edge_distance(real(0u).xyz, real(1u).xyz), 0.0, 0.0, 0.0)",
    },
    FunctionCall {
        function: "bound_corner",
        files: &["image_bound", "frame", "hemicube", "projection"],
        declarations: "",
        statements: "",
        result: "bound_corner(real(0u), word(1u).x, real(2u).xyz, real(2u).w)",
    },
    FunctionCall {
        function: "bound_arc",
        files: &["image_bound", "frame", "hemicube", "projection"],
        declarations: "",
        statements: "",
        result: "bound_arc(real(0u), real(1u).xyz, real(2u).xyz, real(2u).w)",
    },
    FunctionCall {
        function: "link_scale",
        files: &["closure"],
        declarations: "",
        statements: "",
        result: "vec4f(link_scale(word(0u).x == 1u, real(1u).x, real(1u).y), 0.0, 0.0, 0.0)",
    },
    FunctionCall {
        function: "intersect_planes",
        files: &["intersect"],
        declarations: "var<private> faces: array<Face, 1>;",
        statements: "let hit = intersect_planes(real(0u), real(1u), real(2u), real(3u), real(4u), real(5u).xyz, real(6u).xyz);",
        result: "vec4f(hit.t, hit.inside, hit.facing, f32(stops_ray(hit, 1.0)))",
    },
    FunctionCall {
        function: "touches_plane",
        files: &["intersect"],
        declarations: "var<private> faces: array<Face, 1>;",
        statements: "faces[0].plane = real(0u);",
        result: "vec4f(f32(touches_plane(0u, real(1u).xyz)), 0.0, 0.0, 0.0)",
    },
    FunctionCall {
        function: "make_ray",
        files: &["bvh"],
        declarations: "var<private> nodes: array<Node, 1>;",
        statements: "let ray = make_ray(vec3f(0.0), real(0u).xyz, real(0u).w);",
        result: "vec4f(abs(ray.inverse), ray.reach)",
    },
    FunctionCall {
        function: "texel_uv",
        files: &["sampling"],
        declarations: "",
        statements: "",
        result: "vec4f(texel_uv(word(0u).x, word(0u).y, word(0u).z), 0.0, 0.0)",
    },
    FunctionCall {
        function: "near_point_uv",
        files: &["sampling"],
        declarations: "",
        statements: "",
        result: "vec4f(near_point_uv(word(0u).x, word(0u).y), 0.0, 0.0)",
    },
    FunctionCall {
        function: "point_on_texel",
        files: &["texel_point", "sampling"],
        declarations: "var<private> params: Params;
var<private> faces: array<Face, 1>;
var<private> texels: array<Texel, 1>;",
        statements: "for (var k = 0u; k < 4u; k++) {
    faces[0].corners[k] = real(k);
}
faces[0].resolution = word(4u).xy;
texels[0].place = word(4u).zw;
texels[0].kind = word(5u).x;
texels[0].area = real(5u).y;",
        result: "point_on_texel(0u, real(5u).zw)",
    },
    FunctionCall {
        function: "is_remote",
        files: &["form_factor"],
        declarations: "var<private> shots: array<Shot, 1>;",
        statements: "",
        result: "vec4f(f32(is_remote(real(0u).x, real(0u).y)), 0.0, 0.0, 0.0)",
    },
    FunctionCall {
        function: "is_low",
        files: &["form_factor"],
        declarations: "var<private> shots: array<Shot, 2>;",
        statements: "slot = 1u;
shots[1].normal = real(1u).xyz;
shots[1].middle = real(2u).xyz;
shots[1].radius = real(2u).w;",
        result: "vec4f(f32(is_low(real(0u).xyz, real(0u).w)), 0.0, 0.0, 0.0)",
    },
    FunctionCall {
        function: "receiver_points_per_side",
        files: &["visibility_samples"],
        declarations: "",
        statements: "",
        result: "vec4f(f32(receiver_points_per_side(real(0u).x, real(0u).y, real(0u).z)), 0.0, 0.0, 0.0)",
    },
    FunctionCall {
        function: "visibility_deviation",
        files: &["visibility_samples"],
        declarations: "",
        statements: "",
        result: "vec4f(visibility_deviation(real(0u).x), 0.0, 0.0, 0.0)",
    },
    FunctionCall {
        function: "spot_point",
        files: &["surface_points", "sampling", "hierarchy_types"],
        declarations: "var<private> shots: array<Shot, 1>;
var<private> spots: array<Spot, 1>;",
        statements: "for (var k = 0u; k < 4u; k++) {
    spots[0].corners[k] = real(k);
}",
        result: "spot_point(0u, real(4u).xy)",
    },
    FunctionCall {
        function: "outline_point",
        files: &["surface_points", "sampling", "hierarchy_types"],
        declarations: "var<private> shots: array<Shot, 1>;
var<private> spots: array<Spot, 1>;",
        statements: "for (var k = 0u; k < 4u; k++) {
    shots[0].corners[k] = real(k);
}",
        result: "outline_point(0u, real(4u).xy)",
    },
];

impl FunctionCall {
    /// Finds the call of a function.
    pub fn find(function: &str) -> Option<&'static Self> {
        FUNCTION_CALLS.iter().find(|call| call.function == function)
    }

    /// Returns the WGSL of the entry point.
    pub(crate) fn entry_text(&self) -> String {
        let Self {
            declarations,
            statements,
            result,
            ..
        } = self;
        format!(
            "@group(0) @binding(8) var<storage, read> inputs: array<array<vec4u, {ARGUMENT_COUNT}>>;
@group(0) @binding(9) var<storage, read_write> results: array<vec4f>;
{declarations}
var<private> arguments: array<vec4u, {ARGUMENT_COUNT}>;

fn word(k: u32) -> vec4u {{
    return arguments[k];
}}

fn real(k: u32) -> vec4f {{
    return bitcast<vec4f>(arguments[k]);
}}

@compute @workgroup_size(PATCH_SUM_LANES)
fn {CALL_ENTRY}(@builtin(global_invocation_id) id: vec3u) {{
    if id.x >= arrayLength(&results) {{
        return;
    }}
    arguments = inputs[id.x];
    {statements}
    results[id.x] = {result};
}}
"
        )
    }
}
