//! Which texels are neighbours on the surface: in the texture where they lie in one chart, across a seam where the texture
//! ends but the surface goes on. The paper (section 3.3) leaves this open and asks for a seamless texture instead.
//!
//! In: a surface with texture coordinates. Out: [`Links`]: its texels, numbered, and for each the four others next to it.
//!
//! A step that leaves a chart is followed to the edge where it leaves, over that edge to the triangle on the other side,
//! and half a texel further. So neighbours across a seam are as near on the surface as texels of either chart are fine.

use super::laid::Laid;
use super::texel::{self, Flat, cross, less};
use crate::mesh::{Adjacency, NONE, Weld};
use rayon::prelude::*;

/// Steps from triangle to triangle before a neighbour is given up.
const STEPS: usize = 32;
/// Left, right, up, down.
const WAYS: [[f64; 2]; 4] = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];

/// Texels of a surface and their neighbours.
pub(crate) struct Links {
    size: u32,
    /// The place in the texture of each texel, in growing order.
    pub(crate) texels: Vec<u32>,
    /// Left, right, up, down of each; [`NONE`] at a border of the surface.
    pub(crate) next: Vec<[u32; 4]>,
    /// The triangle that owns each.
    owner: Vec<u32>,
    /// The number of the texel at each place of the texture.
    number: Vec<u32>,
}

impl Links {
    pub(crate) fn new(low: &Laid, size: u32) -> Links {
        let walk = Walk::new(low, size);
        let owners = &walk.owners;
        let texels: Vec<u32> = (0..owners.len() as u32)
            .filter(|&at| owners[at as usize] != NONE)
            .collect();
        let mut number = vec![NONE; owners.len()];
        for (k, &at) in texels.iter().enumerate() {
            number[at as usize] = k as u32;
        }
        let next = texels.par_iter().map(|&at| {
            WAYS.map(|way| match walk.next(at, way) {
                Some(place) => number[place as usize],
                None => NONE,
            })
        });
        Links {
            next: next.collect(),
            owner: texels.iter().map(|&at| owners[at as usize]).collect(),
            size,
            texels,
            number,
        }
    }

    /// The number of the texel at a place of the texture; [`NONE`] off the surface.
    pub(super) fn at_place(&self, place: u32) -> u32 {
        self.number[place as usize]
    }

    /// The number of the texel at texture coordinates; [`NONE`] outside.
    pub(crate) fn at_uv(&self, uv: [f32; 2]) -> u32 {
        self.number[texel::place(self.size, uv)]
    }

    /// Texels, by number, and ways from them that lead to no other.
    pub(super) fn open(&self) -> Vec<(u32, usize)> {
        let all = self.next.iter().enumerate();
        let open = all.flat_map(|(k, next)| {
            let ways = (0..4).filter(|&way| next[way] == NONE);
            ways.map(move |way| (k as u32, way))
        });
        open.collect()
    }

    /// The number of the texel beside texel `k` (left, right, up, down) if it lies beside it in the texture too.
    pub(crate) fn in_chart(&self, k: usize, way: usize) -> Option<usize> {
        let next = *self.texels.get(self.next[k][way] as usize)?;
        let [x, y] = WAYS[way];
        let beside = i64::from(self.texels[k]) + x as i64 + y as i64 * i64::from(self.size);
        (i64::from(next) == beside).then(|| self.next[k][way] as usize)
    }
}

/// For each texel the triangle that owns it and where in it the texel's middle lies.
pub(crate) fn centres(low: &Laid, links: &Links, size: u32) -> Vec<(usize, [f32; 3])> {
    let centre = |(&at, &owner): (&u32, &u32)| {
        let corners = texel::corners(&low.object, owner as usize, size);
        let middle = [at % size, at / size].map(|c| f64::from(c) + 0.5);
        let b = Flat::new(&corners)
            .barycentric(middle)
            .unwrap_or([1.0, 0.0, 0.0]);
        (owner as usize, b)
    };
    let texels = links.texels.par_iter().zip(&links.owner);
    texels.map(centre).collect()
}

/// Steps from texel to texel over one surface.
pub(super) struct Walk<'a> {
    pub(super) low: &'a Laid,
    size: u32,
    /// The triangle at each place of the texture.
    owners: Vec<u32>,
    /// Corners by place.
    welded: Vec<[u32; 3]>,
    /// Corners by place in space and texture.
    flat: Vec<[u32; 3]>,
    pub(super) across: Vec<[u32; 3]>,
}

/// How a line leaves a chart.
enum Left {
    /// Into a triangle across a seam, at a place half a texel inside it.
    Over(usize, [f64; 2]),
    /// Over an edge beyond which the surface has nothing.
    Out(Crossing),
}

/// Where a line crosses an edge: `share` of the way from corner `k` of triangle `t` to the next corner.
pub(super) struct Crossing {
    pub(super) t: usize,
    pub(super) k: usize,
    pub(super) share: f64,
}

impl<'a> Walk<'a> {
    pub(super) fn new(low: &'a Laid, size: u32) -> Walk<'a> {
        let all = 0..low.object.triangles.len() as u32;
        let welded = low.weld.triangles(&low.world.triangles);
        Walk {
            low,
            size,
            owners: texel::owners(&low.object, all, size, 0..size),
            across: Adjacency::new(&welded).across,
            flat: Weld::by_position_and_uv(&low.world, 0).triangles(&low.world.triangles),
            welded,
        }
    }

    /// The place of the texel next to place `at`.
    fn next(&self, at: u32, way: [f64; 2]) -> Option<u32> {
        let (from, to) = self.step(at, way);
        let own = self.owners[at as usize];
        let place = self.place(to);
        if let Some(place) = place
            && self.chart_at(place) == Some(self.low.chart[own as usize])
        {
            return Some(place);
        }
        match self.leave(own as usize, from, to)? {
            Left::Over(t, uv) => self.place_of(t, uv),
            Left::Out(_) => None,
        }
    }

    /// Where a step from place `at` leaves the surface.
    pub(super) fn border(&self, at: u32, way: usize) -> Option<Crossing> {
        let (from, to) = self.step(at, WAYS[way]);
        match self.leave(self.owners[at as usize] as usize, from, to)? {
            Left::Over(..) => None,
            Left::Out(crossing) => Some(crossing),
        }
    }

    /// From the middle of the texel at place `at` to that of the one beside it.
    fn step(&self, at: u32, way: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let from = [at % self.size, at / self.size].map(|c| f64::from(c) + 0.5);
        (from, [from[0] + way[0], from[1] + way[1]])
    }

    /// The place of texel `uv` if the chart of triangle `t` has it.
    pub(super) fn place_of(&self, t: usize, uv: [f64; 2]) -> Option<u32> {
        let place = self.place(uv)?;
        (self.chart_at(place) == Some(self.low.chart[t])).then_some(place)
    }

    fn place(&self, [x, y]: [f64; 2]) -> Option<u32> {
        let size = f64::from(self.size);
        let inside = x >= 0.0 && y >= 0.0 && x < size && y < size;
        inside.then(|| y as u32 * self.size + x as u32)
    }

    fn chart_at(&self, place: u32) -> Option<u32> {
        let owner = self.owners[place as usize];
        (owner != NONE).then(|| self.low.chart[owner as usize])
    }

    /// Follows the straight line in the texture from `from` (in triangle `t`) towards `to` until it leaves the chart.
    fn leave(&self, mut t: usize, from: [f64; 2], to: [f64; 2]) -> Option<Left> {
        let mut came = NONE;
        for _ in 0..STEPS {
            let corners = texel::corners(&self.low.object, t, self.size);
            let k = self.leaves(&corners, t, came, from, to)?;
            let crossing = || Crossing {
                t,
                k,
                share: share([corners[k], corners[(k + 1) % 3]], from, to),
            };
            let other = self.across[t][k];
            if other == NONE {
                return Some(Left::Out(crossing()));
            }
            let next = other as usize;
            if !self.joined(t, k, next) {
                let corner = |k: usize| {
                    let v = self.welded[t][k % 3];
                    self.welded[next].iter().position(|&w| w == v)
                };
                let ends = [corner(k)?, corner(k + 1)?];
                let uv = self.landed(next, ends, crossing().share)?;
                return Some(Left::Over(next, uv));
            }
            (came, t) = (t as u32, next);
        }
        None
    }

    /// Whether the texture goes on over edge `k` of `t` into `next`: a chart may meet itself across a seam.
    fn joined(&self, t: usize, k: usize, next: usize) -> bool {
        let both = [k, (k + 1) % 3];
        both.iter()
            .all(|&k| self.flat[next].contains(&self.flat[t][k]))
    }

    /// The edge by which the line leaves triangle `t`: the one it crosses farthest along.
    fn leaves(
        &self,
        corners: &[[f64; 2]; 3],
        t: usize,
        came: u32,
        from: [f64; 2],
        to: [f64; 2],
    ) -> Option<usize> {
        let turned = cross(less(corners[1], corners[0]), less(corners[2], corners[0])).signum();
        let mut best: Option<(f64, usize)> = None;
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let edge = less(b, a);
            let (here, there) = (
                cross(edge, less(from, a)) * turned,
                cross(edge, less(to, a)) * turned,
            );
            // The edge that the line came in by is the one it does not leave by.
            if there >= here || (came != NONE && self.across[t][k] == came) {
                continue;
            }
            let along = here / (here - there);
            if best.is_none_or(|(least, _)| along < least) {
                best = Some((along, k));
            }
        }
        best.map(|(_, k)| k)
    }

    /// Half a texel inside triangle `t`, from the point that is `share` of the way between two of its corners.
    pub(super) fn landed(&self, t: usize, [i, j]: [usize; 2], share: f64) -> Option<[f64; 2]> {
        if i == j {
            return None;
        }
        let there = texel::corners(&self.low.object, t, self.size);
        let (p, q, apex) = (there[i], there[j], there[3 - i - j]);
        let at = [0, 1].map(|x| p[x] + (q[x] - p[x]) * share);
        let along = less(q, p);
        let mut inwards = [-along[1], along[0]];
        let length = inwards[0].hypot(inwards[1]);
        if length == 0.0 {
            return None;
        }
        if cross(along, less(apex, p)) < 0.0 {
            inwards = inwards.map(|c| -c);
        }
        Some([0, 1].map(|x| at[x] + inwards[x] / length * 0.5))
    }
}

/// How much of an edge lies before the line from `from` to `to` crosses it.
fn share([a, b]: [[f64; 2]; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let (edge, way) = (less(b, a), less(to, from));
    let share = cross(less(from, a), way) / cross(edge, way);
    share.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::laid::{Laying, UvLayout};
    use super::super::standing::Standing;
    use super::*;
    use crate::mesh::{Mesh, shapes};

    fn laid(mesh: &Mesh, layout: UvLayout, size: u32) -> Laid {
        let stood = Standing {
            number: 0,
            mesh: mesh.clone(),
            world: glam::DMat4::IDENTITY,
        };
        let laying = Laying {
            file: "test",
            layout,
            size,
        };
        Laid::all(&laying, mesh, &stood, &[]).unwrap().remove(0)
    }

    /// Distances between neighbours: those in one chart, and those across seams.
    fn distances(low: &Laid, size: u32) -> [Vec<f32>; 2] {
        let links = Links::new(low, size);
        let all = centres(low, &links, size);
        let point = |k: usize| glam::Vec3::from_array(low.point(all[k].0, all[k].1));
        let mut out = [Vec::new(), Vec::new()];
        for k in 0..all.len() {
            for way in (0..4).filter(|&way| links.next[k][way] != NONE) {
                let apart = point(k).distance(point(links.next[k][way] as usize));
                out[usize::from(links.in_chart(k, way).is_none())].push(apart);
            }
        }
        out
    }

    #[test]
    fn neighbours_across_seams_are_neighbours_on_the_surface() {
        for (mesh, layout, least) in [
            (shapes::tube(24, 4), UvLayout::Uv0, 100),
            (shapes::icosphere(2), UvLayout::Charts, 300),
        ] {
            let [inside, across] = distances(&laid(&mesh, layout, 64), 64);
            let longest = inside.iter().copied().fold(0.0, f32::max);
            assert!(across.len() >= least, "{}: {}", mesh.name, across.len());
            let far = across.iter().filter(|d| **d > 2.0 * longest).count();
            assert_eq!(far, 0, "{}: of {}", mesh.name, across.len());
            // The negative control: texels beside each other in the texture alone would be far apart.
            assert!(longest < 0.3);
        }
    }
}
