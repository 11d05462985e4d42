//! LoD chains: counts, one budget, seams, layers, and what happens at the edges of the input.

mod parted;

use invertex::lod::{Lod, LodInput, chains};
use invertex::mesh::{Adjacency, Mesh, Weld, shapes};
use invertex::param::{Axis, Parts, PrimaryKind};
use parted::{IDENTITY, Model};

fn simplify(models: &[Model], fractions: &[f32]) -> Vec<Vec<Lod>> {
    let inputs: Vec<LodInput> = models.iter().map(Model::input).collect();
    chains(&inputs, fractions).unwrap()
}

fn sphere(subdivisions: u32) -> Model {
    Model::new(shapes::icosphere(subdivisions), PrimaryKind::Sphere)
}

/// A rounded cube of six charts, `n` x `n` quads each, every chart in its own cell of a 3 x 2 layout with margins.
fn six_charts(n: u32) -> Mesh {
    let face = shapes::grid(n);
    let mut out = Mesh {
        name: "six charts".into(),
        uv_sets: vec![vec![]],
        ..Mesh::default()
    };
    for side in 0..6u32 {
        let (axis, sign) = (side as usize / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
        let first = out.positions.len() as u32;
        for p in &face.positions {
            let [a, b] = [2.0 * p[0] - 1.0, 2.0 * p[1] - 1.0];
            let mut q = [0.0; 3];
            (q[axis], q[(axis + 1) % 3], q[(axis + 2) % 3]) = (sign, sign * a, b);
            let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]).sqrt();
            // Rounded to a coarse grid so that the faces' common edges agree to the bit.
            out.positions
                .push(q.map(|x| (x * (0.5 + 0.5 / length) * 4096.0).round() / 4096.0));
            let cell = [(side % 3) as f32, (side / 3) as f32];
            out.uv_sets[0].push([
                (cell[0] + 0.1 + 0.8 * p[0]) / 3.0,
                (cell[1] + 0.1 + 0.8 * p[1]) / 2.0,
            ]);
        }
        out.triangles
            .extend(face.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    out.triangle_material = vec![0; out.triangles.len()];
    out.normals = invertex::mesh::smooth_normals(&out.positions, &out.triangles);
    out
}

fn check_arrays(lod: &Lod) {
    let vertices = lod.positions.len();
    assert_eq!((lod.normals.len(), lod.t3.len()), (vertices, vertices));
    assert_eq!(lod.triangle_layer.len(), lod.triangles.len());
    let mut used = vec![false; vertices];
    lod.triangles
        .iter()
        .flatten()
        .for_each(|&v| used[v as usize] = true);
    assert!(used.iter().all(|&u| u), "no vertex is unused");
    assert!(
        lod.triangles
            .iter()
            .all(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
    );
    assert!(
        lod.normals
            .iter()
            .all(|n| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-3)
    );
}

fn border_edges(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> usize {
    Adjacency::new(&Weld::by_position(positions).triangles(triangles)).border_edges
}

#[test]
fn counts_come_near_the_target_and_errors_grow() {
    let fractions = [0.5, 0.2, 0.05, 0.01];
    let models = [sphere(5)];
    let chain = &simplify(&models, &fractions)[0];
    assert_eq!(chain.len(), 4);
    for (lod, fraction) in chain.iter().zip(fractions) {
        check_arrays(lod);
        let target = models[0].mesh.triangles.len() as f32 * fraction;
        let count = lod.triangles.len() as f32;
        assert!(
            lod.reached && count <= target.ceil() && count >= 0.9 * target - 4.0,
            "{count} for {target}"
        );
        assert_eq!(
            border_edges(&lod.positions, &lod.triangles),
            0,
            "closed stays closed"
        );
        assert_eq!(lod.turned, 0);
    }
    assert!(
        chain.windows(2).all(|w| w[0].error < w[1].error),
        "fewer triangles, more error"
    );
    // A sphere of radius 1 with 82 triangles: the error is the sagitta's order, and vertices stay near the surface.
    assert!(chain[3].error < 0.15);
    for p in &chain[3].positions {
        let radius = p.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!((radius - 1.0).abs() < 0.1, "{radius}");
    }
}

#[test]
fn t3_comes_from_where_the_vertex_went() {
    for model in [
        sphere(4),
        Model::new(shapes::tube(64, 32), PrimaryKind::Cylinder(Axis::Z)),
    ] {
        let lod = &simplify(std::slice::from_ref(&model), &[0.1])[0][0];
        for (p, t3) in lod.positions.iter().zip(&lod.t3) {
            let expected = model
                .primary
                .to_grid(model.primary.t3_of_position(p.map(f64::from)));
            assert_eq!(*t3, expected);
        }
        let moved = lod
            .positions
            .iter()
            .filter(|p| !model.mesh.positions.contains(p))
            .count();
        assert!(moved > 0, "vertices may move to the optimum");
    }
}

#[test]
fn the_flat_pays_for_the_curved() {
    let flat = Model::new(shapes::grid(32), PrimaryKind::Plane(Axis::Z)).at(4.0, [10.0, 0.0, 0.0]);
    let models = [flat, sphere(4)];
    let counts = |k: usize, result: &[Vec<Lod>]| {
        result
            .iter()
            .map(|c| c[k].triangles.len())
            .collect::<Vec<_>>()
    };
    let result = simplify(&models, &[0.2]);
    let [flat, round] = counts(0, &result)[..] else {
        panic!()
    };
    assert_eq!(
        (
            models[0].mesh.triangles.len(),
            models[1].mesh.triangles.len()
        ),
        (2048, 2048)
    );
    assert!(flat < 100, "a square needs next to nothing, it kept {flat}");
    assert!(round > 600, "the sphere gets the rest, {round}");
    // Part by part each would have got the same.
    let alone = simplify(&models[1..], &[0.2])[0][0].triangles.len();
    assert!(round > alone + 200);
}

#[test]
fn charts_keep_to_themselves_and_nothing_cracks() {
    let model = Model::new(six_charts(16), PrimaryKind::UvSet(0));
    assert_eq!(model.parts.part_count, 6);
    assert_eq!(
        border_edges(&model.mesh.positions, &model.mesh.triangles),
        0
    );
    for lod in &simplify(std::slice::from_ref(&model), &[0.5, 0.2, 0.05])[0] {
        check_arrays(lod);
        assert_eq!(
            border_edges(&lod.positions, &lod.triangles),
            0,
            "{} triangles",
            lod.triangles.len()
        );
        for triangle in &lod.triangles {
            let cells = triangle.map(|v| {
                let uv = model.primary.frame.from_vertex_grid(lod.t3[v as usize]);
                [(uv[0] * 3.0).floor(), (uv[1] * 2.0).floor()]
            });
            assert!(
                cells[0] == cells[1] && cells[1] == cells[2],
                "a triangle spans charts: {cells:?}"
            );
        }
    }
}

#[test]
fn layers_are_those_of_the_part() {
    // Two shells, one in the other: the LoD's outer triangles carry the outer shell's layer.
    let mut mesh = shapes::icosphere(4);
    let inner = mesh.clone();
    let first = mesh.positions.len() as u32;
    mesh.positions
        .extend(inner.positions.iter().map(|p| p.map(|x| 0.5 * x)));
    mesh.normals.extend(&inner.normals);
    mesh.uv_sets[0].extend(&inner.uv_sets[0]);
    mesh.triangles
        .extend(inner.triangles.iter().map(|t| t.map(|v| v + first)));
    mesh.triangle_material.extend(&inner.triangle_material);
    let model = Model::new(mesh, PrimaryKind::Sphere);
    let (outer_layer, inner_layer) = (
        model.parts.triangle_layer[0],
        *model.parts.triangle_layer.last().unwrap(),
    );
    assert_ne!(outer_layer, inner_layer);
    let lod = &simplify(&[model], &[0.1])[0][0];
    for (t, layer) in lod.triangles.iter().zip(&lod.triangle_layer) {
        let p = lod.positions[t[0] as usize];
        let radius = p.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert_eq!(
            *layer,
            if radius > 0.75 {
                outer_layer
            } else {
                inner_layer
            }
        );
    }
}

#[test]
fn the_place_in_the_world_changes_nothing_but_the_budget() {
    let here = simplify(&[sphere(4)], &[0.1]).remove(0).remove(0);
    let there = simplify(&[sphere(4).at(1000.0, [5e4, 0.0, -3e4])], &[0.1])
        .remove(0)
        .remove(0);
    assert!(here.triangles.len().abs_diff(there.triangles.len()) < 4);
    assert!(
        (here.error / there.error - 1.0).abs() < 0.2,
        "errors are in object units: {} {}",
        here.error,
        there.error
    );
    let far = there
        .positions
        .iter()
        .flatten()
        .fold(0.0f32, |a, x| a.max(x.abs()));
    assert!((0.9..1.1).contains(&far), "positions are in object space");
    // A world that cannot be undone is left out.
    let squashed = simplify(&[sphere(3).at(0.0, [0.0; 3])], &[0.2])
        .remove(0)
        .remove(0);
    check_arrays(&squashed);
    assert!(squashed.positions.iter().flatten().all(|x| x.is_finite()));
}

#[test]
fn a_mesh_never_vanishes() {
    let models = [
        sphere(6),
        Model::new(shapes::tetrahedron(), PrimaryKind::Sphere).at(1e-4, [2.0, 0.0, 0.0]),
    ];
    let result = simplify(&models, &[0.5, 0.001]);
    assert!(result.iter().flatten().all(|lod| !lod.triangles.is_empty()));
    let empty = Mesh {
        name: "empty".into(),
        ..Mesh::default()
    };
    let model = Model {
        primary: models[0].primary,
        parts: Parts::default(),
        mesh: empty,
        world: IDENTITY,
    };
    assert!(simplify(&[model], &[0.5])[0][0].triangles.is_empty());
}

#[test]
fn what_cannot_be_reached_is_said() {
    // Where three charts meet a vertex cannot go: eight corners need twelve triangles.
    let model = Model::new(six_charts(8), PrimaryKind::UvSet(0));
    let lod = &simplify(&[model], &[0.005])[0][0];
    assert!(
        !lod.reached && lod.triangles.len() >= 12,
        "{}",
        lod.triangles.len()
    );
}

#[test]
fn skins_come_along() {
    let mut model = sphere(3);
    let bone = |p: &[f32; 3]| u16::from(p[0] > 0.0);
    model.mesh.joints = model
        .mesh
        .positions
        .iter()
        .map(|p| [bone(p), 0, 0, 0])
        .collect();
    model.mesh.weights = vec![[1.0, 0.0, 0.0, 0.0]; model.mesh.positions.len()];
    let lod = &simplify(&[model], &[0.2])[0][0];
    assert_eq!(
        (lod.joints.len(), lod.weights.len()),
        (lod.positions.len(), lod.positions.len())
    );
    let right = lod
        .positions
        .iter()
        .zip(&lod.joints)
        .filter(|(p, j)| p[0].abs() < 0.3 || j[0] == bone(p))
        .count();
    assert_eq!(right, lod.positions.len());
}

#[test]
fn fractions_are_checked() {
    let model = sphere(1);
    let input = LodInput {
        mesh: &model.mesh,
        primary: &model.primary,
        parts: &model.parts,
        world: IDENTITY,
    };
    for bad in [0.0, 1.0, -0.5, 1.5, f32::NAN, f32::INFINITY] {
        let error = chains(&[input], &[0.5, bad]).unwrap_err();
        assert!(error.to_string().starts_with("--lods"), "{error}");
        assert_eq!(error.exit_code(), 2);
    }
    assert_eq!(chains(&[input], &[]).unwrap(), vec![vec![]]);
    assert!(chains(&[], &[0.5]).unwrap().is_empty());
}

#[test]
fn the_same_model_gets_the_same_chain() {
    let models = || {
        [
            sphere(5),
            Model::new(six_charts(8), PrimaryKind::UvSet(0)).at(2.0, [5.0, 0.0, 0.0]),
        ]
    };
    let fractions = [0.5, 0.1, 0.3];
    assert_eq!(
        simplify(&models(), &fractions),
        simplify(&models(), &fractions)
    );
}
