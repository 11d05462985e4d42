//! What `auto` takes: seamless and there already first, then whichever costs a LoD least of the file's charts and what can be
//! computed.

mod glb;
mod long;
mod maps;

use invertex::mesh::{Mesh, shapes};
use invertex::param::{Chosen, Map, PrimaryKind, PrimaryRequest, Weighed, parameterize};
use invertex::scene::Scene;
use maps::{bare, corkscrew};

fn auto(mesh: &Mesh) -> Chosen {
    parameterize(mesh, &PrimaryRequest::Auto).unwrap()
}

/// The mesh with every triangle a chart of its own on a grid of cells: as many seams as edges.
fn shattered(mesh: &Mesh) -> Mesh {
    let cells = (mesh.triangles.len() as f32).sqrt().ceil();
    let mut broken = bare(
        "shattered",
        mesh.triangles
            .iter()
            .flatten()
            .map(|&v| mesh.positions[v as usize])
            .collect(),
        (0..mesh.triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
    );
    let uv = |t: usize| {
        let cell = [t as f32 % cells, (t as f32 / cells).floor()];
        [[0.1, 0.1], [0.9, 0.1], [0.5, 0.8]].map(|p| [0, 1].map(|k| (cell[k] + p[k]) / cells))
    };
    broken.uv_sets = vec![(0..mesh.triangles.len()).flat_map(uv).collect()];
    broken
}

/// The corkscrew laid out by a computed map, as an artist's uv would be: few charts, one-to-one.
fn unwrapped(mesh: &Mesh) -> Mesh {
    let (_, mut open) = maps::computed(mesh, Map::Lscm);
    let uv = open.embedding.t3.iter().map(|p| [p[0], p[1]]);
    open.uv_sets = vec![uv.collect()];
    open.embedding = Default::default();
    open
}

fn row<'a>(chosen: &'a Chosen, kind: &str) -> &'a Weighed {
    let found = chosen.weighed.iter().find(|w| w.kind == kind);
    found.unwrap_or_else(|| panic!("{kind} was not weighed: {}", chosen.why))
}

#[test]
fn what_is_seamless_already_is_taken_without_weighing() {
    for mesh in [shapes::icosphere(3), shapes::tube(48, 6)] {
        let chosen = auto(&mesh);
        assert!(
            chosen.computed.is_none() && chosen.weighed.is_empty(),
            "{}",
            chosen.why
        );
    }
}

/// The same surfaces with a seam at every edge of their uv set, and without.
#[test]
fn seams_decide() {
    let broken = shattered(&corkscrew());
    let chosen = auto(&broken);
    assert_eq!(
        chosen.primary.kind,
        PrimaryKind::Computed(Map::Sphere),
        "{}",
        chosen.why
    );
    let uv = row(&chosen, "uv0");
    // All edges are seams: there are 3/2 of them a triangle, far longer than any LoD's triangles have sides.
    assert!(uv.seam_share.unwrap() > 3.0, "{uv:?}");
    assert!(row(&chosen, "sphere:map").cost < uv.cost);
    assert!(
        chosen.why.contains("uv0 costs") && chosen.why.contains("seams of"),
        "{}",
        chosen.why
    );

    // A disk in one chart: no seams, hardly any stretch, and so nothing is computed beside it.
    let mut disk = shapes::grid(20);
    disk.positions.iter_mut().for_each(|p| {
        // Rolled up 1.4 times, so that no projection sees it whole; 3.4 long.
        let angle = 9.0 * p[0];
        let radius = 0.3 + 0.02 * angle;
        *p = [radius * angle.cos(), radius * angle.sin(), 3.4 * p[1]];
    });
    let chosen = auto(&disk);
    assert_eq!(chosen.primary.kind, PrimaryKind::UvSet(0), "{}", chosen.why);
    assert_eq!(row(&chosen, "uv0").seam_share, Some(0.0));
    assert_eq!(chosen.weighed.len(), 1, "{}", chosen.why);

    // Shattered it is still the same surface, and the sphere is better.
    let chosen = auto(&shattered(&disk));
    assert!(row(&chosen, "uv0").seam_share.unwrap() > 3.0);
    assert_eq!(
        chosen.primary.kind,
        PrimaryKind::Computed(Map::Sphere),
        "{}",
        chosen.why
    );
}

/// The finer the mesh, the less its seams take of a LoD: share and cost fall, by the root of the triangles.
#[test]
fn the_share_of_seams_falls_with_the_root_of_the_triangles() {
    let coarse = unwrapped(&corkscrew());
    let mut fine = coarse.clone();
    // Each triangle in four, uv and all.
    let uv = fine.uv_sets[0].clone();
    let mut triangles = vec![];
    let mut middles = std::collections::HashMap::new();
    for t in &coarse.triangles {
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let at =
                    |p: &[[f32; 3]]| [0, 1, 2].map(|k| 0.5 * (p[a as usize][k] + p[b as usize][k]));
                fine.positions.push(at(&coarse.positions));
                fine.normals.push(at(&coarse.normals));
                fine.uv_sets[0].push([0, 1].map(|k| 0.5 * (uv[a as usize][k] + uv[b as usize][k])));
                fine.positions.len() as u32 - 1
            })
        };
        let m = [middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])];
        triangles.extend([
            [t[0], m[0], m[2]],
            [m[0], t[1], m[1]],
            [m[2], m[1], t[2]],
            m,
        ]);
    }
    fine.triangle_material = vec![0; triangles.len()];
    fine.triangles = triangles;
    let (coarse, fine) = (auto(&coarse), auto(&fine));
    let (a, b) = (row(&coarse, "uv0"), row(&fine, "uv0"));
    let length = |w: &Weighed| w.quality.as_ref().unwrap().seam_length;
    assert!(
        (length(a) - length(b)).abs() < 1e-3 * length(a),
        "{a:?} {b:?}"
    );
    let ratio = a.seam_share.unwrap() / b.seam_share.unwrap();
    assert!((ratio - 2.0).abs() < 0.01, "{ratio}");
}

#[test]
fn a_large_mesh_is_not_computed_beside_a_uv_set_that_will_do() {
    let mut mesh = corkscrew();
    // The same triangles many times over, and charts that are enough: only their number is looked at.
    let broken = shattered(&mesh);
    mesh = broken.clone();
    let copies = 100_000 / broken.triangles.len() + 1;
    for copy in 1..copies as u32 {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(
            broken
                .positions
                .iter()
                .map(|p| [p[0] + 5.0 * copy as f32, p[1], p[2]]),
        );
        mesh.normals.extend(&broken.normals);
        mesh.uv_sets[0].extend(
            broken.uv_sets[0]
                .iter()
                .map(|uv| [uv[0] + copy as f32, uv[1]]),
        );
        mesh.triangles
            .extend(broken.triangles.iter().map(|t| t.map(|v| v + first)));
        mesh.triangle_material.extend(&broken.triangle_material);
    }
    let chosen = auto(&mesh);
    assert_eq!(chosen.primary.kind, PrimaryKind::UvSet(0), "{}", chosen.why);
    let reason = row(&chosen, "sphere:map").why_not.clone().unwrap();
    assert!(
        reason.contains("not tried for more than 100000"),
        "{reason}"
    );
}

/// What the scoreboard says of the shared models: see the README for the figures.
#[test]
fn the_models_get_what_scores_best() {
    for (name, kind) in [
        ("spot", "sphere:map"),
        ("fox", "sphere:map"),
        ("food_apple", "sphere"),
        ("water_bottle", "cylinder:y"),
        ("globe_earth", "sphere"),
        ("boat", "sphere"),
    ] {
        let Some(path) = long::found(name) else {
            continue;
        };
        let scene = Scene::load(&path).unwrap();
        let chosen = auto(&scene.meshes[0]);
        println!("{name}: {}", chosen.why);
        assert_eq!(chosen.primary.kind.to_string(), kind, "{}", chosen.why);
    }
}
