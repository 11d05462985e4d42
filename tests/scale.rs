//! Tables larger than a device's storage buffers: built in portions, asked in pages; the bytes and the answers are the same.
//!
//! Small ones always, as if storage buffers held a few hundred bytes; with `INVERTEX_LONG=1` twenty million triangles on a
//! device whose storage buffers stop at 128 MiB.
#![cfg(feature = "gpu")]

mod long;

use invertex::Error;
use invertex::gpu::{Context, ContextOptions, DeviceChoice, devices};
use invertex::igt::{self, Asking, BuildOptions, Layout, Needs, Reference, Tables, build_cpu};
use invertex::mesh::{Mesh, shapes};
use invertex::param::{Axis, Primary, PrimaryKind};

fn contexts() -> Vec<Context> {
    let all = devices().expect("a Vulkan loader");
    let usable = all.iter().filter(|d| d.usable);
    let open = |index| {
        Context::new(&ContextOptions {
            device: DeviceChoice::Index(index),
            validation: true,
        })
    };
    let contexts: Vec<Context> = usable.map(|d| open(d.index).unwrap()).collect();
    assert!(!contexts.is_empty(), "these tests need a Vulkan device");
    contexts
}

/// A reference with holes and two layers, and a LoD that asks from all over it.
fn case(mesh: &Mesh, kind: PrimaryKind, layout: Layout, hash: u32) -> (Reference, Needs) {
    let mut holes = mesh.clone();
    holes.triangles = mesh.triangles.iter().skip(1).step_by(2).copied().collect();
    holes.triangle_material = vec![0; holes.triangles.len()];
    let primary = Primary::centred(kind, &holes).unwrap();
    let layer: Vec<u8> = (0..holes.triangles.len())
        .map(|t| (t % 7 == 0) as u8)
        .collect();
    let reference = Reference::new(&holes, &primary, &layer, layout).unwrap();
    let t3: Vec<_> = (0..mesh.positions.len())
        .map(|v| primary.to_grid(primary.t3_of(mesh, v)))
        .collect();
    let asking = Asking {
        t3: &t3,
        triangles: &mesh.triangles,
        layer: &vec![0; mesh.triangles.len()],
    };
    let needs = Needs::of(&reference, &[asking], hash.trailing_zeros());
    (reference, needs)
}

fn cases() -> Vec<(Mesh, PrimaryKind)> {
    vec![
        (shapes::grid(24), PrimaryKind::UvSet(0)),
        (shapes::tube(40, 9), PrimaryKind::Cylinder(Axis::Z)),
        (shapes::icosphere(3), PrimaryKind::Sphere),
    ]
}

/// Points of the query grid all over the domain.
fn points(count: usize, reach: i32) -> Vec<[i32; 3]> {
    let mut state = 99u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % (2 * reach as u64)) as i32 - reach
    };
    (0..count).map(|_| [random(), random(), random()]).collect()
}

#[test]
fn portions_give_the_bytes_of_the_whole() {
    for context in contexts() {
        for (mesh, kind) in cases() {
            for layout in [Layout::Packed, Layout::Classic] {
                let (reference, needs) = case(&mesh, kind, layout, 64);
                let options = BuildOptions { hash: 64, layout };
                let whole = build_cpu(&reference, &needs, options).unwrap();
                for portion in [1, 100, 333, reference.triangles.len()] {
                    // One at a time only where that is quick.
                    if portion == 1 && reference.triangles.len() > 400 {
                        continue;
                    }
                    let built =
                        igt::gpu::build_in_portions(&context, &reference, &needs, options, portion)
                            .unwrap();
                    assert!(built.tables == whole, "{kind} {layout:?} by {portion}");
                }
            }
        }
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
}

/// log2 of the smallest page with which the largest table takes no more than `pages`.
fn page_bits(tables: &Tables, pages: u64) -> u32 {
    let most = tables.bytes().into_iter().max().unwrap();
    (8..32).find(|bits| most <= pages << bits).unwrap()
}

#[test]
fn pages_give_the_answers_of_whole_tables() {
    let points = points(600, 1 << 29);
    for context in contexts() {
        for (mesh, kind) in cases() {
            for layout in [Layout::Packed, Layout::Classic] {
                let (reference, needs) = case(&mesh, kind, layout, 64);
                let options = BuildOptions { hash: 64, layout };
                let tables = build_cpu(&reference, &needs, options).unwrap();
                for pages in 1..=4 {
                    let bits = page_bits(&tables, pages);
                    let found =
                        igt::gpu::query_in_pages(&context, &tables, &points, None, true, bits)
                            .unwrap();
                    for (point, found) in points.iter().zip(found) {
                        let own = tables.lookup_with_cost(*point, None, true);
                        assert_eq!(own, found, "{kind} {layout:?} {pages} pages, {point:?}");
                    }
                }
                let short = page_bits(&tables, 4) - 1;
                let refused =
                    igt::gpu::query_in_pages(&context, &tables, &points, None, true, short);
                assert!(matches!(refused, Err(Error::Capacity { .. })), "{kind}");
            }
        }
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
}

/// Bytes of memory that the process held at most so far; 0 where the system does not say.
fn peak_bytes() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kib = line.and_then(|l| l.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
    kib.unwrap_or(0) << 10
}

/// A sheet whose inner uv are moved: no two triangles alike.
fn sheet(triangles: usize) -> Mesh {
    let n = ((triangles / 2) as f64).sqrt().ceil() as u32;
    let mut mesh = shapes::grid(n);
    let mut state = 5u64;
    for uv in mesh.uv_sets[0].iter_mut().flatten() {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        if *uv > 0.0 && *uv < 1.0 {
            *uv += ((state >> 40) as f32 / (1 << 24) as f32 - 0.5) * 0.4 / n as f32;
        }
    }
    mesh
}

/// Twenty million triangles: built and asked on the processor and on every device with storage buffers of 128 MiB, the same
/// bytes and answers, in less than 12 GiB for all of it.
#[test]
fn twenty_million_triangles() {
    let wanted = long::count("INVERTEX_SCALE_TRIANGLES", 0, 20_000_000) as usize;
    if wanted == 0 {
        eprintln!("SHORT: twenty million triangles are built with INVERTEX_LONG=1");
        return;
    }
    let hash = invertex::asset::hash_for(wanted);
    let options = BuildOptions {
        hash,
        layout: Layout::Packed,
    };
    let reference = {
        let mesh = sheet(wanted);
        let primary = Primary::centred(PrimaryKind::UvSet(0), &mesh).unwrap();
        let layer = vec![0; mesh.triangles.len()];
        Reference::new(&mesh, &primary, &layer, options.layout).unwrap()
    };
    assert!(reference.triangles.len() >= wanted);
    let before = peak_bytes();
    let needs = Needs::default();
    let start = std::time::Instant::now();
    let tables = build_cpu(&reference, &needs, options).unwrap();
    let on_cpu = start.elapsed().as_secs_f64();
    tables.validate(reference.triangles.len()).unwrap();
    let of_cpu = peak_bytes();
    // The domain has a margin of three in a hundred around the sheet.
    let points = points(1 << 18, (1 << 29) / 100 * 96);
    let answers: Vec<_> = points
        .iter()
        .map(|q| tables.lookup_with_cost(*q, Some(0), false))
        .collect();
    assert!(answers.iter().all(|(found, _)| found.is_some()));
    let (bytes, sha256) = (tables.bytes(), tables.sha256());
    for context in contexts() {
        let info = context.info();
        if info.limits.storage_buffer_bytes > 128 << 20 {
            continue;
        }
        let start = std::time::Instant::now();
        let built = igt::gpu::build(&context, &reference, &needs, options).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        assert_eq!(built.tables.sha256(), sha256, "{}", info.name);
        let asked = igt::gpu::query(&context, &built.tables, &points, Some(0), false).unwrap();
        assert!(asked == answers, "{}: other answers", info.name);
        let numbers = format!("{hash} texels, {seconds:.1} s, bytes and answers of the processor");
        long::proved("20 M triangles", &info.name, &numbers);
    }
    let peak = peak_bytes();
    let gib = |bytes: u64| bytes as f64 / (1u64 << 30) as f64;
    long::proved(
        "20 M triangles",
        "processor",
        &format!(
            "{on_cpu:.1} s, tables {:?} MiB, peak {:.2} GiB (the mesh alone {:.2}), with devices {:.2}",
            bytes.map(|b| b >> 20),
            gib(of_cpu),
            gib(before),
            gib(peak)
        ),
    );
    assert!(peak < 12 << 30, "{peak}");
}
