//! Compares single WGSL functions with their twins at the limits of their branches: directions below the horizon, rays in a
//! plane or along an axis, outlines without area, ties.

use super::comparison::StageCheck;
use super::statistics::{Elements, ErrorTally, ValueSource};
use common::Result;
use common::constants::{
    CONTACT_DISTANCE, MAX_GRAZING_HEIGHT_RATIO, NEAR_POINTS_PER_SIDE, PATCH_SUM_LANES, POINT_SOURCE_RADII,
};
use common::form_factor::Shooter;
use common::mesh::{Mesh, MeshFace, TexelKind};
use common::passes::PatchClosure;
use common::sampling::near_point_uv;
use common::settings::{ItemBufferProjection, Transport, Visibility};
use cpu::shader_twins::bvh::make_ray;
use cpu::shader_twins::form_factor::{is_low, is_remote};
use cpu::shader_twins::hemicube::{side_extent, side_height};
use cpu::shader_twins::image_bound::{bound_arc, bound_corner, edge_distance};
use cpu::shader_twins::intersect::{intersect_planes, touches_plane};
use cpu::shader_twins::projection::{is_covered, project_direction, unproject_point};
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

/// Kinds of texels by their numbers in WGSL.
const TEXEL_KINDS: [TexelKind; 3] = [TexelKind::Quad, TexelKind::Upright, TexelKind::Inverted];

/// A function with its arguments, in a solver of these settings.
struct CheckedFunction<'a> {
    function: &'static str,
    transport: Transport,
    arguments: Vec<CallArguments>,
    /// The result in Rust.
    twin: Box<dyn Fn(&CallArguments) -> Vec4 + 'a>,
}

/// Checks the functions that solves by shots call.
///
/// Errors: the device fails.
pub async fn check_shooting_functions(
    mesh: &Mesh,
    transport: &Transport,
    (gpu, faults): (&Gpu, &[ShaderFault]),
) -> Result<Vec<StageCheck>> {
    let mut checked = vec![
        CheckedFunction {
            function: "intersect_planes",
            transport: *transport,
            arguments: rays_and_squares(),
            twin: Box::new(|arguments| {
                let [plane, edge0, edge1, edge2, edge3, origin, direction, _] = arguments.map(to_vector);
                let edges = [edge0, edge1, edge2, edge3];
                let hit = intersect_planes(plane, edges, origin.truncate(), direction.truncate());
                Vec4::new(hit.t, hit.inside, hit.facing, to_number(hit.stops_ray(1.0)))
            }),
        },
        CheckedFunction {
            function: "touches_plane",
            transport: *transport,
            arguments: points_at_plane(),
            twin: Box::new(|arguments| {
                let [plane, point, ..] = arguments.map(to_vector);
                let face = MeshFace { plane, ..mesh.faces[0] };
                to_result(to_number(touches_plane(&face, point.truncate())))
            }),
        },
        CheckedFunction {
            function: "make_ray",
            transport: *transport,
            arguments: ray_directions(),
            twin: Box::new(|arguments| {
                let given = to_vector(arguments[0]);
                let ray = make_ray(Vec3::ZERO, given.truncate(), given.w);
                // Either sign of 1/0 gives the same boxes.
                ray.inverse.abs().extend(ray.reach)
            }),
        },
        CheckedFunction {
            function: "link_scale",
            transport: *transport,
            arguments: closure_arguments(),
            twin: Box::new(|[[conserve, ..], sums, ..]| {
                let given = to_vector(*sums);
                let closure = PatchClosure {
                    form_factor_sum: given.x,
                    escaped: given.y,
                };
                to_result(closure.link_scale(*conserve == 1))
            }),
        },
        CheckedFunction {
            function: "is_low",
            transport: *transport,
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
            transport: *transport,
            arguments: squared_distances(),
            twin: Box::new(|arguments| {
                let given = to_vector(arguments[0]);
                to_result(to_number(is_remote(given.x, given.y)))
            }),
        },
    ];
    checked.extend(sampling_functions(mesh, transport));
    if let Some(drawing) = transport.visibility.item_buffer() {
        checked.extend(projection_functions(transport, drawing.size));
        checked.push(CheckedFunction {
            function: "edge_distance",
            transport: *transport,
            arguments: image_edges(),
            twin: Box::new(|arguments| {
                let [a, b, ..] = arguments.map(|words| to_vector(words).truncate());
                to_result(edge_distance(a, b))
            }),
        });
    }
    check_functions(&checked, (gpu, faults)).await
}

/// Returns the functions that place sample points on texels.
fn sampling_functions<'a>(mesh: &'a Mesh, transport: &Transport) -> [CheckedFunction<'a>; 3] {
    [
        CheckedFunction {
            function: "texel_uv",
            transport: *transport,
            arguments: sample_numbers(),
            twin: Box::new(|[[s, texel, patch, _], ..]| {
                let [u, v] = texel_uv(*s, *texel, *patch);
                Vec4::new(u, v, 0.0, 0.0)
            }),
        },
        CheckedFunction {
            function: "near_point_uv",
            transport: *transport,
            arguments: near_places(),
            twin: Box::new(|[[place, kind, ..], ..]| {
                let [u, v] = near_point_uv(*place, TEXEL_KINDS[*kind as usize]);
                Vec4::new(u, v, 0.0, 0.0)
            }),
        },
        CheckedFunction {
            function: "point_on_texel",
            transport: *transport,
            arguments: texel_points(),
            twin: Box::new(|[a, b, c, d, [w, h, i, j], [kind, area, u, v], ..]| {
                let face = MeshFace {
                    corners: [a, b, c, d].map(|corner| to_vector(*corner).truncate()),
                    resolution: [*w, *h],
                    ..mesh.faces[0]
                };
                let [area, u, v] = [area, u, v].map(|bits| f32::from_bits(*bits));
                point_on_texel(&face, TEXEL_KINDS[*kind as usize], [*i, *j], area, [u, v])
            }),
        },
    ]
}

/// Returns the functions of projections to images of this size, each by all projections: a file of them is judged whichever
/// projection the solver uses.
fn projection_functions(transport: &Transport, size: u32) -> Vec<CheckedFunction<'static>> {
    let by = |projection| Transport {
        visibility: Visibility::with_item_buffer(projection, size),
        ..*transport
    };
    let mut checked = Vec::new();
    for projection in ItemBufferProjection::ALL_PROJECTIONS {
        checked.push(CheckedFunction {
            function: "project_direction",
            transport: by(projection),
            arguments: projected_directions(projection),
            twin: Box::new(move |arguments| {
                let image = project_direction(projection, to_vector(arguments[0]).truncate());
                image.extend(0.0).extend(0.0)
            }),
        });
        checked.push(CheckedFunction {
            function: "unproject_point",
            transport: by(projection),
            arguments: image_points(),
            twin: Box::new(move |arguments| {
                let point = to_vector(arguments[0]).truncate().truncate();
                let covered = is_covered(projection, point, size);
                unproject_point(projection, point).extend(to_number(covered))
            }),
        });
        checked.push(CheckedFunction {
            function: "side_extent",
            transport: by(projection),
            arguments: (0..projection.plane_count())
                .map(|side| with_words([side, 0, 0, 0]))
                .collect(),
            twin: Box::new(move |arguments| side_extent(projection, arguments[0][0], size)),
        });
    }
    for projection in [ItemBufferProjection::Hemisphere, ItemBufferProjection::Stereographic] {
        checked.push(CheckedFunction {
            function: "bound_arc",
            transport: by(projection),
            arguments: bounded_arcs(),
            twin: Box::new(move |[limits, a, b, ..]| {
                let [limits, a, b] = [limits, a, b].map(|words| to_vector(*words));
                bound_arc(projection, limits, a.truncate(), b.truncate(), b.w)
            }),
        });
    }
    checked.push(CheckedFunction {
        function: "bound_corner",
        transport: by(ItemBufferProjection::Hemicube),
        arguments: bounded_corners(),
        twin: Box::new(|[limits, [side, ..], corner, ..]| {
            let [limits, corner] = [limits, corner].map(|words| to_vector(*words));
            bound_corner(limits, *side, corner.truncate(), corner.w)
        }),
    });
    // A function's calls lie side by side.
    checked.sort_by_key(|checked| checked.function);
    checked
}

/// Checks the functions that only links between nodes call.
///
/// Errors: the device fails.
pub fn check_link_functions(gpu: &Gpu, faults: &[ShaderFault]) -> Result<Vec<StageCheck>> {
    let transport = Transport::default();
    let counts = CheckedFunction {
        function: "receiver_points_per_side",
        transport,
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
        transport,
        // Rounding may make a share larger than 1.
        arguments: [0.0, 0.25, 0.5, 1.0, 1.0 + f32::EPSILON]
            .map(|seen| with_numbers([[seen, 0.0, 0.0, 0.0]]))
            .to_vec(),
        twin: Box::new(|arguments| to_result(visibility_deviation(to_vector(arguments[0]).x))),
    };
    let points = CheckedFunction {
        function: "spot_point",
        transport,
        arguments: spot_points(),
        twin: Box::new(|arguments| {
            let [a, b, c, d, uv, ..] = arguments.map(|words| to_vector(words).truncate());
            let (point, weight) = spot_point([a, b, c, d], c == d, [uv.x, uv.y]);
            point.extend(weight)
        }),
    };
    let node_points = CheckedFunction {
        function: "outline_point",
        transport,
        arguments: spot_points(),
        twin: Box::new(|arguments| {
            let [a, b, c, d, uv, ..] = arguments.map(|words| to_vector(words).truncate());
            outline_point(&[a, b, c, d], [uv.x, uv.y])
        }),
    };
    pollster::block_on(check_functions(
        &[points, node_points, counts, deviations],
        (gpu, faults),
    ))
}

/// Checks functions; calls of one function that follow each other are one check.
async fn check_functions(
    checked: &[CheckedFunction<'_>],
    (gpu, faults): (&Gpu, &[ShaderFault]),
) -> Result<Vec<StageCheck>> {
    let mut checks = Vec::new();
    for same in checked.chunk_by(|a, b| a.function == b.function) {
        let function = same[0].function;
        let elements = Elements {
            name: "call",
            count: same.iter().map(|checked| checked.arguments.len()).sum(),
            lanes: PATCH_SUM_LANES,
        };
        let mut tally = ErrorTally::new(function, (MAX_CALL_ULPS, CALL_REASON), elements, &RESULT_VALUES);
        let mut first = 0;
        for CheckedFunction {
            transport,
            arguments,
            twin,
            ..
        } in same
        {
            let found = match FunctionCall::find(function) {
                Some(call) => {
                    let mut caller = FunctionCaller::new(gpu, transport, faults);
                    caller.request_results(call, arguments).await?
                }
                None => None,
            };
            for (k, (arguments, found)) in arguments.iter().zip(found.into_iter().flatten()).enumerate() {
                let twin = twin(arguments);
                for n in 0..4 {
                    tally.add_ulps(ValueSource::default(), [first + k, n], [found[n], twin[n]], RESULT_SIZE);
                }
            }
            first += arguments.len();
        }
        let calls: Vec<&CallArguments> = same.iter().flat_map(|checked| &checked.arguments).collect();
        if tally.values() > 0 {
            checks.push(tally.named_check(|compared| {
                let value = RESULT_VALUES[compared.component];
                format!("{value} of {function}({})", describe_arguments(calls[compared.element]))
            }));
        }
    }
    Ok(checks)
}

/// Lists the arguments of a call without the zeros at their end, vectors in brackets. Words that are no common numbers are
/// integers.
fn describe_arguments(arguments: &CallArguments) -> String {
    let count = arguments
        .iter()
        .rposition(|words| *words != [0; 4])
        .map_or(1, |last| last + 1);
    let describe_word = |word: &u32| match f32::from_bits(*word) {
        number if number.is_normal() && number.abs() < 1e10 => number.to_string(),
        _ => word.to_string(),
    };
    let vectors = arguments[..count].iter().map(|words| {
        let words: Vec<String> = words.iter().map(describe_word).collect();
        format!("[{}]", words.join(", "))
    });
    vectors.collect::<Vec<String>>().join(", ")
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

/// Returns the arguments of a call: these words, then zeros.
fn with_words(words: [u32; 4]) -> CallArguments {
    let mut arguments = [[0; 4]; ARGUMENT_COUNT];
    arguments[0] = words;
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
    numbers.map(with_words).to_vec()
}

/// Returns sums of form factors, none and above 1 among them, with escaped shares; whether they are to be closed comes first.
fn closure_arguments() -> Vec<CallArguments> {
    let sums = [[0.0, 0.0], [0.5, 0.25], [0.75, 0.0], [1.5, 0.125]];
    let with_choice = |[sum, escaped]: [f32; 2]| {
        [0, 1].map(|conserve| {
            let mut arguments = with_numbers([[0.0; 4], [sum, escaped, 0.0, 0.0]]);
            arguments[0][0] = conserve;
            arguments
        })
    };
    sums.into_iter().flat_map(with_choice).collect()
}

/// Returns corners on each side of a hemicube that enlarge a bound at one end or the other, with the distance of their edge.
fn bounded_corners() -> Vec<CallArguments> {
    let limits = [[9.0, 9.0, -9.0, -9.0], [0.0, 0.0, 0.25, 0.25]];
    let corners = [
        [0.5, 0.25, 1.0, 0.001],
        [-0.5, -1.0, 0.5, 0.002],
        [1.0, -0.25, 0.5, 0.001],
    ];
    let mut calls = Vec::new();
    for side in 0..ItemBufferProjection::Hemicube.plane_count() {
        for (limits, corner) in limits.iter().flat_map(|limits| corners.map(|corner| (*limits, corner))) {
            let mut arguments = with_numbers([limits, [0.0; 4], corner]);
            arguments[1][0] = side;
            // A corner below the plane of a side is cut off before.
            let given = Vec4::from_array(corner);
            if side_height(side, given.truncate()) > 0.0 {
                calls.push(arguments);
            }
        }
    }
    calls
}

/// Returns edges whose ends are near each other, a right angle or more apart, and nearly opposite each other.
fn bounded_arcs() -> Vec<CallArguments> {
    let limits = [9.0, 9.0, -9.0, -9.0];
    let edges = [
        [[2.0, 0.0, 1.0, 0.0], [2.0, 0.125, 1.0, 0.001]],
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]],
        [[0.5, 0.25, 1.0, 0.0], [1.0, -2.0, 0.25, 0.002]],
        [[-3.0, 0.25, 0.5, 0.0], [3.0, 0.5, 0.25, 0.001]],
        [[-16.0, 0.5, 0.5, 0.0], [16.0, 0.25, 0.0, 0.001]],
        [[-64.0, 0.5, 0.5, 0.0], [64.0, 0.25, 0.0, 0.001]],
    ];
    edges.map(|[a, b]| with_numbers([limits, a, b])).to_vec()
}

/// Returns points on both sides of a plane within the distance of contact, at it and beyond.
fn points_at_plane() -> Vec<CallArguments> {
    let plane = [0.0, 0.0, 1.0, 0.0];
    let heights = [0.0, 0.5, 1.0, 1.5, 4.0]
        .into_iter()
        .flat_map(|factor| [factor, -factor]);
    heights
        .map(|factor| with_numbers([plane, [0.25, 0.5, factor * CONTACT_DISTANCE, 0.0]]))
        .collect()
}

/// Returns all places of the grid of a near texel, of each kind.
fn near_places() -> Vec<CallArguments> {
    let places = 0..NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE;
    places
        .flat_map(|place| (0..3).map(move |kind| with_words([place, kind, 0, 0])))
        .collect()
}

/// Returns points of the square of an image: in its middle, on each side of a hemicube, in a corner, and on the rim of a disc.
fn image_points() -> Vec<CallArguments> {
    let points = [
        [0.25, -0.125],
        [0.75, 0.25],
        [-0.75, 0.25],
        [0.25, 0.75],
        [0.25, -0.75],
        [0.625, 0.625],
        [-0.875, 0.875],
        [1.0, 0.0],
    ];
    points.map(|[x, y]| with_numbers([[x, y, 0.0, 0.0]])).to_vec()
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
