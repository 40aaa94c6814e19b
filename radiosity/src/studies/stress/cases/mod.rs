//! The cases, one row each, in the order of the report. Every family of scenes is built to break one
//! method by one parameter.

mod build;
pub mod shapes;

use super::ErrorMeasure;
use super::methods::{
    AtlasMethod, CONSERVED, DEFAULT, DENSE, DISC, FINE, HEMICUBE, HEMISPHERE, POLYGON, RELIGHT_METHODS, SOLVE_METHODS,
    SOUTHWELL, STEREOGRAPHIC,
};
use super::trial::Trial;
use build::{
    copies_trial, cracks_trial, dense_trial, direct_trial, door_trial, furnace_trial, object_on_floor, open_room,
    plain_trial, relight_trial, relit_block, shadowed_trial, slit_faces, strips_trial, wall_trial,
};
use common::Result;
use common::scene::Face;
use glam::{DVec3, Vec3};
use serde::Serialize;
use shapes::{
    box_faces, cut_face, floor_square, grey_square, ground_lamp, import_text, lamp_above, move_faces, plate_at,
    square_lamp, unit_floor, unit_room,
};

/// A family of scenes with one parameter.
#[derive(Clone, Copy, Serialize)]
pub struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// Heading under which the case is listed.
    pub group: &'static str,
    /// Swept parameter with its unit.
    pub parameter: &'static str,
    /// Weakness that the case is built to expose.
    pub weakness: &'static str,
    /// Source of the truth.
    pub truth: &'static str,
    /// Measure of the error.
    pub measure: ErrorMeasure,
    /// Methods to run.
    #[serde(skip)]
    pub methods: &'static [AtlasMethod],
    /// Method that fails in the middle of the values where one does; not the paper's, which fails nearly everywhere.
    #[serde(skip)]
    pub failing_method: AtlasMethod,
    /// Values of the parameter, easy to hard.
    #[serde(skip)]
    pub values: &'static [f64],
    /// Builds the trial at a value.
    #[serde(skip)]
    pub build: fn(f64) -> Result<Trial>,
}

impl Case {
    /// Returns whether its values are the seeds of random scenes, which are no sweep.
    pub fn is_random(&self) -> bool {
        self.values.is_empty()
    }
}

/// Direct light; the other kinds of rows differ from it.
const LAMBERT: Case = Case {
    name: "",
    group: "Solved",
    parameter: "",
    weakness: "",
    truth: "Lambert's factor, exact, mean over each texel",
    measure: ErrorMeasure::RelativeRms,
    methods: SOLVE_METHODS,
    failing_method: HEMISPHERE,
    values: &[],
    build: |_| direct_trial(Vec::new()),
};
const SHADOW: Case = Case {
    truth: "Lambert's factor of what is left of the lamp once shadows are cut out of it, mean over each texel",
    ..LAMBERT
};
const LEAK_CASE: Case = Case {
    truth: "no light behind a wall",
    measure: ErrorMeasure::Leak,
    ..LAMBERT
};
const FURNACE: Case = Case {
    truth: "furnace: B = E/(1 − ρ)",
    ..LAMBERT
};
const FINER: Case = Case {
    truth: "the dense solver on texels twice as fine, averaged",
    ..LAMBERT
};
const PLAIN: Case = Case {
    truth: "the dense solver for the scene in plain units at the origin, on texels twice as fine, averaged",
    ..LAMBERT
};
const RELIGHT: Case = Case {
    group: "Relit",
    methods: RELIGHT_METHODS,
    ..FINER
};

/// All cases.
pub const ALL_CASES: &[Case] = &[
    // Faces that are close to each other, small, thin, far, or seen at a grazing angle.
    Case {
        name: "closeness",
        parameter: "gap / size",
        weakness: "one point that stands for an area",
        failing_method: DISC,
        values: &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        build: |gap| direct_trial(vec![unit_floor(), lamp_above([0.5, 0.5, gap], [1.0; 2], 1.0)]),
        ..LAMBERT
    },
    Case {
        name: "shared-edge",
        parameter: "angle between the faces, degrees",
        weakness: "form factors where faces touch along an edge",
        values: &[135.0, 90.0, 30.0, 10.0, 3.0, 1.0, 0.3],
        build: |degrees| {
            let (s, c) = degrees.to_radians().sin_cos();
            let lamp = square_lamp([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s], 1.0);
            direct_trial(vec![unit_floor(), lamp])
        },
        ..LAMBERT
    },
    Case {
        name: "grazing",
        parameter: "height of the lamp / distance",
        weakness: "cosines that nearly vanish",
        values: &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        build: |height| {
            let low = square_lamp([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, height], 1.0);
            let far = grey_square([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.5);
            direct_trial(vec![far, low])
        },
        ..LAMBERT
    },
    Case {
        name: "sliver-shooter",
        parameter: "length / width of the lamp",
        weakness: "a disc, or a few points, in place of a long thin shooter",
        failing_method: DISC,
        values: &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
        build: |aspect| {
            let lamp = lamp_above([0.5, 0.5, 0.5], [1.0, 1.0 / aspect], 1.0);
            direct_trial(vec![unit_floor(), lamp])
        },
        ..LAMBERT
    },
    Case {
        name: "sliver-receiver",
        parameter: "length / width of the receiver",
        weakness: "texels that are long and thin",
        values: &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
        build: |aspect| {
            let strip = floor_square(0.0, [1.0, 1.0 / aspect]);
            direct_trial(vec![strip, lamp_above([0.5, 0.5, 0.5], [1.0; 2], 1.0)])
        },
        ..LAMBERT
    },
    Case {
        name: "small-shooter",
        parameter: "side of the lamp / side of the floor",
        weakness: "a shooter smaller than a texel, close to it",
        values: &[0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        build: |side| direct_trial(vec![unit_floor(), lamp_above([0.53, 0.46, 0.1], [side; 2], 1.0)]),
        ..LAMBERT
    },
    Case {
        name: "large-texel",
        parameter: "height of the lamp / side of the floor",
        weakness: "texels larger than the shooter's distance",
        values: &[1.0, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        build: |height| direct_trial(vec![unit_floor(), lamp_above([0.53, 0.46, height], [0.1; 2], 1.0)]),
        ..LAMBERT
    },
    Case {
        name: "remote",
        parameter: "distance / size",
        weakness: "coordinates of which distance takes the digits",
        values: &[1.0, 10.0, 100.0, 1e3, 1e4, 1e5],
        build: |distance| direct_trial(vec![unit_floor(), lamp_above([0.5, 0.5, distance], [1.0; 2], 1.0)]),
        ..LAMBERT
    },
    // What an item buffer cannot represent.
    Case {
        name: "vanishing-face",
        parameter: "side of the face / distance",
        weakness: "a face smaller than an item buffer's pixel, before a wall",
        values: &[0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        build: |side| {
            let tiny = plate_at([0.51, 0.47, 1.0], [side; 2], 0.5).reversed();
            let wall = plate_at([0.5, 0.5, 1.2], [4.0; 2], 0.0).reversed();
            direct_trial(vec![tiny, wall, ground_lamp([0.5; 2], 1.0)])
        },
        ..LAMBERT
    },
    Case {
        name: "tessellation",
        parameter: "side of the ceiling / its height",
        weakness: "corners projected, and straight lines drawn between them",
        values: &[1.0, 3.0, 10.0, 30.0, 100.0],
        build: |side| {
            let (low, high) = ([-side / 2.0, -side / 2.0, 0.0], [side / 2.0, side / 2.0, 1.0]);
            let mut faces = box_faces(low, high, true, 0.0);
            faces[1].reflectance = Vec3::splat(0.5);
            faces[0] = ground_lamp([0.0; 2], 0.2);
            direct_trial(faces)
        },
        ..LAMBERT
    },
    Case {
        name: "horizon",
        parameter: "depth of the wall below the horizon / distance",
        weakness: "faces that cross the shooter's horizon",
        values: &[0.1, 0.3, 1.0, 3.0, 10.0, 30.0],
        build: |depth| {
            let up = [0.0, 0.0, 1.0 + depth];
            let wall = grey_square([1.0, -0.5, -depth], up, [0.0, 1.0, 0.0], 0.5);
            direct_trial(vec![wall, ground_lamp([0.0; 2], 0.5)])
        },
        ..LAMBERT
    },
    Case {
        name: "rim",
        parameter: "height of the wall / distance",
        weakness: "the rim of the hemisphere: everything low is in its last pixels",
        values: &[1.0, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        build: |height| {
            let strip = grey_square([1.0, -0.5, 0.0], [0.0, 0.0, height], [0.0, 1.0, 0.0], 0.5);
            let behind = grey_square([1.2, -1.0, 0.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], 0.0);
            direct_trial(vec![strip, behind, ground_lamp([0.0; 2], 0.1)])
        },
        ..LAMBERT
    },
    // Defective surfaces: coincident, intersecting, without thickness, bent, without area, or missing.
    Case {
        name: "coplanar",
        parameter: "distance of two fronts / size",
        weakness: "which of two fronts at one place is lit",
        values: &[0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
        build: |distance| {
            let patch = plate_at([0.45, 0.55, distance], [0.5; 2], 0.5);
            let lamp = lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0);
            shadowed_trial(vec![unit_floor(), patch, lamp], 1..2)
        },
        ..SHADOW
    },
    Case {
        name: "duplicate",
        parameter: "copies of the floor",
        weakness: "the same face twice",
        truth: "the dense solver without the copies, on texels twice as fine, averaged",
        values: &[0.0, 1.0, 2.0, 4.0, 9.0],
        build: copies_trial,
        ..LAMBERT
    },
    Case {
        name: "intersecting",
        parameter: "walls through the floor",
        weakness: "texels that a wall cuts in two",
        values: &[1.0, 2.0, 4.0, 8.0, 16.0],
        build: |walls| {
            let mut faces = vec![unit_floor(), lamp_above([0.5, 0.5, 1.0], [0.6; 2], 1.0)];
            for k in 0..walls as usize {
                let x = (k as f64 + 0.43) / walls;
                faces.push(grey_square([x, -0.1, -0.2], [0.0, 1.2, 0.0], [0.02, 0.0, 0.4], 0.0));
            }
            let occluders = 2..faces.len();
            shadowed_trial(faces, occluders)
        },
        ..SHADOW
    },
    Case {
        name: "thin-sheet",
        parameter: "thickness / size",
        weakness: "two fronts back to back: light through the sheet",
        failing_method: DISC,
        values: &[0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 0.0],
        build: |thickness| {
            let mut faint = unit_floor();
            (faint.emission, faint.reflectance) = (Vec3::splat(0.01), Vec3::ZERO);
            let above = plate_at([0.5, 0.5, 0.5 + thickness / 2.0], [0.6; 2], 0.5);
            let below = plate_at([0.5, 0.5, 0.5 - thickness / 2.0], [0.6; 2], 0.5).reversed();
            let lamp = lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0);
            Ok(Trial {
                judged: 3..4,
                ..direct_trial(vec![faint, lamp, above, below])?
            })
        },
        ..LAMBERT
    },
    Case {
        name: "back-face",
        parameter: "height of the blocker / size",
        weakness: "black backs that must block, down to contact",
        values: &[0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        build: |height| {
            let blocker = plate_at([0.47, 0.54, height], [0.4; 2], 0.0);
            let lamp = lamp_above([0.5, 0.5, 1.0], [0.3; 2], 1.0);
            shadowed_trial(vec![unit_floor(), blocker, lamp], 1..2)
        },
        ..SHADOW
    },
    Case {
        name: "t-vertices",
        parameter: "strips of a wall",
        weakness: "cracks where the edges of neighbours do not meet at corners",
        truth: "the dense solver with the wall in one piece, on texels twice as fine, averaged",
        values: &[2.0, 3.0, 4.0, 6.0, 8.0],
        build: strips_trial,
        ..LAMBERT
    },
    Case {
        name: "non-planar",
        parameter: "a corner below the plane / size",
        weakness: "quads whose corners are not in one plane",
        failing_method: DISC,
        values: &[0.0, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.3],
        build: |bend| {
            let obj = format!(
                "mtllib m.mtl\nv 0 0 0\nv 1 0 -{bend}\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 0 1 1\nv 1 1 1\nv 1 0 1\n\
                 usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n"
            );
            let scene = import_text(&obj, "newmtl floor\nKd .5 .5 .5\nnewmtl lamp\nKd 0 0 0\nKe 1 1 1\n")?;
            direct_trial(scene.faces)
        },
        ..LAMBERT
    },
    Case {
        name: "degenerate",
        parameter: "height of a triangle / its base",
        weakness: "faces with no area, or nearly none",
        failing_method: DISC,
        values: &[0.1, 1e-3, 1e-6, 1e-9, 1e-12, 0.0],
        build: |height| {
            let corners = [[0.2, 0.5, 0.3], [0.8, 0.5, 0.3], [0.5, 0.5 + height, 0.3]];
            let thin = Face::triangle("thin", corners.map(DVec3::from), Vec3::ZERO, Vec3::ZERO);
            let lamp = lamp_above([0.5, 0.5, 1.0], [0.8; 2], 1.0);
            shadowed_trial(vec![unit_floor(), lamp, thin], 2..3)
        },
        ..SHADOW
    },
    Case {
        name: "open",
        parameter: "faces missing of six",
        weakness: "open scenes, a single face, and none",
        values: &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        build: |missing| {
            let mut faces = unit_room(0.6);
            faces.swap(0, 1);
            faces[0].emission = Vec3::ONE;
            faces.truncate(6 - missing as usize);
            Ok(dense_trial(faces.clone(), faces))
        },
        ..FINER
    },
    // Shadows. Everything but the receiver is black, so the truth is exact.
    Case {
        name: "slit",
        parameter: "width / side of the screen",
        weakness: "light through an opening thinner than samples and pixels",
        values: &[0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        build: |width| shadowed_trial(slit_faces(width), 2..4),
        ..SHADOW
    },
    Case {
        name: "blinds",
        parameter: "slats",
        weakness: "slats finer than samples and pixels, under a wide lamp",
        values: &[2.0, 4.0, 8.0, 16.0, 32.0],
        build: |count| {
            let mut faces = vec![unit_floor(), lamp_above([0.5, 0.5, 1.0], [1.0; 2], 1.0)];
            let pitch = 2.0 / count;
            for k in 0..count as usize {
                let x = -0.5 + pitch * (k as f64 + 0.37);
                faces.push(plate_at([x, 0.5, 0.5], [pitch / 2.0, 2.0], 0.0));
            }
            shadowed_trial(faces, 2..2 + count as usize)
        },
        ..SHADOW
    },
    Case {
        name: "grating",
        parameter: "pitch / height",
        weakness: "slats at and below the size of a pixel, in an opening",
        values: &[0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4],
        build: |pitch| {
            let mut faces = slit_faces(8.0 * pitch);
            for k in 0..8 {
                let x = 0.5 + pitch * (f64::from(k) - 3.6);
                faces.push(plate_at([x, 0.5, 0.5], [pitch / 2.0, 2.0], 0.0));
            }
            shadowed_trial(faces, 2..12)
        },
        ..SHADOW
    },
    Case {
        name: "plates",
        parameter: "gap between the plates / size",
        weakness: "plates stacked close: light comes in at the edges only",
        values: &[1.0, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        build: |gap| {
            let floor = floor_square(-4.0 * gap, [1.0; 2]);
            let mut faces = vec![floor, lamp_above([0.5, 0.5, 0.5], [0.5; 2], 1.0)];
            for k in 0..4 {
                let side = 0.23 + 0.2 * f64::from(k);
                faces.push(plate_at([0.5, 0.5, -gap * f64::from(k)], [side; 2], 0.5));
            }
            shadowed_trial(faces, 2..6)
        },
        ..SHADOW
    },
    Case {
        name: "covered-lamp",
        parameter: "open share of the lamp",
        weakness: "a body on the shooter's centre, from which all its light leaves",
        values: &[0.99, 0.9, 0.5, 0.1, 0.01],
        build: |open| {
            let side = (1.0f64 - open).sqrt();
            let (low, high) = (0.5 - side / 2.0, 0.5 + side / 2.0);
            let ceiling = floor_square(1.0, [1.0; 2]).reversed();
            let mut faces = vec![ceiling, ground_lamp([0.5; 2], 1.0)];
            faces.extend(box_faces([low, low, 0.0], [high, high, 0.3], false, 0.0));
            shadowed_trial(faces, 2..8)
        },
        ..SHADOW
    },
    // Two rooms: light through a door, and none through a wall or the seams of a box.
    Case {
        name: "door",
        parameter: "width of the door / width of the rooms",
        weakness: "a room that is lit through a small opening only",
        values: &[0.9, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        build: door_trial,
        ..SHADOW
    },
    Case {
        name: "wall",
        parameter: "thickness / size",
        weakness: "a wall between a lit room and a dark one",
        values: &[0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 0.0],
        build: wall_trial,
        ..LEAK_CASE
    },
    Case {
        name: "cracks",
        parameter: "strips of a wall",
        weakness: "the seams of a closed box, lit from outside",
        values: &[1.0, 2.0, 3.0, 5.0, 9.0, 17.0],
        build: cracks_trial,
        ..LEAK_CASE
    },
    // The light itself: reflectance near one, emission over decades, many shots, equal shooters, many lamps.
    Case {
        name: "white-walls",
        parameter: "reflectance",
        weakness: "errors of closure that grow with every bounce",
        methods: &[DEFAULT, FINE, POLYGON, DISC, STEREOGRAPHIC, HEMICUBE, DENSE, CONSERVED],
        failing_method: DISC,
        values: &[0.9, 0.99, 0.999, 0.9999, 0.99999],
        build: |reflectance| furnace_trial(1, reflectance as f32, 6),
        ..FURNACE
    },
    Case {
        name: "power",
        parameter: "emitted radiosity, W/m²",
        weakness: "thresholds that depend on the unit of power",
        failing_method: DISC,
        values: &[1.0, 1e3, 1e-3, 1e6, 1e-6],
        build: |power| direct_trial(vec![unit_floor(), lamp_above([0.5, 0.5, 1.0], [1.0; 2], power as f32)]),
        ..LAMBERT
    },
    Case {
        name: "faint-lamp",
        parameter: "power / power of the other lamp",
        weakness: "a faint lamp beside a bright one",
        failing_method: DISC,
        values: &[1.0, 1e-3, 1e-6, 1e-9, 1e-12],
        build: |ratio| {
            let pair = |x: f64, power: f64| {
                let faces = vec![unit_floor(), lamp_above([0.5, 0.5, 1.0], [1.0; 2], power as f32)];
                move_faces(faces, |p| p + DVec3::X * x)
            };
            direct_trial([pair(0.0, 1.0), pair(10.0, ratio)].concat())
        },
        ..LAMBERT
    },
    Case {
        name: "many-shots",
        parameter: "reflectance",
        weakness: "sums in single precision over up to 1e5 shots",
        methods: &[DEFAULT, POLYGON, DENSE, CONSERVED, SOUTHWELL],
        failing_method: POLYGON,
        values: &[0.5, 0.9, 0.99, 0.999, 0.9996],
        build: |reflectance| furnace_trial(1, reflectance as f32, 4),
        ..FURNACE
    },
    Case {
        name: "ties",
        parameter: "faces a wall, all alike, by side",
        weakness: "shooters of equal power: the choice hangs on rounding",
        methods: &[DEFAULT, FINE, POLYGON, DISC, STEREOGRAPHIC, DENSE, SOUTHWELL],
        failing_method: DISC,
        values: &[1.0, 2.0, 3.0, 4.0, 5.0],
        build: |side| furnace_trial(side as usize, 0.5, 1),
        ..FURNACE
    },
    Case {
        name: "lights",
        parameter: "lamps",
        weakness: "very many lamps",
        methods: &[DEFAULT, FINE, POLYGON, DENSE],
        failing_method: POLYGON,
        values: &[1.0, 10.0, 100.0, 300.0, 1000.0],
        build: |count| {
            let side = count.sqrt().ceil();
            let lamp = |k: usize| {
                let (i, j) = ((k as f64 % side).floor(), (k as f64 / side).floor());
                let centre = [(i + 0.5) / side, (j + 0.5) / side, 0.5];
                lamp_above(centre, [0.3 / side; 2], 1.0)
            };
            let mut faces = cut_face(&unit_floor(), [6; 2]);
            faces.extend((0..count as usize).map(lamp));
            Ok(Trial {
                texels: 1,
                ..direct_trial(faces)?
            })
        },
        ..LAMBERT
    },
    // Units and position, which must not affect a solution.
    Case {
        name: "units",
        parameter: "units a side of the room",
        weakness: "thresholds that depend on the unit of length",
        values: &[1.0, 1e3, 1e-3, 1e6, 1e-6],
        build: |unit| plain_trial(|p| p * unit),
        ..PLAIN
    },
    Case {
        name: "translation",
        parameter: "distance from the origin / size",
        weakness: "coordinates that lose their digits far from the origin",
        values: &[0.0, 1e3, 1e4, 1e5, 1e6, 1e7],
        build: |distance| plain_trial(|p| p + DVec3::new(0.6, -0.64, 0.48) * distance),
        ..PLAIN
    },
    // Objects put into a room that was captured without them.
    Case {
        name: "object-on-floor",
        parameter: "gap below the object / size of the room",
        weakness: "an object that comes to touch the floor",
        truth: "the dense solver on texels twice as fine, averaged; of the touching object where it is as close as 0.001",
        values: &[0.1, 0.01, 1e-3, 1e-5, 0.0],
        build: object_on_floor,
        ..RELIGHT
    },
    Case {
        name: "object-sunk",
        parameter: "share of its height below the floor",
        weakness: "an object that is sunk in the floor",
        values: &[0.01, 0.1, 0.5, 0.9, 0.99],
        build: |depth| relight_trial(open_room(), relit_block(-0.3 * depth, 0.5)),
        ..RELIGHT
    },
    Case {
        name: "object-in-its-shadow",
        parameter: "side of the table top / side of the room",
        weakness: "an object in the shadow that it throws itself",
        values: &[0.1, 0.3, 0.5, 0.7, 0.9],
        build: |side| {
            let top = plate_at([0.5, 0.5, 0.5], [side; 2], 0.5);
            let under = top.reversed();
            relight_trial(open_room(), [vec![top, under], relit_block(0.0, 0.5)].concat())
        },
        ..RELIGHT
    },
    Case {
        name: "object-black",
        parameter: "reflectance of the object",
        weakness: "an object that only takes light away",
        values: &[0.1, 0.01, 1e-3, 1e-4, 0.0],
        build: |reflectance| relight_trial(open_room(), relit_block(0.1, reflectance as f32)),
        ..RELIGHT
    },
    Case {
        name: "object-white",
        parameter: "reflectance of the object",
        weakness: "an object that keeps no light",
        values: &[0.9, 0.99, 0.999, 0.9999, 0.99999],
        build: |reflectance| relight_trial(open_room(), relit_block(0.1, reflectance as f32)),
        ..RELIGHT
    },
    Case {
        name: "object-at-window",
        parameter: "side of the object / side of the window",
        weakness: "an object that is larger than the window before which it stands",
        values: &[0.3, 0.6, 1.0, 2.0, 3.0],
        build: |ratio| {
            let mut room = open_room();
            room[1].emission = Vec3::ZERO;
            room.push(square_lamp([0.99, 0.35, 0.35], [0.0, 0.0, 0.3], [0.0, 0.3, 0.0], 10.0));
            let half = 0.15 * ratio;
            let (low, high) = ([0.8, 0.5 - half, 0.5 - half], [0.85, 0.5 + half, 0.5 + half]);
            relight_trial(room, box_faces(low, high, false, 0.5))
        },
        ..RELIGHT
    },
];
