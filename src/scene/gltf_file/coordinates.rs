//! Where the textures of a glTF material lie: sets of coordinates, and `KHR_texture_transform`.

use super::super::model::OnSecondUvs;
use gltf::texture::Info;

/// A set of texture coordinates and how they are moved: scale, then rotation (counter-clockwise in the
/// picture), then offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvMap {
    pub(super) set: u32,
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
}

impl UvMap {
    fn plain(set: u32) -> Self {
        Self {
            set,
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
        }
    }

    fn of(info: &Info) -> Self {
        match info.texture_transform() {
            None => Self::plain(info.tex_coord()),
            Some(transform) => Self {
                set: transform.tex_coord().unwrap_or(info.tex_coord()),
                offset: transform.offset(),
                rotation: transform.rotation(),
                scale: transform.scale(),
            },
        }
    }

    pub(super) fn apply(&self, uvs: &mut [[f32; 2]]) {
        let (sin, cos) = self.rotation.sin_cos();
        for uv in uvs {
            let [u, v] = [uv[0] * self.scale[0], uv[1] * self.scale[1]];
            *uv = [
                cos * u + sin * v + self.offset[0],
                cos * v - sin * u + self.offset[1],
            ];
        }
    }
}

/// How the textures of a material lie: by the base colour's coordinates, or by one more set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) first: UvMap,
    pub(super) second: Option<UvMap>,
    pub(super) on_second: OnSecondUvs,
    /// A third set would be needed, and what needs it lies by the first.
    pub(super) too_many: bool,
}

impl Layout {
    pub(super) fn of(material: &gltf::Material) -> Self {
        let surface = material.pbr_metallic_roughness();
        let base = surface.base_color_texture().map(|info| UvMap::of(&info));
        let others = [
            material.emissive_texture().map(|info| UvMap::of(&info)),
            surface
                .metallic_roughness_texture()
                .map(|info| UvMap::of(&info)),
            // The library does not tell how a normal map is moved.
            material
                .normal_texture()
                .map(|normal| UvMap::plain(normal.tex_coord())),
        ];
        // A normal map by the base colour's set is moved with it, as exporters write them.
        let with_base = |index: usize, map: &UvMap| {
            base.is_some_and(|base| *map == base || (index == 2 && map.set == base.set))
        };
        let first = base
            .or_else(|| others.iter().flatten().next().copied())
            .unwrap_or(UvMap::plain(0));
        let lies_first = |index: usize, map: &UvMap| *map == first || with_base(index, map);
        let rest = others.iter().enumerate();
        let second = rest
            .filter_map(|(index, map)| map.filter(|map| !lies_first(index, map)))
            .next();
        let on = |index: usize| {
            others[index].is_some_and(|map| !lies_first(index, &map) && Some(map) == second)
        };
        let too_many = (0..3).any(|index| {
            others[index].is_some_and(|map| !lies_first(index, &map) && Some(map) != second)
        });
        Self {
            first,
            second,
            on_second: OnSecondUvs {
                emissive: on(0),
                metallic_roughness: on(1),
                normal: on(2),
            },
            too_many,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_scaled_then_turned_then_moved() {
        let map = UvMap {
            set: 0,
            offset: [0.25, 0.5],
            rotation: std::f32::consts::FRAC_PI_2,
            scale: [2.0, 3.0],
        };
        // The matrices of the extension, offset × rotation × scale, where rotation is
        // (cos, sin; −sin, cos): u goes to −v and v to u.
        let mut uvs = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
        map.apply(&mut uvs);
        for (found, wanted) in uvs.iter().zip([[0.25, -1.5], [3.25, 0.5], [0.25, 0.5]]) {
            let off = (0..2)
                .map(|i| (found[i] - wanted[i]).abs())
                .fold(0.0, f32::max);
            assert!(off < 1e-6, "{found:?} in place of {wanted:?}");
        }
    }
}
