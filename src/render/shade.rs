//! Pass *shade*: from triangle ids to colours. Twin of `glsl/render/shade.comp`.
//!
//! In: for each pixel the picture's triangle (from the raster pass), and all words of the [`Picture`]. Out: for each
//! pixel linear RGBA, sRGB RGBA of 8 bits, and the AOVs. Barycentrics are recomputed from the snapped vertices, at the
//! pixel and at its two neighbours, so gradients are analytic and never cross a triangle's border.

use super::beforehand;
use super::constants::{THRESHOLDS_AT, palette};
use super::cover::{Edges, edges};
use super::draw::{DrawRecord, Projected, ViewConstants, draw_of_triangle};
use super::filter::{Gathered, gather};
use super::frame;
use super::light::{lit, split, towards_eye};
use super::picture::Picture;
use super::project::affine;
use crate::attribute::arithmetic::{V3, srgb_encode, unit_encode};
use crate::attribute::surface::{Frame, Surface, SurfacePoint};
use rayon::prelude::*;

/// Id of a pixel that no triangle covers.
pub(crate) const NOTHING: u32 = u32::MAX;

/// Bits of [`ViewConstants::flags`]: what is written (0 lit, 1 base colour, 2 normals, 3 fetches) ...
pub(crate) const OUTPUT_LIT: u32 = 0;
pub(crate) const OUTPUT_UNLIT: u32 = 1;
pub(crate) const OUTPUT_NORMALS: u32 = 2;
pub(crate) const OUTPUT_FETCHES: u32 = 3;
pub(crate) const OUTPUT_MASK: u32 = 3;
/// ... whether the drawn triangles' edges are drawn over it ...
pub(crate) const FLAG_WIREFRAME: u32 = 4;
/// ... the [`Filter`], two bits from this one on ...
pub(crate) const FILTER_SHIFT: u32 = 3;
/// ... whether base colour is data, written as it is ...
pub(crate) const FLAG_DATA: u32 = 128;
/// ... from this bit on, 16 bits, the number of fetches at the top of the false-colour scale ...
pub(crate) const FETCHES_SHIFT: u32 = 8;
/// ... and, from this bit on, the bound of the shader LoD in quarters of a step of 8 bits.
pub(crate) const SHADER_LOD_SHIFT: u32 = 24;

/// Colour of wireframe lines, linear.
const LINE: V3 = [0.004, 0.006, 0.012];

/// One pixel of the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pixel {
    pub linear: [f32; 4],
    pub rgba8: u32,
    pub aov: Aov,
}

/// What else is known of a pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Aov {
    /// Triangle of the reference, counted in its own mesh; [`NOTHING`] where there is none.
    pub triangle: u32,
    /// Which draw.
    pub draw: u32,
    /// Barycentrics of corners 1 and 2 on the reference triangle.
    pub barycentric: [f32; 2],
    /// Fetches the correspondence took.
    pub fetches: u32,
    /// Depth, 1 where nothing is.
    pub depth: f32,
}

/// A pixel that nothing covers.
pub(crate) const EMPTY: Pixel = Pixel {
    linear: [0.0; 4],
    rgba8: 0,
    aov: Aov {
        triangle: NOTHING,
        draw: NOTHING,
        barycentric: [0.0; 2],
        fetches: 0,
        depth: 1.0,
    },
};

/// A drawn point that the tables know no reference point for: mid grey.
const UNKNOWN: Surface = Surface {
    base: [0.2, 0.2, 0.2, 1.0],
    normal: [0.0, 0.0, 1.0],
    emissive: [0.0; 3],
    metallic: 0.0,
    roughness: 1.0,
    occlusion: 1.0,
    bump: [0.5, 0.5, 1.0],
    masked: false,
    unlit: true,
};

/// All pixels, row by row.
pub(crate) fn cpu(
    picture: &Picture,
    view: &ViewConstants,
    projected: &[Projected],
    ids: &[u32],
) -> Vec<Pixel> {
    let width = view.width as usize;
    let mut out = vec![EMPTY; ids.len()];
    out.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let id = ids[y * width + x];
            if id != NOTHING {
                *pixel = shade(picture, view, projected, id, x as i32, y as i32);
            }
        }
    });
    out
}

fn shade(
    picture: &Picture,
    view: &ViewConstants,
    projected: &[Projected],
    id: u32,
    x: i32,
    y: i32,
) -> Pixel {
    let draw_index = draw_of_triangle(&picture.draws, id);
    let draw = &picture.draws[draw_index];
    let local = id - draw.first_triangle;
    let corner = picture.corners[(draw.corner_base + local) as usize];
    let vertex = [corner[0], corner[1], corner[2]];
    let seen = vertex.map(|v| projected[(v - draw.vertex_base + draw.projected_base) as usize]);
    let here = edges(&seen, x, y);
    let sense = here.covers();
    let Some(b) = here.barycentric(sense) else {
        return EMPTY;
    };
    let drawn = Drawn {
        b,
        bx: edges(&seen, x + 1, y).barycentric(sense),
        by: edges(&seen, x, y + 1).barycentric(sense),
        local,
        vertex,
        asker: corner[3],
    };
    let depth = super::cover::depth(&seen, b, [0.0; 2]).unwrap_or(1.0);
    let sight = Sight {
        here: &here,
        sense,
        world: world_position(picture, draw, vertex, b),
        frame: &frame::at(picture, draw, vertex, b),
        attribute_base: draw.attribute_base,
    };
    let filter = view.filter();
    let see = |p: &SurfacePoint| surface_seen(picture, &sight, p, view.time);
    let before = beforehand::at(
        picture,
        draw,
        view,
        &drawn,
        (sight.frame, sight.is_turned()),
    );
    let Gathered {
        point,
        surface,
        fetches,
    } = gather((picture, draw), &drawn, filter, before, see);
    let surface = surface.unwrap_or(UNKNOWN);
    let (linear, rgba8) = colour(picture, view, &sight, &surface, fetches);
    let (triangle, barycentric) = point.map_or((NOTHING, [0.0; 2]), |p| {
        (p.triangle - draw.attribute_base, [p.b[1], p.b[2]])
    });
    let aov = Aov {
        triangle,
        draw: draw_index as u32,
        barycentric,
        fetches,
        depth,
    };
    Pixel { linear, rgba8, aov }
}

/// The drawn triangle at a pixel: barycentrics there and, where they mean something, one pixel further.
pub(crate) struct Drawn {
    pub b: [f32; 3],
    pub bx: Option<[f32; 3]>,
    pub by: Option<[f32; 3]>,
    /// Number of the triangle in its draw.
    pub local: u32,
    /// Its vertices in the picture's arrays.
    pub vertex: [u32; 3],
    /// Which hits it prefers: an [`Asker::word`](crate::igt::Asker::word).
    pub asker: u32,
}

/// How the drawn triangle is seen at a pixel.
struct Sight<'a> {
    here: &'a Edges,
    sense: i32,
    world: V3,
    frame: &'a frame::Rows,
    /// The first triangle of its reference in the attributes.
    attribute_base: u32,
}

impl Sight<'_> {
    /// Whether the back is seen. Counter-clockwise is the front, with y up; pixels have y down; a mirroring transform turns
    /// it again.
    fn is_turned(&self) -> bool {
        self.sense as f32 * self.frame.1[0][3] > 0.0
    }
}

fn world_position(picture: &Picture, draw: &DrawRecord, vertex: [u32; 3], b: [f32; 3]) -> V3 {
    let [p0, p1, p2] = vertex.map(|v| picture.positions[v as usize]);
    let p = [0, 1, 2].map(|i| b[0] * p0[i] + b[1] * p1[i] + b[2] * p2[i]);
    draw.world.map(|row| affine(row, p))
}

/// What the material says at a point, the normal on the side that is seen, and what is shown in place of it.
fn surface_seen(picture: &Picture, sight: &Sight, p: &SurfacePoint, time: f32) -> Surface {
    let (world, normal) = sight.frame;
    let frame = Frame { world, normal };
    let mut surface = picture.attributes.surface(&picture.constants, p, &frame);
    if sight.is_turned() {
        surface.normal = surface.normal.map(|c| -c);
    }
    let triangle = p.triangle - sight.attribute_base;
    let attributes = &picture.attributes;
    attributes.show(&picture.constants, &mut surface, p, triangle, time);
    surface
}

fn colour(
    picture: &Picture,
    view: &ViewConstants,
    sight: &Sight,
    surface: &Surface,
    fetches: u32,
) -> ([f32; 4], u32) {
    let constants = &picture.constants;
    if surface.masked {
        return ([0.0; 4], 0);
    }
    let output = view.flags & OUTPUT_MASK;
    let coded = match output {
        OUTPUT_NORMALS => Some(surface.normal.map(|c| c * 0.5 + 0.5)),
        OUTPUT_FETCHES => Some(false_colour(constants, fetches, view.flags)),
        _ if view.flags & FLAG_DATA != 0 => {
            Some([surface.base[0], surface.base[1], surface.base[2]])
        }
        _ => None,
    };
    if let Some([r, g, b]) = coded {
        let code = unit_encode(r) | (unit_encode(g) << 8) | (unit_encode(b) << 16) | 0xff00_0000;
        return ([r, g, b, 1.0], code);
    }
    let mut rgb = [surface.base[0], surface.base[1], surface.base[2]];
    if output == OUTPUT_LIT && !surface.unlit {
        let (toward, intensity) = split([view.light[0], view.light[1], view.light[2]]);
        rgb = lit(
            surface,
            towards_eye(view.eye, sight.world),
            toward,
            intensity,
            view.light[3],
        );
    }
    if view.flags & FLAG_WIREFRAME != 0 {
        let line = wire(sight.here);
        rgb = [0, 1, 2].map(|i| rgb[i] * (1.0 - line) + LINE[i] * line);
    }
    let thresholds = &constants[THRESHOLDS_AT..THRESHOLDS_AT + 256];
    let [r, g, b] = rgb.map(|c| srgb_encode(thresholds, c));
    (
        [rgb[0], rgb[1], rgb[2], 1.0],
        r | (g << 8) | (b << 16) | 0xff00_0000,
    )
}

/// Gives pixels of linear (or coded) colour their 8-bit codes, and false colours where fetches are asked for: what the
/// forward path leaves to the host.
#[cfg(feature = "gpu")]
pub(crate) fn encode(pixels: &mut [Pixel], constants: &[f32], flags: u32) {
    let thresholds = &constants[THRESHOLDS_AT..THRESHOLDS_AT + 256];
    let output = flags & OUTPUT_MASK;
    pixels
        .par_iter_mut()
        .filter(|p| p.aov.draw != NOTHING)
        .for_each(|pixel| {
            if output == OUTPUT_FETCHES {
                let [r, g, b] = false_colour(constants, pixel.aov.fetches, flags);
                pixel.linear = [r, g, b, 1.0];
            }
            let coded =
                output == OUTPUT_NORMALS || output == OUTPUT_FETCHES || flags & FLAG_DATA != 0;
            let code = |c: f32| {
                if coded {
                    unit_encode(c)
                } else {
                    srgb_encode(thresholds, c)
                }
            };
            let [r, g, b, _] = pixel.linear;
            pixel.rgba8 = code(r) | (code(g) << 8) | (code(b) << 16) | 0xff00_0000;
        });
}

/// False colour of a number of fetches.
fn false_colour(constants: &[f32], fetches: u32, flags: u32) -> V3 {
    let top = (flags >> FETCHES_SHIFT & 0xffff) as i32 as f32;
    palette(constants, fetches as i32 as f32 / top.max(1.0))
}

/// How much of a pixel the lines along the drawn triangle's edges cover. Lines fade where the triangle is only a few
/// pixels high, so that dense meshes turn to an even tone instead of speckles.
fn wire(edges: &Edges) -> f32 {
    let doubled_area = (edges.value[0] + edges.value[1] + edges.value[2]).abs();
    let mut line = 0f32;
    for k in 0..3 {
        let [x, y] = edges.step[k];
        let length = (x * x + y * y).sqrt().max(1e-6);
        // Values are in 1/256 square pixels, lengths in 1/16 pixels.
        let distance = edges.value[k].abs() / (length * 16.0);
        let height = doubled_area / (length * 16.0);
        let fade = ((height - 1.0) * 0.25).clamp(0.15, 1.0);
        line = line.max((1.1 - distance).clamp(0.0, 1.0) * fade);
    }
    line * 0.85
}
