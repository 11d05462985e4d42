//! Buffers and compute passes on every device: contents survive, sizes around a workgroup work, passes see each other's
//! results, timings make sense.
#![cfg(feature = "gpu")]

mod devices;

use devices::{context, on_every_device, usable};
use invertex::gpu::shaders::test_add::{Bindings, Push, SCALE, Shader};
use invertex::gpu::{Buffer, Context, ShaderInterface};

/// Sizes around the workgroup of 64, around a power of two, and one of many workgroups.
const SIZES: [usize; 10] = [0, 1, 2, 63, 64, 65, 127, 1023, 1025, 100_003];

fn words(count: usize, seed: u32) -> Vec<u32> {
    (0..count as u32)
        .map(|i| i.wrapping_mul(2_654_435_761).wrapping_add(seed))
        .collect()
}

fn groups(count: usize) -> [u32; 3] {
    [(count as u32).div_ceil(Shader::WORKGROUP[0]), 1, 1]
}

fn add(ctx: &Context, a: &Buffer, b: &Buffer, count: usize, offset: u32, scale: u32) -> Vec<u32> {
    let sum = ctx.storage("sum", 4 * count as u64).unwrap();
    let pipeline = ctx.compute_with::<Shader>(&[(SCALE, scale)]).unwrap();
    let bound = pipeline.bind(&Bindings { a, b, sum: &sum }).unwrap();
    let mut recorder = ctx.recorder("add").unwrap();
    recorder.dispatch(
        &bound,
        &Push {
            count: count as u32,
            offset,
        },
        groups(count),
    );
    ctx.run(recorder).unwrap();
    ctx.download(&sum).unwrap()
}

#[test]
fn contents_survive_the_round_trip() {
    on_every_device(|ctx| {
        for size in SIZES {
            let data = words(size, 7);
            let buffer = ctx.upload("words", &data).unwrap();
            assert_eq!(buffer.bytes(), 4 * size as u64);
            assert_eq!(
                ctx.download::<u32>(&buffer).unwrap(),
                data,
                "{size} words on {}",
                ctx.info().name
            );
            // Bytes that are no whole number of words.
            let bytes: Vec<u8> = data.iter().map(|word| *word as u8).collect();
            let buffer = ctx.upload("bytes", &bytes).unwrap();
            assert_eq!(
                ctx.download::<u8>(&buffer).unwrap(),
                bytes,
                "{size} bytes on {}",
                ctx.info().name
            );
        }
    });
}

#[test]
fn parts_of_a_large_upload_meet() {
    on_every_device(|ctx| {
        // More than one staging buffer of 64 MiB, not a whole number of them.
        let data = words((80 << 20) / 4 + 3, 1);
        let buffer = ctx.upload("large", &data).unwrap();
        assert!(
            ctx.download::<u32>(&buffer).unwrap() == data,
            "on {}",
            ctx.info().name
        );
    });
}

#[test]
fn sums_at_sizes_around_a_workgroup() {
    on_every_device(|ctx| {
        for size in SIZES {
            let (a, b) = (words(size, 1), words(size, 99));
            let (on_a, on_b) = (ctx.upload("a", &a).unwrap(), ctx.upload("b", &b).unwrap());
            for scale in [1, 3] {
                let sum = add(ctx, &on_a, &on_b, size, 5, scale);
                let expected: Vec<u32> = a
                    .iter()
                    .zip(&b)
                    .map(|(a, b)| a.wrapping_add(*b).wrapping_mul(scale).wrapping_add(5))
                    .collect();
                assert!(
                    sum == expected,
                    "{size} words, scale {scale}, on {}",
                    ctx.info().name
                );
                if size > 0 {
                    let other = add(ctx, &on_a, &on_b, size, 6, scale);
                    assert!(other != expected, "another offset must give another sum");
                }
            }
        }
    });
}

#[test]
fn a_pass_sees_what_the_one_before_wrote() {
    on_every_device(|ctx| {
        const COUNT: usize = 1000;
        const ROUNDS: u32 = 300;
        let one = ctx.upload("one", &[1_u32; COUNT]).unwrap();
        let (x, y) = (
            ctx.upload("x", &[0_u32; COUNT]).unwrap(),
            ctx.upload("y", &[0_u32; COUNT]).unwrap(),
        );
        let pipeline = ctx.compute::<Shader>().unwrap();
        let there = pipeline
            .bind(&Bindings {
                a: &x,
                b: &one,
                sum: &y,
            })
            .unwrap();
        let back = pipeline
            .bind(&Bindings {
                a: &y,
                b: &one,
                sum: &x,
            })
            .unwrap();
        let mut recorder = ctx.recorder("there and back").unwrap();
        let push = Push {
            count: COUNT as u32,
            offset: 0,
        };
        for _ in 0..ROUNDS {
            recorder.dispatch(&there, &push, groups(COUNT));
            recorder.dispatch(&back, &push, groups(COUNT));
        }
        // The recorder keeps what it uses.
        drop((there, back, y, one));
        let timings = ctx.run(recorder).unwrap();
        assert_eq!(ctx.download::<u32>(&x).unwrap(), [2 * ROUNDS; COUNT]);
        // More passes than a query pool holds: each is timed, and the parts make the whole.
        assert_eq!(timings.passes.len(), 2 * ROUNDS as usize);
        assert!(timings.passes.iter().all(|pass| pass.name == "test_add"));
        let parts: u64 = timings.passes.iter().map(|pass| pass.nanoseconds).sum();
        assert!(
            parts > 0 && parts.abs_diff(timings.total) <= 2 * timings.passes.len() as u64,
            "{parts} {}",
            timings.total
        );
    });
}

#[test]
fn more_work_takes_longer() {
    on_every_device(|ctx| {
        let time = |count: usize| {
            let buffer = ctx.upload("words", &words(count, 3)).unwrap();
            let sum = ctx.storage("sum", buffer.bytes()).unwrap();
            let bound = ctx
                .compute::<Shader>()
                .unwrap()
                .bind(&Bindings {
                    a: &buffer,
                    b: &buffer,
                    sum: &sum,
                })
                .unwrap();
            let mut recorder = ctx.recorder("time").unwrap();
            for _ in 0..4 {
                recorder.dispatch(
                    &bound,
                    &Push {
                        count: count as u32,
                        offset: 0,
                    },
                    groups(count),
                );
            }
            // The first pass compiles on some drivers.
            let timings = ctx.run(recorder).unwrap();
            timings.passes[1..]
                .iter()
                .map(|pass| pass.nanoseconds)
                .min()
                .unwrap()
        };
        let (small, large) = (time(64), time(64 * 60_000));
        assert!(
            small < large,
            "{small} ns for 64 words, {large} ns for 3.8 million, on {}",
            ctx.info().name
        );
    });
}

#[test]
fn indirect_counts_fills_and_copies() {
    on_every_device(|ctx| {
        const COUNT: usize = 130;
        let a = ctx.storage("a", 4 * COUNT as u64).unwrap();
        let b = ctx.upload("b", &words(COUNT, 2)).unwrap();
        let (sum, copy) = (
            ctx.storage("sum", 4 * COUNT as u64).unwrap(),
            ctx.storage("copy", 4 * 100).unwrap(),
        );
        let counts = ctx.upload("counts", &[9_u32, 2, 1, 1]).unwrap();
        let bound = ctx
            .compute::<Shader>()
            .unwrap()
            .bind(&Bindings {
                a: &a,
                b: &b,
                sum: &sum,
            })
            .unwrap();
        let mut recorder = ctx.recorder("indirect").unwrap();
        recorder.fill(&a, 40);
        recorder.fill(&sum, 77);
        recorder.dispatch_indirect(
            &bound,
            &Push {
                count: COUNT as u32,
                offset: 2,
            },
            &counts,
            4,
        );
        recorder.copy(&sum, &copy);
        ctx.run(recorder).unwrap();
        let expected: Vec<u32> = words(COUNT, 2).iter().map(|b| b.wrapping_add(42)).collect();
        let mut two_groups = expected[..128].to_vec();
        two_groups.extend([77, 77]);
        assert_eq!(
            ctx.download::<u32>(&sum).unwrap(),
            two_groups,
            "two workgroups reach 128 words"
        );
        assert_eq!(ctx.download::<u32>(&copy).unwrap(), expected[..100]);
    });
}

#[test]
fn many_sets_outgrow_the_first_pool() {
    on_every_device(|ctx| {
        let buffer = ctx.upload("words", &words(64, 5)).unwrap();
        let pipeline = ctx.compute::<Shader>().unwrap();
        let sets: Vec<_> = (0..500)
            .map(|_| {
                pipeline
                    .bind(&Bindings {
                        a: &buffer,
                        b: &buffer,
                        sum: &buffer,
                    })
                    .unwrap()
            })
            .collect();
        assert_eq!(sets.len(), 500);
    });
}

#[test]
fn contexts_on_many_threads() {
    let devices = usable();
    std::thread::scope(|scope| {
        for thread in 0..4_usize {
            let device = &devices[thread % devices.len()];
            scope.spawn(move || {
                let ctx = context(device);
                // Two threads within the context, too.
                std::thread::scope(|inner| {
                    for seed in 0..2 {
                        let ctx = &ctx;
                        inner.spawn(move || {
                            for size in [65, 4097] {
                                let a = words(size, seed);
                                let buffer = ctx.upload("a", &a).unwrap();
                                let doubled: Vec<u32> = a
                                    .iter()
                                    .map(|a| a.wrapping_mul(2).wrapping_add(1))
                                    .collect();
                                assert_eq!(add(ctx, &buffer, &buffer, size, 1, 1), doubled);
                            }
                        });
                    }
                });
                assert_eq!(ctx.validation_messages(), Vec::<String>::new());
            });
        }
    });
}
