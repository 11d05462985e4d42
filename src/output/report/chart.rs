//! Bar charts as inline SVG.
//!
//! In: named categories and one or more series of values. Out: SVG text that takes its colours from the page's style
//! (so it follows light and dark) and carries each number as text.

use std::fmt::Write;

use super::page::escape;

/// One colour of bars: a name and a value for each category.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// A value for each category; what is not finite or below zero draws no bar.
    pub values: Vec<f64>,
}

/// Horizontal bars, grouped by category.
#[derive(Clone, Debug)]
pub struct BarChart {
    /// What it shows, with the unit.
    pub title: String,
    /// Names of the groups, top to bottom.
    pub categories: Vec<String>,
    /// The bars in each group.
    pub series: Vec<Series>,
    /// Digits after the point in the labels.
    pub digits: usize,
}

const WIDTH: f64 = 520.0;
const LABEL: f64 = 130.0;
const NUMBER: f64 = 80.0;
const BAR: f64 = 18.0;
const GAP: f64 = 14.0;

impl BarChart {
    /// The chart as an `<svg>` element with its legend.
    pub(super) fn svg(&self) -> String {
        let finite = |v: &f64| if v.is_finite() { v.max(0.0) } else { 0.0 };
        let largest = self
            .series
            .iter()
            .flat_map(|s| &s.values)
            .map(finite)
            .fold(0.0, f64::max);
        let scale = if largest > 0.0 {
            (WIDTH - LABEL - NUMBER) / largest
        } else {
            0.0
        };
        let group = BAR * self.series.len() as f64 + GAP;
        let height = group * self.categories.len() as f64;
        let mut svg = format!(
            "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"{}\">",
            escape(&self.title)
        );
        for (row, category) in self.categories.iter().enumerate() {
            let top = row as f64 * group + GAP / 2.0;
            let middle = top + BAR * self.series.len() as f64 / 2.0;
            text(
                &mut svg,
                "end",
                LABEL - 10.0,
                middle,
                &escape(category),
                "name",
            );
            for (k, series) in self.series.iter().enumerate() {
                let value = series.values.get(row).copied().unwrap_or(f64::NAN);
                let (y, width) = (top + k as f64 * BAR, (finite(&value) * scale).max(1.0));
                let _ = write!(
                    svg,
                    "<rect class=\"bar s{k}\" x=\"{LABEL}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"{:.1}\" rx=\"3\"/>",
                    y + 1.0,
                    BAR - 2.0
                );
                let number = if value.is_finite() {
                    format!("{value:.*}", self.digits)
                } else {
                    "–".into()
                };
                text(
                    &mut svg,
                    "start",
                    LABEL + width + 6.0,
                    y + BAR / 2.0,
                    &number,
                    "number",
                );
            }
        }
        svg.push_str("</svg>");
        svg + &self.legend()
    }

    fn legend(&self) -> String {
        legend(self.series.iter().map(|s| s.name.as_str()))
    }
}

/// Names beside the colours of a chart's series; nothing for a single one.
pub(super) fn legend<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    if names.len() < 2 {
        return String::new();
    }
    let item =
        |(k, name): (usize, &str)| format!("<span><i class=\"s{k}\"></i>{}</span>", escape(name));
    format!(
        "<p class=\"legend\">{}</p>",
        names.enumerate().map(item).collect::<String>()
    )
}

pub(super) fn text(svg: &mut String, anchor: &str, x: f64, y: f64, content: &str, class: &str) {
    let _ = write!(
        svg,
        "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" dominant-baseline=\"central\">{content}</text>"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_proportional_and_text_is_escaped() {
        let chart = BarChart {
            title: "a < b".into(),
            categories: vec!["<one>".into(), "two".into()],
            series: vec![Series {
                name: "s".into(),
                values: vec![2.0, 1.0],
            }],
            digits: 1,
        };
        let svg = chart.svg();
        let widths: Vec<f64> = svg
            .split("<rect")
            .skip(1)
            .map(|rect| {
                rect.split("width=\"")
                    .nth(1)
                    .unwrap()
                    .split('"')
                    .next()
                    .unwrap()
                    .parse()
                    .unwrap()
            })
            .collect();
        assert_eq!(widths[0], 2.0 * widths[1]);
        assert!(svg.contains("&lt;one&gt;") && !svg.contains("<one>"));
    }

    #[test]
    fn nothing_and_nonsense_still_draw() {
        let values = vec![f64::NAN, -1.0, f64::INFINITY];
        let categories = vec!["a".into(), "b".into(), "c".into(), "missing".into()];
        let chart = BarChart {
            title: String::new(),
            categories,
            series: vec![Series {
                name: String::new(),
                values,
            }],
            digits: 0,
        };
        let svg = chart.svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
}
