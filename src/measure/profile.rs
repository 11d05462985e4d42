//! The profile: where fetches and time go when the reference, a LoD with its inverse texture, and the same LoD with
//! baked textures are drawn.
//!
//! In: a [`Sitter`] (a built model, whole or one mesh of it), [`Drawing`]s, where to draw. Out: a [`Run`] for each drawing
//! and distance. Counting and timing are never one run: first an image is drawn and brought back, and its counters are
//! read; then frames are drawn for their times alone.

use super::lookups;
use super::plan::{Drawing, Variant};
use super::run::Run;
use super::table_figures::TableFigures;
use super::timing::{TimeStatistics, pass_statistics};
use crate::asset::{Built, Processor};
use crate::attribute::{AttributeSet, attributes_of};
use crate::igt::{BuildOptions, Layout};
use crate::recover;
use crate::render::{
    self, Camera, Clock, Correspond, Filter, FrameBudget, Options, Output, Picture, Projection,
    Renderer,
};
use crate::{Error, Result};

/// How everything is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileSettings {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Azimuth and elevation, degrees.
    pub view: [f64; 2],
    /// Frames timed, and before them.
    pub budget: FrameBudget,
    /// By the forward path instead of the deferred one. Counters come from the deferred path either way.
    pub forward: bool,
    /// Lit instead of base colour alone.
    pub lit: bool,
    /// Side of baked textures, texels.
    pub bake_size: u32,
}

impl Default for ProfileSettings {
    fn default() -> Self {
        ProfileSettings {
            size: [1024, 768],
            view: [30.0, 20.0],
            budget: FrameBudget {
                warm_up: 5,
                frames: 200,
                seconds: Some(1.0),
            },
            forward: false,
            lit: true,
            bake_size: 1024,
        }
    }
}

/// What is drawn: a model, with its textures read.
pub struct Sitter {
    /// The file it is from.
    pub file: String,
    /// The mesh that is drawn alone, or [`WHOLE`].
    pub mesh: String,
    /// The model.
    pub built: Built,
    /// What was replaced when its textures were read.
    pub warnings: Vec<String>,
    pub(super) attributes: AttributeSet,
    sphere: ([f64; 3], f64),
}

/// The name of a whole model of several meshes among the meshes.
pub const WHOLE: &str = "*";

impl Sitter {
    /// Reads the textures of `built`.
    ///
    /// # Errors
    /// [`Error::Capacity`] where the textures are too large.
    pub fn new(file: &str, mesh: &str, built: Built, lit: bool) -> Result<Self> {
        let (attributes, warnings) = attributes_of(&built.scene, lit)?;
        Ok(Sitter {
            file: file.to_owned(),
            mesh: mesh.to_owned(),
            sphere: render::reference_sphere(&built.scene)?,
            built,
            warnings,
            attributes,
        })
    }

    /// The camera that is `distance` times as far away as one that the model fills.
    pub fn camera(&self, settings: &ProfileSettings, distance: f64) -> Result<Camera> {
        let (centre, radius) = self.sphere;
        let projection = Projection::Perspective;
        Camera::framed_from(
            distance,
            centre,
            radius,
            settings.view,
            projection,
            settings.size,
        )
    }

    /// Centre and radius of a sphere round the reference, world units.
    pub fn sphere(&self) -> ([f64; 3], f64) {
        self.sphere
    }
}

/// Where profiles are taken.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// What draws and builds tables.
    pub processor: Processor<'a>,
    /// How.
    pub settings: &'a ProfileSettings,
}

impl Bench<'_> {
    /// The rows of one drawing: one for each distance.
    ///
    /// # Errors
    /// Those of building tables, baking and drawing; [`Error::Option`] where the forward path is asked of the processor.
    pub fn runs(&self, sitter: &Sitter, drawing: &Drawing) -> Result<Vec<Run>> {
        let rebuilt = drawing.tables.map(|tables| self.rebuilt(sitter, tables));
        let rebuilt = rebuilt.transpose()?;
        let built = rebuilt.as_ref().unwrap_or(&sitter.built);
        let picture = self.picture(sitter, built, drawing)?;
        let row = self.row(sitter, built, drawing, &picture);
        let cameras = drawing.distances.iter().map(|&distance| {
            let camera = sitter.camera(self.settings, distance)?;
            Ok((distance, camera))
        });
        let cameras = cameras.collect::<Result<Vec<_>>>()?;
        let renderer = self.deferred(picture)?;
        let (mut runs, points) = self.count(&renderer, built, &row, &cameras)?;
        let renderer = if self.settings.forward {
            self.forward(renderer.picture().clone())?
        } else {
            renderer
        };
        self.time(&renderer, &mut runs, &cameras)?;
        for (run, points) in runs.iter_mut().zip(points) {
            let time = |mesh| lookups::time(self.processor, mesh, &points, &self.settings.budget);
            let taken = built.meshes.first().map(time).transpose()?.flatten();
            run.lookup_ns_median = taken.map(|t| t.median_ns);
            run.lookup_ns_p95 = taken.map(|t| t.p95_ns);
        }
        Ok(runs)
    }

    fn rebuilt(&self, sitter: &Sitter, (hash, layout): (Option<u32>, Layout)) -> Result<Built> {
        let options = |mesh: &crate::asset::BuiltMesh| BuildOptions {
            hash: hash.unwrap_or(mesh.tables.hash_size[0]),
            layout,
        };
        sitter.built.rebuilt(options, self.processor)
    }

    fn picture(&self, sitter: &Sitter, built: &Built, drawing: &Drawing) -> Result<Picture> {
        let (scene, attributes) = (&built.scene, &sitter.attributes);
        let subjects = render::subjects(built, drawing.level);
        let correspond = match drawing.variant {
            Variant::Reference => Correspond::Reference,
            Variant::Inverse => Correspond::Inverse,
            Variant::Plain => Correspond::Plain,
            Variant::Baked => {
                let size = self.settings.bake_size;
                return recover::stage_baked(attributes, scene, &subjects, size);
            }
        };
        let pose = scene.rest();
        render::stage_with(attributes.clone(), scene, &subjects, correspond, &pose)
    }

    /// What is known of a run before anything is drawn.
    fn row(&self, sitter: &Sitter, built: &Built, drawing: &Drawing, picture: &Picture) -> Run {
        let tables = TableFigures::of(built, drawing.variant);
        Run {
            file: sitter.file.clone(),
            mesh: sitter.mesh.clone(),
            variant: drawing.variant,
            sweep: drawing.sweep,
            filter: drawing.filter,
            lod: drawing.level,
            distance: 1.0,
            layout: tables.layout,
            hash: tables.hash,
            triangles: picture.triangle_count(),
            mean_list: tables.mean_list,
            mean_fetches: 0.0,
            mean_fetches_with_uv: 0.0,
            p99_fetches: 0,
            max_fetches: 0,
            mean_texture_fetches: 0.0,
            tables_bytes: tables.bytes,
            texture_bytes: picture.texture_bytes(),
            covered_pixels: 0,
            unmapped_pixels: 0,
            frame_ns_median: 0,
            frame_ns_p95: 0,
            frame_ns_p99: 0,
            lookup_ns_median: None,
            lookup_ns_p95: None,
            frames: 0,
            clock: Clock::Wall,
            passes: Vec::new(),
            histogram: Vec::new(),
            tests_histogram: Vec::new(),
            mean_tests: None,
            times: Vec::new(),
            fetches: Vec::new(),
        }
    }

    fn options(&self, filter: Filter) -> Options {
        Options {
            filter,
            output: if self.settings.lit {
                Output::Lit
            } else {
                Output::Unlit
            },
            ..Options::default()
        }
    }

    /// A row for each camera with its counters, and the points that its pixels look up where they are of one mesh. Always
    /// by the deferred path: it counts the same everywhere.
    fn count(
        &self,
        renderer: &Renderer,
        built: &Built,
        row: &Run,
        cameras: &[(f64, Camera)],
    ) -> Result<(Vec<Run>, Vec<Vec<[i32; 3]>>)> {
        let (mut runs, mut points) = (Vec::new(), Vec::new());
        let instances = built.scene.instances();
        for &(distance, camera) in cameras {
            let image = renderer.draw(&camera, &self.options(row.filter))?;
            let run = Run {
                distance,
                ..row.clone()
            };
            let mut run = run.counted(&image, renderer.picture());
            points.push(match built.meshes.as_slice() {
                [mesh]
                    if row.variant == Variant::Inverse
                        && instances.iter().all(|i| i.mesh == mesh.mesh) =>
                {
                    let points = lookups::points(&built.scene.meshes[mesh.mesh], mesh, &image)?;
                    run = run.tested(lookups::tests(mesh, &image, &points));
                    points
                }
                _ => Vec::new(),
            });
            runs.push(run);
        }
        Ok((runs, points))
    }

    /// Fills in the times.
    fn time(&self, renderer: &Renderer, runs: &mut [Run], cameras: &[(f64, Camera)]) -> Result<()> {
        for (run, (_, camera)) in runs.iter_mut().zip(cameras) {
            let options = self.options(run.filter);
            let taken = renderer.time(camera, &options, &self.settings.budget)?;
            let totals: Vec<u64> = taken.frames.iter().map(|f| f.total).collect();
            if let Some(statistics) = TimeStatistics::of(&totals) {
                run.frame_ns_median = statistics.median_ns;
                run.frame_ns_p95 = statistics.p95_ns;
                run.frame_ns_p99 = statistics.p99_ns;
                run.frames = statistics.runs;
            }
            run.clock = taken.clock;
            run.passes = pass_statistics(taken.frames.iter().map(|f| f.passes.as_slice()));
            run.times = taken.frames;
        }
        Ok(())
    }

    pub(super) fn deferred(&self, picture: Picture) -> Result<Renderer> {
        match self.processor {
            Processor::Cpu => Ok(Renderer::cpu(picture)),
            #[cfg(feature = "gpu")]
            Processor::Device(context) | Processor::Preferably(context) => {
                Renderer::on(context, picture)
            }
            #[cfg(not(feature = "gpu"))]
            Processor::Absent(never) => match *never {},
        }
    }

    fn forward(&self, picture: Picture) -> Result<Renderer> {
        match self.processor {
            #[cfg(feature = "gpu")]
            Processor::Device(context) | Processor::Preferably(context) => {
                Renderer::forward(context, picture)
            }
            _ => {
                drop(picture);
                let reason = "the forward path is drawn by a device only; see `invertex doctor`, or use --path deferred";
                Err(Error::NoDevice {
                    reason: reason.into(),
                })
            }
        }
    }
}
