//! The command line: flags in, one library call, tables or JSON out.
//!
//! stdout carries results only; bars, notes and logs go to stderr. Exit codes: 0 done, 2 usage, 3 bad input, 4 no
//! usable device, 5 a comparison failed, 70 our own bug (a panic, caught here).

mod ambiguous;
mod assess;
mod assess_light;
mod attribute;
mod bake;
mod bake_around;
mod bake_batch;
mod bake_files;
mod bake_preview;
mod bake_report;
mod bake_settings;
mod build;
mod build_choices;
mod compare;
mod demo;
mod demo_report;
mod device;
mod doctor;
mod drawing;
mod fly;
mod fly_report;
mod inspect;
mod lod_choice;
mod manual;
mod maps;
mod motion;
mod points;
mod print;
mod profile;
mod profile_cuts;
mod profile_found;
mod profile_report;
mod profile_table;
mod progress;
mod query;
mod recovery;
mod render;
mod render_report;
mod render_stages;
mod view;

use std::io::{self, IsTerminal, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use invertex::{Error, Result};

/// Inverse geometric textures: all of a reference mesh's appearance on any simplified version of it.
#[derive(Parser)]
#[command(name = "invertex", version, propagate_version = true, max_term_width = 110, after_help = EXAMPLES)]
struct Command {
    #[command(subcommand)]
    verb: Verb,
    #[command(flatten)]
    common: Common,
}

/// Options of every verb.
#[derive(clap::Args, Clone, Debug)]
struct Common {
    /// Print one JSON document instead of a table.
    #[arg(long, global = true, help_heading = "Output")]
    json: bool,
    /// Where to compute: `auto` (a device if there is one and it has room, else the processor), `cpu` (the reference
    /// implementation; needs no Vulkan), the index of a device, or part of its name.
    #[arg(long, global = true, default_value = "auto", value_name = "DEVICE")]
    device: String,
    /// Say more on stderr: -v what is decided, -vv how, -vvv everything.
    #[arg(short, long, global = true, action = clap::ArgAction::Count, help_heading = "Output")]
    verbose: u8,
    /// No bars and no notes on stderr; errors remain.
    #[arg(
        short,
        long,
        global = true,
        conflicts_with = "verbose",
        help_heading = "Output"
    )]
    quiet: bool,
}

#[derive(Subcommand)]
enum Verb {
    /// Say which devices there are, what is missing, and how to get it.
    Doctor(doctor::Doctor),
    /// Say what is in a model, and which primary parameterizations fit each mesh.
    Inspect(inspect::Inspect),
    /// Turn a model into one GLB with its LoDs and inverse geometric textures.
    Build(build::Build),
    /// Look up which point of the reference stands for given points of texture space.
    Query(query::Query),
    /// Draw a model, or a LoD of it that looks like the original.
    Render(render::Render),
    /// Resample attributes of a reference into textures of a simpler surface.
    Bake(bake::Bake),
    /// Rate the ways from a simple model's surface to a detailed one's.
    Assess(assess::Assess),
    /// Say where fetches and time go: counts, times, memory, sweeps, heat maps.
    Profile(profile::Profile),
    /// Fly round a model, and see which triangles are drawn.
    Fly(fly::Fly),
    /// Compare two pictures, or two folders of pictures by name.
    Compare(compare::Compare),
    /// Do all of it on the bundled model, ending with an HTML report.
    Demo(demo::Demo),
    /// Print completions for a shell.
    Completions(manual::Completions),
    /// Print the manual page (roff).
    Man(manual::Man),
}

const EXAMPLES: &str = "\
Examples:
  invertex doctor                                              devices, and what is missing
  invertex build model.glb -o built.glb                        LoDs and inverse texture, all in one GLB
  invertex render built.glb -o lod2.png --mode igt --lod 2     a picture of a LoD that looks like the reference
  invertex bake built.glb -o textures/ --attributes normal     the reference's detail as textures of a LoD
  invertex bake scan.glb low.glb -o textures/ --attributes normal   a detailed model's normals as a texture of a simple one
  invertex assess scan.glb low.glb                             which of the ways there is best
  invertex profile built.glb                                   where fetches and time go
  invertex fly mrm.glb -o flight/                              cuts of a multiresolution model on the way
  invertex demo report/                                        everything on the bundled model, as an HTML report

`invertex VERB --help` ends with examples of each verb.";

/// Exit code for our own bugs (EX_SOFTWARE of sysexits.h).
const INTERNAL_ERROR: u8 = 70;

/// Parses the arguments, runs the verb, and turns every outcome into an exit code.
pub(crate) fn main() -> ExitCode {
    let command = match Command::try_parse() {
        Ok(command) => command,
        Err(usage) => return usage_exit(&usage),
    };
    start_log(&command.common);
    std::panic::set_hook(Box::new(|panic| tracing::info!("{panic}")));
    match catch_unwind(AssertUnwindSafe(|| run(&command))) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) => {
            report(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
        Err(cause) => {
            let what = cause.downcast_ref::<String>().map(String::as_str);
            let what = what
                .or_else(|| cause.downcast_ref::<&str>().copied())
                .unwrap_or("unknown cause");
            report(&format!(
                "internal error: {what}; this is a bug in invertex {}: please report it with the command and the \
                 input (-v shows where)",
                env!("CARGO_PKG_VERSION")
            ));
            ExitCode::from(INTERNAL_ERROR)
        }
    }
}

fn run(command: &Command) -> Result<()> {
    let common = &command.common;
    match &command.verb {
        Verb::Doctor(verb) => verb.run(common),
        Verb::Inspect(verb) => verb.run(common),
        Verb::Build(verb) => verb.run(common),
        Verb::Query(verb) => verb.run(common),
        Verb::Render(verb) => verb.run(common),
        Verb::Bake(verb) => verb.run(common),
        Verb::Assess(verb) => verb.run(common),
        Verb::Profile(verb) => verb.run(common),
        Verb::Fly(verb) => verb.run(common),
        Verb::Compare(verb) => verb.run(common),
        Verb::Demo(verb) => verb.run(common),
        Verb::Completions(verb) => verb.run(),
        Verb::Man(verb) => verb.run(),
    }
}

/// Help and version go to stdout with 0, wrong usage to stderr with 2; a reader that closed the pipe is no error.
fn usage_exit(usage: &clap::Error) -> ExitCode {
    let _ = usage.print();
    ExitCode::from(if usage.use_stderr() { 2 } else { 0 })
}

/// One line on stderr, whatever line breaks the text holds.
fn report(text: &str) {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let _ = writeln!(io::stderr(), "{line}");
}

/// A remark on stderr that is neither result nor error; `--quiet` drops it.
fn note(common: &Common, text: &str) {
    if !common.quiet {
        report(&format!("note: {text}"));
    }
}

fn start_log(common: &Common) {
    use tracing_subscriber::EnvFilter;
    let level = ["warn", "info", "debug", "trace"][usize::from(common.verbose.min(3))];
    let level = if common.quiet { "error" } else { level };
    // RUST_LOG, where set, is the finer instrument.
    let filter = EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| EnvFilter::new(format!("invertex={level}")));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .without_time()
        .with_target(false)
        .init();
}

/// An [`Error::Option`]: an option whose value cannot be used.
fn bad_option(option: &'static str, reason: impl Into<String>) -> Error {
    Error::Option {
        option,
        reason: reason.into(),
    }
}

/// The place of the mesh called `name` among `names`.
///
/// # Errors
/// [`Error::Input`] listing the names there are.
fn mesh_named<'a>(file: &str, names: impl Iterator<Item = &'a str>, name: &str) -> Result<usize> {
    let names: Vec<&str> = names.collect();
    names
        .iter()
        .position(|&other| other == name)
        .ok_or_else(|| {
            let reason = format!("there is no such mesh; there are: {}", names.join(", "));
            Error::input(file, format!("mesh \"{name}\""), reason)
        })
}

/// A name as a part of a file's name.
fn plain(name: &str) -> String {
    let keep = |c: char| {
        if c.is_alphanumeric() || "-_.".contains(c) {
            c
        } else {
            '-'
        }
    };
    name.chars().map(keep).collect()
}
