//! The `--camera` file: many views of one model.
//!
//! In: the bytes of a JSON document (untrusted). Out: [`View`]s, each a name for its image and a [`Camera`]. Matrices
//! are row-major; `projection_vulkan` is for clip z 0..1, y down. Members that are not listed here are ignored.

use super::camera::Camera;
use crate::{Error, Result};
use glam::DMat4;
use serde::Deserialize;

/// The most views one file may hold, and the largest file, in bytes.
const MAX_VIEWS: usize = 10_000;
const MAX_BYTES: usize = 64 << 20;

/// One view of a camera file.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// File name of the image, without folders; `view_00.png` and so on where the file gives none.
    pub name: String,
    /// The camera.
    pub camera: Camera,
}

#[derive(Deserialize)]
struct Document {
    width: u32,
    height: u32,
    views: Vec<Entry>,
}

#[derive(Deserialize)]
struct Entry {
    name: Option<String>,
    view: [[f64; 4]; 4],
    projection_vulkan: [[f64; 4]; 4],
}

/// Reads a camera file; `file` names it in errors. `size` overrides the file's own.
pub fn parse_views(file: &str, bytes: &[u8], size: Option<(u32, u32)>) -> Result<Vec<View>> {
    if bytes.len() > MAX_BYTES {
        return Err(Error::Capacity {
            what: format!("{file}: bytes of a camera file"),
            need: bytes.len() as u64,
            have: MAX_BYTES as u64,
        });
    }
    let document: Document =
        serde_json::from_slice(bytes).map_err(|e| Error::input(file, "json", e.to_string()))?;
    if document.views.is_empty() || document.views.len() > MAX_VIEWS {
        let reason = format!(
            "{} views; 1 to {MAX_VIEWS} are allowed",
            document.views.len()
        );
        return Err(Error::input(file, "views", reason));
    }
    let (width, height) = size.unwrap_or((document.width, document.height));
    let mut names = std::collections::HashSet::new();
    document
        .views
        .into_iter()
        .enumerate()
        .map(|(i, entry)| view(file, i, entry, width, height, &mut names))
        .collect()
}

fn view(
    file: &str,
    index: usize,
    entry: Entry,
    width: u32,
    height: u32,
    names: &mut std::collections::HashSet<String>,
) -> Result<View> {
    let element = format!("views[{index}]");
    let name = entry.name.unwrap_or_else(|| format!("view_{index:02}.png"));
    if !plain_file_name(&name) {
        return Err(Error::input(
            file,
            element,
            format!("name {name:?} is not a plain file name"),
        ));
    }
    if !names.insert(name.clone()) {
        return Err(Error::input(
            file,
            element,
            format!("name {name:?} occurs twice"),
        ));
    }
    let camera = Camera::new(
        matrix(&entry.view),
        matrix(&entry.projection_vulkan),
        width,
        height,
    )
    .map_err(|e| Error::input(file, element, e.to_string()))?;
    Ok(View { name, camera })
}

/// A name that stays in its folder on every system.
fn plain_file_name(name: &str) -> bool {
    let safe =
        |c: char| c.is_alphanumeric() || matches!(c, '.' | '_' | '-' | ' ' | '+' | '(' | ')');
    !name.is_empty() && name.len() <= 200 && !name.starts_with('.') && name.chars().all(safe)
}

fn matrix(rows: &[[f64; 4]; 4]) -> DMat4 {
    DMat4::from_cols_array_2d(rows).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: &str = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";

    fn document(name: &str, width: u32) -> String {
        format!(
            r#"{{"width":{width},"height":4,"png":"x","views":[{{{name}"eye":[1,2],"view":{IDENTITY},
            "projection_vulkan":[[2,0,0,5],[0,-1,0,0],[0,0,1,0],[0,0,0,1]]}}]}}"#
        )
    }

    #[test]
    fn rows_are_rows_and_names_are_given() {
        let views = parse_views("f", document("", 8).as_bytes(), None).unwrap();
        assert_eq!(views[0].name, "view_00.png");
        assert_eq!(views[0].camera.projection.w_axis.x, 5.0);
        assert_eq!((views[0].camera.width, views[0].camera.height), (8, 4));
        let sized = parse_views(
            "f",
            document(r#""name":"a b.png","#, 8).as_bytes(),
            Some((3, 2)),
        )
        .unwrap();
        assert_eq!(
            (sized[0].name.as_str(), sized[0].camera.width),
            ("a b.png", 3)
        );
    }

    #[test]
    fn hostile_documents_are_typed_errors() {
        let bad = [
            String::new(),
            "[]".into(),
            "[".repeat(100_000),
            r#"{"width":4,"height":4,"views":[]}"#.into(),
            document("", 0),
            document("", 4_000_000_000),
            document(r#""name":"../x.png","#, 4),
            document(r#""name":"/x.png","#, 4),
            document(r#""name":"","#, 4),
            document(r#""name":"a\u0000b","#, 4),
            document("", 4).replace(IDENTITY, "[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,0]]"),
            document("", 4).replace("[2,0,0,5]", "[1e400,0,0,5]"),
            document("", 4).replace("[2,0,0,5]", "[2,0,0]"),
        ];
        for text in bad {
            let error = parse_views("f", text.as_bytes(), None).unwrap_err();
            assert_eq!(error.exit_code(), 3, "{error}");
        }
    }
}
