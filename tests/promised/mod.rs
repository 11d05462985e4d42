//! What the flow diagram says of points of a cut, asked one by one: nothing is drawn, and nothing is rounded to a raster.

use crate::PIXELS;
use crate::colour::sampled::differences;
use crate::colour::{Model, spread};
use crate::unpromised::Unpromised;
use glam::{DMat4, DVec3};
use invertex::asset::{Built, colours_of};
use invertex::lod::multiresolution::{Criterion, Hierarchy, Limits, Memory};
use invertex::lod::progressive::Made;
use invertex::lod::progressive::colour::{ColourDeviations, Colours, Distance};
use invertex::render::Camera;
use std::collections::HashSet;

/// Points of cuts that colours decided.
#[derive(Default)]
pub(crate) struct Promised {
    pub(crate) points: usize,
    /// Those that are displaced by more than the pixels, and the largest difference of their colours over the limit.
    pub(crate) beyond: usize,
    pub(crate) largest: f64,
}

/// What the flow diagram says of points of a cut, one by one and without drawing: a point that is displaced by more than the
/// pixels has, where it belongs but for its normal part, a colour within the limit. At the mip in use at its distance.
pub(crate) struct Promise<'a> {
    meshes: Vec<Promising<'a>>,
}

struct Promising<'a> {
    hierarchy: &'a Hierarchy,
    world: DMat4,
    folds: &'a HashSet<u32>,
    model: Model,
    colours: Colours<'static>,
    levels: ColourDeviations,
}

impl<'a> Promise<'a> {
    /// Nothing is said of the folds of `unpromised`.
    pub(crate) fn new(built: &'a Built, unpromised: &'a [Unpromised]) -> Self {
        let promising = |instance: invertex::scene::Instance| {
            let of_mesh = built.of_mesh(instance.mesh)?;
            let hierarchy = of_mesh.hierarchy.as_ref()?;
            let steps = hierarchy.colours.as_ref()?;
            let mesh = &built.scene.meshes[instance.mesh];
            Some(Promising {
                hierarchy,
                world: instance.world,
                folds: &unpromised[instance.mesh].folds,
                colours: colours_of(&built.scene, mesh).0?,
                model: Model::with(mesh.clone(), of_mesh.tables.primary),
                levels: ColourDeviations {
                    footprint: steps.footprint,
                    levels: steps.levels,
                    first: 0,
                    of: Vec::new(),
                    widest: 0.0,
                    known: 0,
                    met: 0,
                },
            })
        };
        let instances = built.scene.instances();
        Promise {
            meshes: instances.into_iter().filter_map(promising).collect(),
        }
    }

    pub(crate) fn look(&self, from: (&Camera, u64), colour: f64, promised: &mut Promised) {
        for mesh in &self.meshes {
            mesh.look(from, colour, promised);
        }
    }
}

/// Triangles of a cut that are looked at.
const LOOKED_AT: usize = 400;

impl Promising<'_> {
    fn look(&self, (camera, seed): (&Camera, u64), colour: f64, promised: &mut Promised) {
        let seen = invertex::lod::multiresolution::Seen {
            object_to_view: camera.view * self.world,
            projection: camera.projection,
            size: [camera.width, camera.height],
            double_sided: true,
        };
        let limits = Limits {
            pixels: PIXELS,
            criterion: Criterion::Colour(colour),
            ..Limits::default()
        };
        let model = &self.hierarchy.model;
        let view = model.view(&seen, &limits).unwrap();
        let cut = model.select(&[view], &mut Memory::default());
        let made = |&f: &u32| &self.hierarchy.history.triangles[model.of[f as usize] as usize];
        let made = cut.faces.iter().map(made).filter(|t| t.made.is_some());
        let step = cut.faces.len() / LOOKED_AT + 1;
        for (k, made) in made.step_by(step).enumerate() {
            let random = |j: u64| spread(seed * 1_000_003 + k as u64 * 2 + j);
            let (u, v) = (random(0), random(1).sqrt());
            let at = [1.0 - v, v * (1.0 - u), v * u];
            self.point((camera, colour), made, at, promised);
        }
    }

    /// The place of a vertex or of a point between three.
    fn place(&self, corners: [u32; 3], b: [f64; 3]) -> DVec3 {
        let p = corners.map(|v| {
            let p = self.hierarchy.history.place[v as usize];
            DVec3::from(self.model.mesh.positions[p as usize].map(f64::from))
        });
        p[0] * b[0] + p[1] * b[1] + p[2] * b[2]
    }

    fn point(
        &self,
        (camera, colour): (&Camera, f64),
        made: &Made,
        at: [f64; 3],
        promised: &mut Promised,
    ) {
        let Some((t, own)) = self.model.shown(made, at) else {
            return;
        };
        if self.folds.contains(&t) {
            return;
        }
        let corners = self.model.mesh.triangles[t as usize];
        let (here, there) = (self.place(made.corners, at), self.place(corners, own));
        let (Some(a), Some(b)) = (self.pixel(camera, here), self.pixel(camera, there)) else {
            return;
        };
        promised.points += 1;
        if (a - b).length() <= PIXELS + 1e-3 {
            return;
        }
        let distance = Distance::Lab;
        let point = (made, at);
        let Some(off) = differences(&self.model, &self.colours, &self.levels, distance, point)
        else {
            return;
        };
        promised.beyond += 1;
        // Places of texels are rounded, and answers to 2^-21 of a triangle, as where bounds are sampled.
        let most = colour * 1.0002 + 0.02;
        promised.largest = promised.largest.max(off[self.level(camera, there)] / most);
    }

    /// Where on the screen a point is, in pixels; none outside of the picture.
    fn pixel(&self, camera: &Camera, p: DVec3) -> Option<DVec3> {
        let clip = camera.projection * camera.view * self.world * p.extend(1.0);
        let at = clip.truncate() / clip.w;
        let half = DVec3::new(f64::from(camera.width), f64::from(camera.height), 0.0) * 0.5;
        (clip.w > 0.0 && at.x.abs() <= 1.0 && at.y.abs() <= 1.0).then(|| at * half)
    }

    /// The finest level whose footprint a pixel may have at the point's distance, anywhere in the picture.
    fn level(&self, camera: &Camera, p: DVec3) -> usize {
        let seen = (camera.view * self.world).transform_point3(p);
        let p = &camera.projection;
        let perspective = p.z_axis.w != 0.0;
        let pixels = 0.5 * (p.x_axis.x * f64::from(camera.width)).abs();
        let corner = (1.0 + p.x_axis.x.powi(-2) + p.y_axis.y.powi(-2)).sqrt();
        let footprint = match perspective {
            true => seen.length() / (pixels * corner),
            false => 1.0 / pixels,
        };
        let scale = self.world.determinant().abs().cbrt();
        self.levels.level_of((footprint / scale) as f32)
    }
}
