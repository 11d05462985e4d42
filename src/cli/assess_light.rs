//! FLIP of a simple model with its baked normals against the detailed one, under a light that moves.

use super::device::Device;
use super::progress::Bar;
use super::recovery::renderer;
use invertex::Result;
use invertex::asset::Progress;
use invertex::measure::{AssessSettings, Lit, MovingLight, OFF_EYE};
use invertex::mesh::Mesh;
use invertex::output::{TexturePlace, TexturedMesh, encode_glb, encode_texture};
use invertex::recover::{Mapping, Misses, Pair, PairSettings, Recovery};
use invertex::scene::Scene;
use serde::Serialize;

/// Pixels along each side of a picture.
const SIDE: u32 = 256;

/// Which pictures were compared, and how the simple model does without any detail.
#[derive(Serialize)]
pub(super) struct LightReport {
    pub(super) views: u32,
    pub(super) size: u32,
    pub(super) off_eye_degrees: f64,
    pub(super) turn_degrees: Vec<f64>,
    pub(super) low: Flips,
}

/// FLIP under each light, and the mean.
#[derive(Serialize)]
pub(super) struct Flips {
    pub(super) mean: f64,
    pub(super) lights: Vec<f64>,
}

impl Flips {
    fn new(lights: Vec<f64>) -> Flips {
        Flips {
            mean: lights.iter().sum::<f64>() / lights.len() as f64,
            lights,
        }
    }
}

/// The models, and where they are drawn.
pub(super) struct Pictured<'a> {
    pub(super) high: &'a Scene,
    pub(super) low: &'a Scene,
    pub(super) cage: Option<&'a Scene>,
    pub(super) device: &'a Device,
}

impl Pictured<'_> {
    /// FLIP for each of the mappings of `settings`, with textures of its size.
    pub(super) fn flips(
        &self,
        settings: &AssessSettings,
        (lights, views): (u32, u32),
        heard: &Bar,
    ) -> Result<(LightReport, Vec<Flips>)> {
        let moving = MovingLight {
            lights,
            views,
            size: SIDE,
        };
        let draw = |picture| renderer(self.device, picture);
        let lit = Lit::new(self.high, moving, &draw)?;
        let report = LightReport {
            views,
            size: SIDE,
            off_eye_degrees: OFF_EYE,
            turn_degrees: moving.turns(),
            low: Flips::new(lit.flip(self.low)?),
        };
        let mut all = Vec::new();
        for (k, &mapping) in settings.mappings.iter().enumerate() {
            Progress::at(heard, "light", mapping.name(), k, settings.mappings.len());
            let baked = self.baked(mapping, settings, heard)?;
            all.push(Flips::new(lit.flip(&baked)?));
        }
        Ok((report, all))
    }

    /// The simple model with the normals of the detailed one, as `bake` writes it.
    fn baked(&self, mapping: Mapping, settings: &AssessSettings, heard: &Bar) -> Result<Scene> {
        let bake = PairSettings {
            mapping,
            recovery: Recovery {
                misses: Misses::Proximity,
                ..settings.recovery
            },
            layout: settings.layout,
            size: settings.size,
            ..PairSettings::default()
        };
        let cage = self.cage.filter(|_| mapping.looks_from_cage());
        let draw = |picture| renderer(self.device, picture);
        let mut pair = Pair::in_cage((self.high, self.low, cage), &bake, &draw, heard)?;
        let mut all: Vec<(Mesh, Vec<u8>, [[f32; 4]; 4])> = Vec::new();
        for k in 0..pair.count() {
            let baked = pair.bake(k, heard)?;
            let normals = encode_texture(bake.size, bake.size, &baked.textures[0].rgba8())?;
            all.extend(baked.low.map(|low| (low, normals, pair.place(k))));
        }
        let textured = all.iter().map(|(mesh, normals, place)| TexturedMesh {
            mesh,
            textures: vec![(TexturePlace::Normal, normals)],
            places: vec![*place],
        });
        let glb = encode_glb(&textured.collect::<Vec<_>>())?;
        Scene::from_bytes("baked.glb", &glb, None)
    }
}
