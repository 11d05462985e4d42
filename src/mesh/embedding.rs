//! A computed map of a mesh to texture space: places of its vertices in T3, and where the mesh is cut open for it.
//!
//! In: a mesh as its file has it. Out: the mesh cut open: vertices on a cut appear once for each side, with every attribute of
//! the vertex they are copies of; triangles keep their numbers. Only what differs from the file is kept: places, copies,
//! and the corners that name a copy, so that a mesh without cuts costs nothing but its places.
//! Source: Inverse Geometric Textures, section 2 (the map C from object space to T3).

use super::{Mesh, MorphTarget};

/// Places of a mesh's vertices in T3, where they are computed; all empty where they are not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Embedding {
    /// For each vertex, copies included, its place in T3.
    pub t3: Vec<[f32; 3]>,
    /// For each copy, which come after all vertices of the file, the vertex that it is a copy of.
    pub copies: Vec<u32>,
    /// Corners (three times the triangle's number, plus 0, 1 or 2) that name a copy, in growing order, and that copy.
    pub moved: Vec<[u32; 2]>,
}

impl Embedding {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.t3.is_empty()
    }

    /// What of this cannot be an embedding of `mesh` (which is not cut open yet): a reason, or none.
    pub fn fault(&self, mesh: &Mesh) -> Option<String> {
        let vertices = mesh.positions.len();
        let all = vertices + self.copies.len();
        if self.t3.len() != all {
            return Some(format!("{} places for {all} vertices", self.t3.len()));
        }
        if let Some(v) = self
            .t3
            .iter()
            .position(|p| !p.iter().all(|c| c.is_finite()))
        {
            return Some(format!("the place of vertex {v} is not finite"));
        }
        if let Some(v) = self.copies.iter().find(|&&v| v as usize >= vertices) {
            return Some(format!("vertex {v} has a copy but does not exist"));
        }
        if !self.moved.is_sorted_by(|a, b| a[0] < b[0]) {
            return Some("corners are not in growing order".into());
        }
        let names_its_own = |&[corner, vertex]: &[u32; 2]| {
            let triangle = mesh.triangles.get(corner as usize / 3)?;
            let source = self.copies.get((vertex as usize).checked_sub(vertices)?)?;
            Some(*source == triangle[corner as usize % 3])
        };
        let bad = self
            .moved
            .iter()
            .find(|moved| names_its_own(moved) != Some(true))?;
        Some(format!(
            "corner {} names vertex {}, which is no copy of its own",
            bad[0], bad[1]
        ))
    }

    /// `mesh`, which this is an embedding of ([`Embedding::fault`] says whether it is), cut open.
    pub fn cut_open(&self, mesh: &Mesh) -> Mesh {
        let mut open = mesh.clone();
        for &[corner, vertex] in &self.moved {
            open.triangles[corner as usize / 3][corner as usize % 3] = vertex;
        }
        let copies = &self.copies;
        repeat(&mut open.positions, copies);
        repeat(&mut open.normals, copies);
        repeat(&mut open.tangents, copies);
        repeat(&mut open.colors, copies);
        repeat(&mut open.joints, copies);
        repeat(&mut open.weights, copies);
        open.uv_sets.iter_mut().for_each(|uv| repeat(uv, copies));
        for MorphTarget {
            positions,
            normals,
            tangents,
        } in &mut open.targets
        {
            [positions, normals, tangents]
                .into_iter()
                .for_each(|array| repeat(array, copies));
        }
        for custom in &mut open.custom {
            for &v in copies {
                let first = v as usize * custom.width;
                custom
                    .values
                    .extend_from_within(first..first + custom.width);
            }
        }
        open.embedding = self.clone();
        open
    }
}

/// Appends the elements of `copies`; an array that a mesh does not have stays empty.
fn repeat<T: Copy>(array: &mut Vec<T>, copies: &[u32]) {
    if !array.is_empty() {
        array.reserve(copies.len());
        copies.iter().for_each(|&v| array.push(array[v as usize]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// A square of two triangles, cut along its diagonal.
    fn cut_square() -> (Mesh, Embedding) {
        let mesh = shapes::grid(1);
        let [first, second] = [mesh.triangles[0], mesh.triangles[1]];
        let shared: Vec<u32> = second
            .iter()
            .copied()
            .filter(|v| first.contains(v))
            .collect();
        let moved = (0..3u32)
            .filter_map(|k| {
                let at = shared.iter().position(|&v| v == second[k as usize])?;
                Some([3 + k, 4 + at as u32])
            })
            .collect();
        let embedding = Embedding {
            t3: vec![[0.5, 0.25, 0.0]; 6],
            copies: shared,
            moved,
        };
        (mesh, embedding)
    }

    #[test]
    fn a_cut_mesh_has_the_same_surface_and_no_shared_vertex() {
        let (mesh, embedding) = cut_square();
        assert_eq!(embedding.fault(&mesh), None);
        let open = embedding.cut_open(&mesh);
        open.validate().unwrap();
        assert_eq!(open.positions.len(), 6);
        for t in 0..2 {
            assert_eq!(open.corners(t), mesh.corners(t));
        }
        assert!(
            open.triangles[0]
                .iter()
                .all(|v| !open.triangles[1].contains(v))
        );
        assert_eq!(Embedding::default().cut_open(&mesh), mesh);
    }

    #[test]
    fn what_does_not_fit_is_named() {
        type Spoil = fn(&mut Embedding);
        let faults: [(Spoil, &str); 6] = [
            (|e| e.t3.truncate(5), "5 places"),
            (|e| e.t3[2][1] = f32::NAN, "vertex 2 is not finite"),
            (|e| e.copies[0] = 4, "does not exist"),
            (|e| e.moved.reverse(), "growing order"),
            (|e| e.moved[0][1] = 3, "no copy of its own"),
            (|e| e.moved[1][0] = 6, "no copy of its own"),
        ];
        for (spoil, reason) in faults {
            let (mesh, mut embedding) = cut_square();
            spoil(&mut embedding);
            let found = embedding.fault(&mesh).unwrap();
            assert!(found.contains(reason), "{found}");
        }
    }
}
