//! Plots over two axes as inline SVG: lines with points, or columns.
//!
//! In: named lines of points, linear or logarithmic axes. Out: SVG text that takes its colours from the page's style.
//! Logarithmic axes that few values lie on are ticked at these (hash resolutions, distances).

use std::fmt::Write;

use super::chart::{legend, text};
use super::page::escape;

/// An axis.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// What it measures, with the unit.
    pub name: String,
    /// Logarithmic; values not above zero are then left out.
    pub log: bool,
}

/// A line of points.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// x and y; what is not finite is left out.
    pub points: Vec<[f64; 2]>,
}

/// How points are marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marks {
    /// Dots, joined by a line.
    Line,
    /// Columns of width 1 that stand on zero.
    Columns,
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Plot {
    /// What it shows.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// The lines; at most eight have a colour of their own.
    pub lines: Vec<Line>,
    /// How their points are marked.
    pub marks: Marks,
}

const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 320.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 52.0;
/// Colours of the page's style.
const COLOURS: usize = 8;
/// A logarithmic axis with at most so many different values is ticked at them.
const FEW: usize = 8;

impl Plot {
    /// The plot as an `<svg>` element with its legend.
    pub(super) fn svg(&self) -> String {
        let across = Scale::of(
            &self.x,
            self.values(0),
            [LEFT, WIDTH - RIGHT],
            self.margin(0),
        );
        let up = Scale::of(
            &self.y,
            self.values(1),
            [HEIGHT - BOTTOM, TOP],
            self.margin(1),
        );
        let mut svg = format!(
            "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">",
            escape(&self.title)
        );
        self.axes(&mut svg, &across, &up);
        for (k, line) in self.lines.iter().enumerate() {
            let points = line.points.iter().filter_map(|&[x, y]| {
                let place = [across.place(x)?, up.place(y)?];
                Some(place)
            });
            let points: Vec<[f64; 2]> = points.collect();
            match self.marks {
                Marks::Line => dots(&mut svg, k % COLOURS, &points),
                Marks::Columns => columns(&mut svg, k % COLOURS, &points, across.unit()),
            }
        }
        svg.push_str("</svg>");
        svg + &legend(self.lines.iter().map(|line| line.name.as_str()))
    }

    fn values(&self, k: usize) -> Vec<f64> {
        let points = self.lines.iter().flat_map(|line| &line.points);
        points.map(|p| p[k]).collect()
    }

    /// Room on both sides of the values: half a column beside the first and the last; linear heights begin at zero.
    fn margin(&self, k: usize) -> Margin {
        match (self.marks, k) {
            (Marks::Columns, 0) => Margin::Half,
            (_, 1) => Margin::Zero,
            _ => Margin::None,
        }
    }

    fn axes(&self, svg: &mut String, across: &Scale, up: &Scale) {
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        for (value, x) in across.ticks() {
            let _ = write!(svg, "<path class=\"grid\" d=\"M{x:.1} {TOP}V{bottom}\"/>");
            text(svg, "middle", x, bottom + 16.0, &number(value), "number");
        }
        for (value, y) in up.ticks() {
            let _ = write!(svg, "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{right}\"/>");
            text(svg, "end", LEFT - 8.0, y, &number(value), "number");
        }
        let middle = (LEFT + right) / 2.0;
        text(
            svg,
            "middle",
            middle,
            HEIGHT - 12.0,
            &escape(&self.x.name),
            "name",
        );
        let _ = write!(
            svg,
            "<text class=\"name\" transform=\"translate(14 {:.1}) rotate(-90)\" text-anchor=\"middle\" \
             dominant-baseline=\"central\">{}</text>",
            (TOP + bottom) / 2.0,
            escape(&self.y.name)
        );
    }
}

fn dots(svg: &mut String, colour: usize, points: &[[f64; 2]]) {
    let path: Vec<String> = points
        .iter()
        .map(|[x, y]| format!("{x:.1},{y:.1}"))
        .collect();
    let _ = write!(
        svg,
        "<polyline class=\"line s{colour}\" points=\"{}\"/>",
        path.join(" ")
    );
    for [x, y] in points {
        let _ = write!(
            svg,
            "<circle class=\"s{colour}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.4\"/>"
        );
    }
}

fn columns(svg: &mut String, colour: usize, points: &[[f64; 2]], unit: f64) {
    let (foot, width) = (HEIGHT - BOTTOM, (unit * 0.86).max(0.5));
    for [x, y] in points {
        let (left, height) = (x - width / 2.0, (foot - y).max(0.0));
        let _ = write!(
            svg,
            "<rect class=\"s{colour}\" x=\"{left:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
    }
}

enum Margin {
    None,
    /// Half a unit on both sides.
    Half,
    /// Down to zero.
    Zero,
}

/// From values to places.
struct Scale {
    log: bool,
    /// The values (their logarithms) at the two ends.
    from: f64,
    to: f64,
    ends: [f64; 2],
    /// Values to tick, where they are few.
    few: Vec<f64>,
}

impl Scale {
    fn of(axis: &Axis, mut values: Vec<f64>, ends: [f64; 2], margin: Margin) -> Self {
        values.retain(|v| v.is_finite() && (!axis.log || *v > 0.0));
        values.sort_by(f64::total_cmp);
        values.dedup();
        let (mut from, mut to) = match (values.first(), values.last()) {
            (Some(&from), Some(&to)) => (from, to),
            _ => (1.0, 1.0),
        };
        match margin {
            Margin::Half => (from, to) = (from - 0.5, to + 0.5),
            Margin::Zero if !axis.log => from = from.min(0.0),
            _ => {}
        }
        if axis.log {
            (from, to) = (from.log10(), to.log10());
        }
        if to <= from {
            (from, to) = (from - 0.5, from + 0.5);
        }
        if matches!(margin, Margin::Zero) {
            // A little air over the highest value, and under the lowest of a logarithmic axis.
            let air = (to - from) * 0.06;
            (from, to) = (if axis.log { from - air } else { from }, to + air);
        }
        let few = axis.log && values.len() <= FEW && matches!(margin, Margin::None);
        Scale {
            log: axis.log,
            from,
            to,
            ends,
            few: if few { values } else { Vec::new() },
        }
    }

    fn place(&self, value: f64) -> Option<f64> {
        let v = if self.log { value.log10() } else { value };
        let share = (v - self.from) / (self.to - self.from);
        let [begin, end] = self.ends;
        v.is_finite().then_some(begin + share * (end - begin))
    }

    /// How far apart two values are that differ by 1 (on a linear axis).
    fn unit(&self) -> f64 {
        (self.ends[1] - self.ends[0]).abs() / (self.to - self.from)
    }

    /// Values and where they lie.
    fn ticks(&self) -> Vec<(f64, f64)> {
        let values = if !self.few.is_empty() {
            self.few.clone()
        } else if self.log {
            self.decades()
        } else {
            self.steps()
        };
        let inside = |v: &f64| {
            let at = if self.log { v.log10() } else { *v };
            at >= self.from - 1e-9 && at <= self.to + 1e-9
        };
        let placed = values.into_iter().filter(inside);
        placed.filter_map(|v| Some((v, self.place(v)?))).collect()
    }

    /// 1, 2, 5 times powers of ten; powers alone where that would be many.
    fn decades(&self) -> Vec<f64> {
        let (low, high) = (self.from.floor() as i32, self.to.ceil() as i32);
        let within: &[f64] = if high - low > 4 {
            &[1.0]
        } else {
            &[1.0, 2.0, 5.0]
        };
        (low..=high)
            .flat_map(|e| within.iter().map(move |m| m * 10f64.powi(e)))
            .collect()
    }

    /// Multiples of 1, 2 or 5 times a power of ten, about six of them.
    fn steps(&self) -> Vec<f64> {
        let raw = (self.to - self.from) / 6.0;
        let power = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|m| m * power)
            .into_iter()
            .find(|&s| s >= raw)
            .unwrap_or(raw);
        let first = (self.from / step).ceil() as i64;
        let last = (self.to / step).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }
}

/// A tick's label.
fn number(value: f64) -> String {
    let size = value.abs();
    if size >= 1e6 {
        format!("{:.0}M", value / 1e6)
    } else if size >= 1e4 {
        format!("{:.0}k", value / 1e3)
    } else if size == 0.0 || size >= 1.0 && value.fract() == 0.0 {
        format!("{value:.0}")
    } else {
        let text = format!("{value:.3}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(log: bool, points: Vec<[f64; 2]>, marks: Marks) -> Plot {
        let axis = |name: &str| Axis {
            name: name.into(),
            log,
        };
        Plot {
            title: "t".into(),
            x: axis("x < 1"),
            y: axis("y"),
            lines: vec![Line {
                name: "l".into(),
                points,
            }],
            marks,
        }
    }

    fn numbers(svg: &str, attribute: &str) -> Vec<f64> {
        let opening = format!(" {attribute}=\"");
        svg.split(&opening)
            .skip(1)
            .filter_map(|p| p.split('"').next()?.parse().ok())
            .collect()
    }

    #[test]
    fn equal_ratios_are_equal_distances_on_a_logarithmic_axis() {
        let points = vec![[128.0, 1.0], [256.0, 10.0], [512.0, 100.0]];
        let svg = plot(true, points, Marks::Line).svg();
        let (x, y) = (numbers(&svg, "cx"), numbers(&svg, "cy"));
        assert!(((x[1] - x[0]) - (x[2] - x[1])).abs() < 0.2);
        assert!(((y[0] - y[1]) - (y[1] - y[2])).abs() < 0.2 && y[0] > y[2]);
        assert!(svg.contains(">128<") && svg.contains(">512<") && svg.contains("x &lt; 1"));
    }

    #[test]
    fn columns_are_as_high_as_their_values() {
        let svg = plot(
            false,
            vec![[0.0, 10.0], [1.0, 20.0], [2.0, 0.0]],
            Marks::Columns,
        )
        .svg();
        let heights: Vec<f64> = numbers(&svg, "height");
        assert!(
            (heights[1] - 2.0 * heights[0]).abs() < 0.2 && heights[2] == 0.0,
            "{heights:?}"
        );
    }

    #[test]
    fn nothing_and_nonsense_still_draw() {
        for log in [false, true] {
            for points in [
                vec![],
                vec![[1.0, 1.0]],
                vec![[f64::NAN, 1.0], [0.0, -3.0], [2.0, f64::INFINITY]],
            ] {
                for marks in [Marks::Line, Marks::Columns] {
                    let svg = plot(log, points.clone(), marks).svg();
                    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
                }
            }
        }
    }
}
