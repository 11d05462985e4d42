//! Embedding: an engine with its own instance, device and allocator hands them over, uploads tables through this crate,
//! and records the lookup into its own command buffer, under its own pipeline layout, with its own shader that includes
//! `igt.glsl`. The answers equal the CPU's to the bit. Two such engines live in one process.
#![cfg(feature = "gpu")]
#![allow(unsafe_code, reason = "an engine speaks Vulkan")]

mod devices;
mod plain;

use invertex::gpu::gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use invertex::gpu::shaders::test_embed_lookup::{Bindings, Push, Shader};
use invertex::gpu::shaders::types::EmbedAnswer;
use invertex::gpu::{Buffer, Context, Recorder, ShaderInterface, vk};
use invertex::igt::{BuildOptions, Layout, Needs, Reference, Tables, build_cpu, layout};
use invertex::mesh::{Mesh, shapes};
use invertex::param::grid::vertex_to_query;
use invertex::param::{Axis, Primary, PrimaryKind};
use plain::{EnginePass, Plain};
use std::sync::{Arc, Mutex};

/// Tables to ask, and the points asked for: vertices, edge midpoints, and a scatter over the whole grid.
struct Case {
    tables: Tables,
    points: Vec<[i32; 4]>,
}

fn case(mesh: &Mesh, kind: PrimaryKind, layout: Layout) -> Case {
    let primary = Primary::centred(kind, mesh).unwrap();
    let reference = Reference::new(mesh, &primary, &vec![0; mesh.triangles.len()], layout).unwrap();
    let options = BuildOptions { hash: 32, layout };
    let tables = build_cpu(&reference, &Needs::default(), options).unwrap();
    let on_vertices = reference.t3.iter().map(|v| vertex_to_query(*v));
    let on_edges = reference.triangles.iter().map(|t| {
        let [a, b] = [t[0], t[1]].map(|v| vertex_to_query(reference.t3[v as usize]));
        [0, 1, 2].map(|axis| (a[axis] + b[axis]) / 2)
    });
    let mut state = 1_u64;
    let mut scatter = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 34) as i32 - (1 << 29)
    };
    let scattered = (0..3000).map(|_| {
        [
            scatter(),
            scatter(),
            if layout::is_flat(&primary) {
                0
            } else {
                scatter()
            },
        ]
    });
    let inside = |q: [i32; 3]| q.map(|x| x.clamp(1 - (1 << 29), (1 << 29) - 1));
    let points = on_vertices
        .chain(on_edges)
        .chain(scattered)
        .map(inside)
        .map(|[x, y, z]| [x, y, z, 0])
        .collect();
    Case { tables, points }
}

fn cases() -> Vec<Case> {
    [Layout::Packed, Layout::Classic]
        .into_iter()
        .flat_map(|layout| {
            [
                case(&shapes::grid(9), PrimaryKind::UvSet(0), layout),
                case(&shapes::icosphere(3), PrimaryKind::Sphere, layout),
                case(&shapes::tube(13, 5), PrimaryKind::Cylinder(Axis::Z), layout),
            ]
        })
        .collect()
}

impl Case {
    fn push(&self) -> Push {
        let [line, how, bits, entries, at, size] = self.tables.shader_words();
        Push {
            tables: [line, how, bits, entries],
            window: [at, size],
            count: self.points.len() as u32,
            nearest: 1,
        }
    }

    fn groups(&self) -> u32 {
        (self.points.len() as u32).div_ceil(Shader::WORKGROUP[0])
    }

    fn upload(&self, ctx: &Context) -> Uploaded {
        let answer_bytes = (self.points.len() * size_of::<EmbedAnswer>()) as u64;
        Uploaded {
            points: ctx.upload("points", &self.points).unwrap(),
            hash: ctx.upload("hash", &self.tables.hash).unwrap(),
            list: ctx.upload("list", &self.tables.list).unwrap(),
            triangles: ctx.upload("triangles", &self.tables.triangle).unwrap(),
            answers: ctx.storage("answers", answer_bytes).unwrap(),
        }
    }

    /// The first point whose answer is not the CPU's.
    fn first_difference(&self, answers: &[EmbedAnswer]) -> Option<usize> {
        assert_eq!(answers.len(), self.points.len());
        (0..answers.len()).find(|i| {
            let [x, y, z, layer] = self.points[*i];
            let (answer, query) = (&answers[*i], [x, y, z]);
            match self.tables.lookup(query, Some(layer as u8), true) {
                Some(found) => {
                    (answer.triangle, answer.fetches, answer.hit == 1)
                        != (found.triangle, found.fetches, found.hit)
                        || answer.barycentric.map(f32::to_bits)
                            != found.barycentric.map(f32::to_bits)
                }
                None => answer.triangle != u32::MAX || answer.hit != 0,
            }
        })
    }
}

struct Uploaded {
    points: Buffer,
    hash: Buffer,
    list: Buffer,
    triangles: Buffer,
    answers: Buffer,
}

impl Uploaded {
    fn bindings(&self) -> Bindings<'_> {
        let Uploaded {
            points,
            hash,
            list,
            triangles,
            answers,
        } = self;
        Bindings {
            points,
            hash,
            list,
            triangles,
            answers,
        }
    }

    /// The handle for a slot of the engine's shader.
    fn buffer(&self, name: &str) -> &Buffer {
        match name {
            "points" => &self.points,
            "hash" => &self.hash,
            "list" => &self.list,
            "triangles" => &self.triangles,
            "answers" => &self.answers,
            other => panic!("the engine's shader has no {other}"),
        }
    }
}

/// The engine records everything itself; this crate gave the tables' buffers.
fn by_the_engine(
    engine: &Plain,
    pass: &EnginePass<'_>,
    ctx: &Context,
    case: &Case,
) -> Vec<EmbedAnswer> {
    let uploaded = case.upload(ctx);
    let buffers: Vec<(u32, vk::Buffer)> = Shader::SLOTS
        .iter()
        .map(|slot| (slot.binding, uploaded.buffer(slot.name).handle()))
        .collect();
    pass.bind(&buffers);
    engine
        .submit(|commands| pass.record(commands, bytemuck::bytes_of(&case.push()), case.groups()));
    ctx.download(&uploaded.answers).unwrap()
}

/// The engine begins, submits and waits; this crate records the pass in between.
fn by_the_recorder(engine: &Plain, ctx: &Context, case: &Case) -> Vec<EmbedAnswer> {
    let uploaded = case.upload(ctx);
    let bound = ctx
        .compute::<Shader>()
        .unwrap()
        .bind(&uploaded.bindings())
        .unwrap();
    let mut in_use = None;
    engine.submit(|commands| {
        // SAFETY: the engine is recording on the family it declared, outside a render pass.
        let mut recorder = unsafe { Recorder::foreign(ctx, commands) };
        recorder.dispatch(&bound, &case.push(), [case.groups(), 1, 1]);
        in_use = Some(recorder.finish().unwrap());
    });
    // The engine has waited.
    drop(in_use);
    ctx.download(&uploaded.answers).unwrap()
}

/// An allocator of the engine's, to share.
fn allocator(engine: &Plain) -> Arc<Mutex<Allocator>> {
    let allocator = Allocator::new(&AllocatorCreateDesc {
        instance: engine.instance.clone(),
        device: engine.device.clone(),
        physical_device: engine.physical_device,
        debug_settings: Default::default(),
        buffer_device_address: false,
        allocation_sizes: Default::default(),
    });
    Arc::new(Mutex::new(allocator.unwrap()))
}

#[test]
fn an_engine_asks_the_tables_in_its_own_command_buffer() {
    let cases = cases();
    for index in 0..devices::usable().len() {
        // Two engines at once, the second with an allocator that it shares.
        let engines = [Plain::new(index), Plain::new(index)];
        let shared = allocator(&engines[1]);
        let mut foreign = [engines[0].foreign(), engines[1].foreign()];
        foreign[1].allocator = Some(shared.clone());
        // SAFETY: the handles belong together; the contexts go before the engines' devices (declared later).
        let contexts = foreign.map(|foreign| unsafe { Context::from_foreign(foreign) }.unwrap());
        for (engine, ctx) in engines.iter().zip(&contexts) {
            let bindings: Vec<u32> = Shader::SLOTS.iter().map(|slot| slot.binding).collect();
            let pass = EnginePass::new(
                engine,
                Shader::STAGES[0].spirv,
                &bindings,
                size_of::<Push>() as u32,
            );
            for case in &cases {
                let place = format!(
                    "{:?} {:?} on {}",
                    case.tables.primary.kind,
                    case.tables.layout,
                    ctx.info().name
                );
                let answers = by_the_engine(engine, &pass, ctx, case);
                assert_eq!(case.first_difference(&answers), None, "{place}");
                assert!(
                    answers.iter().any(|answer| answer.hit == 1),
                    "nothing was hit: {place}"
                );
                assert_eq!(by_the_recorder(engine, ctx, case), answers, "{place}");
                let mut wrong = answers;
                wrong[7].barycentric[1] = f32::from_bits(wrong[7].barycentric[1].to_bits() ^ 1);
                assert_eq!(
                    case.first_difference(&wrong),
                    Some(7),
                    "one bit must be seen: {place}"
                );
            }
        }
        assert!(
            shared
                .lock()
                .unwrap()
                .generate_report()
                .allocations
                .is_empty(),
            "the shared allocator is empty again"
        );
        // The crate destroys nothing of the engine's: it still works when the contexts are gone.
        drop(contexts);
        for engine in &engines {
            engine.submit(|_| ());
        }
    }
}
