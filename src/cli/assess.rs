//! `assess`: which mapping is best for a pair of models, by the four measures.

use std::path::PathBuf;
use std::time::Instant;

use super::assess_light::{Flips, LightReport, Pictured};
use super::device::Device;
use super::print::{Table, percent};
use super::progress::Bar;
use super::recovery::{Recovering, renderer, scene};
use super::view::Size;
use super::{Common, bad_option, note, plain, print};
use invertex::measure::{AssessSettings, Assessment, Heat, Rating, assess_in_cage};
use invertex::output::{encode_png, heat_map, make_folder, write_bytes};
use invertex::recover::{Mapping, Misses};
use invertex::{Error, Result};
use serde::Serialize;

/// Rate the ways from a simple model's surface to a detailed one's.
///
/// The measures are those of Tarini, Cignoni and Scopigno (IEEE Visualization 2003), over parallel views from all around:
/// how far the detail shown lies from what the detailed model shows there (object space), how far it is shifted across
/// the picture (image space; divided by how far it was fetched from: normalised), how unevenly the detail is sampled.
/// Smaller is better in all of them. Rays are cast in full precision; views are none of the directions that visibility is
/// gathered from.
///
/// Last, LOW is drawn with the normals that each mapping bakes, beside HIGH, under a light that turns round the eye, and the
/// pictures are compared by FLIP: what is left of the errors where they are seen.
#[derive(clap::Args)]
#[command(after_help = "\
Mappings: proximity, normal, visibility-face, visibility-vertex, visibility-texel, hybrid-vertex, hybrid-texel, cage, auto;
see `invertex bake --help`. A mapping is rated where it finds a point; --misses proximity rates the closest point in place of
a ray that met nothing, as a bake would, so that all mappings rate the same rays.

JSON: high, low, device, views, rays, size, diagonal (of HIGH's box), reach (of rays, in diagonals), mappings[]: mapping,
object_space, object_space_rms, image_space (means over rays, in percent of the diagonal), image_space_normalized (0 to 1),
sampling_uniformity (0.2: distances between neighbours change by 20 % in the mean), missed_fraction, rays, light_flip: mean,
lights[] (0 same, 1 worst); light: views, size (of pictures, drawn in one grey), off_eye_degrees (between light and eye),
turn_degrees[] (of each light round the eye, 0 from the right, 90 from above), low: mean, lights[] (LOW without detail);
images[]; ms; warnings[].

Files with -o: N_MAPPING_image-space.png and N_MAPPING_object-space.png for LOW's N-th mesh, in its texture: means of rays in
thousandths of a percent.

Examples:
  invertex assess statue.glb statue_low.glb
  invertex assess scan.glb low.glb --maps proximity,normal,hybrid-vertex --views 64 --json
  invertex assess car.glb car_low.glb --maps cage,auto --cage car_cage.glb --lights 12
  invertex assess scan.glb low.glb --maps all -o maps/ --size 2048")]
pub(super) struct Assess {
    /// The detailed model.
    high: PathBuf,
    /// The simple one.
    low: PathBuf,
    /// The mappings, or all.
    #[arg(
        long,
        value_name = "MAPPING,..",
        value_delimiter = ',',
        default_value = "all"
    )]
    maps: Vec<String>,
    /// LOW with its vertices moved outwards, triangles in LOW's order, for cage and auto; see `invertex bake --help`.
    #[arg(long, value_name = "FILE")]
    cage: Option<PathBuf>,
    /// Directions of view, spread evenly.
    #[arg(long, value_name = "N", default_value_t = 512)]
    views: u32,
    /// Rays along each side of a view.
    #[arg(long, value_name = "N", default_value_t = 128)]
    rays: u32,
    /// Directions of light that LOW with baked normals is compared with HIGH under, 60 degrees off the eye; 0: none.
    #[arg(long, value_name = "N", default_value_t = 6)]
    lights: u32,
    /// Directions of view of these pictures.
    #[arg(long, value_name = "N", default_value_t = 4)]
    light_views: u32,
    /// Texels along each side of LOW's texture, whose neighbours tell uniformity, and of its normals under light.
    #[arg(long, value_name = "N", default_value = "1024")]
    size: Size,
    /// A folder for pictures of where rays went wrong.
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// Texels along each side of these pictures.
    #[arg(long, value_name = "N", default_value_t = 512)]
    heat_size: u32,
    /// What stands in where a mapping finds nothing.
    #[arg(long, value_enum, default_value_t = Missed::Blank)]
    misses: Missed,
    #[command(flatten)]
    recovering: Recovering,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Missed {
    /// Nothing: such rays say nothing.
    Blank,
    /// The closest point.
    Proximity,
}

#[derive(Serialize)]
struct Report {
    high: String,
    low: String,
    device: String,
    views: u32,
    rays: u32,
    size: u32,
    diagonal: f64,
    reach: f64,
    mappings: Vec<MappingReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    light: Option<LightReport>,
    images: Vec<String>,
    ms: f64,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct MappingReport {
    mapping: &'static str,
    object_space: f64,
    object_space_rms: f64,
    image_space: f64,
    image_space_normalized: f64,
    sampling_uniformity: f64,
    missed_fraction: f64,
    rays: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    light_flip: Option<Flips>,
}

impl Assess {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        let settings = self.settings()?;
        let (high, low) = (scene(&self.high)?, scene(&self.low)?);
        let cage = self.cage.as_deref().map(scene).transpose()?;
        let device = Device::open(common)?;
        let heard = Bar::new(common, 1);
        let start = Instant::now();
        let draw = |picture| renderer(&device, picture);
        let assessment = assess_in_cage((&high, &low, cage.as_ref()), &settings, &draw, &heard)?;
        let pictured = Pictured {
            high: &high,
            low: &low,
            cage: cage.as_ref(),
            device: &device,
        };
        let lit = match self.lights {
            0 => None,
            lights => Some(pictured.flips(&settings, (lights, self.light_views), &heard)?),
        };
        let ms = start.elapsed().as_secs_f64() * 1e3;
        drop(heard);
        device.check();
        let images = match &self.output {
            Some(folder) => write_maps(folder, &assessment)?,
            None => vec![],
        };
        for warning in &assessment.warnings {
            note(common, warning);
        }
        let (light, flips) = lit.map_or((None, vec![]), |(light, flips)| (Some(light), flips));
        let flips = flips
            .into_iter()
            .map(Some)
            .chain(std::iter::repeat_with(|| None));
        let ratings = assessment.ratings.iter().zip(flips);
        let report = Report {
            high: high.name.clone(),
            low: low.name.clone(),
            device: device.name(),
            views: settings.views,
            rays: settings.rays,
            size: settings.size,
            diagonal: assessment.diagonal,
            reach: assessment.reach,
            mappings: ratings
                .map(|(r, flips)| MappingReport::new(r, flips))
                .collect(),
            light,
            images,
            ms,
            warnings: assessment.warnings.clone(),
        };
        if common.json {
            print::json(&report)
        } else {
            print::text(&report.text())
        }
    }

    fn settings(&self) -> Result<AssessSettings> {
        let Size(size, height) = self.size;
        if size != height {
            return Err(bad_option("--size", "textures are square: give one number"));
        }
        for (option, value, least) in [
            ("--lights", self.lights, 0),
            ("--light-views", self.light_views, 1),
        ] {
            if !(least..=360).contains(&value) {
                return Err(bad_option(
                    option,
                    format!("{value} is outside {least} to 360"),
                ));
            }
        }
        if self.output.is_some() && !(16..=8192).contains(&self.heat_size) {
            let reason = format!("{} is outside 16 to 8192", self.heat_size);
            return Err(bad_option("--heat-size", reason));
        }
        let misses = match self.misses {
            Missed::Blank => Misses::Blank,
            Missed::Proximity => Misses::Proximity,
        };
        Ok(AssessSettings {
            mappings: mappings(&self.maps)?,
            recovery: self.recovering.settings(misses)?,
            layout: self.recovering.layout(),
            views: self.views,
            rays: self.rays,
            size,
            heat: self.output.as_ref().map_or(0, |_| self.heat_size),
        })
    }
}

/// Mappings by name, each once.
fn mappings(names: &[String]) -> Result<Vec<Mapping>> {
    let mut all = Vec::new();
    for name in names {
        let some = match name.trim() {
            "all" => Mapping::OF_TWO_SURFACES.to_vec(),
            name => vec![name.parse().map_err(|error| match error {
                Error::Option { reason, .. } => bad_option("--maps", reason),
                error => error,
            })?],
        };
        for mapping in some {
            if !all.contains(&mapping) {
                all.push(mapping);
            }
        }
    }
    Ok(all)
}

impl MappingReport {
    fn new(rating: &Rating, light_flip: Option<Flips>) -> Self {
        MappingReport {
            mapping: rating.mapping.name(),
            object_space: rating.object_space,
            object_space_rms: rating.object_space_rms,
            image_space: rating.image_space,
            image_space_normalized: rating.image_space_normalized,
            sampling_uniformity: rating.sampling_uniformity,
            missed_fraction: rating.missed_fraction,
            rays: rating.rays,
            light_flip,
        }
    }
}

impl Report {
    /// The paper's Table 1; the best of each column is marked.
    fn text(&self) -> String {
        let columns: [(&str, fn(&MappingReport) -> f64); 4] = [
            ("object space %", |m| m.object_space),
            ("image space %", |m| m.image_space),
            ("normalised", |m| m.image_space_normalized),
            ("uniformity %", |m| m.sampling_uniformity * 100.0),
        ];
        let mut headings = vec!["mapping"];
        headings.extend(columns.iter().map(|(name, _)| *name));
        headings.push("missed");
        let mut table = Table::new(&headings);
        let least =
            columns.map(|(_, of)| self.mappings.iter().map(of).fold(f64::INFINITY, f64::min));
        for mapping in &self.mappings {
            let mut row = vec![mapping.mapping.to_owned()];
            for ((_, of), least) in columns.iter().zip(least) {
                let mark = if of(mapping) == least { "*" } else { " " };
                row.push(format!("{:.4}{mark}", of(mapping)));
            }
            row.push(percent(mapping.missed_fraction));
            table.row(row);
        }
        let mut text = table.text();
        text += &format!(
            "\n* the best; distances in percent of the diagonal, {} views of {} x {} rays\n",
            self.views, self.rays, self.rays
        );
        if let Some(light) = &self.light {
            text += &self.text_of_light(light);
        }
        self.images
            .iter()
            .for_each(|path| text += &format!("{path}\n"));
        text
    }

    /// FLIP, a column for each direction of light.
    fn text_of_light(&self, light: &LightReport) -> String {
        let turns = light
            .turn_degrees
            .iter()
            .map(|turn| format!("{turn:.0} deg"));
        let headings: Vec<String> = ["mapping".into(), "FLIP".into()]
            .into_iter()
            .chain(turns)
            .collect();
        let mut table = Table::new(&headings.iter().map(String::as_str).collect::<Vec<_>>());
        let mut row = |name: &str, flips: &Flips| {
            let numbers = std::iter::once(&flips.mean).chain(&flips.lights);
            let cells = numbers.map(|n| format!("{n:.4}"));
            table.row(std::iter::once(name.to_owned()).chain(cells));
        };
        let rated = self
            .mappings
            .iter()
            .filter_map(|m| Some((m.mapping, m.light_flip.as_ref()?)));
        rated.for_each(|(name, flips)| row(name, flips));
        row("(LOW as it is)", &light.low);
        format!(
            "\n{}\nFLIP of LOW with baked normals against HIGH, in one grey, light {:.0} degrees off the eye and turned round it, \
             {} views of {} x {} pixels\n",
            table.text(),
            light.off_eye_degrees,
            light.views,
            light.size,
            light.size
        )
    }
}

/// Heat maps of every mapping, all on the scale of the worst percentile of all.
fn write_maps(folder: &std::path::Path, assessment: &Assessment) -> Result<Vec<String>> {
    make_folder(folder)?;
    let mut written = Vec::new();
    let kinds: [(&str, fn(&Heat) -> &Vec<Option<f32>>); 2] = [
        ("image-space", |heat| &heat.image_space),
        ("object-space", |heat| &heat.object_space),
    ];
    for (kind, of) in kinds {
        let all = assessment.ratings.iter().flat_map(|r| &r.heat);
        let mut values: Vec<u32> = all
            .flat_map(of)
            .flatten()
            .map(|v| thousandths(*v))
            .collect();
        values.sort_unstable();
        let top = values.get(values.len() * 98 / 100).copied().unwrap_or(1);
        for rating in &assessment.ratings {
            for (k, heat) in rating.heat.iter().enumerate() {
                let values: Vec<Option<u32>> =
                    of(heat).iter().map(|v| v.map(thousandths)).collect();
                let title = format!("{} {kind} (0.001 %)", rating.mapping);
                let (width, height, rgba) = heat_map([heat.size; 2], &values, top, &title)?;
                let path = folder.join(format!("{k}_{}_{kind}.png", plain(rating.mapping.name())));
                write_bytes(&path, &encode_png(width, height, &rgba)?)?;
                written.push(path.display().to_string());
            }
        }
    }
    Ok(written)
}

/// A percentage in thousandths of a percent.
fn thousandths(percent: f32) -> u32 {
    (percent * 1000.0).round() as u32
}
