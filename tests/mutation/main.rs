//! Mutated inputs: whatever bytes come, every reader gives a result or an error. No panic, no hang, no memory by a claim.
//!
//! The inputs run in a child process with 1 GiB of address space (`ulimit -v`), so that an allocation out of proportion is an
//! abort, and with a watchdog, so that a hang is one too. `INVERTEX_MUTATIONS` sets how many (20,000; with
//! `INVERTEX_LONG=1` a million); input `i` is made from the number `i` alone, so that `INVERTEX_MUTATION_FIRST=i` runs
//! it again.

#[path = "../long/mod.rs"]
mod long;
mod make;
mod readers;

use std::os::unix::fs::FileExt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::{Command, Output, exit};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Address space of the child, in KiB.
const ADDRESS_SPACE_KIB: u64 = 1 << 20;
/// Longest that one input may take; many times what any takes, on a machine busy with other tests.
const PATIENCE: Duration = Duration::from_secs(60);
/// The test that does the work when it finds itself in the child.
const CHILD: &str = "child";

fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name)
        .ok()
        .and_then(|value| value.parse().ok())
        .unwrap_or(otherwise)
}

/// Runs the child over `count` inputs; `fault` makes it misbehave on purpose.
fn run_child(count: u64, first: u64, fault: &str) -> (Output, u64) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("at");
    std::fs::write(&at, [0; 8]).unwrap();
    let output = Command::new("sh")
        .args([
            "-c",
            &format!("ulimit -v {ADDRESS_SPACE_KIB} && exec \"$0\" --exact {CHILD} --nocapture"),
        ])
        .arg(std::env::current_exe().unwrap())
        .env("INVERTEX_MUTATION_AT", &at)
        .env("INVERTEX_MUTATIONS", count.to_string())
        .env("INVERTEX_MUTATION_FIRST", first.to_string())
        .env("INVERTEX_MUTATION_FAULT", fault)
        .env("RAYON_NUM_THREADS", "2")
        .output()
        .unwrap();
    let last = u64::from_le_bytes(std::fs::read(&at).unwrap().try_into().unwrap());
    (output, last)
}

#[test]
fn mutated_inputs_give_a_result_or_an_error() {
    let count = long::count("INVERTEX_MUTATIONS", 20_000, 1_000_000);
    let (output, last) = run_child(count, number("INVERTEX_MUTATION_FIRST", 0), "");
    let text = String::from_utf8_lossy(&output.stdout);
    for line in text.lines().filter(|line| line.contains("mutated inputs")) {
        long::proved("mutation", "a result or an error", line);
    }
    let errors = String::from_utf8_lossy(&output.stderr);
    let tail: String = errors
        .chars()
        .rev()
        .take(3000)
        .collect::<Vec<_>>()
        .into_iter()
        .rev()
        .collect();
    assert!(
        output.status.success(),
        "input {last}: {}\n{tail}",
        output.status
    );
    assert!(
        text.contains("mutated inputs"),
        "the child did nothing:\n{text}"
    );
}

/// Negative control: a panic, a hang, a runaway allocation and a deep recursion are each noticed.
#[test]
fn misbehaviour_is_noticed() {
    for fault in ["panic", "allocate", "recurse", "hang"] {
        let (output, last) = run_child(3, 7, fault);
        assert!(!output.status.success(), "{fault} went unnoticed");
        assert_eq!(last, 7, "{fault}: the offender is named");
    }
}

fn misbehave(fault: &str) {
    fn recurse(n: u64) -> u64 {
        if n == u64::MAX {
            0
        } else {
            std::hint::black_box(recurse(std::hint::black_box(n + 1)) + 1)
        }
    }
    match fault {
        "panic" => panic!("on purpose"),
        "allocate" => drop(std::hint::black_box(vec![1u8; 2 << 30])),
        "recurse" => drop(std::hint::black_box(recurse(0))),
        "hang" => std::thread::sleep(PATIENCE * 10),
        _ => {}
    }
}

/// The work itself, in the child; nothing anywhere else.
#[test]
fn child() {
    let Some(at) = std::env::var_os("INVERTEX_MUTATION_AT") else {
        return;
    };
    let at = std::fs::File::options().write(true).open(at).unwrap();
    let fault = std::env::var("INVERTEX_MUTATION_FAULT").unwrap_or_default();
    let (count, first) = (
        number("INVERTEX_MUTATIONS", 0),
        number("INVERTEX_MUTATION_FIRST", 0),
    );
    let started = Arc::new(AtomicU64::new(0));
    let clock = Instant::now();
    watch(
        Arc::clone(&started),
        clock,
        if fault == "hang" {
            Duration::from_secs(1)
        } else {
            PATIENCE
        },
    );
    let seeds = make::seeds();
    let (mut good, mut slowest) = (0u64, (Duration::ZERO, 0));
    for i in first..first + count {
        at.write_all_at(&i.to_le_bytes(), 0).unwrap();
        started.store(clock.elapsed().as_millis() as u64, Ordering::Relaxed);
        let begin = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| {
            misbehave(&fault);
            readers::read(&seeds, i)
        }));
        match result {
            Ok(read) => good += u64::from(read),
            Err(_) => exit(1),
        }
        slowest = slowest.max((begin.elapsed(), i));
    }
    println!(
        "{count} mutated inputs in {:.1} s: {good} read, {} refused; slowest {:?} (input {}); {}",
        clock.elapsed().as_secs_f64(),
        count - good,
        slowest.0,
        slowest.1,
        peaks()
    );
    assert!(
        good > 0 || count < 100,
        "every input was refused: the mutations are too coarse to mean anything"
    );
}

/// Ends the process when one input takes longer than `patience`.
fn watch(started: Arc<AtomicU64>, clock: Instant, patience: Duration) {
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_millis(200));
            let since = Duration::from_millis(started.load(Ordering::Relaxed));
            if clock.elapsed().saturating_sub(since) > patience {
                eprintln!("hang: one input takes longer than {patience:?}");
                exit(2);
            }
        }
    });
}

/// Peak memory as the system counts it.
fn peaks() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let lines = status
        .lines()
        .filter(|line| line.starts_with("VmHWM") || line.starts_with("VmPeak"));
    lines
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect::<Vec<_>>()
        .join(", ")
}
