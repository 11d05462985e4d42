//! The report's HTML.
//!
//! In: a [`Report`]. Out: the text of one HTML file. Every text from outside is escaped; pictures are embedded once.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::{Level, Report, Shot, Table};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The report as HTML.
pub fn render(report: &Report) -> String {
    let mut html = String::new();
    let _ = write!(
        html,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{0}</title>\n<style>\n{STYLE}</style>\n</head>\n\
         <body>\n<header>\n<h1>{0}</h1>\n<p class=\"lead\">{1}</p>\n{2}</header>\n<main>\n",
        escape(&report.title),
        escape(&report.lead),
        facts(&report.facts, "facts"),
    );
    html.push_str(&showcase(report));
    for (k, level) in report.levels.iter().enumerate() {
        html.push_str(&section(level, k, k == report.showcase));
    }
    if !report.charts.is_empty() {
        html.push_str("<section>\n<h2>In bars</h2>\n<div class=\"charts\">\n");
        for chart in &report.charts {
            let _ = writeln!(
                html,
                "<figure><h3>{}</h3>{}</figure>",
                escape(&chart.title),
                chart.svg()
            );
        }
        html.push_str("</div>\n</section>\n");
    }
    if !report.tables.is_empty() {
        html.push_str("<section>\n<h2>In numbers</h2>\n");
        html.extend(report.tables.iter().map(table));
        html.push_str("</section>\n");
    }
    let _ = write!(
        html,
        "</main>\n<footer>{}</footer>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        escape(&report.footer)
    );
    html
}

/// Reference, inverse texture, plain: the page's first picture. The level's own section does not repeat its two.
fn showcase(report: &Report) -> String {
    let mut html = String::from("<section class=\"showcase\">\n<div class=\"row three\">\n");
    html.push_str(&figure(&report.reference, "reference"));
    if let Some(level) = report.levels.get(report.showcase) {
        html.push_str(&figure(
            &level.inverse,
            &format!("inverse-{}", report.showcase),
        ));
        html.push_str(&figure(&level.plain, &format!("plain-{}", report.showcase)));
    }
    html.push_str("</div>\n</section>\n");
    html
}

fn section(level: &Level, index: usize, shown_above: bool) -> String {
    let mut html = format!(
        "<section class=\"level\">\n<h2>{}</h2>\n",
        escape(&level.name)
    );
    html.push_str(&facts(&level.numbers, "numbers"));
    // Filled by the script: a slider over pictures that are on the page anyway.
    let _ = writeln!(
        html,
        "<div class=\"slider\" data-level=\"{index}\" hidden></div>"
    );
    html.push_str("<div class=\"row pictures\">\n");
    if !shown_above {
        html.push_str(&figure(&level.inverse, &format!("inverse-{index}")));
        html.push_str(&figure(&level.plain, &format!("plain-{index}")));
    }
    for (k, shot) in level.others.iter().enumerate() {
        html.push_str(&figure(shot, &format!("other-{index}-{k}")));
    }
    html.push_str("</div>\n</section>\n");
    html
}

fn figure(shot: &Shot, id: &str) -> String {
    let caption = escape(&shot.caption);
    let data = BASE64_STANDARD.encode(&shot.png);
    format!(
        "<figure><div class=\"stage\"><img id=\"{id}\" alt=\"{caption}\" src=\"data:image/png;base64,{data}\"></div>\
         <figcaption>{caption}</figcaption></figure>\n"
    )
}

fn facts(pairs: &[(String, String)], class: &str) -> String {
    if pairs.is_empty() {
        return String::new();
    }
    let item = |(label, value): &(String, String)| {
        format!(
            "<div><dt>{}</dt><dd>{}</dd></div>",
            escape(label),
            escape(value)
        )
    };
    format!(
        "<dl class=\"{class}\">{}</dl>\n",
        pairs.iter().map(item).collect::<String>()
    )
}

fn table(table: &Table) -> String {
    let cells = |tag: &str, row: &[String]| -> String {
        row.iter()
            .map(|cell| format!("<{tag}>{}</{tag}>", escape(cell)))
            .collect()
    };
    let rows: String = table
        .rows
        .iter()
        .map(|row| match row.split_first() {
            Some((name, rest)) => {
                format!(
                    "<tr><th scope=\"row\">{}</th>{}</tr>\n",
                    escape(name),
                    cells("td", rest)
                )
            }
            None => String::new(),
        })
        .collect();
    format!(
        "<div class=\"scroll\"><table><caption>{}</caption>\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
        escape(&table.title),
        cells("th", &table.columns)
    )
}

/// `text` with HTML's special characters replaced; safe as content and inside double quotes.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::{BarChart, Series};
    use super::*;

    fn shot(caption: &str) -> Shot {
        Shot {
            caption: caption.into(),
            png: crate::output::encode_png(2, 2, &[90; 16]).unwrap(),
        }
    }

    fn report() -> Report {
        let level = |name: &str| Level {
            name: name.into(),
            inverse: shot("inverse"),
            plain: shot("plain"),
            others: vec![shot("wireframe")],
            numbers: vec![("triangles".into(), "12".into())],
        };
        Report {
            title: "A <script>alert(1)</script> model".into(),
            lead: "x & y".into(),
            facts: vec![("primary".into(), "sphere".into())],
            reference: shot("reference"),
            showcase: 1,
            levels: vec![level("LoD 1"), level("LoD 2")],
            charts: vec![BarChart {
                title: "FLIP".into(),
                categories: vec!["LoD 1".into()],
                series: vec![Series {
                    name: "inverse".into(),
                    values: vec![0.1],
                }],
                digits: 3,
            }],
            tables: vec![Table {
                title: "t".into(),
                columns: vec!["a".into()],
                rows: vec![vec!["1".into()]],
            }],
            footer: "f".into(),
        }
    }

    #[test]
    fn one_file_without_network_and_with_every_picture_once() {
        let html = render(&report());
        assert_eq!(
            html.matches("src=\"data:image/png;base64,").count(),
            1 + 2 * 3
        );
        // An address in the page would be a request when it is opened.
        for outside in ["http:", "https:", "src=\"/", "@import", "url(", "<link"] {
            assert!(!html.contains(outside), "{outside}");
        }
    }

    #[test]
    fn text_from_files_cannot_become_markup() {
        let html = render(&report());
        assert!(!html.contains("<script>alert"));
        assert!(html.contains("A &lt;script&gt;alert(1)&lt;/script&gt; model"));
    }

    #[test]
    fn a_report_without_levels_is_a_page() {
        let mut empty = report();
        empty.levels.clear();
        assert!(render(&empty).ends_with("</html>\n"));
    }
}
