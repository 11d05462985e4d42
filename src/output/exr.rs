//! OpenEXR: linear float colour, and on request what lies under each pixel as named layers.
//!
//! In: pixels, top row first. Out: the file's bytes (one part, ZIP, 32-bit float; textures on request 16-bit). Layers follow
//! OpenEXR's naming, `layer.channel`, which every reader groups: `R G B A`, `triangle.id`, `barycentric.x .y .z`,
//! `fetches.count`, `depth.Z`. Background pixels hold -1 in `triangle.id` and 0 in the others. A correspondence
//! ([`encode_exr_mapping`]) has whole numbers (UINT) in `triangle.id`, 2^32 - 1 where there is none.

use std::io::Cursor;

use ::exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    SmallVec, WritableImage, f16,
};

use crate::{Error, Result};

/// What lies under each pixel. Each slice has one element per pixel.
#[derive(Clone, Copy, Debug)]
pub struct Aov<'a> {
    /// Triangle of the reference mesh, or `u32::MAX` where nothing is drawn.
    pub triangle: &'a [u32],
    /// Barycentric coordinates in that triangle.
    pub barycentric: &'a [[f32; 3]],
    /// Table fetches the correspondence took.
    pub fetches: &'a [u32],
    /// Depth in clip space, 0 (near) to 1 (far).
    pub depth: &'a [f32],
}

/// The largest integer up to which every integer is a float.
const LARGEST_EXACT: u32 = 1 << 24;

/// Encodes linear `rgba` and, when given, the layers of `aov`.
///
/// # Errors
/// [`Error::Capacity`] when a slice is not `width * height` long, a side is zero, or a triangle id is too large to
/// be a float exactly (2^24).
pub fn encode_exr(width: u32, height: u32, rgba: &[[f32; 4]], aov: Option<Aov>) -> Result<Vec<u8>> {
    let pixels = width as usize * height as usize;
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (name, k) in [("R", 0), ("G", 1), ("B", 2), ("A", 3)] {
        channels.push(channel(name, pixels, rgba.iter().map(|p| p[k]))?);
    }
    if let Some(aov) = aov {
        let id = |&t: &u32| if t == u32::MAX { -1.0 } else { t as f32 };
        if let Some(&large) = aov
            .triangle
            .iter()
            .find(|&&t| t != u32::MAX && t > LARGEST_EXACT)
        {
            return Err(capacity(
                "triangle ids in an EXR's floats",
                large.into(),
                LARGEST_EXACT.into(),
            ));
        }
        channels.push(channel("triangle.id", pixels, aov.triangle.iter().map(id))?);
        for (name, k) in [
            ("barycentric.x", 0),
            ("barycentric.y", 1),
            ("barycentric.z", 2),
        ] {
            channels.push(channel(name, pixels, aov.barycentric.iter().map(|b| b[k]))?);
        }
        channels.push(channel(
            "fetches.count",
            pixels,
            aov.fetches.iter().map(|&n| n as f32),
        )?);
        channels.push(channel("depth.Z", pixels, aov.depth.iter().copied())?);
    }
    encode((width, height), channels)
}

/// Encodes linear `rgba` in 16-bit floats; what they do not hold (above 65504) becomes infinite.
///
/// # Errors
/// As [`encode_exr`].
pub fn encode_exr_half(width: u32, height: u32, rgba: &[[f32; 4]]) -> Result<Vec<u8>> {
    let pixels = width as usize * height as usize;
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (name, k) in [("R", 0), ("G", 1), ("B", 2), ("A", 3)] {
        let values: Vec<f16> = rgba.iter().map(|p| f16::from_f32(p[k])).collect();
        whole(name, pixels, values.len())?;
        channels.push(AnyChannel::new(name, FlatSamples::F16(values)));
    }
    encode((width, height), channels)
}

/// Encodes which point each pixel stands for: the numbers of triangles exactly, whatever they are, `u32::MAX` where there is
/// none, and the barycentrics of their corners.
///
/// # Errors
/// [`Error::Capacity`] when a slice is not `width * height` long or a side is zero.
pub fn encode_exr_mapping(
    width: u32,
    height: u32,
    triangle: &[u32],
    barycentric: &[[f32; 3]],
) -> Result<Vec<u8>> {
    let pixels = width as usize * height as usize;
    whole("triangle.id", pixels, triangle.len())?;
    let numbers = FlatSamples::U32(triangle.to_vec());
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    channels.push(AnyChannel::new("triangle.id", numbers));
    for (name, k) in [
        ("barycentric.x", 0),
        ("barycentric.y", 1),
        ("barycentric.z", 2),
    ] {
        channels.push(channel(name, pixels, barycentric.iter().map(|b| b[k]))?);
    }
    encode((width, height), channels)
}

fn encode(
    (width, height): (u32, u32),
    channels: SmallVec<[AnyChannel<FlatSamples>; 4]>,
) -> Result<Vec<u8>> {
    let encoding = Encoding {
        compression: Compression::ZIP16,
        ..Encoding::default()
    };
    let size = (width as usize, height as usize);
    let layer = Layer::new(
        size,
        LayerAttributes::default(),
        encoding,
        AnyChannels::sort(channels),
    );
    let mut bytes = Vec::new();
    Image::from_layer(layer)
        .write()
        .to_unbuffered(Cursor::new(&mut bytes))
        .map_err(|error| Error::input("exr", format!("{width} x {height}"), error.to_string()))?;
    Ok(bytes)
}

fn channel(
    name: &str,
    pixels: usize,
    values: impl ExactSizeIterator<Item = f32>,
) -> Result<AnyChannel<FlatSamples>> {
    whole(name, pixels, values.len())?;
    Ok(AnyChannel::new(name, FlatSamples::F32(values.collect())))
}

/// Refuses a channel that is empty or has another length.
fn whole(name: &str, pixels: usize, have: usize) -> Result<()> {
    if pixels == 0 || have != pixels {
        let what = format!("pixels of channel {name}");
        return Err(capacity(&what, pixels as u64, have as u64));
    }
    Ok(())
}

fn capacity(what: &str, need: u64, have: u64) -> Error {
    Error::Capacity {
        what: what.to_owned(),
        need,
        have,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::prelude::{AnyChannel, ReadChannels, ReadLayers, read};

    fn channels(bytes: &[u8]) -> Vec<AnyChannel<FlatSamples>> {
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .unwrap();
        image.layer_data.channel_data.list.into_vec()
    }

    fn read_back(bytes: &[u8]) -> Vec<(String, Vec<f32>)> {
        let values = |c: AnyChannel<FlatSamples>| {
            (c.name.to_string(), c.sample_data.values_as_f32().collect())
        };
        channels(bytes).into_iter().map(values).collect()
    }

    #[test]
    fn layers_come_back_by_name_with_their_values() {
        let rgba: Vec<[f32; 4]> = (0..6)
            .map(|i| [i as f32 * 0.1, 0.5, 1.5, (i % 2) as f32])
            .collect();
        let aov = Aov {
            triangle: &[0, 1, u32::MAX, 3, 1 << 24, 5],
            barycentric: &[[0.25, 0.25, 0.5]; 6],
            fetches: &[1, 2, 3, 4, 5, 6],
            depth: &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5],
        };
        let bytes = encode_exr(3, 2, &rgba, Some(aov)).unwrap();
        assert_eq!(bytes, encode_exr(3, 2, &rgba, Some(aov)).unwrap());
        let channels = read_back(&bytes);
        let get = |name: &str| {
            &channels
                .iter()
                .find(|c| c.0 == name)
                .unwrap_or_else(|| panic!("no {name}"))
                .1
        };
        assert_eq!(get("R"), &rgba.iter().map(|p| p[0]).collect::<Vec<_>>());
        assert_eq!(get("triangle.id"), &[0.0, 1.0, -1.0, 3.0, 16777216.0, 5.0]);
        assert_eq!(get("barycentric.z"), &[0.5; 6]);
        assert_eq!(get("fetches.count"), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(get("depth.Z"), aov.depth);
        assert_eq!(read_back(&encode_exr(3, 2, &rgba, None).unwrap()).len(), 4);
    }

    #[test]
    fn numbers_of_triangles_are_whole_however_large() {
        let (ids, b) = ([0, (1 << 24) + 1, u32::MAX], [[0.5, 0.25, 0.25]; 3]);
        let bytes = encode_exr_mapping(3, 1, &ids, &b).unwrap();
        let list = channels(&bytes);
        let of = |name: &str| list.iter().find(|c| c.name == *name).unwrap();
        let FlatSamples::U32(numbers) = &of("triangle.id").sample_data else {
            panic!("no UINT channel")
        };
        assert_eq!(numbers.as_slice(), ids);
        assert!(
            of("barycentric.y")
                .sample_data
                .values_as_f32()
                .eq([0.25; 3])
        );
        assert!(encode_exr_mapping(3, 1, &ids[1..], &b).is_err());
    }

    #[test]
    fn halves_are_the_nearest_there_are() {
        let rgba = [[0.1, -2.5, 70000.0, 1.0]];
        let bytes = encode_exr_half(1, 1, &rgba).unwrap();
        let get = |name: &str| {
            let all = read_back(&bytes);
            all.iter().find(|c| c.0 == name).unwrap().1[0]
        };
        assert!((get("R") - 0.1).abs() < 0.1 / 2048.0 && get("R") != 0.1);
        assert_eq!((get("G"), get("B"), get("A")), (-2.5, f32::INFINITY, 1.0));
        assert!(bytes.len() < encode_exr(1, 1, &rgba, None).unwrap().len());
        assert!(encode_exr_half(2, 1, &rgba).is_err());
    }

    #[test]
    fn ids_that_floats_would_blur_and_wrong_sizes_are_refused() {
        let aov = Aov {
            triangle: &[(1 << 24) + 1],
            barycentric: &[[0.0; 3]],
            fetches: &[0],
            depth: &[0.0],
        };
        assert!(encode_exr(1, 1, &[[0.0; 4]], Some(aov)).is_err());
        assert!(encode_exr(2, 1, &[[0.0; 4]], None).is_err());
        assert!(encode_exr(0, 1, &[], None).is_err());
    }
}
