//! A graphics pass on every device: coverage and ids equal an integer rasteriser's, loads keep, depth decides, textures
//! arrive, images read back what was drawn.
#![cfg(feature = "gpu")]

mod devices;

use devices::on_every_device;
use invertex::gpu::shaders::test_triangle::{Bindings, Push, Shader};
use invertex::gpu::shaders::types::ClipVertex;
use invertex::gpu::{
    Clear, Context, GraphicsOptions, GraphicsPass, Image, ImageOptions, Pipeline, SamplerOptions,
    vk,
};

const SIZE: u32 = 37;
const COLOR: [vk::Format; 2] = [vk::Format::R32_UINT, vk::Format::R32G32B32A32_SFLOAT];
const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

/// A triangle: corners in half pixels, and its depth.
type Corners = ([[i64; 2]; 3], f32);

fn clip(triangles: &[Corners]) -> Vec<ClipVertex> {
    let to_clip = |half: i64| half as f32 / SIZE as f32 - 1.0;
    let corner = |[x, y]: [i64; 2], z: f32| ClipVertex {
        position: [to_clip(x), to_clip(y), z, 1.0],
    };
    triangles
        .iter()
        .flat_map(|(corners, z)| corners.map(|c| corner(c, *z)))
        .collect()
}

/// Ids of the triangles on top at pixel centres, by edge functions; the corners lie on even half pixels and the centres
/// on odd ones, and no edge used here meets a centre.
fn expected(triangles: &[Corners], start: u32) -> Vec<u32> {
    let inside = |[a, b, c]: &[[i64; 2]; 3], p: [i64; 2]| {
        let edge = |a: &[i64; 2], b: &[i64; 2]| {
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        };
        let signs = [edge(a, b), edge(b, c), edge(c, a)].map(i64::signum);
        assert!(
            !signs.contains(&0),
            "an edge meets a pixel centre: choose other corners"
        );
        signs[0] == signs[1] && signs[1] == signs[2]
    };
    let pixels = (0..i64::from(SIZE))
        .flat_map(|y| (0..i64::from(SIZE)).map(move |x| [2 * x + 1, 2 * y + 1]));
    pixels
        .map(|p| {
            let hits = triangles
                .iter()
                .enumerate()
                .filter(|(_, (corners, _))| inside(corners, p));
            let nearest = hits.fold((start, f32::MAX), |best, (at, (_, z))| {
                if *z <= best.1 {
                    (at as u32 + 1, *z)
                } else {
                    best
                }
            });
            nearest.0
        })
        .collect()
}

struct Targets {
    id: Image,
    color: Image,
    depth: Image,
}

fn targets(ctx: &Context) -> Targets {
    let color = vk::ImageUsageFlags::COLOR_ATTACHMENT;
    let depth = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
    Targets {
        id: ctx.target("id", SIZE, SIZE, COLOR[0], color).unwrap(),
        color: ctx.target("color", SIZE, SIZE, COLOR[1], color).unwrap(),
        depth: ctx.target("depth", SIZE, SIZE, DEPTH, depth).unwrap(),
    }
}

fn pipeline(ctx: &Context) -> Pipeline<Shader> {
    ctx.graphics(&GraphicsOptions {
        color_formats: &COLOR,
        depth: Some(DEPTH),
        topology: vk::PrimitiveTopology::TRIANGLE_LIST,
        cull: vk::CullModeFlags::NONE,
        depth_test: true,
    })
    .unwrap()
}

fn draw(ctx: &Context, targets: &Targets, triangles: &[Corners], start: Option<u32>) {
    let vertices = ctx.upload("vertices", &clip(triangles)).unwrap();
    let options = ImageOptions {
        size: [2, 1],
        layers: None,
        levels: 2,
        format: vk::Format::R8G8B8A8_UNORM,
        usage: vk::ImageUsageFlags::SAMPLED,
    };
    let paint = ctx
        .texture(
            "paint",
            &options,
            &[&[255, 0, 0, 255, 255, 0, 0, 255], &[0, 0, 255, 255]],
        )
        .unwrap();
    let sampler = ctx.sampler(&SamplerOptions::default()).unwrap();
    let bindings = Bindings {
        vertices: &vertices,
        paint: (&paint, &sampler),
    };
    let bound = pipeline(ctx).bind(&bindings).unwrap();
    let mut recorder = ctx.recorder("draw").unwrap();
    let (id, color, depth) = match start {
        Some(id) => (
            Clear::Uint([id; 4]),
            Clear::Float([0.25; 4]),
            Clear::Depth(1.0),
        ),
        None => (Clear::Load, Clear::Load, Clear::Load),
    };
    recorder.draw(&GraphicsPass {
        pipeline: &bound,
        push: Push { gain: 0.5 },
        color: &[(&targets.id, id), (&targets.color, color)],
        depth: Some((&targets.depth, depth)),
        vertices: 3 * triangles.len() as u32,
        instances: 1,
    });
    ctx.run(recorder).unwrap();
}

const NEAR: Corners = ([[4, 4], [60, 10], [20, 62]], 0.25);
const FAR: Corners = ([[2, 40], [70, 2], [66, 72]], 0.75);

#[test]
fn coverage_equals_an_integer_rasteriser() {
    on_every_device(|ctx| {
        let targets = targets(ctx);
        draw(ctx, &targets, &[NEAR, FAR], Some(9));
        let ids = ctx.download_image::<u32>(&targets.id).unwrap();
        let expected_ids = expected(&[NEAR, FAR], 9);
        assert!(ids == expected_ids, "coverage on {}", ctx.info().name);
        let moved = ([[8, 4], [60, 10], [20, 62]], 0.25);
        assert!(
            ids != expected(&[moved, FAR], 9),
            "another triangle must cover other pixels"
        );
        let colors = ctx.download_image::<[f32; 4]>(&targets.color).unwrap();
        let depths = ctx.download_image::<f32>(&targets.depth).unwrap();
        for ((id, color), depth) in ids.iter().zip(&colors).zip(&depths) {
            let (paint, z) = match id {
                1 => ([0.5, 0.0, 0.0, 0.5], 0.25),
                2 => ([0.5, 0.0, 0.0, 0.5], 0.75),
                _ => ([0.25; 4], 1.0),
            };
            assert_eq!(
                (*color, *depth),
                (paint, z),
                "triangle {id} on {}",
                ctx.info().name
            );
        }
    });
}

#[test]
fn a_second_pass_can_keep_the_first() {
    on_every_device(|ctx| {
        let targets = targets(ctx);
        draw(ctx, &targets, &[NEAR], Some(0));
        draw(ctx, &targets, &[FAR], None);
        // Both are triangle 1 of their pass, the far one only where the near one is not.
        let union: Vec<u32> = expected(&[NEAR, FAR], 0)
            .iter()
            .map(|id| (*id).min(1))
            .collect();
        assert!(ctx.download_image::<u32>(&targets.id).unwrap() == union);
        draw(ctx, &targets, &[FAR], Some(0));
        assert!(
            ctx.download_image::<u32>(&targets.id).unwrap() == expected(&[FAR], 0),
            "a clear forgets"
        );
    });
}
