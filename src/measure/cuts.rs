//! What cuts of a multiresolution model cost and how they look, by what decides them.
//!
//! In: a [`Sitter`] with a multiresolution model, limits in pixels and in colour, distances. Out: a [`CutRun`] for each
//! criterion, limit and distance: triangles, what the selection asked and took, the bound that holds and what is measured of it,
//! and FLIP against the reference from the same place, both without light.
//!
//! | criterion | a triangle may be drawn where |
//! |---|---|
//! | surface | it lies within the pixels of the reference's surface, whatever it shows |
//! | pixels | nothing that it shows is displaced by more than the pixels |
//! | pixels+colour | or no colour is changed by more than the limit |

use super::compare::{Region, compare};
use super::displaced::{Displacements, displaced};
use super::profile::{Bench, Sitter};
use super::timing::TimeStatistics;
use super::{Comparison, Picture};
use crate::Result;
use crate::lod::multiresolution::{Criterion, Limits, Memory, Multiresolution, View};
use crate::render::{
    self, Camera, Correspond, Cutter, Options, Output, Rendered, Renderer, stage_with,
};
use serde::Serialize;
use std::time::Instant;

/// Selections that are timed for each row, at most.
const SELECTIONS: u32 = 9;

/// What cuts are made within.
#[derive(Clone, Debug, PartialEq)]
pub struct CutRanges {
    /// Limits in pixels.
    pub pixels: Vec<f64>,
    /// Limits in colour, in the unit of the model's colour deviations; not asked of a model that knows none.
    pub colours: Vec<f64>,
    /// Distances, in units of the one at which the model fills the view.
    pub distances: Vec<f64>,
}

impl Default for CutRanges {
    fn default() -> Self {
        CutRanges {
            pixels: vec![0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0],
            colours: vec![2.0, 5.0],
            distances: vec![1.0, 2.0, 4.0, 8.0, 16.0],
        }
    }
}

/// One cut, seen from one place.
#[derive(Clone, Debug, Serialize)]
pub struct CutRun {
    /// The built file.
    pub file: String,
    /// The mesh, or [`WHOLE`](super::WHOLE).
    pub mesh: String,
    /// What decided: `surface`, `pixels` or `pixels+colour`.
    pub criterion: &'static str,
    /// The limit in pixels.
    pub pixels: f64,
    /// The limit in colour.
    pub colour: Option<f64>,
    /// Distance, in units of the one at which the model fills the view.
    pub distance: f64,
    /// Triangles drawn, all instances counted.
    pub triangles: u32,
    /// Triangles of the reference, all instances counted.
    pub reference_triangles: u32,
    /// Collapses and blocks of them that were asked.
    pub asked: usize,
    /// Half of the selections on one core took at most this, nanoseconds.
    pub selection_ns_median: u64,
    /// 95 % of them.
    pub selection_ns_p95: u64,
    /// Half of the selections on the device took at most this by its time stamps, nanoseconds; none on the processor, or
    /// where the device has no room for the model.
    pub device_selection_ns_median: Option<u64>,
    /// Pixels that no detail that faces the eye is displaced by more than, as the model knows it; infinite (`null`) where the
    /// eye stands too near to say.
    pub bound_pixels: f64,
    /// Displacements that were measured in the picture.
    pub displaced: Displacements,
    /// Pixels that FLIP is taken over: those that either picture covers.
    pub compared_pixels: usize,
    /// Mean FLIP against the reference.
    pub flip_mean: f64,
    /// Largest FLIP of a pixel.
    pub flip_max: f64,
}

impl Bench<'_> {
    /// The cuts of `sitter` by every criterion, from near to far as `ranges` say. None of a sitter without a multiresolution
    /// model. `at` hears how many of how many are done.
    ///
    /// # Errors
    /// [`crate::Error::Option`] for limits that are none; those of drawing.
    pub fn cuts(
        &self,
        sitter: &Sitter,
        ranges: &CutRanges,
        at: &dyn Fn(usize, usize),
    ) -> Result<Vec<CutRun>> {
        let Some(cutter) = Cutter::new(&sitter.built) else {
            return Ok(Vec::new());
        };
        let criteria = criteria(ranges, cutter.knows_colours());
        let mut cutting = Cutting::new(self, sitter, cutter)?;
        let all = ranges.distances.len() * criteria.len() * ranges.pixels.len();
        let mut runs = Vec::with_capacity(all);
        for &distance in &ranges.distances {
            let seen = cutting.reference(distance)?;
            for &criterion in &criteria {
                for &pixels in &ranges.pixels {
                    at(runs.len(), all);
                    runs.push(cutting.run(&seen, criterion, pixels)?);
                }
            }
        }
        Ok(runs)
    }
}

fn criteria(ranges: &CutRanges, knows_colours: bool) -> Vec<Criterion> {
    let colours = ranges.colours.iter().filter(|_| knows_colours);
    let colours = colours.map(|&limit| Criterion::Colour(limit));
    [Criterion::Surface, Criterion::Displacement]
        .into_iter()
        .chain(colours)
        .collect()
}

/// The reference from one place.
struct Seen {
    distance: f64,
    camera: Camera,
    picture: Picture,
}

/// A sitter that is cut and drawn.
struct Cutting<'a> {
    bench: &'a Bench<'a>,
    sitter: &'a Sitter,
    cutter: Cutter<'a>,
    reference: Renderer,
    /// Of cuts; none before the first.
    renderer: Option<Renderer>,
    #[cfg(feature = "gpu")]
    device: Option<OnDevice>,
}

/// Base colour as it is: what the limits of colour speak of.
fn unlit() -> Options {
    Options {
        output: Output::Unlit,
        ..Options::default()
    }
}

fn picture(image: &Rendered) -> Picture {
    Picture {
        width: image.width,
        height: image.height,
        rgba: image.rgba8.as_chunks().0.to_vec(),
        has_alpha: true,
    }
}

impl<'a> Cutting<'a> {
    fn new(bench: &'a Bench<'a>, sitter: &'a Sitter, cutter: Cutter<'a>) -> Result<Self> {
        let scene = &sitter.built.scene;
        let subjects = render::subjects(&sitter.built, 0);
        let (attributes, correspond) = (sitter.attributes.clone(), Correspond::Reference);
        let picture = stage_with(attributes, scene, &subjects, correspond, &scene.rest())?;
        Ok(Cutting {
            bench,
            sitter,
            cutter,
            reference: bench.deferred(picture)?,
            renderer: None,
            #[cfg(feature = "gpu")]
            device: OnDevice::new(bench, sitter)?,
        })
    }

    fn reference(&self, distance: f64) -> Result<Seen> {
        let camera = self.sitter.camera(self.bench.settings, distance)?;
        let image = self.reference.draw(&camera, &unlit())?;
        Ok(Seen {
            distance,
            camera,
            picture: picture(&image),
        })
    }

    fn run(&mut self, seen: &Seen, criterion: Criterion, pixels: f64) -> Result<CutRun> {
        let limits = Limits {
            pixels,
            criterion,
            ..Limits::default()
        };
        let cuts = self.cutter.cut(&seen.camera, &limits)?;
        let image = self.draw(&seen.camera, &cuts)?;
        let off = displaced(&self.sitter.built.scene, &seen.camera, &image);
        let like = self.compared(seen, &image)?;
        let views = self.cutter.views(&seen.camera, &limits)?;
        let taken = self.timed(&views);
        let triangles = |r: &Renderer| r.picture().triangle_count();
        Ok(CutRun {
            file: self.sitter.file.clone(),
            mesh: self.sitter.mesh.clone(),
            criterion: criterion.name(),
            pixels,
            colour: criterion.colour(),
            distance: seen.distance,
            triangles: self.renderer.as_ref().map_or(0, triangles),
            reference_triangles: triangles(&self.reference),
            asked: cuts.asked,
            selection_ns_median: taken.map_or(0, |t| t.median_ns),
            selection_ns_p95: taken.map_or(0, |t| t.p95_ns),
            device_selection_ns_median: self.timed_on_device(&views)?,
            bound_pixels: cuts.displacement,
            displaced: Displacements::of(&off),
            compared_pixels: like.compared_pixels,
            flip_mean: like.flip_mean,
            flip_max: like.flip_max,
        })
    }

    fn draw(&mut self, camera: &Camera, cuts: &render::Cuts) -> Result<Rendered> {
        let scene = &self.sitter.built.scene;
        let subjects = self.cutter.subjects(cuts, 1);
        let (correspond, pose) = (Correspond::Inverse, scene.rest());
        let renderer = match self.renderer.take() {
            Some(mut renderer) => {
                renderer.restage(scene, &subjects, correspond, &pose)?;
                renderer
            }
            None => {
                let attributes = self.sitter.attributes.clone();
                let picture = stage_with(attributes, scene, &subjects, correspond, &pose)?;
                self.bench.deferred(picture)?
            }
        };
        self.renderer.insert(renderer).draw(camera, &unlit())
    }

    fn compared(&self, seen: &Seen, image: &Rendered) -> Result<Comparison> {
        let names = ["the reference", "the cut"];
        compare(&seen.picture, &picture(image), Region::Foreground, names)
    }

    fn selections(&self) -> u32 {
        self.bench.settings.budget.frames.clamp(1, SELECTIONS)
    }

    /// Selections on one core, without memory of the one before.
    fn timed(&self, views: &[Vec<View>]) -> Option<TimeStatistics> {
        let once = |_| {
            let start = Instant::now();
            for (model, views) in models(self.sitter, views) {
                std::hint::black_box(model.select(views, &mut Memory::default()));
            }
            start.elapsed().as_nanos() as u64
        };
        let taken: Vec<u64> = (0..self.selections()).map(once).collect();
        TimeStatistics::of(&taken)
    }

    #[cfg(not(feature = "gpu"))]
    fn timed_on_device(&mut self, _: &[Vec<View>]) -> Result<Option<u64>> {
        Ok(None)
    }

    #[cfg(feature = "gpu")]
    fn timed_on_device(&mut self, views: &[Vec<View>]) -> Result<Option<u64>> {
        let selections = self.selections();
        let Some(device) = &mut self.device else {
            return Ok(None);
        };
        device.select(views)?;
        let taken: Vec<u64> = (0..selections)
            .map(|_| device.select(views))
            .collect::<Result<_>>()?;
        Ok(TimeStatistics::of(&taken).map(|t| t.median_ns))
    }
}

/// The models of a sitter's meshes, with what is said of each.
fn models<T>(
    sitter: &Sitter,
    of_meshes: impl IntoIterator<Item = T>,
) -> impl Iterator<Item = (&Multiresolution, T)> {
    let model = |mesh: usize| {
        let hierarchy = sitter.built.of_mesh(mesh)?.hierarchy.as_ref()?;
        Some(&hierarchy.model)
    };
    let of_meshes = of_meshes.into_iter().enumerate();
    of_meshes.filter_map(move |(mesh, of)| Some((model(mesh)?, of)))
}

/// The models on a device.
#[cfg(feature = "gpu")]
struct OnDevice {
    /// For each mesh that has a model its number and what selects there.
    selectors: Vec<(usize, crate::lod::multiresolution::gpu::Selector)>,
}

#[cfg(feature = "gpu")]
impl OnDevice {
    /// None on the processor, and where the device has no room.
    fn new(bench: &Bench, sitter: &Sitter) -> Result<Option<Self>> {
        use crate::asset::Processor;
        use crate::lod::multiresolution::gpu::Selector;
        let context = match bench.processor {
            Processor::Cpu => return Ok(None),
            Processor::Device(context) | Processor::Preferably(context) => context,
        };
        let meshes = &sitter.built.scene.meshes;
        let mut selectors = Vec::new();
        for (model, mesh) in models(sitter, 0..meshes.len()) {
            match Selector::new(context, model, meshes[mesh].triangles.len()) {
                Ok(selector) => selectors.push((mesh, selector)),
                Err(crate::Error::Capacity { .. }) => return Ok(None),
                Err(error) => return Err(error),
            }
        }
        Ok(Some(OnDevice { selectors }))
    }

    /// Nanoseconds of the selection of all meshes.
    fn select(&mut self, views: &[Vec<View>]) -> Result<u64> {
        let mut taken = 0;
        for (mesh, selector) in &mut self.selectors {
            taken += selector.select(&views[*mesh])?.1.total;
        }
        Ok(taken)
    }
}
