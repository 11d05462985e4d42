//! Parts are a partition by connection; layers tell apart whatever answers for the same place.

use invertex::mesh::{Mesh, Weld, shapes};
use invertex::param::{Axis, Parts, Primary, PrimaryKind, parts};

/// Deterministic pseudo-random numbers in [0, 1) (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// `count` small copies of `shape`, each placed by `place(uv or position)`.
fn copies(
    shape: &Mesh,
    count: usize,
    mut place: impl FnMut(usize, [f32; 3], [f32; 2]) -> ([f32; 3], [f32; 2]),
) -> Mesh {
    let mut out = Mesh {
        name: "copies".into(),
        uv_sets: vec![vec![]],
        ..Mesh::default()
    };
    for copy in 0..count {
        let first = out.positions.len() as u32;
        for (p, uv) in shape.positions.iter().zip(&shape.uv_sets[0]) {
            let (p, uv) = place(copy, *p, *uv);
            out.positions.push(p);
            out.uv_sets[0].push(uv);
        }
        out.normals.extend(&shape.normals);
        out.triangles
            .extend(shape.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    out.triangle_material = vec![0; out.triangles.len()];
    out
}

/// Rotated squares thrown on the unit square.
fn thrown(count: usize, size: f32, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let placed: Vec<[f32; 3]> = (0..count)
        .map(|_| [0; 3].map(|_| random.next() as f32))
        .collect();
    copies(&shapes::grid(2), count, |copy, p, uv| {
        let [x, y, turn] = placed[copy];
        let (sin, cos) = (turn * 6.0).sin_cos();
        let [u, v] = uv.map(|x| (x - 0.5) * size);
        (
            [p[0], p[1], copy as f32],
            [x + cos * u - sin * v, y + sin * u + cos * v],
        )
    })
}

fn contains(corners: [[f32; 2]; 3], at: [f64; 2]) -> bool {
    let side = |i: usize| {
        let [a, b] = [corners[i], corners[(i + 1) % 3]].map(|p| p.map(f64::from));
        (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0])
    };
    let sides = [side(0), side(1), side(2)];
    sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0)
}

/// Random points where two different parts of the same layer both answer.
fn conflicts(mesh: &Mesh, parts: &Parts) -> usize {
    let mut random = Random(7);
    let mut found = 0;
    for _ in 0..2000 {
        let at = [random.next(), random.next()];
        let mut owner = [None; 256];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            if contains(triangle.map(|v| mesh.uv_sets[0][v as usize]), at) {
                let slot = &mut owner[parts.triangle_layer[t] as usize];
                found += usize::from(slot.is_some_and(|part| part != parts.triangle_part[t]));
                *slot = Some(parts.triangle_part[t]);
            }
        }
    }
    found
}

fn primary(kind: PrimaryKind, mesh: &Mesh) -> Primary {
    Primary::new(kind, mesh, [0.0; 3]).unwrap()
}

#[test]
fn layers_never_conflict_and_the_check_can_fail() {
    let mesh = thrown(60, 0.3, 1);
    let primary = primary(PrimaryKind::UvSet(0), &mesh);
    let mut parts = parts(&mesh, &primary);
    assert_eq!((parts.part_count, parts.crowded_parts), (60, 0));
    assert_eq!(conflicts(&mesh, &parts), 0);
    let layers = 1 + *parts.triangle_layer.iter().max().unwrap() as usize;
    assert!((2..60).contains(&layers), "{layers} layers for 60 parts");
    parts.triangle_layer.fill(0);
    assert!(
        conflicts(&mesh, &parts) > 0,
        "without layers parts answer for each other"
    );
}

#[test]
fn parts_are_the_connected_components() {
    for mesh in [
        thrown(20, 0.1, 3),
        shapes::uv_sphere(12, 6),
        shapes::icosphere(2),
    ] {
        for kind in [
            PrimaryKind::UvSet(0),
            PrimaryKind::Sphere,
            PrimaryKind::Cylinder(Axis::Y),
        ] {
            let found = parts(&mesh, &primary(kind, &mesh));
            assert_eq!(found.triangle_part.len(), mesh.triangles.len());
            let weld = match kind {
                PrimaryKind::UvSet(_) => Weld::by_position_and_uv(&mesh, 0),
                _ => Weld::by_position(&mesh.positions),
            };
            // One part per vertex, parts numbered by first appearance, and none empty.
            let mut of_vertex = vec![None; mesh.positions.len()];
            let mut seen = 0;
            for (t, triangle) in weld.triangles(&mesh.triangles).iter().enumerate() {
                let part = found.triangle_part[t];
                assert!(part <= seen, "part {part} before {seen}");
                seen = seen.max(part + 1);
                for &v in triangle {
                    assert_eq!(*of_vertex[v as usize].get_or_insert(part), part);
                }
            }
            assert_eq!(seen as usize, found.part_count);
        }
    }
}

#[test]
fn one_part_has_one_layer() {
    let mesh = shapes::icosphere(3);
    let found = parts(&mesh, &primary(PrimaryKind::Sphere, &mesh));
    assert_eq!(found.part_count, 1);
    assert!(found.triangle_layer.iter().all(|&l| l == 0));
}

#[test]
fn nested_shells_get_different_layers_and_distant_ones_the_same() {
    let shells = copies(&shapes::icosphere(2), 3, |copy, p, uv| {
        (p.map(|x| x * (1.0 + copy as f32)), uv)
    });
    for kind in [
        PrimaryKind::Sphere,
        PrimaryKind::Cylinder(Axis::X),
        PrimaryKind::Plane(Axis::Z),
    ] {
        let found = parts(&shells, &primary(kind, &shells));
        let third = found.triangle_layer.len() / 3;
        let mut layers = [0, third, 2 * third].map(|t| found.triangle_layer[t]);
        layers.sort_unstable();
        assert_eq!(layers, [0, 1, 2], "{kind:?}");
    }
    let apart = copies(&shapes::icosphere(1), 2, |copy, p, uv| {
        ([p[0] + 20.0 * (copy as f32 - 0.5), p[1], p[2]], uv)
    });
    let found = parts(&apart, &primary(PrimaryKind::Sphere, &apart));
    assert!(
        found.triangle_layer.iter().all(|&l| l == 0),
        "they are seen in opposite directions"
    );
}

#[test]
fn neighbours_across_a_fold_of_the_domain_keep_apart() {
    // Two strips on both sides of the edge of the cube's faces x and y, closer than a LoD may move a border.
    let gap = 0.004;
    let strip = copies(&shapes::grid(2), 2, |copy, p, uv| {
        let angle = std::f32::consts::FRAC_PI_4
            + if copy == 0 {
                -gap - 0.2 * p[0]
            } else {
                gap + 0.2 * p[0]
            };
        ([angle.cos(), angle.sin(), 0.3 * p[1]], uv)
    });
    for kind in [PrimaryKind::Sphere, PrimaryKind::Cylinder(Axis::Z)] {
        let found = parts(&strip, &primary(kind, &strip));
        let last = found.triangle_layer.len() - 1;
        assert_ne!(
            found.triangle_layer[0], found.triangle_layer[last],
            "{kind:?}"
        );
    }
}

#[test]
fn more_parts_than_layers_share_the_last_and_say_so() {
    let pile = copies(&shapes::grid(1), 300, |copy, p, uv| {
        ([p[0], p[1], copy as f32], uv)
    });
    let found = parts(&pile, &primary(PrimaryKind::UvSet(0), &pile));
    assert_eq!((found.part_count, found.crowded_parts), (300, 45));
    assert_eq!(*found.triangle_layer.iter().max().unwrap(), 254);
}

#[test]
fn the_same_mesh_gets_the_same_layers() {
    let mesh = thrown(100, 0.4, 9);
    let primary = primary(PrimaryKind::UvSet(0), &mesh);
    assert_eq!(parts(&mesh, &primary), parts(&mesh, &primary));
}
