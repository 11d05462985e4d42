//! `query`: which reference point stands for given addresses.

use std::path::PathBuf;

use invertex::asset::{self, Model};
#[cfg(feature = "gpu")]
use invertex::igt;
use invertex::igt::{Cost, Found, Tables};
use invertex::param::Primary;
use invertex::scene::read_file;
use invertex::{Error, Result};
use rayon::prelude::*;
use serde::Serialize;

use super::device::Device;
use super::{Common, mesh_named, points, print};

/// Look up which point of the reference stands for given points of texture space.
///
/// Points are `u,v` for a mesh whose primary is a uv set, `x,y,z` (object space) for plane, cylinder and sphere; one
/// point a line. Blank lines, lines that begin with #, and a first line of column names are skipped. Prints one line a
/// point: triangle,b0,b1,b2,fetches; triangle -1 where nothing is mapped.
#[derive(clap::Args)]
#[command(after_help = "\
JSON: mesh, primary, device, points, mapped, mean_fetches, max_fetches, results[]: triangle (-1: nothing), barycentric[],
fetches, hit (false: the nearest point, outside every chart).

Examples:
  invertex query built.glb --points uv.csv > found.csv
  printf '0.25,0.5\\n0.26,0.5\\n' | invertex query built.glb --points -
  invertex query built.glb --mapped --points few.csv           a large file, few points: milliseconds
  invertex query built.glb --mesh Hose_low --points uv.csv --nearest --json")]
pub(super) struct Query {
    /// A file that `build` made.
    built: PathBuf,
    /// The points, as CSV; - for standard input.
    #[arg(long, value_name = "FILE.csv", allow_hyphen_values = true)]
    points: PathBuf,
    /// The mesh to ask; needed where there are several.
    #[arg(long, value_name = "NAME")]
    mesh: Option<String>,
    /// Where nothing is mapped, give the nearest listed point of the reference.
    #[arg(long)]
    nearest: bool,
    /// Ask as a LoD triangle of this layer does (0 to 254): its own part's hits come first.
    #[arg(long, value_name = "N")]
    layer: Option<u8>,
    /// Map the file and read nothing of it but what lookups need. Every index is still checked, but neither the tables'
    /// checksum nor whether the mesh is the one they were built for.
    #[arg(long)]
    mapped: bool,
    /// Begin with a line of column names.
    #[arg(long)]
    header: bool,
}

#[derive(Serialize)]
struct Report {
    mesh: String,
    primary: String,
    device: String,
    points: usize,
    mapped: usize,
    mean_fetches: f64,
    max_fetches: u32,
    results: Vec<Answer>,
}

#[derive(Serialize)]
struct Answer {
    triangle: i64,
    barycentric: [f32; 3],
    fetches: u32,
    hit: bool,
}

impl Query {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        let mut all = self.tables()?;
        let file = self.built.display().to_string();
        let names = || all.iter().map(|(name, _)| name.as_str());
        let at = match (&self.mesh, all.len()) {
            (Some(name), _) => mesh_named(&file, names(), name)?,
            (None, 1) => 0,
            (None, _) => {
                let listed: Vec<&str> = names().collect();
                return Err(bad_mesh(&listed));
            }
        };
        let (name, tables) = all.swap_remove(at);
        let queries = self.queries(&tables.primary)?;
        let device = Device::open(common)?;
        let answers = self.answers(&tables, &queries, &device)?;
        device.check();
        if common.json {
            return print::json(&report(&name, &tables.primary, &device, answers));
        }
        print::text(&self.csv(&answers))
    }

    /// The tables of each mesh, with its name.
    fn tables(&self) -> Result<Vec<(String, Tables)>> {
        if self.mapped {
            let file = asset::open_tables(&self.built)?;
            let named = |mesh: asset::MeshTables| (mesh.name, mesh.tables);
            return Ok(file.meshes.into_iter().map(named).collect());
        }
        let Model::Built(built) = Model::load(&self.built)? else {
            return Err(Error::input(
                self.built.display().to_string(),
                "extensions",
                "this model has no inverse textures; run `invertex build` first",
            ));
        };
        let meshes = &built.scene.meshes;
        let named = |mesh: asset::BuiltMesh| (meshes[mesh.mesh].name.clone(), mesh.tables);
        Ok(built.meshes.into_iter().map(named).collect())
    }

    /// The points on the query grid.
    fn queries(&self, primary: &Primary) -> Result<Vec<[i32; 3]>> {
        let (name, bytes) = if self.points.as_os_str() == "-" {
            ("standard input".to_owned(), points::standard_input()?)
        } else {
            (self.points.display().to_string(), read_file(&self.points)?)
        };
        let points = points::parse(&name, &bytes, primary)?;
        Ok(points
            .into_par_iter()
            .map(|t3| primary.to_query(t3))
            .collect())
    }

    fn answers(
        &self,
        tables: &Tables,
        queries: &[[i32; 3]],
        device: &Device,
    ) -> Result<Vec<Answer>> {
        #[cfg(feature = "gpu")]
        if let Some(context) = device.context() {
            let found = igt::gpu::query(context, tables, queries, self.layer, self.nearest)?;
            return Ok(found.into_iter().map(answer).collect());
        }
        let _ = device;
        let one =
            |&query: &[i32; 3]| answer(tables.lookup_with_cost(query, self.layer, self.nearest));
        Ok(queries.par_iter().map(one).collect())
    }

    fn csv(&self, answers: &[Answer]) -> String {
        use std::fmt::Write;
        let mut text = String::with_capacity(answers.len() * 40 + 32);
        if self.header {
            text += "triangle,b0,b1,b2,fetches\n";
        }
        for a in answers {
            // `{}` of a float is the shortest text that reads back as the same float.
            let [b0, b1, b2] = a.barycentric;
            let _ = writeln!(text, "{},{b0},{b1},{b2},{}", a.triangle, a.fetches);
        }
        text
    }
}

fn bad_mesh(names: &[&str]) -> Error {
    super::bad_option(
        "--mesh",
        format!("is needed, there are several: {}", names.join(", ")),
    )
}

fn answer((found, cost): (Option<Found>, Cost)) -> Answer {
    match found {
        Some(f) => Answer {
            triangle: f.triangle.into(),
            barycentric: f.barycentric,
            fetches: f.fetches,
            hit: f.hit,
        },
        None => Answer {
            triangle: -1,
            barycentric: [0.0; 3],
            fetches: cost.fetches,
            hit: false,
        },
    }
}

fn report(mesh: &str, primary: &Primary, device: &Device, results: Vec<Answer>) -> Report {
    Report {
        mesh: mesh.to_owned(),
        primary: primary.kind.to_string(),
        device: device.name(),
        points: results.len(),
        mapped: results.iter().filter(|a| a.triangle >= 0).count(),
        mean_fetches: results.iter().map(|a| f64::from(a.fetches)).sum::<f64>()
            / results.len().max(1) as f64,
        max_fetches: results.iter().map(|a| a.fetches).max().unwrap_or(0),
        results,
    }
}
