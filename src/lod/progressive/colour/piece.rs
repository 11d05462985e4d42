//! Parts of a reference triangle whose feet are shown by one formula: their largest deviations at each level.

use super::bound::Search;
use super::landing::Linear;
use super::palette::Palette;
use super::polygon::Polygon;
use glam::{DVec2, DVec3};

/// The part of a cell whose feet are shown by one triangle.
pub(super) struct Piece {
    pub(super) shown: u32,
    /// Its corners' second and third barycentric coordinates in the triangle that it is part of.
    pub(super) polygon: Polygon<2>,
    /// Homogeneous coordinates of the feet in what is shown.
    pub(super) coordinates: Linear<DVec3>,
}

/// Places of points in what two triangles show, for the corners of a polygon over which they vary linearly: u and v of the
/// first; u, v and weight of the second.
pub(super) type Places = Polygon<5>;

/// Such places, ready to be looked at at any level.
pub(super) struct Ready<'a> {
    palette: &'a Palette,
    /// The triangle that points are of, and the one that is shown.
    triangles: [u32; 2],
    places: Places,
    /// How far apart a point's two places are, at most, along either axis.
    far: DVec2,
}

impl Piece {
    /// As part of triangle `t`.
    pub(super) fn of<'a>(&self, palette: &'a Palette, t: u32) -> Ready<'a> {
        let own = Linear::<DVec2>::through(palette.coordinates(t));
        let places = self.polygon.map(|r| {
            let (here, there) = (own.of(r), self.coordinates.of(r));
            [here.x, here.y, there.x, there.y, there.z]
        });
        Ready::new(palette, [t, self.shown], places)
    }
}

impl<'a> Ready<'a> {
    pub(super) fn new(palette: &'a Palette, triangles: [u32; 2], places: Places) -> Self {
        let repeats = palette.shared(triangles[0], triangles[1]);
        let places = repeats.map_or(places, |repeats| same_copy(places, repeats));
        Ready {
            palette,
            triangles,
            places,
            far: way(&places),
        }
    }

    /// At all levels, from the coarsest on: a finer one has deviations at least as large.
    pub(super) fn look(&self, searches: &mut [Search]) {
        let [t, shown] = self.triangles;
        for k in (0..searches.len()).rev() {
            if k + 1 < searches.len() {
                let coarser = searches[k + 1].lower;
                searches[k].reach(coarser);
            }
            if !self.palette.is_as_next(shown, t, k) {
                self.look_at(k, &mut searches[k]);
            }
        }
    }

    /// At one level.
    pub(super) fn look_at(&self, level: usize, search: &mut Search) {
        let first = self.triangles[0];
        let sides = self.triangles.map(|t| self.palette.side(t, first, level));
        if sides[0].is_smooth_with(&sides[1]) {
            let upper = sides[0].along(self.far);
            if upper <= search.enough() {
                search.settle(upper);
                return;
            }
        }
        let [(a, a_shift), (b, b_shift)] = sides.map(|side| side.scale());
        let texels = |c: &[f64; 5]| {
            [
                c[0] * a[0] - a_shift,
                c[1] * a[1] - a_shift,
                c[2] * b[0] - c[4] * b_shift,
                c[3] * b[1] - c[4] * b_shift,
                c[4],
            ]
        };
        search.look_at(sides, self.places.map(texels));
    }
}

/// The second places in the copy of a repeated picture that the first are in.
fn same_copy(places: Places, repeats: [bool; 2]) -> Places {
    let middle = places.middle();
    let apart = [0, 1].map(|k| match repeats[k] {
        true => (middle[2 + k] / middle[4] - middle[k]).round(),
        false => 0.0,
    });
    if apart == [0.0; 2] {
        return places;
    }
    places.map(|c| {
        let [x, y] = [0, 1].map(|k| c[2 + k] - apart[k] * c[4]);
        [c[0], c[1], x, y, c[4]]
    })
}

fn way(places: &Places) -> DVec2 {
    let (mut far, mut weights) = (DVec2::ZERO, [f64::INFINITY, 0f64]);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for c in places.corners() {
        let place = DVec2::new(c[2], c[3]) / c[4];
        far = far.max((place - DVec2::new(c[0], c[1])).abs());
        (low, high) = (low.min(place), high.max(place));
        weights = [weights[0].min(c[4]), weights[1].max(c[4])];
    }
    if weights[0] <= 0.0 {
        return DVec2::INFINITY;
    }
    // What weights move a mean of places: see `bound`.
    far + (high - low) * (0.25 * (weights[1] / weights[0] - 1.0))
}
