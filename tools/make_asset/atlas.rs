//! The artist's uv: the vase cut into panels, unrolled and packed.
//!
//! In: the silhouette. Out: charts with a place in a square atlas, each with the map (s, turn) -> uv and back. A
//! panel is unrolled at true length along s and true width at every s, so its sides are curved like a tailor's
//! gore. Paint is evaluated through the inverse map beyond the panel's border too: the gutter continues the picture.

use crate::profile::Profile;
use crate::surface::TURN;
use glam::{DVec2, dvec2};

/// Columns of the tessellation once round; chart borders lie on columns.
pub(crate) const COLUMNS: u32 = 240;
/// Texels between a chart's border and its neighbour's gutter.
const GUTTER: f64 = 5.0;

#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// A gore: straight down its middle.
    Panel,
    /// A full disc about the lower end of the axis.
    Disc,
}

/// One chart: a range of s, a range of columns, and where it lies in the atlas.
#[derive(Clone)]
pub(crate) struct Chart {
    pub(crate) shape: Shape,
    pub(crate) s: (f64, f64),
    pub(crate) columns: (u32, u32),
    /// Texel density relative to the others.
    density: f64,
    /// Laid on its side (turned clockwise).
    on_side: bool,
    /// Bounding box in the plane, object units.
    box_min: DVec2,
    box_max: DVec2,
    /// Lower corner in the atlas, texels.
    place: DVec2,
}

/// (from height, to height, panels, first column, density, on its side)
const PANELS: [(f64, f64, u32, u32, f64, bool); 8] = [
    (0.050, 0.282, 2, 20, 0.80, false),
    (0.282, 0.585, 5, 7, 0.90, true),
    (0.585, 1.120, 4, 31, 1.12, false),
    (1.120, 1.476, 3, 64, 1.08, true),
    (1.476, 1.806, 2, 0, 1.00, true),
    (1.806, 1.905, 2, 90, 0.85, false),
    (1.905, 2.096, 2, 45, 0.95, false),
    (2.096, 2.292, 2, 105, 0.90, false),
];

/// Cuts the vase: one disc below, panels in eight rings above.
pub(crate) fn charts(profile: &Profile) -> Vec<Chart> {
    let s_of = |height: f64| profile.s_of_height(height);
    let mut charts = vec![Chart::new(
        profile,
        Shape::Disc,
        (0.0, s_of(0.050)),
        (0, COLUMNS),
        0.55,
        false,
    )];
    for (from, to, count, first, density, on_side) in PANELS {
        let s = (
            s_of(from),
            if to >= 2.292 {
                profile.total()
            } else {
                s_of(to)
            },
        );
        let width = COLUMNS / count;
        for i in 0..count {
            let columns = (first + i * width, first + (i + 1) * width);
            charts.push(Chart::new(
                profile,
                Shape::Panel,
                s,
                columns,
                density,
                on_side,
            ));
        }
    }
    charts
}

impl Chart {
    fn new(
        profile: &Profile,
        shape: Shape,
        s: (f64, f64),
        columns: (u32, u32),
        density: f64,
        on_side: bool,
    ) -> Self {
        let nothing = DVec2::ZERO;
        let mut chart = Self {
            shape,
            s,
            columns,
            density,
            on_side,
            box_min: DVec2::MAX,
            box_max: DVec2::MIN,
            place: nothing,
        };
        for i in 0..=64 {
            for column in columns.0..=columns.1 {
                let at = s.0 + (s.1 - s.0) * f64::from(i) / 64.0;
                let p = chart.plane(profile, at, f64::from(column) / f64::from(COLUMNS));
                (chart.box_min, chart.box_max) = (chart.box_min.min(p), chart.box_max.max(p));
            }
        }
        chart
    }

    fn middle(&self) -> f64 {
        f64::from(self.columns.0 + self.columns.1) / (2.0 * f64::from(COLUMNS))
    }

    /// Unrolled, object units, right and up as seen from outside.
    fn plane(&self, profile: &Profile, s: f64, turn: f64) -> DVec2 {
        match self.shape {
            Shape::Panel => dvec2((turn - self.middle()) * TURN * profile.at(s).radius, s),
            // Seen from below, growing turn goes the other way round.
            Shape::Disc => s * dvec2(libm::cos(turn * TURN), libm::sin(turn * TURN)),
        }
    }

    fn surface(&self, profile: &Profile, p: DVec2) -> (f64, f64) {
        match self.shape {
            Shape::Panel => (
                p.y,
                self.middle() + p.x / (TURN * profile.at(p.y).radius.max(0.004)),
            ),
            Shape::Disc => (p.length(), libm::atan2(p.y, p.x) / TURN),
        }
    }

    fn texels(&self, per_unit: f64) -> DVec2 {
        let size = (self.box_max - self.box_min) * per_unit * self.density + 2.0 * GUTTER;
        let size = if self.on_side {
            dvec2(size.y, size.x)
        } else {
            size
        };
        size.ceil()
    }
}

/// All charts, placed.
pub(crate) struct Atlas {
    pub(crate) charts: Vec<Chart>,
    pub(crate) texels_per_unit: f64,
    size: f64,
}

impl Atlas {
    /// The densest packing that fits a square of `size` texels: tallest first, each at the lowest free place.
    pub(crate) fn pack(mut charts: Vec<Chart>, size: f32) -> Self {
        let size = f64::from(size);
        let mut per_unit = size;
        while !place_all(&mut charts, per_unit, size as usize) {
            per_unit *= 0.99;
        }
        Self {
            charts,
            texels_per_unit: per_unit,
            size,
        }
    }

    /// Texel coordinate of a point of the surface, through one chart.
    pub(crate) fn texel(&self, profile: &Profile, chart: &Chart, s: f64, turn: f64) -> DVec2 {
        let p = chart.plane(profile, s, turn);
        let k = self.texels_per_unit * chart.density;
        let right_down = dvec2(p.x - chart.box_min.x, chart.box_max.y - p.y) * k + GUTTER;
        let height = (chart.box_max.y - chart.box_min.y) * k + 2.0 * GUTTER;
        let turned = if chart.on_side {
            dvec2(height - right_down.y, right_down.x)
        } else {
            right_down
        };
        chart.place + turned
    }

    pub(crate) fn uv(&self, profile: &Profile, chart: &Chart, s: f64, turn: f64) -> DVec2 {
        self.texel(profile, chart, s, turn) / self.size
    }

    /// The point of the surface a texel coordinate inside the chart's rectangle stands for.
    pub(crate) fn surface(&self, profile: &Profile, chart: &Chart, texel: DVec2) -> (f64, f64) {
        let k = self.texels_per_unit * chart.density;
        let height = (chart.box_max.y - chart.box_min.y) * k + 2.0 * GUTTER;
        let local = texel - chart.place;
        let right_down = if chart.on_side {
            dvec2(local.y, height - local.x)
        } else {
            local
        };
        let plane = dvec2(
            chart.box_min.x + (right_down.x - GUTTER) / k,
            chart.box_max.y - (right_down.y - GUTTER) / k,
        );
        chart.surface(profile, plane)
    }

    /// Rectangle of a chart in texels: (x, y, width, height).
    pub(crate) fn rectangle(&self, chart: &Chart) -> (usize, usize, usize, usize) {
        let size = chart.texels(self.texels_per_unit);
        (
            chart.place.x as usize,
            chart.place.y as usize,
            size.x as usize,
            size.y as usize,
        )
    }

    /// Object units that one texel of the chart spans.
    pub(crate) fn texel_width(&self, chart: &Chart) -> f64 {
        1.0 / (self.texels_per_unit * chart.density)
    }
}

fn place_all(charts: &mut [Chart], per_unit: f64, size: usize) -> bool {
    let mut order: Vec<usize> = (0..charts.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse((charts[i].texels(per_unit).y as usize, i)));
    // Skyline: how high each column of texels is filled.
    let mut filled = vec![0usize; size];
    for i in order {
        let need = charts[i].texels(per_unit);
        let (width, height) = (need.x as usize, need.y as usize);
        if width > size {
            return false;
        }
        let level = |x: usize| filled[x..x + width].iter().copied().max().unwrap_or(0);
        let Some((y, x)) = (0..=size - width).step_by(4).map(|x| (level(x), x)).min() else {
            return false;
        };
        if y + height > size {
            return false;
        }
        filled[x..x + width].fill(y + height);
        charts[i].place = dvec2(x as f64, y as f64);
    }
    true
}
