//! Numbers of a glTF file's accessors, in every form that the specification and
//! `KHR_mesh_quantization` allow: any component type, sparse ones, and ones without data, which are
//! zeros.

use super::{MAX_TRIANGLES, SceneError, Source};
use gltf::Accessor;
use gltf::accessor::DataType;
use gltf::accessor::sparse::IndexType;

/// Most elements of an accessor: what no scene within the limit of triangles exceeds.
const MAX_ELEMENTS: usize = 3 * MAX_TRIANGLES;

/// All elements of an accessor of `N` components. Whole numbers are shares of their range where the
/// accessor says so (`normalized`) or `as_share` does.
pub(super) fn read<const N: usize>(
    source: &Source,
    accessor: &Accessor,
    what: &str,
    as_share: bool,
) -> Result<Vec<[f32; N]>, SceneError> {
    let (kind, share) = (accessor.data_type(), as_share || accessor.normalized());
    elements(source, accessor, what, |bytes| {
        component(bytes, kind, share)
    })
}

/// All indices.
pub(super) fn read_indices(source: &Source, accessor: &Accessor) -> Result<Vec<u32>, SceneError> {
    let width = match accessor.data_type() {
        kind @ (DataType::U8 | DataType::U16 | DataType::U32) => kind.size(),
        _ => {
            return Err(source.malformed(format!(
                "accessor {} (indices) has a type that is not allowed there",
                accessor.index()
            )));
        }
    };
    let whole = |bytes: &[u8]| little_endian(&bytes[..width]);
    let found = elements::<u32, 1>(source, accessor, "indices", whole)?;
    Ok(found.into_iter().map(|[index]| index).collect())
}

/// `count` pieces of `width` bytes from `offset` on.
fn part(bytes: &[u8], offset: usize, count: usize, width: usize) -> Option<&[u8]> {
    let end = offset.checked_add(count.checked_mul(width)?)?;
    bytes.get(offset..end)
}

/// At most four bytes as a whole number.
fn little_endian(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |sum, &byte| sum << 8 | u32::from(byte))
}

/// All elements of an accessor; `decode` reads a component.
fn elements<T: Copy + Default, const N: usize>(
    source: &Source,
    accessor: &Accessor,
    what: &str,
    decode: impl Fn(&[u8]) -> T,
) -> Result<Vec<[T; N]>, SceneError> {
    let fault =
        |reason: &str| source.malformed(format!("accessor {} ({what}) {reason}", accessor.index()));
    if accessor.dimensions().multiplicity() != N {
        return Err(fault("has a type that is not allowed there"));
    }
    let count = accessor.count();
    if count == 0 {
        return Err(fault("has no elements"));
    }
    if count > MAX_ELEMENTS {
        return Err(fault(&format!("has more than {MAX_ELEMENTS} elements")));
    }
    let kind = accessor.data_type();
    let size = kind.size() * N;
    let beyond = || fault("reaches beyond its buffer view");
    let element =
        |bytes: &[u8]| std::array::from_fn::<T, N, _>(|k| decode(&bytes[k * kind.size()..]));
    let mut values = vec![[T::default(); N]; count];
    let view = accessor
        .view()
        .filter(|_| !source.blank.contains(&accessor.index()));
    if let Some(view) = view {
        let bytes = source.view(&view)?;
        let stride = view.stride().unwrap_or(size);
        let end = (count - 1)
            .checked_mul(stride)
            .and_then(|end| end.checked_add(accessor.offset())?.checked_add(size));
        if stride < size || end.is_none_or(|end| end > bytes.len()) {
            return Err(beyond());
        }
        for (index, value) in values.iter_mut().enumerate() {
            *value = element(&bytes[accessor.offset() + index * stride..]);
        }
    }
    if let Some(sparse) = accessor.sparse() {
        let width = match sparse.indices().index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let count = sparse.count();
        let (at, new) = (sparse.indices(), sparse.values());
        let places =
            part(source.view(&at.view())?, at.offset(), count, width).ok_or_else(beyond)?;
        let bytes =
            part(source.view(&new.view())?, new.offset(), count, size).ok_or_else(beyond)?;
        for (place, bytes) in places.chunks_exact(width).zip(bytes.chunks_exact(size)) {
            let place = little_endian(place) as usize;
            *values
                .get_mut(place)
                .ok_or_else(|| fault("replaces an element that it does not have"))? =
                element(bytes);
        }
    }
    Ok(values)
}

/// One component, little-endian (glTF 2.0, 3.6.2.2 and 3.11).
fn component(bytes: &[u8], kind: DataType, share: bool) -> f32 {
    let two = [bytes[0], bytes.get(1).copied().unwrap_or(0)];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    let (value, full) = match kind {
        DataType::F32 => return f32::from_le_bytes(four()),
        DataType::U32 => return u32::from_le_bytes(four()) as f32,
        DataType::I8 => (f32::from(bytes[0] as i8), 127.0),
        DataType::U8 => (f32::from(bytes[0]), 255.0),
        DataType::I16 => (f32::from(i16::from_le_bytes(two)), 32_767.0),
        DataType::U16 => (f32::from(u16::from_le_bytes(two)), 65_535.0),
    };
    if share {
        (value / full).max(-1.0)
    } else {
        value
    }
}
