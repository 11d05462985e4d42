//! How a pixel gathers the reference: against 64 samples a pixel of the same level of detail, far away, where one point
//! shimmers; and what the filters cost.

mod cli_support;
mod glb;

use cli_support::{Folder, invertex};
use invertex::asset::{Built, Model};
use invertex::measure::{Picture, Region, compare};
use invertex::render::{
    Camera, Correspond, Filter, Options, Output, Projection, Rendered, Renderer, reference_sphere,
    stage, subjects,
};

/// The bundled amphora: painted figures on an atlas of its own, looked up through a cylinder.
fn amphora() -> Built {
    let folder = Folder::new();
    let out = folder.at("built.glb");
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/amphora.glb");
    invertex(&[
        "build", model, "-o", &out, "--device", "cpu", "--lods", "0.1",
    ])
    .ok();
    match Model::load(out.as_ref()).unwrap() {
        Model::Built(built) => *built,
        Model::Plain(_) => panic!("{out} is not built"),
    }
}

struct Studio {
    renderer: Renderer,
    cameras: Vec<Camera>,
}

impl Studio {
    fn new(built: &Built, side: u32) -> Self {
        let subjects = subjects(built, 1);
        let (picture, _) = stage(&built.scene, &subjects, Correspond::Inverse, false).unwrap();
        let (centre, radius) = reference_sphere(&built.scene).unwrap();
        let camera = |(azimuth, elevation)| {
            let projection = Projection::Perspective;
            Camera::framed(centre, radius, azimuth, elevation, projection, side, side).unwrap()
        };
        Studio {
            renderer: Renderer::cpu(picture),
            cameras: [(30.0, 20.0), (150.0, -10.0), (265.0, 50.0)]
                .map(camera)
                .to_vec(),
        }
    }

    fn draw(&self, filter: Filter, samples: u32) -> Vec<Rendered> {
        let options = Options {
            output: Output::Unlit,
            filter,
            samples,
            ..Options::default()
        };
        let draw = |camera| self.renderer.draw(camera, &options).unwrap();
        self.cameras.iter().map(draw).collect()
    }
}

fn picture(image: &Rendered) -> Picture {
    Picture {
        width: image.width,
        height: image.height,
        rgba: bytemuck::cast_slice(&image.rgba8).to_vec(),
        has_alpha: true,
    }
}

/// Mean FLIP over pixels that both cover wholly: what is compared is the filter, not the outline.
fn flip(truth: &[Rendered], images: &[Rendered]) -> f64 {
    let each = truth.iter().zip(images).map(|(t, i)| {
        let (mut a, mut b) = (picture(t), picture(i));
        for (x, y) in a.rgba.iter_mut().zip(&mut b.rgba) {
            if x[3] != 255 || y[3] != 255 {
                (*x, *y) = ([0; 4], [0; 4]);
            }
        }
        let names = ["64 samples", "filter"];
        compare(&a, &b, Region::Foreground, names)
            .unwrap()
            .flip_mean
    });
    each.sum::<f64>() / truth.len() as f64
}

fn mean_fetches(images: &[Rendered]) -> f64 {
    images.iter().map(|i| i.mean_fetches).sum::<f64>() / images.len() as f64
}

/// FLIP and mean fetches of every filter on a picture of so many pixels.
fn measured(built: &Built, side: u32) -> [(f64, f64); 3] {
    let studio = Studio::new(built, side);
    let truth = studio.draw(Filter::Nearest, 64);
    Filter::ALL.map(|filter| {
        let images = studio.draw(filter, 1);
        let (flip, fetches) = (flip(&truth, &images), mean_fetches(&images));
        println!("{side} pixels, {filter:?}: FLIP {flip:.4}, {fetches:.2} fetches");
        (flip, fetches)
    })
}

#[test]
fn five_points_are_nearer_to_the_truth_than_one_and_the_footprint_is_no_farther() {
    let built = amphora();
    for side in [96, 400] {
        let [nearest, footprint, five] = measured(&built, side);
        assert!(five.0 < 0.75 * nearest.0, "five points beat one");
        assert!(footprint.0 <= five.0, "the footprint is no farther");
        assert!(
            footprint.0 > 0.0,
            "the truth is no filter's by construction"
        );
        assert_eq!(footprint.1, five.1, "the same lookups");
        // Triangles of the reference a tenth of a pixel high share nothing; of some pixels, most.
        let most = if side == 400 { 2.5 } else { 4.0 };
        assert!(five.1 <= most * nearest.1, "{} loads", five.1);
    }
}

#[test]
fn where_nothing_is_looked_up_a_filter_changes_nothing() {
    let built = amphora();
    let (picture, _) = stage(&built.scene, &[], Correspond::Reference, true).unwrap();
    let renderer = Renderer::cpu(picture);
    let camera = Studio::new(&built, 96).cameras[0];
    let draw = |filter| {
        let options = Options {
            filter,
            ..Options::default()
        };
        renderer.draw(&camera, &options).unwrap()
    };
    let (one, five) = (draw(Filter::Nearest), draw(Filter::Five));
    assert_eq!(one.rgba8, five.rgba8);
    assert_eq!(five.mean_fetches, 0.0);
}
