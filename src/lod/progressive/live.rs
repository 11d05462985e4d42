//! The mesh while it is simplified: which triangles there are, what lies round a place, what may collapse.
//!
//! In: a reference mesh and its primary. Out: [`Live`], in which the surface's *places* (welded positions) collapse onto
//! neighbours, and every triangle that ever was is kept.
//!
//! A place has several *vertices* where charts meet: one for each side of a seam. A collapse takes all of them along:
//!
//! | place | may collapse onto | because |
//! |---|---|---|
//! | inside (a closed fan) | any neighbour | |
//! | on a rim (an open fan) | its neighbours along the rim | the hole keeps its rim |
//! | on a seam | its neighbours along the seam | every one of its vertices needs one of its own chart to become |
//! | where seams end or meet | its only or no such neighbour | the same rule |
//! | where more than two triangles share an edge, fans touch or windings disagree | none | no fan to close |
//!
//! and only where the surface stays one: both have no common neighbours but those across the edge (the link condition),
//! no triangle is doubled.

use super::overlay::Deviation;
use crate::lod::LodInput;
use crate::param::fit_surface::weld;
use crate::param::weld::by_place;

/// No collapse.
pub(super) const NEVER: u32 = u32::MAX;

/// A triangle that is or was part of the surface.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Vertices of the mesh.
    pub(super) corners: [u32; 3],
    pub(super) layer: u8,
    pub(super) deviation: Deviation,
    /// Triangles of the reference that its image meets; none after it is gone.
    pub(super) covers: Vec<u32>,
    /// The collapses that made it and removed it, or [`NEVER`].
    pub(super) made: u32,
    pub(super) gone: u32,
}

/// The surface.
pub(super) struct Live {
    /// For each vertex of the mesh its place, named by one of its vertices.
    pub(super) place: Vec<u32>,
    pub(super) faces: Vec<Face>,
    /// The triangles of the mesh that the first faces are.
    pub(super) reference: Vec<u32>,
    /// For each place the faces round it that are there, in growing order.
    pub(super) round: Vec<Vec<u32>>,
    /// Faces that are there.
    pub(super) count: usize,
}

/// What a collapse does to the faces round the place that goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Star {
    /// Faces that lose their area.
    pub(super) lost: Vec<u32>,
    /// Faces that get another corner, and their new corners.
    pub(super) turned: Vec<(u32, [u32; 3])>,
}

/// How the fan round a place lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fan {
    Closed,
    Open,
    Broken,
}

impl Live {
    pub(super) fn new(input: &LodInput<'_>) -> Self {
        let mesh = input.mesh;
        let vertex = weld(mesh, input.primary.kind);
        let place = by_place(&mesh.positions, &mesh.triangles).of;
        let mut live = Live {
            round: vec![Vec::new(); place.len()],
            place,
            faces: Vec::with_capacity(mesh.triangles.len() * 3),
            reference: Vec::with_capacity(mesh.triangles.len()),
            count: 0,
        };
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let corners = triangle.map(|v| vertex.of[v as usize]);
            let [a, b, c] = corners.map(|v| live.place[v as usize]);
            if a != b && b != c && c != a {
                live.reference.push(t as u32);
                live.push(Face {
                    corners,
                    layer: input.parts.triangle_layer[t],
                    deviation: Deviation::default(),
                    covers: vec![t as u32],
                    made: NEVER,
                    gone: NEVER,
                });
            }
        }
        live
    }

    /// Adds a face that is there.
    pub(super) fn push(&mut self, face: Face) {
        let f = self.faces.len() as u32;
        for place in face.corners.map(|v| self.place[v as usize]) {
            self.round[place as usize].push(f);
        }
        self.faces.push(face);
        self.count += 1;
    }

    /// Takes a face away, by collapse number `by`.
    pub(super) fn remove(&mut self, f: u32, by: u32) {
        for place in self.places(f) {
            self.round[place as usize].retain(|&other| other != f);
        }
        let face = &mut self.faces[f as usize];
        face.gone = by;
        face.covers = Vec::new();
        self.count -= 1;
    }

    /// The places of a face's corners.
    pub(super) fn places(&self, f: u32) -> [u32; 3] {
        self.faces[f as usize]
            .corners
            .map(|v| self.place[v as usize])
    }

    /// The corner of face `f` that lies at place `u`.
    pub(super) fn vertex(&self, f: u32, u: u32) -> Option<u32> {
        let corners = self.faces[f as usize].corners;
        corners.into_iter().find(|&v| self.place[v as usize] == u)
    }

    /// Whether no face but `f` has both vertices of `edge`: a hole's rim, or one side of a seam.
    pub(super) fn is_rim(&self, f: u32, edge: [u32; 2]) -> bool {
        let place = self.place[edge[0] as usize];
        !self.round[place as usize].iter().any(|&other| {
            let corners = &self.faces[other as usize].corners;
            other != f && edge.iter().all(|v| corners.contains(v))
        })
    }

    /// Neighbours of place `u`: each with the faces on whose edge it comes next after `u`, and before.
    fn spokes(&self, u: u32) -> Vec<(u32, u32, u32)> {
        let mut spokes: Vec<(u32, u32, u32)> = Vec::with_capacity(8);
        let mut count = |place: u32, next: u32, before: u32| match spokes
            .iter_mut()
            .find(|spoke| spoke.0 == place)
        {
            Some(spoke) => (spoke.1, spoke.2) = (spoke.1 + next, spoke.2 + before),
            None => spokes.push((place, next, before)),
        };
        for &f in &self.round[u as usize] {
            let [_, next, before] = self.from(f, u);
            count(next, 1, 0);
            count(before, 0, 1);
        }
        spokes
    }

    /// The places of face `f`, turned so that `u` comes first.
    fn from(&self, f: u32, u: u32) -> [u32; 3] {
        let [a, b, c] = self.places(f);
        match u {
            _ if u == a => [a, b, c],
            _ if u == b => [b, c, a],
            _ => [c, a, b],
        }
    }

    /// The fan round `u`, and the neighbours that `u` may collapse onto as far as the fan says.
    pub(super) fn fan(&self, u: u32) -> (Fan, Vec<u32>) {
        let spokes = self.spokes(u);
        let single = spokes.iter().all(|s| s.1 <= 1 && s.2 <= 1);
        let rim: Vec<u32> = spokes
            .iter()
            .filter(|s| s.1 + s.2 == 1)
            .map(|s| s.0)
            .collect();
        match rim.len() {
            _ if spokes.is_empty() || !single || !self.is_one_fan(u, &spokes) => {
                (Fan::Broken, Vec::new())
            }
            0 => (Fan::Closed, spokes.iter().map(|s| s.0).collect()),
            2 => (Fan::Open, rim),
            _ => (Fan::Broken, Vec::new()),
        }
    }

    /// Whether one walk round `u` passes all its faces.
    fn is_one_fan(&self, u: u32, spokes: &[(u32, u32, u32)]) -> bool {
        // A rim's walk starts at the edge that no face comes to.
        let start = spokes.iter().find(|s| s.2 == 0).unwrap_or(&spokes[0]).0;
        let faces = &self.round[u as usize];
        let (mut at, mut passed) = (start, 0);
        while let Some([_, _, before]) = faces
            .iter()
            .map(|&f| self.from(f, u))
            .find(|places| places[1] == at)
        {
            passed += 1;
            at = before;
            if at == start || passed > faces.len() {
                break;
            }
        }
        passed == faces.len()
    }

    /// What the collapse of place `u` onto its neighbour `v` does, if the surface stays one. `u` has a whole fan.
    pub(super) fn star(&self, u: u32, v: u32) -> Option<Star> {
        let (mut lost, mut kept) = (Vec::with_capacity(2), Vec::with_capacity(6));
        for &f in &self.round[u as usize] {
            match self.places(f).contains(&v) {
                true => lost.push(f),
                false => kept.push(f),
            }
        }
        if kept.is_empty() || !self.stays_one(u, v, &lost, &kept) {
            return None;
        }
        let becomes = self.becomes(u, v, &lost)?;
        let turned = kept
            .into_iter()
            .map(|f| Some((f, self.with(f, u, &becomes)?)));
        Some(Star {
            turned: turned.collect::<Option<_>>()?,
            lost,
        })
    }

    /// For each vertex of `u` the vertex of `v` on the same side; none where a vertex has two.
    fn becomes(&self, u: u32, v: u32, lost: &[u32]) -> Option<Vec<(u32, u32)>> {
        let mut becomes: Vec<(u32, u32)> = Vec::with_capacity(2);
        for &f in lost {
            let (from, to) = (self.vertex(f, u)?, self.vertex(f, v)?);
            match becomes.iter().find(|pair| pair.0 == from) {
                Some(pair) if pair.1 != to => return None,
                Some(_) => {}
                None => becomes.push((from, to)),
            }
        }
        Some(becomes)
    }

    /// The corners of face `f` once the vertex of `u` has become another.
    fn with(&self, f: u32, u: u32, becomes: &[(u32, u32)]) -> Option<[u32; 3]> {
        let mut corners = self.faces[f as usize].corners;
        for w in &mut corners {
            if self.place[*w as usize] == u {
                *w = becomes.iter().find(|pair| pair.0 == *w)?.1;
            }
        }
        Some(corners)
    }

    /// The link condition: `u` and `v` share no neighbours but those across their edge, and no face would be there twice.
    fn stays_one(&self, u: u32, v: u32, lost: &[u32], kept: &[u32]) -> bool {
        let across = |f: u32| self.places(f).into_iter().find(|&p| p != u && p != v);
        let across: Vec<u32> = lost.iter().filter_map(|&f| across(f)).collect();
        let near_u = |p: u32| kept.iter().any(|&f| self.places(f).contains(&p));
        let stay = self.round[v as usize].iter().filter(|f| !lost.contains(f));
        for &f in stay {
            let others = self.places(f).into_iter().filter(|&p| p != v);
            let shared = others.clone().filter(|p| near_u(*p));
            if shared.clone().any(|p| !across.contains(&p)) {
                return false;
            }
            // Both others are neighbours of u: is there a face of the three?
            let both = |&k: &u32| others.clone().all(|p| self.places(k).contains(&p));
            if kept.iter().any(both) {
                return false;
            }
        }
        across.len() < 2 || across[0] != across[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, shapes};
    use crate::param::{Primary, PrimaryKind, parts};

    fn live(mesh: &Mesh, kind: PrimaryKind) -> Live {
        let primary = Primary::centred(kind, mesh).unwrap();
        let parts = parts(mesh, &primary);
        let world = glam::Mat4::IDENTITY.to_cols_array_2d();
        Live::new(&LodInput {
            mesh,
            primary: &primary,
            parts: &parts,
            world,
        })
    }

    #[test]
    fn a_sphere_collapses_anywhere_and_a_tetrahedron_nowhere() {
        let sphere = live(&shapes::icosphere(1), PrimaryKind::Sphere);
        for u in 0..sphere.round.len() as u32 {
            let (fan, onto) = sphere.fan(u);
            assert_eq!(fan, Fan::Closed);
            for v in onto {
                let star = sphere.star(u, v).unwrap();
                assert_eq!(star.lost.len(), 2);
                assert_eq!(star.turned.len(), sphere.round[u as usize].len() - 2);
            }
        }
        let least = live(&shapes::tetrahedron(), PrimaryKind::Sphere);
        let (fan, onto) = least.fan(0);
        assert_eq!((fan, onto.len()), (Fan::Closed, 3));
        assert!(onto.iter().all(|&v| least.star(0, v).is_none()));
    }

    #[test]
    fn rims_and_seams_are_kept() {
        let sheet = shapes::grid(4);
        let flat = live(&sheet, PrimaryKind::Plane(crate::param::Axis::Z));
        let at = |x: f32, y: f32| {
            let near = |p: &[f32; 3]| (p[0] - x).abs() + (p[1] - y).abs() < 1e-6;
            sheet.positions.iter().position(near).unwrap() as u32
        };
        let (low, high) = (sheet.positions[0][0], sheet.positions[24][0]);
        let middle = (low + high) / 2.0;
        let (fan, onto) = flat.fan(at(middle, sheet.positions[0][1]));
        assert_eq!((fan, onto.len()), (Fan::Open, 2));
        assert_eq!(flat.fan(at(middle, middle)).0, Fan::Closed);

        // A tube's uv seam: two vertices at a place, which only go along it.
        let tube = shapes::tube(12, 6);
        let open = live(&tube, PrimaryKind::UvSet(0));
        let seam: Vec<u32> = (0..tube.positions.len() as u32)
            .filter(|&v| open.place[v as usize] != v)
            .map(|v| open.place[v as usize])
            .collect();
        assert!(seam.len() > 5);
        let inner: Vec<u32> = seam
            .iter()
            .copied()
            .filter(|&u| open.fan(u).0 == Fan::Closed)
            .collect();
        assert!(!inner.is_empty());
        for u in inner {
            let onto: Vec<u32> = open.fan(u).1;
            let may: Vec<u32> = onto
                .into_iter()
                .filter(|&v| open.star(u, v).is_some())
                .collect();
            assert_eq!(may.len(), 2);
            assert!(may.iter().all(|v| seam.contains(v)));
        }
    }

    #[test]
    fn what_is_no_fan_stays() {
        // Three triangles on an edge; two that touch in a vertex; two that wind against each other.
        let three: &[[u32; 3]] = &[[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        let touching: &[[u32; 3]] = &[[0, 1, 2], [0, 3, 4]];
        let against: &[[u32; 3]] = &[[0, 1, 2], [0, 1, 3]];
        for triangles in [three, touching, against] {
            let mesh = Mesh {
                positions: vec![
                    [0.0, 0.0, 0.0],
                    [1.0, 0.0, 0.0],
                    [0.0, 1.0, 0.0],
                    [0.0, -1.0, 0.1],
                    [0.3, 0.2, 1.0],
                ],
                triangles: triangles.to_vec(),
                ..Mesh::default()
            };
            let live = live(&mesh, PrimaryKind::Plane(crate::param::Axis::Z));
            assert_eq!(live.fan(0), (Fan::Broken, vec![]), "{triangles:?}");
        }
    }
}
