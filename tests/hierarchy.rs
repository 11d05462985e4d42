//! Histories made again from steps, as a file holds them; levels that are cuts; what is refused.

mod camera;
mod parted;

use camera::{looking, perspective};
use glam::DVec3;
use invertex::lod::multiresolution::{Criterion, Hierarchy, Limits, Memory, Seen, StepColours};
use invertex::lod::progressive::colour::Distance;
use invertex::lod::progressive::{Cost, Deviation, Progressive, Steps};
use invertex::mesh::shapes;
use invertex::param::{Axis, PrimaryKind};
use parted::Model;

fn sphere() -> (Model, Progressive) {
    let model = Model::new(shapes::icosphere(3), PrimaryKind::Sphere);
    let history = Progressive::new(&model.input(), Cost::Displacement, 4);
    (model, history)
}

#[test]
fn steps_make_the_history_again() {
    let tube = Model::new(shapes::tube(24, 12), PrimaryKind::UvSet(0));
    let of_tube = Progressive::new(&tube.input(), Cost::Displacement, 4);
    for (model, history) in [sphere(), (tube, of_tube)] {
        let again = Progressive::replay(&model.input(), &history.steps()).unwrap();
        assert_eq!(again.triangles, history.triangles);
        assert_eq!(
            (&again.place, &again.reference),
            (&history.place, &history.reference)
        );
        assert_eq!(again.steps(), history.steps());
        assert!(again.collapses.is_sorted_by(|a, b| a.price <= b.price));
    }
}

#[test]
fn steps_of_something_else_are_refused() {
    let (model, history) = sphere();
    let good = history.steps();
    let refused = |change: &dyn Fn(&mut Steps)| {
        let mut steps = good.clone();
        change(&mut steps);
        Progressive::replay(&model.input(), &steps).unwrap_err()
    };
    let far = |d: f32| Deviation {
        total: d,
        ..Deviation::default()
    };
    assert!(refused(&|s| s.places[0] = [u32::MAX, 0]).contains("no such place"));
    assert!(refused(&|s| s.places[3][1] = s.places[3][0]).contains("no neighbours"));
    assert!(refused(&|s| s.places.reverse()).contains("collapse"));
    assert!(refused(&|s| s.places.push([0, 1])).contains("collapse"));
    assert!(refused(&|s| s.deviations.push(far(0.0))).contains("of no triangle"));
    assert!(refused(&|s| s.deviations.truncate(9)).contains("without a deviation"));
    assert!(refused(&|s| s.deviations[5] = far(f32::NAN)).contains("not a distance"));
    assert!(refused(&|s| s.deviations[5] = far(-1.0)).contains("not a distance"));
    // Another mesh.
    let other = Model::new(shapes::uv_sphere(16, 12), PrimaryKind::Sphere);
    assert!(Progressive::replay(&other.input(), &good).is_err());
    // A surface that would close on itself: everything onto one neighbour.
    let least = Model::new(shapes::tetrahedron(), PrimaryKind::Sphere);
    let onto = Steps {
        places: vec![[0, 1]],
        deviations: vec![far(0.0); 4],
    };
    assert!(
        Progressive::replay(&least.input(), &onto)
            .unwrap_err()
            .contains("tear")
    );
}

#[test]
fn colours_fit_or_are_refused() {
    let (model, history) = sphere();
    let colours = |levels: usize, rows: usize, footprint: f32| StepColours {
        distance: Distance::Lab,
        footprint,
        levels,
        codes: vec![[1, 1]; rows * levels],
    };
    let n = history.collapses.len();
    let read = |colours| Hierarchy::replay(&model.input(), &history.steps(), Some(colours));
    assert!(read(colours(3, n, 0.1)).is_ok());
    for wrong in [
        colours(3, n - 1, 0.1),
        colours(0, n, 0.1),
        colours(17, n, 0.1),
        colours(3, n, 0.0),
        colours(3, n, f32::NAN),
    ] {
        assert!(read(wrong).unwrap_err().contains("colours"));
    }
}

fn seen(distance: f64) -> Seen {
    Seen {
        object_to_view: looking(DVec3::Z * distance, DVec3::ZERO, DVec3::Y),
        projection: perspective(0.35, 1.0),
        size: [400, 400],
        double_sided: true,
    }
}

#[test]
fn a_cut_is_a_level() {
    let (model, history) = sphere();
    let hierarchy = Hierarchy::new(history, &model.mesh.positions, None);
    for pixels in [0.0, 2.0, 1e9] {
        let limits = Limits {
            pixels,
            ..Limits::default()
        };
        let view = hierarchy.model.view(&seen(40.0), &limits).unwrap();
        let cut = hierarchy.model.select(&[view], &mut Memory::default());
        let lod = hierarchy.lod(&model.input(), &cut);
        assert_eq!(lod.triangles.len(), cut.faces.len());
        assert_eq!(
            (lod.turned, lod.positions.len()),
            (0, lod.triangles.len() / 2 + 2)
        );
        assert!(
            f64::from(lod.error) * 40.0 <= pixels * 40.0 + 1e-9 || pixels == 1e9 || lod.error < 0.2
        );
    }
}

#[test]
fn a_mesh_in_two_places_gets_one_cut_for_both() {
    let (model, history) = sphere();
    let hierarchy = Hierarchy::new(history, &model.mesh.positions, None);
    let cut = |views: &[Seen]| {
        let view = |seen| hierarchy.model.view(seen, &Limits::default()).unwrap();
        let views: Vec<_> = views.iter().map(view).collect();
        let cut = hierarchy.model.select(&views, &mut Memory::default());
        hierarchy.lod(&model.input(), &cut)
    };
    let (near, far) = (seen(6.0), seen(60.0));
    assert!(cut(&[near]).triangles.len() > cut(&[far]).triangles.len());
    assert_eq!(cut(&[far, near]).triangles, cut(&[near]).triangles);
    // Nowhere at all: the coarsest.
    let coarsest = hierarchy.history.after(hierarchy.model.collapses()).count();
    assert_eq!(cut(&[]).triangles.len(), coarsest);
}

/// A rough sheet of which one half says that its colours are off by nothing.
#[test]
fn colours_let_the_plain_half_be_coarse() {
    let mut sheet = shapes::grid(64);
    for p in &mut sheet.positions {
        *p = [
            p[0] - 0.5,
            p[1] - 0.5,
            (p[0] * 40.0).sin() * (p[1] * 31.0).cos() * 0.01,
        ];
    }
    let model = Model::new(sheet, PrimaryKind::Plane(Axis::Z));
    let history = Progressive::new(&model.input(), Cost::Displacement, 4);
    let side = |v: u32| model.mesh.positions[v as usize][0];
    let is_plain = |corners: [u32; 3]| corners.iter().all(|&v| side(v) <= 0.0);
    let mut codes = vec![[0u8; 2]; history.collapses.len() * 2];
    for t in history.triangles.iter().filter(|t| !is_plain(t.corners)) {
        if let Some(c) = t.made {
            codes[c as usize * 2..][..2].fill([200, 200]);
        }
    }
    let colours = StepColours {
        distance: Distance::Lab,
        footprint: 0.01,
        levels: 2,
        codes,
    };
    let hierarchy = Hierarchy::new(history, &model.mesh.positions, Some(colours));
    let halves = |colour: Option<f64>| {
        let limits = Limits {
            pixels: 0.5,
            criterion: colour.map_or(Criterion::Displacement, Criterion::Colour),
            ..Limits::default()
        };
        let view = hierarchy.model.view(&seen(2.0), &limits).unwrap();
        let cut = hierarchy.model.select(&[view], &mut Memory::default());
        let plain = |&&f: &&u32| is_plain(hierarchy.model.faces[f as usize].corners);
        let plain = cut.faces.iter().filter(plain).count();
        (plain, cut.faces.len() - plain)
    };
    let (by_pixels, by_colour) = (halves(None), halves(Some(2.0)));
    assert!(by_colour.0 * 2 < by_pixels.0, "{by_pixels:?} {by_colour:?}");
    assert!(
        by_colour.1 * 10 > by_pixels.1 * 9,
        "{by_pixels:?} {by_colour:?}"
    );
    // No colour may be off at all: what says nothing is off stays as coarse.
    assert_eq!(halves(Some(0.0)).0, by_colour.0);
}

/// A flat sheet whose uv runs ever faster: nothing moves along the normal, everything along the surface.
#[test]
fn the_surface_alone_lets_its_texture_go() {
    let mut sheet = shapes::grid(24);
    for uv in &mut sheet.uv_sets[0] {
        uv[0] *= uv[0];
    }
    let model = Model::new(sheet, PrimaryKind::UvSet(0));
    let history = Progressive::new(&model.input(), Cost::Displacement, 4);
    let coarsest = history.after(history.collapses.len()).count();
    let cuts = Hierarchy::new(history, &model.mesh.positions, None).model;
    let cut = |criterion: Criterion| {
        let limits = Limits {
            criterion,
            ..Limits::default()
        };
        let view = cuts.view(&seen(3.0), &limits).unwrap();
        let cut = cuts.select(&[view], &mut Memory::default());
        (cut.faces.len(), cuts.displacement(&[view], &cut))
    };
    let ((all, kept), (few, gone)) = (cut(Criterion::Displacement), cut(Criterion::Surface));
    assert!(few == coarsest && all > 3 * few, "{all} {few}");
    assert!(kept <= 0.5 * 1.00001 && gone > 5.0, "{kept} {gone}");
}

#[test]
fn what_a_cut_proves_is_within_the_limit_and_near_it() {
    let (model, history) = sphere();
    let cuts = Hierarchy::new(history, &model.mesh.positions, None).model;
    let mut most = 0.0f64;
    for i in 0..40 {
        let seen = seen(1.2 * 1.1f64.powi(i));
        let within = |pixels: f64| {
            let limits = Limits {
                pixels,
                ..Limits::default()
            };
            let view = cuts.view(&seen, &limits).unwrap();
            (view, cuts.select(&[view], &mut Memory::default()))
        };
        let (view, cut) = within(3.0);
        let proved = cuts.displacement(&[view], &cut);
        assert!(proved <= 3.0 * 1.00001, "{i}: {proved}");
        most = most.max(proved);
        // A cut that was made within less proves no more; the reference itself nothing.
        assert!(cuts.displacement(&[view], &within(1.0).1) <= proved);
        assert_eq!(cuts.displacement(&[view], &within(0.0).1), 0.0);
    }
    assert!(most > 2.5, "{most}");
}
