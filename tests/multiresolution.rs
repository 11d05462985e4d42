//! Cuts of multiresolution models: each is a mesh as sound as the reference, whoever looks from wherever; they follow the view;
//! limits are what no triangle that is seen exceeds.

mod camera;
mod parted;

use camera::{looking, parallel, perspective};
use glam::{DMat4, DVec3, DVec4};
use invertex::lod::multiresolution::{
    Criterion, Cut, Limits, Memory, Multiresolution, NEVER, Seen,
};
use invertex::lod::progressive::{Cost, Progressive};
use invertex::mesh::{Mesh, shapes};
use invertex::param::{Axis, PrimaryKind, projection};
use parted::Model;
use std::collections::HashMap;

struct Subject {
    model: Model,
    history: Progressive,
    cuts: Multiresolution,
}

impl Subject {
    fn new(mesh: Mesh, kind: PrimaryKind) -> Self {
        let model = Model::new(mesh, kind);
        let history = Progressive::new(&model.input(), Cost::Displacement, 4);
        let cuts = Multiresolution::new(&history, &model.mesh.positions, None);
        Subject {
            model,
            history,
            cuts,
        }
    }

    fn select(&self, seen: &Seen, limits: &Limits, memory: &mut Memory) -> Cut {
        self.cuts
            .select(&[self.cuts.view(seen, limits).unwrap()], memory)
    }

    fn cut(&self, seen: &Seen, limits: &Limits) -> Cut {
        self.select(seen, limits, &mut Memory::default())
    }

    /// Edges of a cut by their places, with how often each way they are passed.
    fn edges(&self, faces: &[u32]) -> HashMap<[u32; 2], [u32; 2]> {
        let mut edges: HashMap<[u32; 2], [u32; 2]> = HashMap::new();
        for &f in faces {
            let corners = self.cuts.faces[f as usize].corners;
            let places = corners.map(|v| self.history.place[v as usize]);
            for k in 0..3 {
                let (a, b) = (places[k], places[(k + 1) % 3]);
                edges.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
            }
        }
        edges
    }

    /// Border edges, and vertices - edges + triangles.
    fn shape(&self, faces: &[u32]) -> (usize, i64) {
        let edges = self.edges(faces);
        let border = edges.values().filter(|n| n[0] + n[1] == 1).count();
        let places: std::collections::HashSet<u32> = edges.keys().flatten().copied().collect();
        let euler = places.len() as i64 - edges.len() as i64 + faces.len() as i64;
        (border, euler)
    }

    fn reference(&self) -> Vec<u32> {
        let faces = self.cuts.faces.iter().enumerate();
        let own = faces.filter(|(_, face)| face.made == NEVER);
        own.map(|(f, _)| f as u32).collect()
    }

    /// A cut is sound: manifold, wound alike, of the reference's shape, not turned in T3.
    fn check(&self, cut: &Cut) {
        let edges = self.edges(&cut.faces);
        assert!(
            edges.values().all(|n| n[0] <= 1 && n[1] <= 1),
            "an edge has three sides or two windings"
        );
        let (border, euler) = self.shape(&cut.faces);
        let (border_before, euler_before) = self.shape(&self.reference());
        assert_eq!(euler, euler_before);
        assert!((border == 0) == (border_before == 0) && border <= border_before);
        let line = self.model.primary.line();
        for &f in &cut.faces {
            let t = self.cuts.of[f as usize] as usize;
            let made = &self.history.triangles[t];
            let sense = projection::orientation(line, &made.corners.map(|v| self.model.grid(v)));
            assert_eq!(sense, 1, "turned: {made:?}");
        }
    }
}

/// The `i`th of views all over the place: inside, near, far, perspective and parallel.
fn view(i: u64, about: DVec3, size: f64) -> Seen {
    let b = |k: u64| parted::spread(i * 7 + k)[0];
    let towards = DVec3::new(b(1) - 0.4, b(2) - 0.4, b(3) - 0.4).normalize();
    let distance = size * 10f64.powf(3.0 * b(4) - 1.0);
    let eye = about + towards * distance;
    let at = about + DVec3::new(b(5), b(6), b(2)) * size * 0.5;
    let up = if towards.y.abs() < 0.9 {
        DVec3::Y
    } else {
        DVec3::X
    };
    let projection = match i % 5 {
        0 => parallel(size, 1.0),
        _ => perspective(0.1 + 0.5 * b(3), 1.5),
    };
    Seen {
        object_to_view: looking(eye, at, up),
        projection,
        size: [300, 200],
        double_sided: i.is_multiple_of(3),
    }
}

fn limits(i: u64) -> Limits {
    Limits {
        pixels: [0.5, 0.0, 3.0, 20.0][(i / 3 % 4) as usize],
        criterion: match i % 7 {
            3 => Criterion::Surface,
            _ => Criterion::Displacement,
        },
        outside: i.is_multiple_of(2),
        hysteresis: [1.0, 0.7][(i / 2 % 2) as usize],
    }
}

fn walked(subject: &Subject, views: u64) {
    let (low, high) = subject.model.mesh.positions.iter().fold(
        (DVec3::INFINITY, DVec3::NEG_INFINITY),
        |(low, high), p| {
            let p = DVec3::from(p.map(f64::from));
            (low.min(p), high.max(p))
        },
    );
    let mut memory = Memory::default();
    let mut sizes = std::collections::BTreeSet::new();
    for i in 0..views {
        let seen = view(i, (low + high) * 0.5, (high - low).length());
        let cut = subject.select(&seen, &limits(i), &mut memory);
        subject.check(&cut);
        sizes.insert(cut.faces.len());
    }
    assert!(sizes.len() > 10, "cuts follow the view: {sizes:?}");
}

/// Views of a walk; ten thousand in the long form.
fn views() -> u64 {
    match std::env::var_os("INVERTEX_LONG") {
        Some(_) => 10_000,
        None => 300,
    }
}

#[test]
fn every_cut_of_a_sphere_is_sound() {
    walked(
        &Subject::new(shapes::icosphere(4), PrimaryKind::Sphere),
        views(),
    );
}

#[test]
fn every_cut_of_a_tube_with_a_seam_is_sound() {
    walked(
        &Subject::new(shapes::tube(48, 24), PrimaryKind::UvSet(0)),
        views(),
    );
}

#[test]
fn every_cut_of_a_sheet_is_sound() {
    let mut sheet = shapes::grid(24);
    for p in &mut sheet.positions {
        p[2] = (p[0] * 9.0).sin() * (p[1] * 7.0).cos() * 0.1;
    }
    walked(&Subject::new(sheet, PrimaryKind::Plane(Axis::Z)), views());
}

#[test]
fn a_collapse_without_those_it_depends_on_tears_the_surface() {
    // What the walk would find: leave out one predecessor.
    let subject = Subject::new(shapes::icosphere(3), PrimaryKind::Sphere);
    let seen = view(1, DVec3::ZERO, 2.0);
    let cut = subject.cut(
        &seen,
        &Limits {
            pixels: 2.0,
            ..Limits::default()
        },
    );
    let torn: Vec<u32> = cut.faces[1..].to_vec();
    assert_eq!(subject.shape(&cut.faces).0, 0);
    assert_eq!(subject.shape(&torn).0, 3);
}

#[test]
fn limits_of_nothing_and_of_everything() {
    let subject = Subject::new(shapes::icosphere(4), PrimaryKind::Sphere);
    let seen = Seen {
        object_to_view: looking(DVec3::Z * 40.0, DVec3::ZERO, DVec3::Y),
        ..view(6, DVec3::ZERO, 2.0)
    };
    let at = |pixels: f64| {
        let limits = Limits {
            pixels,
            ..Limits::default()
        };
        subject
            .cut(
                &Seen {
                    double_sided: true,
                    ..seen
                },
                &limits,
            )
            .faces
            .len()
    };
    assert_eq!(at(0.0), subject.model.mesh.triangles.len());
    let coarsest = subject
        .history
        .after(subject.history.collapses.len())
        .count();
    assert_eq!(at(1e9), coarsest);
    assert!(at(0.1) > at(1.0) && at(1.0) > at(10.0));
    for wrong in [-1.0, f64::NAN, f64::INFINITY] {
        let limits = Limits {
            pixels: wrong,
            ..Limits::default()
        };
        assert!(subject.cuts.view(&seen, &limits).is_err());
        let limits = Limits {
            criterion: Criterion::Colour(wrong),
            ..Limits::default()
        };
        assert!(subject.cuts.view(&seen, &limits).is_err());
    }
    for hysteresis in [0.0, 1.5, f64::NAN] {
        let limits = Limits {
            hysteresis,
            ..Limits::default()
        };
        assert!(subject.cuts.view(&seen, &limits).is_err());
    }
    let flat = Seen {
        object_to_view: DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0)),
        ..seen
    };
    assert!(subject.cuts.view(&flat, &Limits::default()).is_err());
}

/// Where a point stands in the picture, in pixels; none behind the eye.
fn on_screen(seen: &Seen, p: DVec3) -> Option<DVec3> {
    let clip: DVec4 = seen.projection * seen.object_to_view * p.extend(1.0);
    let half = DVec3::new(f64::from(seen.size[0]), f64::from(seen.size[1]), 0.0) * 0.5;
    (clip.w > 0.0).then(|| clip.truncate() / clip.w * half)
}

#[test]
fn no_triangle_in_the_picture_is_displaced_by_more() {
    let subject = Subject::new(shapes::icosphere(5), PrimaryKind::Sphere);
    let mut seen_triangles = 0;
    for i in 0..200 {
        let stretched = DMat4::from_scale(DVec3::new(1.0, if i % 2 == 0 { 1.0 } else { 2.0 }, 1.0));
        let seen = view(i, DVec3::ZERO, 2.0);
        let seen = Seen {
            object_to_view: seen.object_to_view * stretched,
            ..seen
        };
        let limits = limits(i);
        for &f in &subject.cut(&seen, &limits).faces {
            let made = &subject.history.triangles[subject.cuts.of[f as usize] as usize];
            let far = f64::from(made.deviation.total);
            let corners = made
                .corners
                .map(|v| DVec3::from(subject.model.mesh.positions[v as usize].map(f64::from)));
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            for p in corners.into_iter().chain([middle]) {
                let Some(at) = on_screen(&seen, p)
                    .filter(|at| at.x.abs() <= 150.0 && at.y.abs() <= 100.0 && at.z.abs() <= 1.0)
                else {
                    continue;
                };
                // A point of the sphere's near side; what faces away may be as coarse as it likes.
                let to_eye = seen.object_to_view.inverse().transform_point3(DVec3::ZERO) - p;
                let perspective = seen.projection.z_axis.w != 0.0;
                let to_eye = if perspective {
                    to_eye
                } else {
                    seen.object_to_view.inverse().transform_vector3(DVec3::Z)
                };
                if !seen.double_sided && p.normalize().dot(to_eye.normalize()) < 0.2 {
                    continue;
                }
                seen_triangles += 1;
                for towards in [
                    DVec3::X,
                    DVec3::Y,
                    DVec3::Z,
                    -DVec3::X,
                    -DVec3::Y,
                    -DVec3::Z,
                ] {
                    let Some(moved) = on_screen(&seen, p + towards * far) else {
                        panic!("behind the eye")
                    };
                    let pixels = (moved - at).truncate().length();
                    assert!(
                        pixels <= limits.pixels * (1.0 + 1e-4) + 1e-9,
                        "{pixels} of {} in view {i}",
                        limits.pixels
                    );
                }
            }
        }
    }
    assert!(seen_triangles > 10_000, "{seen_triangles}");
}

#[test]
fn what_is_asked_follows_the_cut_not_the_reference() {
    let asked = |subdivisions: u32| {
        let subject = Subject::new(shapes::icosphere(subdivisions), PrimaryKind::Sphere);
        let seen = Seen {
            object_to_view: looking(DVec3::Z * 40.0, DVec3::ZERO, DVec3::Y),
            double_sided: true,
            ..view(6, DVec3::ZERO, 2.0)
        };
        let cut = subject.cut(
            &seen,
            &Limits {
                pixels: 0.25,
                ..Limits::default()
            },
        );
        (cut.faces.len(), cut.asked, subject.cuts.collapses())
    };
    let (small, large) = (asked(4), asked(6));
    assert!(large.2 > small.2 * 15);
    assert!(
        large.0 < small.0 * 2,
        "the same picture: {small:?} {large:?}"
    );
    assert!(large.1 < small.1 * 3, "{small:?} {large:?}");
}

#[test]
fn what_trembles_does_not_flicker() {
    let subject = Subject::new(shapes::icosphere(5), PrimaryKind::Sphere);
    let seen = |i: u64| {
        let distance = 5.0 + 0.01 * f64::from((i % 2) as u32);
        Seen {
            object_to_view: looking(DVec3::Z * distance, DVec3::ZERO, DVec3::Y),
            ..view(6, DVec3::ZERO, 2.0)
        }
    };
    let changes = |hysteresis: f64| {
        let limits = Limits {
            hysteresis,
            ..Limits::default()
        };
        let mut memory = Memory::default();
        let cuts: Vec<Cut> = (0..8)
            .map(|i| subject.select(&seen(i), &limits, &mut memory))
            .collect();
        cuts.iter().for_each(|cut| subject.check(cut));
        cuts[2..]
            .windows(2)
            .filter(|pair| pair[0].faces != pair[1].faces)
            .count()
    };
    assert_eq!(changes(1.0), 5);
    assert_eq!(changes(0.9), 0);
}
