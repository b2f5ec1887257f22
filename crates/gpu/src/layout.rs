//! Host structs against WGSL structs, field by field: no "keep in sync".

use crate::{GpuError, Shader};

/// One field of a `#[repr(C)]` struct shared with WGSL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostField {
    /// Field name, the same in WGSL.
    pub name: &'static str,
    /// Byte offset.
    pub offset: usize,
    /// Byte size.
    pub size: usize,
}

/// A `#[repr(C)]` struct that exists in WGSL under [`Self::WGSL_NAME`] with the same fields at the same offsets.
pub trait HostStruct: bytemuck::Pod {
    /// Name of the struct in WGSL, without its module.
    const WGSL_NAME: &'static str;
    /// All fields, in order; [`host_fields!`](crate::host_fields) lists them.
    const FIELDS: &'static [HostField];

    /// Compares with the struct of that name that `shader` uses.
    ///
    /// # Errors
    /// A message with the first field that differs, or that the shader has no such struct.
    fn check_layout(shader: &Shader, includes: &[Shader]) -> Result<(), GpuError> {
        let module = crate::compose(shader, includes, &[])?;
        compare(&module, Self::WGSL_NAME, Self::FIELDS, size_of::<Self>())
            .map_err(|message| GpuError::Shader { shader: shader.name.to_owned(), message })
    }
}

/// The fields of a host struct with their offsets and sizes.
#[macro_export]
macro_rules! host_fields {
    ($name:ident { $($field:ident),* $(,)? }) => {
        &[$($crate::HostField {
            name: stringify!($field),
            offset: ::core::mem::offset_of!($name, $field),
            size: {
                const fn size_of_field<T, U>(_: fn(&T) -> &U) -> usize { ::core::mem::size_of::<U>() }
                size_of_field(|host: &$name| &host.$field)
            },
        }),*]
    };
}

fn compare(module: &naga::Module, name: &str, fields: &[HostField], host_size: usize) -> Result<(), String> {
    // naga_oil appends a decoration to the names of imported items.
    let is_named = |found: &str| found == name || found.starts_with(&format!("{name}X_naga_oil"));
    let (members, span) = module
        .types
        .iter()
        .find_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, span } if ty.name.as_deref().is_some_and(is_named) => {
                Some((members, *span))
            }
            _ => None,
        })
        .ok_or_else(|| format!("has no struct {name}"))?;
    if members.len() != fields.len() {
        return Err(format!(
            "struct {name} has {} fields in WGSL, {} on the host",
            members.len(),
            fields.len()
        ));
    }
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).map_err(|e| e.to_string())?;
    for (member, field) in members.iter().zip(fields) {
        let wgsl_name = member.name.as_deref().unwrap_or("?");
        let size = layouter[member.ty].size as usize;
        if wgsl_name != field.name || member.offset as usize != field.offset || size != field.size {
            return Err(format!(
                "struct {name}: WGSL has {wgsl_name} at byte {} ({size} bytes), the host has {} at byte {} ({} bytes)",
                member.offset, field.name, field.offset, field.size
            ));
        }
    }
    if span as usize != host_size {
        return Err(format!("struct {name} takes {span} bytes in WGSL, {host_size} on the host"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::role::{KeptRange, Occludee, PackedParticle, StandIn};
    use crate::{CameraUniform, shader};

    const USER: Shader = Shader {
        name: "test/user",
        source: "#import meniscus::camera::{Camera, view_ray}\n#import meniscus::particle::{PackedParticle, KeptRange, Occludee, StandIn, kept}\n\
            @group(0) @binding(0) var<uniform> camera: Camera;\n\
            @group(0) @binding(1) var<storage, read> particles: array<PackedParticle>;\n\
            @group(0) @binding(2) var<storage, read> ranges: array<KeptRange>;\n\
            @group(0) @binding(3) var<storage, read_write> out: array<f32>;\n\
            @group(0) @binding(4) var<storage, read> occludees: array<Occludee>;\n\
            @group(0) @binding(5) var<storage, read> stand_ins: array<StandIn>;\n\
            @compute @workgroup_size(1) fn main() {\n\
              out[1] = occludees[0].front + stand_ins[0].center_world.x;\n\
              out[0] = view_ray(camera, particles[0].position_world.xy).step.x + kept(particles[0].packed, ranges[0].keep, 1.0).weight;\n}",
    };

    #[test]
    fn shared_structs_have_the_same_fields_at_the_same_offsets() {
        CameraUniform::check_layout(&USER, shader::COMMON).unwrap();
        PackedParticle::check_layout(&USER, shader::COMMON).unwrap();
        KeptRange::check_layout(&USER, shader::COMMON).unwrap();
        Occludee::check_layout(&USER, shader::COMMON).unwrap();
        StandIn::check_layout(&USER, shader::COMMON).unwrap();
    }

    #[test]
    fn a_moved_a_missing_and_a_renamed_field_are_found() {
        let module = crate::compose(&USER, shader::COMMON, &[]).unwrap();
        let good = KeptRange::FIELDS;
        let check = |fields: &[HostField], size| compare(&module, "KeptRange", fields, size);
        assert_eq!(check(good, 16), Ok(()));
        assert!(check(&good[..3], 16).unwrap_err().contains("4 fields in WGSL, 3"));
        assert!(check(good, 20).unwrap_err().contains("16 bytes in WGSL, 20"));
        let mut moved = good.to_vec();
        moved[1].offset = 8;
        assert!(check(&moved, 16).unwrap_err().contains("count at byte 4"));
        let mut renamed = good.to_vec();
        renamed[2].name = "kept";
        assert!(check(&renamed, 16).unwrap_err().contains("keep"));
        assert!(compare(&module, "Nothing", good, 16).unwrap_err().contains("no struct"));
    }
}
