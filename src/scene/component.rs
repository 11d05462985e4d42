//! Component types of accessors: their sizes, and their values.
//!
//! In: little-endian bytes. Out: numbers. Source: glTF 2.0 specification, sections 3.6.2.2 and 3.6.2.4.

/// The type of a component, by its OpenGL number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    pub(super) fn from_number(number: u32) -> Option<Component> {
        Some(match number {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The value at the start of `bytes` as a float, normalized as glTF 3.6.2.2 says if so asked.
    pub(super) fn float(self, bytes: &[u8], normalized: bool) -> f32 {
        let whole = match self {
            Component::F32 => return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            Component::U32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as f32,
            Component::I8 => f32::from(bytes[0] as i8),
            Component::U8 => f32::from(bytes[0]),
            Component::I16 => f32::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            Component::U16 => f32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        };
        let largest = match self {
            _ if !normalized => return whole,
            Component::I8 => 127.0,
            Component::U8 => 255.0,
            Component::I16 => 32_767.0,
            Component::U16 => 65_535.0,
            Component::U32 | Component::F32 => return whole,
        };
        (whole / largest).max(-1.0)
    }

    /// The value at the start of `bytes` as an unsigned integer; `None` for signed and float types.
    pub(super) fn unsigned(self, bytes: &[u8]) -> Option<u32> {
        match self {
            Component::U8 => Some(bytes[0].into()),
            Component::U16 => Some(u16::from_le_bytes([bytes[0], bytes[1]]).into()),
            Component::U32 => Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
            _ => None,
        }
    }
}

/// Components of an element and its bytes (matrix columns start at multiples of 4 bytes).
pub(super) fn layout(kind: &str, component: Component) -> Option<(usize, usize)> {
    let size = component.size();
    let matrix = |n: usize| (n * n, n * (n * size).next_multiple_of(4));
    Some(match kind {
        "SCALAR" => (1, size),
        "VEC2" => (2, 2 * size),
        "VEC3" => (3, 3 * size),
        "VEC4" => (4, 4 * size),
        "MAT2" => matrix(2),
        "MAT3" => matrix(3),
        "MAT4" => matrix(4),
        _ => return None,
    })
}
