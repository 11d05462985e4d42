//! Visibility across the borders of tiles of texture coordinates: what lies in two tiles gets what it gets in one.

mod pair;

use invertex::mesh::Mesh;
use invertex::output::{TexturedMesh, encode_glb};
use invertex::recover::{Mapping, Pair};
use invertex::render::Renderer;
use invertex::scene::Scene;
use pair::{Quiet, plane, positions, scene};

/// One wall of a valley along y, left of x = 0 or right of it, as a chart that fills half a tile.
fn wall(right: bool, deeper: f32, tile: f32) -> Mesh {
    let mut wall = plane(4, 0.0, 0.0);
    let (from, side) = if right { (0.0, -1.0) } else { (-1.0, 1.0) };
    for (p, uv) in wall.positions.iter_mut().zip(&mut wall.uv_sets[0]) {
        *uv = [(p[0] + from + 1.0) * 0.5 + tile, p[1]];
        p[0] += from;
        p[2] = 2.0 * p[0].abs() - deeper;
    }
    let normal = [side * 2.0 / 5f32.sqrt(), 0.0, 1.0 / 5f32.sqrt()];
    wall.normals.fill(normal);
    wall.tangents.clear();
    wall
}

/// Two meshes as one.
fn joined(a: &Mesh, b: &Mesh) -> Mesh {
    let (mut all, first) = (a.clone(), a.positions.len() as u32);
    all.positions.extend(&b.positions);
    all.normals.extend(&b.normals);
    all.uv_sets[0].extend(&b.uv_sets[0]);
    let moved = b.triangles.iter().map(|t| t.map(|v| v + first));
    all.triangles.extend(moved);
    all.triangle_material.extend(&b.triangle_material);
    all
}

/// A scene of two meshes.
fn two(name: &str, meshes: [&Mesh; 2]) -> Scene {
    let upright = glam::Mat4::IDENTITY.to_cols_array_2d();
    let textured = meshes.map(|mesh| TexturedMesh {
        mesh,
        textures: vec![],
        places: vec![upright],
    });
    Scene::from_bytes(name, &encode_glb(&textured).unwrap(), None).unwrap()
}

/// Directions of visibility know no border between tiles: charts in two tiles get what they get in one.
#[test]
fn visibility_is_filtered_across_the_borders_of_tiles() {
    let high = scene(
        "high",
        &joined(&wall(false, 0.05, 0.0), &wall(true, 0.05, 0.0)),
    );
    let asked = positions(Mapping::VisibilityTexel);
    let baked = |low: &Scene| -> Vec<Vec<[f32; 4]>> {
        let draw = |picture| Ok(Renderer::cpu(picture));
        let mut pair = Pair::new(&high, low, &asked, &draw, &Quiet).unwrap();
        let surfaces = pair.count();
        // What is blank holds the mean of its tile.
        let shown = |v: [f32; 4]| if v[3] == 0.0 { [0.0; 4] } else { v };
        let bake = |k| -> Vec<[f32; 4]> {
            let baked = pair.bake(k, &Quiet).unwrap();
            baked.textures[0]
                .values
                .iter()
                .copied()
                .map(shown)
                .collect()
        };
        (0..surfaces).map(bake).collect()
    };
    let left = wall(false, 0.0, 0.0);
    let one = baked(&scene("low", &joined(&left, &wall(true, 0.0, 0.0))));
    let tiles = baked(&scene("low", &joined(&left, &wall(true, 0.0, 1.0))));
    let apart = baked(&two("low", [&left, &wall(true, 0.0, 0.0)]));
    assert_eq!([one.len(), tiles.len(), apart.len()], [1, 2, 2]);
    let of = |all: &[Vec<[f32; 4]>], x: usize, y: usize| all[x / 32 * (all.len() - 1)][y * 64 + x];
    let texels = || (0..64 * 64).map(|k| (k % 64, k / 64));
    for (x, y) in texels() {
        assert_eq!(of(&tiles, x, y), of(&one, x, y), "{x} {y}");
    }
    // Meshes that touch without being one are left apart, and that shows.
    let differ = texels().filter(|&(x, y)| of(&apart, x, y) != of(&one, x, y));
    assert!(differ.count() > 64);
}
