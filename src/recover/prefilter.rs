//! The shader LoD's textures: appearance over the primary parameterization, filtered beforehand, which says itself where it
//! will do.
//!
//! In: a built model, a size. Out: [`Prefiltered`] for each of its meshes. A texel is the mean of what the full lookup answers
//! in a window two texels wide. Then both are asked at places between texels too, over footprints of several shapes; the farthest that they come apart in the neighbourhood of a texel is written into it. Texels without
//! a surface, which nothing asks for, count for nothing.
//!
//! Where surfaces lie over each other one of them can be filtered. It is the layer, seen from one side or from any, that
//! fills most of a coarse raster; who asks for another is always looked up ([`Scope`]).
//!
//! ```text
//! address -> T3 -> lookup -> surface -> levels -> sampled as a shader would -> distance to the surface -> fourth channel
//! ```

use super::coding::code;
use super::low::{ROWS, UPRIGHT};
use super::prefilter_apart::halved;
use super::{address, fill};
use crate::asset::{Built, BuiltMesh, Progress};
use crate::attribute::prefiltered::{CODES_A_STEP, Role, levels, texels};
use crate::attribute::surface::{Frame, Surface, SurfacePoint};
use crate::attribute::{AttributeSet, Prefiltered, Scope, TextureSet, attributes_of};
use crate::igt::Tables;
use crate::param::projection::Line;
use crate::render::{THRESHOLDS_AT, constants};
use crate::{Error, Result};
use rayon::prelude::*;

/// Lookups along each side of the square that a texel is the mean of.
const WINDOW: usize = 4;

/// Filters the appearance of all meshes of `built`, with `size` texels along each side of the first level. Returns what was
/// replaced on the way, as [`attributes_of`].
///
/// # Errors
/// [`Error::Option`] for a size that is not a power of two in [`Prefiltered::SIZES`]; [`Error::Capacity`] where textures do
/// not fit; [`Error::Cancelled`].
pub fn prefilter(built: &mut Built, size: u32, progress: &dyn Progress) -> Result<Vec<String>> {
    Prefiltered::check(size, Scope::default()).map_err(|reason| Error::Option {
        option: "--shader-lod",
        reason,
    })?;
    let (mut attributes, warnings) = attributes_of(&built.scene, true)?;
    let constants = constants();
    for k in 0..built.meshes.len() {
        let mesh = &built.meshes[k];
        let reference = &built.scene.meshes[mesh.mesh];
        attributes.triangles.clear();
        attributes.vertices.clear();
        attributes.push_mesh_of_scene(reference, mesh.mesh)?;
        let mut filtering = Filtering {
            tables: &mesh.tables,
            layer_of: &mesh.triangle_layer,
            attributes: &attributes,
            constants: &constants,
            size,
            scope: Scope::default(),
        };
        filtering.scope = filtering.widest(&layers(mesh));
        filtering.scope.unlit = filtering.is_unlit();
        built.meshes[k].prefiltered = Some(filtering.run(&reference.name, progress)?);
    }
    Ok(warnings)
}

/// The layers there are.
fn layers(mesh: &BuiltMesh) -> Vec<u8> {
    let mut layers = mesh.triangle_layer.clone();
    layers.sort_unstable();
    layers.dedup();
    layers
}

/// One mesh.
pub(super) struct Filtering<'a> {
    pub(super) tables: &'a Tables,
    /// For each triangle of the reference.
    pub(super) layer_of: &'a [u8],
    pub(super) attributes: &'a AttributeSet,
    pub(super) constants: &'a [f32],
    pub(super) size: u32,
    /// What is filtered.
    pub(super) scope: Scope,
}

/// What the four images hold at a place.
type Values = [[f32; 4]; 4];

impl Filtering<'_> {
    fn run(&self, name: &str, progress: &dyn Progress) -> Result<Prefiltered> {
        let mut images: [Vec<u8>; 4] =
            std::array::from_fn(|_| Vec::with_capacity(4 * texels(self.size)));
        let all = 2 * levels(self.size).count();
        let heard = |done: usize| {
            progress.at("shader LoD", name, done, all);
            match progress.cancelled() {
                true => Err(Error::Cancelled),
                false => Ok(()),
            }
        };
        for (k, (_, side)) in levels(self.size).enumerate() {
            heard(k)?;
            let values = self.level(side);
            for (role, image) in Role::ALL.into_iter().zip(&mut images) {
                let coded = values.iter().map(|v| self.coded(role, v[role as usize]));
                image.extend(coded.flatten());
            }
        }
        let plain = Prefiltered::new(self.size, self.scope, images.clone())?;
        let mut textures = TextureSet::default();
        textures.add_prefiltered(0, &plain, self.goes_round())?;
        let mut unusable = self.unusable();
        for (k, (at, side)) in levels(self.size).enumerate() {
            heard(all / 2 + k)?;
            if k > 0 {
                unusable = halved(&unusable, side);
            }
            let apart = self.apart(&textures, side, &unusable);
            for (i, apart) in self.widened(&apart, side).into_iter().enumerate() {
                for (role, steps) in [Role::Base, Role::Normal].into_iter().zip(apart) {
                    let code = (steps * CODES_A_STEP).ceil().min(255.0);
                    images[role as usize][4 * (at + i) + 3] = code as u8;
                }
            }
        }
        Prefiltered::new(self.size, self.scope, images)
    }

    pub(super) fn line(&self) -> Line {
        self.tables.primary.line()
    }

    /// Whether the first axis of addresses closes.
    pub(super) fn goes_round(&self) -> bool {
        self.line() == Line::Cylinder
    }

    /// All texels of a level, those without a surface filled from their neighbours and then with the mean.
    fn level(&self, side: usize) -> Vec<Values> {
        let known: Vec<Option<Values>> = (0..side * side)
            .into_par_iter()
            .map(|i| self.texel(side, [i % side, i / side]))
            .collect();
        let filled = fill::spread(known, side as u32, 2);
        let mean = mean(filled.iter().flatten());
        filled.into_iter().map(|v| v.unwrap_or(mean)).collect()
    }

    /// The mean over a texel.
    fn texel(&self, side: usize, at: [usize; 2]) -> Option<Values> {
        let part = 1.0 / WINDOW as f32;
        let seen: Vec<Values> = window(side, at)
            .filter_map(|st| self.place(st, side))
            .map(|p| values(&self.seen(&p, [part, part])))
            .collect();
        (!seen.is_empty()).then(|| mean(seen.iter()))
    }

    /// The point of the reference at an address, its gradients those of a footprint two texels wide.
    pub(super) fn place(&self, st: [f64; 2], side: usize) -> Option<SurfacePoint> {
        let asker = self.asker(self.scope.side.into());
        address::asked(self.tables, st, 2.0 / side as f64, asker)
    }

    /// What the full lookup shows over a footprint, object space.
    pub(super) fn seen(&self, place: &SurfacePoint, shares: [f32; 2]) -> Surface {
        let point = SurfacePoint {
            dx: place.dx.map(|d| d.map(|c| c * shares[0])),
            dy: place.dy.map(|d| d.map(|c| c * shares[1])),
            ..*place
        };
        let frame = Frame {
            world: &ROWS,
            normal: &UPRIGHT,
        };
        self.attributes.surface(self.constants, &point, &frame)
    }

    fn coded(&self, role: Role, value: [f32; 4]) -> [u8; 4] {
        let thresholds = &self.constants[THRESHOLDS_AT..THRESHOLDS_AT + 256];
        let code = |c: f32| code(c, role.is_srgb(), thresholds);
        [code(value[0]), code(value[1]), code(value[2]), 0]
    }
}

/// Addresses of the middles of `along` x `along` equal parts of a texel.
pub(super) fn places(side: usize, at: [usize; 2], along: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..along * along).map(move |k| {
        let part = [k % along, k / along];
        [0, 1].map(|i| {
            let within = (part[i] as f64 + 0.5) / along as f64;
            (at[i] as f64 + within) / side as f64
        })
    })
}

/// Addresses of the middles of equal parts of a square two texels wide round a texel's middle.
fn window(side: usize, at: [usize; 2]) -> impl Iterator<Item = [f64; 2]> {
    places(side, at, WINDOW).map(move |st| {
        [0, 1].map(|i| {
            let middle = (at[i] as f64 + 0.5) / side as f64;
            middle + 2.0 * (st[i] - middle)
        })
    })
}

fn values(s: &Surface) -> Values {
    let four = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
    [
        s.base,
        four(s.normal.map(|c| c * 0.5 + 0.5)),
        [s.occlusion, s.roughness, s.metallic, 0.0],
        four(s.emissive),
    ]
}

/// The mean; grey where there is none.
fn mean<'a>(all: impl Iterator<Item = &'a Values>) -> Values {
    let (mut sum, mut count) = ([[0f64; 4]; 4], 0u32);
    for values in all {
        for (sum, value) in sum.iter_mut().flatten().zip(values.iter().flatten()) {
            *sum += f64::from(*value);
        }
        count += 1;
    }
    if count == 0 {
        return [[0.5; 4]; 4];
    }
    sum.map(|image| image.map(|c| (c / f64::from(count)) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_evenly_in_their_texel() {
        let all: Vec<_> = places(4, [1, 3], 2).collect();
        assert_eq!(all[0], [1.25 / 4.0, 3.25 / 4.0]);
        assert_eq!(all[3], [1.75 / 4.0, 3.75 / 4.0]);
    }
}
