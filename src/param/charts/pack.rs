//! Charts side by side in a square.
//!
//! In: charts' maps, all at one scale. Out: the same, turned and moved, and the side of the square that holds them. Charts are
//! turned so that the smallest rectangle round them stands upright, and are placed tallest first on a skyline of columns: a
//! chart goes where its underside leaves the least room between itself and what is there, as it is or upside down. A free
//! border is kept round each.
//! Source: Lévy et al., Least Squares Conformal Maps (2002), section 4 (packing by horizons).

use super::chart::Chart;
use super::merge::Flat;
use glam::DVec2;
use rayon::prelude::*;

/// Columns of the skyline.
const COLUMNS: usize = 512;
/// Free columns round a chart, on each side.
const BORDER: f64 = 1.0;
/// Widths of the skyline that are tried, times the side of a square as large as all charts.
const WIDTHS: [f64; 6] = [1.0, 1.05, 1.1, 1.15, 1.2, 1.3];

/// Places charts in the square `[0, side]`; returns the side.
pub(crate) fn pack(charts: &mut [Flat]) -> f64 {
    charts
        .par_iter_mut()
        .for_each(|flat| upright(&flat.chart, &mut flat.places));
    let extents: Vec<DVec2> = charts.iter().map(|flat| high(&flat.places)).collect();
    let area: f64 = extents.iter().map(|e| e.x * e.y).sum();
    let widest = extents.iter().map(|e| e.x).fold(0.0, f64::max);
    if area <= 0.0 {
        return 1.0;
    }
    let packed = |&factor: &f64| {
        let width = (area.sqrt() * factor * 0.85).max(widest * 1.02);
        placed(charts, &extents, width)
    };
    let tried: Vec<Packed> = WIDTHS.par_iter().map(packed).collect();
    let Some(best) = tried
        .into_iter()
        .reduce(|best, p| if p.side < best.side { p } else { best })
    else {
        return 1.0;
    };
    for (flat, place) in charts.iter_mut().zip(&best.places) {
        let extent = high(&flat.places);
        for p in &mut flat.places {
            *p = if place.over { extent - *p } else { *p } + place.at;
        }
    }
    best.side
}

/// Turns a map so that the smallest rectangle round it stands upright at the origin.
fn upright(chart: &Chart, places: &mut [DVec2]) {
    let rim: Vec<DVec2> = chart.rim.iter().map(|&v| places[v as usize]).collect();
    let hull = hull(rim);
    let mut best = (f64::INFINITY, DVec2::X);
    for (i, &p) in hull.iter().enumerate() {
        let Some(along) = (hull[(i + 1) % hull.len()] - p).try_normalize() else {
            continue;
        };
        let turned = hull
            .iter()
            .map(|q| DVec2::new(along.dot(*q), along.perp_dot(*q)));
        let (low, high) = bounds(turned);
        let extent = high - low;
        if extent.x * extent.y < best.0 {
            // The longer side goes up.
            let axis = if extent.x > extent.y {
                along.perp()
            } else {
                along
            };
            best = (extent.x * extent.y, axis);
        }
    }
    let axis = best.1;
    places
        .iter_mut()
        .for_each(|p| *p = DVec2::new(axis.dot(*p), axis.perp_dot(*p)));
    let (low, _) = bounds(places.iter().copied());
    places.iter_mut().for_each(|p| *p -= low);
}

fn bounds(points: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    points.fold(start, |(low, high), p| (low.min(p), high.max(p)))
}

fn high(places: &[DVec2]) -> DVec2 {
    places.iter().fold(DVec2::ZERO, |high, p| high.max(*p))
}

/// Convex hull, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<DVec2> = vec![];
    for half in 0..2 {
        let start = hull.len();
        for &p in &points {
            while hull.len() >= start + 2 {
                let (a, b) = (hull[hull.len() - 2], hull[hull.len() - 1]);
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        if half == 0 {
            points.reverse();
        }
    }
    hull
}

/// Where a chart goes, and whether upside down.
#[derive(Clone, Copy, Default)]
struct Place {
    at: DVec2,
    over: bool,
}

struct Packed {
    places: Vec<Place>,
    side: f64,
}

/// The under- and upper side of a chart in columns: lowest and highest point of each.
struct Outline {
    under: Vec<f64>,
    upper: Vec<f64>,
}

fn placed(charts: &[Flat], extents: &[DVec2], width: f64) -> Packed {
    let column = width / COLUMNS as f64;
    let mut order: Vec<usize> = (0..charts.len()).collect();
    order.sort_by(|&a, &b| extents[b].y.total_cmp(&extents[a].y).then(a.cmp(&b)));
    let mut skyline = vec![0.0; COLUMNS];
    let mut places = vec![Place::default(); charts.len()];
    for &c in &order {
        let outline = outline(&charts[c], extents[c], column);
        let turned = outline.over(extents[c].y);
        let tried =
            [(&outline, false), (&turned, true)].map(|(o, over)| (best(&skyline, o), over, o));
        let [this, other] = &tried;
        let ((at, base, _), over, used) = if other.0.2 < this.0.2 { other } else { this };
        for (k, upper) in used.upper.iter().enumerate() {
            skyline[at + k] = base + upper + BORDER * column;
        }
        // Upside down, the chart ends where its last column does.
        let left = match over {
            true => (at + used.upper.len()) as f64 * column - extents[c].x - BORDER * column,
            false => (*at as f64 + BORDER) * column,
        };
        let shift = DVec2::new(left, *base);
        places[c] = Place {
            at: shift,
            over: *over,
        };
    }
    let height = skyline.into_iter().fold(0.0, f64::max);
    Packed {
        places,
        side: width.max(height),
    }
}

/// The column where an outline leaves least room below, the height of its origin there, and what it costs.
fn best(skyline: &[f64], outline: &Outline) -> (usize, f64, f64) {
    let wide = outline.under.len();
    let mut best = (0, 0.0, f64::INFINITY);
    for at in 0..=skyline.len().saturating_sub(wide) {
        let below = &skyline[at..at + wide];
        let base = below
            .iter()
            .zip(&outline.under)
            .map(|(s, u)| s - u)
            .fold(0.0, f64::max);
        let room: f64 = below
            .iter()
            .zip(&outline.under)
            .map(|(s, u)| base + u - s)
            .sum();
        // What stands out at the top costs as much as what is lost below.
        let top = outline
            .upper
            .iter()
            .fold(0.0, |top: f64, u| top.max(base + u));
        let cost = room + top * wide as f64;
        if cost < best.2 {
            best = (at, base, cost);
        }
    }
    best
}

impl Outline {
    /// The outline of the same chart upside down (turned by half a turn).
    fn over(&self, height: f64) -> Outline {
        let turned = |side: &[f64]| side.iter().rev().map(|y| height - y).collect();
        Outline {
            under: turned(&self.upper),
            upper: turned(&self.under),
        }
    }
}

/// Every column that the rim, with its border, touches. Sides are sampled column by column.
fn outline(flat: &Flat, extent: DVec2, column: f64) -> Outline {
    let wide = ((extent.x / column + 2.0 * BORDER).ceil() as usize).clamp(1, COLUMNS);
    let mut outline = Outline {
        under: vec![f64::INFINITY; wide],
        upper: vec![f64::NEG_INFINITY; wide],
    };
    let rim = &flat.chart.rim;
    let border = BORDER * column;
    for (i, &v) in rim.iter().enumerate() {
        let (a, b) = (
            flat.places[v as usize],
            flat.places[rim[(i + 1) % rim.len()] as usize],
        );
        let (a, b) = if a.x <= b.x { (a, b) } else { (b, a) };
        let first = (a.x / column).floor().max(0.0) as usize;
        let last = ((b.x + 2.0 * border) / column).floor() as usize;
        for c in first..=last.min(wide - 1) {
            // What of the side lies in this column or within the border of it.
            let [from, to] = [c as f64 * column - 2.0 * border, (c as f64 + 1.0) * column]
                .map(|x| x.clamp(a.x, b.x));
            let at = |x: f64| {
                if b.x > a.x {
                    a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x)
                } else {
                    a.y
                }
            };
            let ends = if b.x > a.x {
                [at(from), at(to)]
            } else {
                [a.y, b.y]
            };
            outline.under[c] = outline.under[c].min(ends[0].min(ends[1]) - border);
            outline.upper[c] = outline.upper[c].max(ends[0].max(ends[1]) + border);
        }
    }
    // A rim is closed, so that no column between is left out; rounding may miss the last.
    for c in 0..wide {
        if outline.under[c] > outline.upper[c] {
            (outline.under[c], outline.upper[c]) = (0.0, extent.y);
        }
    }
    outline
}
