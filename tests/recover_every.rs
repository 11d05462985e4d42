//! Correspondences against asking every triangle: for each texel of a layout the closest point and the first hits of its normal
//! ray, same triangle and barycentrics to the bit, of equally near ones the lowest, on the processor and on every device; and
//! the baked mapping image against the same.
//!
//! A made pair always; with `INVERTEX_LONG=1` a million texels of the bunny.
#![cfg(feature = "gpu")]

mod devices;
mod long;
mod pair;

use devices::on_every_device;
use invertex::mesh::{Mesh, shapes};
use invertex::recover::{
    Answer, Ask, BakeAttribute, Baked, Mapping, Misses, Pair, PairSettings, Question, Triangles,
};
use invertex::render::Renderer;
use invertex::scene::Scene;
use pair::{Quiet, scene};

fn bake(high: &Scene, low: &Scene, settings: &PairSettings) -> Baked {
    let draw = |picture| Ok(Renderer::cpu(picture));
    let mut pair = Pair::new(high, low, settings, &draw, &Quiet).unwrap();
    pair.bake(0, &Quiet).unwrap()
}

/// Place and normal under each texel of `low`'s layout, none off the surface.
fn texels(low: &Scene, size: u32) -> Vec<Option<[[f32; 3]; 2]>> {
    let itself = PairSettings {
        mapping: Mapping::Proximity,
        attributes: vec![BakeAttribute::Position, BakeAttribute::ObjectNormal],
        size,
        padding: 0,
        ..PairSettings::default()
    };
    let baked = bake(low, low, &itself);
    let three = |a: usize, k: usize| {
        let [x, y, z, _] = baked.textures[a].values[k];
        [x, y, z]
    };
    let on = |k: usize| (baked.mask[k] == 255).then(|| [three(0, k), three(1, k)]);
    (0..baked.mask.len()).map(on).collect()
}

fn corners(scene: &Scene) -> Vec<[[f32; 3]; 3]> {
    let of =
        |mesh: &Mesh| -> Vec<_> { (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect() };
    scene.meshes.iter().flat_map(of).collect()
}

/// What a bake asks of each texel: its closest point, and its normal ray outwards and inwards.
fn questions(texels: &[[[f32; 3]; 2]], reach: f32) -> Vec<Question> {
    let ray = |place, way, ask| Question {
        ask,
        ..Question::ray(place, way, reach)
    };
    let of = |&[place, normal]: &[[f32; 3]; 2]| {
        let inwards = normal.map(|c: f32| -c);
        [
            Question::closest(place),
            ray(place, normal, Ask::RayBack),
            ray(place, inwards, Ask::RayFront),
        ]
    };
    texels.iter().flat_map(of).collect()
}

fn bits(answers: &[Option<Answer>]) -> Vec<Option<[u32; 5]>> {
    let words = |a: &Answer| {
        let [x, y, z] = a.barycentric.map(f32::to_bits);
        [a.triangle, x, y, z, a.distance.to_bits()]
    };
    answers.iter().map(|a| a.as_ref().map(words)).collect()
}

/// Holds all against asking every triangle; answers of the definition.
fn held(triangles: &Triangles, questions: &[Question], name: &str) -> Vec<Option<Answer>> {
    let every = triangles.ask_every(questions);
    assert_eq!(bits(&triangles.ask(questions)), bits(&every), "{name}");
    on_every_device(|context| {
        let theirs = triangles.ask_on(context, questions).unwrap();
        assert_eq!(
            bits(&theirs),
            bits(&every),
            "{name} on {}",
            context.info().name
        );
    });
    // The negative control: a question moved by little has another answer.
    let mut other = questions.to_vec();
    other.iter_mut().for_each(|q| q.place[0] += 1e-3);
    assert_ne!(bits(&triangles.ask(&other)), bits(&every));
    every
}

/// A ball with waves, and a coarse ball laid out in charts: corners of both coincide along the axes, so that there are ties.
fn made() -> (Scene, Scene) {
    let mut high = shapes::icosphere(5);
    for p in &mut high.positions {
        let wave = 1.0 + 0.03 * (9.0 * p[0]).sin() * (11.0 * p[1]).sin() * (7.0 * p[2]).sin();
        *p = p.map(|c| c * wave);
    }
    let mut low = shapes::icosphere(3);
    low.uv_sets.clear();
    (scene("high", &high), scene("low", &low))
}

#[test]
fn texels_of_a_made_pair_have_the_answers_of_every_triangle() {
    let (high, low) = made();
    let some: Vec<_> = texels(&low, 128).into_iter().flatten().collect();
    assert!(some.len() > 5_000, "{}", some.len());
    let mut all = questions(&some, 0.2);
    // Straight over corners and edges: several triangles are equally near.
    let places = low.meshes[0].positions.iter();
    all.extend(
        places
            .clone()
            .map(|p| Question::closest(p.map(|c| c * 1.5))),
    );
    all.extend(places.map(|p| Question::ray(p.map(|c| c * 1.5), p.map(|c| -c), 3.0)));
    let every = held(&Triangles::new(&corners(&high)), &all, "made");
    assert!(every.iter().flatten().count() > all.len() / 2);
    let tied = |a: &&Answer| a.barycentric.contains(&0.0);
    assert!(every.iter().flatten().filter(tied).count() > 100, "ties");
}

/// The image that a bake leaves says the same, as far as its own places of texels are rounded otherwise.
#[test]
fn the_mapping_image_is_what_asking_every_triangle_says() {
    let (high, low) = made();
    let (size, corners) = (128, corners(&high));
    let (triangles, texels) = (Triangles::new(&corners), texels(&low, size));
    let asked = |mapping| {
        let mut settings = PairSettings {
            mapping,
            attributes: vec![BakeAttribute::Mapping],
            size,
            padding: 0,
            ..PairSettings::default()
        };
        settings.recovery.misses = Misses::Blank;
        settings.recovery.facing = false;
        settings
    };
    for mapping in [Mapping::Proximity, Mapping::Normal] {
        let settings = asked(mapping);
        let draw = |picture| Ok(Renderer::cpu(picture));
        let reach = Pair::new(&high, &low, &settings, &draw, &Quiet)
            .unwrap()
            .reach(0);
        let image = bake(&high, &low, &settings);
        let numbers = image.textures[0].triangles().unwrap();
        let (mut same, mut apart, mut count) = (0, 0.0f32, 0);
        for (k, texel) in texels.iter().enumerate() {
            let Some([place, normal]) = texel else {
                continue;
            };
            let ray = |way: [f32; 3]| triangles.ask_every(&[Question::ray(*place, way, reach)])[0];
            let want = match mapping {
                Mapping::Proximity => triangles.ask_every(&[Question::closest(*place)])[0],
                _ => ray(*normal).or_else(|| ray(normal.map(|c| -c))),
            };
            let (Some(want), true) = (want, image.mask[k] == 255) else {
                continue;
            };
            let [_, b1, b2, _] = image.textures[0].values[k];
            let point = |t: u32, b: [f32; 3]| {
                let c = corners[t as usize];
                [0, 1, 2].map(|i| (0..3).map(|j| b[j] * c[j][i]).sum::<f32>())
            };
            let ours = point(numbers[k], [1.0 - b1 - b2, b1, b2]);
            let theirs = point(want.triangle, want.barycentric);
            let off = (0..3)
                .map(|i| (ours[i] - theirs[i]).abs())
                .fold(0.0, f32::max);
            apart = apart.max(off);
            same += u32::from(numbers[k] == want.triangle);
            count += 1;
        }
        assert!(count > 5_000, "{mapping}: {count}");
        assert!(apart < 2e-4, "{mapping}: {apart}");
        assert!(
            f64::from(same) > 0.998 * f64::from(count),
            "{mapping}: {same} of {count}"
        );
    }
}

#[test]
fn a_million_texels_of_the_bunny_have_the_answers_of_every_triangle() {
    let (Some(high), Some(low)) = (long::model("bunny"), long::model("bunny_low")) else {
        return;
    };
    let (high, low) = (Scene::load(&high).unwrap(), Scene::load(&low).unwrap());
    let mut some: Vec<_> = texels(&low, 1536).into_iter().flatten().collect();
    some.truncate(1_000_000);
    assert_eq!(some.len(), 1_000_000);
    let corners = corners(&high);
    let reach = 0.05 * 0.25;
    let all = questions(&some, reach);
    let every = held(&Triangles::new(&corners), &all, "bunny");
    let found = every.iter().flatten().count();
    let numbers = format!(
        "{} texels, {} questions to {} triangles, {found} answers, all the same",
        some.len(),
        all.len(),
        corners.len()
    );
    long::proved("bunny", "correspondences", &numbers);
}
