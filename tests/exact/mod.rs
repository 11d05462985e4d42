//! Answers of tables made exact: tables round the triangles of a sphere and of a cylinder (to 16 bits, where they are large), and a
//! renderer has that error beside every bound.

use invertex::mesh::{Mesh, Weld};
use invertex::param::Primary;
use invertex::param::projection::hit;

/// For each place the triangles there.
pub(crate) struct Exact {
    weld: Weld,
    around: Vec<Vec<u32>>,
}

impl Exact {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let weld = Weld::by_position(&mesh.positions);
        let mut around = vec![Vec::new(); mesh.positions.len()];
        for (t, triangle) in (0u32..).zip(&mesh.triangles) {
            for v in triangle {
                around[weld.of[*v as usize] as usize].push(t);
            }
        }
        Exact { weld, around }
    }

    /// Where the line through `query` meets, in `sense`, the triangle that was found or one beside it: its number and barycentric
    /// coordinates.
    pub(crate) fn at(
        &self,
        (mesh, primary): (&Mesh, &Primary),
        (query, sense): ([i32; 3], i32),
        found: u32,
    ) -> Option<(u32, [f64; 3])> {
        let grid = |v: u32| primary.to_grid(primary.t3_of(mesh, v as usize));
        let met = |t: u32| {
            let corners = mesh.triangles[t as usize].map(grid);
            let met = hit(primary.line(), query, &corners).filter(|met| met.sense == sense)?;
            Some((t, met.barycentric().map(f64::from)))
        };
        let near = mesh.triangles[found as usize];
        let places = near.iter().map(|&v| self.weld.of[v as usize] as usize);
        let mut beside = places.flat_map(|place| self.around[place].iter().copied());
        met(found).or_else(|| beside.find_map(met))
    }
}
