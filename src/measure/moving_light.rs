//! How alike two models look under a light that moves.
//!
//! In: a detailed scene, others that stand in its place with textures of its detail. Out: FLIP ([`compare`]) of their pictures for
//! each direction of the light, the mean over views. Normals that point a little wrong hide under light from the eye; light that
//! rakes over the surface and turns shows them. All is drawn in one grey: shapes are compared, not colours.

use super::{Picture, Region, compare};
use crate::Result;
use crate::recover::{Draw, spread};
use crate::render::{
    Camera, Correspond, Light, Options, Output, Projection, Renderer, reference_sphere, stage,
};
use crate::scene::{Material, Scene};

/// Degrees between the light's direction and the eye's.
pub const OFF_EYE: f64 = 60.0;
/// Linear; bright fronts stay below white.
const GREY: [f32; 4] = [0.6, 0.6, 0.6, 1.0];
/// Samples of a pixel.
const SAMPLES: u32 = 4;

/// How many pictures, and how large.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MovingLight {
    /// Directions of the light, [`OFF_EYE`] from the eye's and turned evenly round it, from the right over above; at least 1.
    pub lights: u32,
    /// Directions of view, spread evenly over the sphere; at least 1.
    pub views: u32,
    /// Pixels along each side of a picture.
    pub size: u32,
}

impl MovingLight {
    /// For each light how far it is turned round the eye's direction, degrees.
    pub fn turns(&self) -> Vec<f64> {
        let step = 360.0 / f64::from(self.lights);
        (0..self.lights).map(|k| f64::from(k) * step).collect()
    }

    /// Cameras round a scene.
    fn cameras(&self, scene: &Scene) -> Result<Vec<Camera>> {
        let (centre, radius) = reference_sphere(scene)?;
        let camera = |[x, y, z]: [f64; 3]| {
            let (azimuth, elevation) = (x.atan2(z), y.clamp(-1.0, 1.0).asin());
            Camera::framed(
                centre,
                radius,
                azimuth.to_degrees(),
                elevation.to_degrees(),
                Projection::Perspective,
                self.size,
                self.size,
            )
        };
        spread(self.views, 0.0).into_iter().map(camera).collect()
    }
}

/// The detailed scene under every light, in every view.
pub struct Lit<'a> {
    settings: MovingLight,
    draw: Draw<'a>,
    cameras: Vec<Camera>,
    /// Light after light, view after view.
    reference: Vec<Picture>,
}

impl<'a> Lit<'a> {
    /// Draws `high`. `draw` makes renderers: on the processor or on a device.
    ///
    /// # Errors
    /// Those of staging and drawing.
    pub fn new(high: &Scene, settings: MovingLight, draw: Draw<'a>) -> Result<Lit<'a>> {
        let mut lit = Lit {
            settings,
            draw,
            cameras: settings.cameras(high)?,
            reference: Vec::new(),
        };
        lit.reference = lit.pictures(high)?;
        Ok(lit)
    }

    /// FLIP of `other`, for each light the mean over views, 0 (same) to 1.
    ///
    /// # Errors
    /// Those of staging and drawing.
    pub fn flip(&self, other: &Scene) -> Result<Vec<f64>> {
        let pictures = self.pictures(other)?;
        let pairs = self.reference.iter().zip(&pictures);
        let each = pairs.map(|(high, other)| {
            let names = ["the detailed model", "the other one"];
            Ok(compare(high, other, Region::Foreground, names)?.flip_mean)
        });
        let each: Vec<f64> = each.collect::<Result<_>>()?;
        let views = each.chunks(self.cameras.len());
        Ok(views
            .map(|views| views.iter().sum::<f64>() / views.len() as f64)
            .collect())
    }

    fn pictures(&self, scene: &Scene) -> Result<Vec<Picture>> {
        let (staged, _) = stage(&in_grey(scene), &[], Correspond::Reference, true)?;
        let renderer = (self.draw)(staged)?;
        let turns = self.settings.turns();
        let all = turns
            .iter()
            .flat_map(|turn| self.cameras.iter().map(move |camera| (turn, camera)));
        all.map(|(turn, camera)| picture(&renderer, camera, *turn))
            .collect()
    }
}

/// One picture, the light turned so many degrees.
fn picture(renderer: &Renderer, camera: &Camera, turn: f64) -> Result<Picture> {
    let (sin, cos) = turn.to_radians().sin_cos();
    let (aside, along) = OFF_EYE.to_radians().sin_cos();
    let light = Light {
        direction: Some(camera.world_direction([aside * cos, aside * sin, along])),
        ..Light::default()
    };
    let options = Options {
        output: Output::Lit,
        samples: SAMPLES,
        light,
        ..Options::default()
    };
    let drawn = renderer.draw(camera, &options)?;
    Ok(Picture {
        width: drawn.width,
        height: drawn.height,
        rgba: drawn.rgba8.as_chunks::<4>().0.to_vec(),
        has_alpha: true,
    })
}

/// The same in one matt grey, normal maps kept: shapes alone are to be seen.
pub fn in_grey(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for material in &mut scene.materials {
        *material = Material {
            name: std::mem::take(&mut material.name),
            base_color: GREY,
            metallic: 0.0,
            normal_texture: material.normal_texture,
            normal_scale: material.normal_scale,
            double_sided: material.double_sided,
            ..Material::default()
        };
    }
    scene.meshes.iter_mut().for_each(|mesh| mesh.colors.clear());
    scene
}
