//! Compares single WGSL functions with their twins at the limits of their branches: directions below the horizon, rays in a
//! plane or along an axis, outlines without area, ties.

use super::comparison::StageCheck;
use super::statistics::{Elements, ErrorTally, ValueSource};
use common::Result;
use common::constants::{MAX_GRAZING_HEIGHT_RATIO, PATCH_SUM_LANES, POINT_SOURCE_RADII};
use common::form_factor::Shooter;
use common::mesh::{Mesh, MeshFace, TexelKind};
use common::settings::{ItemBufferProjection, Transport};
use cpu::shader_twins::bvh::make_ray;
use cpu::shader_twins::form_factor::{is_low, is_remote};
use cpu::shader_twins::image_bound::edge_distance;
use cpu::shader_twins::intersect::intersect_planes;
use cpu::shader_twins::projection::project_direction;
use cpu::shader_twins::sampling::texel_uv;
use cpu::shader_twins::surface_points::{outline_point, spot_point};
use cpu::shader_twins::texel_point::point_on_texel;
use cpu::shader_twins::visibility_samples::{receiver_points_per_side, visibility_deviation};
use glam::{Vec3, Vec4};
use gpu::function_caller::FunctionCaller;
use gpu::function_calls::{ARGUMENT_COUNT, CallArguments, FunctionCall};
use gpu::{Gpu, ShaderFault};

/// Names of the numbers of a result.
const RESULT_VALUES: [&str; 4] = ["x", "y", "z", "w"];
/// Largest difference in ulp of the result, or of [`RESULT_SIZE`]. The arguments are exact; the differences of rounded
/// numbers among their terms are a fifth of these at least.
const MAX_CALL_ULPS: f64 = 64.0;
/// Reason of that bound.
const CALL_REASON: &str = "ulp of the result, or of 1: 5 operations of 2.5 ulp, enlarged 5 times";
/// Size of the terms of a result: coordinates of the unit square and of images.
const RESULT_SIZE: f32 = 1.0;

/// A function with its arguments.
struct CheckedFunction<'a> {
    function: &'static str,
    arguments: Vec<CallArguments>,
    /// The result in Rust.
    twin: Box<dyn Fn(&CallArguments) -> Vec4 + 'a>,
}

/// Checks the functions that solves by shots call.
///
/// Errors: the device fails.
pub fn check_shooting_functions(
    mesh: &Mesh,
    transport: &Transport,
    (gpu, faults): (&Gpu, &[ShaderFault]),
) -> Result<Vec<StageCheck>> {
    let mut checked = vec![
        CheckedFunction {
            function: "intersect_planes",
            arguments: rays_and_squares(),
            twin: Box::new(|arguments| {
                let [plane, edge0, edge1, edge2, edge3, origin, direction, _] = arguments.map(to_vector);
                let edges = [edge0, edge1, edge2, edge3];
                let hit = intersect_planes(plane, edges, origin.truncate(), direction.truncate());
                Vec4::new(hit.t, hit.inside, hit.facing, to_number(hit.stops_ray(1.0)))
            }),
        },
        CheckedFunction {
            function: "make_ray",
            arguments: ray_directions(),
            twin: Box::new(|arguments| {
                let given = to_vector(arguments[0]);
                let ray = make_ray(Vec3::ZERO, given.truncate(), given.w);
                // Either sign of 1/0 gives the same boxes.
                ray.inverse.abs().extend(ray.reach)
            }),
        },
        CheckedFunction {
            function: "texel_uv",
            arguments: sample_numbers(),
            twin: Box::new(|[[s, texel, patch, _], ..]| {
                let [u, v] = texel_uv(*s, *texel, *patch);
                Vec4::new(u, v, 0.0, 0.0)
            }),
        },
        CheckedFunction {
            function: "point_on_texel",
            arguments: texel_points(),
            twin: Box::new(|[a, b, c, d, [w, h, i, j], [kind, area, u, v], ..]| {
                let face = MeshFace {
                    corners: [a, b, c, d].map(|corner| to_vector(*corner).truncate()),
                    resolution: [*w, *h],
                    ..mesh.faces[0]
                };
                let kinds = [TexelKind::Quad, TexelKind::Upright, TexelKind::Inverted];
                let [area, u, v] = [area, u, v].map(|bits| f32::from_bits(*bits));
                point_on_texel(&face, kinds[*kind as usize], [*i, *j], area, [u, v])
            }),
        },
        CheckedFunction {
            function: "is_low",
            arguments: grazing_points(),
            twin: Box::new(|[point, normal, middle, ..]| {
                let [point, normal, middle] = [point, normal, middle].map(|words| to_vector(*words));
                let shooter = Shooter {
                    normal: normal.truncate(),
                    centre: middle.truncate(),
                    radius: middle.w,
                    ..mesh.patches[0].shooter
                };
                to_result(to_number(is_low(&shooter, point.truncate(), point.w)))
            }),
        },
        CheckedFunction {
            function: "is_remote",
            arguments: squared_distances(),
            twin: Box::new(|arguments| {
                let given = to_vector(arguments[0]);
                to_result(to_number(is_remote(given.x, given.y)))
            }),
        },
    ];
    let projection = transport.visibility.item_buffer().map(|drawing| drawing.projection);
    if let Some(projection) = projection {
        checked.push(CheckedFunction {
            function: "project_direction",
            arguments: projected_directions(projection),
            twin: Box::new(move |arguments| {
                let image = project_direction(projection, to_vector(arguments[0]).truncate());
                image.extend(0.0).extend(0.0)
            }),
        });
        checked.push(CheckedFunction {
            function: "edge_distance",
            arguments: image_edges(),
            twin: Box::new(|arguments| {
                let [a, b, ..] = arguments.map(|words| to_vector(words).truncate());
                to_result(edge_distance(a, b))
            }),
        });
    }
    check_functions(&checked, mesh, FunctionCaller::new(gpu, transport, faults))
}

/// Checks the functions that only links between nodes call.
///
/// Errors: the device fails.
pub fn check_link_functions(mesh: &Mesh, (gpu, faults): (&Gpu, &[ShaderFault])) -> Result<Vec<StageCheck>> {
    let counts = CheckedFunction {
        function: "receiver_points_per_side",
        arguments: [0.5, 1.0, 10.0, 20.0, 100.0, 200.0]
            .map(|error| with_numbers([[error, 0.5, 0.5, 0.0]]))
            .to_vec(),
        twin: Box::new(|arguments| {
            let given = to_vector(arguments[0]);
            to_result(receiver_points_per_side(given.x, given.y, given.z) as f32)
        }),
    };
    let deviations = CheckedFunction {
        function: "visibility_deviation",
        // Rounding may make a share larger than 1.
        arguments: [0.0, 0.25, 0.5, 1.0, 1.0 + f32::EPSILON]
            .map(|seen| with_numbers([[seen, 0.0, 0.0, 0.0]]))
            .to_vec(),
        twin: Box::new(|arguments| to_result(visibility_deviation(to_vector(arguments[0]).x))),
    };
    let points = CheckedFunction {
        function: "spot_point",
        arguments: spot_points(),
        twin: Box::new(|arguments| {
            let [a, b, c, d, uv, ..] = arguments.map(|words| to_vector(words).truncate());
            let (point, weight) = spot_point([a, b, c, d], c == d, [uv.x, uv.y]);
            point.extend(weight)
        }),
    };
    let node_points = CheckedFunction {
        function: "outline_point",
        arguments: spot_points(),
        twin: Box::new(|arguments| {
            let [a, b, c, d, uv, ..] = arguments.map(|words| to_vector(words).truncate());
            outline_point(&[a, b, c, d], [uv.x, uv.y])
        }),
    };
    check_functions(
        &[points, node_points, counts, deviations],
        mesh,
        FunctionCaller::new(gpu, &Transport::default(), faults),
    )
}

fn check_functions(checked: &[CheckedFunction], mesh: &Mesh, mut caller: FunctionCaller) -> Result<Vec<StageCheck>> {
    let mut checks = Vec::new();
    for CheckedFunction {
        function,
        arguments,
        twin,
    } in checked
    {
        let found = match FunctionCall::find(function) {
            Some(call) => caller.call(call, arguments)?,
            None => None,
        };
        let Some(found) = found else {
            continue;
        };
        let calls = Elements {
            name: "call",
            count: arguments.len(),
            lanes: PATCH_SUM_LANES,
        };
        let mut tally = ErrorTally::new(function, (MAX_CALL_ULPS, CALL_REASON), calls, &RESULT_VALUES);
        for (k, (arguments, found)) in arguments.iter().zip(found).enumerate() {
            let twin = twin(arguments);
            for n in 0..4 {
                tally.add_ulps(ValueSource::default(), [k, n], [found[n], twin[n]], RESULT_SIZE);
            }
        }
        checks.push(tally.stage_check(mesh));
    }
    Ok(checks)
}

/// Returns 1 for true, 0 for false.
fn to_number(holds: bool) -> f32 {
    f32::from(u8::from(holds))
}

/// Returns the result of a function of one number.
fn to_result(number: f32) -> Vec4 {
    Vec4::new(number, 0.0, 0.0, 0.0)
}

/// Returns the numbers of an argument.
fn to_vector(words: [u32; 4]) -> Vec4 {
    Vec4::from_array(words.map(f32::from_bits))
}

/// Returns the arguments of a call: these numbers, then zeros.
fn with_numbers<const N: usize>(numbers: [[f32; 4]; N]) -> CallArguments {
    let mut arguments = [[0; 4]; ARGUMENT_COUNT];
    for (words, numbers) in arguments.iter_mut().zip(numbers) {
        *words = numbers.map(f32::to_bits);
    }
    arguments
}

/// Returns directions on the axes, above and below the horizon and, where the image goes on there, straight down.
fn projected_directions(projection: ItemBufferProjection) -> Vec<CallArguments> {
    let directions = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 2.0, 0.0],
        [0.0, -2.0, 0.0],
        [0.0, 0.0, 0.5],
        [3.0, 4.0, 0.0],
        [-4.0, 3.0, 12.0],
        [1.0, 1.0, 1.0],
        [1.0, -0.5, 1.0],
        [3.0, 0.0, -4.0],
        [-4.0, 3.0, -12.0],
    ];
    let straight_down = (projection == ItemBufferProjection::Hemisphere).then_some([0.0, 0.0, -1.0]);
    let all = directions.into_iter().chain(straight_down);
    all.map(|[x, y, z]| with_numbers([[x, y, z, 0.0]])).collect()
}

/// Returns rays that meet a unit square or half of it, miss it, touch its outline, run along it or in its plane.
fn rays_and_squares() -> Vec<CallArguments> {
    let plane = [0.0, 0.0, 1.0, 0.0];
    let [left, right] = [[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, -1.0]];
    let [low, high] = [[0.0, 1.0, 0.0, 0.0], [0.0, -1.0, 0.0, -1.0]];
    let outlines = [[left, right, low, high], [left, [-0.5, -0.5, 0.0, -0.5], low, [0.0; 4]]];
    let down = [0.0, 0.0, -2.0, 0.0];
    let rays = [
        ([0.5, 0.25, 1.0, 0.0], down),
        ([0.5, 0.25, -1.0, 0.0], [0.0, 0.0, 2.0, 0.0]),
        ([0.5, 0.25, -1.0, 0.0], down),
        ([0.5, 0.25, 2.0, 0.0], down),
        ([0.75, 0.75, 1.0, 0.0], down),
        ([1.0, 0.0, 1.0, 0.0], down),
        ([1.5, 0.5, 1.0, 0.0], down),
        ([0.5, -1.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0]),
        ([0.5, -1.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0]),
        ([0.5, 0.25, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]),
        ([0.0, 0.0, 1.0, 0.0], [1.0, 0.5, -2.0, 0.0]),
    ];
    let with_ray = |[a, b, c, d]: [[f32; 4]; 4]| {
        rays.map(|(origin, direction)| with_numbers([plane, a, b, c, d, origin, direction]))
    };
    outlines.into_iter().flat_map(with_ray).collect()
}

/// Returns directions along axes, in planes of two, and with components so small that 1/x has no bound.
fn ray_directions() -> Vec<CallArguments> {
    let directions = [
        [1.0, 0.0, 0.0, 1.0],
        [0.0, -2.0, 0.0, 2.0],
        [1e-31, 0.0, -4.0, 1.0],
        [-1e-31, 1e-29, 1.0, 1.0],
        [0.75, -0.5, 3.0, 8.0],
    ];
    directions.map(|direction| with_numbers([direction])).to_vec()
}

/// Returns numbers of samples, texels and patches, the largest ones among them: steps that are wrong by one in 2³² differ.
fn sample_numbers() -> Vec<CallArguments> {
    let numbers = [
        [0, 0, 0, 0],
        [1, 0, 0, 0],
        [7, 65_537, 3, 0],
        [u32::MAX - 1, 1, 0, 0],
        [3_000_000_000, 12, u32::MAX, 0],
        [2_000_000_000, u32::MAX, 1, 0],
    ];
    let with_zeros = |words| {
        let mut arguments = [[0; 4]; ARGUMENT_COUNT];
        arguments[0] = words;
        arguments
    };
    numbers.map(with_zeros).to_vec()
}

/// Corners of a trapezium, and of an outline without area.
const OUTLINES: [[[f32; 4]; 4]; 2] = [
    [
        [0.0, 0.0, 0.0, 0.0],
        [2.0, 0.0, 0.5, 0.0],
        [1.5, 1.0, 0.5, 0.0],
        [0.5, 1.0, 0.125, 0.0],
    ],
    [
        [0.0, 0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0, 0.0],
        [2.0, 2.0, 0.0, 0.0],
        [0.5, 0.5, 0.0, 0.0],
    ],
];
/// Points of a texel on both sides of the diagonal along which triangles are folded.
const UNIT_POINTS: [[f32; 2]; 3] = [[0.25, 0.5], [0.25, 0.8125], [0.75, 0.5]];

/// Returns points of texels of each kind, and of a texel without area.
fn texel_points() -> Vec<CallArguments> {
    let mut calls = Vec::new();
    for (corners, area) in OUTLINES.into_iter().zip([0.25f32, 0.0]) {
        for (kind, [u, v]) in (0..3).flat_map(|kind| UNIT_POINTS.map(|point| (kind, point))) {
            let mut arguments = with_numbers(corners);
            arguments[4] = [4, 2, 3, 1];
            arguments[5] = [kind, area.to_bits(), u.to_bits(), v.to_bits()];
            calls.push(arguments);
        }
    }
    calls
}

/// Returns points of spots or nodes: of a quad, of a triangle, and of an outline without area.
fn spot_points() -> Vec<CallArguments> {
    let [[a, b, c, d], line] = OUTLINES;
    let outlines = [[a, b, c, d], [a, b, c, c], line];
    let with_points =
        |[a, b, c, d]: [[f32; 4]; 4]| UNIT_POINTS.map(|[u, v]| with_numbers([a, b, c, d, [u, v, 0.0, 0.0]]));
    outlines.into_iter().flat_map(with_points).collect()
}

/// Returns edges of which the nearest point to the origin is within, at either end, and of one without length.
fn image_edges() -> Vec<CallArguments> {
    let edges = [
        [[-1.0, 1.0, 0.5], [3.0, 1.0, 0.5]],
        [[1.0, 0.5, 0.5], [3.0, 1.0, 0.5]],
        [[3.0, 1.0, 0.5], [1.0, 0.5, 0.5]],
        [[0.5, 1.0, 2.0], [0.5, 1.0, 2.0]],
    ];
    let with_ends = |[[ax, ay, az], [bx, by, bz]]: [[f32; 3]; 2]| with_numbers([[ax, ay, az, 0.0], [bx, by, bz, 0.0]]);
    edges.map(with_ends).to_vec()
}

/// Returns points of texels beside and before a shooter whose highest corner is lower than the limit of grazing light, and
/// higher. None is as high: a root decides there.
fn grazing_points() -> Vec<CallArguments> {
    let (normal, middle) = ([0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.5]);
    let positions = [[8.5, 0.0, 0.0], [0.0, 0.0, 8.0]];
    let with_height = |[x, y, z]: [f32; 3]| {
        [0.5, 0.97, 1.5, 3.0].map(|factor| {
            let highest = factor * MAX_GRAZING_HEIGHT_RATIO * 8.0;
            with_numbers([[x, y, z, highest], normal, middle])
        })
    };
    positions.into_iter().flat_map(with_height).collect()
}

/// Returns squared distances at the limit from which a shooter is a point, nearer and farther, with its radius.
fn squared_distances() -> Vec<CallArguments> {
    let radius = 0.5;
    let limit = POINT_SOURCE_RADII * radius;
    [0.25, 1.0, 4.0]
        .map(|factor| with_numbers([[factor * limit * limit, radius, 0.0, 0.0]]))
        .to_vec()
}
