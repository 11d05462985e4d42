//! What lookups answer on small shapes.

use super::super::{BuildOptions, Needs, Reference, build_cpu};
use super::*;
use crate::mesh::{Mesh, shapes};
use crate::param::grid::QUERY_SHIFT;
use crate::param::projection::Line;
use crate::param::{Axis, Primary, PrimaryKind};

/// A tube about z with an outer wall and, nine tenths as wide and facing inwards, an inner one: one part.
fn walls() -> Mesh {
    let mut mesh = shapes::tube(24, 4);
    let (count, outer) = (mesh.positions.len() as u32, mesh.triangles.len());
    for v in 0..count as usize {
        let [x, y, z] = mesh.positions[v];
        mesh.positions.push([0.9 * x, 0.9 * y, z]);
    }
    mesh.normals = vec![[0.0, 0.0, 1.0]; mesh.positions.len()];
    mesh.uv_sets.clear();
    for t in 0..outer {
        let [a, b, c] = mesh.triangles[t].map(|v| v + count);
        mesh.triangles.push([a, c, b]);
    }
    mesh.triangle_material = vec![0; mesh.triangles.len()];
    mesh
}

#[test]
fn an_outer_wall_never_answers_with_the_inner_one() {
    let mesh = walls();
    let outer = mesh.triangles.len() as u32 / 2;
    let primary = Primary::centred(PrimaryKind::Cylinder(Axis::Z), &mesh).unwrap();
    let layers = vec![0; mesh.triangles.len()];
    let layout = Layout::Packed;
    let reference = Reference::new(&mesh, &primary, &layers, layout).unwrap();
    let options = BuildOptions { hash: 64, layout };
    let tables = build_cpu(&reference, &Needs::default(), options).unwrap();
    let side = |t: usize| projection::orientation(Line::Cylinder, &reference.corners(t));
    assert_eq!(side(0), -side(outer as usize));
    let mut changed = 0;
    for (t, triangle) in reference.triangles[..outer as usize].iter().enumerate() {
        // Just outside the inner wall, where a LoD's chord may run.
        let corners = triangle.map(|v| reference.t3[v as usize]);
        let query: [i32; 3] = std::array::from_fn(|k| {
            let mean = corners.iter().map(|c| i64::from(c[k])).sum::<i64>() / 3;
            let near = if k < 2 { mean * 92 / 100 } else { mean };
            (near << QUERY_SHIFT) as i32
        });
        let ask = |side| {
            tables
                .lookup(
                    query,
                    Asker {
                        layer: Some(0),
                        side,
                        grazed: false,
                    },
                    false,
                )
                .unwrap()
        };
        assert!(ask(0).triangle >= outer, "the inner wall is closer");
        assert_eq!(ask(side(t)).triangle, t as u32);
        assert!(ask(-side(t)).triangle >= outer);
        changed += 1;
    }
    assert!(changed > 0);
}

#[test]
fn the_orientation_is_the_sense_of_the_hits() {
    let mesh = shapes::icosphere(2);
    for kind in [
        PrimaryKind::Sphere,
        PrimaryKind::Cylinder(Axis::Z),
        PrimaryKind::Plane(Axis::Z),
    ] {
        let primary = Primary::centred(kind, &mesh).unwrap();
        let layers = vec![0; mesh.triangles.len()];
        let reference = Reference::new(&mesh, &primary, &layers, Layout::Packed).unwrap();
        for t in 0..reference.triangles.len() {
            let corners = reference.corners(t);
            let middle: [i32; 3] = std::array::from_fn(|k| {
                let sum: i64 = corners.iter().map(|c| i64::from(c[k])).sum();
                ((sum << QUERY_SHIFT) / 3) as i32
            });
            if let Some(hit) = projection::hit(primary.line(), middle, &corners) {
                assert_eq!(hit.sense, projection::orientation(primary.line(), &corners));
            }
        }
    }
}

#[test]
fn a_grazed_triangle_gets_the_nearest_point() {
    let mesh = shapes::icosphere(2);
    let primary = Primary::centred(PrimaryKind::Plane(Axis::Z), &mesh).unwrap();
    let (layout, layers) = (Layout::Packed, vec![0; mesh.triangles.len()]);
    let reference = Reference::new(&mesh, &primary, &layers, layout).unwrap();
    let options = BuildOptions { hash: 32, layout };
    let tables = build_cpu(&reference, &Needs::default(), options).unwrap();
    let mut grazed = 0;
    for t in 0..reference.triangles.len() {
        let corners = reference.corners(t);
        let asker = Asker::of(Line::Parallel, &corners, Some(0));
        let middle: [i32; 3] = std::array::from_fn(|k| {
            let sum: i64 = corners.iter().map(|c| i64::from(c[k])).sum();
            ((sum << QUERY_SHIFT) / 3) as i32
        });
        let found = tables.lookup(middle, asker, true).unwrap();
        assert_eq!((found.triangle, found.hit), (t as u32, !asker.grazed));
        assert!(!asker.grazed || tables.lookup(middle, asker, false).is_none_or(|f| f.hit));
        grazed += u32::from(asker.grazed);
    }
    assert!(
        grazed > 0,
        "the sphere's equator stands upright over the plane"
    );
}
