//! From SPIR-V types to Rust types of the same bytes. In: a reflected type. Out: its Rust spelling, and the `repr(C)`
//! structs it needs. A layout with holes is refused: explicit padding in GLSL keeps both sides honest.

use spirq::ty::{MatrixAxisOrder, ScalarType, StructType, Type};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A member of a struct: name, byte offset, byte size, Rust type.
#[derive(Clone, PartialEq)]
pub(crate) struct Member {
    pub name: String,
    pub offset: usize,
    pub bytes: usize,
    pub rust: String,
}

/// Structs shared by all shaders, by their GLSL name.
#[derive(Default)]
pub(crate) struct Structs(BTreeMap<String, Vec<Member>>);

impl Structs {
    /// The members of `block`, whose nested structs are taken in. Errors where Rust could not have the same bytes.
    pub(crate) fn members(&mut self, block: &StructType) -> Result<Vec<Member>, String> {
        let owner = block.name.clone().unwrap_or_default();
        let mut members: Vec<Member> = Vec::new();
        let mut end = 0;
        for member in &block.members {
            let name = member
                .name
                .clone()
                .ok_or(format!("{owner} has a member without a name"))?;
            let offset = member
                .offset
                .ok_or(format!("{owner}.{name} has no offset"))?;
            if offset != end {
                return Err(format!(
                    "{owner}.{name} starts at byte {offset}, but the bytes before it end at {end}: pad in GLSL"
                ));
            }
            let (rust, bytes) = self
                .rust_type(&member.ty)
                .map_err(|reason| format!("{owner}.{name}: {reason}"))?;
            end = offset + bytes;
            members.push(Member {
                name,
                offset,
                bytes,
                rust,
            });
        }
        Ok(members)
    }

    /// Takes in the structs that a storage block's array is made of, so that the host can fill it by name.
    pub(crate) fn elements(&mut self, block: &StructType) -> Result<(), String> {
        for member in &block.members {
            let element = match &member.ty {
                Type::Array(array) => &array.element_ty,
                other => other,
            };
            if let Type::Struct(_) = element {
                let (_, bytes) = self.rust_type(element)?;
                if let Type::Array(array) = &member.ty {
                    stride(array.stride, bytes)?;
                }
            }
        }
        Ok(())
    }

    /// Takes a named struct in; two of one name must be one struct.
    pub(crate) fn insert(&mut self, structure: &StructType) -> Result<(String, usize), String> {
        let name = structure.name.clone().ok_or("a struct without a name")?;
        let members = self.members(structure)?;
        let bytes = members
            .last()
            .map_or(0, |member| member.offset + member.bytes);
        match self.0.get(&name) {
            Some(present) if *present != members => {
                Err(format!("two different structs are called {name}"))
            }
            _ => {
                self.0.insert(name.clone(), members);
                Ok((name, bytes))
            }
        }
    }

    /// Rust spelling and size of a type.
    fn rust_type(&mut self, ty: &Type) -> Result<(String, usize), String> {
        match ty {
            Type::Scalar(scalar) => Ok((scalar_type(scalar)?.to_owned(), 4)),
            Type::Vector(vector) => {
                let scalar = scalar_type(&vector.scalar_ty)?;
                Ok((
                    format!("[{scalar}; {}]", vector.nscalar),
                    4 * vector.nscalar as usize,
                ))
            }
            Type::Matrix(matrix) => {
                if matrix.axis_order != Some(MatrixAxisOrder::ColumnMajor) {
                    return Err("a row-major matrix".to_owned());
                }
                let rows = matrix.vector_ty.nscalar;
                stride(matrix.stride, 4 * rows as usize)?;
                let scalar = scalar_type(&matrix.vector_ty.scalar_ty)?;
                Ok((
                    format!("[[{scalar}; {rows}]; {}]", matrix.nvector),
                    4 * (rows * matrix.nvector) as usize,
                ))
            }
            Type::Array(array) => {
                let (element, bytes) = self.rust_type(&array.element_ty)?;
                stride(array.stride, bytes)?;
                let count = array.nelement.ok_or("an array without a length")? as usize;
                Ok((format!("[{element}; {count}]"), bytes * count))
            }
            Type::Struct(structure) => {
                let (name, bytes) = self.insert(structure)?;
                Ok((format!("crate::gpu::shaders::types::{name}"), bytes))
            }
            other => Err(format!("{other} has no place in a block")),
        }
    }

    /// The Rust definitions.
    pub(crate) fn definitions(&self) -> String {
        self.0
            .iter()
            .map(|(name, members)| {
                definition(name, &format!("`struct {name}` of the shaders."), members)
            })
            .collect()
    }
}

fn stride(stride: Option<usize>, bytes: usize) -> Result<(), String> {
    match stride {
        Some(stride) if stride != bytes => Err(format!(
            "elements of {bytes} bytes stand {stride} apart: pad them in GLSL, or use another type"
        )),
        _ => Ok(()),
    }
}

fn scalar_type(scalar: &ScalarType) -> Result<&'static str, String> {
    match scalar {
        ScalarType::Integer {
            bits: 32,
            is_signed: true,
        } => Ok("i32"),
        ScalarType::Integer {
            bits: 32,
            is_signed: false,
        } => Ok("u32"),
        ScalarType::Float { bits: 32 } => Ok("f32"),
        other => Err(format!("{other} is not a 32-bit number")),
    }
}

/// A `repr(C)` struct with its size and offsets asserted against reflection.
pub(crate) fn definition(name: &str, doc: &str, members: &[Member]) -> String {
    let bytes = members
        .last()
        .map_or(0, |member| member.offset + member.bytes);
    let mut fields = String::new();
    let mut asserts = format!("assert!(size_of::<{name}>() == {bytes});");
    for Member {
        name: field,
        offset,
        rust,
        ..
    } in members
    {
        let _ = writeln!(
            fields,
            "    /// At byte {offset}.\n    pub r#{field}: {rust},"
        );
        let _ = write!(
            asserts,
            " assert!(core::mem::offset_of!({name}, r#{field}) == {offset});"
        );
    }
    format!(
        "/// {doc}\n#[repr(C)]\n#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\n\
         pub struct {name} {{\n{fields}}}\nconst _: () = {{ {asserts} }};\n\
         impl Default for {name} {{\n    /// All zero.\n    fn default() -> Self {{ bytemuck::Zeroable::zeroed() }}\n}}\n"
    )
}
