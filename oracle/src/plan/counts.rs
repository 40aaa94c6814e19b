//! How many there will be of everything, without making any of it.

use common::scene::Scene;
use common::settings::{Meshing, Visibility};
use common::texel::Cells;

/// Counts of one solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Faces.
    pub faces: u64,
    /// Texels.
    pub texels: u64,
    /// Cells.
    pub cells: u64,
    /// Points per cell.
    pub samples: u64,
}

impl Counts {
    /// Of `scene`, meshed so.
    pub fn new(scene: &Scene, meshing: &Meshing) -> Self {
        let resolution = [meshing.texels; 2];
        let cells = |shape| u64::from(Cells::new(shape, resolution, meshing.cells).count());
        let faces = scene.faces.len() as u64;
        Self {
            faces,
            texels: faces * u64::from(meshing.texels).pow(2),
            cells: scene.faces.iter().map(|face| cells(face.shape)).sum(),
            samples: u64::from(meshing.samples),
        }
    }

    /// Links: pairs of a cell and a texel.
    pub fn links(&self) -> u64 {
        self.cells.saturating_mul(self.texels)
    }

    /// The rays of `cells` cells at most, one a sample of a link; fewer are asked, since what
    /// faces away needs none. 0 by item buffer.
    pub fn rays_at_most(&self, cells: u64, visibility: Visibility) -> u64 {
        match visibility {
            Visibility::Rays => cells
                .saturating_mul(self.texels)
                .saturating_mul(self.samples),
            _ => 0,
        }
    }

    /// The pixels of the item buffers of `cells` cells, one buffer a sample; 0 by rays.
    pub fn pixels(&self, cells: u64, visibility: Visibility) -> u64 {
        match visibility {
            Visibility::Rays => 0,
            Visibility::Drawn(drawing) => cells * self.samples * drawing.pixels(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::mesh::Mesh;
    use common::scene::Face;
    use glam::{DVec3, Vec3};

    /// A quad and a triangle.
    fn scene() -> Scene {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let [e, r] = [Vec3::ONE, Vec3::splat(0.5)];
        let triangle = [c[0], c[1], c[2]].map(|p| p + DVec3::Z);
        Scene {
            faces: vec![
                Face::quad("quad", c, e, r),
                Face::triangle("triangle", triangle, e, r),
            ],
            ..Scene::default()
        }
    }

    #[test]
    fn the_counts_are_those_of_the_mesh() {
        for (texels, cells) in [(1, 1), (8, 4), (6, 4), (7, 3), (2, 8)] {
            let meshing = Meshing {
                texels,
                cells,
                ..Meshing::default()
            };
            let counts = Counts::new(&scene(), &meshing);
            let mesh = Mesh::uniform(&scene(), texels, cells).unwrap();
            assert_eq!(counts.texels, mesh.texels.len() as u64);
            assert_eq!(counts.cells, mesh.cells.len() as u64, "{texels} {cells}");
        }
    }
}
