//! The mesh while it is simplified: which triangles there are, what lies round a place, what may collapse.
//!
//! In: a reference mesh and its primary. Out: [`Live`], in which the surface's *places* (welded positions) collapse onto
//! neighbours, and every triangle that ever was is kept.
//!
//! A place has several *vertices* where charts meet: one for each side of a seam. A collapse takes all of them along:
//!
//! | place | may collapse onto | because |
//! |---|---|---|
//! | inside (a closed ring) | any neighbour | |
//! | on a rim (an open ring) | its neighbours along the rim | the hole keeps its rim |
//! | on a seam | its neighbours along the seam | every one of its vertices needs one of its own chart to become |
//! | where seams end or meet | its only or no such neighbour | the same rule |
//! | where more than two triangles share an edge, fans touch or windings disagree | none | no ring to close |
//!
//! and only where the surface stays one (`ring`).

use super::lists::Lists;
use super::overlay::Deviation;
use super::ring::Star;
use super::{Collapse, Made, Progressive};
use crate::lod::LodInput;
use crate::param::PrimaryKind;
use crate::param::fit_surface::weld;
use crate::param::weld::by_place;
use rayon::prelude::*;
use smallvec::SmallVec;

/// A triangle of the surface. One that a collapse turns stays where it is: what lies side by side does so in memory too.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Vertices of the mesh.
    pub(super) corners: [u32; 3],
    /// Their places.
    pub(super) places: [u32; 3],
    /// The sense in which projection lines meet it.
    pub(super) sense: i8,
    pub(super) deviation: Deviation,
    /// What it is in the history.
    now: u32,
}

/// The surface.
pub(super) struct Live {
    /// For each vertex of the mesh its place, named by one of its vertices.
    pub(super) place: Vec<u32>,
    /// First those of the reference; some are there no more.
    pub(super) faces: Vec<Face>,
    /// All there ever were, as they were made.
    history: Vec<Made>,
    /// The triangles of the mesh that the first faces are.
    pub(super) reference: Vec<u32>,
    /// For each place the faces round it that are there.
    pub(super) round: Lists,
    /// For each face the triangles of the reference that its image meets.
    pub(super) covers: Lists,
    /// For each place how many collapses there had been after the last that changed what lies round it.
    pub(super) changed: Vec<u32>,
    /// Faces that are there.
    pub(super) count: usize,
}

/// What becomes of a face that a collapse turns.
#[derive(Clone, Debug)]
pub(super) struct Turned<'a> {
    pub(super) sense: i8,
    pub(super) deviation: Deviation,
    pub(super) covers: &'a [u32],
}

/// How many more triangles there are in a whole history than in its reference, about.
const HISTORY: f64 = 3.5;

impl Live {
    /// The mesh; `sense` tells in which sense lines meet a triangle of it.
    pub(super) fn new(input: &LodInput<'_>, sense: impl Fn(usize) -> i8) -> Self {
        let (mesh, kind) = (input.mesh, input.primary.kind);
        let place = by_place(&mesh.positions, &mesh.triangles).of;
        let vertex = match kind {
            PrimaryKind::UvSet(_) | PrimaryKind::Computed(_) => weld(mesh, kind).of,
            _ => place.clone(),
        };
        let most = (mesh.triangles.len() as f64 * HISTORY) as usize;
        let mut faces = Vec::with_capacity(mesh.triangles.len());
        let mut reference = Vec::with_capacity(mesh.triangles.len());
        let mut history = Vec::with_capacity(most);
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let corners = triangle.map(|v| vertex[v as usize]);
            let places = corners.map(|v| place[v as usize]);
            let [a, b, c] = places;
            if a != b && b != c && c != a {
                reference.push(t as u32);
                faces.push(Face {
                    corners,
                    places,
                    sense: sense(t),
                    deviation: Deviation::default(),
                    now: history.len() as u32,
                });
                history.push(Made {
                    corners,
                    layer: input.parts.triangle_layer[t],
                    deviation: Deviation::default(),
                    made: None,
                    gone: None,
                });
            }
        }
        let at = |(f, face): (usize, &Face)| face.places.map(|p| (p, f as u32));
        let covers = (0u32..).zip(reference.iter().copied());
        Live {
            round: Lists::of(place.len(), faces.iter().enumerate().flat_map(at)),
            covers: Lists::of(faces.len(), covers),
            changed: vec![0; place.len()],
            count: faces.len(),
            place,
            faces,
            history,
            reference,
        }
    }

    /// Collapses place `u` onto `v`, as collapse number `number`. `turned` tells what becomes of the star's faces, in order.
    pub(super) fn collapse<'t>(
        &mut self,
        [u, v]: [u32; 2],
        star: &Star,
        turned: impl Iterator<Item = Turned<'t>>,
        number: u32,
    ) {
        for &f in &star.lost {
            self.history[self.faces[f as usize].now as usize].gone = Some(number);
            for place in self.faces[f as usize].places {
                self.round.remove(place, f);
                self.changed[place as usize] = number + 1;
            }
            self.covers.clear(f);
        }
        for (&(f, corners), turned) in star.turned.iter().zip(turned) {
            self.turn(f, corners, turned, number);
        }
        let turned: SmallVec<[u32; 10]> = star.turned.iter().map(|&(f, _)| f).collect();
        self.round.extend(v, &turned);
        self.round.clear(u);
        self.changed[u as usize] = number + 1;
        self.count -= star.lost.len();
    }

    /// Gives a face other corners.
    fn turn(&mut self, f: u32, corners: [u32; 3], turned: Turned<'_>, number: u32) {
        let face = &mut self.faces[f as usize];
        let before = &mut self.history[face.now as usize];
        before.gone = Some(number);
        let made = Made {
            corners,
            layer: before.layer,
            deviation: turned.deviation,
            made: Some(number),
            gone: None,
        };
        *face = Face {
            corners,
            places: corners.map(|w| self.place[w as usize]),
            sense: turned.sense,
            deviation: turned.deviation,
            now: self.history.len() as u32,
        };
        self.history.push(made);
        for place in face.places {
            self.changed[place as usize] = number + 1;
        }
        self.covers.set(f, turned.covers);
    }

    /// What became of the surface by these collapses.
    pub(super) fn into_history(self, collapses: Vec<Collapse>) -> Progressive {
        Progressive {
            triangles: self.history,
            place: self.place,
            reference: self.reference,
            collapses,
        }
    }

    /// For each vertex of the mesh whether an edge of a rim or seam ends there.
    pub(super) fn on_rim(&self) -> Vec<bool> {
        let rims = (0..self.faces.len() as u32)
            .into_par_iter()
            .flat_map_iter(|f| {
                let [a, b, c] = self.faces[f as usize].corners;
                let edges = [[a, b], [b, c], [c, a]].into_iter();
                edges.filter(move |&edge| self.is_rim(f, edge)).flatten()
            });
        let mut on_rim = vec![false; self.place.len()];
        for v in rims.collect::<Vec<u32>>() {
            on_rim[v as usize] = true;
        }
        on_rim
    }

    /// The corner of face `f` that lies at place `u`.
    pub(super) fn vertex(&self, f: u32, u: u32) -> Option<u32> {
        let face = &self.faces[f as usize];
        let corner = face.places.iter().position(|&p| p == u)?;
        Some(face.corners[corner])
    }

    /// Whether no face but `f` has both vertices of `edge`: a hole's rim, or one side of a seam.
    pub(super) fn is_rim(&self, f: u32, edge: [u32; 2]) -> bool {
        let place = self.place[edge[0] as usize];
        !self.round.get(place).iter().any(|&other| {
            let corners = &self.faces[other as usize].corners;
            other != f && edge.iter().all(|v| corners.contains(v))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lod::progressive::ring::Ring;
    use crate::mesh::{Mesh, shapes};
    use crate::param::{Primary, PrimaryKind, parts};

    fn live(mesh: &Mesh, kind: PrimaryKind) -> Live {
        let primary = Primary::centred(kind, mesh).unwrap();
        let parts = parts(mesh, &primary);
        let world = glam::Mat4::IDENTITY.to_cols_array_2d();
        Live::new(
            &LodInput {
                mesh,
                primary: &primary,
                parts: &parts,
                world,
            },
            |_| 1,
        )
    }

    #[test]
    fn a_sphere_collapses_anywhere_and_a_tetrahedron_nowhere() {
        let sphere = live(&shapes::icosphere(1), PrimaryKind::Sphere);
        for u in 0..sphere.round.count() as u32 {
            let ring = sphere.ring(u).unwrap();
            assert!(ring.closed);
            for v in ring.onto() {
                let star = sphere.star(&ring, v).unwrap();
                assert_eq!(star.lost.len(), 2);
                assert_eq!(star.turned.len(), sphere.round.get(u).len() - 2);
            }
        }
        let least = live(&shapes::tetrahedron(), PrimaryKind::Sphere);
        let ring = least.ring(0).unwrap();
        assert_eq!((ring.closed, ring.onto().len()), (true, 3));
        let may = |&v: &u32| least.star(&ring, v).is_some();
        assert!(!ring.onto().iter().any(may));
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
        let ring = flat.ring(at(middle, sheet.positions[0][1])).unwrap();
        assert_eq!((ring.closed, ring.onto().len()), (false, 2));
        assert!(flat.ring(at(middle, middle)).unwrap().closed);

        // A tube's uv seam: two vertices at a place, which only go along it.
        let tube = shapes::tube(12, 6);
        let open = live(&tube, PrimaryKind::UvSet(0));
        let seam: Vec<u32> = (0..tube.positions.len() as u32)
            .filter(|&v| open.place[v as usize] != v)
            .map(|v| open.place[v as usize])
            .collect();
        assert!(seam.len() > 5);
        let rings = seam.iter().filter_map(|&u| open.ring(u));
        let inner: Vec<Ring> = rings.filter(|ring| ring.closed).collect();
        assert!(!inner.is_empty());
        for ring in inner {
            let may: Vec<u32> = ring
                .onto()
                .into_iter()
                .filter(|&v| open.star(&ring, v).is_some())
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
            assert!(live.ring(0).is_none(), "{triangles:?}");
        }
    }
}
