//! The report's HTML.
//!
//! In: a [`Report`]. Out: the text of one HTML file. Every text from outside is escaped; pictures are embedded once.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::{BarChart, Chart, Level, Page, Report, Section, Shot, Table};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The report as HTML.
pub fn render(report: &Report) -> String {
    let mut html = head(&report.title, &report.lead, &report.facts);
    html.push_str(&showcase(report));
    for (k, level) in report.levels.iter().enumerate() {
        html.push_str(&section(level, k, k == report.showcase));
    }
    if !report.charts.is_empty() {
        html.push_str("<section>\n<h2>In bars</h2>\n");
        html.push_str(&charts(report.charts.iter().map(bars)));
        html.push_str("</section>\n");
    }
    if !report.tables.is_empty() {
        html.push_str("<section>\n<h2>In numbers</h2>\n");
        html.extend(report.tables.iter().map(table));
        html.push_str("</section>\n");
    }
    html + &foot(&report.footer, SCRIPT)
}

/// The page as HTML. It has no script.
pub fn render_page(page: &Page) -> String {
    let mut html = head(&page.title, &page.lead, &page.facts);
    html.extend(
        page.sections
            .iter()
            .enumerate()
            .map(|(k, s)| plain_section(s, k)),
    );
    html + &foot(&page.footer, "")
}

fn head(title: &str, lead: &str, row: &[(String, String)]) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{0}</title>\n<style>\n{STYLE}</style>\n</head>\n\
         <body>\n<header>\n<h1>{0}</h1>\n<p class=\"lead\">{1}</p>\n{2}</header>\n<main>\n",
        escape(title),
        escape(lead),
        facts(row, "facts"),
    )
}

fn foot(text: &str, script: &str) -> String {
    let mut html = format!("</main>\n<footer>{}</footer>\n", escape(text));
    if !script.is_empty() {
        let _ = writeln!(html, "<script>\n{script}</script>");
    }
    html + "</body>\n</html>\n"
}

fn plain_section(section: &Section, index: usize) -> String {
    let mut html = format!("<section>\n<h2>{}</h2>\n", escape(&section.heading));
    if !section.text.is_empty() {
        let _ = writeln!(html, "<p class=\"lead\">{}</p>", escape(&section.text));
    }
    if !section.shots.is_empty() {
        html.push_str("<div class=\"row wide\">\n");
        let shots = section.shots.iter().enumerate();
        html.extend(shots.map(|(k, shot)| figure(shot, &format!("shot-{index}-{k}"))));
        html.push_str("</div>\n");
    }
    if !section.charts.is_empty() {
        html.push_str(&charts(section.charts.iter().map(|chart| match chart {
            Chart::Bars(chart) => bars(chart),
            Chart::Plot(plot) => (plot.title.as_str(), plot.svg()),
        })));
    }
    html.extend(section.tables.iter().map(table));
    html + "</section>\n"
}

fn bars(chart: &BarChart) -> (&str, String) {
    (&chart.title, chart.svg())
}

/// Charts side by side, each a title and its SVG.
fn charts<'a>(charts: impl Iterator<Item = (&'a str, String)>) -> String {
    let figure = |(title, svg)| format!("<figure><h3>{}</h3>{svg}</figure>\n", escape(title));
    format!(
        "<div class=\"charts\">\n{}</div>\n",
        charts.map(figure).collect::<String>()
    )
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
    // A table of many columns is set narrower.
    let class = if table.columns.len() > 10 {
        " many"
    } else {
        ""
    };
    format!(
        "<div class=\"scroll{class}\"><table><caption>{}</caption>\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
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
    fn a_page_has_its_sections_and_no_script() {
        let page = Page {
            title: "t".into(),
            lead: "l".into(),
            facts: vec![],
            sections: vec![Section {
                heading: "one < two".into(),
                shots: vec![shot("heat")],
                ..Section::default()
            }],
            footer: "f".into(),
        };
        let html = render_page(&page);
        assert!(html.contains("one &lt; two") && html.contains("id=\"shot-0-0\""));
        assert!(!html.contains("<script") && html.ends_with("</html>\n"));
    }

    #[test]
    fn a_report_without_levels_is_a_page() {
        let mut empty = report();
        empty.levels.clear();
        assert!(render(&empty).ends_with("</html>\n"));
    }
}
