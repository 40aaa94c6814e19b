//! Relighting held to the full solution, and to what can be worked out by hand.

use common::energy::Energy;
use common::form_factor::form_factor;
use common::import::{ImportOptions, load};
use common::mesh::Mesh;
use common::relight::{Mended, Method, Relit, Room, relight};
use common::scene::{Face, Scene};
use common::settings::{Settings, Visibility};
use common::shooting::{Engine, Field};
use cpu::CpuSolver;
use cpu::cover::furnished;
use glam::{DVec3, Vec3, Vec4};
use gpu::{Fault, Gpu, GpuSolver};
use radiosity_tests::engines::{free, gpu};
use radiosity_tests::{lit_room, room, scene};
use std::ops::ControlFlow;
use std::path::Path;

const ALL: [Visibility; 5] = [
    Visibility::Rays,
    Visibility::Paper,
    Visibility::Hemisphere,
    Visibility::Stereographic,
    Visibility::Hemicube,
];

fn settings(visibility: Visibility) -> Settings {
    Settings {
        texels: 4,
        cells: 2,
        samples: 2,
        epsilon: 1e-4,
        item_buffer: 256,
        visibility,
        ..Settings::default()
    }
}

/// The lit room with its box as part of the room, and a second one as the object: it stands on the
/// floor, half on a cell.
fn furnished_room(objects: Vec<Face>) -> (Scene, usize) {
    let mut scene = lit_room();
    let count = scene.faces.len();
    scene.faces.extend(objects);
    (scene, count)
}

fn cube(emission: Vec3, reflectance: Vec3) -> Vec<Face> {
    let (low, high) = (DVec3::new(1.7, 0.0, 1.6), DVec3::new(2.3, 0.8, 2.7));
    let mut faces = room(low, high, false, emission, reflectance);
    // A body without a bottom stands on the floor.
    faces.remove(0);
    faces
}

fn mesh_of(scene: &Scene, count: usize, settings: &Settings) -> Mesh {
    let resolutions = vec![[settings.texels; 2]; scene.faces.len()];
    furnished(scene, count, &resolutions, settings).unwrap()
}

type Maker<'m> = dyn Fn(&'m Mesh, &Settings) -> Box<dyn Engine + 'm>;

fn on_cpu<'m>(mesh: &'m Mesh, settings: &Settings) -> Box<dyn Engine + 'm> {
    Box::new(CpuSolver::new(mesh, settings))
}

fn on_gpu<'m>(gpu: &Gpu) -> impl Fn(&'m Mesh, &Settings) -> Box<dyn Engine + 'm> {
    let gpu = gpu.clone();
    move |mesh, settings| Box::new(GpuSolver::new(&gpu, mesh, settings).unwrap())
}

/// The empty room solved on the texels that `mesh` has of it.
fn capture(scene: &Scene, mesh: &Mesh, settings: &Settings, epsilon: f64) -> Room {
    let empty = Scene {
        faces: scene.faces[..mesh.room as usize].to_vec(),
        ..scene.clone()
    };
    let room = mesh_of(&empty, empty.faces.len(), settings);
    let settings = Settings {
        epsilon,
        ..settings.clone()
    };
    let field = free(&mut CpuSolver::new(&room, &settings), &settings).field;
    let fill = |values: &[Vec4]| -> Vec<Vec4> {
        let mut all = vec![Vec4::ZERO; mesh.texels.len()];
        all[..values.len()].copy_from_slice(values);
        all
    };
    Room {
        radiosity: fill(&field.radiosity),
        residual: fill(&field.residual),
        reflectance: Some(mesh.texels.iter().map(|t| t.reflectance).collect()),
    }
}

fn run(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    room: &Room,
    method: Method,
    settings: &Settings,
) -> Relit {
    relight(engine, mesh, room, method, settings, &mut |_, _| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// √(ΣA(a − b)²/ΣA b²) of B − E, the worst channel.
fn error(mesh: &Mesh, a: &Field, b: &Field) -> f64 {
    let (mut square, mut scale) = (DVec3::ZERO, DVec3::ZERO);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let area = f64::from(texel.area);
        let reflected = |f: &Field| (f.radiosity[k].truncate() - texel.emission).as_dvec3();
        square += (reflected(a) - reflected(b)).powf(2.0) * area;
        scale += reflected(b).powf(2.0) * area;
    }
    (square / scale).max_element().sqrt()
}

/// The mesh as the relit room has it.
fn with_surface(mesh: &Mesh, relit: &Relit) -> Mesh {
    let mut mesh = mesh.clone();
    for (k, texel) in mesh.texels.iter_mut().enumerate() {
        texel.reflectance = relit.surface.reflectance[k];
        texel.emission = relit.surface.emission[k];
    }
    mesh
}

fn full(mesh: &Mesh, settings: &Settings) -> Field {
    let mut mesh = mesh.clone();
    mesh.room = mesh.faces.len() as u32;
    free(&mut CpuSolver::new(&mesh, settings), settings).field
}

#[test]
fn nothing_inserted_changes_nothing() {
    let gpu = gpu();
    for visibility in ALL {
        let settings = settings(visibility);
        let (scene, count) = furnished_room(Vec::new());
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-2);
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            for method in [
                Method::Signed,
                Method::Paper(Mended {
                    empty_room: true,
                    ..Mended::default()
                }),
            ] {
                let mut engine = make(&mesh, &settings);
                let relit = run(engine.as_mut(), &mesh, &room, method, &settings);
                let worst = relit.change.radiosity.iter().position(|d| *d != Vec4::ZERO);
                assert!(
                    worst.is_none(),
                    "{visibility:?} {} {worst:?} {:?}",
                    relit.run.field.origin,
                    relit.change.radiosity[worst.unwrap()]
                );
                assert_eq!(relit.run.field.radiosity, room.radiosity);
                assert!(relit.run.converged && relit.object_shots == 0 && relit.map_shots > 0);
            }
        }
    }
}

#[test]
fn signed_is_the_full_solution() {
    let gpu = gpu();
    for visibility in [Visibility::Rays, Visibility::Stereographic] {
        let settings = settings(visibility);
        let (scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::new(0.2, 0.5, 0.8)));
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-2);
        let truth = full(
            &mesh,
            &Settings {
                epsilon: 1e-6,
                ..settings.clone()
            },
        );
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            let mut engine = make(&mesh, &settings);
            let relit = run(engine.as_mut(), &mesh, &room, Method::Signed, &settings);
            let error = error(&mesh, &relit.run.field, &truth);
            let energy = Energy::new(
                &with_surface(&mesh, &relit),
                &relit.run.field,
                &relit.run.shots,
            );
            println!(
                "{visibility:?}: {error:.2e}, imbalance {:.1e}, {} + {} shots",
                energy.imbalance, relit.map_shots, relit.object_shots
            );
            assert!(error < 1e-3, "{visibility:?}: {error}");
            assert!(energy.imbalance < 1e-4, "{energy:?}");
        }
    }
}

/// The paper's room with its objects, whole faces as the paper shot them; tight enough that what is
/// left unshot on both sides is well below the bound.
#[test]
fn signed_is_the_full_solution_in_the_paper_s_room() {
    let bundled = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../scenes")
            .join(name);
        load(&path, &ImportOptions::default()).unwrap()
    };
    let mut scene = bundled("paper_room.obj");
    let count = scene.faces.len();
    scene.faces.extend(bundled("paper_objects.obj").faces);
    let gpu = gpu();
    for visibility in [Visibility::Rays, Visibility::Stereographic] {
        let settings = Settings {
            texels: 8,
            cells: 1,
            samples: 1,
            item_buffer: 512,
            ..settings(visibility)
        };
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-4);
        let truth = full(&mesh, &settings);
        let mut printed = f64::NAN;
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            let relit = run(
                make(&mesh, &settings).as_mut(),
                &mesh,
                &room,
                Method::Signed,
                &settings,
            );
            let paper = Method::Paper(Mended::default());
            let table_2 = run(
                make(&mesh, &settings).as_mut(),
                &mesh,
                &room,
                paper,
                &settings,
            );
            let of = |relit: &Relit| {
                let energy = Energy::new(
                    &with_surface(&mesh, relit),
                    &relit.run.field,
                    &relit.run.shots,
                );
                (
                    error(&mesh, &relit.run.field, &truth),
                    energy.imbalance,
                    energy.share(energy.closure),
                )
            };
            let (signed, table_2) = (of(&relit), of(&table_2));
            println!(
                "{visibility:?} {}: signed {:.4} % of error, imbalance {:.1e}, closure {:.2} %, {} + {} shots; Table 2 {:.1} %, {:.2}",
                relit.run.field.origin,
                100.0 * signed.0,
                signed.1,
                100.0 * signed.2,
                relit.map_shots,
                relit.object_shots,
                100.0 * table_2.0,
                table_2.1
            );
            assert!(signed.0 < 1e-3 && signed.1 < 1e-4, "{signed:?}");
            assert!(table_2.0 > 0.05 && table_2.1 > 0.01, "{table_2:?}");
            // Two solvers, one answer.
            assert!(printed.is_nan() || (printed - table_2.0).abs() < 0.01);
            printed = table_2.0;
        }
    }
}

#[test]
fn a_black_object_only_darkens() {
    let gpu = gpu();
    for visibility in [Visibility::Rays, Visibility::Stereographic] {
        let settings = Settings {
            cells: 4,
            ..settings(visibility)
        };
        // It covers one cell of the floor: of one that it cut, the light would leave from whichever
        // of its points are open, which is noise that may brighten.
        let (low, high) = (DVec3::new(1.5, 0.0, 2.0), DVec3::new(2.25, 0.8, 3.0));
        let (scene, count) = furnished_room(room(low, high, false, Vec3::ZERO, Vec3::ZERO));
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-6);
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            let mut engine = make(&mesh, &settings);
            let relit = run(engine.as_mut(), &mesh, &room, Method::Signed, &settings);
            // What is still unshot may land anywhere: at most all of it on one texel.
            let unshot: f64 = relit.run.unshot_fraction() * f64::from(relit.run.emitted);
            let mut darkest = 0.0f32;
            for (k, texel) in mesh.texels.iter().enumerate() {
                if mesh.is_object(texel.face) {
                    assert_eq!(relit.run.field.radiosity[k], Vec4::ZERO);
                    continue;
                }
                let change = relit.change.radiosity[k];
                let bound = unshot as f32 / texel.area;
                assert!(change.max_element() <= bound, "{change} beyond {bound}");
                assert!(relit.run.field.radiosity[k].min_element() >= -bound);
                darkest = darkest.min(change.min_element());
            }
            assert!(darkest < -0.1, "no shadow: {darkest}");
        }
    }
}

#[test]
fn table_2_with_all_its_flaws_mended_is_signed() {
    let settings = settings(Visibility::Rays);
    let (scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::splat(0.7)));
    let mesh = mesh_of(&scene, count, &settings);
    let room = capture(&scene, &mesh, &settings, 1e-6);
    let truth = full(
        &mesh,
        &Settings {
            epsilon: 1e-6,
            ..settings.clone()
        },
    );
    let of = |method| {
        run(
            &mut CpuSolver::new(&mesh, &settings),
            &mesh,
            &room,
            method,
            &settings,
        )
    };
    let all = Mended {
        empty_room: true,
        object_shadows: true,
        bleeding: true,
        shadows: true,
    };
    let (signed, mended) = (of(Method::Signed), of(Method::Paper(all)));
    assert_eq!(signed.run.field.radiosity, mended.run.field.radiosity);
    let error_of = |mended| error(&mesh, &of(Method::Paper(mended)).run.field, &truth);
    let steps = [
        Mended::default(),
        Mended {
            empty_room: true,
            ..Mended::default()
        },
        Mended {
            shadows: false,
            ..all
        },
        all,
    ];
    let errors = steps.map(error_of);
    println!(
        "printed {:.3}, empty room {:.3}, without shadows shot on {:.3}, all {:.5}",
        errors[0], errors[1], errors[2], errors[3]
    );
    assert!(
        errors[0] > 0.02 && errors.is_sorted_by(|a, b| a > b),
        "{errors:?}"
    );
}

/// Fig. 7: a lit plate above a floor of the room and one of an object, an object between. Case A: a
/// texel of the object that is hidden gets nothing. Case B: a texel of the room that is hidden loses
/// what it had, ρB₀F.
#[test]
fn the_two_cases_of_figure_7() {
    let quad = |name, low: [f64; 2], high: [f64; 2], y, up: bool| {
        let p = |x, z| DVec3::new(x, y, z);
        let face = Face::quad(
            name,
            [
                p(low[0], low[1]),
                p(low[0], high[1]),
                p(high[0], high[1]),
                p(high[0], low[1]),
            ],
            Vec3::ZERO,
            Vec3::splat(0.5),
        );
        if up { face } else { face.reversed() }
    };
    let lamp = quad("i", [0.0, 0.0], [1.0, 1.0], 1.0, false);
    let floor = quad("c", [0.0, 0.0], [1.0, 1.0], 0.0, true);
    // The blocker is as large as both plates and in the middle: it hides all of the floor.
    let blocker = quad("a", [-1.0, -1.0], [2.0, 2.0], 0.5, true);
    let below = quad("b", [0.0, 0.0], [1.0, 1.0], 0.25, true);
    let scene = scene("figure 7", vec![lamp, floor, blocker, below]);
    let gpu = gpu();
    for visibility in [Visibility::Rays, Visibility::Stereographic] {
        let settings = Settings {
            texels: 1,
            cells: 1,
            samples: 1,
            ..settings(visibility)
        };
        let mesh = mesh_of(&scene, 2, &settings);
        let (lit, captured) = (8.0f32, 3.0f32);
        let mut radiosity = vec![Vec4::ZERO; 4];
        radiosity[0] = Vec4::new(lit, lit, lit, 0.0);
        radiosity[1] = Vec4::new(captured, captured, captured, 0.0);
        let room = Room {
            radiosity,
            residual: vec![Vec4::ZERO; 4],
            reflectance: Some(vec![Vec3::splat(0.5); 4]),
        };
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            let mut engine = make(&mesh, &settings);
            let paper = Method::Paper(Mended::default());
            let relit = run(engine.as_mut(), &mesh, &room, paper, &settings);
            let (floor, texel) = (&mesh.cells[0].shooter, &mesh.texels[1]);
            let f = form_factor(
                settings.form_factor,
                floor,
                texel.position,
                mesh.faces[1].normal,
                texel.area,
            );
            assert!(f > 0.2);
            // Case B: exactly ρB₀F; δ is that number, negative.
            assert_eq!(
                relit.change.radiosity[1].x,
                -(0.5 * (lit * f)),
                "{visibility:?}"
            );
            // Case A: nothing of the lamp's; the floor's own light is hidden from its back as well.
            assert_eq!(relit.run.field.radiosity[3], Vec4::ZERO);
            assert_eq!(relit.run.field.irradiance[3].truncate(), Vec3::ZERO);
            // And the blocker's lit side is lit.
            assert!(relit.run.field.radiosity[2].x > 1.0);
        }
    }
}

#[test]
fn cpu_and_gpu_relight_alike() {
    let settings = settings(Visibility::Rays);
    let (scene, count) = furnished_room(cube(Vec3::new(1.0, 0.5, 0.0), Vec3::splat(0.5)));
    let mesh = mesh_of(&scene, count, &settings);
    let room = capture(&scene, &mesh, &settings, 1e-4);
    for method in [Method::Signed, Method::Paper(Mended::default())] {
        let cpu = run(
            &mut CpuSolver::new(&mesh, &settings),
            &mesh,
            &room,
            method,
            &settings,
        );
        let mut solver = GpuSolver::new(&gpu(), &mesh, &settings).unwrap();
        let gpu = run(&mut solver, &mesh, &room, method, &settings);
        assert_ne!(cpu.run.field.origin, gpu.run.field.origin);
        let apart = error(&mesh, &gpu.run.field, &cpu.run.field);
        println!(
            "{method:?}: {apart:.1e}, shots {} and {}",
            cpu.run.shots.len(),
            gpu.run.shots.len()
        );
        // Rounding of a few hundred shots, and one more or less of them.
        assert!(apart < settings.epsilon, "{method:?}: {apart}");
        assert!(cpu.run.shots.len().abs_diff(gpu.run.shots.len()) <= 2);
    }
}

/// Light under a body is lost, whether it stands on a lamp of the room or on captured light.
#[test]
fn a_body_on_a_lamp_buries_its_light() {
    let settings = Settings {
        samples: 16,
        ..settings(Visibility::Rays)
    };
    let (mut scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::splat(0.5)));
    scene.faces[0].emission = Vec3::splat(2.0);
    let mesh = mesh_of(&scene, count, &settings);
    assert!(
        mesh.cells
            .iter()
            .any(|c| c.open < 1.0 && c.open > 0.0 && c.open_before == 1.0)
    );
    let room = capture(&scene, &mesh, &settings, 1e-5);
    let relit = run(
        &mut CpuSolver::new(&mesh, &settings),
        &mesh,
        &room,
        Method::Signed,
        &settings,
    );
    let truth = full(
        &mesh,
        &Settings {
            epsilon: 1e-6,
            ..settings.clone()
        },
    );
    let error = error(&mesh, &relit.run.field, &truth);
    let energy = Energy::new(
        &with_surface(&mesh, &relit),
        &relit.run.field,
        &relit.run.shots,
    );
    println!("{error:.2e} {energy:?}");
    assert!(error < 1e-3 && energy.imbalance < 1e-4);
    assert!(energy.share(energy.escaped) > 0.01, "{energy:?}");
}

#[test]
fn walls_are_told_from_their_own_light() {
    let settings = Settings {
        texels: 8,
        cells: 8,
        samples: 4,
        ..settings(Visibility::Rays)
    };
    let (scene, count) = furnished_room(Vec::new());
    let mesh = mesh_of(&scene, count, &settings);
    let known = capture(&scene, &mesh, &settings, 1e-6);
    let room = Room {
        residual: vec![Vec4::ZERO; mesh.texels.len()],
        reflectance: None,
        ..known.clone()
    };
    let relit = run(
        &mut CpuSolver::new(&mesh, &settings),
        &mesh,
        &room,
        Method::Signed,
        &settings,
    );
    let surface = &relit.surface;
    for (k, texel) in mesh.texels.iter().enumerate() {
        // The ceiling is the lamp.
        assert_eq!(
            surface.emitters.contains(&(k as u32)),
            texel.face == 1,
            "{k}"
        );
        let h = relit.run.field.irradiance[k].truncate();
        let b = surface.emission[k] + surface.reflectance[k] * h;
        let apart = (b - room.radiosity[k].truncate()).abs().max_element();
        assert!(apart <= 4.0 * f32::EPSILON * b.max_element(), "{k}");
        if texel.face != 1 {
            let error = (surface.reflectance[k] - texel.reflectance)
                .abs()
                .max_element();
            assert!(
                error < 1e-4,
                "{k}: {} for {}",
                surface.reflectance[k],
                texel.reflectance
            );
        }
    }
}

#[test]
fn nothing_is_seen_that_was_not_seen_before() {
    let gpu = gpu();
    for visibility in ALL {
        let settings = Settings {
            samples: 1,
            ..settings(visibility)
        };
        let (scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::ZERO));
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-3);
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            // With the room's walls black, all there is are the captured shots: each can only take.
            let black = Room {
                reflectance: Some(vec![Vec3::splat(1e-3); mesh.texels.len()]),
                ..room.clone()
            };
            let mut engine = make(&mesh, &settings);
            let mut watched = 0;
            relight(
                engine.as_mut(),
                &mesh,
                &black,
                Method::Signed,
                &settings,
                &mut |_, _| {
                    watched += 1;
                    if watched < 8 {
                        ControlFlow::Continue(())
                    } else {
                        ControlFlow::Break(())
                    }
                },
            )
            .unwrap();
            let after = engine.field().unwrap();
            for (k, h) in after.irradiance.iter().enumerate() {
                if !mesh.is_object(mesh.texels[k].face) {
                    assert!(h.truncate().max_element() <= 0.0, "{visibility:?} {k} {h}");
                }
            }
            // Table 3 clips what is half a unit deep: all of this room.
            let shadow = after.irradiance.iter().any(|h| h.x < 0.0);
            assert!(
                shadow || visibility == Visibility::Paper,
                "{visibility:?}: no shadow"
            );
        }
    }
}

#[test]
fn a_wrong_shader_is_noticed() {
    let faults = [
        ("deposit", "* shot.scale - past.x", "* shot.scale"),
        (
            "deposit",
            "radiosity[k] += vec4f(shot.radiosity * past.y, 0.0);",
            "",
        ),
        ("deposit", "if (params.rule & KEEP) != 0u ||", "if"),
        (
            "link",
            "before = share(sums, sums.before, shot.open_before);",
            "before = share(sums, sums.seen, shot.open);",
        ),
        ("rays", "if !through || primitive < params.room", "if true"),
        ("select", "shot.open_before = cells[cell].open_before;", ""),
    ];
    let settings = Settings {
        samples: 4,
        ..settings(Visibility::Rays)
    };
    let (scene, count) = furnished_room(cube(Vec3::new(1.0, 0.5, 0.0), Vec3::splat(0.5)));
    let mesh = mesh_of(&scene, count, &settings);
    let room = capture(&scene, &mesh, &settings, 1e-4);
    let cpu = run(
        &mut CpuSolver::new(&mesh, &settings),
        &mesh,
        &room,
        Method::Signed,
        &settings,
    );
    let gpu = gpu();
    for (file, from, to) in faults {
        let fault = [Fault { file, from, to }];
        let mut solver = GpuSolver::with_faults(&gpu, &mesh, &settings, &fault).unwrap();
        let relit = relight(
            &mut solver,
            &mesh,
            &room,
            Method::Signed,
            &Settings {
                max_shots: 500,
                ..settings.clone()
            },
            &mut |_, _| ControlFlow::Continue(()),
        )
        .unwrap();
        let change = error(&mesh, &relit.run.field, &cpu.run.field);
        let before = relit
            .surface
            .emission
            .iter()
            .zip(&cpu.surface.emission)
            .any(|(a, b)| (*a - *b).abs().max_element() > 1e-3);
        println!("{file}, {to:?}: {change:.1e} {before}");
        assert!(
            change.is_nan() || change > settings.epsilon || before,
            "{file}, {to} was not noticed"
        );
    }
}
