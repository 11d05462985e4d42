//! The tree against asking every triangle, to the bit; the arithmetic against definitions in double precision.

use super::*;
use crate::mesh::shapes;
use glam::DVec3;

/// Triangles of every size: a ball, a grid in its middle, slivers, a point, and some twice.
fn triangles() -> Vec<[V3; 3]> {
    let (ball, grid) = (shapes::icosphere(4), shapes::grid(13));
    let of = |mesh: &crate::mesh::Mesh| -> Vec<[V3; 3]> {
        (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect()
    };
    let mut all = of(&ball);
    all.extend(of(&grid));
    all.push([[0.2; 3]; 3]);
    all.push([[-1.0, 0.3, 0.1], [1.0, 0.3, 0.1], [0.0, 0.300_01, 0.1]]);
    all.push([[-2.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    all.extend_from_within(..40);
    all
}

/// Numbers in -1..1 without a pattern.
fn noise(k: u32) -> V3 {
    [0.731_f64, 0.377, 0.913].map(|step| ((f64::from(k) * step).fract() * 2.0 - 1.0) as f32)
}

fn questions() -> impl Iterator<Item = (V3, V3)> {
    (0..3000).map(|k| {
        let (p, mut way) = (noise(k).map(|c| c * 1.6), noise(k + 7919));
        match k % 5 {
            // Through corners and along edges: many triangles are equally near.
            0 => way = [0.0, way[1], 0.0],
            1 => return ([0.0, 0.0, (k as f32 * 0.01).fract()], [0.5, 0.5, 0.0]),
            _ => {}
        }
        (p, way)
    })
}

#[test]
fn closest_points_are_those_of_asking_every_triangle() {
    let all = triangles();
    let tree = Bvh::new(&all);
    let single: Vec<Bvh> = all.iter().map(|t| Bvh::new(&[*t])).collect();
    let mut asking = tree.asking();
    let (mut hint, mut ties, mut none) = (NO_HINT, 0, 0);
    for (k, (p, way)) in questions().enumerate() {
        let facing = (k % 3 == 0).then_some(way);
        let within = if k % 4 == 0 { 0.02 } else { f32::INFINITY };
        let each = single.iter().enumerate().filter_map(|(t, one)| {
            let found = one.asking().closest(p, within, facing, NO_HINT)?;
            Some((found.distance, t as u32, found.b))
        });
        let each: Vec<_> = each.collect();
        let best = each
            .iter()
            .copied()
            .reduce(|a, b| if (b.0, b.1) < (a.0, a.1) { b } else { a });
        let found = asking.closest(p, within, facing, hint);
        assert_eq!(
            found.map(|f| (f.distance, f.triangle, f.b)),
            best,
            "{p:?} {way:?}"
        );
        hint = found.map_or(hint, |f| f.hint);
        ties += u32::from(best.is_some_and(|b| each.iter().filter(|e| e.0 == b.0).count() > 1));
        none += u32::from(best.is_none());
    }
    assert!(ties > 300 && none > 100, "{ties} {none}");
}

#[test]
fn first_hits_are_those_of_asking_every_triangle() {
    let all = triangles();
    let tree = Bvh::new(&all);
    // With the margin of the whole, which is part of what a hit is.
    let lone = |t: &[V3; 3]| Bvh {
        low: tree.low,
        high: tree.high,
        largest: tree.largest,
        ..Bvh::new(&[*t])
    };
    let single: Vec<Bvh> = all.iter().map(lone).collect();
    let mut asking = tree.asking();
    let mut hits = [0; 3];
    for (k, (begin, way)) in questions().enumerate() {
        let sides = [Sides::Both, Sides::Front, Sides::Back][k % 3];
        let reach = if k % 4 == 0 { 0.8 } else { f32::INFINITY };
        let ray = Ray {
            begin,
            way,
            reach,
            sides,
        };
        let each = single.iter().enumerate().filter_map(|(t, one)| {
            let found = one.asking().first(ray)?;
            Some((found.distance, t as u32, found.b))
        });
        let best = each.reduce(|a, b| if (b.0, b.1) < (a.0, a.1) { b } else { a });
        let found = asking.first(ray).map(|f| (f.distance, f.triangle, f.b));
        assert_eq!(found, best, "{begin:?} {way:?}");
        assert_eq!(asking.meets(ray), best.is_some());
        hits[k % 3] += u32::from(best.is_some());
    }
    assert!(hits.iter().all(|&h| h > 50), "{hits:?}");
}

/// From the same place the other way; the same triangles count.
fn reversed(ray: Ray) -> Ray {
    Ray {
        way: ray.way.map(|c| -c),
        sides: match ray.sides {
            Sides::Both => Sides::Both,
            Sides::Front => Sides::Back,
            Sides::Back => Sides::Front,
        },
        ..ray
    }
}

/// A line asked in one walk: what the ray and then its reverse find, to the bit but for the signs of zeros.
#[test]
fn both_halves_of_a_line_are_its_two_rays() {
    let tree = Bvh::new(&triangles());
    let mut asking = tree.asking();
    let (mut ahead, mut behind) = ([0; 3], [0; 3]);
    for (k, (begin, way)) in questions().enumerate() {
        let ray = Ray {
            begin,
            way,
            reach: if k % 4 == 0 { f32::INFINITY } else { 0.4 },
            sides: [Sides::Both, Sides::Front, Sides::Back][k % 3],
        };
        let first = asking.first(ray);
        let apart = first.or_else(|| asking.first(reversed(ray)));
        assert_eq!(asking.first_of_both(ray, None), apart, "{ray:?}");
        ahead[k % 3] += u32::from(first.is_some());
        behind[k % 3] += u32::from(first.is_none() && apart.is_some());
    }
    assert!(
        ahead.iter().chain(&behind).all(|&n| n > 10),
        "{ahead:?} {behind:?}"
    );
}

/// The closest point by bisection of nothing: the nearest of many points of the triangle is never nearer.
#[test]
fn no_point_of_a_triangle_is_nearer_than_its_closest_one() {
    for k in 0..400 {
        let corners = [noise(3 * k), noise(3 * k + 1), noise(3 * k + 2)];
        let p = noise(k + 4001).map(|c| c * 2.0);
        let found = Bvh::new(&[corners])
            .asking()
            .closest(p, f32::INFINITY, None, NO_HINT)
            .unwrap();
        let at = |b: [f64; 3]| -> DVec3 {
            (0..3)
                .map(|i| DVec3::from_array(corners[i].map(f64::from)) * b[i])
                .sum()
        };
        let p = DVec3::from_array(p.map(f64::from));
        let distance = at(found.b.map(f64::from)).distance(p);
        assert!((distance - f64::from(found.distance).sqrt()).abs() < 1e-5);
        for i in 0..=20 {
            for j in 0..=20 - i {
                let (v, w) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let other = at([1.0 - v - w, v, w]).distance(p);
                assert!(other > distance - 1e-5, "{k}: {other} < {distance}");
            }
        }
    }
}

#[test]
fn a_closed_surface_is_hit_from_inside_whatever_edge_the_ray_meets() {
    let ball = shapes::icosphere(3);
    let corners: Vec<[V3; 3]> = (0..ball.triangles.len()).map(|t| ball.corners(t)).collect();
    let tree = Bvh::new(&corners);
    let mut asking = tree.asking();
    let towards = |t: usize, b: [f32; 3]| -> V3 {
        [0, 1, 2].map(|k| (0..3).map(|i| b[i] * corners[t][i][k]).sum())
    };
    for t in 0..corners.len() {
        // Through corners, middles of edges and the middle.
        for b in [
            [1.0, 0.0, 0.0],
            [0.5, 0.5, 0.0],
            [0.0, 0.3, 0.7],
            [0.3, 0.3, 0.4],
        ] {
            let ray = |sides| Ray {
                begin: [0.0; 3],
                way: towards(t, b),
                reach: 2.0,
                sides,
            };
            let found = asking.first(ray(Sides::Back)).expect("no gap");
            assert!((found.distance - 1.0).abs() < 1e-5);
            assert!(
                asking.first(ray(Sides::Front)).is_none(),
                "the ball faces outwards"
            );
        }
    }
}

#[test]
fn nothing_has_no_closest_point_and_no_hit() {
    let tree = Bvh::new(&[]);
    assert!(
        tree.asking()
            .closest([0.0; 3], f32::INFINITY, None, 5)
            .is_none()
    );
    let ray = Ray {
        begin: [0.0; 3],
        way: [1.0, 0.0, 0.0],
        reach: f32::INFINITY,
        sides: Sides::Both,
    };
    assert!(tree.asking().first(ray).is_none() && !tree.asking().meets(ray));
    assert_eq!(tree.diagonal(), 0.0);
}

/// Ten thousand copies of one triangle, and ever smaller ones towards a corner, make no deep tree.
#[test]
fn hostile_triangles_make_no_deep_tree() {
    let one: [V3; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut all = vec![one; 10_000];
    all.extend((0..120).map(|k| one.map(|p| p.map(|c| c * 0.5f32.powi(k) + 3.0 * 0.5f32.powi(k)))));
    let tree = Bvh::new(&all);
    let found = tree
        .asking()
        .closest([0.2, 0.2, -0.5], f32::INFINITY, None, NO_HINT)
        .unwrap();
    assert_eq!((found.triangle, found.distance), (0, 0.25));
}
