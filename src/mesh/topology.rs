//! Which vertices are one point, which triangles hang together, what lies across an edge.
//!
//! In: arrays of a [`Mesh`]. Out: per-vertex and per-triangle labels, numbered in order of first appearance, so that
//! the same mesh always gets the same labels. Everything is iterative and works on non-manifold input.

use super::Mesh;
use rayon::prelude::*;
use std::collections::HashMap;
use std::hash::Hash;

/// No triangle, no vertex.
pub const NONE: u32 = u32::MAX;

/// Vertices grouped into classes that count as one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Weld {
    /// For each vertex the lowest-numbered vertex of its class.
    pub of: Vec<u32>,
    /// Number of classes.
    pub count: usize,
}

impl Weld {
    /// Vertices with equal keys are one.
    pub fn by_key<K: Hash + Eq>(keys: impl Iterator<Item = K>) -> Weld {
        let mut first: HashMap<K, u32> = HashMap::new();
        let of = keys
            .enumerate()
            .map(|(v, key)| *first.entry(key).or_insert(v as u32))
            .collect();
        Weld {
            of,
            count: first.len(),
        }
    }

    /// Vertices at the same position are one (0 and -0 are the same).
    pub fn by_position(positions: &[[f32; 3]]) -> Weld {
        Weld::by_key(positions.iter().map(|p| p.map(bits)))
    }

    /// Vertices with the same position and the same coordinate in uv set `set` are one: what makes a chart.
    ///
    /// # Panics
    /// If the mesh has no such uv set.
    pub fn by_position_and_uv(mesh: &Mesh, set: usize) -> Weld {
        Weld::by_key(
            mesh.positions
                .iter()
                .zip(&mesh.uv_sets[set])
                .map(|(p, uv)| (p.map(bits), uv.map(bits))),
        )
    }

    /// The triangles with every vertex replaced by its class.
    pub fn triangles(&self, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        triangles
            .iter()
            .map(|t| t.map(|v| self.of[v as usize]))
            .collect()
    }
}

/// Bit pattern of a float, with -0 made 0.
fn bits(x: f32) -> u32 {
    (x + 0.0).to_bits()
}

/// Triangles grouped into connected components.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Components {
    /// For each triangle its component, `0..count`, numbered by each component's first triangle.
    pub of: Vec<u32>,
    /// Number of components.
    pub count: usize,
}

/// Connected components of triangles that share a vertex. Weld first ([`Weld::triangles`]) to say what a shared
/// vertex is; `vertices` is the number of vertices.
pub fn components(triangles: &[[u32; 3]], vertices: usize) -> Components {
    let mut union = Union::new(vertices);
    for t in triangles {
        union.join(t[0], t[1]);
        union.join(t[1], t[2]);
    }
    let mut label = vec![NONE; vertices];
    let mut count = 0;
    let of = triangles
        .iter()
        .map(|t| {
            let slot = &mut label[union.root(t[0]) as usize];
            if *slot == NONE {
                *slot = count;
                count += 1;
            }
            *slot
        })
        .collect();
    Components {
        of,
        count: count as usize,
    }
}

/// Disjoint sets, joined towards the lower number, with path halving.
pub(crate) struct Union(Vec<u32>);

impl Union {
    pub(crate) fn new(count: usize) -> Union {
        Union((0..count as u32).collect())
    }

    pub(crate) fn root(&mut self, mut v: u32) -> u32 {
        while self.0[v as usize] != v {
            self.0[v as usize] = self.0[self.0[v as usize] as usize];
            v = self.0[v as usize];
        }
        v
    }

    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// What lies across each edge of each triangle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adjacency {
    /// For triangle `t` and its edge `k` (from corner k to corner k + 1) the one triangle on the other side; [`NONE`]
    /// at a border and where three or more triangles meet.
    pub across: Vec<[u32; 3]>,
    /// Number of edges with one triangle.
    pub border_edges: usize,
    /// Number of edges with three triangles or more.
    pub non_manifold_edges: usize,
}

impl Adjacency {
    /// Adjacency over edges between equal vertex numbers (weld first). Edges of no length (both ends the same
    /// vertex) have nothing across and are counted nowhere.
    pub fn new(triangles: &[[u32; 3]]) -> Adjacency {
        let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(triangles.len() * 3);
        for (t, triangle) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                if a != b {
                    edges.push((a.min(b), a.max(b), (t * 3 + k) as u32));
                }
            }
        }
        edges.par_sort_unstable();
        let mut out = Adjacency {
            across: vec![[NONE; 3]; triangles.len()],
            border_edges: 0,
            non_manifold_edges: 0,
        };
        for same in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            match same {
                [_] => out.border_edges += 1,
                [x, y] => {
                    out.across[x.2 as usize / 3][x.2 as usize % 3] = y.2 / 3;
                    out.across[y.2 as usize / 3][y.2 as usize % 3] = x.2 / 3;
                }
                _ => out.non_manifold_edges += 1,
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// Euler's number V - E + F of the welded surface.
    fn euler(mesh: &Mesh) -> i64 {
        let weld = Weld::by_position(&mesh.positions);
        let adjacency = Adjacency::new(&weld.triangles(&mesh.triangles));
        assert_eq!(adjacency.non_manifold_edges, 0, "{}", mesh.name);
        let edges = (3 * mesh.triangles.len() + adjacency.border_edges) / 2;
        weld.count as i64 - edges as i64 + mesh.triangles.len() as i64
    }

    #[test]
    fn euler_numbers_of_known_surfaces() {
        for sphere in [
            shapes::tetrahedron(),
            shapes::octahedron(),
            shapes::icosphere(2),
        ] {
            assert_eq!(euler(&sphere), 2, "{}", sphere.name);
        }
        assert_eq!(euler(&shapes::grid(5)), 1);
        assert_eq!(euler(&shapes::tube(12, 3)), 0);
    }

    #[test]
    fn closed_surfaces_have_a_triangle_across_every_edge() {
        let mesh = shapes::icosphere(2);
        let adjacency = Adjacency::new(&mesh.triangles);
        assert_eq!(adjacency.border_edges, 0);
        for (t, across) in adjacency.across.iter().enumerate() {
            for other in across {
                assert!(adjacency.across[*other as usize].contains(&(t as u32)));
            }
        }
    }

    #[test]
    fn two_tetrahedra_are_two_components_until_they_touch() {
        let one = shapes::tetrahedron();
        let mut both = one.triangles.clone();
        both.extend(one.triangles.iter().map(|t| t.map(|v| v + 4)));
        let parts = components(&both, 8);
        assert_eq!(
            (parts.count, &parts.of[..]),
            (2, &[0, 0, 0, 0, 1, 1, 1, 1][..])
        );
        both.push([3, 4, 4]);
        assert_eq!(components(&both, 8).count, 1);
        assert_eq!(components(&[], 0).count, 0);
    }

    #[test]
    fn welding_joins_seams_but_uv_keeps_them_apart() {
        let sphere = shapes::uv_sphere(8, 4);
        let position = Weld::by_position(&sphere.positions);
        let chart = Weld::by_position_and_uv(&sphere, 0);
        assert!(position.count < chart.count);
        assert_eq!(Weld::by_position(&[[0.0; 3], [-0.0; 3]]).count, 1);
    }

    #[test]
    fn three_triangles_round_an_edge_are_not_adjacent() {
        let adjacency = Adjacency::new(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert_eq!(adjacency.non_manifold_edges, 1);
        assert_eq!(adjacency.across[0][0], NONE);
    }
}
