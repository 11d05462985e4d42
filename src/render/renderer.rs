//! The renderer: a picture made ready once, drawn from many cameras.

use super::camera::Camera;
#[cfg(feature = "gpu")]
use super::device::{Device, upload};
use super::draw::{Light, ViewConstants};
use super::filter::Filter;
#[cfg(feature = "gpu")]
use super::forward::Forward;
use super::picture::Picture;
use super::shade::{
    Aov, FETCHES_SHIFT, FILTER_SHIFT, FLAG_DATA, FLAG_WIREFRAME, NOTHING, OUTPUT_FETCHES,
    OUTPUT_LIT, OUTPUT_NORMALS, OUTPUT_UNLIT, Pixel, SHADER_LOD_SHIFT,
};
use super::stage::{Correspond, Subject, stage_with};
use super::{function, project, raster, resolve, shade};
#[cfg(feature = "gpu")]
use crate::Error;
use crate::Result;
use crate::attribute::AttributeSet;
#[cfg(feature = "gpu")]
use crate::gpu;
use crate::scene::{Pose, Scene};

/// Pixels drawn at once: their largest buffer is 96 MiB, within the 128 that every device gives.
const BAND_PIXELS: u32 = 1 << 22;

/// What is written into the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Output {
    /// Lit by one directional light and a constant ambient one.
    #[default]
    Lit,
    /// Base colour.
    Unlit,
    /// Two-level world-space normals, x y z as 0..1.
    Normals,
    /// Fetches of the correspondence in false colour ([`super::legend`]).
    Fetches,
    /// What is shown in place of base colour ([`Shown`](crate::attribute::Shown)) as it is, never lit: for data.
    Data,
}

/// How a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What is written.
    pub output: Output,
    /// Whether the drawn triangles' edges are drawn over it.
    pub wireframe: bool,
    /// The light of [`Output::Lit`].
    pub light: Light,
    /// Fetches at the top of the false-colour scale.
    pub fetches_top: u32,
    /// Samples a pixel: 1, 4, 16 or 64 (2 x 2 and so on, averaged in linear light, weighted by coverage).
    pub samples: u32,
    /// How a LoD gathers the reference's appearance over a pixel.
    pub filter: Filter,
    /// Where what was filtered beforehand lies within so many steps of 8 bits of the lookup it is shown instead, in
    /// quarters, up to 63.75; 0 for nowhere. Subjects say what was filtered
    /// ([`Subject::prefiltered`](super::Subject::prefiltered)).
    pub shader_lod: f32,
    /// Seconds, for attributes that vary with time.
    pub time: f32,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            output: Output::Lit,
            wireframe: false,
            light: Light::default(),
            fetches_top: 16,
            samples: 1,
            filter: Filter::Nearest,
            shader_lod: 0.0,
            time: 0.0,
        }
    }
}

/// An image and what else is known of its pixels, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rendered {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// sRGB, alpha = coverage, not premultiplied.
    pub rgba8: Vec<u8>,
    /// Linear, alpha = coverage, not premultiplied.
    pub linear: Vec<[f32; 4]>,
    /// Triangle of the reference, counted in its own mesh; `u32::MAX` where there is none.
    pub triangle: Vec<u32>,
    /// Which draw; `u32::MAX` where there is none.
    pub draw: Vec<u32>,
    /// Barycentrics of corners 1 and 2 in that triangle.
    pub barycentric: Vec<[f32; 2]>,
    /// Fetches of the correspondence.
    pub fetches: Vec<u32>,
    /// Depth in 0..1, 1 where nothing is.
    pub depth: Vec<f32>,
    /// Pixels that are not empty.
    pub covered_pixels: u64,
    /// Mean fetches over covered pixels.
    pub mean_fetches: f64,
    /// Duration of each pass in nanoseconds, all bands of a large picture together.
    pub passes: Vec<(String, u64)>,
}

/// A picture made ready for drawing.
pub struct Renderer {
    pub(super) picture: Picture,
    pub(super) on: Processor,
}

/// Where and how it is drawn.
pub(super) enum Processor {
    Cpu,
    #[cfg(feature = "gpu")]
    Deferred(Box<Device>),
    #[cfg(feature = "gpu")]
    Forward(Box<Forward>),
}

impl Renderer {
    /// Draws on the CPU.
    pub fn cpu(picture: Picture) -> Self {
        Renderer {
            picture,
            on: Processor::Cpu,
        }
    }

    /// Draws on a device by the deferred path; uploads the picture.
    #[cfg(feature = "gpu")]
    pub fn on(context: &gpu::Context, picture: Picture) -> Result<Self> {
        let on = Processor::Deferred(Box::new(Device::new(context, &picture)?));
        Ok(Renderer { picture, on })
    }

    /// Draws on a device by the forward path, with the device's own interpolation and texture sampling; uploads the
    /// picture. No wireframe.
    ///
    /// # Errors
    /// [`Error::Capacity`] where the textures are of more than eight kinds.
    #[cfg(feature = "gpu")]
    pub fn forward(context: &gpu::Context, picture: Picture) -> Result<Self> {
        let arrays = upload(context, &picture)?;
        let on = Processor::Forward(Box::new(Forward::new(context, &picture, &arrays)?));
        Ok(Renderer { picture, on })
    }

    /// The picture.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// From now on draws another pose of `scene`: of the scene, subjects and correspondence that its picture was staged
    /// with. Textures, tables and pipelines stay where they are.
    ///
    /// ```no_run
    /// # use invertex::render::{Camera, Correspond, Options, Projection, Renderer, stage_posed};
    /// # fn main() -> invertex::Result<()> {
    /// let scene = invertex::scene::Scene::load("fox.glb".as_ref())?;
    /// let walk = scene.animation_named("Walk")?;
    /// let rest = scene.rest();
    /// let (picture, _) = stage_posed(&scene, &[], Correspond::Reference, true, &rest)?;
    /// let (centre, radius) = picture.bounding_sphere();
    /// let camera = Camera::framed(centre, radius, 75.0, 10.0, Projection::Perspective, 640, 480)?;
    /// let mut renderer = Renderer::cpu(picture);
    /// for frame in 0..30 {
    ///     let time = scene.animations[walk].looped(f64::from(frame) / 30.0);
    ///     renderer.repose(&scene, &[], Correspond::Reference, &scene.pose(walk, time)?)?;
    ///     let image = renderer.draw(&camera, &Options::default())?;
    ///     println!("{frame}: {} pixels", image.covered_pixels);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`stage_posed`](super::stage_posed), after which the renderer is of no use; those of the device. Panics where the
    /// picture was staged from something else, so that its arrays have other lengths.
    pub fn repose(
        &mut self,
        scene: &Scene,
        subjects: &[Subject],
        correspond: Correspond,
        pose: &Pose,
    ) -> Result<()> {
        self.stage(scene, subjects, correspond, pose)?;
        #[cfg(feature = "gpu")]
        match &self.on {
            Processor::Cpu => {}
            Processor::Deferred(device) => device.posed.write(&self.picture)?,
            Processor::Forward(forward) => forward.posed.write(&self.picture)?,
        }
        Ok(())
    }

    /// From now on draws other levels of `scene`, say the cuts of another view: subjects may have other LoDs than its picture
    /// was staged with, and nothing else. The deferred path keeps textures and tables where they are.
    ///
    /// # Errors
    /// As [`stage_posed`](super::stage_posed), after which the renderer is of no use; those of the device.
    pub fn restage(
        &mut self,
        scene: &Scene,
        subjects: &[Subject],
        correspond: Correspond,
        pose: &Pose,
    ) -> Result<()> {
        self.stage(scene, subjects, correspond, pose)?;
        #[cfg(feature = "gpu")]
        match &mut self.on {
            Processor::Cpu => {}
            Processor::Deferred(device) => **device = device.restaged(&self.picture)?,
            Processor::Forward(forward) => **forward = forward.restaged(&self.picture)?,
        }
        Ok(())
    }

    /// Makes the picture anew, with the textures that it has.
    fn stage(
        &mut self,
        scene: &Scene,
        subjects: &[Subject],
        correspond: Correspond,
        pose: &Pose,
    ) -> Result<()> {
        let nothing = Picture::new(AttributeSet::default());
        let mut attributes = std::mem::replace(&mut self.picture, nothing).attributes;
        attributes.triangles.clear();
        attributes.vertices.clear();
        self.picture = stage_with(attributes, scene, subjects, correspond, pose)?;
        Ok(())
    }

    /// One image.
    pub fn draw(&self, camera: &Camera, options: &Options) -> Result<Rendered> {
        let factor = resolve::factor(options.samples)?;
        let fine = camera.scaled(factor)?;
        let view = ViewConstants::new(&fine, &options.light, flags(options), options.time);
        let (pixels, passes) = self.bands(&fine, &view, factor)?;
        let coded = matches!(
            options.output,
            Output::Normals | Output::Fetches | Output::Data
        );
        let pixels = if factor == 1 {
            pixels
        } else {
            resolve::average(&pixels, camera, factor, coded)
        };
        let mut out = assemble(camera, pixels);
        out.passes = passes;
        Ok(out)
    }

    /// A picture of more than [`BAND_PIXELS`] in bands of whole rows, `multiple` at a time. The bands depend on nothing but the
    /// size, so that a picture has the same bytes on devices of any size.
    fn bands(
        &self,
        camera: &Camera,
        view: &ViewConstants,
        multiple: u32,
    ) -> Result<(Vec<Pixel>, Vec<(String, u64)>)> {
        let rows = (BAND_PIXELS / camera.width / multiple).max(1) * multiple;
        if rows >= camera.height {
            return self.pixels(view);
        }
        let mut all = Vec::with_capacity(camera.width as usize * camera.height as usize);
        let mut times: Vec<(String, u64)> = Vec::new();
        for top in (0..camera.height).step_by(rows as usize) {
            let band = view.band(camera, top, rows.min(camera.height - top));
            let (pixels, passes) = self.pixels(&band)?;
            all.extend(pixels);
            for (k, (name, time)) in passes.into_iter().enumerate() {
                match times.get_mut(k) {
                    Some((_, sum)) => *sum += time,
                    None => times.push((name, time)),
                }
            }
        }
        Ok((all, times))
    }

    pub(super) fn pixels(&self, view: &ViewConstants) -> Result<(Vec<Pixel>, Vec<(String, u64)>)> {
        #[cfg(feature = "gpu")]
        match &self.on {
            Processor::Cpu => {}
            Processor::Deferred(device) => return device.draw(view).map(named),
            Processor::Forward(forward) => {
                forward_can(view)?;
                let (mut pixels, timings) = forward.draw(view)?;
                shade::encode(&mut pixels, &self.picture.constants, view.flags);
                return Ok(named((pixels, timings)));
            }
        }
        function::not_here(&self.picture.attributes)?;
        let mut passes = Vec::new();
        let projected = timed(&mut passes, "project", || {
            project::cpu(&self.picture.positions, &self.picture.draws, view)
        });
        let ids = timed(&mut passes, "raster", || {
            raster::cpu(&self.picture.corners, &self.picture.draws, view, &projected)
        });
        let pixels = timed(&mut passes, "shade", || {
            shade::cpu(&self.picture, view, &projected, &ids)
        });
        Ok((pixels, passes))
    }
}

/// Refuses what the forward path does not draw.
#[cfg(feature = "gpu")]
pub(super) fn forward_can(view: &ViewConstants) -> Result<()> {
    if view.flags & FLAG_WIREFRAME == 0 {
        return Ok(());
    }
    Err(Error::Option {
        option: "--path",
        reason: "wireframe is drawn by the deferred path only".into(),
    })
}

#[cfg(feature = "gpu")]
fn named((pixels, timings): (Vec<Pixel>, gpu::Timings)) -> (Vec<Pixel>, Vec<(String, u64)>) {
    let passes = timings.passes.into_iter();
    (pixels, passes.map(|p| (p.name, p.nanoseconds)).collect())
}

fn timed<T>(passes: &mut Vec<(String, u64)>, name: &str, work: impl FnOnce() -> T) -> T {
    let start = std::time::Instant::now();
    let out = work();
    passes.push((format!("render_{name}"), start.elapsed().as_nanos() as u64));
    out
}

pub(super) fn flags(options: &Options) -> u32 {
    let output = match options.output {
        Output::Lit => OUTPUT_LIT,
        Output::Unlit => OUTPUT_UNLIT,
        Output::Normals => OUTPUT_NORMALS,
        Output::Fetches => OUTPUT_FETCHES,
        Output::Data => OUTPUT_UNLIT | FLAG_DATA,
    };
    output
        | if options.wireframe { FLAG_WIREFRAME } else { 0 }
        | options.filter.code() << FILTER_SHIFT
        | (options.fetches_top.min(0xffff) << FETCHES_SHIFT)
        | ((options.shader_lod * 4.0).round().clamp(0.0, 255.0) as u32) << SHADER_LOD_SHIFT
}

fn assemble(camera: &Camera, pixels: Vec<Pixel>) -> Rendered {
    let mut out = Rendered {
        width: camera.width,
        height: camera.height,
        ..Rendered::default()
    };
    for Pixel { linear, rgba8, aov } in pixels {
        out.rgba8.extend(rgba8.to_le_bytes());
        out.linear.push(linear);
        push_aov(&mut out, &aov);
    }
    let fetches: u64 = out.fetches.iter().map(|&f| u64::from(f)).sum();
    out.mean_fetches = fetches as f64 / out.covered_pixels.max(1) as f64;
    out
}

fn push_aov(out: &mut Rendered, aov: &Aov) {
    out.triangle.push(aov.triangle);
    out.draw.push(aov.draw);
    out.barycentric.push(aov.barycentric);
    out.fetches.push(aov.fetches);
    out.depth.push(aov.depth);
    out.covered_pixels += u64::from(aov.draw != NOTHING);
}
