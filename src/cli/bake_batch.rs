//! `bake` of many pairs: a folder of models named by convention, or a manifest.
//!
//! In: a folder or a JSON file. Out: [`Job`]s, each baked into a folder of its own; one that fails does not keep the others
//! from being done.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use super::bake::Bake;
use super::bake_report::Report;
use super::view::Size;
use super::{Common, bad_option, note, plain, print};
use invertex::output::make_folder;
use invertex::recover::{Role, role};
use invertex::{Error, Result};
use serde::{Deserialize, Serialize};

/// A manifest. Unknown words are refused: a mistyped one would be left out silently.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    jobs: Vec<Job>,
}

/// One pair; what it does not say the command line does.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Job {
    high: PathBuf,
    /// None: a built file.
    low: Option<PathBuf>,
    cage: Option<PathBuf>,
    /// The folder within OUT; the stem of LOW (or HIGH) where it is not said.
    output: Option<String>,
    map: Option<String>,
    attributes: Option<Vec<String>>,
    size: Option<u32>,
    by_name: Option<bool>,
}

/// What became of a job.
#[derive(Serialize)]
struct Outcome {
    name: String,
    #[serde(flatten)]
    report: Option<Report>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

#[derive(Serialize)]
struct Outcomes {
    jobs: Vec<Outcome>,
}

/// The jobs that HIGH names; none where it is a model.
///
/// # Errors
/// [`Error::Option`] where LOW is named as well; [`Error::Input`] and [`Error::Io`] for a manifest or folder that cannot be
/// used.
pub(super) fn jobs(bake: &Bake) -> Result<Option<Vec<Job>>> {
    let path = bake.high.as_path();
    let is_manifest = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("json"));
    if !is_manifest && !path.is_dir() {
        return Ok(None);
    }
    if bake.low.is_some() || bake.cage.is_some() {
        let reason = "a folder or a manifest names the models to bake for itself";
        return Err(bad_option("LOW", reason));
    }
    let jobs = match is_manifest {
        true => manifest(path)?,
        false => in_folder(path)?,
    };
    distinct(path, &jobs)?;
    Ok(Some(jobs))
}

fn manifest(path: &Path) -> Result<Vec<Job>> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|source| Error::Io {
        path: path.to_path_buf(),
        source,
    })?;
    let parsed: Manifest = serde_json::from_str(&text)
        .map_err(|error| Error::input(&file, "manifest", error.to_string()))?;
    if parsed.jobs.is_empty() {
        return Err(Error::input(file, "jobs", "there are none"));
    }
    let beside = path.parent().unwrap_or(Path::new(""));
    let placed = |job: Job| Job {
        high: beside.join(&job.high),
        low: job.low.map(|low| beside.join(low)),
        cage: job.cage.map(|cage| beside.join(cage)),
        ..job
    };
    Ok(parsed.jobs.into_iter().map(placed).collect())
}

/// The pairs of a folder, by name.
fn in_folder(folder: &Path) -> Result<Vec<Job>> {
    let fault = |source| Error::Io {
        path: folder.to_path_buf(),
        source,
    };
    let mut sets: BTreeMap<String, [Option<PathBuf>; 3]> = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        if let Some((stem, role)) = role_of(&path) {
            // Of several that would do the first by name, whatever order the folder has.
            let slot = &mut sets.entry(stem).or_default()[role as usize];
            let first = slot.take().map_or(path.clone(), |other| other.min(path));
            *slot = Some(first);
        }
    }
    let job = |(stem, [low, high, cage]): (String, [Option<PathBuf>; 3])| {
        Some(Job {
            high: high?,
            low: Some(low?),
            cage,
            output: Some(stem),
            map: None,
            attributes: None,
            size: None,
            by_name: None,
        })
    };
    let jobs: Vec<Job> = sets.into_iter().filter_map(job).collect();
    if jobs.is_empty() {
        let reason = "holds no pair of models NAME_high.glb and NAME_low.glb";
        return Err(Error::input(folder.display().to_string(), "folder", reason));
    }
    Ok(jobs)
}

/// What a model is by its file's name, and the name without the ending.
fn role_of(path: &Path) -> Option<(String, Role)> {
    let kind = path.extension()?.to_str()?.to_lowercase();
    match ["glb", "gltf"].contains(&kind.as_str()) {
        true => role(path.file_stem()?.to_str()?),
        false => None,
    }
}

/// Refuses jobs that would write over each other, or outside of OUT.
fn distinct(path: &Path, jobs: &[Job]) -> Result<()> {
    let fault = |k: usize, reason: String| {
        Err(Error::input(
            path.display().to_string(),
            format!("job {k}"),
            reason,
        ))
    };
    let names: Vec<String> = jobs.iter().map(Job::name).collect();
    for (k, name) in names.iter().enumerate() {
        let mut parts = Path::new(name).components();
        if !matches!(
            (parts.next(), parts.next()),
            (Some(Component::Normal(_)), None)
        ) {
            return fault(
                k,
                format!("its output \"{name}\" is not the name of a folder within OUT"),
            );
        }
        if let Some(other) = names[..k].iter().position(|n| n == name) {
            return fault(
                k,
                format!("writes to \"{name}\", as job {other} does: give it another output"),
            );
        }
    }
    Ok(())
}

impl Job {
    /// The folder within OUT.
    fn name(&self) -> String {
        let model = self.low.as_ref().unwrap_or(&self.high);
        let stem = || plain(&model.file_stem().unwrap_or_default().to_string_lossy());
        self.output.clone().unwrap_or_else(stem)
    }

    /// The command of this job alone.
    fn command(&self, bake: &Bake) -> Bake {
        let mut one = bake.clone();
        one.high.clone_from(&self.high);
        one.low.clone_from(&self.low);
        one.cage.clone_from(&self.cage);
        one.output = bake.output.join(self.name());
        one.map = self.map.clone().or(one.map);
        one.by_name = self.by_name.unwrap_or(one.by_name);
        if let Some(attributes) = &self.attributes {
            one.attributes.clone_from(attributes);
        }
        if let Some(size) = self.size {
            one.size = Size(size, size);
        }
        one
    }
}

/// Does all jobs, one after the other, and says what became of them.
///
/// # Errors
/// That of the first job that failed, after all are done; [`Error::Cancelled`] at once.
pub(super) fn run(bake: &Bake, jobs: &[Job], common: &Common) -> Result<()> {
    make_folder(&bake.output)?;
    let (mut outcomes, mut first) = (Vec::new(), None);
    for job in jobs {
        let name = job.name();
        let (report, error) = match job.command(bake).bake(common) {
            Ok(report) => (Some(report), None),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                let told = error.to_string();
                note(common, &format!("{name}: {told}"));
                first.get_or_insert(error);
                (None, Some(told))
            }
        };
        outcomes.push(Outcome {
            name,
            report,
            error,
        });
    }
    if common.json {
        print::json(&Outcomes { jobs: outcomes })?;
    } else {
        let text = |o: &Outcome| match &o.report {
            Some(report) => format!("{}\n{}", o.name, report.text()),
            None => format!("{}: {}\n", o.name, o.error.as_deref().unwrap_or_default()),
        };
        print::text(&outcomes.iter().map(text).collect::<Vec<_>>().join("\n"))?;
    }
    first.map_or(Ok(()), Err)
}
