//! Typed reads from buffers. They never panic, whatever the input.
//!
//! An accessor (glTF 2.0, section 3.6.2) is `count` elements, `stride` bytes apart, in a view of a buffer.
//! Without a view the elements are zero. A sparse accessor replaces some elements by others.

use std::ops::Range;

use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Index, Root, buffer};

use super::ImportSource;
use crate::fault::invalid_gltf;
use crate::{AssetFault, ImportLimit};

/// Bytes of a buffer that hold an accessor's elements, or its sparse indices or values.
struct Span {
    buffer: usize,
    bytes: Range<usize>,
    stride: usize,
    element: usize,
}

/// Checks that every view lies in its buffer, and every accessor in its view.
pub fn check(root: &Root) -> Result<(), AssetFault> {
    for (index, view) in root.buffer_views.iter().enumerate() {
        let end = view.byte_offset.unwrap_or_default().0.checked_add(view.byte_length.0);
        let length = root.get(view.buffer).map_or(0, |b| b.byte_length.0);
        if end.is_none_or(|end| end > length) {
            return Err(invalid_gltf(format!("buffer view {index} reaches past the end of its buffer")));
        }
    }
    for (index, accessor) in root.accessors.iter().enumerate() {
        layout(root, accessor).map_err(|why| invalid_gltf(format!("accessor {index} {why}")))?;
    }
    Ok(())
}

/// Bytes that hold an accessor's elements, and those that hold its sparse indices and values.
#[derive(Default)]
struct Layout {
    dense: Option<Span>,
    sparse: Option<(Span, Span)>,
}

fn layout(root: &Root, accessor: &Accessor) -> Result<Layout, &'static str> {
    let element = component_type(accessor).size() * components(accessor);
    let offset = accessor.byte_offset.unwrap_or_default();
    let count = accessor.count;
    if count.0 == 0 {
        return Err("has no elements");
    }
    let dense = accessor.buffer_view.map(|view| span(root, view, offset, count, element)).transpose()?;
    let Some(sparse) = &accessor.sparse else { return Ok(Layout { dense, sparse: None }) };
    if sparse.count.0 == 0 || sparse.count.0 > count.0 {
        return Err("replaces none or more elements than it has");
    }
    let Checked::Valid(index_type) = sparse.indices.component_type else { return Err("has unknown indices") };
    let (indices, values) = (&sparse.indices, &sparse.values);
    let indices = span(root, indices.buffer_view, indices.byte_offset, sparse.count, index_type.0.size())?;
    let values = span(root, values.buffer_view, values.byte_offset, sparse.count, element)?;
    Ok(Layout { dense, sparse: Some((indices, values)) })
}

fn span(
    root: &Root,
    view: Index<buffer::View>,
    offset: USize64,
    count: USize64,
    element: usize,
) -> Result<Span, &'static str> {
    let view = root.get(view).ok_or("uses a buffer view that does not exist")?;
    let stride = view.byte_stride.map_or(element, |stride| stride.0);
    if stride < element {
        return Err("has elements that overlap");
    }
    let length = (count.0 - 1).checked_mul(stride as u64).and_then(|most| most.checked_add(element as u64));
    let end = length.and_then(|length| length.checked_add(offset.0));
    if end.is_none_or(|end| end > view.byte_length.0) {
        return Err("reaches past the end of its buffer view");
    }
    // Cannot overflow: the view lies in its buffer, and the elements lie in the view.
    let start = (view.byte_offset.unwrap_or_default().0 + offset.0) as usize;
    let bytes = start..start + length.unwrap_or_default() as usize;
    Ok(Span { buffer: view.buffer.value(), bytes, stride, element })
}

fn component_type(accessor: &Accessor) -> ComponentType {
    match accessor.component_type {
        Checked::Valid(generic) => generic.0,
        Checked::Invalid => ComponentType::F32,
    }
}

/// Returns the number of components of an element.
pub fn components(accessor: &Accessor) -> usize {
    match accessor.type_ {
        Checked::Valid(kind) => kind.multiplicity(),
        Checked::Invalid => Type::Mat4.multiplicity(),
    }
}

/// Conversion of integers to floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntegerConversion {
    /// Conversion that the accessor declares: normalized or unchanged.
    AsDeclared,
    /// Always normalized to 0..1 or -1..1, as for colors.
    Normalized,
}

impl ImportSource<'_> {
    /// Reads an accessor of `N` components as finite floats.
    pub fn floats<const N: usize>(
        &self,
        accessor: &Accessor,
        integers: IntegerConversion,
    ) -> Result<Vec<[f32; N]>, AssetFault> {
        if components(accessor) != N {
            return Err(invalid_gltf(format!("an attribute has {} components instead of {N}", components(accessor))));
        }
        let kind = component_type(accessor);
        let normalized = accessor.normalized || integers == IntegerConversion::Normalized;
        let size = kind.size();
        let decode = |bytes: &[u8]| std::array::from_fn(|i| float(&bytes[i * size..], kind, normalized));
        let values: Vec<[f32; N]> = self.elements(accessor, [0.0; N], decode)?;
        if values.as_flattened().iter().all(|x| x.is_finite()) {
            return Ok(values);
        }
        Err(invalid_gltf("an attribute has values that are not finite numbers"))
    }

    /// Reads an accessor of unsigned integers.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, AssetFault> {
        let kind = component_type(accessor);
        let unsigned = matches!(kind, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        if !unsigned || components(accessor) != 1 {
            return Err(invalid_gltf("indices are not unsigned integers"));
        }
        self.elements(accessor, 0, |bytes| unsigned_at(bytes, kind))
    }

    fn elements<T: Clone>(
        &self,
        accessor: &Accessor,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, AssetFault> {
        let layout = layout(self.root, accessor).map_err(invalid_gltf)?;
        // Callers check smaller limits of their own. This one bounds index lists.
        ImportLimit::Triangles.check(accessor.count.0 / 3)?;
        let mut values = match &layout.dense {
            Some(span) => self.slices(span).map(&decode).collect(),
            None => vec![zero; accessor.count.0 as usize],
        };
        if let (Some((indices, replacements)), Some(sparse)) = (&layout.sparse, &accessor.sparse)
            && let Checked::Valid(kind) = sparse.indices.component_type
        {
            let replaced = self.slices(indices).map(|bytes| unsigned_at(bytes, kind.0) as usize);
            if !replaced.clone().is_sorted_by(|a, b| a < b) {
                return Err(invalid_gltf("the indices of a sparse accessor do not strictly increase"));
            }
            for (index, bytes) in replaced.zip(self.slices(replacements)) {
                let value = values.get_mut(index);
                *value.ok_or_else(|| invalid_gltf("a sparse accessor replaces an element it does not have"))? =
                    decode(bytes);
            }
        }
        Ok(values)
    }

    /// Iterates over the bytes of each element. [`check`] has verified that they exist. If they do not, the result is
    /// empty.
    fn slices<'s>(&'s self, span: &'s Span) -> impl Iterator<Item = &'s [u8]> + Clone {
        let bytes = self.buffers.get(span.buffer).and_then(|buffer| buffer.get(span.bytes.clone()));
        bytes.unwrap_or_default().chunks(span.stride).map(|chunk| &chunk[..span.element])
    }
}

fn unsigned_at(bytes: &[u8], kind: ComponentType) -> u32 {
    match kind {
        ComponentType::U8 | ComponentType::I8 => u32::from(bytes[0]),
        ComponentType::U16 | ComponentType::I16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::U32 | ComponentType::F32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}

/// Converts one component. Normalized integers follow glTF 2.0, section 3.11.
fn float(bytes: &[u8], kind: ComponentType, normalized: bool) -> f32 {
    let bits = unsigned_at(bytes, kind);
    let (value, scale) = match kind {
        ComponentType::F32 => return f32::from_bits(bits),
        ComponentType::I8 => (f32::from((bits as u8).cast_signed()), f32::from(i8::MAX)),
        ComponentType::U8 => (bits as f32, f32::from(u8::MAX)),
        ComponentType::I16 => (f32::from((bits as u16).cast_signed()), f32::from(i16::MAX)),
        ComponentType::U16 => (bits as f32, f32::from(u16::MAX)),
        ComponentType::U32 => (bits as f32, u32::MAX as f32),
    };
    if normalized { (value / scale).max(-1.0) } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalised_integers_reach_exactly_their_ends() {
        let cases: [(&[u8], ComponentType, f32); 6] = [
            (&[127], ComponentType::I8, 1.0),
            (&[0x80], ComponentType::I8, -1.0),
            (&[255], ComponentType::U8, 1.0),
            (&[0x01, 0x80], ComponentType::I16, -1.0),
            (&[0x00, 0x80], ComponentType::I16, -1.0),
            (&[255, 255], ComponentType::U16, 1.0),
        ];
        for (bytes, kind, expected) in cases {
            assert_eq!(float(bytes, kind, true).to_bits(), expected.to_bits(), "{kind:?} {bytes:?}");
        }
        assert_eq!(float(&[0x80], ComponentType::I8, false).to_bits(), (-128.0_f32).to_bits());
    }
}
