//! Cages, meshes that belong together by name, and texture coordinates in several tiles: known answers and refusals.

mod pair;

use invertex::asset::Progress;
use invertex::mesh::{Mesh, shapes};
use invertex::output::{TexturedMesh, encode_glb};
use invertex::recover::{BakeAttribute, Baked, Mapping, Pair, PairSettings};
use invertex::render::Renderer;
use invertex::scene::Scene;
use invertex::{Error, Result};
use pair::{Quiet, placed, plane, positions, scene};

const UPRIGHT: [[f32; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// A scene of several meshes, each with its name.
fn several(name: &str, meshes: &[(&str, Mesh)]) -> Scene {
    let named: Vec<Mesh> = meshes
        .iter()
        .map(|(name, mesh)| Mesh {
            name: (*name).to_owned(),
            ..mesh.clone()
        })
        .collect();
    let textured = |mesh| TexturedMesh {
        mesh,
        textures: vec![],
        places: vec![UPRIGHT],
    };
    let all: Vec<TexturedMesh> = named.iter().map(textured).collect();
    Scene::from_bytes(name, &encode_glb(&all).unwrap(), None).unwrap()
}

fn in_cage(high: &Scene, low: &Scene, cage: &Scene, settings: &PairSettings) -> Result<Baked> {
    let draw = |picture| Ok(Renderer::cpu(picture));
    Pair::in_cage((high, low, Some(cage)), settings, &draw, &Quiet)?.bake(0, &Quiet)
}

fn moved(mesh: &Mesh, by: impl Fn([f32; 3]) -> [f32; 3]) -> Mesh {
    let mut out = mesh.clone();
    out.positions.iter_mut().for_each(|p| *p = by(*p));
    out
}

/// Rays run from the cage's point through the low one's: of a cage shifted aside they slant by as much.
#[test]
fn rays_run_from_the_cage_through_the_surface() {
    let (high, low) = (plane(6, -0.1, 0.0), plane(3, 0.0, 0.0));
    let cage = moved(&low, |[x, y, z]| [x + 0.05, y - 0.1, z + 0.2]);
    let (high, low, cage) = (
        scene(
            "high",
            &moved(&high, |[x, y, z]| [x * 3.0 - 1.0, y * 3.0 - 1.0, z]),
        ),
        scene("low", &low),
        scene("cage", &cage),
    );
    let baked = in_cage(&high, &low, &cage, &positions(Mapping::Cage)).unwrap();
    assert_eq!((baked.filled, baked.missed), (64 * 64, 0));
    for (k, [x, y, z, _]) in baked.textures[0].values.iter().enumerate() {
        let [u, v] = [k % 64, k / 64].map(|c| (c as f32 + 0.5) / 64.0);
        // From 0.2 over the plane to 0.1 under it: half as far again beyond the surface.
        let want = [u - 0.025, v + 0.05, -0.1];
        for (a, b) in [*x, *y, *z].iter().zip(want) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }
    // The negative control: straight rays, from a cage by offset, come out elsewhere.
    let draw = |picture| Ok(Renderer::cpu(picture));
    let asked = positions(Mapping::Cage);
    let straight = Pair::new(&high, &low, &asked, &draw, &Quiet)
        .unwrap()
        .bake(0, &Quiet)
        .unwrap();
    let apart = |k: usize| straight.textures[0].values[k][0] - baked.textures[0].values[k][0];
    assert!((0..64 * 64).all(|k| (apart(k) - 0.025).abs() < 1e-5));
}

/// What lies outside of the cage is not seen from it.
#[test]
fn a_cage_leaves_out_what_lies_over_it() {
    let (floor, lid) = (plane(4, 0.02, 0.0), plane(4, 0.5, 0.0));
    let high = several("high", &[("floor", floor), ("lid", lid)]);
    let low = plane(2, 0.0, 0.0);
    for (height, want) in [(0.3, 0.02), (0.7, 0.5)] {
        let cage = scene("cage", &moved(&low, |[x, y, z]| [x, y, z + height]));
        let baked = in_cage(&high, &scene("low", &low), &cage, &positions(Mapping::Cage)).unwrap();
        assert_eq!(baked.missed, 0);
        assert!(
            baked.textures[0]
                .values
                .iter()
                .all(|v| (v[2] - want).abs() < 1e-6)
        );
    }
}

#[test]
fn a_cage_stands_where_mirrored_models_stand() {
    let mirror = |name: &str, mesh: &Mesh| {
        let mut place = UPRIGHT;
        place[0][0] = -1.0;
        placed(name, mesh, place)
    };
    let (high, low) = (plane(5, 0.05, 0.0), plane(2, 0.0, 0.0));
    let cage = moved(&low, |[x, y, z]| [x, y, z + 0.1]);
    // A cage whose vertices are split as tools split them is the same cage.
    let mut split = cage.clone();
    split.positions = cage
        .triangles
        .iter()
        .flatten()
        .map(|&v| cage.positions[v as usize])
        .collect();
    split.normals = vec![[0.0, 0.0, 1.0]; split.positions.len()];
    split.triangles = (0..cage.triangles.len() as u32)
        .map(|t| [0, 1, 2].map(|k| 3 * t + k))
        .collect();
    (split.uv_sets, split.tangents) = (vec![], vec![]);
    let (high, low) = (mirror("high", &high), mirror("low", &low));
    for cage in [cage, split] {
        let asked = positions(Mapping::Cage);
        let baked = in_cage(&high, &low, &mirror("cage", &cage), &asked).unwrap();
        assert_eq!(baked.missed, 0);
        for (k, [x, y, ..]) in baked.textures[0].values.iter().enumerate() {
            let [u, v] = [k % 64, k / 64].map(|c| (c as f32 + 0.5) / 64.0);
            assert!((x + u).abs() < 1e-5 && (y - v).abs() < 1e-5);
        }
    }
}

#[test]
fn what_is_no_cage_of_the_model_is_refused() {
    let (high, low) = (scene("high", &plane(3, 0.05, 0.0)), plane(2, 0.0, 0.0));
    let refused = |cage: &Mesh, mapping: Mapping| {
        let outcome = in_cage(
            &high,
            &scene("low", &low),
            &scene("cage", cage),
            &positions(mapping),
        );
        outcome.map(|_| ()).unwrap_err().to_string()
    };
    let up = |mesh: &Mesh| moved(mesh, |[x, y, z]| [x, y, z + 0.1]);
    assert!(refused(&up(&plane(3, 0.0, 0.0)), Mapping::Cage).contains("has 18 triangles where"));
    let mut shuffled = up(&low);
    shuffled.triangles.swap(0, 5);
    assert!(refused(&shuffled, Mapping::Cage).contains("or in another order"));
    assert!(refused(&up(&low), Mapping::Normal).starts_with("--cage"));
    let two = several("cage", &[("a", up(&low)), ("b", up(&low))]);
    let none = in_cage(&high, &scene("low", &low), &two, &positions(Mapping::Cage));
    assert!(none.unwrap_err().to_string().contains("no such mesh"));
}

/// Two planes one over the other: by name each low one takes its own, though the other is nearer.
#[test]
fn meshes_belong_together_by_name() {
    let at = |z: f32| plane(3, z, 0.0);
    let high = several("high", &[("top_high", at(1.0)), ("Bottom_HP.001", at(0.0))]);
    let low = several("low", &[("top_low", at(0.3)), ("bottom_lp", at(0.7))]);
    for (by_name, wants) in [(true, [1.0, 0.0]), (false, [0.0, 1.0])] {
        let asked = PairSettings {
            by_name,
            ..positions(Mapping::Proximity)
        };
        let draw = |picture| Ok(Renderer::cpu(picture));
        let mut pair = Pair::new(&high, &low, &asked, &draw, &Quiet).unwrap();
        for (k, want) in wants.into_iter().enumerate() {
            let baked = pair.bake(k, &Quiet).unwrap();
            let values = &baked.textures[0].values;
            assert!(
                values.iter().all(|v| (v[2] - want).abs() < 1e-6),
                "{by_name} {k}"
            );
        }
    }
}

/// Four charts side by side in tiles 1001, 1002 and 1011 are baked into three textures that hold what one would.
#[test]
fn tiles_are_textures_of_their_own() {
    // Columns of the plane: x below 1/3 in tile 1001, then 1002, the rest in 1011.
    let mut low = plane(3, 0.0, 0.0);
    let corners = low.triangles.clone();
    let mut split = Mesh {
        triangles: vec![],
        positions: vec![],
        normals: vec![],
        uv_sets: vec![vec![]],
        tangents: vec![],
        ..low.clone()
    };
    for t in corners {
        let middle: f32 = t.iter().map(|&v| low.positions[v as usize][0]).sum::<f32>() / 3.0;
        let column = (middle * 3.0).floor();
        let shift = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][column as usize];
        let first = split.positions.len() as u32;
        for v in t {
            let p = low.positions[v as usize];
            split.positions.push(p);
            split.normals.push([0.0, 0.0, 1.0]);
            split.uv_sets[0].push([p[0] * 3.0 - column + shift[0], p[1] + shift[1]]);
        }
        split.triangles.push([first, first + 1, first + 2]);
    }
    let high = scene("high", &plane(7, 0.05, 0.0));
    let asked = positions(Mapping::Normal);
    let draw = |picture| Ok(Renderer::cpu(picture));
    let low_scene = scene("low", &split);
    let mut pair = Pair::new(&high, &low_scene, &asked, &draw, &Quiet).unwrap();
    let tiles: Vec<Option<u32>> = (0..pair.count()).map(|k| pair.tile(k)).collect();
    assert_eq!(tiles, [Some(1001), Some(1002), Some(1011)]);
    for k in 0..3 {
        let baked = pair.bake(k, &Quiet).unwrap();
        assert_eq!((baked.filled, baked.missed), (64 * 64, 0));
        for (at, [x, y, ..]) in baked.textures[0].values.iter().enumerate() {
            let [u, v] = [at % 64, at / 64].map(|c| (c as f32 + 0.5) / 64.0);
            assert!((x - (u + k as f32) / 3.0).abs() < 1e-5 && (y - v).abs() < 1e-5);
        }
        let mesh = baked.low.unwrap();
        assert_eq!(mesh.triangles.len(), 6);
        let inside = mesh.uv_sets[0]
            .iter()
            .flatten()
            .all(|c| (0.0..=1.0).contains(c));
        assert!(inside, "what viewers get lies in the unit square");
    }
    // All in one tile other than the first: moved, as ever, and said.
    low.uv_sets[0].iter_mut().for_each(|uv| uv[0] += 3.0);
    let one = scene("low", &low);
    let pair = Pair::new(&high, &one, &asked, &draw, &Quiet).unwrap();
    assert_eq!((pair.count(), pair.tile(0)), (1, None));
    assert!(pair.warnings[0].contains("from tile 3, 0 to 0, 0"));
}

#[test]
fn tiles_that_cannot_be_are_refused() {
    let high = scene("high", &shapes::grid(2));
    let refused = |low: &Mesh| {
        let draw = |picture| Ok(Renderer::cpu(picture));
        let (low, asked) = (scene("low", low), positions(Mapping::Normal));
        let outcome = Pair::new(&high, &low, &asked, &draw, &Quiet).map(|_| ());
        outcome.unwrap_err().to_string()
    };
    // Triangles over a border.
    let mut low = plane(3, 0.0, 0.0);
    low.uv_sets[0].iter_mut().for_each(|uv| uv[1] += 0.5);
    assert!(refused(&low).contains("along v: out of its tile"));
    // Columns beyond the tenth, rows below the first.
    for by in [[10.0, 0.0], [0.0, -1.0]] {
        let mut low = plane(2, 0.0, 0.0);
        let far: Vec<u32> = low.triangles[6..].as_flattened().to_vec();
        let mut copy = low.clone();
        copy.triangles = low.triangles[6..].to_vec();
        low.triangles.truncate(6);
        let first = low.positions.len() as u32;
        low.positions.extend(&copy.positions);
        low.normals.extend(&copy.normals);
        let moved = copy.uv_sets[0]
            .iter()
            .map(|uv| [uv[0] + by[0], uv[1] + by[1]]);
        low.uv_sets[0].extend(moved);
        low.tangents.clear();
        low.triangles.extend(
            far.chunks(3)
                .map(|t| [t[0] + first, t[1] + first, t[2] + first]),
        );
        assert!(refused(&low).contains("no UDIM number"), "{by:?}");
    }
}

/// Somebody who ends the work after so many words.
struct Until(std::cell::Cell<u32>);

// The walk asks from the thread that began it.
impl Progress for Until {
    fn at(&self, _: &'static str, _: &str, _: usize, _: usize) {
        self.0.set(self.0.get().saturating_sub(1));
    }

    fn cancelled(&self) -> bool {
        self.0.get() == 0
    }
}

/// One texture at a time or all at once: the same texels; and what was handed over before a cancel stays.
#[test]
fn little_memory_makes_the_same_textures_one_by_one() {
    let (high, low) = (scene("high", &shapes::icosphere(4)), shapes::icosphere(2));
    let low = scene(
        "low",
        &Mesh {
            uv_sets: vec![],
            tangents: vec![],
            ..low
        },
    );
    let attributes = [
        BakeAttribute::Normal,
        BakeAttribute::Position,
        BakeAttribute::Curvature,
        BakeAttribute::Mapping,
    ];
    let with = |memory: u64| PairSettings {
        attributes: attributes.to_vec(),
        memory,
        padding: 3,
        ..positions(Mapping::Normal)
    };
    let (all, single) = (with(1 << 30), with(1));
    let draw = |picture| Ok(Renderer::cpu(picture));
    let once = Pair::new(&high, &low, &all, &draw, &Quiet)
        .unwrap()
        .bake(0, &Quiet)
        .unwrap();
    let mut pair = Pair::new(&high, &low, &single, &draw, &Quiet).unwrap();
    let by_one = pair.bake(0, &Quiet).unwrap();
    assert_eq!((once.mask.len(), by_one.textures.len()), (64 * 64, 4));
    assert_eq!((&once.mask, once.filled), (&by_one.mask, by_one.filled));
    for (a, b) in once.textures.iter().zip(&by_one.textures) {
        assert_eq!((&a.attribute, &a.values), (&b.attribute, &b.values));
    }
    // Each walk says one word: the third is never begun.
    let mut handed = Vec::new();
    let until = Until(2.into());
    let outcome = pair.bake_each(0, &until, &mut |texture| {
        handed.push(texture);
        Ok(())
    });
    assert!(matches!(outcome, Err(Error::Cancelled)));
    assert_eq!(handed.len(), 2);
    assert_eq!(handed[1].values, once.textures[1].values);
    // Whoever takes textures may end the work as well.
    let full = pair.bake_each(0, &Quiet, &mut |_| Err(Error::Cancelled));
    assert!(matches!(full, Err(Error::Cancelled)));
}
