//! The tables of the CPU and of every device are equal byte for byte, and so is every answer.
//!
//! Made shapes always; with `INVERTEX_LONG=1` every mesh of every shared model, sizes 64 to 1024.
#![cfg(feature = "gpu")]

mod long;
mod render;

use invertex::Error;
use invertex::gpu::{Context, ContextOptions, DeviceChoice, devices};
use invertex::igt::{self, Asking, BuildOptions, Layout, Needs, Reference, build_cpu};
use invertex::mesh::{Mesh, shapes};
use invertex::param::{Axis, Primary, PrimaryKind};
use invertex::scene::Scene;

fn contexts() -> Vec<Context> {
    let all = devices().expect("a Vulkan loader");
    let usable: Vec<_> = all.iter().filter(|d| d.usable).collect();
    assert!(
        !usable.is_empty(),
        "these tests need a Vulkan device; tools/setup installs one"
    );
    usable
        .iter()
        .map(|d| {
            Context::new(&ContextOptions {
                device: DeviceChoice::Index(d.index),
                validation: true,
            })
            .unwrap()
        })
        .collect()
}

fn cases() -> Vec<(Mesh, PrimaryKind)> {
    vec![
        (shapes::grid(20), PrimaryKind::UvSet(0)),
        (shapes::grid(3), PrimaryKind::Plane(Axis::Z)),
        (shapes::tube(50, 9), PrimaryKind::Cylinder(Axis::Z)),
        (shapes::uv_sphere(24, 12), PrimaryKind::Cylinder(Axis::Y)),
        (shapes::octahedron(), PrimaryKind::Sphere),
        (shapes::tetrahedron(), PrimaryKind::Sphere),
        (shapes::icosphere(4), PrimaryKind::Sphere),
        // Everything in a few texels: lists too long for one invocation to sort.
        (crowded(), PrimaryKind::UvSet(0)),
        (shapes::uv_sphere(60, 40), PrimaryKind::Sphere),
    ]
}

/// 9800 triangles in a hundredth of the domain's width, beside one that spans it.
fn crowded() -> Mesh {
    let mut mesh = shapes::grid(70);
    for uv in &mut mesh.uv_sets[0] {
        *uv = [uv[0] * 0.01, uv[1] * 0.01];
    }
    mesh.uv_sets[0][0] = [1.0, 1.0];
    mesh
}

/// A mesh that asks from outside: the reference without every third triangle stands in for a reference with holes.
fn with_holes(mesh: &Mesh) -> Mesh {
    let mut holes = mesh.clone();
    let kept = |i: usize| i % 3 != 1;
    holes.triangles = mesh
        .triangles
        .iter()
        .enumerate()
        .filter(|(i, _)| kept(*i))
        .map(|(_, t)| *t)
        .collect();
    holes.triangle_material = vec![0; holes.triangles.len()];
    holes
}

#[test]
fn every_device_builds_the_bytes_of_the_cpu() {
    for context in contexts() {
        for (whole, kind) in cases() {
            let mesh = with_holes(&whole);
            let primary = Primary::centred(kind, &mesh).unwrap();
            let layer: Vec<u8> = (0..mesh.triangles.len())
                .map(|i| (i % 5 == 0) as u8)
                .collect();
            for (layout, hash) in [
                (Layout::Packed, 64),
                (Layout::Classic, 64),
                (Layout::Packed, 4),
                (Layout::Packed, 128),
            ] {
                let reference = Reference::new(&mesh, &primary, &layer, layout).unwrap();
                let asking: Vec<u8> = (0..whole.triangles.len()).map(|i| (i % 2) as u8).collect();
                let t3: Vec<_> = (0..whole.positions.len())
                    .map(|v| primary.to_grid(primary.t3_of(&whole, v)))
                    .collect();
                let lods = [Asking {
                    t3: &t3,
                    triangles: &whole.triangles,
                    layer: &asking,
                }];
                let options = BuildOptions { hash, layout };
                let needs = Needs::of(&reference, &lods, options.bits().unwrap());
                let cpu = build_cpu(&reference, &needs, options).unwrap();
                let device = igt::gpu::build(&context, &reference, &needs, options)
                    .unwrap()
                    .tables;
                let what = format!(
                    "{} {kind} {layout:?} {hash} on {}",
                    mesh.name,
                    context.info().name
                );
                assert_eq!(cpu.stats, device.stats, "{what}");
                assert!(cpu == device, "{what}: tables differ");
                assert_eq!(cpu.sha256(), device.sha256(), "{what}");
                cpu.validate(mesh.triangles.len()).unwrap();
                same_answers(&context, &cpu, &what);
            }
        }
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
}

fn same_answers(context: &Context, tables: &igt::Tables, what: &str) {
    let mut state = 12345u64;
    let mut next = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (((state >> 33) as u32) as i32) >> 1
    };
    let mut points: Vec<[i32; 3]> = (0..500)
        .map(|_| [next() >> 1, next() >> 1, next() >> 1])
        .collect();
    points.extend([
        [0, 0, 0],
        [0, 0, 5],
        [1, 0, 0],
        [0, -1, 0],
        [-(1 << 28), 0, 0],
        [1 << 28, 1 << 28, 0],
    ]);
    for (layer, nearest) in [(None, false), (Some(1), true), (Some(7), true)] {
        let device = igt::gpu::query(context, tables, &points, layer, nearest).unwrap();
        for (q, answer) in points.iter().zip(&device) {
            assert_eq!(
                tables.lookup_with_cost(*q, layer, nearest),
                *answer,
                "{what}: {q:?} layer {layer:?}"
            );
        }
    }
}

/// Every mesh of a model, with the LoDs' needs, in each size and layout. A device may refuse the dragon's largest tables,
/// which want more bytes in one buffer than software devices bind (128 MiB); the row says how often one did.
fn same_on_every_device(name: &str, scene: Scene, sizes: &[u32]) {
    let prepared = render::model::prepare(scene, &long::primary(name), &[0.2, 0.1, 0.05]);
    let contexts = contexts();
    let (mut meshes, mut tables, mut kinds, mut refused) = (0, 0, Vec::new(), 0);
    for (mesh, built) in prepared.scene.meshes.iter().zip(&prepared.meshes) {
        let Some((primary, parts, chain)) = built else {
            assert!(
                mesh.triangles.is_empty(),
                "{name}: {} has no primary",
                mesh.name
            );
            continue;
        };
        meshes += 1;
        kinds.push(primary.kind.to_string());
        for layout in [Layout::Packed, Layout::Classic] {
            let reference = Reference::new(mesh, primary, &parts.triangle_layer, layout).unwrap();
            let asking: Vec<Asking> = chain.iter().map(render::inverse::asking).collect();
            for &hash in sizes {
                let options = BuildOptions { hash, layout };
                let needs = Needs::of(&reference, &asking, options.bits().unwrap());
                let cpu = build_cpu(&reference, &needs, options).unwrap();
                for context in &contexts {
                    let on = &context.info().name;
                    let what = format!("{} {layout:?} {hash} on {on}", mesh.name);
                    let built = igt::gpu::build(context, &reference, &needs, options);
                    if let (Err(Error::Capacity { what, need, have }), "dragon") = (&built, name) {
                        refused += 1;
                        println!("{layout:?} {hash} on {on}: {what}: {need} of {have}");
                        continue;
                    }
                    assert_eq!(
                        cpu.sha256(),
                        built.unwrap().tables.sha256(),
                        "{name}: {what}"
                    );
                    same_answers(context, &cpu, &what);
                }
                tables += 1;
            }
        }
    }
    for context in &contexts {
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
    kinds.sort();
    kinds.dedup();
    let devices: Vec<&str> = contexts.iter().map(|c| c.info().name.as_str()).collect();
    long::proved(
        name,
        "same sha256 of tables",
        &format!(
            "{meshes} meshes by {}; {tables} tables, hash {sizes:?}, both layouts; cpu = {}{}",
            kinds.join(" "),
            devices.join(" = "),
            match refused {
                0 => String::new(),
                n => format!("; {n} builds refused: over the device's buffer limit"),
            }
        ),
    );
}

#[test]
fn a_shared_model_at_two_sizes() {
    if let Some(path) = render::model::path("fox/fox.glb") {
        same_on_every_device("fox, short", Scene::load(&path).unwrap(), &[64, 256]);
    }
}

fn at_length(name: &str) {
    if let Some(path) = long::model(name) {
        let sizes = [64, 128, 256, 512, 1024];
        same_on_every_device(name, Scene::load(&path).unwrap(), &sizes);
    }
}

mod every_size_and_layout {
    super::long::on_every_model!(super::at_length);
}

#[test]
fn a_changed_word_changes_the_sum() {
    // Negative control of the comparisons above.
    let mesh = shapes::grid(4);
    let primary = Primary::centred(PrimaryKind::UvSet(0), &mesh).unwrap();
    let reference = Reference::new(&mesh, &primary, &[0; 32], Layout::Packed).unwrap();
    let tables = build_cpu(
        &reference,
        &Needs::default(),
        BuildOptions {
            hash: 8,
            layout: Layout::Packed,
        },
    )
    .unwrap();
    for part in 0..3 {
        let mut other = tables.clone();
        [&mut other.hash, &mut other.list, &mut other.triangle][part][0] ^= 1;
        assert_ne!(other.sha256(), tables.sha256());
    }
}
