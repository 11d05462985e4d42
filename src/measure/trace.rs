//! A profile as a trace: Chrome's trace event format, which Perfetto and chrome://tracing open.
//!
//! In: [`Run`]s with their frames. Out: one JSON document: a process for each run, in it a track for each pass, frames one
//! after the other. Devices tell durations, not when something began; a run's frames are laid end to end.

use super::run::Run;
use serde_json::{Value, json};

/// The trace of `runs`.
pub fn chrome_trace(runs: &[Run]) -> Value {
    let mut events = Vec::new();
    for (process, run) in runs.iter().enumerate() {
        add(&mut events, process + 1, run);
    }
    json!({ "displayTimeUnit": "ms", "traceEvents": events })
}

fn add(events: &mut Vec<Value>, process: usize, run: &Run) {
    let named = |what: &str, track: usize, name: &str| json!({ "ph": "M", "name": what, "pid": process, "tid": track, "args": { "name": name } });
    events.push(named("process_name", 0, &title(run)));
    events.push(named("thread_name", 0, "frame"));
    for (k, pass) in run.passes.iter().enumerate() {
        events.push(named("thread_name", k + 1, &pass.name));
    }
    let mut start = 0u64;
    for (number, frame) in run.times.iter().enumerate() {
        let event = |name: &str, track: usize, begin: u64, duration: u64| {
            let microseconds = |ns: u64| ns as f64 / 1e3;
            json!({
                "ph": "X", "cat": run.variant.name(), "name": name, "pid": process, "tid": track,
                "ts": microseconds(begin), "dur": microseconds(duration), "args": { "frame": number },
            })
        };
        events.push(event("frame", 0, start, frame.total));
        let mut begin = start;
        for (name, nanoseconds) in &frame.passes {
            let track = run.passes.iter().position(|pass| pass.name == *name);
            events.push(event(name, track.map_or(0, |k| k + 1), begin, *nanoseconds));
            begin += nanoseconds;
        }
        start += frame.total.max(begin - start);
    }
}

/// A run in a few words.
fn title(run: &Run) -> String {
    let mut title = format!("{} {}", run.mesh, run.variant.name());
    if run.lod > 0 {
        title += &format!(", LoD {}", run.lod);
    }
    if let (Some(layout), Some(hash)) = (run.layout, run.hash) {
        title += &format!(", {} {hash}", format!("{layout:?}").to_lowercase());
    }
    if run.distance != 1.0 {
        title += &format!(", distance {}", run.distance);
    }
    title
}
