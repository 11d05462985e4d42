//! Colour deviations of real models, whose textures are read as the renderer reads them.
//! Spot in the suite; every shared model with `INVERTEX_LONG=1`.

mod colour;
#[path = "long/mod.rs"]
mod long;

use colour::Model;
use colour::found::sampled;
use invertex::asset::colours_of;
use invertex::lod::progressive::colour::{Distance, Shade};
use invertex::param::projection::Line;
use invertex::param::{Computed, parameterize};
use invertex::scene::Scene;

/// Bounds of a model's colours against samples, and the share that is met.
fn check(name: &str, path: &std::path::Path) {
    let scene = Scene::load(path).unwrap();
    for mesh in &scene.meshes {
        let chosen = parameterize(mesh, &long::primary(name)).unwrap();
        let cut = |c: &Computed| c.embedding.cut_open(mesh);
        let mesh = chosen.computed.as_ref().map_or_else(|| mesh.clone(), cut);
        let (colours, words) = colours_of(&scene, &mesh);
        let Some(colours) = colours else {
            println!("{name}: {words:?}");
            continue;
        };
        let least = mesh.triangles.len() / 100;
        println!("{name} over {}", chosen.primary.kind);
        let line = chosen.primary.line();
        let model = Model::with(mesh, chosen.primary);
        let found = sampled(&model, &colours, Distance::Lab, least, 600);
        let numbers = format!(
            "{} points, {} of {} bounds exceeded; {} of {} met within 5 %; {} products exceeded, {} half met",
            found.points,
            found.above,
            found.triangles,
            found.met,
            found.known,
            found.steeper,
            found.steep
        );
        long::proved(name, "colour bound", &numbers);
        assert_eq!((found.above, found.steeper), (0, 0), "{name}: {numbers}");
        // Along a cylinder's lines bounds hold and are wide.
        let least = if line == Line::Cylinder { 0 } else { 80 };
        assert!(found.met * 100 >= found.known * least, "{name}: {numbers}");
    }
}

#[test]
fn spot_keeps_its_bounds() {
    if let Some(path) = long::found("spot") {
        check("spot", &path);
    }
}

fn at_length(name: &str) {
    if let Some(path) = long::model(name) {
        check(name, &path);
    }
}

long::on_every_model!(at_length);

/// The model that comes with the crate: a picture with all its mips; without its texture coordinates, its factor.
#[test]
fn what_a_scene_shows() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/amphora.glb");
    let scene = Scene::load(std::path::Path::new(file)).unwrap();
    let mesh = &scene.meshes[0];
    let (colours, _) = colours_of(&scene, mesh);
    let colours = colours.unwrap();
    assert_eq!(colours.shades.len(), mesh.triangles.len());
    for picture in &colours.pictures {
        let levels = picture.size[0].max(picture.size[1]).ilog2() as usize + 1;
        assert!(picture.mips.len() == levels || picture.mips.len() == 1);
        assert_eq!(
            picture.mips[0].len(),
            (picture.size[0] * picture.size[1]) as usize
        );
    }
    assert!(!colours.pictures.is_empty());
    let mut bare = mesh.clone();
    bare.uv_sets.clear();
    bare.colors.clear();
    let (none, words) = colours_of(&scene, &bare);
    assert!(
        none.is_none() && words[0].contains("only geometry counts"),
        "{words:?}"
    );
    // A second colour, at one vertex, is enough.
    bare.colors = vec![[1.0; 4]; bare.positions.len()];
    bare.colors[bare.triangles[0][0] as usize] = [0.0, 0.5, 0.0, 1.0];
    let (some, _) = colours_of(&scene, &bare);
    assert!(matches!(some.unwrap().shades[0], Shade::Corners(_)));
}
