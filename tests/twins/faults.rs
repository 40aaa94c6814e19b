//! The harness can fail: each planted fault turns the verdict red, and without one it is green.

use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{Meshing, Projection, Schedule, Settings, Transport, Visibility};
use gpu::{Fault, Gpu};
use oracle::judge::compare::difference::difference;
use oracle::judge::compare::{Request, compare};
use oracle::judge::comparison::{Comparison, Gate};
use oracle::solve::watch::unwatched;
use radiosity_tests::engines::drawn;
use radiosity_tests::{box_in_room, furnace};

fn verdict(texels: u32, faults: &[Fault]) -> Comparison {
    judged(drawn(512), texels, faults)
}

fn judged(visibility: Visibility, texels: u32, faults: &[Fault]) -> Comparison {
    of(&box_in_room(), visibility, texels, faults)
}

fn of(scene: &Scene, visibility: Visibility, texels: u32, faults: &[Fault]) -> Comparison {
    let settings = Settings {
        meshing: Meshing {
            texels,
            cells: 1,
            ..Meshing::default()
        },
        transport: Transport {
            visibility,
            form_factor: FormFactor::Disc,
            ..Transport::default()
        },
        schedule: Schedule {
            epsilon: 0.02,
            // A kept residual never ends.
            max_shots: 200,
            ..Schedule::default()
        },
        ..Settings::default()
    };
    let gpu = Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh");
    let request = Request {
        settings,
        gpu: &gpu,
        faults,
    };
    compare(scene, &request, &unwatched()).unwrap()
}

fn failing(comparison: &Comparison) -> Vec<&str> {
    comparison
        .gates
        .iter()
        .filter(|gate| !gate.pass)
        .map(|gate| gate.name.as_str())
        .collect()
}

fn caught(name: &str, faults: &[Fault]) {
    // Enough texels that some lie where one pixel decides.
    let texels = if faults.iter().any(|fault| fault.from.contains("p.x")) {
        32
    } else {
        8
    };
    let comparison = verdict(texels, faults);
    println!("{name}: {:?}", failing(&comparison));
    assert!(!comparison.agree(), "{name} was not noticed");
}

#[test]
fn without_a_fault_the_solvers_agree() {
    let comparison = verdict(8, &[]);
    assert!(comparison.agree(), "{:?}", failing(&comparison));
}

#[test]
fn faults_in_the_form_factor() {
    let disc = "return disc(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);";
    let fault = |to| {
        [Fault {
            file: "form_factor",
            from: disc,
            to,
        }]
    };
    caught(
        "a dropped cosine",
        &fault("return disc(cos_i, 1.0, r2, shots[slot].area, shots[slot].area);"),
    );
    caught(
        "swapped areas",
        &fault("return disc(cos_i, cos_j, r2, texel_area, texel_area);"),
    );
    caught(
        "a flipped normal",
        &[Fault {
            file: "aim",
            from: "shots[slot].normal = faces[face].plane.xyz;",
            to: "shots[slot].normal = -faces[face].plane.xyz;",
        }],
    );
}

#[test]
fn faults_in_the_deposit() {
    let fault = |from, to| {
        [Fault {
            file: "deposit",
            from,
            to,
        }]
    };
    caught(
        "a dropped reflectance",
        &fault("texels[k].reflectance * received;", "received;"),
    );
    caught("a kept residual", &fault("residual[k] = vec4f(0.0);", ""));
    caught(
        "zeros",
        &fault(
            "radiosity[k] += vec4f(reflected, 0.0);",
            "radiosity[k] = vec4f(0.0);",
        ),
    );
    caught(
        "NaN",
        &fault("shot.radiosity * f;", "shot.radiosity * (f / (f - f));"),
    );
}

#[test]
fn faults_in_the_item_buffer() {
    caught(
        "a lookup one pixel off",
        &[Fault {
            file: "lookup",
            from: "clamp(i32(floor(p.x)), 0, last)",
            to: "clamp(i32(floor(p.x)) + 1, 0, last)",
        }],
    );
    caught(
        "a raster one pixel off",
        &[Fault {
            file: "item_buffer",
            from: "pixel_centre(pixel.x, ",
            to: "pixel_centre(pixel.x + 1u, ",
        }],
    );
}

#[test]
fn faults_in_the_hemicube() {
    let comparison = judged(Visibility::drawn(Projection::Hemicube, 512), 8, &[]);
    assert!(comparison.agree(), "{:?}", failing(&comparison));
    let faults = [
        (
            "hemicube",
            "select(2u, 1u, p.x >= 0.0)",
            "select(1u, 2u, p.x >= 0.0)",
        ),
        (
            "hemicube",
            "select(-1.0, 1.0, (side",
            "select(1.0, -1.0, (side",
        ),
        (
            "item_buffer",
            "index / 6u % SIDES",
            "index / 6u % (SIDES - 1u)",
        ),
        ("item_buffer", "place(side, p)", "place(side, p.yx)"),
        // Sides are planes: their bounds are tight.
        ("bound", "limits.xy - pixel", "limits.xy + pixel"),
        ("bound", "limits.zw + pixel", "limits.zw - pixel"),
        ("projection", "v.z >= max(", "v.z >= 2.0 * max("),
    ];
    for (file, from, to) in faults {
        let comparison = judged(
            Visibility::drawn(Projection::Hemicube, 512),
            8,
            &[Fault { file, from, to }],
        );
        println!("{file}, {to}: {:?}", failing(&comparison));
        assert!(!comparison.agree(), "{file}, {to} was not noticed");
    }
}

#[test]
fn a_tie_that_goes_to_the_highest() {
    caught(
        "a tie to the highest",
        &[
            Fault {
                file: "select",
                from: "if power > best {",
                to: "if power >= best {",
            },
            Fault {
                file: "select",
                from: "other < lane_cell[lane]",
                to: "other > lane_cell[lane]",
            },
        ],
    );
}

#[test]
fn a_field_compared_with_itself() {
    let comparison = verdict(8, &[]);
    let field = &comparison.cpu.field;
    let same = difference(&comparison.mesh, field, field);
    assert!(!Gate::at_most("identical", same.relative_rms, 1.0, "").pass);
    let mut empty = field.clone();
    empty.origin = "empty".into();
    empty.radiosity.clear();
    assert!(
        difference(&comparison.mesh, &empty, field)
            .relative_rms
            .is_nan()
    );
    let mut zero = field.clone();
    zero.origin = "zero".into();
    zero.radiosity
        .iter_mut()
        .for_each(|b| *b = glam::Vec4::ZERO);
    assert!(difference(&comparison.mesh, &zero, field).relative_rms > 0.5);
}

#[test]
fn a_thousandth_of_the_energy_is_missed() {
    let fault = Fault {
        file: "deposit",
        from: "irradiance[k].xyz + received, f)",
        to: "irradiance[k].xyz + received * 1.001, f)",
    };
    let comparison = verdict(8, &[fault]);
    let failing = failing(&comparison);
    assert!(failing.contains(&"energy imbalance, GPU"), "{failing:?}");
    assert!(!failing.contains(&"energy imbalance, CPU"), "{failing:?}");
}

/// What pixels may err by follows from the scene: where no texel lies near a silhouette it is rounding.
#[test]
fn without_silhouettes_nothing_is_allowed() {
    let comparison = of(&furnace(0.5), drawn(512), 4, &[]);
    assert!(comparison.agree(), "{:?}", failing(&comparison));
    assert_eq!(comparison.pairs.explainable, 0);
    let bound = |name: &str| {
        let gate = comparison.gates.iter().find(|gate| gate.name == name);
        gate.unwrap_or_else(|| panic!("{name}")).bound
    };
    assert_eq!(bound("visibility: mismatched share"), 0.0);
    assert!(bound("lockstep: relative RMS") < 1e-4);
    // ε = 2 % is left unshot by either, and reflected by half.
    assert!(bound("free: relative RMS") < 0.1);
}

/// The bound on radiosity is not so wide that it allows anything.
#[test]
fn what_silhouettes_could_bring_is_of_the_size_of_what_they_bring() {
    let comparison = verdict(16, &[]);
    let gate = |name: &str| {
        let gate = comparison.gates.iter().find(|gate| gate.name == name);
        gate.unwrap_or_else(|| panic!("{name}"))
    };
    let lockstep = gate("lockstep: relative RMS");
    println!("{:.3e} of {:.3e}", lockstep.value, lockstep.bound);
    assert!(lockstep.value <= lockstep.bound && lockstep.bound < 0.1);
}
