//! Points of texture space from CSV.
//!
//! In: bytes of a file and the primary they are points of. Out: T3 coordinates, or an error that names the line.

use std::io::Read;

use invertex::param::Primary;
use invertex::{Error, Result};

/// All of standard input.
pub(super) fn standard_input() -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::io::stdin()
        .lock()
        .read_to_end(&mut bytes)
        .map_err(|source| Error::io("standard input", source))?;
    Ok(bytes)
}

/// Reads points: two or three numbers a line, as the primary wants them.
pub(super) fn parse(file: &str, bytes: &[u8], primary: &Primary) -> Result<Vec<[f64; 3]>> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let mut points = Vec::new();
    for (k, record) in reader.records().enumerate() {
        let record = record.map_err(|error| {
            let line = error.position().map_or(0, csv::Position::line);
            Error::input(file, format!("line {line}"), "is not text in CSV")
        })?;
        let line = record.position().map_or(0, csv::Position::line);
        let blank = record.iter().all(str::is_empty);
        let names = k == 0 && record.iter().all(|field| field.parse::<f64>().is_err());
        if !blank && !names {
            let point = point(&record, primary)
                .map_err(|reason| Error::input(file, format!("line {line}"), reason))?;
            points.push(point);
        }
    }
    Ok(points)
}

fn point(record: &csv::StringRecord, primary: &Primary) -> std::result::Result<[f64; 3], String> {
    let numbers = record
        .iter()
        .map(|field| match field.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(format!("{field:?} is not a finite number")),
        })
        .collect::<std::result::Result<Vec<f64>, String>>()?;
    match (primary.kind, numbers.as_slice()) {
        (kind, &[u, v]) if kind.has_charts() => Ok([u, v, 0.0]),
        (kind, &[u, v, 0.0]) if kind.has_charts() => Ok([u, v, 0.0]),
        (kind, _) if kind.has_charts() => {
            Err(format!("holds {} numbers; {kind} wants u,v", numbers.len()))
        }
        (_, &[x, y, z]) => Ok(primary.t3_of_position([x, y, z])),
        (kind, _) => Err(format!(
            "holds {} numbers; {kind} wants x,y,z",
            numbers.len()
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use invertex::param::grid::Frame;
    use invertex::param::{Axis, PrimaryKind};

    fn read(text: &str, kind: PrimaryKind) -> Result<Vec<[f64; 3]>> {
        let primary = Primary {
            kind,
            frame: Frame {
                origin: [0.0; 3],
                scale: 1.0,
            },
        };
        parse("f", text.as_bytes(), &primary)
    }

    #[test]
    fn names_comments_blanks_and_spaces_are_skipped() {
        let text = "u,v\n# a remark\n\n 0.5 , 0.25\r\n1e-3,-2\n , \n";
        assert_eq!(
            read(text, PrimaryKind::UvSet(0)).unwrap(),
            [[0.5, 0.25, 0.0], [1e-3, -2.0, 0.0]]
        );
        let about_x = PrimaryKind::Cylinder(Axis::X);
        assert_eq!(
            read("1,2,3", about_x).unwrap(),
            [Axis::X.to_third([1.0, 2.0, 3.0])]
        );
    }

    #[test]
    fn a_bad_line_is_named() {
        for text in [
            "0,1\n0,x\n",
            "0,1\n0\n",
            "0,1\n0,1,2\n",
            "0,1\n0,nan\n",
            "0,1\n0,inf\n",
            "0,1\nu,v\n",
        ] {
            let error = read(text, PrimaryKind::UvSet(0)).unwrap_err();
            assert!(error.to_string().contains("line 2"), "{error}");
            assert_eq!(error.exit_code(), 3);
        }
        assert!(
            read("0,1", PrimaryKind::Sphere)
                .unwrap_err()
                .to_string()
                .contains("x,y,z")
        );
        assert!(
            parse(
                "f",
                b"0,\xff\n",
                &Primary {
                    kind: PrimaryKind::Sphere,
                    frame: Frame {
                        origin: [0.0; 3],
                        scale: 1.0
                    }
                }
            )
            .is_err()
        );
    }
}
