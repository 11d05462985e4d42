//! Balls on stems over a board, and a sheet laid over them: what each way of looking for points makes of what overhangs.
//!
//! Out: the detailed model, the simple one, and the simple one with the colours that mappings find, holes black. The counterpart
//! of figure 7 of Tarini, Cignoni and Scopigno (2003), whose relief overhangs too.

use super::{Done, WIDTH};
use image::RgbaImage;
use invertex::mesh::{Mesh, smooth_normals};
use invertex::output::{TexturePlace, TexturedMesh, encode_glb, encode_texture};
use invertex::recover::{BakeAttribute, Mapping, Misses, Pair, PairSettings, Recovery};
use invertex::render::{Camera, Correspond, Options, Output, Projection, Renderer, stage};
use invertex::scene::Scene;
use libm::{cosf, sinf};
use std::f32::consts::{PI, TAU};

/// Where balls stand: across, along, how high their middles are, their radius.
const BALLS: [[f32; 4]; 3] = [
    [-0.45, -0.40, 0.42, 0.30],
    [0.42, -0.45, 0.36, 0.26],
    [0.0, 0.42, 0.48, 0.34],
];
/// Cells of the sheet along each side.
const CELLS: usize = 22;
/// Pixels upwards.
const HEIGHT: u32 = WIDTH * 4 / 5;
/// Texels along each side of what is baked.
const TEXELS: u32 = 512;

type Rgb = [u8; 3];
const BOARD: [Rgb; 2] = [[89, 137, 153], [112, 160, 173]];
const STRIPES: [Rgb; 2] = [[231, 130, 80], [249, 225, 158]];
const STEM: Rgb = [63, 188, 96];
const HOLE: [u8; 4] = [12, 12, 12, 255];

pub(super) fn panels() -> Done<Vec<RgbaImage>> {
    let (high, low) = (high()?, scene("sheet", &[(&sheet(), None, IN_PLACE)])?);
    let mut panels = vec![panel(&high)?, panel(&low)?];
    for mapping in [
        Mapping::Proximity,
        Mapping::Normal,
        Mapping::VisibilityTexel,
    ] {
        panels.push(panel(&baked(&high, &low, mapping)?)?);
    }
    Ok(panels)
}

/// A mesh, its colours (a picture's size and texels), and the places where it stands: a size and a shift each.
type Part<'a> = (&'a Mesh, Option<(u32, u32, Vec<u8>)>, &'a [(f32, [f32; 3])]);
const IN_PLACE: &[(f32, [f32; 3])] = &[(1.0, [0.0; 3])];

fn scene(name: &str, parts: &[Part]) -> Done<Scene> {
    let coded = parts.iter().map(|(_, colours, _)| match colours {
        Some((width, height, texels)) => encode_texture(*width, *height, texels).map(Some),
        None => Ok(None),
    });
    let coded = coded.collect::<Result<Vec<_>, _>>()?;
    let place = |&(size, [x, y, z]): &(f32, [f32; 3])| {
        [
            [size, 0.0, 0.0, 0.0],
            [0.0, size, 0.0, 0.0],
            [0.0, 0.0, size, 0.0],
            [x, y, z, 1.0],
        ]
    };
    let textured = parts.iter().zip(&coded).map(|((mesh, _, places), coded)| {
        let colours = coded.iter().map(|bytes| (TexturePlace::BaseColor, bytes));
        TexturedMesh {
            mesh,
            textures: colours
                .map(|(place, bytes)| (place, bytes.as_slice()))
                .collect(),
            places: places.iter().map(place).collect(),
        }
    });
    let glb = encode_glb(&textured.collect::<Vec<_>>())?;
    Ok(Scene::from_bytes(name, &glb, None)?)
}

/// The balls, their stems, the board.
fn high() -> Done<Scene> {
    let ball = patch([64, 32], |u, v| {
        let (a, e) = (TAU * u, PI * (v - 0.5));
        let across = cosf(e);
        let n = [across * cosf(a), across * sinf(a), sinf(e)];
        (n, n)
    });
    let stem = patch([48, 4], |u, v| {
        let (sin, cos) = (sinf(TAU * u), cosf(TAU * u));
        ([0.35 * cos, 0.35 * sin, -1.4 + 0.6 * v], [cos, sin, 0.0])
    });
    let board = patch([96, 96], |u, v| {
        ([2.0 * u - 1.0, 2.0 * v - 1.0, 0.0], [0.0, 0.0, 1.0])
    });
    let stand = BALLS.map(|[x, y, height, radius]| (radius, [x, height, -y]));
    let chequered = picture([16, 16], |x, y| BOARD[(x + y) % 2]);
    let striped = picture([16, 1], |x, _| STRIPES[x % 2]);
    scene(
        "relief",
        &[
            (&board, Some(chequered), IN_PLACE),
            (&ball, Some(striped), &stand),
            (&stem, Some(picture([1, 1], |_, _| STEM)), &stand),
        ],
    )
}

/// Falls from the balls straight to the board.
fn sheet() -> Mesh {
    let height = |x: f32, y: f32| {
        let over = |[a, b, height, radius]: [f32; 4]| {
            let up = radius * radius - (x - a).powi(2) - (y - b).powi(2);
            if up > 0.0 { height + up.sqrt() } else { 0.0 }
        };
        BALLS.map(over).into_iter().fold(0.0, f32::max)
    };
    let mut sheet = patch([CELLS, CELLS], |u, v| {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        ([x, y, height(x, y)], [0.0, 0.0, 1.0])
    });
    sheet.normals = smooth_normals(&sheet.positions, &sheet.triangles);
    sheet
}

/// A surface over the unit square, which `at` gives places and normals, z upwards; it stands with y upwards.
fn patch([columns, rows]: [usize; 2], at: impl Fn(f32, f32) -> ([f32; 3], [f32; 3])) -> Mesh {
    let mut mesh = Mesh {
        uv_sets: vec![Vec::new()],
        ..Mesh::default()
    };
    let upright = |[x, y, z]: [f32; 3]| [x, z, -y];
    for j in 0..=rows {
        for i in 0..=columns {
            let (u, v) = (i as f32 / columns as f32, j as f32 / rows as f32);
            let (position, normal) = at(u, v);
            mesh.positions.push(upright(position));
            mesh.normals.push(upright(normal));
            mesh.uv_sets[0].push([u, v]);
        }
    }
    let corner = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
    for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
        let across = corner(i + 1, j + 1);
        mesh.triangles
            .push([corner(i, j), corner(i + 1, j), across]);
        mesh.triangles
            .push([corner(i, j), across, corner(i, j + 1)]);
    }
    mesh
}

/// Squares of one colour each, of eight texels a side.
fn picture(
    [columns, rows]: [usize; 2],
    colour: impl Fn(usize, usize) -> Rgb,
) -> (u32, u32, Vec<u8>) {
    const SIDE: usize = 8;
    let texels = (0..rows * SIDE).flat_map(|y| (0..columns * SIDE).map(move |x| (x, y)));
    let texel = |(x, y): (usize, usize)| {
        let [r, g, b] = colour(x / SIDE, y / SIDE);
        [r, g, b, 255]
    };
    let texels = texels.flat_map(texel).collect();
    ((columns * SIDE) as u32, (rows * SIDE) as u32, texels)
}

/// The simple model with the colours that `mapping` finds; where its rays meet nothing there is a hole.
fn baked(high: &Scene, low: &Scene, mapping: Mapping) -> Done<Scene> {
    let settings = PairSettings {
        mapping,
        recovery: Recovery {
            misses: Misses::Blank,
            ..Recovery::default()
        },
        attributes: vec!["color".parse::<BakeAttribute>()?],
        size: TEXELS,
        ..PairSettings::default()
    };
    let draw = |picture| Ok(Renderer::cpu(picture));
    let baked = Pair::new(high, low, &settings, &draw, &())?.bake(0, &())?;
    let mut texels = baked.textures[0].rgba8();
    for (texel, &mask) in texels.as_chunks_mut::<4>().0.iter_mut().zip(&baked.mask) {
        if mask == 0 {
            *texel = HOLE;
        }
    }
    let mesh = baked.low.ok_or("no surface")?;
    scene(
        "baked",
        &[(&mesh, Some((TEXELS, TEXELS, texels)), IN_PLACE)],
    )
}

fn panel(scene: &Scene) -> Done<RgbaImage> {
    let (picture, _) = stage(scene, &[], Correspond::Reference, true)?;
    let (centre, radius) = picture.bounding_sphere();
    let projection = Projection::Perspective;
    let camera = Camera::framed(centre, radius * 0.66, 20.0, 28.0, projection, WIDTH, HEIGHT)?;
    let options = Options {
        output: Output::Lit,
        samples: 16,
        ..Options::default()
    };
    let image = Renderer::cpu(picture).draw(&camera, &options)?;
    RgbaImage::from_raw(WIDTH, HEIGHT, image.rgba8)
        .ok_or_else(|| "a picture of another size".into())
}
